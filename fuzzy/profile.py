"""The trapezoid that stands for a membership function while its type changes, as in the designer."""

import math
from dataclasses import dataclass
from typing import NamedTuple

HALF_WIDTH = math.sqrt(2 * math.log(2))  # of a Gaussian at degree 0.5, in standard deviations


class Profile(NamedTuple):
    """The trapezoid with a function's points of degree 0.5 and its slopes there, all in the unit of x.

    Piecewise functions give their own vertices. A side that is open has none (None): the degree is 1 there.
    """

    a: float | None  # left foot
    b: float | None  # left shoulder
    c: float | None  # right shoulder
    d: float | None  # right foot

    @classmethod
    def ordered(cls, a: float, b: float, c: float, d: float) -> "Profile":
        """The trapezoid with these vertices; shoulders that cross meet in their middle, and the feet stay outside."""
        if b > c:
            b = c = min(max((b + c) / 2, a), max(a, d))
        return cls(min(a, b), b, c, max(d, c))

    @classmethod
    def between(cls, left: float, right: float, up: float, down: float) -> "Profile":
        """The trapezoid of degree 0.5 at ``left`` and ``right``, with edges of the widths ``up`` and ``down``."""
        a, b, c, d = left - up / 2, left + up / 2, right - down / 2, right + down / 2
        if b > c:
            b = c = min(max((b + c) / 2, left), right)
            a, d = 2 * left - b, 2 * right - c
        return cls(a, b, c, d)

    def closed(self, low: float, high: float) -> "Outline":
        """The profile over the universe [low, high]: an open side ends there, or at the other side if that is beyond.

        The edge of such a side is vertical.
        """
        left, right = self[:2], self[2:]
        a, b = (min(low, right[0]),) * 2 if left[0] is None else left  # type: ignore[type-var]
        c, d = (max(high, left[1]),) * 2 if right[0] is None else right  # type: ignore[type-var]
        assert a is not None
        assert b is not None
        assert c is not None
        assert d is not None
        return Outline(a, b, c, d, left[0] is None, right[0] is None, low, high)


@dataclass(frozen=True)
class Outline:
    """A profile whose sides are closed: what another function is fitted to. All in the unit of x."""

    a: float  # left foot
    b: float  # left shoulder
    c: float  # right shoulder
    d: float  # right foot
    open_left: bool  # was the left side open?
    open_right: bool
    low: float  # ends of the universe
    high: float

    @property
    def span(self) -> float:
        """The width of the universe; 1 where that is a single value."""
        return (self.high - self.low) or 1.0

    @property
    def smallest(self) -> float:
        """The least width that a function gets."""
        return max(self.span / 1000, 1e-300)

    @property
    def up(self) -> float:
        """The width of the left edge."""
        return max(self.b - self.a, self.smallest)

    @property
    def down(self) -> float:
        """The width of the right edge."""
        return max(self.d - self.c, self.smallest)

    @property
    def center(self) -> float:
        """The middle of the core, or the end of the universe on a side that was open."""
        return self.b if self.open_left else self.c if self.open_right else (self.b + self.c) / 2

    @property
    def half(self) -> float:
        """The half-width at degree 0.5."""
        if self.open_left:
            half = (self.d + self.c) / 2 - self.center
        elif self.open_right:
            half = self.center - (self.a + self.b) / 2
        else:
            half = (self.c + self.d - self.a - self.b) / 4
        return max(half, self.smallest)
