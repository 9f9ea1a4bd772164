"""Small formations for tests."""

from math import cos, pi, sin

from robotics.simulation.scenario.description import Scenario
from robotics.simulation.scenario.reading import parse_scenario

RADII = (2.0, 2.5, 1.6)  # m


def circling(*, speed: float = 0.2, duration: float = 30.0, second: float = 0.0, turns: float = 1.0) -> Scenario:
    """A leader and two followers on concentric circles; robot 2 begins ``second`` [rad] ahead of where it should be."""
    text = f'kind = "formation"\nduration = {duration}\nplant = "kinematic"\n[sensing]\nposture = "pose"\n'
    for i, radius in enumerate(RADII):
        angle = second if i == 1 else 0.0
        text += f"""
        [[robots]]
        path = {{ shape = "circle", radius = {radius}, turns = {turns} }}
        timing = {{ duration = {2 * pi * turns * RADII[0] / speed!r} }}
        start = [{radius * cos(angle)!r}, {radius * sin(angle)!r}, {angle + pi / 2!r}]
        """
    return parse_scenario(text, "circling")
