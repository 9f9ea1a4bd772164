"""A scene of robots and obstacles as MJCF, the XML of MuJoCo, made from robots' numbers.

A robot is a body with a free joint at the middle of its axle, two wheels on hinges, and castor balls before and behind
the axle, which slide. A motor is a general actuator: its force is k_t (U - k_e ω), bounded by the torque limit, of a
held voltage U. Dry friction of wheel and gear is the joint's frictionloss, the rotor's inertia its armature.
"""

from dataclasses import dataclass
from math import cos, hypot, sin
from xml.sax.saxutils import quoteattr

import numpy as np

from fuzzy.figures.palette import COLORS
from fuzzy.quantity import check_quantities, quantity
from robotics.simulation.physics import PhysicsError
from robotics.world.environment.world import Geometry
from robotics.world.vehicle.robot import GRAVITY, Robot

CLEARANCE = 5e-4  # m: castors hang so far above the floor while the robot stands upright on its wheels
CASTOR_PLACE = 0.4  # of the length, before and behind the axle
CASTOR_RADIUS = 0.3  # of the wheels'
# Contacts settle within two of the least steps that they are stable with, and sink in by 0.1 mm under a robot's weight
CONTACT_TIME = 0.004  # s
# Of castors: their force begins at 0 where they touch (MuJoCo's impedance). As stiff as wheels, a castor that drags
# leaves the floor and comes back every few steps
SOFTLY = "0 0.95 0.001"
HEIGHT_OF_OBSTACLES = 0.2  # m: obstacles
THIN = 0.005  # m: half the thickness of edges and walls
FILM_PIXELS = 960, 540  # pixels of a film
_LIGHT = 0.01  # of the body: a wheel's mass where the robot's file leaves it out, for a moving body needs one
_FLOOR, _SOLID = 1, 2  # bits of what collides with what


@dataclass(frozen=True, kw_only=True)
class Ground:
    """The floor and what stands on it, beside what a scenario says. Raises PhysicsError."""

    friction: float = quantity(0.8, "1", above=0, most=5, doc="Of the tyres on the floor: 0.8 rubber, 0.2 wet tiles.")
    castor_friction: float = quantity(0.05, "1", least=0, most=5, doc="Of the castor balls, which slide.")
    slope: float = quantity(0.0, "rad", least=-0.5, most=0.5, doc="Of the floor, uphill along x.")
    obstacle_mass: float = quantity(
        0.0, "kg", least=0, most=1000, doc="Of each obstacle, which robots can then push; 0: obstacles stand fast."
    )
    step: float = quantity(0.002, "s", least=1e-4, most=2e-3, doc="Of the integration; a part of 10 ms.")

    def __post_init__(self) -> None:
        check_quantities(self, PhysicsError)
        if abs(0.01 / self.step - round(0.01 / self.step)) > 1e-6:
            raise PhysicsError(f"step must be a part of 10 ms, such as 0.002 or 0.001; got {self.step!r}").about("step")


def scene(robots: tuple[Robot, ...], obstacles: Geometry | None, ground: Ground, emf: bool = True) -> str:
    """The MJCF of robots, in their order, and of obstacles at their places; each robot stands at the origin.

    Without ``emf`` motors have no back EMF: what drives them holds a torque, and minds the EMF itself.
    """
    gravity = _numbers(-GRAVITY * sin(ground.slope), 0, -GRAVITY * cos(ground.slope))
    bodies = [_body(i, robot, ground) for i, robot in enumerate(robots)]
    motors = [_motor(i, robot, side, emf) for i, robot in enumerate(robots) for side in ("right", "left")]
    things = [] if obstacles is None else _obstacles(obstacles, ground)
    return f"""<mujoco>
  <option timestep="{ground.step!r}" gravity="{gravity}" integrator="implicitfast" cone="elliptic" impratio="10"/>
  <default>
    <geom solref="{_numbers(CONTACT_TIME, 1)}" contype="{_SOLID}" conaffinity="{_SOLID}" density="0"/>
  </default>
  <visual><global offwidth="{FILM_PIXELS[0]}" offheight="{FILM_PIXELS[1]}"/></visual>
  <asset>
    <texture name="tiles" type="2d" builtin="checker" width="64" height="64" rgb1="1 1 1" rgb2="0.93 0.93 0.93"/>
    <material name="tiles" texture="tiles" texrepeat="1 1" texuniform="true"/>
  </asset>
  <worldbody>
    <light pos="0 0 5"/>
    <geom type="plane" size="0 0 1" material="tiles" contype="{_FLOOR}" conaffinity="0"/>
    {"".join(bodies)}{"".join(things)}
  </worldbody>
  <actuator>{"".join(motors)}</actuator>
</mujoco>
"""


def _body(i: int, robot: Robot, ground: Ground) -> str:
    """A robot: masses and inertias so that all of it together has those of its file."""
    r, wheel = robot.wheel_radius, robot.wheel_mass or _LIGHT * robot.body_mass
    spin = wheel * r**2 / 2
    across = max(robot.wheel_inertia, 0.501 * spin)  # of a body whose principal inertias are possible
    mass = robot.mass - 2 * wheel
    upright = robot.yaw_inertia - 2 * (wheel * robot.half_axle**2 + across) - mass * robot.mass_offset**2
    upright = max(upright, 0.1 * robot.body_inertia)
    lying = [max(mass * (side**2 + (2 * r) ** 2) / 12, 0.501 * upright) for side in (robot.width, robot.length)]
    rubber = f'friction="{_numbers(ground.friction, 0, 0)}"'
    ball = f'friction="{_numbers(ground.castor_friction, 0, 0)}"'
    wheels = [
        f"""
      <body name="{side}{i}" pos="{_numbers(0, y, 0)}">
        <inertial pos="0 0 0" mass="{wheel!r}" diaginertia="{_numbers(across, spin, across)}"/>
        <joint name="{side}{i}" axis="0 1 0" frictionloss="{robot.friction_torque!r}"
          armature="{max(robot.wheel_spin_inertia - spin, 0.0)!r}"/>
        <geom type="sphere" size="{r!r}" rgba="0.2 0.2 0.2 1" contype="0" conaffinity="{_FLOOR}" priority="1" {rubber}/>
      </body>"""
        for side, y in (("right", -robot.half_axle), ("left", robot.half_axle))
    ]
    small = CASTOR_RADIUS * r
    castors = [
        f"""
      <geom type="sphere" size="{small!r}" pos="{_numbers(x, 0, small + CLEARANCE - r)}" contype="0"
        conaffinity="{_FLOOR}" priority="1" solimp="{SOFTLY}" {ball}/>"""
        for x in (-CASTOR_PLACE * robot.length, CASTOR_PLACE * robot.length)
    ]
    return f"""
    <body name="robot{i}" pos="{_numbers(0, 0, r)}">
      <freejoint/>
      <inertial pos="{_numbers(robot.mass_offset, 0, 0)}" mass="{mass!r}" diaginertia="{_numbers(*lying, upright)}"/>
      <geom type="box" size="{_numbers(robot.length / 2, robot.width / 2, 0.7 * r)}" rgba="{_rgba(i)}"/>
      {"".join(castors + wheels)}
    </body>"""


def _rgba(i: int) -> str:
    color = COLORS[i % len(COLORS)]
    return _numbers(*(int(color[k : k + 2], 16) / 255 for k in (1, 3, 5)), 1)


def _motor(i: int, robot: Robot, side: str, emf: bool) -> str:
    constant, supply, most = robot.torque_constant, robot.supply_voltage, robot.torque_limit
    back = robot.back_emf if emf else 0.0
    return f"""
    <general joint={quoteattr(f"{side}{i}")} gainprm="{constant!r}" biastype="affine"
      biasprm="{_numbers(0, 0, -constant * back)}" ctrllimited="{str(emf).lower()}"
      ctrlrange="{_numbers(-supply, supply)}" forcerange="{_numbers(-most, most)}"/>"""


def _obstacles(found: Geometry, ground: Ground) -> list[str]:
    """Discs, and edges of polygons and walls as thin boxes: fixed, or each obstacle's pieces as a body of its own."""
    made, moved = [], ground.obstacle_mass > 0
    touched = _FLOOR | _SOLID if moved else _SOLID
    for (x, y, radius), (first, edges, _, _) in zip(
        found.circles[0].tolist(), found.bodies[0, : found.counts[0]].tolist(), strict=False
    ):
        share = f'mass="{ground.obstacle_mass / max(edges, 1)!r}" conaffinity="{touched}"'
        geoms = [] if edges else [f'<geom type="cylinder" size="{_numbers(radius, HEIGHT_OF_OBSTACLES / 2)}" {share}/>']
        for ax, ay, bx, by in found.segments[0, first : first + edges].tolist():
            turn = np.arctan2(by - ay, bx - ax)
            geoms.append(
                f'<geom type="box" pos="{_numbers((ax + bx) / 2 - x, (ay + by) / 2 - y, 0)}" '
                f'euler="{_numbers(0, 0, np.degrees(turn))}" '
                f'size="{_numbers(hypot(bx - ax, by - ay) / 2, THIN, HEIGHT_OF_OBSTACLES / 2)}" {share}/>'
            )
        joint = "<freejoint/>" if moved else ""
        made.append(f'\n    <body pos="{_numbers(x, y, HEIGHT_OF_OBSTACLES / 2)}">{joint}{"".join(geoms)}</body>')
    return made


def _numbers(*values: float) -> str:
    return " ".join(repr(float(value)) for value in values)
