"""What is kept of a simulation as it goes on, and the runs made of it."""

from collections.abc import Callable
from typing import Any

import numpy as np

from robotics.environment.world import Geometry
from robotics.laws.law import ControllerError, Law
from robotics.laws.setting import Setting
from robotics.paths.references import sampled
from robotics.simulation.channels import CHANNELS, RECORDS, Record, units_of
from robotics.simulation.run import About, Recorded, Run
from robotics.simulation.state import State
from robotics.vehicle import plant as p

_DEMANDS = [list(CHANNELS).index(name) for name in ("v_demand", "w_demand")]


class Recorder:
    """The samples of a simulation as it goes on, and the runs made of them."""

    def __init__(self, setting: Setting, law: Law[Any], runs: int, *, links: bool = False) -> None:
        """Room for all samples of ``runs`` runs of ``setting``; ``links`` keeps the ages of messages too."""
        self.level, self.rule_bases = law.level, dict(law.fuzzy_systems)
        self.length = setting.ticks + 1
        self.limits = p.velocity_limits(setting.robots)
        self.limited = 0  # samples whose demands have been brought within the limits
        left_out = {"team": setting.kind != "team", "links": not links, "inputs": not self.rule_bases}
        self.records = {name: record for name, record in RECORDS.items() if not left_out.get(name)}
        self.parts = {name: _parts(record) for name, record in self.records.items()}
        self.last: State | None = None
        self.arrays: dict[str, np.ndarray] = {
            name: np.zeros((self.length, len(units_of(record.scalars)), runs, len(setting.robots)))
            for name, record in self.records.items()
            if record.scalars
        }

    def keep(self, state: State) -> None:
        """Keep one period; they come in their order."""
        for name, record in self.records.items():
            if record.scalars:
                row = self.arrays[name][state.k]
                for where, of in self.parts[name]:
                    row[where] = of(state)
            else:
                assert record.of is not None
                found = record.of(state)
                if found is None:
                    continue
                row = self._row(name, record, state.k, found.shape)
                row[...] = found
            if not state.all_drive and record.stopped is not None:
                row[..., state.stopped >= 0] = record.stopped
        self.last = state

    def _row(self, name: str, record: Record, k: int, shape: tuple[int, ...]) -> np.ndarray:
        """Where one period of a record goes; all before the first that has it is 0."""
        if name not in self.arrays:
            self.arrays[name] = np.zeros((self.length, *shape), dtype=record.dtype)
        row: np.ndarray = self.arrays[name][k]
        return row

    def run(self, setting: Setting, seeds: tuple[int, ...], name: str, which: slice = slice(None)) -> Run:
        """The run of ``setting`` with the law called ``name``; ``which`` of the runs of the pass are its seeds.

        It ends with the setting, or before, if no more was kept. Raises ControllerError where the law's inputs are not
        those of its rule bases.
        """
        assert self.last is not None  # something was kept
        self._check_inputs(name)
        stopped = np.where(self.last.lost, self.last.k, self.last.stopped)[which]
        kept = self.last.k + 1
        end = min(setting.ticks + 1, kept)
        times = setting.times[:end]
        new = self.arrays["samples"][self.limited : kept]
        v, w = _DEMANDS
        new[:, v], new[:, w] = p.saturate(self.limits, new[:, v], new[:, w])
        self.limited = kept
        recorded = {
            array: Recorded(values[:end], RECORDS[array].axes).only("run", which)
            for array, values in self.arrays.items()
            if array != "ranges" or setting.world is not None
        }
        return Run(
            About(setting.name, setting.kind, name, self.level, setting.robots, setting.sensors, self.rule_bases),
            seeds,
            times,
            recorded,
            np.stack(sampled(setting.references, times)),
            tuple(path.table[:2] for path in setting.references.joined.paths),
            np.where(stopped < end, stopped, -1),
            _obstacles(setting, times),
        )

    def _check_inputs(self, name: str) -> None:
        """Raise ControllerError unless as many inputs were kept as the law's rule bases have, or none."""
        expected = sum(len(system.inputs) for system in self.rule_bases.values())
        if "inputs" in self.arrays and self.arrays["inputs"].shape[1] != expected:
            raise ControllerError(
                f"{name}: the rule bases {', '.join(self.rule_bases)} have {expected} inputs in all, and the law's "
                f"commands carry {self.arrays['inputs'].shape[1]}"
            )


def _parts(record: Record) -> list[tuple[slice | int, Callable[[State], Any]]]:
    """Where the scalars of a record go in a row, and what gives them."""
    parts: list[tuple[slice | int, Callable[[State], Any]]] = []
    first = 0
    for part in record.scalars:
        last = first + len(part.units)
        parts.append((slice(first, last) if last > first + 1 else first, part.of))
        first = last
    return parts


def _obstacles(setting: Setting, times: np.ndarray) -> Geometry | None:
    """Where the obstacles are at ``times`` [s]; once, if none moves."""
    world = setting.world
    if world is None or world.motion is None:
        return None if world is None else world.rest
    seen = [world.at(time) for time in times]
    circles, segments = (np.concatenate([getattr(g, name) for g in seen]) for name in ("circles", "segments"))
    bodies, counts = (np.repeat(getattr(world.rest, name), len(seen), axis=0) for name in ("bodies", "counts"))
    return Geometry(circles, bodies, segments, counts)
