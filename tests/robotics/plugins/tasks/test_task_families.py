"""Families of teams: the same number is the same run, blocks are disjoint, and what is drawn is what was asked for."""

from typing import Any

import numpy as np
import pytest

from robotics.plugins.arena.kinds import load_plan, parse_plan
from robotics.plugins.arena.plan import BLOCKS, ArenaError
from robotics.plugins.tasks.families import TaskFamily
from robotics.plugins.tasks.layouts import TASKS, draw_layout

TEXT = """
kind = "tasks"
laws = ["stop-and-wait", "right-of-way"]
engines = ["cmaes"]
move = ["gains"]
evaluations = 3
repeats = 1
[[tune]]
task = "crossing"
most = 3
[[choose]]
task = "crossing"
most = 3
[[test]]
task = "crossing"
count = 4
most = 3
latency = 0.3
[[test]]
task = "course"
count = 3
most = 3
held_up = 0.5
"""


def facts(scenario):
    paths = scenario.setting.references.joined
    return scenario.facts, scenario.seed, np.concatenate([paths.lengths.ravel(), scenario.setting.starts.ravel()])


@pytest.mark.parametrize("task", TASKS)
def test_a_number_is_a_run_whatever_else_is_drawn(task):
    family = TaskFamily(task=task, fewest=3, most=4, loss=0.4, latency=0.6, held_up=0.5, silent=0.5)
    first, other = facts(family.scenario(3_000_001)), facts(family.scenario(3_000_002))
    again = facts(
        TaskFamily(task=task, fewest=3, most=4, loss=0.4, latency=0.6, held_up=0.5, silent=0.5, count=9).scenario(
            3_000_001
        )
    )
    assert first[:2] == again[:2]
    np.testing.assert_array_equal(first[2], again[2])
    assert first[0] != other[0]


@pytest.mark.parametrize("task", TASKS)
def test_starts_are_apart_and_off_all_obstacles(task):
    family = TaskFamily(task=task, fewest=4, most=4)
    for number in range(5):
        scenario = family.scenario(number)
        starts = scenario.setting.starts[0, :, :2]
        away = np.hypot(*(starts[:, None] - starts[None]).transpose(2, 0, 1))[np.triu_indices(4, 1)]
        assert away.min() > 2 * scenario.setting.robots[0].turning_circle


def test_what_is_drawn_lies_between_what_was_asked_for():
    models = ("etsro", "pioneer-3dx", "turtlebot3-burger", "mir100")
    family = TaskFamily(
        task="crossing", fewest=3, most=5, models=models, loss=0.4, latency=0.6, held_up=0.5, silent=0.5
    )
    drawn = [family.scenario(number).facts for number in range(60)]
    assert {row["robots"] for row in drawn} == {3, 4, 5}
    assert {row["model"] for row in drawn} == {*models}
    for name, most in (("loss", 0.4), ("latency_s", 0.6)):
        values = [row[name] for row in drawn]
        assert min(values) < 0.15 * most
        assert 0.85 * most < max(values) <= most
    held = [row["held_up_s"] for row in drawn if row["held_up_s"]]
    assert 18 < len(held) < 42
    assert 2 <= min(held) < max(held) <= 8


def test_a_corridor_has_room_and_a_gate_is_crossed_by_all():
    rng = np.random.default_rng(1)
    corridor, gate = (draw_layout(task, rng, 5, 0) for task in ("corridor", "gate"))
    assert len(corridor.obstacles) == len(gate.obstacles) == 2
    first = np.array([table[0, 0] for table in corridor.tables])
    last = np.array([table[0, -1] for table in corridor.tables])
    assert (np.sign(first) == -np.sign(last)).all()
    assert len({*np.sign(first)}) == 2
    through = [table[1, np.argmin(abs(table[0]))] for table in gate.tables]
    assert np.ptp(through) < 0.1


@pytest.mark.parametrize("name", ["tasks", "tasks-demo"])
def test_the_blocks_of_the_packaged_arenas_have_nothing_in_common(name):
    plan: Any = load_plan(name)
    numbers = {
        block: {plan.scenario(block, place, repeat).seed for place in (0, plan.count(block) - 1) for repeat in range(2)}
        for block in BLOCKS
    }
    for block, first in BLOCKS.items():
        assert all(first <= number < first + 1_000_000 for number in numbers[block])
    spans = [range(first, first + plan.count(block) * plan.repeats) for block, first in BLOCKS.items()]
    assert not any({*a} & {*b} for k, a in enumerate(spans) for b in spans[:k])


def test_the_packaged_arena_has_what_is_asked_of_it():
    plan: Any = load_plan("tasks")
    test = plan.test
    assert {family.task for family in test} == {*TASKS}
    assert max(family.most for family in test) == 10
    assert min(family.fewest for family in test) == 3
    assert max(family.loss for family in test) == 0.4
    assert max(family.latency for family in test) == 0.6
    assert {model for family in test for model in family.models} == {
        "etsro",
        "pioneer-3dx",
        "turtlebot3-burger",
        "mir100",
    }
    assert any(family.held_up for family in test)
    assert any(family.silent for family in test)
    assert any(family.discs for family in test)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('kind = "tasks"', 'kind = "task"', r":2: unknown kind of arena 'task'; did you mean 'tasks'"),
        (
            '"stop-and-wait"',
            '"stop-an-wait"',
            r":3: laws: unknown controller 'stop-an-wait'; did you mean 'stop-and-wait'",
        ),
        ("latency = 0.3", "latency = -1", r":18: latency must be"),
        ("latency = 0.3", "latence = 0.3", r":18: unknown key 'latence'; did you mean 'latency'"),
        ('task = "course"', 'task = "curse"', r":20: task must be one of 'lanes'"),
        ("held_up = 0.5", "held_up = 1.5", r":23: held_up must be"),
        ("held_up = 0.5", "fewest = 5", r"fewest must be <= most, 3; got 5"),
        ("held_up = 0.5", 'models = ["etsro", "etsr"]', r":23: models: "),
        ("latency = 0.3", "discs = 2", r":18: discs belong to course, joined and trap"),
    ],
)
def test_what_is_wrong_with_a_file_is_said_with_its_line(old, new, message):
    with pytest.raises(ArenaError, match=message):
        parse_plan(TEXT.replace(old, new, 1), file="mine.toml")
