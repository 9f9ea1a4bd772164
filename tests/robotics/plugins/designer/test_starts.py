"""The wall follower follows walls, inside and outside; without its rules it does not."""

from dataclasses import replace

import numpy as np
import pytest

import fuzzy
import robotics
from fuzzy.plugins.designer.starts.packaged import packaged
from robotics.plugins.designer.starts import starts

SCENARIO = """
duration = 60.0
divergence = 50.0
[sensing]
posture = "pose"
[[robots]]
start = [0.0, 0.7, -0.2]
path = { shape = "line", start = [0.0, 0.55], end = [4.4, 0.55] }
timing = { speed = 0.2 }
[[obstacles]]
"""
ROOM = 'shape = "wall"\npoints = [[-1.0, 0.0], [5.0, 0.0], [5.0, 4.0], [-1.0, 4.0], [-1.0, 0.0]]\nposition = [0.0, 0.0]'
BOX = 'shape = "box"\nlength = 3.0\nwidth = 2.0\nposition = [0.5, -1.0]'


def driven(folder, fis, obstacle):
    """The distance of the robot's middle from the wall, over time, and the rounds about the middle of the obstacle."""
    fuzzy.write_fis(fis, folder / "mine.fis")
    scenario = robotics.parse_scenario(SCENARIO + obstacle, "walls")
    run = robotics.simulate(scenario, f"fuzzy:rule_base={folder / 'mine.fis'}", seeds=[0])
    x, y = run.samples[:, 0, 0, 0], run.samples[:, 1, 0, 0]
    if obstacle == ROOM:
        middle, distance = (2.0, 2.0), np.min([x + 1, 5 - x, y, 4 - y], axis=0)
    else:
        middle, distance = (0.5, -1.0), np.hypot(np.clip(abs(x - 0.5) - 1.5, 0, None), np.clip(abs(y + 1) - 1, 0, None))
    angle = np.unwrap(np.arctan2(y - middle[1], x - middle[0]))
    return distance, (angle[-1] - angle[0]) / (2 * np.pi)


@pytest.mark.long
@pytest.mark.parametrize(("obstacle", "rounds"), [(ROOM, 0.8), (BOX, -1.0)])
def test_the_wall_follower_follows_a_wall_and_only_by_its_rules(obstacle, rounds, tmp_path):
    fis = packaged("wall-follower")
    distance, driven_rounds = driven(tmp_path, fis, obstacle)
    assert driven_rounds / rounds > 1  # counter-clockwise in a room, clockwise round a box: the wall is on the right
    late = distance[len(distance) // 4 :]
    assert 0.4 < np.median(late) < 0.55  # 0.3 m beside the circle of 0.152 m in which it turns
    assert late.min() > 0.16  # at an outer corner the sensors lose the wall for a moment
    assert late.max() < 0.6
    # Where no rule turns it, it leaves the wall, or comes to touch it.
    straight = [replace(rule, then=(("v", "cruise"), ("w", "straight"))) for rule in fis.rules]
    distance, driven_rounds = driven(tmp_path, replace(fis, rules=tuple(straight)), obstacle)
    assert abs(driven_rounds) < 0.6
    late = distance[len(distance) // 4 :]
    assert late.min() < 0.1 or late.max() > 1


def test_the_tracking_start_is_the_shipped_rule_base():
    made = {start.name: start.made({}, "mine") for start in starts()}
    assert [v.name for v in made["tracking"].outputs] == ["v", "w"]
    assert made["tracking"] == packaged("tracking")
    assert made["wall-follower"].name == "wall-follower"
