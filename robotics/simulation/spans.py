"""Spans of time in a run: the span that is shown of one seed, and the spans of its faults."""

from typing import NamedTuple

import numpy as np

from fuzzy.errors import InputError
from robotics.simulation.run import Run
from robotics.world.radio.faults import FAULTS

FAULT_KINDS = {code: kind for kind, code in FAULTS.items()}  # the meaning of the codes of the channel "fault"


class ReplayError(InputError):
    """A seed that was not run, or a span of time that the run does not have."""


class FaultSpan(NamedTuple):
    """A span of time in which a robot is at fault."""

    robot: int  # from 0
    kind: str  # a value of FAULT_KINDS
    start: float  # s
    end: float  # s


def seed_place(run: Run, seed: int | None) -> int:
    """The place (from 0) of ``seed`` among those of the run; None means the first. Raises ReplayError."""
    if seed is None:
        return 0
    if seed not in run.seeds:
        known = ", ".join(map(str, run.seeds[:12])) + (", ..." if len(run.seeds) > 12 else "")
        raise ReplayError(f"seed {seed} is not among those of the run: {known}")
    return run.seeds.index(seed)


def span(run: Run, start: float | None, end: float | None) -> tuple[float, float]:
    """The span of time [s] to show; None means the run's beginning or its end. Raises ReplayError."""
    first, last = float(run.time[0]), float(run.time[-1])
    start, end = first if start is None else start, last if end is None else end
    if not first <= start < end <= last:
        raise ReplayError(
            f"the run lasts from {first:g} to {last:g} s, and from must be before to; got from {start:g} to {end:g} s"
        )
    return start, end


def fault_spans(run: Run, place: int) -> tuple[FaultSpan, ...]:
    """The spans in which robots were at fault in the run of the seed at ``place``, by robot and time."""
    if run.team is None:
        return ()
    codes = np.nan_to_num(run["fault"][place]).astype(int)
    found = []
    for robot, row in enumerate(codes):
        edges = np.flatnonzero(np.diff(row)) + 1
        for a, b in zip([0, *edges], [*edges, len(row)], strict=True):
            if row[a]:
                found.append(FaultSpan(robot, FAULT_KINDS[int(row[a])], float(run.time[a]), float(_after(run, b))))
    return tuple(found)


def _after(run: Run, sample: np.ndarray) -> np.ndarray:
    """The time of a sample [s]; that of the sample beyond the last is one period later."""
    time = np.append(run.time, 2 * run.time[-1] - run.time[-2])
    return np.asarray(time[sample])
