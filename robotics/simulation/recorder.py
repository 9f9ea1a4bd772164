"""The recorder: the observer that keeps the samples of a simulation, and the runs made of them."""

from collections.abc import Collection, Mapping
from typing import Any, NamedTuple

import numpy as np

from fuzzy.compiled.columns import Floats2, PartOfBools3, PartOfBytes3, PartOfFloats4, PartOfSingles4
from fuzzy.compiled.jit import compiled_only
from fuzzy.system import Sugeno
from robotics.laws.equation import EquationLaw, SeenColumns, WrittenColumns
from robotics.laws.law import Command, ControllerError, Law
from robotics.laws.modes import STOPPED
from robotics.laws.setting import Setting
from robotics.simulation.channels import CHANNELS, ENCODER_CHANNELS, RECORDS, TEAM_CHANNELS
from robotics.simulation.observer import Observer, observer
from robotics.simulation.opening import looks
from robotics.simulation.run import About, Recorded, Run
from robotics.world.environment.world import Geometry
from robotics.world.radio.channel import HeardColumns
from robotics.world.sensing.carried import sensor_names
from robotics.world.vehicle import plant as p
from robotics.world.vehicle.plant import TruthColumns, within

OPTIONAL = ("message_ages", "torques", "encoders", "messages")  # of RECORDS: kept where somebody asks for them


class Recording(NamedTuple):
    """What is recorded, as of :mod:`robotics.simulation.channels`; no samples: it is not."""

    samples: PartOfFloats4  # (samples, channels, runs, robots)
    team: PartOfFloats4  # (samples, channels, runs, robots)
    message_ages: PartOfSingles4  # (samples, runs, robots, senders)
    modes: PartOfBytes3  # (samples, runs, robots)
    guarded: PartOfBools3  # (samples, runs, robots)
    inputs: PartOfSingles4  # (samples, inputs, runs, robots)
    ranges: PartOfSingles4  # (samples, runs, robots, sensors)
    torques: PartOfSingles4  # (samples, wheels, runs, robots)
    encoders: PartOfFloats4  # (samples, channels, runs, robots)
    messages: PartOfFloats4  # (samples, values, runs, robots)
    limits: Floats2  # (4, lanes): of the velocities, as of robotics.world.vehicle.plant.velocity_limits


@observer
def record(moment, kept):  # type: ignore[no-untyped-def]
    """Keep the samples of a period; of stopped robots what stands for them."""
    k, robots, command = moment.k, moment.robots, moment.command
    for i in range(command.shape[1]):
        run, robot, gone = i // robots, i % robots, moment.stopped[i] >= 0
        truth, out = TruthColumns(moment.truth, i), WrittenColumns(command, i)
        if len(kept.samples) > 0:
            _sample(kept.samples[k, :, run, robot], i, gone, kept.limits, truth, moment.seen, out, moment.order)
        if len(kept.team) > 0:
            kept.team[k, 0, run, robot] = np.nan if gone else out.progress
            kept.team[k, 1, run, robot] = np.nan if gone else out.target.x
            kept.team[k, 2, run, robot] = np.nan if gone else out.target.y
            kept.team[k, 3, run, robot] = np.nan if gone else out.target.heading
            kept.team[k, 4, run, robot] = np.nan if gone else float(moment.code[i])
        if len(kept.modes) > 0:
            kept.modes[k, run, robot] = STOPPED if gone else np.int8(out.mode)
        if len(kept.guarded) > 0:
            kept.guarded[k, run, robot] = not gone and out.guarded > 0
        if len(kept.inputs) > 0:
            for n in range(kept.inputs.shape[1]):
                kept.inputs[k, n, run, robot] = np.nan if gone else out.values[moment.values + n]
        if len(kept.message_ages) > 0:
            for j in range(robots):
                heard = HeardColumns(moment.heard, i, j)
                kept.message_ages[k, run, robot, j] = heard.age if heard.hears > 0 else np.inf
        if len(kept.ranges) > 0:
            for n in range(kept.ranges.shape[3]):
                kept.ranges[k, run, robot, n] = moment.readings[i, n]
        if len(kept.torques) > 0:
            kept.torques[k, 0, run, robot] = np.nan if gone else truth.right.torque
            kept.torques[k, 1, run, robot] = np.nan if gone else truth.left.torque
        if len(kept.encoders) > 0:
            robot_v = SeenColumns(moment.seen, i).robot
            kept.encoders[k, 0, run, robot] = np.nan if gone else truth.right.angle
            kept.encoders[k, 1, run, robot] = np.nan if gone else truth.left.angle
            kept.encoders[k, 2, run, robot] = np.nan if gone else robot_v.v
            kept.encoders[k, 3, run, robot] = np.nan if gone else robot_v.w
        if len(kept.messages) > 0:
            for n in range(kept.messages.shape[1]):
                due = k % moment.every == 0 and not gone
                kept.messages[k, n, run, robot] = out.values[n] if due else np.nan
    return False


@compiled_only
def _sample(sample, i, gone, limits, truth, seen, out, order):  # type: ignore[no-untyped-def]
    """The channels of every run, in the order of robotics.simulation.channels.CHANNELS."""
    if gone:
        sample[:] = np.nan
        return
    robot = SeenColumns(seen, i).robot
    v, w = within(limits, i, out.wish_v, out.wish_w)
    sample[0], sample[1], sample[2], sample[3], sample[4] = truth.x, truth.y, truth.heading, truth.v, truth.w
    sample[5], sample[6], sample[7] = robot.x, robot.y, robot.heading
    sample[8], sample[9], sample[10], sample[11] = order[0, i], order[1, i], v, w
    sample[12], sample[13] = truth.effort, truth.variation


class Recorder:
    """The samples of some runs of a simulation as it goes on, and the runs made of them."""

    def __init__(
        self,
        setting: Setting,
        law: Law[Any],
        runs: int,
        *,
        besides: Collection[str] = (),
        nothing: bool = False,
    ) -> None:
        """Room for all samples of ``runs`` runs of ``setting``.

        ``besides`` names what is kept of OPTIONAL: the ages of messages, the wheels' torques, what encoders tell, what
        robots broadcast. Where ``nothing`` is kept there is no room.
        """
        self.setting, self.law, self.runs = setting, law, runs
        self.rule_bases: Mapping[str, Sugeno] = dict(law.fuzzy_systems)
        self.arrays: dict[str, np.ndarray] = {}
        self.nothing = nothing
        if nothing:
            return
        self._room("samples", len(CHANNELS))
        if setting.kind == "team":
            self._room("team", len(TEAM_CHANNELS))
        lengths = {"torques": 2, "encoders": len(ENCODER_CHANNELS), "messages": len(law.message)}
        for name in OPTIONAL:
            if name in besides and (name != "messages" or law.message):
                self._room(name, lengths.get(name, 0))
        if self.rule_bases:
            self._room("inputs", law.rule_inputs)
        if isinstance(law, EquationLaw) and law.has_equation:
            for name, has in (("modes", law.has_modes), ("guarded", law.guards)):
                if has:
                    self._room(name)
        if looks(setting, law):
            self._room("ranges", len(sensor_names(setting.sensors)))

    def _room(self, name: str, channels: int = 0) -> None:
        """Room for one of RECORDS; ``channels`` is the length of its axis that is not of lanes."""
        record, robots = RECORDS[name], len(self.setting.robots)
        lengths = {"sample": self.setting.ticks + 1, "run": self.runs, "robot": robots, "sender": robots}
        shape = tuple(lengths.get(axis, channels) for axis in record.axes)
        self.arrays[name] = np.zeros(shape, dtype=record.dtype)

    def makes_room(self, command: Command, name: str) -> bool:
        """Whether room was made for something that a law without an equation is seen to command for the first time.

        Raises ControllerError where its inputs are not those of its rule bases.
        """
        expected = self.law.rule_inputs
        if command.inputs is not None and len(command.inputs) != expected:
            own = ", ".join(self.rule_bases)
            has = f"the rule bases {own} have {expected} inputs in all" if own else "fuzzy_systems names no rule bases"
            raise ControllerError(f"{name}: {has}, and the law's commands carry {len(command.inputs)}")
        seen = {"modes": command.mode, "guarded": command.guarded}
        new = [name for name, value in seen.items() if value is not None and name not in self.arrays]
        if self.nothing or not new:
            return False
        for array in new:
            self._room(array)
        return True

    def observer(self, first: int, last: int) -> Observer:
        """What records the runs from ``first`` to before ``last``."""
        arrays = {}
        for name in Recording._fields[:-1]:
            room = RECORDS[name]
            if name in self.arrays:
                which = (slice(None),) * room.axes.index("run") + (slice(first, last),)
                arrays[name] = self.arrays[name][which]
            else:
                arrays[name] = np.zeros((0,) * len(room.axes), dtype=room.dtype)
        limits = np.ascontiguousarray(np.tile(p.velocity_limits(self.setting.robots), last - first))
        return Observer(record, Recording(**arrays, limits=limits))

    def run(
        self,
        setting: Setting,
        seeds: tuple[int, ...],
        name: str,
        stopped: np.ndarray,
        end: int,
        which: slice = slice(None),
        law: Law[Any] | None = None,
        references: np.ndarray | None = None,
    ) -> Run:
        """The run of ``setting`` with the law called ``name``.

        Args:
            setting: What was driven; its robots and references are those of the run.
            seeds: The seeds of ``which``.
            name: Of the controller.
            stopped: The period in which each robot was stopped, or -1 (runs, robots).
            end: The number of samples that were kept; the run ends with the setting, or before.
            which: Those of the runs that are its seeds.
            law: The law that drove these, if it is another than that of the first.
            references: The references of all samples (6, samples, robots), where they are known already.
        """
        end = min(setting.ticks + 1, end)
        times = setting.times[:end]
        recorded = {
            array: Recorded(values[:end], RECORDS[array].axes).only("run", which)
            for array, values in self.arrays.items()
        }
        gone, bases = stopped[which], self.rule_bases if law is None else dict(law.fuzzy_systems)
        names = self.law.message if "messages" in self.arrays else ()
        return Run(
            About(
                scenario=setting.name,
                kind=setting.kind,
                controller=name,
                level=self.law.level,
                robots=setting.robots,
                sensors=setting.sensors,
                rule_bases=bases,
                message=names,
                goals=setting.goals,
                patches=setting.patches,
            ),
            seeds,
            times,
            recorded,
            np.stack(setting.references.sampled(times)) if references is None else references[:, :end],
            tuple(path.table[:2] for path in setting.references.joined.paths),
            np.where(gone < end, gone, -1),
            _obstacles(setting, times),
        )


def _obstacles(setting: Setting, times: np.ndarray) -> Geometry | None:
    """Where the obstacles are at ``times`` [s]; once, if none moves."""
    world = setting.world
    if world is None or world.motion is None:
        return None if world is None else world.rest
    seen = [world.at(time) for time in times]
    circles, segments = (np.concatenate([getattr(g, name) for g in seen]) for name in ("circles", "segments"))
    bodies, counts = (np.repeat(getattr(world.rest, name), len(seen), axis=0) for name in ("bodies", "counts"))
    return Geometry(circles, bodies, segments, counts)
