"""Several scenarios of one world side by side in one array pass."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from robotics.environment.world import World, compile_worlds
from robotics.laws.catalogue import make_controller
from robotics.measures.clearance import _OFF
from robotics.paths.joined import Paths
from robotics.paths.trajectory import Reference, Trajectory
from robotics.scenario.description import Scenario
from robotics.scenario.ensemble import Ensemble
from robotics.simulation.loop import drive
from robotics.simulation.recorder import Recorder
from robotics.simulation.run import Run
from robotics.vehicle import plant as p

_LONGEST = 70.0  # s of a run that are driven
_REST = 5.0  # s that are driven after all have reached their goals


def run_together(settings: Sequence[Scenario], controller: str, seed: int, longest: float = _LONGEST) -> list[Run]:
    """``controller`` on each of ``settings`` with ``seed``, in one pass: the runs of simulate(), up to ``longest`` [s],
    or until all have reached their goals in all of them.

    The scenarios differ in paths, starts, durations and obstacles only; each run is, to the last bit, that of its
    scenario alone. Raises ControllerError, and ValueError for
    scenarios that differ in more.
    """
    first = settings[0]
    for other in settings:
        same = all(getattr(other, n) == getattr(first, n) for n in ("period", "latency", "plant", "sensing", "radio"))
        even = all(m.timing.start == m.timing.ramp == 0 and m.robot == first.robots[0].robot for m in other.robots)
        if not same or not even or other.faults or len(other.robots) != len(first.robots):
            raise ValueError(f"{other.name} cannot be driven together with {first.name}")
    duration = min(longest, max(s.duration for s in settings))
    shared = replace(first, duration=duration, obstacles=())
    worlds = [World(obstacles=s.obstacles, known=False) for s in settings]
    ensemble = Ensemble(
        shared,
        np.stack([s.starts for s in settings]),
        _joined(settings),  # type: ignore[arg-type]
        compile_worlds(worlds) if any(s.obstacles for s in settings) else None,
    )
    law = make_controller(controller)
    recorded = Recorder(ensemble.ticks + 1, len(settings), [m.robot for m in first.robots], team=True)
    goals = ensemble.trajectory.joined.at(ensemble.trajectory.joined.lengths)
    reached = np.inf
    for period in drive(ensemble, law, [seed] * len(settings)):
        recorded.keep(period)
        if np.isinf(reached) and (np.hypot(period.state[p.X] - goals.x, period.state[p.Y] - goals.y) < _OFF).all():
            reached = period.time
        if period.time > reached + _REST:
            break
    return [recorded.run(s, law.level, (seed,), controller, slice(r, r + 1)) for r, s in enumerate(settings)]


@dataclass(frozen=True, eq=False)
class _Timing:
    """The references of several scenarios, a run each, to the last bit those of each alone."""

    flat: Trajectory  # all robots of the first run, then those of the second ...
    joined: Paths  # lengths (runs, robots)

    @property
    def ends(self) -> np.ndarray:
        return self.flat.ends.reshape(self.joined.lengths.shape)

    def at(self, time: float) -> Reference:
        return Reference(*(row.reshape(self.joined.lengths.shape) for row in self.flat.at(time)))

    def each_at(self, times: np.ndarray) -> Reference:
        found = self.flat.each_at(np.reshape(times, (1, -1)))
        return Reference(*(row.reshape(self.joined.lengths.shape) for row in found))


def _joined(settings: Sequence[Scenario]) -> _Timing:
    trajectories = [s.trajectory for s in settings]
    flat = Trajectory(
        tuple(path for t in trajectories for path in t.paths),
        np.concatenate([t.tables for t in trajectories]),
        np.concatenate([t.ends for t in trajectories]),
    )
    return _Timing(flat, replace(flat.joined, lengths=flat.joined.lengths.reshape(len(settings), -1)))
