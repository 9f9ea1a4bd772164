"""The network: what training computes of a point, block by block, always through the one inference.

A point is the free premises and the consequents. Everything that sums over samples does so in blocks, so that data
larger than a block's activations need no more memory than one block.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import torch

from anfis.consequents import (
    Group,
    NormalEquations,
    Solution,
    consequent_terms,
    design,
    empty_equations,
    present_values,
    range_of,
    solve,
)
from anfis.data import Samples
from anfis.premises import Premises, Tensors
from fuzzy.inference import rule_weights
from fuzzy.system import Sugeno


class Fit(NamedTuple):
    """The best that the consequents can do for given premises."""

    solutions: list[Solution]  # one a group
    rmse: float  # over samples and outputs
    gradient: list[torch.Tensor] | None  # of the sum of squares, to the free premises


class Point(NamedTuple):
    """Where learning is."""

    free: Tensors  # the premises, see :class:`anfis.premises.Premises`
    values: list[torch.Tensor]  # the consequents in scaled units, (parameters, outputs) a group


@dataclass(frozen=True, eq=False)
class Network:
    """A Sugeno system as learning sees it."""

    premises: Premises
    groups: tuple[Group, ...]
    ridge: float
    block: int  # samples at a time

    @property
    def fis(self) -> Sugeno:
        """The system that learning started from: its structure stays."""
        return self.premises.fis

    @property
    def count(self) -> int:
        """How many numbers are learnt."""
        return sum(p.numel() for p in self.premises.signs) + sum(len(g.columns) * len(g.outputs) for g in self.groups)

    def start(self) -> Point:
        """The point where the system is now."""
        p = self.premises
        return Point(p.valid(p.start()), present_values(self.fis, self.groups, p.low, p.span))

    def system(self, point: Point) -> Sugeno:
        """The system at ``point``, in the inputs' own units, with plain numbers."""
        p = self.premises
        return p.system(point.free, consequent_terms(self.fis, self.groups, point.values, p.low, p.span))

    def weights(self, free: Sequence[torch.Tensor], u: torch.Tensor) -> torch.Tensor:
        """The rules' weights (samples, rules) at scaled inputs ``u``; firing strengths for a weighted sum."""
        firing, weights = rule_weights(self.fis, u, self.premises.natural(free))
        return firing if self.fis.defuzzification == "wtsum" else weights

    def designs(self, free: Sequence[torch.Tensor], u: torch.Tensor) -> tuple[list[torch.Tensor], torch.Tensor | None]:
        """Each group's design matrix (samples, parameters), and what stands where no rule fires.

        The latter is (samples, outputs): the middle of the output's range there, 0 elsewhere; None where some rule
        fires at every sample. A sample where none fires has a row of zeros and so no say in the least squares, but
        its error counts.
        """
        weights = self.weights(free, u)
        u1 = torch.cat([u, torch.ones_like(u[:, :1])], dim=1)
        matrices = [design(g, weights, u1, self.fis.defuzzification == "wtaver") for g in self.groups]
        silent = self._silent(weights.detach())
        if not bool(silent.any()):
            return matrices, None
        return matrices, silent * u.new_tensor([v.midrange for v in self.fis.outputs])

    def _silent(self, weights: torch.Tensor) -> torch.Tensor:
        """(samples, outputs) bool: does no rule for that output fire?"""
        result = torch.empty(len(weights), len(self.fis.outputs), dtype=torch.bool, device=weights.device)
        for g in self.groups:
            total = weights.sum(dim=1) if g.everyone else (weights @ g.share).sum(dim=1)
            result[:, list(g.outputs)] = (total <= 0)[:, None]
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

    def _blocks(self, data: Samples) -> Iterator[tuple[torch.Tensor, torch.Tensor]]:
        for start in range(0, data.count, self.block):
            x, y = data.rows(slice(start, start + self.block))
            yield self.premises.scale(x), y

    def fit(self, free: Sequence[torch.Tensor], data: Samples, gradient: bool = False) -> Fit:
        """The consequents by least squares, the squared error left, and its gradient to the premises if asked.

        The gradient holds the consequents: they are at their own minimum, where their change does not count (with a
        ridge that holds as nearly as the ridge is small). Samples of one block take one forward pass; more blocks take
        one pass for the equations and one for the rest.
        """
        leaves = [p.detach().clone().requires_grad_(gradient) for p in free]
        whole = data.count <= self.block
        equations: list[NormalEquations] = []
        kept: tuple[list[torch.Tensor], torch.Tensor | None] = ([], None)
        with torch.set_grad_enabled(gradient and whole):
            for u, y in self._blocks(data):
                kept = self.designs(leaves, u)
                held = [a.detach() for a in kept[0]]
                targets = [y[:, list(g.outputs)] for g in self.groups]
                if not equations:
                    equations = [empty_equations(a, t) for a, t in zip(held, targets, strict=True)]
                equations = [e.plus(a, t) for e, a, t in zip(equations, held, targets, strict=True)]
        blocks = [(a.detach(), t) if whole else None for a, t in zip(kept[0], targets, strict=True)]
        solutions = [solve(e, self.ridge, rows) for e, rows in zip(equations, blocks, strict=True)]
        solutions = [s._replace(values=s.values.to(leaves[0].dtype)) for s in solutions]
        values = [s.values for s in solutions]
        total = 0.0
        with torch.set_grad_enabled(gradient):
            for u, y in self._blocks(data):
                matrices, silent = kept if whole else self.designs(leaves, u)
                loss = (self._assemble(matrices, silent, values) - y).square().sum()
                if gradient:
                    loss.backward()
                total += float(loss.detach())
        gradients = [torch.zeros_like(p) if p.grad is None else p.grad for p in leaves] if gradient else None
        return Fit(solutions, (total / (data.count * len(self.fis.outputs))) ** 0.5, gradients)

    @torch.no_grad()
    def rmse(self, point: Point, data: Samples) -> float:
        """Root mean square error over samples and outputs."""
        total = 0.0
        for u, y in self._blocks(data):
            total += float((self.output(point.free, point.values, u) - y).square().sum())
        return (total / (data.count * len(self.fis.outputs))) ** 0.5

    @torch.no_grad()
    def silent(self, free: Sequence[torch.Tensor], data: Samples) -> int:
        """How many samples leave some output without a rule that fires."""
        count = 0
        for u, _ in self._blocks(data):
            count += int(self._silent(self.weights(free, u)).any(dim=1).sum())
        return count

    def reduced(self, point: Point, data: Samples) -> tuple[torch.Tensor, torch.Tensor]:
        """Jᵀ J and Jᵀ r of the reduced residual, consequents eliminated   [Kaufman 1975].

        J is the Jacobian of the output to the free premises with the consequents held, less what the consequents can
        make up for: J − A A⁺ J. With samples of one block the projection is that of A's singular vectors; with more
        blocks J is never formed whole and the projection is applied to the sums, which is less precise.
        """
        if data.count <= self.block:
            return self._reduced_whole(point, data)
        sums: list[list[torch.Tensor]] = []
        for u, y in self._blocks(data):
            with torch.no_grad():
                matrices, _ = self.designs(point.free, u)
            jacobians, outputs = self._jacobians(point, u)
            residual = y - outputs
            for k, (a, group) in enumerate(zip(matrices, self.groups, strict=True)):
                if len(sums) <= k:
                    sums.append([])
                for j, o in enumerate(group.outputs):
                    jacobian = jacobians[o]
                    parts = [
                        jacobian.T @ jacobian,
                        jacobian.T @ residual[:, o],
                        a.T @ jacobian,
                        a.T @ residual[:, o],
                        a.T @ a,
                    ]
                    if len(sums[k]) <= j * 5:
                        sums[k] += parts
                    else:
                        for i, part in enumerate(parts):
                            sums[k][j * 5 + i] = sums[k][j * 5 + i] + part
        jtj: torch.Tensor | None = None
        jtr: torch.Tensor | None = None
        for group, held in zip(self.groups, sums, strict=True):
            for j in range(len(group.outputs)):
                jj, jr, aj, ar, aa = held[j * 5 : j * 5 + 5]
                made_up = solve(NormalEquations(aa, aj), self.ridge).values
                jj = jj - aj.T @ made_up
                jr = jr - made_up.T @ ar
                jtj = jj if jtj is None else jtj + jj
                jtr = jr if jtr is None else jtr + jr
        assert jtj is not None
        assert jtr is not None
        return (jtj + jtj.T) / 2, jtr

    def _reduced_whole(self, point: Point, data: Samples) -> tuple[torch.Tensor, torch.Tensor]:
        ((u, y),) = self._blocks(data)
        with torch.no_grad():
            matrices, _ = self.designs(point.free, u)
        jacobians, outputs = self._jacobians(point, u)
        parts = []
        for a, group in zip(matrices, self.groups, strict=True):
            basis, _, _ = range_of(a)
            for o in group.outputs:
                own = jacobians[o] - basis @ (basis.T @ jacobians[o])
                parts.append((own.T @ own, own.T @ (y - outputs)[:, o]))
        return sum(p[0] for p in parts), sum(p[1] for p in parts)  # type: ignore[return-value]

    def _jacobians(self, point: Point, u: torch.Tensor) -> tuple[list[torch.Tensor], torch.Tensor]:
        """∂ output / ∂ free premises (samples, parameters) an output, and the outputs: one backward pass an output.

        Every sample gets premises of its own (expanded, not copied), so that the gradient of the summed output is the
        Jacobian, sample by sample.
        """
        leaves = [p.detach().expand(len(u), *p.shape).clone().requires_grad_() for p in point.free]
        outputs = self.output(leaves, point.values, u)
        jacobians = []
        for o in range(outputs.shape[1]):
            rows = torch.autograd.grad(outputs[:, o].sum(), leaves, retain_graph=o + 1 < outputs.shape[1])
            jacobians.append(torch.cat([r.flatten(1) for r in rows], dim=1))
        return jacobians, outputs.detach()

    def unflatten(self, flat: torch.Tensor) -> Tensors:
        """Free premises from one vector of all."""
        result, start = [], 0
        for sign in self.premises.signs:
            result.append(flat[start : start + sign.numel()].reshape(sign.shape))
            start += sign.numel()
        return tuple(result)
