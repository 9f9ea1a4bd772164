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
Compare laws at their best:
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

import _fuzzyfleet

_fuzzyfleet.check()

from fuzzy.lazynames import lazy_names  # noqa: E402
from fuzzy.renamed import redirect  # noqa: E402

# What was elsewhere once: a line has the earlier name of a module or a folder, and the present one
_MOVED = __loader__.get_data(f"{__path__[0]}/moved.txt").decode().split()
__getattr__, __dir__, __all__ = lazy_names(__name__)
redirect(
    {f"robotics.{old}": f"robotics.{new}" for old, new in zip(_MOVED[::2], _MOVED[1::2], strict=True)},
    lasting={"robotics.quantity": "fuzzy.quantity"},  # which laws of one's own import
)
