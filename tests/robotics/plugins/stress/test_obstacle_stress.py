"""Random courses among obstacles: drawn by their seed alone, judged exactly; who arrives and what touches."""

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from fuzzy.shell.options import Application
from robotics.laws.catalogue import make_controller
from robotics.plugins.stress import obstaclecourse
from robotics.plugins.stress.commands_stress_obstacles import obstacles
from robotics.plugins.stress.crossings import drawn_ensemble, growth
from robotics.plugins.stress.disturbance import UNDISTURBED, Disturbance
from robotics.plugins.stress.obstaclecourse import ObstacleOutcome, obstacle_ensemble, stress_obstacles
from robotics.plugins.stress.quintic_table import quintic_table
from robotics.plugins.stress.tally import run_ensemble
from robotics.simulation.scenario.robots import load_robot
from robotics.world.environment.collision import obstacle_contacts
from robotics.world.environment.world import Wall, World, compile_worlds
from robotics.world.paths.path import Quintic
from tests.robotics.laws.rules.arrayform import clearances
from tests.robotics.laws.rules.arrayform.laws import InterpretedTeam

COMMITTED, LITERAL = make_controller("obstacles"), make_controller("obstacles-literal")


def same(a, b):
    return a.tobytes() == b.tobytes()


@pytest.mark.parametrize(("kind", "robots"), [("A", 1), ("B", 1), ("U", 1), ("A", 3)])
def test_a_course_depends_on_its_seed_alone_and_starts_free(kind, robots):
    many, one = obstacle_ensemble((4, 7, 11), kind, robots), obstacle_ensemble((7,), kind, robots)
    assert same(many.starts[1], one.starts[0])
    count = one.world.rest.counts[0]
    assert many.world.rest.counts[1] == count
    assert same(many.world.rest.circles[1, :count], one.world.rest.circles[0, :count])
    sizes = np.array([[0.115], [0.1], [0.153]]).repeat(robots, axis=1)
    for place in (many.starts, np.stack([*many.references.joined.at(many.references.joined.lengths)[:3]], axis=-1)):
        touched = obstacle_contacts(place[..., 0], place[..., 1], place[..., 2], sizes, many.world.at(0.0))
        assert (touched < 0).all()


@cache
def driven(kind, robots, runs):
    """What became of the courses of seeds 100 ... under the committed scheme."""
    return stress_obstacles(COMMITTED, range(100, 100 + runs), kind, robots)


@pytest.mark.parametrize(
    ("kind", "robots", "runs"),
    [
        *[("A", 1, 12), ("B", 1, 8), ("U", 1, 6), ("A", 3, 4)],
        *[pytest.param("A", 1, 1000, marks=pytest.mark.long), pytest.param("B", 1, 500, marks=pytest.mark.long)],
        *[pytest.param("U", 1, 400, marks=pytest.mark.long), pytest.param("A", 3, 60, marks=pytest.mark.long)],
    ],
)
def test_committed_robots_arrive_and_nothing_touches(kind, robots, runs):
    outcome = driven(kind, robots, runs)
    assert outcome.succeeded.all()
    assert outcome.clearance.min() > 0.02
    summary = outcome.summary()
    assert summary["contacts"] == summary["deadlocks"] == 0
    assert summary["arrived"] == runs
    assert summary["arrived_together"] == runs
    if kind == "U":
        assert summary["followed_wall"] > 0  # some traps cannot be left otherwise


def test_the_literal_scheme_never_leaves_a_trap(monkeypatch):
    monkeypatch.setattr(obstaclecourse.ObstacleOutcome, "limit", 1.5)
    outcome = stress_obstacles(LITERAL, range(2), "U")
    assert not outcome.arrived.any()
    assert outcome.summary()["failed_seeds"]["deadlock"] == [0, 1]


def test_contacts_are_seen():
    """Robots that look at nothing run into what stands on their paths."""
    outcome = stress_obstacles(make_controller("cooperation"), range(2), "U", 3)
    assert outcome.hit.all()
    assert (outcome.clearance < 0).all()
    assert outcome.summary()["contacts"] == 2
    assert outcome.summary()["failed_seeds"]["obstacle"] == [0, 1]


@pytest.mark.parametrize(
    ("seeds", "options"),
    [
        (range(424249, 424252), {"moving": 5}),  # the last touches a disc
        (range(100, 102), {"kind": "B", "robots": 3, "disturbance": Disturbance(loss=0.2, freeze=8.0)}),
    ],
)
def test_every_field_of_an_outcome_depends_on_its_seed_alone(seeds, options):
    beside = stress_obstacles(COMMITTED, seeds, **options)
    for seed in seeds:
        alone = stress_obstacles(COMMITTED, (seed,), **options)
        mine = beside.table[beside.table["seed"] == seed].reset_index(drop=True)
        pd.testing.assert_frame_equal(alone.table, mine, check_exact=True)


def test_lost_and_late_messages_cause_no_contact():
    outcome = stress_obstacles(COMMITTED, range(2), "A", 3, disturbance=Disturbance(loss=0.2, latency=0.3))
    assert outcome.succeeded.all()


def test_discs_cross_the_lanes_and_leave_the_rest_as_it_was():
    still, moving = obstacle_ensemble((4, 7), "A", 1), obstacle_ensemble((4, 7), "A", 1, moving=2)
    assert still.world.motion is None
    for k, count in enumerate(still.world.rest.counts):
        assert moving.world.rest.counts[k] == count + 2
        assert same(moving.world.rest.circles[k, :count], still.world.rest.circles[k, :count])
        steps = [moving.world.at(time).circles[k, count : count + 2, :2] for time in (1.0, 2.0)]
        speeds = np.hypot(*(steps[1] - steps[0]).T)
        assert ((speeds >= 0.05) & (speeds <= 0.2)).all()


def test_whose_fault_a_contact_is():
    """Robots that look at nothing drive into what stands there."""
    blind = stress_obstacles(make_controller("cooperation"), range(2), "U")
    assert blind.caused.all()


# The command line ---------------------------------------------------------------------------------------------------


def command(*arguments):
    app = Application()
    app.command("obstacles")(obstacles)
    return CliRunner().invoke(app, list(arguments))


def test_the_command_prints_one_json_object_with_the_outcome():
    result = command("--runs", "1", "--seed", "20", "--moving", "1", "--json", "--quiet")
    assert result.exit_code == 0
    figures = json.loads(result.stdout)
    wanted = {"runs", "collisions", "deadlocks", "refused", "arrived_together", "arrival_spread_p95_s"}
    assert figures.keys() >= wanted | {"time_ratio_median", "min_distance_m", "contacts", "failed_seeds"}
    assert figures["runs"] == figures["arrived"] == 1
    assert figures["first_seed"] == 20
    assert figures["moving"] == 1
    assert figures["contacts_caused"] == 0
    again = json.loads(json.dumps(stress_obstacles(COMMITTED, (20,), moving=1).summary()))
    assert figures.items() >= again.items()


def test_the_command_prints_a_table(monkeypatch):
    monkeypatch.setattr(obstaclecourse.ObstacleOutcome, "limit", 0.2)
    result = command("--runs", "1", "--quiet")
    assert result.exit_code == 0
    assert "min_clearance_m" in result.stdout


@pytest.mark.parametrize(
    "arguments",
    [("--runs", "0"), ("--class", "C"), ("--robots", "2"), ("--loss", "2"), ("--moving", "-1")],
)
def test_bad_options_are_refused(arguments):
    assert command(*arguments).exit_code == 2


def walls(seeds, robot):
    """A straight lane of 4.75 m for each seed, with a thin wall across it that a robot goes round."""
    model, rows = load_robot(robot), []
    for seed in seeds:
        rng = np.random.default_rng(seed)
        top, lean, bottom = rng.uniform(0.1, 0.8), rng.uniform(-0.3, 0.3), rng.uniform(-0.8, 0.0)
        rows.append(World(obstacles=(Wall(points=((2.37, bottom), (2.37 + lean, top))),), known=False))
    lane = quintic_table(Quintic(start=(0.0, 0.0), end=(4.75 / growth(model), 0.0)))
    setting = drawn_ensemble("walls", [[lane]] * len(rows), ObstacleOutcome.limit, 4.75, UNDISTURBED, model)
    return replace(setting, world=compile_worlds(rows))


def test_a_robot_without_eyes_behind_remembers_the_wall_that_it_goes_round(monkeypatch):
    """The cause taken away: a Pioneer, whose sonars look ahead, turns into the end of the wall beside its tail."""
    seeds, law = range(70_000, 70_060), make_controller("fuzzy-team")
    setting = walls(seeds, "pioneer-3dx")
    outcome = run_ensemble(ObstacleOutcome, setting, law, seeds)
    assert outcome.succeeded.all()
    monkeypatch.setattr(clearances, "REMEMBERED", -1.0)  # which compiled code has taken for a constant
    assert run_ensemble(ObstacleOutcome, setting, InterpretedTeam(), seeds).hit.sum() > 10


@pytest.mark.parametrize("robot", ["turtlebot3-burger", "pioneer-3dx", "mir100"])
def test_courses_grow_with_the_robot(robot):
    size = load_robot(robot).robot.turning_circle / load_robot("etsro").robot.turning_circle
    small = obstacle_ensemble((4,), "A", 1, moving=1)
    large = obstacle_ensemble((4,), "A", 1, moving=1, robot=load_robot(robot))
    assert growth(load_robot(robot)) == size
    np.testing.assert_allclose(large.references.joined.lengths, size * small.references.joined.lengths)
    for time in (0.0, 20.0):
        one, other = (s.world.at(time * s_).circles[0] for s, s_ in ((small, 1.0), (large, size)))
        np.testing.assert_allclose(other[:, :2], size * one[:, :2], atol=1e-9)
    curves = [s.references.joined.at(0.4 * s.references.joined.lengths).curvature for s in (small, large)]
    np.testing.assert_allclose(curves[1], curves[0] / size, rtol=1e-6)


def test_the_command_drives_another_robot_and_refuses_what_is_none():
    app = Application()
    app.command()(obstacles)
    told = CliRunner().invoke(app, ["--runs", "2", "--robot", "pioneer-3dx", "-c", "fuzzy-team", "--json", "-q"])
    assert json.loads(told.stdout)["robot"] == "pioneer-3dx"
    assert json.loads(told.stdout)["contacts"] == 0
    refused = CliRunner().invoke(app, ["--runs", "2", "--robot", "pioneer"])
    assert refused.exit_code
    assert "pioneer-3dx" in str(refused.exception) + refused.output
