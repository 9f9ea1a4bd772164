"""Faults of robots and of their radio: their description, their times in a run, and which act at a time."""

from collections.abc import Sequence
from dataclasses import MISSING, dataclass
from typing import Literal, NamedTuple

import numpy as np

from fuzzy.compiled.columns import Bools1, Bools2, Floats2, Ints1
from fuzzy.compiled.jit import kernel
from fuzzy.quantity import check_quantities, described, quantity, whole
from robotics.world.radio.description import RadioError, expect_one_of
from robotics.world.random_streams import FAULT_STREAM

# The kinds of faults with the codes that a run records, the gravest first
FAULTS = {"failure": 1, "stall": 4, "delay": 2, "silence": 3}


@dataclass(frozen=True, kw_only=True)
class Fault:
    """A fault of one robot for a while.

    "failure": its wheel references are 0, and its radio is cut off both ways. "delay": it holds its last command, and
    its radio is cut off. "silence": it drives on, but its radio is cut off; with ``other`` only the link to that robot
    is. "stall": its wheel references are 0, as if it were held up, and its radio works. With ``start_until`` each seed
    draws the start evenly between ``start`` and that.

    Raises:
        RadioError: Fields that do not suit each other.
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
            what = f"start_until must be >= start, {self.start:g} s; got {self.start_until:g}"
            raise RadioError(what).about("start_until")


class Trouble(NamedTuple):
    """The faults of every run as columns, and who is at fault now; a lane is one robot of one run."""

    kind: Ints1  # (faults,): of FAULTS
    robot: Ints1  # (faults,), from 0
    other: Ints1  # (faults,): the other end of a link; -1: it is the robot's own fault
    starts: Floats2  # (runs, faults) s
    ends: Floats2  # (runs, faults) s
    failed: Bools1  # (lanes,): wheel references are 0
    held: Bools1  # (lanes,): the last command is held
    cut: Bools2  # (lanes, robots): no message passes from that robot
    code: Ints1  # (lanes,): of FAULTS, the gravest of several; 0: none, or only of a link


def untroubled(runs: int, robots: int) -> Trouble:
    """The columns of runs without faults."""
    none, lanes = np.zeros(0, dtype=np.int64), runs * robots
    times = np.zeros((runs, 0))
    ill = np.zeros(lanes, dtype=bool)
    cut = np.zeros((lanes, robots), dtype=bool)
    return Trouble(none, none, none, times, times, ill, ill.copy(), cut, np.zeros(lanes, dtype=np.int64))


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

    def trouble(self, runs: np.ndarray) -> Trouble:
        """The columns of ``runs``, their places (n,)."""
        return untroubled(len(runs), self.robots)._replace(
            kind=np.array([FAULTS[f.kind] for f in self.faults], dtype=np.int64),
            robot=np.array([f.robot - 1 for f in self.faults], dtype=np.int64),
            other=np.array([-1 if f.other is None else f.other - 1 for f in self.faults], dtype=np.int64),
            starts=np.ascontiguousarray(self.starts[runs], dtype=float),
            ends=np.ascontiguousarray(self.ends[runs], dtype=float),
        )


_FAILURE, _STALL, _DELAY = FAULTS["failure"], FAULTS["stall"], FAULTS["delay"]
_GRAVEST_FIRST = tuple(FAULTS.values())


@kernel(nogil=True, _nrt=False)
def notice(trouble, time, robots):  # type: ignore[no-untyped-def]
    """Find out who of the ``robots`` of every run is at fault at ``time`` [s], and which links are cut."""
    if len(trouble.kind) == 0:
        return
    trouble.code[:] = 0
    trouble.failed[:] = False
    trouble.held[:] = False
    trouble.cut[:] = False
    now = time + 1e-9
    for run in range(len(trouble.starts)):
        for f in range(len(trouble.kind)):
            if not trouble.starts[run, f] <= now < trouble.ends[run, f]:
                continue
            kind, i = trouble.kind[f], run * robots + trouble.robot[f]
            if trouble.other[f] >= 0:
                trouble.cut[i, trouble.other[f]] = True
                trouble.cut[run * robots + trouble.other[f], trouble.robot[f]] = True
                continue
            trouble.failed[i] |= kind in (_FAILURE, _STALL)
            trouble.held[i] |= kind == _DELAY
            trouble.code[i] = _graver(kind, trouble.code[i])
            if kind != _STALL:
                for j in range(robots):
                    trouble.cut[i, j] = True
                    trouble.cut[run * robots + j, trouble.robot[f]] = True


@kernel(nogil=True, _nrt=False)
def _graver(one, other):  # type: ignore[no-untyped-def]
    """The graver of two kinds of faults; 0 is none."""
    for kind in _GRAVEST_FIRST:
        if kind in (one, other):
            return kind
    return 0
