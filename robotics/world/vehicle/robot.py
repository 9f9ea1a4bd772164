"""A differential-drive robot: its body, wheels, motors, encoders, wheel loops and limits.

A robot is given by the numbers that its maker states and that nothing else implies: mass, size, wheels, motors,
encoders. What is left out follows from them by the rule that stands beside its field (:attr:`Robot.derived` tells which
did); no robot has another one's numbers. Those of packaged robots, with their sources, are the files of
``robotics/data/robots/``, which :func:`robotics.load_robot` reads.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from math import hypot, inf
from typing import Any, ClassVar, NamedTuple

from fuzzy.errors import InputError
from fuzzy.quantity import check_quantities, quantity

GRAVITY = 9.81  # m/s²
GRIP = 0.55  # 1: rubber grips hard floors with 0.8, and castors bear about 30 % of the weight
ROLLING = 0.02  # 1: rolling resistance over weight; small rubber wheels on hard floors have 0.01 to 0.035
ROTOR = 0.01  # s: mechanical time constant of small motors without load; data sheets have 3 to 20 ms
FASTEST_LOOP = 0.04  # s: four periods of the wheel loop, so that its sampling does not matter
STIFFEST = 1000.0  # 1/s: the plant's Runge-Kutta steps of 2.5 ms are stable up to 2.78 / 2.5 ms


class RobotError(InputError):
    """A robot that cannot be built. The message names the parameter, its value and what is accepted."""


class DerivationRule(NamedTuple):
    """How a number follows from others, where it is not given."""

    says: str  # a formula in the names of fields, and its reason
    value: Callable[["Robot"], float]  # of a robot whose earlier fields are filled in


def _needed(unit: str, doc: str, **bounds: float) -> Any:
    """A field that nothing else implies."""
    return quantity(None, unit, doc=doc, **bounds)


def _derived(unit: str, doc: str, says: str, value: Callable[["Robot"], float], **bounds: float) -> Any:
    """A field that follows by a rule from the fields above it, where it is not given."""
    metadata = quantity(None, unit, doc=doc, **bounds).metadata
    return field(default=None, metadata={**metadata, "rule": DerivationRule(says, value)})


@dataclass(frozen=True, kw_only=True)
class Robot:
    """Parameters of one robot, in SI units. Axes: x forward, y left, heading counter-clockwise (REP 103).

    A number that is left out is derived by the ``rule`` in its field's metadata. ``dataclasses.replace`` keeps derived
    numbers as they are; :meth:`changed` derives them anew.

    Raises:
        RobotError: Numbers that are missing or wrong.
    """

    # Body
    body_mass: float = _needed(
        "kg", "The mass without the driving wheels (m_c); where wheel_mass is left out, of the whole robot.",
        above=0, example=2.0,
    )  # fmt: skip
    length: float = _needed(
        "m", "The size along the heading; the outline is a rectangle with its center at the axle midpoint.",
        above=0, most=10, example=0.25,
    )  # fmt: skip
    width: float = _needed("m", "The size across the heading, wheels included.", above=0, most=10, example=0.2)
    mass_offset: float = _derived(
        "m", "From the axle forward to the center of mass of the body (d); negative: it lies behind the axle.",
        "0: the center of mass is over the axle, as that of the outline is",
        lambda r: 0.0, least=-10, most=10, example=0.02,
    )  # fmt: skip
    body_inertia: float = _derived(
        "kg m²", "The inertia of the body about the vertical through its center of mass (I_c).",
        "body_mass (length² + width²) / 12: a box of even density",
        lambda r: r.body_mass * (r.length**2 + r.width**2) / 12, above=0, example=0.017,
    )  # fmt: skip
    # Wheels
    half_axle: float = _needed("m", "Half the distance between the driving wheels (L).", above=0, most=10, example=0.09)
    wheel_radius: float = _needed("m", "The radius of the driving wheels (r).", above=0, most=1, example=0.04)
    wheel_mass: float = _derived(
        "kg", "The mass of one driving wheel with its rotor (m_w).",
        "0: a data sheet's mass is the whole robot's, so that the wheels are part of body_mass",
        lambda r: 0.0, least=0, example=0.05,
    )  # fmt: skip
    wheel_inertia: float = _derived(
        "kg m²", "The inertia of a driving wheel about its diameter (I_m).",
        "wheel_mass wheel_radius² / 4: a thin disc",
        lambda r: r.wheel_mass * r.wheel_radius**2 / 4, least=0, example=2e-05,
    )  # fmt: skip
    # Motors, as they act at the wheel, behind the gear
    supply_voltage: float = _needed("V", "The voltage that the motors are driven with at most.", above=0, example=12.0)
    stall_torque: float | None = quantity(
        None, "N m", above=0, example=1.0,
        doc="The torque of one motor at standstill and full voltage, at the wheel; instead of torque_constant.",
    )  # fmt: skip
    no_load_speed: float | None = quantity(
        None, "rad/s", above=0, example=15.0,
        doc="The speed of one wheel at full voltage without load; instead of back_emf.",
    )  # fmt: skip
    torque_constant: float = _derived(
        "N m/V", "The stall torque at the wheel for each volt (k_t).",
        "stall_torque / supply_voltage", lambda r: (r.stall_torque or inf) / r.supply_voltage, above=0, example=0.083,
    )  # fmt: skip
    back_emf: float = _derived(
        "V s/rad", "The voltage for each rad/s of the wheel without load (k_e).",
        "supply_voltage / no_load_speed", lambda r: r.supply_voltage / (r.no_load_speed or inf), above=0, example=0.8,
    )  # fmt: skip
    wheel_spin_inertia: float = _derived(
        "kg m²", "The inertia of a driving wheel and of its rotor, behind the gear, about the axle (J_w).",
        f"wheel_mass wheel_radius² / 2 + {ROTOR:g} s torque_constant back_emf: a disc, and a rotor that alone takes up "
        "speed with the time constant of most small motors; behind a high gear it outweighs the robot",
        lambda r: r.wheel_mass * r.wheel_radius**2 / 2 + ROTOR * r.torque_constant * r.back_emf,
        least=0, example=0.0007,
    )  # fmt: skip
    torque_limit: float = _derived(
        "N m", "The highest torque of one wheel, where its tyre slips or its motor stalls.",
        f"the smaller of torque_constant supply_voltage, where the motor stalls, and of {GRIP:g} g wheel_radius "
        "(effective mass) / 2, where the tyre slips: rubber has 0.8 on hard floors, castors bear 30 % of the weight",
        lambda r: min(r.torque_constant * r.supply_voltage, GRIP * GRAVITY * r.wheel_load / r.wheel_radius),
        above=0, example=0.3,
    )  # fmt: skip
    friction_torque: float = _derived(
        "N m", "The dry (Coulomb) friction of one wheel with its gear.",
        f"{ROLLING:g} m g wheel_radius / 2: small rubber wheels on hard floors roll with 0.01 to 0.035 of the weight",
        lambda r: ROLLING * r.mass * GRAVITY * r.wheel_radius / 2, least=0, example=0.008,
    )  # fmt: skip
    friction_speed: float = _derived(
        "rad/s", "The range of wheel speeds over which the friction changes its sign.",
        "0.01 supply_voltage / back_emf: 1 % of the speed without load",
        lambda r: 0.01 * r.supply_voltage / r.back_emf, above=0, example=0.15,
    )  # fmt: skip
    # Encoders and wheel loops, every 10 ms
    counts_per_turn: float = _needed(
        "counts", "What an encoder counts in one turn of the wheel.", above=0, example=1000.0
    )
    kp: float = _derived(
        "V s/rad", "The proportional gain of the wheel loop.",
        "J / (torque_constant λ) with J = wheel_radius² (effective mass) / 2 for each wheel, and λ the greatest of "
        "0.04 s, T/2 with the motor's T = J / (torque_constant back_emf), and J supply_voltage / (4 back_emf "
        "torque_limit): with ki the motor's pole is cancelled, and the loop settles with the time constant λ, at most "
        "twice as fast as the motor alone, and a step to a quarter of the top speed stays below the torque limit",
        lambda r: r.wheel_load / (r.torque_constant * r.loop_time), least=0, example=0.68,
    )  # fmt: skip
    ki: float = _derived(
        "V/rad", "The integral gain of the wheel loop.",
        "kp torque_constant back_emf / J: the zero of the loop cancels the motor's pole",
        lambda r: r.kp * r.torque_constant * r.back_emf / r.wheel_load, least=0, example=20.0,
    )  # fmt: skip
    kd: float = _derived(
        "V s²/rad", "The gain of the wheel loop on the measured acceleration of the wheel.",
        "0: a PI loop is enough for a motor that is a lag of first order", lambda r: 0.0, least=0, example=0.001,
    )  # fmt: skip
    filter_frequency: float = _derived(
        "Hz", "The corner of the low-pass on the measured wheel speed; 0: there is none.",
        "0: no low-pass, which would delay the loop", lambda r: 0.0, least=0, most=49, example=20.0,
    )  # fmt: skip
    # Limits of the command
    wheel_speed_max: float = _derived(
        "rad/s", "The highest speed of a wheel.",
        "supply_voltage / back_emf: the motor's speed without load",
        lambda r: r.supply_voltage / r.back_emf, above=0, example=15.0,
    )  # fmt: skip
    v_max: float = _derived(
        "m/s", "The highest commanded speed.",
        "wheel_radius wheel_speed_max: what the wheels can turn", lambda r: r.wheel_speed_limit, above=0, example=0.6,
    )  # fmt: skip
    w_max: float = _derived(
        "rad/s", "The highest commanded turn rate.",
        "wheel_radius wheel_speed_max / half_axle: what the wheels can turn on the spot",
        lambda r: r.wheel_speed_limit / r.half_axle, above=0, example=6.7,
    )  # fmt: skip
    # Thesis (5.1); of a commanded velocity only
    v_rate_max: float | None = quantity(
        None, "m/s²", above=0, example=1.0, doc="How fast a commanded speed may change; left out: at once."
    )
    w_rate_max: float | None = quantity(
        None, "rad/s²", above=0, example=5.0, doc="How fast a commanded turn rate may change; left out: at once."
    )
    # What a data sheet seldom says, and a simulation by it leaves out
    dead_band: float = _derived(
        "m/s", "The commanded speed of a wheel's rim below which that wheel stands; of a commanded velocity only.",
        "0: every command moves", lambda r: 0.0, least=0, most=10, example=0.02,
    )  # fmt: skip
    v_resolution: float = _derived(
        "m/s", "A commanded speed is rounded to a multiple of it, as by a driver that takes whole numbers.",
        "0: it is not rounded", lambda r: 0.0, least=0, most=10, example=0.01,
    )  # fmt: skip
    w_resolution: float = _derived(
        "rad/s", "A commanded turn rate is rounded to a multiple of it.",
        "0: it is not rounded", lambda r: 0.0, least=0, most=10, example=0.05,
    )  # fmt: skip
    # Tyres that slip in proportion to their force (Pacejka, Tire and Vehicle Dynamics, 2012, section 1.2), the load
    # being the weight: a tyre's stiffness of C times its load is a slip of 1 / (C g) for each m/s²
    longitudinal_slip: float = _derived(
        "s²/m", "The slip of a wheel for each m/s² by which its rim speeds up, as a share of the rim's speed; the "
        "robot stays behind its wheels by it.",
        "0: wheels roll", lambda r: 0.0, least=0, most=10, example=0.02,
    )  # fmt: skip
    lateral_slip: float = _derived(
        "s²/m", "The slip angle in radians for each m/s² of centripetal acceleration v ω; the robot drifts outwards "
        "by it.",
        "0: wheels do not slide sideways", lambda r: 0.0, least=0, most=10, example=0.02,
    )  # fmt: skip
    castor_drag: float = _derived(
        "N", "The dry friction of the castor against its way over the floor.",
        "0: castors drag nothing that friction_torque does not", lambda r: 0.0, least=0, example=0.3,
    )  # fmt: skip
    castor_offset: float = _derived(
        "m", "From the axle forward to the castor; negative: it lies behind.",
        "-0.4 length: a tenth of the length from the rear edge",
        lambda r: -0.4 * r.length, least=-10, most=10, example=-0.1,
    )  # fmt: skip

    _left_out: ClassVar[tuple[str, ...]] = ()  # of an instance: the names of the fields that were derived

    def __post_init__(self) -> None:
        if lacking := missing_numbers(vars(self)):
            raise RobotError(f"a robot lacks {', '.join(lacking)}")
        for name, other in ALTERNATIVES.items():
            if getattr(self, name) is not None and getattr(self, other) is not None:
                raise RobotError(f"give {name} or {other}, not both: one follows from the other").about(name)
        check_quantities(self, RobotError)
        left_out = []
        for name, rule in RULES.items():
            if getattr(self, name) is None:
                object.__setattr__(self, name, rule.value(self))
                left_out.append(name)
        for name in ALTERNATIVES:  # from here on said by the constant
            object.__setattr__(self, name, None)
        object.__setattr__(self, "_left_out", tuple(left_out))
        check_quantities(self, RobotError)
        self._check_stiffness()

    def _check_stiffness(self) -> None:
        """Refuse a motor that is so strong for what it moves that the plant's steps do not resolve it."""
        damping = self.torque_constant * self.back_emf + self.friction_torque / self.friction_speed
        turning = self.effective_inertia * (self.wheel_radius / self.half_axle) ** 2 / 2
        rate = damping / min(self.wheel_load, turning)
        if rate > STIFFEST:
            raise RobotError(
                f"the wheels would answer within {1000 / rate:.2g} ms, and the simulation resolves no less than "
                f"{1000 / STIFFEST:g} ms: check the motor's torque_constant and back_emf, friction_torque and "
                "friction_speed against the masses, inertias and the wheel_radius"
            )

    @property
    def derived(self) -> dict[str, str]:
        """The rule of each number that was not given, by its name."""
        return {name: RULES[name].says for name in self._left_out}

    @property
    def given(self) -> dict[str, float]:
        """The numbers that were given, and the motor's constants, by their names: this robot is made of these."""
        known = {f.name: getattr(self, f.name) for f in fields(self) if f.init}
        left_out = set(self._left_out) - set(ALTERNATIVES.values())
        return {name: value for name, value in known.items() if value is not None and name not in left_out}

    def changed(self, **numbers: float) -> "Robot":
        """The same robot with other ``numbers``, by the names of fields; what was derived is derived anew."""
        return type(self)(**merged(self.given, numbers))

    @property
    def imperfections(self) -> dict[str, float]:
        """What of :data:`IMPERFECTIONS` it has: each is left out of what is proven, and of most laws' models."""
        return {name: getattr(self, name) for name in IMPERFECTIONS if getattr(self, name) > 0}

    @property
    def wheel_load(self) -> float:
        """J = r² (m + 2 J_w/r²) / 2 [kg m²]: what one motor turns when the robot drives straight on."""
        return self.wheel_radius**2 * self.effective_mass / 2

    @property
    def motor_time(self) -> float:
        """T = J / (k_t k_e) [s]: the time constant of a wheel's speed at a held voltage, straight on."""
        return self.wheel_load / (self.torque_constant * self.back_emf)

    @property
    def loop_time(self) -> float:
        """λ [s], the time constant that derived gains give the wheel loop: see the rule of kp."""
        quarter = self.wheel_load * self.supply_voltage / (4 * self.back_emf * self.torque_limit)
        return max(FASTEST_LOOP, self.motor_time / 2, quarter)

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

    @property
    def turning_circle(self) -> float:
        """The radius of the circle in which its corners swing as it turns on the spot [m]."""
        return hypot(self.length, self.width) / 2


# Effects that the plant has where they are above 0
IMPERFECTIONS = ("dead_band", "v_resolution", "w_resolution", "longitudinal_slip", "lateral_slip", "castor_drag")
# Two ways to say one thing: the data sheet's, and the constant that it is turned into.
ALTERNATIVES = {"stall_torque": "torque_constant", "no_load_speed": "back_emf"}
RULES: dict[str, DerivationRule] = {f.name: f.metadata["rule"] for f in fields(Robot) if "rule" in f.metadata}
NEEDED = ("body_mass", "length", "width", "half_axle", "wheel_radius", "supply_voltage", "counts_per_turn")


def missing_numbers(given: Mapping[str, Any]) -> list[str]:
    """What a robot of the ``given`` numbers lacks, in words with units; empty: it is whole."""
    units = {f.name: f.metadata["unit"] for f in fields(Robot)}
    lacking = [f"{name} [{units[name]}]" for name in NEEDED if given.get(name) is None]
    for name, other in ALTERNATIVES.items():
        if given.get(name) is None and given.get(other) is None:
            lacking.append(f"{name} [{units[name]}] (or {other} [{units[other]}])")
    return lacking


def merged(given: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """The numbers of a robot with ``changes``: a stall torque takes the place of a torque constant, and so on."""
    replaced = {other for pair in ALTERNATIVES.items() for name, other in (pair, pair[::-1]) if name in changes}
    return {name: value for name, value in given.items() if name not in replaced} | dict(changes)
