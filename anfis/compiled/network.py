"""The network of :mod:`anfis.network` in compiled code: what training computes of a point, block by block."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any, NamedTuple, TypeVar

import numpy as np

from anfis.compiled import threads
from anfis.compiled.kernel import DESIGN, ERRORS, GRADIENT, JACOBIAN, KEEP, KEPT, sweep
from anfis.compiled.least_squares import Equations, eliminated, joined, plus, solve
from anfis.compiled.plan import CHUNK_LANES, KernelPlan, plan_of
from anfis.data import SampleArrays
from anfis.parameters import NetworkParameters
from anfis.point import Point, PointFit, numbers
from anfis.premises import premises
from fuzzy.compiled.tables import NUMBERS
from fuzzy.compiled.threads import share_out
from fuzzy.fitting.consequents import OutputGroup, output_groups
from fuzzy.system import Sugeno

_BLOCK = 2048  # samples whose sums are made in one piece: what a thread is given
_NOTHING, _NOWHERE = np.empty((0, 0)), np.zeros((3, 1), dtype=np.int64)
T = TypeVar("T")


class Swept(NamedTuple):
    """What a sweep finds in a block of samples."""

    squares: float  # the sum of the squared errors
    silent: int  # samples where no rule fires for some output
    slopes: np.ndarray  # (functions, 4): the gradient of ``squares`` to the membership functions' parameters
    made: np.ndarray  # (rows, samples): the matrices that were asked for
    fires: np.ndarray  # (groups,) int: samples where a rule of the group fires


@dataclass(frozen=True, eq=False)
class CompiledNetwork(NetworkParameters):
    """A Sugeno system as a function of a point, with the sums over samples that learning needs."""

    groups: tuple[OutputGroup, ...]
    _plan: KernelPlan = field(repr=False)
    # The last fit, and what it is of: a method that tries points has it measured once more at the one it takes.
    _last: list[Any] = field(default_factory=list, init=False, repr=False)

    # The system and its numbers -----------------------------------------------------------------------------------

    def samples(self, data: SampleArrays) -> SampleArrays:
        """The samples as this network takes them."""
        return data

    def array(self, values: Any) -> np.ndarray:
        """Numbers of a checkpoint as an array of this network."""
        return np.array(numbers(values))

    def units(self, data: SampleArrays) -> Iterator[np.ndarray]:
        """The samples' scaled inputs (samples, inputs), some at a time."""
        return (self.premises.scale(x) for x, _ in self._portions(data))

    def normal_equations(self, a: np.ndarray, y: np.ndarray) -> Equations:
        """Those of ``a`` (samples, parameters) and ``y`` (samples, outputs)."""
        return Equations(a.T @ a, a.T @ y)

    def threads(self, count: int) -> AbstractContextManager[None]:
        """The threads that suit ``count`` samples, while learning goes on."""
        return threads.one_for_linear_algebra()

    def _at(self, free: Sequence[np.ndarray]) -> tuple[list[np.ndarray], np.ndarray]:
        """The membership functions' parameters at ``free``, by kind and as the kernel takes them (functions, 4)."""
        natural, parameters = list(self.premises.natural(free)), np.zeros(self._plan.premise.shape)
        for kind, own in zip(self.fis.structure.kinds, natural, strict=True):
            parameters[kind.terms, : own.shape[1]] = own
        return natural, parameters

    def _by_kind(self, natural: Sequence[np.ndarray], gradient: np.ndarray) -> list[np.ndarray]:
        """The gradient to the free premises, from (functions, 4, ...) to the membership functions' parameters."""
        kinds = zip(self.fis.structure.kinds, natural, strict=True)
        return self.premises.free_gradient(natural, [gradient[k.terms, : p.shape[1]] for k, p in kinds])

    def _proposals(self, values: Sequence[np.ndarray]) -> np.ndarray:
        """The consequents (outputs, terms, inputs + 1) of the groups' ``values``."""
        result = np.zeros_like(self._no_proposals)
        flat = result.reshape(len(result), -1)
        for group, found in zip(self.groups, values, strict=True):
            for k, o in enumerate(group.outputs):
                flat[o, group.columns] = found[:, k]
        return result

    # Sums over samples --------------------------------------------------------------------------------------------

    def _portions(self, data: SampleArrays) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Inputs and outputs of some samples at a time, those that lie on disk read now."""
        for start in range(0, data.count, self.block):
            yield data.rows(slice(start, start + self.block))

    def _over_blocks(self, data: SampleArrays, work: Callable[[tuple[np.ndarray, np.ndarray]], T]) -> Iterator[T]:
        """What ``work`` makes of each block of samples, in the blocks' order."""
        for x, y in self._portions(data):
            blocks = [slice(start, start + _BLOCK) for start in range(0, len(x), _BLOCK)]
            yield from share_out(lambda one, x=x, y=y: work((x[one], y[one])), blocks, threads.count())  # type: ignore[misc]

    def _sweep(
        self,
        parameters: np.ndarray,
        samples: tuple[np.ndarray, np.ndarray],
        task: int,
        proposals: np.ndarray | None = None,
        factor: np.ndarray | None = None,
        kept: np.ndarray | None = None,
    ) -> Swept:
        """What the kernel finds in a block of samples; ``kept`` is filled with a design and used without one."""
        x, y = samples
        if kept is not None:
            task |= KEEP if task & DESIGN else KEPT
        slopes, fires = np.empty_like(parameters), np.zeros(len(self.groups), dtype=np.int64)
        if not task & (DESIGN | JACOBIAN):
            made, place = _NOTHING, _NOWHERE
        else:
            place, count = self._places[bool(task & JACOBIAN)]
            made = np.empty((count, len(x)))
            if not task & JACOBIAN:
                made[place[2]] = y.T
        squares, silent = sweep(
            self._plan,
            parameters,
            self._no_proposals if proposals is None else proposals,
            x,
            y,
            task,
            made,
            place,
            parameters if factor is None else factor,
            fires,
            slopes,
            _NOTHING if kept is None else kept,
        )
        return Swept(squares, silent, slopes, made, fires)

    @cached_property
    def _no_proposals(self) -> np.ndarray:
        shape = len(self.fis.outputs), max(1, int(self._plan.terms.max())), len(self.fis.inputs) + 1
        return np.zeros(shape)

    def _rows(self, g: int, jacobian: bool) -> slice:
        """The rows of group ``g`` in what a sweep makes: [A y] or [A J r], transposed."""
        (first, *_), rows = self._places[jacobian]
        return slice(first[g], first[g + 1] if g + 1 < len(self.groups) else rows)

    @cached_property
    def _places(self) -> tuple[tuple[np.ndarray, int], tuple[np.ndarray, int]]:
        """Where a sweep writes the groups' designs, the outputs' Jacobians and targets; how many rows there are."""
        found = []
        for size in (0, self.premise_count):
            place, row = np.zeros((3, len(self.fis.outputs)), dtype=np.int64), 0
            for g, group in enumerate(self.groups):
                place[0, g] = row
                row += len(group.columns)
                for o in group.outputs:
                    place[1, o] = row
                    row += size
                for o in group.outputs:
                    place[2, o] = row
                    row += 1
            found.append((place, row))
        return found[0], found[1]

    def _equations(
        self, parameters: np.ndarray, data: SampleArrays, kept: np.ndarray | None
    ) -> tuple[list[Equations], np.ndarray, np.ndarray | None]:
        """The groups' normal equations, where rules fire, and the designs with the targets if that is one block."""
        firing = np.zeros(len(self.groups), dtype=np.int64)
        grams: list[Any] = [0.0] * len(self.groups)
        design: np.ndarray | None = None

        def work(samples: tuple[np.ndarray, np.ndarray]) -> tuple[list[np.ndarray], np.ndarray, np.ndarray | None]:
            found = self._sweep(parameters, samples, DESIGN, kept=kept)
            parts = [found.made[self._rows(g, False)] for g in range(len(self.groups))]
            with np.errstate(over="ignore", invalid="ignore"):  # the solution says so
                made = [part @ part.T for part in parts]
            return made, found.fires, found.made if kept is not None else None

        for made, fires, held in self._over_blocks(data, work):
            design = held
            firing = firing + fires
            grams = [total + part for total, part in zip(grams, made, strict=True)]
        equations = [joined(gram, len(g.columns)) for gram, g in zip(grams, self.groups, strict=True)]
        return equations, firing, design

    def fit(self, free: Sequence[np.ndarray], data: SampleArrays, gradient: bool = False) -> PointFit:
        """Solve for the consequents by least squares: they, the error left, and its gradient to the premises if asked.

        The gradient holds the consequents: they are at their own minimum, where their change does not count (with a
        ridge that holds as nearly as the ridge is small).
        """
        if not gradient and self._last and self._last[0] is free and self._last[1] is data:
            return self._last[2]
        natural, parameters = self._at(free)
        kept = None
        if data.count <= min(_BLOCK, self.block):
            functions, rules = len(self._plan.kind), len(self._plan.weight)
            kept = np.empty((functions + 2 * rules, -(-data.count // CHUNK_LANES) * CHUNK_LANES))
        equations, fires, design = self._equations(parameters, data, kept)
        below: list[tuple[np.ndarray, np.ndarray]] = []
        if self.ridge:
            below = [self.ridge_rows(g, equations[g], int(n), data) for g, n in enumerate(fires)]
            equations = [plus(e, *rows) for e, rows in zip(equations, below, strict=True)]

        def samples(g: int) -> tuple[np.ndarray, np.ndarray]:
            """The design matrix of a group, transposed, and its targets."""
            whole = self._sweep(parameters, next(self._portions(data)), DESIGN).made if design is None else design
            a, y = np.split(whole[self._rows(g, False)], [len(self.groups[g].columns)])
            return (np.hstack([a, below[g][0].T]), np.concatenate([y.T, below[g][1]])) if below else (a, y.T)

        whole = data.count <= self.block
        solutions = [solve(e, partial(samples, g) if whole else None) for g, e in enumerate(equations)]
        squares, slopes, _ = self._errors(parameters, [s.values for s in solutions], data, gradient, kept)
        rmse = (squares / (data.count * len(self.fis.outputs))) ** 0.5
        found = PointFit(solutions, rmse, self._by_kind(natural, slopes) if gradient else None)
        self._last[:] = free, data, found
        return found

    def _errors(
        self,
        parameters: np.ndarray,
        values: Sequence[np.ndarray],
        data: SampleArrays,
        gradient: bool,
        kept: np.ndarray | None = None,
    ) -> tuple[float, np.ndarray, int]:
        """The squared errors, their gradient to the membership functions' parameters, and at how many none fires."""
        proposals, squares, silent = self._proposals(values), 0.0, 0
        slopes = np.zeros_like(parameters)
        task = ERRORS | GRADIENT if gradient else ERRORS
        for found in self._over_blocks(
            data, lambda samples: self._sweep(parameters, samples, task, proposals, kept=kept)
        ):
            squares, silent, slopes = squares + found.squares, silent + found.silent, slopes + found.slopes
        return squares, slopes, silent

    def rmse(self, point: Point, data: SampleArrays) -> float:
        """The root mean square error at ``point`` over samples and outputs, in the outputs' unit."""
        squares, _, _ = self._errors(self._at(point.free)[1], point.values, data, False)
        return float((squares / (data.count * len(self.fis.outputs))) ** 0.5)

    def silent(self, free: Sequence[np.ndarray], data: SampleArrays) -> int:
        """The number of samples at which no rule fires for some output."""
        values = [np.zeros((len(g.columns), len(g.outputs))) for g in self.groups]
        return self._errors(self._at(free)[1], values, data, False)[2]

    # Second order -------------------------------------------------------------------------------------------------

    def reduced(self, point: Point, data: SampleArrays) -> tuple[np.ndarray, np.ndarray]:
        """Jᵀ J and Jᵀ r of the reduced residual, consequents eliminated, as :meth:`anfis.network.Network.reduced`."""
        natural, parameters = self._at(point.free)
        proposals = self._proposals(point.values)
        factor = np.zeros_like(parameters)
        ones = self.premises.free_gradient(natural, [np.ones_like(p) for p in natural])
        for kind, by in zip(self.fis.structure.kinds, ones, strict=True):
            factor[kind.terms, : by.shape[1]] = by
        jtj: Any = 0.0
        jtr: Any = 0.0
        parts, fires = self._rows_of(parameters, factor, proposals, data)
        for g, (group, rows) in enumerate(zip(self.groups, parts, strict=True)):
            n, q = len(group.columns), len(group.outputs)
            if self.ridge:
                rows = self.with_ridge(g, rows.T, point.values[g], int(fires[g]), data).T
            left = eliminated(rows, n)
            size = (len(left) - q) // q
            for k in range(q):
                own = slice(k * size, (k + 1) * size)
                jtj, jtr = jtj + left[own, own], jtr + left[own, k - q]
        return jtj, jtr

    def _rows_of(
        self, parameters: np.ndarray, factor: np.ndarray, proposals: np.ndarray, data: SampleArrays
    ) -> tuple[list[np.ndarray], np.ndarray]:
        """Each group's [A, J, r], transposed, or of more than one block its triangle (QR); and where rules fire."""
        firing: Any = 0
        whole: list[Any] = []
        task = DESIGN | JACOBIAN
        for found in self._over_blocks(data, lambda samples: self._sweep(parameters, samples, task, proposals, factor)):
            rows: list[Any] = [found.made[self._rows(g, True)] for g in range(len(self.groups))]
            firing = firing + found.fires
            if data.count > min(_BLOCK, self.block):
                rows = [np.hstack(pair) for pair in zip(whole, rows, strict=True)] if whole else rows
                rows = [np.asarray(np.linalg.qr(part.T, mode="r")).T for part in rows]
            whole = rows
        return whole, firing


def has_kernel(fis: Sugeno) -> bool:
    """Whether compiled code knows all membership functions of ``fis``."""
    return all(type(f) in NUMBERS for v in fis.inputs for f in v.terms.values())


def make_network(fis: Sugeno, keep_order: bool, ridge: float, block: int) -> CompiledNetwork:
    """The compiled network of ``fis``, which has plain numbers and functions that all have a kernel."""
    held, groups = premises(fis, keep_order=keep_order), output_groups(fis)
    return CompiledNetwork(held, groups, ridge, block, plan_of(fis, groups, held.low, held.span, held.high))
