"""The EtsRo: a differential-drive robot, its motors, encoders, wheel loops and limits.

Sources: thesis 2.1.3.1 (set-up) and 2.1.3.2 (dynamic parameters). Values that the thesis leaves open are marked
"assumed"; the motor is fitted to its 7.5 V and 175 rpm. Where two figures contradict each other (the wheel radius 4.5
or 4.0 cm, the speed limit 1.12 m/s against 175 rpm), the field's comment says which of them is used.
"""

from dataclasses import dataclass
from math import pi

from fuzzy.errors import InputError
from robotics.quantity import check_quantities, quantity


class RobotError(InputError):
    """A robot that cannot be built. The message names the parameter, its value and what is accepted."""


@dataclass(frozen=True, kw_only=True)
class Robot:
    """Parameters of one robot, in SI units. Axes: x forward, y left, heading counter-clockwise (REP 103)."""

    # Body: thesis 2.1.3.2
    body_mass: float = quantity(2.3, "kg", above=0)  # m_c, without the driving wheels
    wheel_mass: float = quantity(0.28, "kg", above=0)  # m_w, each wheel with its rotor
    body_inertia: float = quantity(0.01, "kg m²", above=0)  # I_c, about the body's own center of mass
    wheel_inertia: float = quantity(0.0021, "kg m²", above=0)  # I_m, each wheel about its diameter
    wheel_spin_inertia: float = quantity(2.8e-4, "kg m²", least=0)  # about the axle: m_w r²/2 (assumed)
    half_axle: float = quantity(0.10, "m", above=0, most=10)  # L in (2.3)-(2.19); 2 L lies between the wheels
    mass_offset: float = quantity(-0.02, "m", least=-10, most=10)  # d: axle to center of mass; < 0: behind it
    wheel_radius: float = quantity(0.045, "m", above=0, most=1)  # r of 2.1.3.1; 2.1.3.2 says 0.04
    length: float = quantity(0.23, "m", above=0, most=10)  # along the heading
    width: float = quantity(0.20, "m", above=0, most=10)
    # Motors: 7.5 V, 175 rpm without load; stall torque 0.70 N m at the wheel (assumed)
    supply_voltage: float = quantity(7.5, "V", above=0)
    torque_constant: float = quantity(0.0933, "N m/V", above=0)  # at the wheel: stall torque / supply voltage
    back_emf: float = quantity(0.409, "V s/rad", above=0)  # supply voltage / no-load speed
    torque_limit: float = quantity(0.35, "N m", above=0)  # a wheel: about where the tyre slips (assumed)
    friction_torque: float = quantity(0.02, "N m", least=0)  # a wheel, Coulomb (assumed)
    friction_speed: float = quantity(
        0.2, "rad/s", above=0
    )  # the speed range over which friction changes sign (assumed)
    # Encoders and wheel loops, every 10 ms (gains tuned: overshoot below 6 %, 2 % settling below 0.35 s)
    counts_per_turn: float = quantity(6000.0, "counts", above=0)
    kp: float = quantity(0.8, "V s/rad", least=0)
    ki: float = quantity(9.0, "V/rad", least=0)
    kd: float = quantity(0.0, "V s²/rad", least=0)  # on the measured speed
    filter_frequency: float = quantity(0.0, "Hz", least=0, most=49)  # low-pass on the wheel speed; 0: none
    # Limits of the command
    v_max: float = quantity(1.12, "m/s", above=0)  # 2.1.3.1; never reached: the wheels end at 0.825 m/s
    w_max: float = quantity(5.74, "rad/s", above=0)  # 2.1.3.1
    wheel_speed_max: float = quantity(175 * 2 * pi / 60, "rad/s", above=0)  # 175 rpm
    # Bounds of (5.1), of a commanded velocity only: how fast it may change. None: at once; the thesis gives no numbers
    v_rate_max: float | None = quantity(None, "m/s²", above=0)
    w_rate_max: float | None = quantity(None, "rad/s²", above=0)

    def __post_init__(self) -> None:
        check_quantities(self, RobotError)

    @property
    def mass(self) -> float:
        """m = m_c + 2 m_w [kg]   thesis (2.3)."""
        return self.body_mass + 2 * self.wheel_mass

    @property
    def yaw_inertia(self) -> float:
        """I0 about the axle midpoint [kg m²]: I_c + m_c d² + 2 m_w L² + 2 I_m.

        Thesis (2.3) has 2 m_w d², which is the inertia about the body's center of mass instead.
        """
        return (
            self.body_inertia
            + self.body_mass * self.mass_offset**2
            + 2 * self.wheel_mass * self.half_axle**2
            + 2 * self.wheel_inertia
        )

    @property
    def effective_mass(self) -> float:
        """m + 2 J_w / r² [kg]: the mass that the wheels' torques accelerate forwards."""
        return self.mass + 2 * self.wheel_spin_inertia / self.wheel_radius**2

    @property
    def effective_inertia(self) -> float:
        """I0 + 2 J_w L² / r² [kg m²]: the inertia that the wheels' torques turn."""
        return self.yaw_inertia + 2 * self.wheel_spin_inertia * (self.half_axle / self.wheel_radius) ** 2

    @property
    def wheel_speed_limit(self) -> float:
        """The highest speed of a wheel over the ground [m/s]; |v| + L |ω| cannot exceed it."""
        return self.wheel_radius * self.wheel_speed_max
