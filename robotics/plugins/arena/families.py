"""Random scenarios: a family says how they are drawn, and a number which of them one is.

A robot shall drive along a path that begins near it, at a constant speed. Sizes, speed and start are drawn from a
generator of the family's path and of the number alone, so that the same number is the same scenario everywhere.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from math import cos, pi, sin
from typing import Literal

import numpy as np

from fuzzy.quantity import check_quantities, described, quantity, whole
from robotics.plugins.arena.plan import ArenaError
from robotics.simulation.scenario.description import InfeasibleError, Member, Scenario
from robotics.simulation.scenario.robots import STANDARD, RobotModel, load_robot
from robotics.world.paths.path import Circle, Eight, Shape, Sine, Waypoints, compile_path
from robotics.world.paths.trajectory import Timing
from robotics.world.sensing.posture import Sensing

PathKind = Literal["sine", "winding", "circle", "eight", "corners"]
_TRIES = 40  # drawings until one can be driven
_ROUNDING = 0.05  # m between the points of a rounded corner
RAMP, STAND = 1.0, 4.0  # s: the reference gathers speed, and slows down; and stands at the end of its path
_REACH = 1.0  # times the length that is driven: so long a random path is made


@dataclass(frozen=True, kw_only=True)
class Conditions:
    """What all scenarios of an arena share."""

    title: str = described("What they are called in tables and pictures.", "", example="noise ×2")
    period: float = quantity(0.05, "s", above=0, most=1, doc="The period in which a law decides.")
    latency: float = quantity(0.03, "s", least=0, most=1, doc="The time from deciding on a command to its effect.")
    position_noise: float = quantity(0.003, "m", least=0, doc="The standard deviation of the measured x and y.")
    heading_noise: float = quantity(0.003, "rad", least=0, doc="The standard deviation of the measured heading.")
    start_position: float = quantity(
        0.05, "m", least=0, doc="The standard deviation of the start in x and y from one run to the next."
    )
    start_heading: float = quantity(0.1, "rad", least=0, doc="Likewise of the heading.")
    encoder_error: float = quantity(
        0.0,
        "1",
        least=0,
        most=0.2,
        doc="The relative standard deviation of the wheels and axle that odometry assumes.",
    )

    def __post_init__(self) -> None:
        check_quantities(self, ArenaError)

    @property
    def sensing(self) -> Sensing:
        """How robots know their postures."""
        return Sensing(
            posture="pose",
            position_noise=self.position_noise,
            heading_noise=self.heading_noise,
            start_position=self.start_position,
            start_heading=self.start_heading,
            wheel_error=self.encoder_error,
            axle_error=self.encoder_error,
        )


@dataclass(frozen=True, kw_only=True)
class Family:
    """Random scenarios of one sort. Raises ArenaError."""

    path: PathKind = described("The paths: sine, winding, circle, eight or corners.")
    count: int = whole(1, least=1, most=1000, doc="How many scenarios of it are drawn.")
    slowest: float = quantity(0.2, "m/s", above=0, doc="The least speed along the path.")
    fastest: float = quantity(0.3, "m/s", above=0, doc="The highest.")
    tightest: float = quantity(0.5, "m", above=0, doc="The least radius of the path's curves.")
    widest: float = quantity(1.5, "m", above=0, doc="The radius up to which the least one of a path is drawn.")
    offset: float = quantity(0.1, "m", least=0, most=5, doc="The start lies beside the path, by up to so much.")
    heading: float = quantity(0.2, "rad", least=0, most=pi, doc="And turned from it, by up to so much.")
    least_offset: float = quantity(0.0, "m", least=0, doc="The start lies beside the path by at least so much.")
    robot: str = described("The robot: a name, or a .toml file.", STANDARD)
    load: float = quantity(0.0, "kg", least=0, doc="What the robot carries, spread over it; the laws know of it.")
    duration: float = quantity(
        14.0, "s", above=12, most=600, doc="How long it is driven at least; then the reference stands for 4 s."
    )
    title: str = described("What it is called in tables and pictures.", "", example="a heavier robot")

    def __post_init__(self) -> None:
        check_quantities(self, ArenaError)
        for low, high in (("slowest", "fastest"), ("tightest", "widest"), ("least_offset", "offset")):
            if getattr(self, low) > getattr(self, high):
                raise ArenaError(f"{low} must be <= {high}, {getattr(self, high):g}; got {getattr(self, low):g}").about(
                    low
                )
        if self.path not in _SHAPES:
            raise ArenaError(f"path must be one of {', '.join(_SHAPES)}; got {self.path!r}").about("path")

    @property
    def label(self) -> str:
        """What it is called."""
        return self.title or self.path

    def scenario(self, number: int, conditions: Conditions) -> Scenario:
        """Draw the scenario of that number.

        Raises ArenaError where none of many drawings can be driven by the robot, and RobotError.
        """
        model = _loaded(load_robot(self.robot), self.load)
        generator = np.random.default_rng([list(_SHAPES).index(self.path), number])
        problem = ""
        for _ in range(_TRIES):
            speed = float(generator.uniform(self.slowest, self.fastest))
            radius = float(generator.uniform(self.tightest, self.widest))
            shape = _SHAPES[self.path](generator, radius, speed * self.duration)
            aside = float(generator.uniform(self.least_offset, self.offset) * generator.choice([-1.0, 1.0]))
            turned = float(generator.uniform(-self.heading, self.heading))
            path = compile_path(shape)
            if abs(path.table[3]).max() > 1.02 / self.tightest or path.length < speed * self.duration:
                problem = "the paths drawn have tighter curves"
                continue
            at = path.at(0.0)
            heading = float(np.remainder(at.heading + turned + pi, 2 * pi) - pi)
            start = (
                float(at.x) - aside * sin(float(at.heading)),
                float(at.y) + aside * cos(float(at.heading)),
                heading,
            )
            over = path.length / speed + RAMP
            timing = Timing(speed=speed, ramp=RAMP)
            try:
                return Scenario(
                    name=f"{self.path}-{number}",
                    title=self.label,
                    robots=(Member(start=start, path=shape, timing=timing, robot=model.robot, model=model),),
                    duration=round((over + STAND) / conditions.period) * conditions.period,
                    latency=conditions.latency,
                    period=conditions.period,
                    sensing=conditions.sensing,
                    sensors={},
                )
            except InfeasibleError as error:
                problem = str(error)
        raise ArenaError(f"{self.label}: {_TRIES} scenarios were drawn, and none can be driven: {problem}")


def _loaded(model: RobotModel, load: float) -> RobotModel:
    """A robot with a load spread over its body; its wheel loops are as they were."""
    if not load:
        return model
    robot = model.robot
    share = (robot.body_mass + load) / robot.body_mass
    heavier = replace(robot, body_mass=robot.body_mass * share, body_inertia=robot.body_inertia * share)
    return replace(model, robot=heavier)


# Paths: from a generator, the least radius [m] and the length [m] that is driven at least --------------------------


def _sine(generator: np.random.Generator, radius: float, length: float) -> Shape:
    """A sine whose peaks have that radius, 1/(a k²)."""
    wavelength = float(generator.uniform(6.0, 12.0)) * radius
    wavenumber = 2 * pi / wavelength
    side = float(generator.choice([-1.0, 1.0]))
    return Sine(amplitude=side / (radius * wavenumber**2), wavenumber=wavenumber, x_end=length)


def _circle(generator: np.random.Generator, radius: float, length: float) -> Shape:
    left = generator.random() < 0.5
    return Circle(
        center=(0.0, radius if left else -radius),
        radius=radius,
        start_angle=-pi / 2 if left else pi / 2,
        direction="counter-clockwise" if left else "clockwise",
        turns=1.01 * length / (2 * pi * radius),
    )


def _eight(generator: np.random.Generator, radius: float, length: float) -> Shape:
    """Bernoulli's lemniscate, whose curvature is at most 3/a."""
    width = 6 * radius
    turns = length / (5.24412 * width / 2)
    return Eight(width=width, angle=float(generator.uniform(-pi, pi)), turns=1.01 * turns)


def _winding(generator: np.random.Generator, radius: float, length: float) -> Shape:
    """A spline through points whose directions wander, four stretches of it at least."""
    step = min(2.0 * radius, length / 4)
    points, heading = [(0.0, 0.0)], 0.0
    while (len(points) - 1) * step < _REACH * length:
        x, y = points[-1]
        points.append((x + step * cos(heading), y + step * sin(heading)))
        heading += float(generator.uniform(-1.0, 1.0))
    return Waypoints(points=tuple(points))


def _corners(generator: np.random.Generator, radius: float, length: float) -> Shape:
    """Straight lines with rounded corners, as through the corridors of a house."""
    x, y, heading, driven = 0.0, 0.0, 0.0, 0.0
    points = [(x, y)]

    def forward(distance: float, turn: float) -> None:
        nonlocal x, y, heading, driven
        steps = max(2, round(distance / _ROUNDING))
        for _ in range(steps):
            heading += turn / steps / 2
            chord = distance / steps
            x, y = x + chord * cos(heading), y + chord * sin(heading)
            heading += turn / steps / 2
            points.append((x, y))
        driven += distance

    while driven < _REACH * length:
        forward(float(generator.uniform(0.6, 1.5)), 0.0)
        angle = float(generator.uniform(0.8, 1.7) * generator.choice([-1.0, 1.0]))
        # A spline overshoots where its curvature jumps: a corner is rounded by a little more than is asked for
        forward(1.35 * radius * abs(angle), angle)
    return Waypoints(points=tuple(points))


_SHAPES: Mapping[str, Callable[[np.random.Generator, float, float], Shape]] = {
    "sine": _sine,
    "winding": _winding,
    "circle": _circle,
    "eight": _eight,
    "corners": _corners,
}
