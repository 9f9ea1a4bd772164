"""Mobile robots on one simulator: plant, sensors, paths, controllers, and their comparison.

>>> import robotics
>>> run = robotics.simulate(robotics.load_scenario("lyapunov-circle"), robotics.make_controller("lyapunov"), seeds=[3])
>>> bool(run["x"].shape == (1, 1, 501))
True

Describe and simulate:
    load_scenario, parse_scenario, scenario_names, load_robot, robot_names, Scenario and its parts (Member, Robot,
    Timing, Radio, Fault, Sensing, RangeSensor, shapes of paths such as Sine); compile_path, formation_scenario,
    random_team, team_toml, adjacency, laplacian; make_controller, CATALOGUE; simulate, simulate_many,
    load_run, Run
Measure, compare and look:
    measure_all, metrics_of, measure, measure_team, measure_formation, tracking_error, cross_track_error, arrival_time,
    nearest_distance, progress_gap, true_progress; compare, summarise, Comparison; recovery_curve; stress_crossing,
    stress_obstacles; explain_decision, explain_spans; player, a run in motion
Prove:
    certify, which takes a SectorModel and finds a Certificate
Tune:
    tune, what may move (LawSpace, Bound), what a run costs (Cost, Term), what was found (Tuned); load_tuning, a file
Hold laws against each other at their best:
    load_arena, run_arena, Arena
Learn a formation: docs/own-formation.md:
    formation_data of a FormationRecipe, checking_recipe; learn_networks, a Learnt for each, write_networks
Log, and learn from logs: docs/logs.md:
    write_mcap, write_rosbag, write_layout; read_drive, Drive; drive_data, DriveRecipe; LogError
Learn by reinforcement (gymnasium, pettingzoo):
    TrackingEnv, TrackingVectorEnv, TeamEnv
Draw, each a matplotlib figure:
    of a run plot_run, plot_team, plot_formation, plot_avoidance, plot_trajectories, plot_distances, plot_progress,
    plot_modes, plot_sonar, plot_rules_at, plot_meetings; of several plot_comparison, plot_leads, plot_paths,
    plot_errors, plot_velocities, plot_recovery, plot_scaling; of a law plot_states, plot_certificate;
    of a scenario plot_scenario; of an arena plot_arena
Take to a robot:
    write_c_law, a law's control step in C (CLawFiles), and verify_c_law, the proof that it is the same (VerifiedLaw)
Your own laws, metrics and studies:
    Law, Setting, Observation, Command, Heard, Preset, ControllerError; metric, Metric; a file or an object is accepted
    wherever a controller or a metric is named: docs/own-law.md; load_study, run_study, study_names

Each name is imported from its module when it is first used, so that the command line starts quickly.
"""

from fuzzy.lazynames import lazy_names

TYPE_CHECKING = False  # type checkers take it as true by its name; importing typing would double the time

if TYPE_CHECKING:
    from robotics.arena.description import Arena, load_arena
    from robotics.arena.families import ArenaError
    from robotics.ccode.verification import VerifiedLaw, verify_c_law
    from robotics.ccode.writing import CLawFiles, write_c_law
    from robotics.experiments.certificate import Certificate, CertificateError, SectorModel, certify
    from robotics.experiments.comparison import Comparison, compare, summarise
    from robotics.experiments.learning.drivedata import DriveRecipe, drive_data
    from robotics.experiments.learning.formationdata import FormationRecipe, checking_recipe, formation_data
    from robotics.experiments.learning.formationlearning import (
        FormationLearningError,
        Learnt,
        learn_networks,
        write_networks,
    )
    from robotics.experiments.population import Population, PopulationError, simulate_many
    from robotics.experiments.recovery import Recovery, recovery_curve
    from robotics.experiments.stress.crossing_runs import stress_crossing
    from robotics.experiments.stress.obstaclecourse import stress_obstacles
    from robotics.figures.avoidance import plot_avoidance, plot_trajectories
    from robotics.figures.certificate import plot_certificate
    from robotics.figures.comparison import plot_comparison
    from robotics.figures.controllers import plot_errors, plot_paths, plot_velocities
    from robotics.figures.distances import plot_distances
    from robotics.figures.drawing import PlotError
    from robotics.figures.formation_run import plot_formation
    from robotics.figures.leads import plot_leads
    from robotics.figures.meetings import plot_meetings
    from robotics.figures.modes import plot_modes
    from robotics.figures.progress import plot_progress
    from robotics.figures.recovery import plot_recovery, plot_scaling
    from robotics.figures.rules import plot_rules_at
    from robotics.figures.run import plot_run
    from robotics.figures.scenario import plot_scenario
    from robotics.figures.sonar import plot_sonar
    from robotics.figures.states import plot_states
    from robotics.figures.team import plot_team
    from robotics.laws.catalogue import CATALOGUE, make_controller
    from robotics.laws.law import Command, Controller, ControllerError, Law, Observation
    from robotics.laws.preset import Preset
    from robotics.laws.setting import Setting
    from robotics.logs.drive import Drive, read_drive
    from robotics.logs.layout import write_layout
    from robotics.logs.typestore import LogError
    from robotics.logs.writing import write_mcap, write_rosbag
    from robotics.measures.arrival import arrival_time
    from robotics.measures.explained import explain_decision, explain_spans
    from robotics.measures.formations import FORMATION_METRICS, measure_formation
    from robotics.measures.own import MetricError, metric
    from robotics.measures.progress import progress_gap, true_progress
    from robotics.measures.registry import measure_all, metrics_of
    from robotics.measures.teams import TEAM_METRICS, measure_team, nearest_distance
    from robotics.measures.tracking import METRICS, Metric, cross_track_error, measure, tracking_error
    from robotics.paths.path import Circle, Line, Path, PathError, Quintic, Sine, Waypoints, compile_path
    from robotics.paths.trajectory import Timing, Trajectory
    from robotics.playback.notebook import player
    from robotics.radio.channel import Heard
    from robotics.radio.description import Radio, RadioError
    from robotics.radio.faults import Fault
    from robotics.radio.graph import adjacency, laplacian
    from robotics.reinforcement.single import TrackingEnv
    from robotics.reinforcement.task import TaskError
    from robotics.reinforcement.team import TeamEnv
    from robotics.reinforcement.vector import TrackingVectorEnv
    from robotics.report.arena import plot_arena, run_arena
    from robotics.report.plan import StudyError, StudyPlan, load_study, study_names
    from robotics.report.study import Study, run_study
    from robotics.scenario.description import Member, Scenario, ScenarioError
    from robotics.scenario.formations import formation_scenario
    from robotics.scenario.random_team import TeamError, random_team, team_toml
    from robotics.scenario.reading import load_scenario, parse_scenario, scenario_names
    from robotics.scenario.robots import RobotModel, load_robot, robot_names
    from robotics.sensing.posture import Sensing, SensingError
    from robotics.sensing.sonar import RangeSensor
    from robotics.simulation.loop import SimulationError, simulate
    from robotics.simulation.run import Run, RunError, load_run
    from robotics.tuning.cost import Cost, Term
    from robotics.tuning.file import load_tuning
    from robotics.tuning.space import Bound, LawSpace
    from robotics.tuning.tune import Tuned, tune
    from robotics.vehicle.robot import Robot, RobotError

_HOMES = {
    "robotics.arena.description": ("Arena", "load_arena"),
    "robotics.arena.families": ("ArenaError",),
    "robotics.ccode.verification": ("VerifiedLaw", "verify_c_law"),
    "robotics.ccode.writing": ("CLawFiles", "write_c_law"),
    "robotics.experiments.certificate": ("Certificate", "CertificateError", "SectorModel", "certify"),
    "robotics.experiments.comparison": ("Comparison", "compare", "summarise"),
    "robotics.experiments.learning.drivedata": ("DriveRecipe", "drive_data"),
    "robotics.experiments.learning.formationdata": ("FormationRecipe", "checking_recipe", "formation_data"),
    "robotics.experiments.learning.formationlearning": (
        "FormationLearningError",
        "Learnt",
        "learn_networks",
        "write_networks",
    ),
    "robotics.experiments.population": ("Population", "PopulationError", "simulate_many"),
    "robotics.experiments.recovery": ("Recovery", "recovery_curve"),
    "robotics.experiments.stress.crossing_runs": ("stress_crossing",),
    "robotics.experiments.stress.obstaclecourse": ("stress_obstacles",),
    "robotics.figures.avoidance": ("plot_avoidance", "plot_trajectories"),
    "robotics.figures.certificate": ("plot_certificate",),
    "robotics.figures.comparison": ("plot_comparison",),
    "robotics.figures.controllers": ("plot_errors", "plot_paths", "plot_velocities"),
    "robotics.figures.distances": ("plot_distances",),
    "robotics.figures.drawing": ("PlotError",),
    "robotics.figures.formation_run": ("plot_formation",),
    "robotics.figures.leads": ("plot_leads",),
    "robotics.figures.meetings": ("plot_meetings",),
    "robotics.figures.modes": ("plot_modes",),
    "robotics.figures.progress": ("plot_progress",),
    "robotics.figures.recovery": ("plot_recovery", "plot_scaling"),
    "robotics.figures.rules": ("plot_rules_at",),
    "robotics.figures.run": ("plot_run",),
    "robotics.figures.scenario": ("plot_scenario",),
    "robotics.figures.sonar": ("plot_sonar",),
    "robotics.figures.states": ("plot_states",),
    "robotics.figures.team": ("plot_team",),
    "robotics.laws.catalogue": ("CATALOGUE", "make_controller"),
    "robotics.laws.law": ("Command", "Controller", "ControllerError", "Law", "Observation"),
    "robotics.laws.preset": ("Preset",),
    "robotics.laws.setting": ("Setting",),
    "robotics.logs.drive": ("Drive", "read_drive"),
    "robotics.logs.layout": ("write_layout",),
    "robotics.logs.typestore": ("LogError",),
    "robotics.logs.writing": ("write_mcap", "write_rosbag"),
    "robotics.measures.arrival": ("arrival_time",),
    "robotics.measures.explained": ("explain_decision", "explain_spans"),
    "robotics.measures.formations": ("FORMATION_METRICS", "measure_formation"),
    "robotics.measures.own": ("MetricError", "metric"),
    "robotics.measures.progress": ("progress_gap", "true_progress"),
    "robotics.measures.registry": ("measure_all", "metrics_of"),
    "robotics.measures.teams": ("TEAM_METRICS", "measure_team", "nearest_distance"),
    "robotics.measures.tracking": ("METRICS", "Metric", "cross_track_error", "measure", "tracking_error"),
    "robotics.paths.path": ("Circle", "Line", "Path", "PathError", "Quintic", "Sine", "Waypoints", "compile_path"),
    "robotics.paths.trajectory": ("Timing", "Trajectory"),
    "robotics.playback.notebook": ("player",),
    "robotics.radio.channel": ("Heard",),
    "robotics.radio.description": ("Radio", "RadioError"),
    "robotics.radio.faults": ("Fault",),
    "robotics.radio.graph": ("adjacency", "laplacian"),
    "robotics.reinforcement.single": ("TrackingEnv",),
    "robotics.reinforcement.task": ("TaskError",),
    "robotics.reinforcement.team": ("TeamEnv",),
    "robotics.reinforcement.vector": ("TrackingVectorEnv",),
    "robotics.report.arena": ("plot_arena", "run_arena"),
    "robotics.report.plan": ("StudyError", "StudyPlan", "load_study", "study_names"),
    "robotics.report.study": ("Study", "run_study"),
    "robotics.scenario.description": ("Member", "Scenario", "ScenarioError"),
    "robotics.scenario.formations": ("formation_scenario",),
    "robotics.scenario.random_team": ("TeamError", "random_team", "team_toml"),
    "robotics.scenario.reading": ("load_scenario", "parse_scenario", "scenario_names"),
    "robotics.scenario.robots": ("RobotModel", "load_robot", "robot_names"),
    "robotics.sensing.posture": ("Sensing", "SensingError"),
    "robotics.sensing.sonar": ("RangeSensor",),
    "robotics.simulation.loop": ("SimulationError", "simulate"),
    "robotics.simulation.run": ("Run", "RunError", "load_run"),
    "robotics.tuning.cost": ("Cost", "Term"),
    "robotics.tuning.file": ("load_tuning",),
    "robotics.tuning.space": ("Bound", "LawSpace"),
    "robotics.tuning.tune": ("Tuned", "tune"),
    "robotics.vehicle.robot": ("Robot", "RobotError"),
}
if not TYPE_CHECKING:  # a type checker has the names above, and sees which there are not
    __getattr__, __dir__ = lazy_names(__name__, _HOMES)

__all__ = [
    "CATALOGUE",
    "FORMATION_METRICS",
    "METRICS",
    "TEAM_METRICS",
    "Arena",
    "ArenaError",
    "Bound",
    "CLawFiles",
    "Certificate",
    "CertificateError",
    "Circle",
    "Command",
    "Comparison",
    "Controller",
    "ControllerError",
    "Cost",
    "Drive",
    "DriveRecipe",
    "Fault",
    "FormationLearningError",
    "FormationRecipe",
    "Heard",
    "Law",
    "LawSpace",
    "Learnt",
    "Line",
    "LogError",
    "Member",
    "Metric",
    "MetricError",
    "Observation",
    "Path",
    "PathError",
    "PlotError",
    "Population",
    "PopulationError",
    "Preset",
    "Quintic",
    "Radio",
    "RadioError",
    "RangeSensor",
    "Recovery",
    "Robot",
    "RobotError",
    "RobotModel",
    "Run",
    "RunError",
    "Scenario",
    "ScenarioError",
    "SectorModel",
    "Sensing",
    "SensingError",
    "Setting",
    "SimulationError",
    "Sine",
    "Study",
    "StudyError",
    "StudyPlan",
    "TaskError",
    "TeamEnv",
    "TeamError",
    "Term",
    "Timing",
    "TrackingEnv",
    "TrackingVectorEnv",
    "Trajectory",
    "Tuned",
    "VerifiedLaw",
    "Waypoints",
    "adjacency",
    "arrival_time",
    "certify",
    "checking_recipe",
    "compare",
    "compile_path",
    "cross_track_error",
    "drive_data",
    "explain_decision",
    "explain_spans",
    "formation_data",
    "formation_scenario",
    "laplacian",
    "learn_networks",
    "load_arena",
    "load_robot",
    "load_run",
    "load_scenario",
    "load_study",
    "load_tuning",
    "make_controller",
    "measure",
    "measure_all",
    "measure_formation",
    "measure_team",
    "metric",
    "metrics_of",
    "nearest_distance",
    "parse_scenario",
    "player",
    "plot_arena",
    "plot_avoidance",
    "plot_certificate",
    "plot_comparison",
    "plot_distances",
    "plot_errors",
    "plot_formation",
    "plot_leads",
    "plot_meetings",
    "plot_modes",
    "plot_paths",
    "plot_progress",
    "plot_recovery",
    "plot_rules_at",
    "plot_run",
    "plot_scaling",
    "plot_scenario",
    "plot_sonar",
    "plot_states",
    "plot_team",
    "plot_trajectories",
    "plot_velocities",
    "progress_gap",
    "random_team",
    "read_drive",
    "recovery_curve",
    "robot_names",
    "run_arena",
    "run_study",
    "scenario_names",
    "simulate",
    "simulate_many",
    "stress_crossing",
    "stress_obstacles",
    "study_names",
    "summarise",
    "team_toml",
    "tracking_error",
    "true_progress",
    "tune",
    "verify_c_law",
    "write_c_law",
    "write_layout",
    "write_mcap",
    "write_networks",
    "write_rosbag",
]
