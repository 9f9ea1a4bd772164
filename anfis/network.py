"""The network: what training computes of a point, block by block, always through the one inference.

A point is the free premises and the consequents. Everything that sums over samples does so in blocks, so that data
larger than a block's activations need no more memory than one block.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any, NamedTuple
from weakref import WeakKeyDictionary

import torch

from anfis.consequents import Group, NormalEquations, design, equations, groups, range_of, solve, weights_gradient
from anfis.data import SampleArrays
from anfis.parameters import NetworkParameters
from anfis.point import Point, PointFit
from anfis.premises import premises
from fuzzy.inference import rule_weights
from fuzzy.system import Sugeno

_SMALL = 250_000  # numbers in a design matrix up to which one thread does


class Block(NamedTuple):
    """Some of the samples, inputs in units of their universes."""

    u: torch.Tensor  # (samples, inputs)
    x1: torch.Tensor  # (samples, inputs + 1): u and 1
    y: torch.Tensor  # (samples, outputs), in the outputs' own units


@dataclass(frozen=True, eq=False)
class Network(NetworkParameters):
    """A Sugeno system as a function of a point, with the sums over samples that learning needs."""

    groups: tuple[Group, ...]
    # Samples of a single block are scaled once, not once an epoch.
    _scaled: WeakKeyDictionary[SampleArrays, Block] = field(default_factory=WeakKeyDictionary, init=False, repr=False)

    def samples(self, data: SampleArrays) -> SampleArrays:
        """The samples as tensors, as this network takes them."""
        low = self.premises.low
        return data.to(low.dtype, str(low.device))

    def array(self, values: Any) -> torch.Tensor:
        """Numbers of a checkpoint as a tensor of this network."""
        return torch.as_tensor(values).to(self.premises.low)

    def units(self, data: SampleArrays) -> Iterator[torch.Tensor]:
        """The samples' scaled inputs (samples, inputs), some at a time."""
        return (block.u for block in self._blocks(data))

    def normal_equations(self, a: torch.Tensor, y: torch.Tensor) -> NormalEquations:
        """Those of ``a`` (samples, parameters) and ``y`` (samples, outputs), in double precision."""
        return equations(a, y)

    @contextmanager
    def threads(self, count: int) -> Iterator[None]:
        """One thread for few samples, where waiting costs more than the arithmetic; the setting is restored."""
        before = torch.get_num_threads()
        small = before > 1 and min(count, self.block) * self.columns < _SMALL
        if small:
            torch.set_num_threads(1)
        try:
            yield
        finally:
            if small:
                torch.set_num_threads(before)

    def weights(self, free: Sequence[torch.Tensor], u: torch.Tensor) -> torch.Tensor:
        """The rules' weights (samples, rules) at scaled inputs ``u``; firing strengths for a weighted sum."""
        return self._rules(self.premises.natural(free), u)[1]

    def _rules(self, natural: Sequence[torch.Tensor], u: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """Firing strengths, and what counts as :meth:`weights`, of the memberships' own parameters."""
        firing, weights = rule_weights(self.fis, u, natural)
        return firing, weights if self.normalise else firing

    def designs(self, free: Sequence[torch.Tensor], u: torch.Tensor) -> tuple[list[torch.Tensor], torch.Tensor | None]:
        """Each group's design matrix (samples, parameters), and what stands where no rule fires.

        The latter is (samples, outputs): the middle of the output's range there, 0 elsewhere; None where some rule
        fires at every sample. A sample where none fires has a row of zeros and so no say in the least squares, but
        its error counts.
        """
        return self._designs(self.weights(free, u), _with_one(u))

    def _designs(self, weights: torch.Tensor, x1: torch.Tensor) -> tuple[list[torch.Tensor], torch.Tensor | None]:
        matrices = [design(g, weights, x1, self.normalise) for g in self.groups]
        silent = self._silent(weights.detach())
        if silent is None:
            return matrices, None
        return matrices, silent * x1.new_tensor([v.midrange for v in self.fis.outputs])

    def _silent(self, weights: torch.Tensor) -> torch.Tensor | None:
        """(samples, outputs) bool: does no rule for that output fire? None where some rule always does."""
        found = [(weights.sum(dim=1) if g.everyone else (weights @ g.share).sum(dim=1)) <= 0 for g in self.groups]
        if not any(bool(none.any()) for none in found):
            return None
        result = torch.empty(len(weights), len(self.fis.outputs), dtype=torch.bool, device=weights.device)
        for g, none in zip(self.groups, found, strict=True):
            result[:, list(g.outputs)] = none[:, None]
        return result

    def output(self, free: Sequence[torch.Tensor], values: Sequence[torch.Tensor], u: torch.Tensor) -> torch.Tensor:
        """The outputs (samples, outputs) at scaled inputs."""
        return self._assemble(*self.designs(free, u), values)

    def _assemble(
        self, matrices: Sequence[torch.Tensor], silent: torch.Tensor | None, values: Sequence[torch.Tensor]
    ) -> torch.Tensor:
        parts = [a @ v for a, v in zip(matrices, values, strict=True)]
        output = parts[0]
        if len(parts) > 1:
            order = [o for g in self.groups for o in g.outputs]
            place = sorted(range(len(order)), key=order.__getitem__)
            output = torch.cat(parts, dim=1)[:, place]
        return output if silent is None else output + silent

    def _blocks(self, data: SampleArrays) -> Iterator[Block]:
        if data.count <= self.block:
            if data not in self._scaled:
                self._scaled[data] = self._scale(data, slice(None))
            yield self._scaled[data]
            return
        for start in range(0, data.count, self.block):
            yield self._scale(data, slice(start, start + self.block))

    def _scale(self, data: SampleArrays, rows: slice) -> Block:
        x, y = data.rows(rows)
        u = self.premises.scale(x)
        return Block(u, _with_one(u), y)

    def fit(self, free: Sequence[torch.Tensor], data: SampleArrays, gradient: bool = False) -> PointFit:
        """Solve for the consequents by least squares: they, the error left, and its gradient to the premises if asked.

        The gradient holds the consequents: they are at their own minimum, where their change does not count (with a
        ridge that holds as nearly as the ridge is small). Samples of one block take one forward pass; more blocks take
        one pass for the equations and one for the rest.
        """
        leaves = [p.requires_grad_(gradient) for p in self.premises.natural([p.detach() for p in free])]
        whole = data.count <= self.block
        sums: list[NormalEquations] = []
        fires = [0] * len(self.groups)  # samples where a rule fires
        for block in self._blocks(data):
            with torch.set_grad_enabled(gradient and whole):
                firing, weights = self._rules(leaves, block.u)
            matrices, silent = self._designs(weights.detach(), block.x1)
            targets = [block.y[:, list(g.outputs)] if len(self.groups) > 1 else block.y for g in self.groups]
            pairs = zip(matrices, targets, strict=True)
            sums = (
                [s.plus(*pair) for s, pair in zip(sums, pairs, strict=True)]
                if sums
                else [equations(*pair) for pair in pairs]
            )
            if self.ridge:
                fires = [n + int(a.any(dim=1).sum()) for n, a in zip(fires, matrices, strict=True)]
        rows: list[tuple[torch.Tensor, torch.Tensor] | None]
        rows = [(a, t) if whole else None for a, t in zip(matrices, targets, strict=True)]
        if self.ridge:
            more = [self.ridge_rows(g, sums[g], n, data) for g, n in enumerate(fires)]
            sums = [s.plus(*pair) for s, pair in zip(sums, more, strict=True)]
            if whole:
                both = zip(matrices, targets, more, strict=True)
                rows = [(torch.cat([a, r[0]]), torch.cat([t, r[1]])) for a, t, r in both]
        solutions = [solve(e, r) for e, r in zip(sums, rows, strict=True)]
        solutions = [s._replace(values=s.values.to(leaves[0].dtype)) for s in solutions]
        values = [s.values for s in solutions]
        total = 0.0
        gradients = [torch.zeros_like(p) for p in leaves]
        for block in self._blocks(data):
            if not whole:
                with torch.set_grad_enabled(gradient):
                    firing, weights = self._rules(leaves, block.u)
                matrices, silent = self._designs(weights.detach(), block.x1)
            error = self._assemble(matrices, silent, values) - block.y
            total += float(error.square().sum())
            if gradient:
                pull = self._pull(weights.detach(), block.x1, values, 2 * error)
                parts = _gradients(firing, weights, leaves, pull)
                gradients = parts if whole else [g + p for g, p in zip(gradients, parts, strict=True)]
        gradients = self.premises.free_gradient([p.detach() for p in leaves], gradients)
        return PointFit(
            solutions, (total / (data.count * len(self.fis.outputs))) ** 0.5, gradients if gradient else None
        )

    def _pull(
        self, weights: torch.Tensor, x1: torch.Tensor, values: Sequence[torch.Tensor], error: torch.Tensor
    ) -> torch.Tensor:
        """∂ Σ error · output / ∂ weights, (samples, rules), with the error (samples, outputs) held."""
        parts = [
            weights_gradient(
                g, weights, x1, v, error[:, list(g.outputs)] if len(self.groups) > 1 else error, self.normalise
            )
            for g, v in zip(self.groups, values, strict=True)
        ]
        return parts[0] if len(parts) == 1 else torch.stack(parts).sum(dim=0)

    @torch.no_grad()
    def rmse(self, point: Point, data: SampleArrays) -> float:
        """The root mean square error at ``point`` over samples and outputs, in the outputs' unit."""
        total = 0.0
        for block in self._blocks(data):
            total += float((self.output(point.free, point.values, block.u) - block.y).square().sum())
        return (total / (data.count * len(self.fis.outputs))) ** 0.5

    @torch.no_grad()
    def silent(self, free: Sequence[torch.Tensor], data: SampleArrays) -> int:
        """The number of samples at which no rule fires for some output."""
        count = 0
        for block in self._blocks(data):
            silent = self._silent(self.weights(free, block.u))
            count += int(silent.any(dim=1).sum()) if silent is not None else 0
        return count

    def reduced(self, point: Point, data: SampleArrays) -> tuple[torch.Tensor, torch.Tensor]:
        """Jᵀ J and Jᵀ r of the reduced residual, consequents eliminated   [Kaufman 1975].

        J is the Jacobian of the output to the free premises with the consequents held, less what the consequents can
        make up for: J − A A⁺ J. A, J and r are gathered block by block into one triangle (QR), which keeps what their
        squares would lose; a ridge is more rows of A, at which J is 0.
        """
        triangles: list[torch.Tensor] = []
        natural = self.premises.natural([p.detach() for p in point.free])
        fires = [0] * len(self.groups)  # samples where a rule fires
        for block in self._blocks(data):
            leaves = [p.expand(len(block.u), *p.shape).clone().requires_grad_() for p in natural]
            firing, weights = self._rules(leaves, block.u)
            matrices, silent = self._designs(weights.detach(), block.x1)
            residual = block.y - self._assemble(matrices, silent, point.values)
            if self.ridge:
                fires = [n + int(a.any(dim=1).sum()) for n, a in zip(fires, matrices, strict=True)]
            jacobians = self._jacobians(firing, weights, leaves, block.x1, point.values)
            for k, (a, g) in enumerate(zip(matrices, self.groups, strict=True)):
                rows = torch.cat([a, *(jacobians[o] for o in g.outputs), residual[:, list(g.outputs)]], dim=1)
                if k < len(triangles):
                    triangles[k] = torch.linalg.qr(torch.cat([triangles[k], rows]), mode="r").R
                else:
                    triangles.append(torch.linalg.qr(rows, mode="r").R)
        if self.ridge:
            triangles = [self.with_ridge(g, triangles[g], point.values[g], n, data) for g, n in enumerate(fires)]
        parts = []
        for g, triangle in zip(self.groups, triangles, strict=True):
            n, q = len(g.columns), len(g.outputs)
            basis, _, _ = range_of(triangle[:, :n])
            for j, jacobian in enumerate(triangle[:, n:-q].chunk(q, dim=1)):
                own = jacobian - basis @ (basis.T @ jacobian)
                parts.append((own.T @ own, own.T @ triangle[:, j - q]))
        return sum(p[0] for p in parts), sum(p[1] for p in parts)  # type: ignore[return-value]

    def _jacobians(
        self,
        firing: torch.Tensor,
        weights: torch.Tensor,
        leaves: Sequence[torch.Tensor],
        x1: torch.Tensor,
        values: Sequence[torch.Tensor],
    ) -> list[torch.Tensor]:
        """∂ output / ∂ free premises (samples, parameters) an output: one backward pass an output.

        Every sample has premises of its own in ``leaves`` (expanded), so that the gradient of the summed output is the
        Jacobian, sample by sample.
        """
        count = len(self.fis.outputs)
        jacobians = []
        for o in range(count):
            error = x1.new_zeros(len(x1), count)
            error[:, o] = 1.0
            rows = _gradients(firing, weights, leaves, self._pull(weights.detach(), x1, values, error), o + 1 < count)
            free = self.premises.free_gradient([p.detach() for p in leaves], rows)
            jacobians.append(torch.cat([r.flatten(1) for r in free], dim=1))
        return jacobians


def _with_one(u: torch.Tensor) -> torch.Tensor:
    """[u, 1] (samples, inputs + 1); a column is in one piece, as in a design matrix."""
    return torch.cat([u.T, torch.ones_like(u[:, :1]).T]).T


def _gradients(
    firing: torch.Tensor,
    weights: torch.Tensor,
    leaves: Sequence[torch.Tensor],
    pull: torch.Tensor,
    again: bool = False,
) -> list[torch.Tensor]:
    """The gradient of Σ pull · weights to each of ``leaves``, 0 where it does not depend on them.

    Weights that are firing strengths over their sum are differentiated as such, which is half the way back through
    the softmax that keeps them from underflow; where a sum comes near underflow, through the softmax.
    """
    if not weights.requires_grad:
        return [torch.zeros_like(p) for p in leaves]
    if weights is not firing:
        total = firing.detach().sum(dim=1, keepdim=True)
        if float(total.min()) > torch.finfo(total.dtype).tiny ** 0.5:
            pull = (pull - (weights.detach() * pull).sum(dim=1, keepdim=True)) / total
            weights = firing
    found = torch.autograd.grad(weights, leaves, pull, retain_graph=again, allow_unused=True)
    return [torch.zeros_like(p) if g is None else g for p, g in zip(leaves, found, strict=True)]


def make_network(fis: Sugeno, dtype: str, device: str, keep_order: bool, ridge: float, block: int) -> Network:
    """The network of ``fis``, which has plain numbers; ``dtype`` is torch's name of a type of number."""
    kind = getattr(torch, dtype)
    held = premises(fis, dtype=kind, device=device, keep_order=keep_order)
    return Network(held, groups(fis, kind, device), ridge, block)
