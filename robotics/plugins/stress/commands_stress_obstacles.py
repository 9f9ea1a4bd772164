"""The command ``robotics stress obstacles``: thousands of random courses among unknown obstacles."""

from functools import partial
from typing import Annotated, Any, Literal

from fuzzy.shell.options import Json, Quiet, option, renamed_options
from robotics.commands.shared import Law, chosen_controller, controller_option, print_forewarnings
from robotics.plugins.stress.printing import Driven, Runners, Wrong, run_stress

Field = Literal["A", "B", "U"]  # the class of a course: what stands on it
Team = Literal["1", "3"]  # the number of robots on a course
Side = Literal["beside", "crossing"]  # how the lanes of several robots lie to each other


@renamed_options(jobs="--workers")
def obstacles(
    *,
    runs: Annotated[int, option("Number of random courses.", min=1, max=1_000_000)] = 1000,
    field: Annotated[Field, option("A: gaps of 0.7 m; B: obstacles may overlap; U: a trap.", "--class")] = "A",
    robots: Annotated[Team, option("Number of robots, each on a lane.")] = "1",
    lanes: Annotated[
        Side, option("beside: lanes side by side; crossing: robots on time would meet, for 3 robots.")
    ] = "beside",
    controller: Annotated[
        str | None, controller_option("Controller: committed (default), literal, or one that `robotics list` names.")
    ] = None,
    law: Law = None,
    seed: Annotated[int, option("The first course's seed.", min=0)] = 0,
    robot: Driven = None,
    disturbance: Wrong,
    moving: Annotated[int, option("Number of discs that cross the lanes, at 0.2 m/s at most.", min=0, max=10)] = 0,
    crew: Runners,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Simulate random courses among obstacles that the robots only sense: who arrives, and who touches what.

    The plant is the full one, sonars and postures are noisy. A course depends on its seed alone, so that `robotics
    repeat obstacles --seed N` with the same options repeats one. The number of workers changes no number. With --out
    the same command goes on after a stop.

    \b
    Example:
      robotics stress obstacles --runs 20 --class U --json
    """
    from robotics.laws.catalogue import make_controller
    from robotics.plugins.stress.obstaclecourse import ObstacleOutcome, obstacle_ensemble, stress_obstacles
    from robotics.plugins.stress.single import ALIASES
    from robotics.simulation.scenario.robots import STANDARD, load_robot
    from robotics.studies.forewarnings import blind

    controller = chosen_controller(controller, law) or "committed"
    name = ALIASES["obstacles"].get(controller, controller)
    driver = make_controller(name)
    count = int(robots)
    first = obstacle_ensemble([seed], field, count, lanes=lanes, robot=None if robot is None else load_robot(robot))
    print_forewarnings([*blind(first, driver, controller), *driver.misgivings(first)])
    course: dict[str, Any] = {"kind": field, "moving": moving, "lanes": lanes, "robot": robot}
    about: dict[str, Any] = {"controller": controller, "class": field, "robots": count, "robot": robot or STANDARD}
    about["lanes"] = lanes
    wrong = {"loss": disturbance.loss, "latency_s": disturbance.latency, "freeze_s": disturbance.freeze}
    run_stress(
        about | {"first_seed": seed, **wrong, "moving": moving},
        partial(stress_obstacles, name, robots=count, disturbance=disturbance, **course),
        ObstacleOutcome,
        count,
        range(seed, seed + runs),
        crew,
        json=json,
        quiet=quiet,
    )
