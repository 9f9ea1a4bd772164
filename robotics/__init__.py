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
    from robotics.experiments.comparison import Comparison, compare, summarise
    from robotics.experiments.recovery import Recovery, recovery_curve
    from robotics.laws.catalogue import CATALOGUE, make_controller
    from robotics.laws.law import Command, Controller, ControllerError, Law, Observation
    from robotics.laws.setting import Setting
    from robotics.measures.arrival import arrival_time
    from robotics.measures.explained import explain_decision, explain_spans
    from robotics.measures.formations import FORMATION_METRICS, measure_formation
    from robotics.measures.progress import progress_gap, true_progress
    from robotics.measures.registry import measure_all, metrics_of
    from robotics.measures.teams import TEAM_METRICS, measure_team, nearest_distance
    from robotics.measures.tracking import METRICS, cross_track_error, measure, tracking_error
    from robotics.paths.path import Circle, Line, Path, PathError, Quintic, Sine, Waypoints, compile_path
    from robotics.paths.trajectory import Timing, Trajectory
    from robotics.playback.notebook import player
    from robotics.radio.channel import Heard
    from robotics.radio.description import Radio, RadioError
    from robotics.radio.faults import Fault
    from robotics.radio.graph import adjacency, laplacian
    from robotics.report.plan import StudyError, StudyPlan, load_study, study_names
    from robotics.report.study import Study, run_study
    from robotics.scenario.description import Member, Scenario, ScenarioError
    from robotics.scenario.formations import formation_scenario
    from robotics.scenario.random_team import TeamError, random_team, team_toml
    from robotics.scenario.reading import load_scenario, parse_scenario, scenario_names
    from robotics.sensing.posture import Sensing, SensingError
    from robotics.sensing.sonar import RangeSensor
    from robotics.simulation.loop import SimulationError, simulate
    from robotics.simulation.run import Run, RunError, load_run
    from robotics.vehicle.robot import Robot, RobotError

_MODULES = {
    "robotics.experiments.comparison": ("Comparison", "compare", "summarise"),
    "robotics.experiments.recovery": ("Recovery", "recovery_curve"),
    "robotics.laws.catalogue": ("CATALOGUE", "make_controller"),
    "robotics.laws.law": ("Command", "Controller", "ControllerError", "Law", "Observation"),
    "robotics.laws.setting": ("Setting",),
    "robotics.measures.explained": ("explain_decision", "explain_spans"),
    "robotics.measures.formations": ("FORMATION_METRICS", "measure_formation"),
    "robotics.measures.registry": ("measure_all", "metrics_of"),
    "robotics.measures.teams": ("TEAM_METRICS", "measure_team", "nearest_distance"),
    "robotics.measures.arrival": ("arrival_time",),
    "robotics.measures.progress": ("progress_gap", "true_progress"),
    "robotics.measures.tracking": ("METRICS", "cross_track_error", "measure", "tracking_error"),
    "robotics.paths.path": ("Circle", "Line", "Path", "PathError", "Quintic", "Sine", "Waypoints", "compile_path"),
    "robotics.paths.trajectory": ("Timing", "Trajectory"),
    "robotics.playback.notebook": ("player",),
    "robotics.radio.channel": ("Heard",),
    "robotics.radio.description": ("Radio", "RadioError"),
    "robotics.radio.faults": ("Fault",),
    "robotics.radio.graph": ("adjacency", "laplacian"),
    "robotics.report.plan": ("StudyError", "StudyPlan", "load_study", "study_names"),
    "robotics.report.study": ("Study", "run_study"),
    "robotics.scenario.description": ("Member", "Scenario", "ScenarioError"),
    "robotics.scenario.formations": ("formation_scenario",),
    "robotics.scenario.random_team": ("TeamError", "random_team", "team_toml"),
    "robotics.scenario.reading": ("load_scenario", "parse_scenario", "scenario_names"),
    "robotics.sensing.posture": ("Sensing", "SensingError"),
    "robotics.sensing.sonar": ("RangeSensor",),
    "robotics.simulation.loop": ("SimulationError", "simulate"),
    "robotics.simulation.run": ("Run", "RunError", "load_run"),
    "robotics.vehicle.robot": ("Robot", "RobotError"),
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
    "Law",
    "Line",
    "Member",
    "Observation",
    "Path",
    "PathError",
    "Quintic",
    "Radio",
    "RadioError",
    "RangeSensor",
    "Recovery",
    "Robot",
    "RobotError",
    "Run",
    "RunError",
    "Scenario",
    "ScenarioError",
    "Sensing",
    "SensingError",
    "Setting",
    "SimulationError",
    "Sine",
    "Study",
    "StudyError",
    "StudyPlan",
    "TeamError",
    "Timing",
    "Trajectory",
    "Waypoints",
    "adjacency",
    "arrival_time",
    "compare",
    "compile_path",
    "cross_track_error",
    "explain_decision",
    "explain_spans",
    "formation_scenario",
    "laplacian",
    "load_run",
    "load_scenario",
    "load_study",
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
    "run_study",
    "scenario_names",
    "simulate",
    "study_names",
    "summarise",
    "team_toml",
    "tracking_error",
    "true_progress",
]
