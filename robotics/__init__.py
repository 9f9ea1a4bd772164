"""Mobile robots on one simulator: plant, sensors, paths, controllers, and their comparison.

>>> import robotics
>>> run = robotics.simulate(robotics.load_scenario("lyapunov-circle"), robotics.make_controller("lyapunov"), seeds=[3])
>>> bool(run["x"].shape == (1, 1, 501))
True

Each name is imported from its module when it is first used, so that the command line starts quickly.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from robotics.catalogue import CATALOGUE, make_controller
    from robotics.comparison import Comparison, compare, summarise
    from robotics.controller import Command, Controller, ControllerError, Observation
    from robotics.formation import FORMATION_METRICS, formation_scenario, measure_formation
    from robotics.graph import adjacency, laplacian
    from robotics.merits import measure_all, metrics_of
    from robotics.metrics import METRICS, cross_track_error, measure, tracking_error
    from robotics.notebook import player
    from robotics.path import Circle, Line, Path, PathError, Quintic, Sine, Waypoints, compile_path
    from robotics.radio import Fault, Heard, Radio, RadioError
    from robotics.recovery import Recovery, recovery_curve
    from robotics.robot import Robot, RobotError
    from robotics.run import Run, RunError, load_run
    from robotics.scenario import (
        Member,
        Scenario,
        ScenarioError,
        Sensing,
        load_scenario,
        parse_scenario,
        scenario_names,
    )
    from robotics.simulation import SimulationError, simulate
    from robotics.team import (
        TEAM_METRICS,
        TeamError,
        arrival_time,
        measure_team,
        nearest_distance,
        progress_gap,
        random_team,
        team_toml,
        true_progress,
    )
    from robotics.trajectory import Timing, Trajectory

_MODULES = {
    "robotics.comparison": (
        "Comparison",
        "compare",
        "summarise",
    ),
    "robotics.controller": (
        "Command",
        "Controller",
        "ControllerError",
        "Observation",
    ),
    "robotics.catalogue": (
        "CATALOGUE",
        "make_controller",
    ),
    "robotics.formation": (
        "FORMATION_METRICS",
        "formation_scenario",
        "measure_formation",
    ),
    "robotics.graph": (
        "adjacency",
        "laplacian",
    ),
    "robotics.merits": (
        "measure_all",
        "metrics_of",
    ),
    "robotics.metrics": (
        "METRICS",
        "cross_track_error",
        "measure",
        "tracking_error",
    ),
    "robotics.notebook": ("player",),
    "robotics.path": (
        "Circle",
        "Line",
        "Path",
        "PathError",
        "Quintic",
        "Sine",
        "Waypoints",
        "compile_path",
    ),
    "robotics.radio": (
        "Fault",
        "Heard",
        "Radio",
        "RadioError",
    ),
    "robotics.recovery": (
        "Recovery",
        "recovery_curve",
    ),
    "robotics.robot": (
        "Robot",
        "RobotError",
    ),
    "robotics.run": (
        "Run",
        "RunError",
        "load_run",
    ),
    "robotics.scenario": (
        "Member",
        "Scenario",
        "ScenarioError",
        "Sensing",
        "load_scenario",
        "parse_scenario",
        "scenario_names",
    ),
    "robotics.simulation": (
        "SimulationError",
        "simulate",
    ),
    "robotics.team": (
        "TEAM_METRICS",
        "TeamError",
        "arrival_time",
        "measure_team",
        "nearest_distance",
        "progress_gap",
        "random_team",
        "team_toml",
        "true_progress",
    ),
    "robotics.trajectory": (
        "Timing",
        "Trajectory",
    ),
}
_HOME = {name: module for module, names in _MODULES.items() for name in names}


def __getattr__(name: str) -> Any:
    if name in _HOME:
        return getattr(import_module(_HOME[name]), name)
    raise AttributeError(f"module 'robotics' has no attribute {name!r}")


__all__ = [
    "CATALOGUE",
    "FORMATION_METRICS",
    "METRICS",
    "TEAM_METRICS",
    "Circle",
    "Command",
    "Comparison",
    "Controller",
    "ControllerError",
    "Fault",
    "Heard",
    "Line",
    "Member",
    "Observation",
    "Path",
    "PathError",
    "Quintic",
    "Radio",
    "RadioError",
    "Recovery",
    "Robot",
    "RobotError",
    "Run",
    "RunError",
    "Scenario",
    "ScenarioError",
    "Sensing",
    "SimulationError",
    "Sine",
    "TeamError",
    "Timing",
    "Trajectory",
    "Waypoints",
    "adjacency",
    "arrival_time",
    "compare",
    "compile_path",
    "cross_track_error",
    "formation_scenario",
    "laplacian",
    "load_run",
    "load_scenario",
    "make_controller",
    "measure",
    "measure_all",
    "measure_formation",
    "measure_team",
    "metrics_of",
    "nearest_distance",
    "parse_scenario",
    "player",
    "progress_gap",
    "random_team",
    "recovery_curve",
    "scenario_names",
    "simulate",
    "summarise",
    "team_toml",
    "tracking_error",
    "true_progress",
]
