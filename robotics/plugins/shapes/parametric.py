"""The shape "parametric": x and y of a path as formulas of a parameter."""

from dataclasses import dataclass

import numpy as np

from fuzzy.quantity import check_quantities, described, quantity
from robotics.plugins.shapes.formula import FormulaError, evaluate
from robotics.world.paths.path import PathError


@dataclass(frozen=True, kw_only=True)
class Parametric:
    """x and y as formulas of a parameter u, such as 6*sin(2*u): a spiral, a Lissajous figure."""

    x: str = described(
        "x in m, of numbers, u, pi, e, + - * / **, sin, cos, tan, exp, log, sqrt, tanh and atan.", example="2*cos(u)"
    )
    y: str = described("y in m, likewise.", example="sin(2*u)")
    begin: float = quantity(0.0, "1", doc="The u at which the path begins.")
    end: float = quantity(
        1.0, "1", doc="The u at which it ends; it may be less, and the path is then driven backwards."
    )

    def __post_init__(self) -> None:
        check_quantities(self, PathError)
        if self.begin == self.end:
            raise PathError(f"parametric path: begin and end are both {self.begin:g}: its length is 0").about("end")
        self.curve(np.linspace(0.0, 1.0, 4097))

    def curve(self, u: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The curve as of a :class:`~robotics.world.paths.path.Shape`.

        Raises PathError for a formula that cannot be read, or is not finite somewhere.
        """
        span = self.end - self.begin
        at = self.begin + span * np.asarray(u, dtype=float)
        found = []
        for name in ("x", "y"):
            try:
                jet = evaluate(getattr(self, name), at)
            except FormulaError as error:
                raise PathError(f"parametric path: {name}: {error}").about(name) from None
            bad = ~np.isfinite(np.stack(jet)).all(axis=0)
            if bad.any():
                where = np.ravel(at)[np.argmax(np.ravel(bad))]
                raise PathError(f"parametric path: {name} or its slope is not finite at u = {where:g}").about(name)
            found.append(jet)
        x, y = found
        place, slope, bend = (np.stack(pair) for pair in zip(x, y, strict=True))
        return place, span * slope, span**2 * bend
