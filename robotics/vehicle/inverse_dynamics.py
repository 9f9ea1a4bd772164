"""The inverse dynamics of many robots: the wheel torques that give an acceleration."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from fuzzy.compiled.columns import Columns, column
from fuzzy.compiled.jit import compiled_only
from robotics.vehicle.robot import Robot


class InverseDynamics(NamedTuple):
    """The inverse dynamics (2.19) for a center of mass on the axle (d = 0); each field is (robots,)."""

    mass: np.ndarray  # kg
    inertia: np.ndarray  # kg m²
    radius: np.ndarray  # m, of the wheels
    half_axle: np.ndarray  # m

    @classmethod
    def nominal(cls, robots: Sequence[Robot]) -> "InverseDynamics":
        """Take the mass and the inertia of thesis (2.3) for d = 0, as in (2.10); the laws of chapter 2 know these."""
        inertia = [r.body_inertia + 2 * r.wheel_mass * r.half_axle**2 + 2 * r.wheel_inertia for r in robots]
        return cls._of(robots, [r.mass for r in robots], inertia)

    @classmethod
    def effective(cls, robots: Sequence[Robot]) -> "InverseDynamics":
        """Take all that the wheels' torques accelerate and turn: also the spinning wheels, and d in the inertia."""
        return cls._of(robots, [r.effective_mass for r in robots], [r.effective_inertia for r in robots])

    @classmethod
    def _of(cls, robots: Sequence[Robot], mass: Sequence[float], inertia: Sequence[float]) -> "InverseDynamics":
        radii, axles = [r.wheel_radius for r in robots], [r.half_axle for r in robots]
        return cls(*(np.array(row) for row in (mass, inertia, radii, axles)))


class DynamicsColumns(Columns):
    """The same of one robot, for compiled functions."""

    mass = column("kg")
    inertia = column("kg m²")
    radius = column("m", "of the wheels")
    half_axle = column("m")


@compiled_only
def wheel_torques(acceleration, turning, dynamics: DynamicsColumns):  # type: ignore[no-untyped-def]
    """The torques of the right and the left wheel [N m] for v' [m/s²] and ω' [rad/s²] of one robot.

    τ = Γ⁻¹ u',  Γ⁻¹ = r/(2L) [L m, I; L m, −I]   thesis (2.19)

    Its ``dynamics`` are as DynamicsColumns.
    """
    common = dynamics.radius * dynamics.mass / 2 * acceleration
    apart = dynamics.radius * dynamics.inertia / (2 * dynamics.half_axle) * turning
    return common + apart, common - apart
