"""The network of an interval type-2 system: back-propagation moves its footprint of uncertainty with all the rest.

The gradient goes through type reduction [Karnik & Mendel 2001], see :func:`fuzzy.infer_type2`: which rules stand at
their upper strengths is held while it is taken, and found anew in every epoch.
"""

import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any

import numpy as np
import torch

import fuzzy
from anfis.consequents import groups
from anfis.network import Network
from anfis.point import Point
from anfis.premises import Arrays, Premises, premises
from fuzzy.inference import InferenceWarning, forgiving
from fuzzy.membershipfunction import as_number
from fuzzy.system import Consequent, Constant, Linear

_LEAST, _MOST = (0.05, 0.0, 0.0), (1.0, 0.95, 0.95)  # scale, left and right lag, unless they start beyond


@dataclass(frozen=True, eq=False)
class Type2Premises(Premises):
    """How the upper system's premises are learnt, with a last free array: scale, left and right lag (terms, 3)."""

    footprint: torch.Tensor = field(kw_only=True)  # that of the start

    def start(self) -> Arrays:
        """Free arrays for the numbers that the system has now."""
        return (*super().start(), self.footprint)

    def natural(self, free: Sequence[torch.Tensor]) -> Arrays:
        """The parameters of the upper membership functions."""
        return super().natural(free[: len(self.signs)])

    def valid(self, free: Sequence[torch.Tensor]) -> Arrays:
        """The nearest free arrays that make legal upper and lower membership functions."""
        *upper, footprint = free
        least, most = (self._array(ends) for ends in (_LEAST, _MOST))
        ends = torch.minimum(self.footprint, least), torch.maximum(self.footprint, most)
        return (*super().valid(upper), torch.clamp(footprint, *ends))


@dataclass(frozen=True, eq=False)
class Type2Network(Network):
    """An interval type-2 system as a function of a point, whose values are all consequents in scaled units."""

    type2: "fuzzy.Type2Sugeno" = field(kw_only=True)  # that learning started from, with plain numbers

    @cached_property
    def _apart(self) -> list[bool]:
        """By term whether its lags are two numbers; else the left one stands for both."""
        return [as_number(each.lag[0]) != as_number(each.lag[1]) for each in _lowers(self.type2)]

    @cached_property
    def count(self) -> int:
        """The number of parameters that are learnt."""
        point = self.start()
        return sum(array.numel() for array in (*point.free, *point.values)) - self._apart.count(False)

    def start(self) -> Point:
        """The point of the system as it is, its premises made legal."""
        lows, spans, numbers = self.premises.low.tolist(), self.premises.span.tolist(), list[float]()
        for variable in self.fis.outputs:
            for term in variable.terms.values():
                *slopes, constant = term.parameters
                shift = sum(slope * low for slope, low in zip(slopes, lows, strict=False))
                scaled = [slope * span for slope, span in zip(slopes, spans, strict=False)]
                numbers += [number / (variable.span or 1.0) for number in (*scaled, constant + shift)]
        return Point(self.premises.valid(self.premises.start()), [self.array(np.array(numbers))])

    def output(self, free: Sequence[torch.Tensor], values: Sequence[torch.Tensor], u: torch.Tensor) -> torch.Tensor:
        """The outputs (samples, outputs) at scaled inputs."""
        system = self._made(free, values, live=True)
        with warnings.catch_warnings(action="ignore", category=InferenceWarning):
            answer: torch.Tensor = system(self.premises.low + u * self.premises.span)
        return answer

    def system(self, point: Point) -> "fuzzy.Type2Sugeno":  # type: ignore[override]
        """The type-2 system at ``point``, in the inputs' own units, with plain numbers."""
        return self._made(point.free, point.values, live=False)

    def _made(self, free: Sequence[torch.Tensor], values: Sequence[torch.Tensor], live: bool) -> "fuzzy.Type2Sugeno":
        """The system of these arrays; if ``live`` of tensors, each a number, and silent where no rule fires."""
        *own, footprint = (array if live else array.detach() for array in free)
        (numbers,) = values
        rest = iter(numbers.unbind() if live else numbers.tolist())
        upper = self.premises.system(own, [list(self._consequents(v, rest)) for v in self.fis.outputs], live)
        upper = forgiving(upper, "midrange") if live else upper
        rows = footprint.unbind() if live else footprint.tolist()
        made = (fuzzy.Lower(r[0], (r[1], r[1 + two])) for r, two in zip(rows, self._apart, strict=True))
        lower = {name: {term: next(made) for term in terms} for name, terms in self.type2.lower.items()}
        return replace(self.type2, upper=upper, lower=lower)

    def _consequents(self, variable: "fuzzy.Variable", rest: Iterator[Any]) -> Iterator[Consequent]:
        """The consequents of an output, in the inputs' own units, from its numbers, which are next."""
        lows, spans, width = self.premises.low.tolist(), self.premises.span.tolist(), variable.span or 1.0
        for term in variable.terms.values():
            slopes = [next(rest) * width / span for span in spans] if isinstance(term, Linear) else []
            shift = sum(slope * low for slope, low in zip(slopes, lows, strict=False))
            constant = next(rest) * width - shift
            yield Linear(slopes, constant) if isinstance(term, Linear) else Constant(constant)


def _lowers(fis: "fuzzy.Type2Sugeno") -> "list[fuzzy.Lower]":
    return [each for terms in fis.lower.values() for each in terms.values()]


def make_network(
    fis: "fuzzy.Type2Sugeno", dtype: str, device: str, keep_order: bool, ridge: float, block: int
) -> Type2Network:
    """The network of ``fis``, whose upper system has plain numbers; ``dtype`` is torch's name of a type of number."""
    kind = getattr(torch, dtype)
    held = premises(fis.upper, dtype=kind, device=device, keep_order=keep_order)
    rows = [[as_number(number) for number in (each.scale, *each.lag)] for each in _lowers(fis)]
    footprint = torch.tensor(rows, dtype=kind, device=device).reshape(-1, 3)
    wide = Type2Premises(*(getattr(held, each.name) for each in fields(held)), footprint=footprint)
    return Type2Network(wide, groups(fis.upper, kind, device), ridge, block, type2=fis)
