"""A scenario in few words: the group in which lists show it, and its noise."""

from collections.abc import Callable
from math import degrees
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from robotics.simulation.scenario.description import Scenario

# The groups of scenarios in the order of lists
_ONE, GOALS, FORMATIONS, TEAMS, MEETINGS, AMONG_OBSTACLES = CONDITION_GROUPS = (
    "One robot",
    "Goals: robots come to a place at no stated time",
    "Formations: followers keep to a leader",
    "Teams: all arrive together",
    "Meetings: robots on time would touch",
    "Obstacles: unknown to the robots",
)


def group_of(scenario: "Scenario") -> str:
    """The one of CONDITION_GROUPS to which a scenario belongs."""
    return group(scenario.kind, len(scenario.robots), bool(scenario.obstacles), lambda: touch_on_time(scenario))


def group(kind: str, robots: int, obstacles: bool, meet: Callable[[], bool]) -> str:
    """The same from what its file says; whether robots on time ``meet`` is asked only where that decides."""
    if kind == "goal":
        return GOALS
    if robots == 1:
        return _ONE
    if obstacles:
        return AMONG_OBSTACLES
    if kind == "formation":
        return FORMATIONS
    return MEETINGS if meet() else TEAMS


def touch_on_time(scenario: "Scenario") -> bool:
    """Whether two references come nearer to each other than the robots are long."""
    import numpy as np  # for which those who list scenarios do not wait

    on = scenario.trajectory.sampled(np.arange(scenario.ticks + 1) * scenario.period)
    half = np.array([member.robot.length / 2 for member in scenario.robots])
    apart = np.hypot(on.x[:, :, None] - on.x[:, None], on.y[:, :, None] - on.y[:, None])
    pairs = np.triu_indices(len(half), 1)
    return bool((apart < half[:, None] + half)[:, *pairs].any())


def noises(scenario: "Scenario") -> list[str]:
    """What is drawn at random in a scenario, in words with the largest values; empty where there is no noise."""
    import numpy as np

    def most(name: str) -> float:
        return max(float(getattr(each, name)) for each in scenario.setting.sensing)

    found = [
        (most("position_noise"), "position ± {:g} mm", 1e3),
        (most("heading_noise"), "heading ± {:.2g}°", degrees(1)),
        (most("relative_noise"), "x and y ± {:g} %", 100),
        (max(most("wheel_error"), most("axle_error")), "wheels and axle ± {:g} %", 100),
        (most("start_position"), "start ± {:g} mm", 1e3),
        (most("start_heading"), "heading at the start ± {:.2g}°", degrees(1)),
    ]
    spread = np.max([member.start_spread for member in scenario.robots], axis=0)
    if spread.any():
        sizes = f"{spread[0]:g} and {spread[1]:g} m and {degrees(spread[2]):.3g}°"
        found.append((1.0, f"starts up to {sizes} to both sides", 1.0))
    words = [text.format(round(size * factor, 6)) for size, text, factor in found if size > 0]
    carried = [sensor for sensors in scenario.setting.sensors for sensor in sensors.values()]
    if scenario.obstacles and any(s.noise or s.relative_noise or s.dropout or s.crosstalk for s in carried):
        words.append("range sensors")
    radio = scenario.radio
    if scenario.kind == "team" and (radio.loss or radio.burst_start):
        words.append("lost messages")
    if scenario.kind == "team" and radio.jitter:
        words.append(f"messages late by up to {radio.jitter:g} s")
    return words
