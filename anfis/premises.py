"""The premises as tensors that an optimiser may move freely: scaled, positive where they must be, valid in order.

Inside, every input is measured from the low end of its universe of discourse in units of its span, so that one step
size suits all of them. Widths and shapes are learnt as logarithms: they cannot collapse to 0 or change sign.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
import torch

from fuzzy.errors import InputError
from fuzzy.inference import premise_parameters
from fuzzy.membership import Bell, Gaussian
from fuzzy.system import Sugeno, Variable

Tensors = tuple[torch.Tensor, ...]

_WIDTHS = (1e-3, 1e2)  # of the universe: narrower or wider than this a term says nothing
_SHAPES = (0.1, 50.0)  # a bell's steepness
_COVER = 0.1  # with ``keep_order`` neighbours cross at this degree or higher


@dataclass(frozen=True, eq=False)
class Premises:
    """How the premises of ``fis`` are learnt: free tensors (terms, parameters), one a kind of membership function."""

    fis: Sugeno
    low: torch.Tensor  # (inputs,)
    span: torch.Tensor  # (inputs,)
    keep_order: bool = False  # memberships of an input stay ordered by their centers, and covering
    signs: Tensors = field(default=())  # per kind, the sign of widths and shapes
    order: tuple[np.ndarray, ...] = field(default=())  # per input its terms by center, with ``keep_order``

    def scale(self, x: torch.Tensor) -> torch.Tensor:
        """Scale ``x`` (..., inputs) to units of the universes, and clip it to them if the system clips its inputs."""
        unit = (x - self.low) / self.span
        return unit.clamp(torch.zeros_like(self.high), self.high) if self.fis.out_of_range == "clip" else unit

    @property
    def high(self) -> torch.Tensor:
        """(inputs,) the high ends of the universes in their own units: 1, or 0 for a universe of a single value."""
        ends = self.low.new_tensor([v.universe[1] for v in self.fis.inputs])
        return (ends - self.low) / self.span

    def natural(self, free: Sequence[torch.Tensor]) -> Tensors:
        """The membership functions' parameters, in scaled units, of free tensors (..., terms, parameters)."""
        return tuple(
            torch.where(positive, sign * torch.exp(torch.where(positive, tensor, 0.0)), tensor)
            for tensor, sign, positive in zip(free, self.signs, self._positive, strict=True)
        )

    def free_gradient(self, natural: Sequence[torch.Tensor], gradient: Sequence[torch.Tensor]) -> list[torch.Tensor]:
        """The gradient to the free tensors, from the ``gradient`` to the parameters of :meth:`natural`."""
        return [
            torch.where(positive, g * p, g) for p, g, positive in zip(natural, gradient, self._positive, strict=True)
        ]

    @cached_property
    def _positive(self) -> Tensors:
        """Per kind (parameters,) bool: which are learnt as logarithms."""
        return tuple(
            torch.tensor([role in ("width", "shape") for role in kind.function.roles], device=self.low.device)
            for kind in self.fis.structure.kinds
        )

    def start(self) -> Tensors:
        """Free tensors for the parameters that ``fis`` has now."""
        result = []
        for kind, natural in zip(self.fis.structure.kinds, self._scaled(), strict=True):
            columns = [
                torch.log(natural[:, k].abs()) if role in ("width", "shape") else natural[:, k]
                for k, role in enumerate(kind.function.roles)
            ]
            result.append(torch.stack(columns, dim=-1))
        return tuple(result)

    def _scaled(self) -> list[torch.Tensor]:
        result = []
        for kind, natural in zip(self.fis.structure.kinds, premise_parameters(self.fis, self.low), strict=True):
            natural = natural.detach().clone()
            low, span = self.low[torch.as_tensor(kind.inputs)], self.span[torch.as_tensor(kind.inputs)]
            for k, role in enumerate(kind.function.roles):
                natural[:, k] = _to_unit(natural[:, k], role, low, span)
            result.append(natural)
        return result

    def valid(self, free: Sequence[torch.Tensor]) -> Tensors:
        """The nearest free tensors that make legal membership functions (feet in order, widths within reason)."""
        result = []
        for kind, tensor in zip(self.fis.structure.kinds, free, strict=True):
            tensor = tensor.clone()
            for k, role in enumerate(kind.function.roles):
                if role in ("width", "shape"):
                    least, most = _WIDTHS if role == "width" else _SHAPES
                    tensor[..., k] = tensor[..., k].clamp(float(np.log(least)), float(np.log(most)))
                if role == "slope":
                    tensor[..., k] = tensor[..., k].clamp(-1 / _WIDTHS[0], 1 / _WIDTHS[0])
            for columns in kind.function.ascending():
                index = list(columns)
                tensor[..., index] = tensor[..., index].sort(dim=-1).values
            result.append(tensor)
        return self._ordered(result) if self.keep_order else tuple(result)

    def _ordered(self, free: list[torch.Tensor]) -> Tensors:
        # Gaussians (width, center) and bells (width, shape, center): the first column is the width, the last the
        # center. ``premises`` has checked that nothing else is asked for.
        for kind, tensor in zip(self.fis.structure.kinds, free, strict=True):
            for i, terms in enumerate(self.order):
                rows = np.flatnonzero(kind.inputs == i)
                if len(rows) < 2:
                    continue
                ranked = torch.as_tensor(rows[terms])
                centers = torch.cummax(tensor[ranked, -1], dim=0).values
                tensor[ranked, -1] = centers
                for left, right in pairwise(ranked):
                    steep = (
                        torch.exp(torch.maximum(tensor[left, 1], tensor[right, 1])) if tensor.shape[1] == 3 else None
                    )
                    reach = (
                        (-2 * np.log(_COVER)) ** 0.5
                        if steep is None
                        else ((1 - _COVER) / _COVER) ** (0.5 / float(steep))
                    )
                    gap = tensor[right, -1] - tensor[left, -1]
                    width = torch.exp(tensor[left, 0]) + torch.exp(tensor[right, 0])
                    lacking = torch.log((gap / (reach * width)).clamp_min(1.0))
                    tensor[left, 0] += lacking
                    tensor[right, 0] += lacking
        return tuple(free)

    def system(self, free: Sequence[torch.Tensor], consequents: "list[list[Any]]") -> Sugeno:
        """The Sugeno system with these premises, in the inputs' own units, and ``consequents`` an output.

        A term that did not move keeps its parameters to the last bit.
        """
        present = [f for v in self.fis.inputs for f in v.terms.values()]
        functions: dict[int, Any] = {}
        for kind, natural, moved, start in zip(
            self.fis.structure.kinds, self.natural(free), free, self.start(), strict=True
        ):
            low, span = self.low[torch.as_tensor(kind.inputs)], self.span[torch.as_tensor(kind.inputs)]
            columns = [
                _from_unit(natural[:, k], role, low, span).tolist() for k, role in enumerate(kind.function.roles)
            ]
            for row, term in enumerate(kind.terms):
                same = torch.equal(moved[row], start[row])
                functions[int(term)] = present[term] if same else kind.function(*(column[row] for column in columns))
        number = 0
        inputs: list[Variable] = []
        for variable in self.fis.inputs:
            terms = {}
            for name in variable.terms:
                terms[name] = functions[number]
                number += 1
            inputs.append(replace(variable, terms=terms))
        outputs = [
            replace(variable, terms=dict(zip(variable.terms, values, strict=True)))
            for variable, values in zip(self.fis.outputs, consequents, strict=True)
        ]
        return replace(self.fis, inputs=inputs, outputs=outputs)


def _to_unit(value: torch.Tensor, role: str, low: torch.Tensor, span: torch.Tensor) -> torch.Tensor:
    if role == "location":
        return (value - low) / span
    return value / span if role == "width" else value * span if role == "slope" else value


def _from_unit(value: torch.Tensor, role: str, low: torch.Tensor, span: torch.Tensor) -> torch.Tensor:
    if role == "location":
        return low + value * span
    return value * span if role == "width" else value / span if role == "slope" else value


def premises(fis: Sugeno, *, dtype: torch.dtype, device: str, keep_order: bool = False) -> Premises:
    """How to learn the premises of ``fis``. Raises InputError where ``keep_order`` cannot be kept."""
    low = torch.tensor([v.universe[0] for v in fis.inputs], dtype=dtype, device=device)
    high = torch.tensor([v.universe[1] for v in fis.inputs], dtype=dtype, device=device)
    span = torch.where(high > low, high - low, torch.ones_like(low))
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
    signs = tuple(torch.where(natural < 0, -1.0, 1.0).to(dtype) for natural in draft._scaled())
    return replace(draft, signs=signs)
