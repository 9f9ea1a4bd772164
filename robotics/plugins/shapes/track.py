"""The shape "track": points of a table, in metres or as latitudes and longitudes, and a spline along them."""

from dataclasses import dataclass, field
from math import cos, hypot, radians, sin, sqrt

import numpy as np

from fuzzy.files.table import DataError, TableText, open_table
from fuzzy.quantity import check_quantities, described, quantity
from robotics.world.paths.path import PathError

# Titles of columns that are taken without being named, the first pair that the table has
_KNOWN = (("x", "y"), ("x_m", "y_m"), ("longitude", "latitude"), ("lon", "lat"), ("lng", "lat"))
_AXIS, _FLATTENING = 6_378_137.0, 1 / 298.257_223_563  # WGS 84: m, 1
_MOST = 20_000  # points


@dataclass(frozen=True, kw_only=True)
class TrackFile:
    """A track that was driven or surveyed: the points of a CSV file, smoothed if asked; closed if the ends coincide."""

    file: str = described("The table, relative to this file; a header names its columns.", example="lap.csv")
    x: str = described(
        'The column of x in m, or of the longitude in degrees; left out: "x", "x_m", "longitude", "lon" or "lng".', ""
    )
    y: str = described('That of y or the latitude; left out: "y", "y_m", "latitude" or "lat".', "")
    geographic: bool = described(
        "Whether they are longitude and latitude; so are columns of these names. x is then east, y north.", False
    )
    origin: tuple[float, float] | None = described(
        "Latitude and longitude in degrees at (0, 0); left out: those of the first point.", None, example=[45.5, -73.6]
    )
    apart: float = quantity(0.05, "m", above=0, doc="Points nearer than this to the last one are left out.")
    smooth: float = quantity(
        0.0, "m", least=0, doc="How far the path may pass the points, root mean square: of a GPS its noise."
    )
    points: tuple[tuple[float, float], ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        check_quantities(self, PathError)
        try:
            table = open_table(self.file)
            wanted, geographic = self._columns(table)
            values = table.numbers(wanted).values
        except (DataError, OSError) as error:
            raise PathError(f"track path: {error}").about("file") from None
        if geographic:
            values = self._metres(values)
        kept = [values[0]]
        for point in values[1:]:
            if hypot(*(point - kept[-1])) >= self.apart:
                kept.append(point)
        if not 2 <= len(kept) <= _MOST:
            what = f"{len(kept)} points of {self.file} are {self.apart:g} m apart or more; accepted: 2 to {_MOST}"
            raise PathError(f"track path: {what}").about("apart")
        if len(kept) > 3 and hypot(*(kept[-1] - kept[0])) < self.apart:
            kept[-1] = kept[0]
        object.__setattr__(self, "points", tuple((float(x), float(y)) for x, y in kept))

    def _columns(self, table: TableText) -> tuple[tuple[str, str], bool]:
        """The columns that hold x and y, and whether these are longitude and latitude."""
        if self.x and self.y:
            return (self.x, self.y), self.geographic
        if self.x or self.y:
            raise PathError("track path: name both columns, x and y, or none").about("x" if self.x else "y")
        there = {column.name.lower(): column.name for column in table.columns}
        for x, y in _KNOWN:
            if x in there and y in there:
                return (there[x], there[y]), self.geographic or not x.startswith("x")
        raise PathError(
            f"track path: {self.file} has the columns {', '.join(there.values())}; name those of x and y"
        ).about("file")

    def _metres(self, degrees: np.ndarray) -> np.ndarray:
        """East and north [m] of longitudes and latitudes [°], in the plane that touches WGS 84 at the origin."""
        if np.abs(degrees[:, 1]).max() >= 90 or np.abs(degrees[:, 0]).max() > 360:
            raise PathError(f"track path: {self.file}: latitudes lie within 90°, longitudes within 360°").about("file")
        latitude, longitude = self.origin or (degrees[0, 1], degrees[0, 0])
        squared = _FLATTENING * (2 - _FLATTENING)  # of the eccentricity
        root = sqrt(1 - squared * sin(radians(latitude)) ** 2)
        east = _AXIS / root * cos(radians(latitude))  # m for each rad
        north = _AXIS * (1 - squared) / root**3
        turned = (degrees[:, 0] - longitude + 180) % 360 - 180  # also across 180°
        return np.stack([np.radians(turned) * east, np.radians(degrees[:, 1] - latitude) * north], axis=1)

    def curve(self, u: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The curve as of a :class:`~robotics.world.paths.path.Shape`."""
        from scipy.interpolate import splev, splprep

        points = np.asarray(self.points)
        closed = len(points) > 3 and self.points[0] == self.points[-1]
        chord = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
        order = min(3, len(points) - 1)
        least = len(points) * self.smooth**2
        spline, _ = splprep(points.T, u=chord / chord[-1], s=least, k=order, per=closed)
        place, slope = (np.stack(splev(u, spline, n)) for n in range(2))
        bend = np.stack(splev(u, spline, 2)) if order > 1 else np.zeros_like(place)
        return place, slope, bend
