"""The inverse dynamics of many robots: the wheel torques that give an acceleration."""

from collections.abc import Sequence

from fuzzy.compiled.columns import Columns, column
from fuzzy.compiled.jit import compiled_only
from robotics.world.vehicle.robot import Robot


class DynamicsColumns(Columns):
    """The inverse dynamics (2.19) of a robot for a center of mass on the axle (d = 0)."""

    mass = column("kg")
    inertia = column("kg m²")
    radius = column("m", "of the wheels")
    half_axle = column("m")


def nominal_dynamics(robots: Sequence[Robot]) -> dict[str, list[float]]:
    """Take the mass and the inertia of thesis (2.3) for d = 0, as in (2.10); the laws of chapter 2 know these."""
    inertia = [r.body_inertia + 2 * r.wheel_mass * r.half_axle**2 + 2 * r.wheel_inertia for r in robots]
    return _dynamics(robots, [r.mass for r in robots], inertia)


def effective_dynamics(robots: Sequence[Robot]) -> dict[str, list[float]]:
    """Take all that the wheels' torques accelerate and turn: also the spinning wheels, and d in the inertia."""
    return _dynamics(robots, [r.effective_mass for r in robots], [r.effective_inertia for r in robots])


def _dynamics(robots: Sequence[Robot], mass: list[float], inertia: list[float]) -> dict[str, list[float]]:
    """The columns of DynamicsColumns, each of all robots."""
    radius, half_axle = [r.wheel_radius for r in robots], [r.half_axle for r in robots]
    return {"mass": mass, "inertia": inertia, "radius": radius, "half_axle": half_axle}


@compiled_only
def wheel_torques(acceleration, turning, dynamics: DynamicsColumns):  # type: ignore[no-untyped-def]
    """The torques of the right and the left wheel [N m] for v' [m/s²] and ω' [rad/s²] of one robot.

    τ = Γ⁻¹ u',  Γ⁻¹ = r/(2L) [L m, I; L m, −I]   thesis (2.19)

    Its ``dynamics`` are as DynamicsColumns.
    """
    common = dynamics.radius * dynamics.mass / 2 * acceleration
    apart = dynamics.radius * dynamics.inertia / (2 * dynamics.half_axle) * turning
    return common + apart, common - apart
