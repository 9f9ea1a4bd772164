"""Changes that no law is told of: how robust each is without being tuned anew."""

from collections.abc import Callable, Mapping
from dataclasses import replace

from robotics.laws.setting import TrueParameters
from robotics.scenario.description import Scenario
from robotics.vehicle.robot import Robot

_SHARE = 0.2  # by which a robot's numbers differ from what is believed
_TIMES = 2  # by which latency and noise do

Changed = tuple[Scenario, TrueParameters | None]  # the scenario, and what is so where laws are told otherwise


def _robot(change: Callable[[Robot], Robot]) -> Callable[[Scenario], Changed]:
    def changed(scenario: Scenario) -> Changed:
        robots = tuple(change(member.robot) for member in scenario.robots)
        return scenario, TrueParameters(robots=robots, latency=scenario.latency)

    return changed


def _mass(factor: float) -> Callable[[Robot], Robot]:
    """The whole robot's mass, with the inertia that goes with it."""
    return lambda r: replace(
        r,
        body_mass=factor * r.body_mass,
        body_inertia=factor * r.body_inertia,
        wheel_mass=factor * r.wheel_mass,
        wheel_inertia=factor * r.wheel_inertia,
        wheel_spin_inertia=factor * r.wheel_spin_inertia,
    )


def _radius(factor: float) -> Callable[[Robot], Robot]:
    return lambda r: replace(r, wheel_radius=factor * r.wheel_radius)


def _friction(factor: float) -> Callable[[Robot], Robot]:
    return lambda r: replace(r, friction_torque=factor * r.friction_torque)


def _latency(scenario: Scenario) -> Changed:
    robots = tuple(member.robot for member in scenario.robots)
    return scenario, TrueParameters(robots=robots, latency=_TIMES * scenario.latency)


def _noise(scenario: Scenario) -> Changed:
    sensing = scenario.sensing
    noisier = replace(
        sensing,
        position_noise=_TIMES * sensing.position_noise,
        heading_noise=_TIMES * sensing.heading_noise,
    )
    return replace(scenario, sensing=noisier), None


CHANGES: Mapping[str, Callable[[Scenario], Changed]] = {
    "mass +20 %": _robot(_mass(1 + _SHARE)),
    "mass -20 %": _robot(_mass(1 - _SHARE)),
    "wheels +20 %": _robot(_radius(1 + _SHARE)),
    "wheels -20 %": _robot(_radius(1 - _SHARE)),
    "friction +20 %": _robot(_friction(1 + _SHARE)),
    "friction -20 %": _robot(_friction(1 - _SHARE)),
    f"latency ×{_TIMES}": _latency,
    f"noise ×{_TIMES}": _noise,
}


def changed(scenario: Scenario, change: str) -> Changed:
    """A scenario in which something is otherwise than laws believe; "" changes nothing."""
    return CHANGES[change](scenario) if change else (scenario, None)
