"""The premises as arrays that an optimiser may move freely: scaled, positive where they must be, valid in order.

Inside, every input is measured from the low end of its universe of discourse in units of its span, so that one step
size suits all of them. Widths and shapes are learnt as logarithms: they cannot collapse to 0 or change sign. The arrays
are numpy's in compiled learning, torch's otherwise; torch is imported only for these.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from array_api_compat import array_namespace, device

from anfis.point import Array
from fuzzy.errors import InputError
from fuzzy.inference import premise_parameters
from fuzzy.membership import Bell, Gaussian
from fuzzy.system import Sugeno, TermKind

Arrays = tuple[Array, ...]

_WIDTHS = (1e-3, 1e2)  # of the universe: narrower or wider than this a term says nothing
_SHAPES = (0.1, 50.0)  # a bell's steepness
_COVER = 0.1  # with ``keep_order`` neighbours cross at this degree or higher


@dataclass(frozen=True, eq=False)
class Premises:
    """How the premises of ``fis`` are learnt: free arrays (terms, parameters), one a kind of membership function."""

    fis: Sugeno
    low: Array  # (inputs,)
    span: Array  # (inputs,)
    keep_order: bool = False  # memberships of an input stay ordered by their centers, and covering
    signs: Arrays = field(default=())  # per kind, the sign of widths and shapes
    order: tuple[np.ndarray, ...] = field(default=())  # per input its terms by center, with ``keep_order``

    def scale(self, x: Array) -> Array:
        """Scale ``x`` (..., inputs) to units of the universes, and clip it to them if the system clips its inputs."""
        unit = (x - self.low) / self.span
        return self._xp.clip(unit, 0.0 * self.high, self.high) if self.fis.out_of_range == "clip" else unit

    @cached_property
    def _xp(self) -> Any:
        """The library of the arrays."""
        return np if isinstance(self.low, np.ndarray) else array_namespace(self.low)

    def _array(self, values: Any) -> Array:
        """Numbers as an array of the library, type and device of the others."""
        return self._xp.asarray(values, dtype=self.low.dtype, device=device(self.low))

    @cached_property
    def high(self) -> Array:
        """(inputs,) the high ends of the universes in their own units: 1, or 0 for a universe of a single value."""
        return (self._array([v.universe[1] for v in self.fis.inputs]) - self.low) / self.span

    def natural(self, free: Sequence[Array]) -> Arrays:
        """The membership functions' parameters, in scaled units, of free arrays (..., terms, parameters)."""
        xp = self._xp
        return tuple(
            xp.where(positive, sign * xp.exp(xp.where(positive, tensor, xp.zeros_like(tensor))), tensor)
            for tensor, sign, positive in zip(free, self.signs, self._positive, strict=True)
        )

    def free_gradient(self, natural: Sequence[Array], gradient: Sequence[Array]) -> list[Array]:
        """The gradient to the free arrays, from the ``gradient`` to the parameters of :meth:`natural`."""
        return [
            self._xp.where(positive, g * p, g) for p, g, positive in zip(natural, gradient, self._positive, strict=True)
        ]

    @cached_property
    def _positive(self) -> Arrays:
        """Per kind (parameters,) bool: which are learnt as logarithms."""
        return tuple(
            self._xp.asarray([role in ("width", "shape") for role in kind.function.roles], device=device(self.low))
            for kind in self.fis.structure.kinds
        )

    def start(self) -> Arrays:
        """Free arrays for the parameters that ``fis`` has now."""
        return self._start

    @cached_property
    def _start(self) -> Arrays:
        result = []
        for kind, natural in zip(self.fis.structure.kinds, self._scaled(), strict=True):
            columns = [
                self._log(natural[:, k]) if role in ("width", "shape") else natural[:, k]
                for k, role in enumerate(kind.function.roles)
            ]
            result.append(self._xp.stack(columns, axis=-1))
        return tuple(result)

    def _log(self, values: Array) -> Array:
        with np.errstate(divide="ignore"):  # a bell's steepness may be 0
            return self._xp.log(self._xp.abs(values))

    def _scaled(self) -> list[Array]:
        result = []
        for kind, natural in zip(self.fis.structure.kinds, premise_parameters(self.fis, self.low), strict=True):
            natural = 1.0 * natural  # a copy
            low, span = self._universes(kind)
            for k, role in enumerate(kind.function.roles):
                natural[:, k] = _to_unit(natural[:, k], role, low, span)
            result.append(natural)
        return result

    def _universes(self, kind: TermKind) -> tuple[Array, Array]:
        """Low ends and spans (terms,) of the universes of a kind's terms."""
        inputs = self._xp.asarray(kind.inputs, device=device(self.low))
        return self.low[inputs], self.span[inputs]

    def valid(self, free: Sequence[Array]) -> Arrays:
        """The nearest free arrays that make legal membership functions (feet in order, widths within reason)."""
        xp, result = self._xp, []
        for kind, tensor in zip(self.fis.structure.kinds, free, strict=True):
            tensor = 1.0 * tensor  # a copy
            for k, role in enumerate(kind.function.roles):
                if role in ("width", "shape"):
                    least, most = _WIDTHS if role == "width" else _SHAPES
                    tensor[..., k] = xp.clip(tensor[..., k], math.log(least), math.log(most))
                if role == "slope":
                    tensor[..., k] = xp.clip(tensor[..., k], -1 / _WIDTHS[0], 1 / _WIDTHS[0])
            for columns in kind.function.ascending():
                index = list(columns)
                tensor[..., index] = xp.sort(tensor[..., index], axis=-1)
            result.append(tensor)
        return self._ordered(result) if self.keep_order else tuple(result)

    def _ordered(self, free: list[Array]) -> Arrays:
        # Gaussians (width, center) and bells (width, shape, center): the first column is the width, the last the
        # center. ``premises`` has checked that nothing else is asked for.
        for kind, tensor in zip(self.fis.structure.kinds, free, strict=True):
            for i, terms in enumerate(self.order):
                rows = np.flatnonzero(kind.inputs == i)
                if len(rows) < 2:
                    continue
                ranked = rows[terms].tolist()
                for left, right in pairwise(ranked):
                    tensor[right, -1] = max(tensor[left, -1], tensor[right, -1])
                for left, right in pairwise(ranked):
                    reach = (-2 * math.log(_COVER)) ** 0.5
                    if tensor.shape[1] == 3:
                        steep = math.exp(max(tensor[left, 1], tensor[right, 1]))
                        reach = ((1 - _COVER) / _COVER) ** (0.5 / steep)
                    gap = float(tensor[right, -1] - tensor[left, -1])
                    width = math.exp(tensor[left, 0]) + math.exp(tensor[right, 0])
                    lacking = math.log(max(gap / (reach * width), 1.0))
                    tensor[left, 0] += lacking
                    tensor[right, 0] += lacking
        return tuple(free)

    def system(self, free: Sequence[Array], consequents: "list[list[Any]]", live: bool = False) -> Sugeno:
        """The Sugeno system with these premises, in the inputs' own units, and ``consequents`` an output.

        A term that did not move keeps its parameters to the last bit. If ``live``, parameters are arrays of the
        library, which gradients reach.
        """
        present = [f for v in self.fis.inputs for f in v.terms.values()]
        functions: dict[int, Any] = {}
        for kind, natural, moved, start in zip(
            self.fis.structure.kinds, self.natural(free), free, self._start, strict=True
        ):
            low, span = self._universes(kind)
            columns = [_from_unit(natural[:, k], role, low, span) for k, role in enumerate(kind.function.roles)]
            columns = columns if live else [column.tolist() for column in columns]
            for row, term in enumerate(kind.terms):
                same = not live and bool(self._xp.all(moved[row] == start[row]))
                functions[int(term)] = present[term] if same else kind.function(*(column[row] for column in columns))
        in_order = iter([functions[term] for term in range(len(present))])
        inputs = [replace(v, terms={name: next(in_order) for name in v.terms}) for v in self.fis.inputs]
        outputs = [
            replace(variable, terms=dict(zip(variable.terms, values, strict=True)))
            for variable, values in zip(self.fis.outputs, consequents, strict=True)
        ]
        return replace(self.fis, inputs=inputs, outputs=outputs)


def _to_unit(value: Array, role: str, low: Array, span: Array) -> Array:
    if role == "location":
        return (value - low) / span
    return value / span if role == "width" else value * span if role == "slope" else value


def _from_unit(value: Array, role: str, low: Array, span: Array) -> Array:
    if role == "location":
        return low + value * span
    return value * span if role == "width" else value / span if role == "slope" else value


def premises(fis: Sugeno, *, dtype: Any = np.float64, device: str = "cpu", keep_order: bool = False) -> Premises:
    """How to learn the premises of ``fis``, which has plain numbers, as arrays of ``dtype``: numpy's or torch's.

    Raises InputError where ``keep_order`` cannot be kept.
    """
    ends = np.array([v.universe for v in fis.inputs]).T
    spans = np.where(ends[1] > ends[0], ends[1] - ends[0], 1.0)
    low, span = (_made(values, dtype, device) for values in (ends[0], spans))
    order: list[np.ndarray] = []
    if keep_order:
        for variable in fis.inputs:
            kinds = {type(f) for f in variable.terms.values()}
            if len(kinds) > 1 or not kinds <= {Gaussian, Bell}:
                raise InputError(
                    f"keep_order: the terms of {variable.name!r} must all be Gaussians or all bells, got "
                    + ", ".join(sorted(k.__name__ for k in kinds))
                )
            order.append(np.argsort([float(f.c) for f in variable.terms.values()], kind="stable"))
    draft = Premises(fis, low, span, keep_order, (), tuple(order))
    signs = tuple(draft._array([[-1.0 if n < 0 else 1.0 for n in row] for row in each]) for each in draft._scaled())
    return replace(draft, signs=signs)


def _made(values: np.ndarray, dtype: Any, device: str) -> Array:
    """``values`` as an array of ``dtype``; one that is not numpy's is torch's."""
    if isinstance(dtype, type) and issubclass(dtype, np.generic):
        return values.astype(dtype)
    import torch

    return torch.as_tensor(values, dtype=dtype, device=device)
