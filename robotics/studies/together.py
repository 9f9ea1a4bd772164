"""Several scenarios of one world, driven side by side in one array pass."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from robotics.laws.catalogue import make_controller
from robotics.simulation.loop import Simulation, when_stopped
from robotics.simulation.recorder import Recorder
from robotics.simulation.run import Run
from robotics.simulation.scenario.description import Scenario
from robotics.world.environment.world import World, compile_worlds
from robotics.world.paths.trajectory import side_by_side
from robotics.world.vehicle.plant import TruthColumns

_LONGEST = 70.0  # s: a run is driven no longer
_GOAL = 0.1  # m: how near its goal a robot has reached it
_REST = 5.0  # s that are driven after all have reached their goals


def run_together(
    settings: Sequence[Scenario], controller: str, seeds: Sequence[int], longest: float = _LONGEST
) -> list[Run]:
    """Drive several scenarios in one pass; each run is, to the last bit, that of its scenario alone.

    Args:
        settings: Scenarios that differ in paths, starts, durations and obstacles only.
        controller: The specification of the controller that drives all of them.
        seeds: The seeds with which each of them is driven.
        longest: The time [s] after which the runs end, unless all robots of all runs have reached their goals before.

    Raises ControllerError for a controller that does not exist or refuses a scenario, ValueError for scenarios that
    differ in more.
    """
    first = settings[0]
    for other in settings:
        same = all(getattr(other, n) == getattr(first, n) for n in ("period", "latency", "plant", "sensing", "radio"))
        even = all(m.timing.start == m.timing.ramp == 0 and m.robot == first.robots[0].robot for m in other.robots)
        if not same or not even or other.faults or len(other.robots) != len(first.robots):
            raise ValueError(f"{other.name} cannot be driven together with {first.name}")
    duration = min(longest, max(s.duration for s in settings))
    shared = replace(first, duration=duration, obstacles=())
    seeds, each = tuple(seeds), len(seeds)
    repeated = [s for s in settings for _ in range(each)]
    worlds = [World(obstacles=s.obstacles, known=False) for s in repeated]
    references = side_by_side([s.trajectory for s in repeated])
    ensemble = replace(
        shared.setting,
        starts=np.stack([s.starts for s in repeated]),
        references=references,
        world=compile_worlds(worlds) if any(s.obstacles for s in settings) else None,
    )
    law = make_controller(controller)
    recorder = Recorder(ensemble, law, len(repeated))
    goals = references.joined.at(references.joined.lengths)
    simulation = Simulation(ensemble, law, seeds * len(settings), recorder=recorder, name=controller)
    reached, k = np.inf, 0
    for k, _ in simulation.periods():
        truth = TruthColumns(simulation.rows(simulation.lanes.body.truth))
        if np.isinf(reached) and (np.hypot(truth.x - goals.x, truth.y - goals.y) < _GOAL).all():
            reached = k * ensemble.period
        if k * ensemble.period > reached + _REST:
            break
    gone = when_stopped(simulation.lanes, k)
    parts = [slice(r * each, (r + 1) * each) for r in range(len(settings))]
    return [
        recorder.run(s.setting, seeds, controller, gone, k + 1, part) for s, part in zip(settings, parts, strict=True)
    ]
