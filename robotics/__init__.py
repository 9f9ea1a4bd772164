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
Learn a formation: docs/howto/own-formation.md:
    formation_data of a FormationRecipe, checking_recipe; learn_networks, a Learnt for each, write_networks
Log, and learn from logs: docs/howto/logs.md:
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
    wherever a controller or a metric is named: docs/howto/own-law.md; load_study, run_study, study_names; Answer, to a
    question of your own: docs/howto/own-question.md

Each name is imported from its module when it is first used, so that the command line starts quickly. Modules can be
imported by the names that they had up to version 0.2, and Python says by which they are now.
"""

from fuzzy.lazynames import lazy_names
from fuzzy.renamed import redirect

_MOVED = """
    world.vehicle world.paths world.radio world.environment world.sensing world.random_streams simulation.scenario
    measures.statistics studies.tuning studies.arena show.figures show.playback show.report show.designer
    show.designer.starts plugins.ccode plugins.logs plugins.reinforcement plugins.thesis
"""
_APART = """
    laws.avoidance.fuzzy_hierarchy:thesis.fuzzy_hierarchy laws.predictive:predictive
    laws.tracking.neural:reinforcement.neural laws.tracking.observed:reinforcement.observed
    laws.tracking.policyfile:reinforcement.policyfile show.designer:designer show.figures.arena:arena.figures
    show.figures.certificate:certificates.figures show.figures.formations:learning.figures
    show.figures.laws:thesis.figures show.figures.recovery:thesis.figures show.report.arena:arena.report
    show.report.learning:learning.report studies.arena:arena studies.certificate:certificates.certificate
    studies.compensation:certificates.compensation studies.learning.drivedata:logs.drivedata
    studies.learning:learning studies.lemma:thesis.lemma studies.recovery:thesis.recovery
    studies.scaling:thesis.recovery studies.stress:stress
    plugins.ccode.body:ccode.translation plugins.ccode.expressions:ccode.translation plugins.ccode.carried:ccode.source
    plugins.ccode.pythonsource:ccode.translation plugins.designer.foldersession:designer.folderfiles
    plugins.designer.seedrounds:designer.severalseeds plugins.designer.textdesk:designer.folderfiles
    plugins.learning.courses:learning.demonstrations plugins.learning.fresh:learning.formationlearning
    plugins.learning.rulefitting:learning.imitation plugins.logs.resampling:logs.drivedata
    plugins.logs.scene:logs.content plugins.logs.topics:logs.drive plugins.reinforcement.agents:reinforcement.episodes
    plugins.reinforcement.sb3:reinforcement.training plugins.reinforcement.teamcolumns:reinforcement.observed
"""  # earlier places of what is a plug-in now, or in another module of one, and that plug-in
_MERGED = """
    commands.templatefiles:commands.filekinds laws.preset:laws.law measures.emergencies:measures.avoidance
    show.figures.progress:show.figures.team show.figures.sonar:show.figures.modes simulation.state:simulation.loop
    simulation.scenario.sensortable:simulation.scenario.robots tables.lines:tables.text
    world.paths.level:world.paths.references
"""  # modules that are a part of another one now
__getattr__, __dir__, __all__ = lazy_names(__name__)
redirect(
    {f"robotics.{name.rpartition('.')[2]}": f"robotics.{name}" for name in _MOVED.split()}
    | {f"robotics.{name}": f"robotics.{now}" for name, _, now in (s.partition(":") for s in _MERGED.split())}
    | {f"robotics.{name}": f"robotics.plugins.{now}" for name, _, now in (s.partition(":") for s in _APART.split())}
    | {"robotics.experiments": "robotics.studies"},
    lasting={"robotics.quantity": "fuzzy.quantity"},  # which laws of one's own import
)
