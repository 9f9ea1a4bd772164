"""Episodes against runs: the same commands give the same trajectory to the bit, and rewards sum to the arena's cost."""

from dataclasses import replace

import numpy as np
import pytest

import robotics
from robotics.measures.contacts import first_contact
from robotics.measures.tracking import late as late_samples
from robotics.plugins.reinforcement.choosing import chosen_scenarios
from robotics.studies.tuning.cost import Cost, costs_of
from robotics.world.environment.world import Disc
from robotics.world.sensing.carried import sensor_names
from robotics.world.sensing.posture import Sensing
from robotics.world.vehicle.floor import Patch
from robotics.world.vehicle.plant import TruthColumns as Truth

pytest.importorskip("gymnasium", reason="needs gymnasium")
from robotics.plugins.reinforcement.reward import SpanColumns, reward_observer, spans
from robotics.plugins.reinforcement.single import TrackingEnv
from robotics.plugins.reinforcement.vector import TrackingVectorEnv

SHORT = robotics.load_scenario("lyapunov-circle")
SENSORS = robotics.load_scenario("obstacles-on-two-paths").setting.sensors[0]


def drawn(count=2):
    """Random scenarios of an arena: noise, latency, scattered starts."""
    return chosen_scenarios(None, "default", count, 7_000_000)


def driven(env, run, place=0, seed=0):
    """Drive ``env`` by the commands of a run; the rewards, the last infos, and whether the trajectory was the run's."""
    observed, _ = env.reset(seed=seed)
    lanes, rewards, infos = env.lane.episodes.lanes, [], {}
    for k in range(len(run.time)):
        for row, name in (
            (Truth.x.row, "x"),
            (Truth.y.row, "y"),
            (Truth.heading.row, "heading"),
            (Truth.v.row, "v"),
            (Truth.w.row, "w"),
        ):
            assert lanes.body.truth[row, 0] == run[name][place, 0, k], (name, k)
        for row, name in enumerate(("x_measured", "y_measured", "heading_measured")):
            assert lanes.moment.seen[row, 0] == run[name][place, 0, k], (name, k)
        assert env.observation_space.contains(observed)
        command = [run["command_1"][place, 0, k], run["command_2"][place, 0, k]]
        observed, reward, terminated, truncated, infos = env.step(command)
        rewards.append(reward)
        if terminated or truncated:
            break
    return np.array(rewards), infos, terminated, k


@pytest.mark.parametrize("law", ["lyapunov", "esm"])  # velocities; wheel torques
def test_the_commands_of_a_law_give_its_run_to_the_bit(law):
    scenario = drawn()[1]
    level = robotics.make_controller(law).level
    run = robotics.simulate(scenario, law, seeds=[5])
    env = TrackingEnv(scenario, units=True, level=level)
    _, infos, terminated, last = driven(env, run, seed=5)
    assert not terminated
    assert last == scenario.ticks
    assert infos["end"] == "time"


@pytest.mark.parametrize(
    "sensing",
    [
        Sensing(),
        Sensing(posture="pose", position_noise=0.01, filter_gain=0.3, noise_start=2.0, noise_end=5.0),
        Sensing(posture="pose", relative_noise=0.01, wheel_error=0.02, axle_error=0.02, start_heading=0.1),
    ],
)
def test_every_way_of_sensing_is_that_of_a_run(sensing):
    scenario = replace(SHORT, sensing=sensing, latency=0.07)
    run = robotics.simulate(scenario, "lyapunov", seeds=[2])
    driven(TrackingEnv(scenario, units=True), run, seed=2)


def test_a_kinematic_plant_is_driven_too():
    scenario = replace(SHORT, plant="kinematic")
    run = robotics.simulate(scenario, "lyapunov")
    driven(TrackingEnv(scenario, units=True), run)


def test_a_floor_with_patches_is_that_of_a_run_and_of_the_next_episode():
    scenario = replace(SHORT, patches=(Patch(friction=0.05, center=(0.3, 1.0), radius=0.4),), duration=8.0)
    run, env = robotics.simulate(scenario, "lyapunov"), TrackingEnv(scenario, units=True)
    plain = robotics.simulate(replace(scenario, patches=()), "lyapunov")
    assert np.abs(run["x"] - plain["x"]).max() > 1e-3
    for _ in range(2):
        driven(env, run)


@pytest.mark.parametrize("number", [0, 1])
def test_rewards_sum_to_the_cost_of_the_arena(number):
    scenario = drawn()[number]
    run = robotics.simulate(scenario, "fuzzy", seeds=[3])
    cost = costs_of(Cost(), [scenario], ["fuzzy"], [3])[0, 0, 0].sum()
    exact, infos, *_ = driven(TrackingEnv(scenario, units=True, reward="cost"), run, seed=3)
    assert infos["cost"] == pytest.approx(cost, rel=1e-12)
    assert -exact.sum() == pytest.approx(cost, rel=1e-12)
    dense, *_ = driven(TrackingEnv(scenario, units=True), run, seed=3)
    assert (dense <= 0).all()
    # By Jensen's inequality: a mean is at most a root of a mean square.
    assert 0.4 * cost < -dense.sum() < cost
    # The mean amounts, by the run itself
    late, errors = late_samples(run)[0], robotics.tracking_error(run)
    distance = np.hypot(errors.x, errors.y)[0, 0, late].mean() / 0.01
    heading = np.abs(errors.heading[0, 0, late]).mean() / np.radians(5)
    turning = robotics.METRICS["w_variation_late_radps2"].measure(run)[0, 0]
    assert -dense.sum() == pytest.approx(distance + heading + turning, rel=1e-12)
    early, *_ = driven(TrackingEnv(scenario, units=True, approach=1.0), run, seed=3)
    assert (early[late] == dense[late]).all()
    assert (early[~late] < 0).all()
    assert (dense[~late] == 0).all()


def test_a_path_of_less_than_12_s_is_counted_from_its_middle():
    scenario = replace(SHORT, duration=8.0)
    run = robotics.simulate(scenario, "lyapunov")
    cost = costs_of(Cost(), [scenario], ["lyapunov"], [0])[0, 0, 0].sum()
    exact, *_ = driven(TrackingEnv(scenario, units=True, reward="cost"), run)
    assert -exact.sum() == pytest.approx(cost, rel=1e-12)


@pytest.mark.parametrize("reward", ["cost", "dense"])
def test_divergence_ends_an_episode_and_costs_no_less_than_going_on(reward):
    scenario = replace(drawn()[0], divergence=0.3)
    env = TrackingEnv(scenario, reward=reward, approach=1.0)
    env.reset(seed=1)
    rewards, terminated = [], False
    while not terminated:
        _, one, terminated, truncated, infos = env.step([0.0, 0.0])
        rewards.append(one)
        assert not truncated
    assert infos == {"cost": 100.0, "end": "diverged"}
    if reward == "cost":
        assert sum(rewards) == pytest.approx(-100, rel=1e-12)
    else:
        samples = scenario.ticks + 1
        begin = SpanColumns(spans(scenario)).counted[0]
        many = samples - begin
        left = samples - len(rewards)
        assert rewards[-1] == pytest.approx(-(100 * left + 30) / many, rel=0.3 * 30 / (100 * left))
        assert -sum(rewards) <= 100 * samples / many
    run = robotics.simulate(scenario, "lyapunov:kx=0.001,feed_forward=none", seeds=[1])
    assert run.diverged.all()
    exact, infos, terminated, last = driven(TrackingEnv(scenario, units=True, reward="cost"), run, seed=1)
    assert terminated
    assert last == run.stopped[0, 0]
    assert exact.sum() == pytest.approx(-100, rel=1e-12)


def test_a_command_that_is_no_number_stops_the_robot():
    env = TrackingEnv(SHORT)
    env.reset(seed=0)
    observed, reward, terminated, _, infos = env.step([np.nan, 0.0])
    assert terminated
    assert infos["end"] == "diverged"
    assert np.isfinite(reward)
    assert np.isfinite(observed[:7]).all()


def beside_obstacles():
    """A robot with sonars on a circle, past one disc and into another."""
    path = SHORT.robots[0].path
    assert path is not None
    x, y = (float(v[0]) for v in SHORT.trajectory.at(0.6 * SHORT.duration)[:2])
    first = SHORT.trajectory.at(0.2 * SHORT.duration)
    beside = Disc(position=(1.25 * float(first.x[0]), 1.25 * float(first.y[0])), radius=0.1)
    into = Disc(position=(x, y), radius=0.1)
    return replace(SHORT, obstacles=(beside, into), sensors=SENSORS)


def test_ranges_are_those_of_a_run_and_a_contact_ends_the_episode():
    scenario = beside_obstacles()
    run = robotics.simulate(scenario, "fuzzy:rule_base=wall-follower", seeds=[4])
    assert run.ranges is not None
    names = sensor_names(run.about.sensors)
    env = TrackingEnv(scenario, units=True)
    entries = [entry.name for entry in env.task.entries]
    observed, _ = env.reset(seed=4)
    known = 0
    for k in range(200):
        for name in names:
            high = env.task.entries[entries.index(f"range_{name}")].high
            told = run.ranges[k, 0, 0, names.index(name)]
            assert observed[entries.index(f"range_{name}")] == pytest.approx(min(told, high), abs=1e-6)
            known += told < high
        observed, *_ = env.step([run["command_1"][0, 0, k], run["command_2"][0, 0, k]])
    assert known > 10
    run = robotics.simulate(scenario, "lyapunov", seeds=[4])
    assert costs_of(Cost(), [scenario], ["lyapunov"], [4]).sum() == 100
    touched = robotics.measure_all(run)["contacts"]
    assert touched[0, 0] == 1
    first = first_contact(run)[0]
    for reward in ("cost", "dense"):
        rewards, infos, terminated, last = driven(TrackingEnv(scenario, units=True, reward=reward), run, seed=4)
        assert terminated
        assert infos["end"] == "collided"
        assert infos["cost"] == 100
        assert last * scenario.period < first <= (last + 1) * scenario.period
        assert -rewards.sum() == pytest.approx(100, rel=1e-9) if reward == "cost" else -rewards.sum() <= 100


@pytest.mark.parametrize("reward", ["dense", "cost"])
@pytest.mark.parametrize("case", ["on time", "torques", "diverged", "collided"])
def test_a_plain_run_is_given_the_return_of_the_environment(case, reward):
    scenario, law, seeds = drawn()[1], "lyapunov", [3, 4]
    if case == "torques":
        law = "esm"
    elif case == "diverged":
        scenario, law = replace(drawn()[0], divergence=0.3), "lyapunov:kx=0.001,feed_forward=none"
    elif case == "collided":
        scenario = beside_obstacles()
    options = {"reward": reward, "level": robotics.make_controller(law).level, "approach": 0.5}
    observer = reward_observer(scenario, len(seeds), **options)
    run = robotics.simulate(scenario, law, seeds, observer=observer)
    for place, seed in enumerate(seeds):
        rewards, infos, *_ = driven(TrackingEnv(scenario, units=True, **options), run, place, seed)
        assert infos["end"] == (case if case in ("diverged", "collided") else "time")
        total = 0.0
        for one in rewards.tolist():
            total += one
        assert observer.notes.returned[place] == total


def test_lanes_do_not_know_of_each_other():
    """Each lane of a vector environment, in whatever company, is the environment of one; also after its end."""
    scenarios = [replace(s, duration=3.0) for s in drawn()]
    several = TrackingVectorEnv(70, scenarios, divergence=0.4, threads=2)
    observed, _ = several.reset(seed=100)
    actions = np.random.default_rng(0).uniform(-0.3, 0.6, (150, 70, 2))
    for lane in (0, 33, 69):
        alone = TrackingVectorEnv(1, scenarios, divergence=0.4, threads=1)
        alone_observed, _ = alone.reset(seed=100 + lane)
        observed, _ = several.reset(seed=100)
        ends = 0
        for action in actions:
            assert (observed[lane] == alone_observed[0]).all()
            observed, rewards, terminated, truncated, _ = several.step(action)
            alone_observed, *rest, _ = alone.step(action[lane : lane + 1])
            assert (rewards[lane], terminated[lane], truncated[lane]) == tuple(part[0] for part in rest)
            ends += terminated[lane] or truncated[lane]
        assert ends >= 2
