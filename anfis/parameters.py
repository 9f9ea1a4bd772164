"""What is learnt of a system, its premises and consequents: the way to a point and back, and the ridge.

Consequents are learnt of inputs in units of the universes, (x − low)/span.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import prod
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from array_api_compat import array_namespace

from anfis.data import SampleArrays
from anfis.point import Array, Point, numbers
from anfis.premises import Arrays, Premises
from fuzzy.fitting.consequents import output_groups
from fuzzy.membershipfunction import like
from fuzzy.system import Consequent, Constant, Linear, Sugeno


@dataclass(frozen=True, eq=False)
class NetworkParameters:
    """A Sugeno system as a function of a point: what networks of numpy's arrays and of torch's have in common."""

    premises: Premises
    groups: tuple[Any, ...]  # the outputs by design matrix: each with its ``outputs`` and free ``columns``
    ridge: float  # without a unit, see fuzzy.fitting.consequents
    block: int  # samples held at a time
    _ranges: WeakKeyDictionary[SampleArrays, tuple[Array, Array]] = field(
        default_factory=WeakKeyDictionary, init=False, repr=False
    )

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

    @property
    def normalise(self) -> bool:
        """Whether a rule counts by its share of all firing strengths: a weighted average, not a weighted sum."""
        return self.fis.defuzzification == "wtaver"

    def array(self, values: Any) -> Array:
        """Numbers, such as those of a checkpoint, as an array of this network."""
        raise NotImplementedError

    def units(self, data: SampleArrays) -> Iterator[Array]:
        """The samples' scaled inputs (samples, inputs), some at a time."""
        raise NotImplementedError

    def normal_equations(self, a: Array, y: Array) -> tuple[Array, Array]:
        """Σ aᵀa and Σ aᵀy of ``a`` (samples, parameters) and ``y`` (samples, outputs)."""
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

    # The ridge ----------------------------------------------------------------------------------------------------

    def _range(self, data: SampleArrays) -> tuple[Array, Array]:
        """Middle and half width (inputs,) of the samples, in scaled units; an input that is constant has width 1."""
        if data not in self._ranges:
            xp = array_namespace(self.premises.low)
            ends = xp.stack([xp.stack([xp.min(u, axis=0), xp.max(u, axis=0)]) for u in self.units(data)])
            low, high = xp.min(ends[:, 0], axis=0), xp.max(ends[:, 1], axis=0)
            self._ranges[data] = (low + high) / 2, xp.where(high > low, (high - low) / 2, xp.ones_like(low))
        return self._ranges[data]

    def ridge_rows(self, g: int, equations: tuple[Array, Array], fires: int, data: SampleArrays) -> tuple[Array, Array]:
        """The ridge λ of :mod:`fuzzy.fitting.consequents` as more samples: rows (parameters, parameters) and targets.

        Appended to the design matrix of group ``g`` and its targets they add λ N |θ|² to the sum of squares: θ =
        T values − m are the consequents for inputs scaled to [−1, 1], T changes the scale, m is the outputs' mean at
        the constants. N is ``fires``, the number of samples where a rule of the group fires; ``equations`` are theirs,
        Σ aᵀa and Σ aᵀy.
        """
        gram, moment = equations
        middle, half = map(numbers, self._range(data))
        scale = np.diag(np.append(half, 1.0))
        scale[-1, :-1] = middle
        term, place = np.divmod(numbers(self.groups[g].columns).astype(int), len(scale))
        change = like(gram, np.where(term[:, None] == term, scale[np.ix_(place, place)], 0.0))
        constants = like(gram, (place == len(scale) - 1).astype(float))
        # Weights that sum to 1 where a rule fires, and to 0 elsewhere: the sum of the constants' columns is who fires.
        firing = max(float(constants @ gram @ constants), 1.0)
        means = (constants @ moment) / firing * self.normalise
        weight = (self.ridge * fires) ** 0.5
        return weight * change, weight * constants[:, None] * means

    def with_ridge(self, g: int, triangle: Array, values: Array, fires: int, data: SampleArrays) -> Array:
        """The triangle [A, J, r] of group ``g`` with the ridge's rows [a, 0, t − a · values] below."""
        xp, (n, q) = array_namespace(triangle), values.shape
        a, residual = triangle[:, :n], triangle[:, -q:]
        rows, targets = self.ridge_rows(g, self.normal_equations(a, residual + a @ values), fires, data)
        below = like(triangle, np.zeros((n, triangle.shape[1])))
        below[:, :n] = rows
        below[:, -q:] = targets - rows @ xp.astype(values, rows.dtype)
        return xp.concat([triangle, below])


def consequent_terms(
    fis: Sugeno, solutions: Sequence[np.ndarray], low: np.ndarray, span: np.ndarray
) -> list[list[Consequent]]:
    """The consequents of every output, in the inputs' own units, from solutions in scaled units (x − low)/span.

    ``solutions`` are those of the groups of :func:`fuzzy.fitting.consequents.output_groups`, (parameters, outputs)
    each; ``low`` and ``span`` are (inputs,). A term that no rule proposes stays as it is.
    """
    result: list[list[Consequent]] = [[] for _ in fis.outputs]
    width = len(fis.inputs) + 1
    for group, values in zip(output_groups(fis), solutions, strict=True):
        full = np.zeros((len(group.linear) * width, values.shape[1]))
        full[group.columns] = values
        for column, o in enumerate(group.outputs):
            rows = full[:, column].reshape(-1, width)
            slopes = rows[:, :-1] / span
            constants = rows[:, -1] - slopes @ low
            for t, term in enumerate(fis.outputs[o].terms.values()):
                if not group.used[t]:
                    result[o].append(term)
                    continue
                constant = float(constants[t])
                result[o].append(
                    Linear(tuple(slopes[t].tolist()), constant) if isinstance(term, Linear) else Constant(constant)
                )
    return result


def present_values(fis: Sugeno, low: np.ndarray, span: np.ndarray) -> list[np.ndarray]:
    """The consequents that ``fis`` has now, in scaled units: the inverse of :func:`consequent_terms`."""
    result = []
    for group in output_groups(fis):
        columns = []
        for o in group.outputs:
            rows = []
            for term in fis.outputs[o].terms.values():
                *slopes, constant = [float(p) for p in term.parameters]
                slope = np.array(slopes or [0.0] * len(fis.inputs))
                rows.append(np.append(slope * span, constant + slope @ low))
            columns.append(np.concatenate([*rows, np.zeros(0)])[group.columns])
        result.append(np.stack(columns, axis=1))
    return result
