"""What rule bases demand of robots: the speeds and turn rates that they ask for, beside those that there are."""

from collections.abc import Sequence
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from fuzzy.inference import forgiving, infer
from fuzzy.insight.coverage import spread_points
from fuzzy.insight.universe import universe_grid
from fuzzy.system import Sugeno
from robotics.laws.law import Law
from robotics.laws.tracking.fuzzy_tracking import rule_base_files
from robotics.world.vehicle.robot import Robot

_POINTS = 4096  # of the universe, at which a rule base is asked
_CORNERS = 10  # inputs, of which all corners of the universe are asked, too
_FINE = 4001  # of a single input


class RuleDemand(NamedTuple):
    """The speeds, or the turn rates, that a rule base asks for on the universe of its inputs."""

    rule_base: str  # its name, or its file
    output: str  # "v" or "w"
    values: np.ndarray  # (points,) m/s or rad/s, at points spread evenly; without those where no rule fires
    packaged: bool  # whether it comes with a package, and was not made for this scenario

    @property
    def unit(self) -> str:
        """That of the values."""
        return "m/s" if self.output == "v" else "rad/s"

    @property
    def span(self) -> tuple[float, float]:
        """The least and the greatest value."""
        return float(self.values.min()), float(self.values.max())

    def beyond(self, robot: Robot) -> str:
        """In words what a robot lacks of it, such as "2.5 m/s; its wheels end at 0.825 m/s"; "" where it has all."""
        wheels = robot.wheel_speed_limit / (1.0 if self.output == "v" else robot.half_axle)
        own = robot.v_max if self.output == "v" else robot.w_max
        most = min(own, wheels)
        over = np.abs(self.values) > most * (1 + 1e-6)
        if not over.any():
            return ""
        greatest = self.values[np.abs(self.values).argmax()]
        what = "its wheels end" if wheels < own else f"its {self.output}_max is"
        share = f"in {max(100 * over.mean(), 0.1):.2g} % of its universe it asks for more"
        return f"{greatest:.3g} {self.unit}; {what} {'at ' * (wheels < own)}{most:.3g} {self.unit}, and {share}"


def rule_demands(law: Law[Any]) -> list[RuleDemand]:
    """What the rule bases of a law ask for that give speeds and turn rates themselves, ``v`` and ``w``."""
    packaged, found = rule_base_files(), []
    for task, fis in law.fuzzy_systems.items():
        named = getattr(law, law.tasks.get(task, ""), fis.name)
        name = named if isinstance(named, str) else fis.name
        values = _asked(fis)
        for place, output in enumerate(variable.name for variable in fis.outputs):
            known = values[np.isfinite(values[:, place]), place]
            if output in ("v", "w") and known.size:
                found.append(RuleDemand(name, output, known, name in packaged))
    return found


def _asked(fis: Sugeno) -> np.ndarray:
    """The outputs (points, outputs) at points spread evenly over the universe and, of few inputs, in its corners."""
    if len(fis.inputs) == 1:
        points = universe_grid(fis.inputs[0], _FINE)[:, None]
    else:
        points = spread_points(fis, _POINTS)
    if len(fis.inputs) <= _CORNERS:
        corners: Sequence[tuple[float, ...]] = list(product(*(variable.universe for variable in fis.inputs)))
        points = np.concatenate([points, np.array(corners)])
    return np.asarray(infer(forgiving(fis, "nan"), points).output)
