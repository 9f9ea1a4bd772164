"""What a search may move of an interval type-2 system: that of its upper system, and the footprint."""

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from itertools import chain
from typing import Any

import numpy as np

from fuzzy.membershipfunction import as_number
from fuzzy.tuning.mirror import Mirror
from fuzzy.tuning.parameter import SearchParameter
from fuzzy.tuning.systemspace import MOVED, SystemSpace, search_space, with_images

FOOTPRINTS = "footprints"  # what may move besides
_LEAST_SCALE, _MOST_LAG = 0.05, 0.95  # of a lower membership function, unless it starts beyond


@dataclass(frozen=True, eq=False)
class Type2Space:
    """A type-2 system and what may move of its upper one, and then scales and lags of its lower functions."""

    fis: Any  # a Type2Sugeno
    move: Collection[str]
    upper: SystemSpace
    footprints: "tuple[_Footprint, ...]"

    @property
    def parameters(self) -> tuple[SearchParameter, ...]:
        """What may move."""
        return (*self.upper.parameters, *chain.from_iterable(each.parameters for each in self.footprints))

    def made(self, values: np.ndarray) -> Any:
        """The system that ``values`` (parameters,) make. Raises FuzzySystemError as the system does."""
        first = len(self.upper.parameters)
        lower = {name: dict(terms) for name, terms in self.fis.lower.items()}
        rest = iter(values[first:])
        for each in self.footprints:
            scale, *lags = (float(next(rest)) for _ in each.parameters)
            pair = (lags[0], lags[-1])
            for term, turned in zip(each.terms, (pair, pair[::-1]), strict=False):
                lower[each.input][term] = replace(lower[each.input][term], scale=scale, lag=turned)
        return replace(self.fis, upper=self.upper.made(values[:first]), lower=lower)

    def unreached(self, x: np.ndarray) -> tuple[str, ...]:
        """The names of the parameters of the upper system of which inputs ``x`` (points, inputs) say too little."""
        return self.upper.unreached(x)


@dataclass(frozen=True)
class _Footprint:
    """The scale of a term, and one lag or a left and a right one; of its mirror image the same, turned round."""

    parameters: tuple[SearchParameter, ...]
    input: str
    terms: tuple[str, ...]


def type2_space(
    fis: Any, move: Collection[str] | None, symmetric: bool, data: tuple[np.ndarray, np.ndarray] | None
) -> Type2Space:
    """What may move of a type-2 system; see :meth:`Type2Sugeno.search_space`."""
    move = (*MOVED, FOOTPRINTS) if move is None else tuple(move)
    upper: SystemSpace = search_space(fis.upper, [part for part in move if part != FOOTPRINTS], symmetric, data)
    if upper.mirror is not None and not _is_mirrored(fis, upper.mirror):
        upper = replace(upper, symmetric=False)
    return Type2Space(fis, move, upper, tuple(_footprints(fis, upper.mirror)) if FOOTPRINTS in move else ())


def _footprints(fis: Any, mirror: Mirror | None) -> Iterator[_Footprint]:
    for place, variable in enumerate(fis.inputs):
        names = list(variable.terms)
        flips = mirror is not None and mirror.inputs[place] < 0
        for orbit in with_images(range(len(names)), mirror.terms[place] if flips and mirror is not None else None):
            terms = tuple(names[k] for k in orbit)
            own, label = fis.lower[variable.name][terms[0]], f"{variable.name}.{'+'.join(terms)}"
            scale, left, right = map(as_number, (own.scale, *own.lag))
            lags = {"lag": left} if left == right else {"left lag": left, "right lag": right}
            parameters = [SearchParameter(name=f"{label}.scale", start=scale, lower=min(_LEAST_SCALE, scale / 2))]
            parameters += [
                SearchParameter(name=f"{label}.{what}", start=lag, upper=max(_MOST_LAG, lag))
                for what, lag in lags.items()
            ]
            yield _Footprint(tuple(parameters), variable.name, terms)


def _is_mirrored(fis: Any, mirror: Mirror) -> bool:
    """Whether the lower functions have the symmetry of the upper system."""
    return all(
        own[image] == replace(own[k], lag=own[k].lag[:: mirror.inputs[place]])
        for place, terms in enumerate(mirror.terms)
        for own in [list(fis.lower[fis.inputs[place].name].values())]
        for k, image in enumerate(terms)
    )
