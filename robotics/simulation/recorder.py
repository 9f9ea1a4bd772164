"""The recorder of a simulation: it keeps samples as the simulation goes on, and makes runs of them."""

import numpy as np

from robotics.environment.world import Geometry
from robotics.laws.setting import Setting
from robotics.paths.references import sampled
from robotics.simulation.channels import CHANNELS, RECORDS, Record, units_of
from robotics.simulation.run import About, Recorded, Run
from robotics.simulation.state import State
from robotics.vehicle import plant as p

_DEMANDS = [list(CHANNELS).index(name) for name in ("v_demand", "w_demand")]


class Recorder:
    """The samples kept so far of a simulation, from which runs are made at any time."""

    def __init__(self, setting: Setting, runs: int, *, links: bool = False) -> None:
        """Prepare for all samples of ``runs`` runs of ``setting``; with ``links`` the ages of messages are kept too."""
        self.length = setting.ticks + 1
        self.limits = p.velocity_limits(setting.robots)
        self.count = self.limited = 0  # samples kept; samples whose demands are within the limits
        left_out = {"team": setting.kind != "team", "links": not links}
        self.arrays: dict[str, np.ndarray] = {}
        self.records = {name: record for name, record in RECORDS.items() if not left_out.get(name)}
        self.stopped = np.full((runs, len(setting.robots)), -1)

    def keep(self, state: State) -> None:
        """Keep one period; periods must come in their order."""
        gone = self.stopped >= 0
        some = bool(gone.any())
        for name, record in self.records.items():
            if record.scalars:
                row = self._row(name, record, state.k, (len(units_of(record.scalars)), *gone.shape))
                first = 0
                for part in record.scalars:
                    row[first : first + len(part.units)] = part.of(state)
                    first += len(part.units)
            else:
                assert record.of is not None
                found = record.of(state)
                if found is None:
                    continue
                row = self._row(name, record, state.k, found.shape)
                row[...] = found
            if some and record.stopped is not None:
                row[..., gone] = record.stopped
        self.stopped = np.where(state.lost, state.k, state.stopped)
        self.count = state.k + 1

    def _row(self, name: str, record: Record, k: int, shape: tuple[int, ...]) -> np.ndarray:
        """The place for one period of a record; periods before the first that has the record stay 0."""
        if name not in self.arrays:
            self.arrays[name] = np.zeros((self.length, *shape), dtype=record.dtype)
        return self.arrays[name][k]

    def run(self, setting: Setting, level: str, seeds: tuple[int, ...], name: str, which: slice = slice(None)) -> Run:
        """Make the run of what was kept; it ends with the setting, or with the last sample kept.

        Args:
            setting: The setting that was simulated.
            level: The law's, "velocity" or "torque".
            seeds: Those of the run.
            name: The name of the law.
            which: The runs of the pass that belong to these seeds.
        """
        end = min(setting.ticks + 1, self.count)
        times = setting.times[:end]
        new = self.arrays["samples"][self.limited : self.count]
        v, w = _DEMANDS
        new[:, v], new[:, w] = p.saturate(self.limits, new[:, v], new[:, w])
        self.limited = self.count
        recorded = {
            array: Recorded(values[:end], RECORDS[array].axes).only("run", which)
            for array, values in self.arrays.items()
            if array != "ranges" or setting.world is not None
        }
        return Run(
            About(setting.name, setting.kind, name, level, setting.robots, setting.sensors),
            seeds,
            times,
            recorded,
            np.stack(sampled(setting.references, times)),
            tuple(path.table[:2] for path in setting.references.joined.paths),
            np.where(self.stopped[which] < end, self.stopped[which], -1),
            _obstacles(setting, times),
        )


def _obstacles(setting: Setting, times: np.ndarray) -> Geometry | None:
    """The places of the obstacles at ``times`` [s]; only one if none moves; None if there are no obstacles."""
    world = setting.world
    if world is None or world.motion is None:
        return None if world is None else world.rest
    seen = [world.at(time) for time in times]
    circles, segments = (np.concatenate([getattr(g, name) for g in seen]) for name in ("circles", "segments"))
    bodies, counts = (np.repeat(getattr(world.rest, name), len(seen), axis=0) for name in ("bodies", "counts"))
    return Geometry(circles, bodies, segments, counts)
