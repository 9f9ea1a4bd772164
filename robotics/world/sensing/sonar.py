"""Range sensors: sonars and lidars, with noise, lost echoes and crosstalk.

A sensor sends a cone of rays (one for a beam of a lidar) and reads the shortest echo. It reads infinite where it sees
nothing, as in REP 117; a thing nearer than the minimum range reads the minimum. The noise is normal, with the standard
deviation √(noise² + (relative_noise · distance)²), and never takes a reading out of the range. Between its updates a
sensor keeps its reading.

An echo is lost beyond the incidence angle, where a smooth surface reflects the sound away; a sharp corner that points
at the sensor has no other surface, so that corners below 2 (90° − incidence) are not seen head-on. At random an echo
is lost with the probability ``dropout``, and another robot's ping is heard with the probability ``crosstalk`` if it
arrives straight on: half its way is then read as a distance.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import pi, remainder

import numpy as np

from fuzzy.errors import InputError
from fuzzy.quantity import check_quantities, is_number, part, quantity, turn, whole


class SonarError(InputError):
    """A range sensor that cannot be. The message names the field, its value and what is accepted."""


@dataclass(frozen=True, kw_only=True)
class RangeSensor:
    """One range sensor in the robot's frame: x forward, y left, from the axle midpoint.

    Raises:
        SonarError: A range sensor that cannot be.
    """

    x: float = quantity(0.0, "m", least=-10, most=10, doc="Where it is mounted, ahead of the middle of the axle.")
    y: float = quantity(0.0, "m", least=-10, most=10, doc="Where it is mounted, to the left of the middle of the axle.")
    axis: float = turn(0.0, doc="Its direction, counted from straight ahead to the left.")
    half_cone: float = quantity(0.0, "rad", least=0, most=pi, doc="Half the opening angle of its cone.")
    rays: int = whole(
        1, least=1, most=10_000, doc="How many rays are spread evenly over the cone; a cone needs at least 2."
    )
    range: float = quantity(2.0, "m", above=0, most=1000, doc="The distance beyond which it sees nothing.")
    minimum: float = quantity(0.0, "m", least=0, most=1000, doc="The least distance that it can read.")
    period: float = quantity(0.05, "s", above=0, most=60, doc="The time from update to update.")
    noise: float = quantity(0.0, "m", least=0, most=10, doc="The standard deviation of a reading.")
    relative_noise: float = part(0.0, doc="The standard deviation of a reading as a share of it, added to the noise.")
    incidence: float = quantity(
        pi / 2, "rad", above=0, most=pi / 2, doc="The angle from a surface's normal beyond which there is no echo."
    )
    dropout: float = part(0.0, doc="The probability with which an echo is lost.")
    crosstalk: float = part(0.0, doc="The probability with which it hears the ping of a robot straight on instead.")
    failure_start: float | None = quantity(
        None, "s", least=0, doc="From when on it sees nothing; left out: it never fails.", example=10.0
    )
    failure_end: float | None = quantity(
        None, "s", above=0, doc="Until when it sees nothing; left out: to the end.", example=20.0
    )

    def __post_init__(self) -> None:
        check_quantities(self, SonarError)
        if self.rays == 1 and self.half_cone > 0:
            raise SonarError(f"rays must be >= 2 to fill a half_cone of {self.half_cone:g} rad, got 1").about("rays")
        if self.minimum >= self.range:
            raise SonarError(f"minimum must be < range, {self.range:g} m; got {self.minimum:g}").about("minimum")
        if self.failure_end is not None and (self.failure_start is None or self.failure_end <= self.failure_start):
            raise SonarError(f"failure_end must be > failure_start; got {self.failure_end:g}").about("failure_end")


def _sonar(x: float, y: float, axis: float, half_cone: float, reach: float) -> RangeSensor:
    # Noise, minimum and incidence are typical of 40 kHz transducers and of surfaces that are not quite smooth.
    return RangeSensor(
        x=x, y=y, axis=axis, half_cone=half_cone, rays=7, range=reach, minimum=0.03,
        noise=0.01, relative_noise=0.01, incidence=pi / 3,
    )  # fmt: skip


def sonar(length: float, width: float) -> dict[str, RangeSensor]:
    """Two sonars on the nose and one on each side (thesis 6.2) of a robot of that size [m].

    The thesis gives neither their places nor their ranges.
    """
    nose, side = length / 2, width / 2
    return {
        "front-left": _sonar(nose, 0.3 * width, pi / 9, 37 * pi / 180, 2.0),
        "front-right": _sonar(nose, -0.3 * width, -pi / 9, 37 * pi / 180, 2.0),
        "left": _sonar(0.0, side, pi / 2, pi / 12, 1.2),
        "right": _sonar(0.0, -side, -pi / 2, pi / 12, 1.2),
    }


SONAR: Mapping[str, RangeSensor] = sonar(0.23, 0.20)  # on the EtsRo


def lidar(beams: int = 121, span: float = 4 * pi / 3, reach: float = 4.0, axis: float = 0.0) -> dict[str, RangeSensor]:
    """The beams of a scanner above the axle, by name: beam-1, beam-2 and so on, from right to left.

    It makes ten scans a second with 1 cm + 1 % of noise, as a small scanner such as the Hokuyo URG-04LX.

    Args:
        beams: Their number.
        span: The angle from the first to the last [rad].
        reach: Their range [m].
        axis: The direction of the middle of the span, counted from straight ahead to the left [rad].

    Raises SonarError for another number than 2 to 10 000, and as :class:`RangeSensor`.
    """
    for name, angle in (("span", span), ("axis", axis)):
        if not (is_number(angle) and abs(angle) <= 2 * pi):
            raise SonarError(f"{name} must be a finite number in rad, >= -2π and <= 2π; got {angle!r}").about(name)
    if isinstance(beams, bool) or not isinstance(beams, int) or not 2 <= beams <= 10_000:
        raise SonarError(f"beams must be a whole number >= 2 and <= 10000, got {beams!r}").about("beams")
    axes = [axis + a for a in np.linspace(-span / 2, span / 2, beams).tolist()]
    return {
        f"beam-{n}": RangeSensor(
            axis=_wrapped(a), range=reach, minimum=0.02, period=0.1, noise=0.01, relative_noise=0.01
        )
        for n, a in enumerate(axes, start=1)
    }


def _wrapped(angle: float) -> float:
    return angle if abs(angle) <= 2 * pi else remainder(angle, 2 * pi)


LIDAR: Mapping[str, RangeSensor] = lidar()
SENSOR_PRESETS: dict[str, Mapping[str, RangeSensor]] = {"sonar": SONAR, "lidar": LIDAR}


@dataclass(frozen=True, eq=False)
class Ranges:
    """The present readings of all range sensors. ``ranges["left"]`` is (runs, robots) [m]; infinite: nothing seen."""

    names: tuple[str, ...]
    values: np.ndarray  # (runs, robots, sensors) m; infinite also where a robot does not carry that sensor

    def __getitem__(self, name: str) -> np.ndarray:
        """The readings of the sensor ``name`` (runs, robots) [m]."""
        return np.asarray(self.values[..., self.names.index(name)])

    def of(self, names: Sequence[str]) -> np.ndarray:
        """The readings of the sensors ``names``, in this order (runs, robots, sensors) [m]."""
        if tuple(names) == self.names:
            return self.values
        return np.ascontiguousarray(self.values[..., [self.names.index(name) for name in names]])
