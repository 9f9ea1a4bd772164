"""Changes that no law is told of: how robust each is without being tuned anew."""

from collections.abc import Callable, Mapping
from dataclasses import replace

from robotics.laws.setting import TrueParameters
from robotics.simulation.scenario.description import Scenario

_SHARE = 0.2  # by which a robot's numbers differ from what is believed
_TIMES = 2  # by which latency and noise do
_WRONG = 0.01  # standard deviation of the wheels and the axle that odometry assumes, over seeds
# The whole robot's mass, with the inertia that goes with it
_MASS = ("body_mass", "body_inertia", "wheel_mass", "wheel_inertia", "wheel_spin_inertia")

Changed = tuple[Scenario, TrueParameters | None]  # the scenario, and what is so where laws are told otherwise


def _robot(factor: float, *numbers: str) -> Callable[[Scenario], Changed]:
    """A change of all robots: some of their numbers are multiplied."""

    def changed(scenario: Scenario) -> Changed:
        robots = (member.robot for member in scenario.robots)
        others = tuple(replace(r, **{name: factor * getattr(r, name) for name in numbers}) for r in robots)
        return scenario, TrueParameters(robots=others, latency=scenario.latency)

    return changed


def _latency(scenario: Scenario) -> Changed:
    robots = tuple(member.robot for member in scenario.robots)
    return scenario, TrueParameters(robots=robots, latency=_TIMES * scenario.latency)


def _noise(scenario: Scenario) -> Changed:
    sensing = scenario.sensing
    noise = {name: _TIMES * getattr(sensing, name) for name in ("position_noise", "heading_noise")}
    return replace(scenario, sensing=replace(sensing, **noise)), None


def _encoders(scenario: Scenario) -> Changed:
    return replace(scenario, sensing=replace(scenario.sensing, wheel_error=_WRONG, axle_error=_WRONG)), None


CHANGES: Mapping[str, Callable[[Scenario], Changed]] = {
    "mass +20 %": _robot(1 + _SHARE, *_MASS),
    "mass -20 %": _robot(1 - _SHARE, *_MASS),
    "wheels +20 %": _robot(1 + _SHARE, "wheel_radius"),
    "wheels -20 %": _robot(1 - _SHARE, "wheel_radius"),
    "friction +20 %": _robot(1 + _SHARE, "friction_torque"),
    "friction -20 %": _robot(1 - _SHARE, "friction_torque"),
    f"latency ×{_TIMES}": _latency,
    f"noise ×{_TIMES}": _noise,
    f"encoders ±{_WRONG:.0%}": _encoders,
}


def changed(scenario: Scenario, change: str) -> Changed:
    """A scenario in which something is otherwise than laws believe; "" changes nothing."""
    return CHANGES[change](scenario) if change else (scenario, None)
