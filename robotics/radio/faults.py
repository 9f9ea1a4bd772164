"""Faults of robots and of their radio: their description, their times in a run, and which act at a time."""

from collections.abc import Sequence
from dataclasses import MISSING, dataclass
from typing import Literal, NamedTuple

import numpy as np

from robotics.quantity import check_quantities, described, quantity, whole
from robotics.radio.description import RadioError, expect_one_of
from robotics.random_streams import FAULT_STREAM

# The kinds of faults with the codes that a run records, the gravest first
FAULTS = {"failure": 1, "stall": 4, "delay": 2, "silence": 3}


@dataclass(frozen=True, kw_only=True)
class Fault:
    """A fault of one robot for a while.

    "failure": its wheel references are 0, and its radio is cut off both ways. "delay": it holds its last command, and
    its radio is cut off. "silence": it drives on, but its radio is cut off; with ``other`` only the link to that robot
    is. "stall": its wheel references are 0, as if it were held up, and its radio works. With ``start_until`` each seed
    draws the start evenly between ``start`` and that. Raises RadioError for fields that do not suit each other.
    """

    robot: int = whole(MISSING, least=1, doc="The robot that is at fault, counted from 1.", example=1)
    kind: Literal["failure", "delay", "silence", "stall"] = described(
        "What goes wrong: failure (wheels and radio stop), delay (it holds its last command, without a radio), silence "
        "(it drives on, without a radio), stall (it is held up, and its radio works).",
        example="silence",
    )
    start: float = quantity(0.0, "s", least=0, doc="When the fault begins.")
    duration: float = quantity(1.0, "s", above=0, doc="How long it lasts.")
    start_until: float | None = quantity(
        None, "s", least=0, doc="Each seed draws the start evenly between start and this time.", example=10.0
    )
    other: int | None = whole(
        None, least=1, doc="Of a silence: the robot, counted from 1, to which alone the link is cut.", example=2
    )

    def __post_init__(self) -> None:
        check_quantities(self, RadioError)
        expect_one_of(FAULTS, "kind", self.kind)
        if self.other is not None and (self.kind != "silence" or self.other == self.robot):
            raise RadioError('other names the far end of a link, for kind = "silence"').about("other")
        if self.start_until is not None and self.start_until < self.start:
            raise RadioError(f"start_until must be >= start, {self.start:g} s; got {self.start_until:g}").about(
                "start_until"
            )


class Condition(NamedTuple):
    """The robots that are at fault at one time."""

    failed: np.ndarray  # (runs, robots) bool: wheel references are 0
    held: np.ndarray  # (runs, robots) bool: the last command is held
    cut: np.ndarray  # (runs, receivers, senders) bool: no message passes
    code: np.ndarray  # (runs, robots) int: of FAULTS, the gravest of several; 0: none, or only of a link


@dataclass(frozen=True)
class Faults:
    """The faults of every run."""

    faults: tuple[Fault, ...]
    robots: int
    starts: np.ndarray  # (runs, faults) s
    ends: np.ndarray  # (runs, faults) s

    @classmethod
    def drawn(cls, faults: Sequence[Fault], robots: int, seeds: Sequence[int]) -> "Faults":
        """Draw when each of ``faults`` begins in the run of each of ``seeds``, for a team of ``robots`` robots."""
        draws = np.array([np.random.default_rng([seed, FAULT_STREAM]).random(len(faults)) for seed in seeds])
        start = np.array([f.start for f in faults])
        until = np.array([f.start if f.start_until is None else f.start_until for f in faults])
        starts = start + draws.reshape(len(seeds), len(faults)) * (until - start)
        return cls(tuple(faults), robots, starts, starts + [f.duration for f in faults])

    def at(self, time: float) -> Condition | None:
        """The condition at ``time`` [s]; None while no robot of any run is at fault."""
        active = (self.starts <= time + 1e-9) & (time + 1e-9 < self.ends)
        if not active.any():
            return None
        runs, n = len(self.starts), self.robots
        at_fault = {kind: np.zeros((runs, n), dtype=bool) for kind in FAULTS}
        cut = np.zeros((runs, n, n), dtype=bool)
        for f, now in zip(self.faults, active.T, strict=True):
            i = f.robot - 1
            if f.other is not None:
                cut[:, i, f.other - 1] |= now
                cut[:, f.other - 1, i] |= now
                continue
            at_fault[f.kind][:, i] |= now
            if f.kind != "stall":
                cut[:, i, :] |= now[:, None]
                cut[:, :, i] |= now[:, None]
        code = np.zeros((runs, n), dtype=int)
        for kind in reversed(FAULTS):
            code[at_fault[kind]] = FAULTS[kind]
        return Condition(at_fault["failure"] | at_fault["stall"], at_fault["delay"], cut, code)
