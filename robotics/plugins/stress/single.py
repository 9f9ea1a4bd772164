"""One run of a stress test by its seed, to be drawn, saved and played: the same run to the last bit."""

from typing import Any

from fuzzy.naming import check_known
from fuzzy.shell.progress import Begin, unwatched
from robotics.laws.law import ControllerError, Law
from robotics.plugins.stress.crossings import crossing_ensemble
from robotics.plugins.stress.disturbance import UNDISTURBED, Disturbance
from robotics.plugins.stress.lanes import Lanes
from robotics.plugins.stress.obstaclecourse import ObstacleOutcome, obstacle_ensemble
from robotics.plugins.stress.outcome import StressOutcome
from robotics.plugins.stress.tally import Tally, judged
from robotics.simulation.loop import record_run
from robotics.simulation.run import Run
from robotics.simulation.scenario.description import ScenarioError
from robotics.simulation.scenario.robots import load_robot

_AFTER = 2.0  # s for which a run goes on after the last arrival
STRESSES = {"crossing": "right-of-way", "obstacles": "obstacles"}  # and the controller of each
ALIASES = {  # what `robotics stress` calls some controllers
    "crossing": {
        "literal": "crash-literal",
        "lag-clock": "crash-lag-clock",
        "yielding": "crash-yielding",
        "none": "cooperation-literal",
    },
    "obstacles": {"committed": "obstacles", "literal": "obstacles-literal"},
}


def single_run(
    stress: str,
    controller: Law[Any],
    seed: int,
    robots: int | None = None,
    kind: Any = None,
    disturbance: Disturbance = UNDISTURBED,
    name: str = "",
    message_ages: bool = False,
    begin: Begin = unwatched,
    *,
    moving: int = 0,
    lanes: Lanes = "beside",
    robot: str | None = None,
    logged: bool = False,
) -> tuple[Run, StressOutcome]:
    """The run that ``robotics stress`` makes of ``seed``, and its outcome.

    Args:
        stress: "crossing" or "obstacles".
        controller: The law that drives the robots.
        seed: The seed of the run.
        robots: Number of robots, by default 3 in a crossing and 1 among obstacles.
        kind: Class of the run, by default "A".
        disturbance: What is wrong in the run.
        name: The controller's name in the run.
        message_ages: Whether the run keeps the age of every message.
        begin: Starts a bar of a progress display, by its text and total.
        moving: Number of discs that cross the lanes, among obstacles.
        lanes: Whether the lanes stay beside each other or cross, among obstacles.
        robot: What the robots are, as :func:`robotics.load_robot` takes it; by default the EtsRo.
        logged: Whether the run keeps its torques, what its encoders tell and what its robots broadcast, too.

    Raises ScenarioError for a class, number of robots, discs or lanes that this stress test does not have,
    ControllerError where the law has no safe plan.
    """
    model = None if robot is None else load_robot(robot)
    kinds = ("A", "B") if stress == "crossing" else ("A", "B", "U")
    kind = kind or "A"
    check_known(kind, kinds, "class", ScenarioError, where=stress)
    if stress == "crossing":
        robots = robots or 3
        if moving:
            raise ScenarioError("crossing: discs that move belong to `obstacles`")
        if lanes != "beside":
            raise ScenarioError("crossing: lanes belong to `obstacles`; here all paths cross")
        if robots < 2:
            raise ScenarioError(f"crossing: robots must be 2 or more, got {robots}")
        ensemble = crossing_ensemble(robots, [seed], kind, disturbance=disturbance, robot=model)
    else:
        robots = robots or 1
        if robots not in (1, 3):
            raise ScenarioError(f"obstacles: robots must be 1 or 3, got {robots}")
        more: dict[str, Any] = {"disturbance": disturbance, "moving": moving, "lanes": lanes, "robot": model}
        ensemble = obstacle_ensemble([seed], kind, robots, **more)
    outcomes = StressOutcome if stress == "crossing" else ObstacleOutcome
    tally = Tally(ensemble, outcomes.longest(ensemble, disturbance.extra), 0, 1, after=_AFTER)
    advance = begin(f"{ensemble.name}: {name}", ensemble.ticks + 1)
    besides = {"torques", "encoders", "messages"} if logged else set()
    besides |= {"message_ages"} if message_ages and robots > 1 else set()
    run = record_run(
        ensemble,
        controller,
        [seed],
        name=name,
        besides=besides,
        faults=disturbance.faults(ensemble, [seed]),
        progress=advance,
        observer=tally.observer,
    )
    tally.guards = run.recorded.get("guarded") is not None
    outcome = judged(outcomes, [tally], [seed])
    if stress == "crossing" and outcome.refused[0]:
        raise ControllerError(f"crossing, seed {seed}: {name} has no safe plan: it would not start")
    return run, outcome
