"""What is learnt of a system, its premises and consequents, and the way from the system to a point and back."""

from dataclasses import dataclass
from functools import cached_property
from math import prod
from typing import Any

from anfis.point import Array, Point, numbers
from anfis.premises import Arrays, Premises
from anfis.proposals import consequent_terms, present_values
from fuzzy.system import Sugeno


@dataclass(frozen=True, eq=False)
class NetworkParameters:
    """A Sugeno system as a function of a point: what networks of numpy's arrays and of torch's have in common."""

    premises: Premises
    groups: tuple[Any, ...]  # the outputs by design matrix: each with its ``outputs`` and free ``columns``
    ridge: float  # without a unit, see fuzzy.fitting.consequents
    block: int  # samples held at a time

    @property
    def fis(self) -> Sugeno:
        """The system that learning started from: its structure stays."""
        return self.premises.fis

    @cached_property
    def premise_count(self) -> int:
        """The number of premises that are learnt."""
        return sum(prod(sign.shape) for sign in self.premises.signs)

    @cached_property
    def count(self) -> int:
        """The number of parameters that are learnt, premises and consequents."""
        return self.premise_count + sum(len(g.columns) * len(g.outputs) for g in self.groups)

    @cached_property
    def columns(self) -> int:
        """The number of parameters of the largest of the least squares."""
        return max(len(g.columns) for g in self.groups)

    def array(self, values: Any) -> Array:
        """Numbers, such as those of a checkpoint, as an array of this network."""
        raise NotImplementedError

    def start(self) -> Point:
        """The point of the system as it is, its premises made legal."""
        p = self.premises
        values = present_values(self.fis, numbers(p.low), numbers(p.span))
        return Point(p.valid(p.start()), [self.array(v) for v in values])

    def system(self, point: Point) -> Sugeno:
        """The system at ``point``, in the inputs' own units, with plain numbers."""
        p = self.premises
        values = [numbers(v) for v in point.values]
        return p.system(point.free, consequent_terms(self.fis, values, numbers(p.low), numbers(p.span)))

    def unflatten(self, flat: Array) -> Arrays:
        """Free premises, as in :class:`anfis.point.Point`, from one vector of all of them."""
        result, start = [], 0
        for sign in self.premises.signs:
            end = start + prod(sign.shape)
            result.append(flat[start:end].reshape(sign.shape))
            start = end
        return tuple(result)
