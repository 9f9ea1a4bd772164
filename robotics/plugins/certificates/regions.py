"""From which errors a law provably stays near its path and comes to it: the certificate of a closed loop.

A candidate comes from a search over points, by the sums of the proof itself; what is found is believed only where
branch and bound over boxes (:mod:`robotics.plugins.certificates.decrease`) shows it.
"""

import itertools
import math
import time
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from fuzzy.compiled.threads import share_out
from robotics.plugins.certificates.decrease import GROWS, HOLE, LIMITED, WAY_TURNED, at_points, prove, tabulate
from robotics.plugins.certificates.loopcolumns import LevelColumns
from robotics.plugins.certificates.loopmodel import ClosedLoop, fall
from robotics.plugins.certificates.wheels import Drives

_SHARE = 0.97  # ν
_STEP = 0.9  # of one level of w to the next
_PARTS = np.array([6, 10, 10])  # of a region's box, to see what the law asks for in it
_SIZES = np.array([2.0, 16.0])  # widths of v_r over v_r and of the curvature that count as the whole region's box
_LEAST = 0.01  # of a region's box, below which no box is split
_CELL = 1.12  # of the greatest to the least v_r in a cell
_DEPTH = 400  # boxes that wait
_WHY = {
    HOLE: "no rule may fire",
    WAY_TURNED: "the heading error may reach π",
    GROWS: "V may not fall",
    LIMITED: "a command may meet a limit of the wheels",
}


@dataclass(frozen=True, kw_only=True)
class SearchEffort:
    """How long a certificate is looked for."""

    seconds: float  # after which no other region is tried
    sizes: tuple[float, ...]  # of the greatest w, one after another
    rounds: int  # of search and refutation, of one size
    points: int  # by which a candidate is judged
    trials: int  # candidates of each size
    boxes: int  # that are looked at, of a cell of references
    shell: float  # the least w that is claimed, of the greatest: every shell costs boxes


QUICK_EFFORT = SearchEffort(seconds=1.0, sizes=(0.08,), rounds=1, points=300, trials=10, boxes=60_000, shell=0.8)
FULL_EFFORT = SearchEffort(
    seconds=50.0,
    sizes=(0.06, 0.09, 0.12, 0.16, 0.2, 0.25, 0.3),
    rounds=3,
    points=1000,
    trials=30,
    boxes=300_000,
    shell=0.3,
)
_SHAPE = np.array([3.35, 2.3, 2.3])  # ln a, ln b and m, from which the search begins
_SLACK = 2.5  # how much faster than needed V must fall at the points of a candidate that is worth a proof
_RIM = 0.5  # of the greatest w, above which V must fall by all means


@dataclass(frozen=True, eq=False)
class Failure:
    """Where a proof ends: a box of X [m], Y [m], ψ [rad], v_r [m/s] and curvature [1/m], and what is in the way."""

    box: np.ndarray  # (5, 2)
    growth: float  # 1, of V in a period, which cannot be excluded
    why: str


@dataclass(frozen=True, eq=False)
class LoopCertificate:
    """A region V <= ν w that no trajectory leaves, which comes to V <= μ ν w₀ at least as fast as V falls by μ^(t/T).

    Attributes:
        loop: The law under its assumptions.
        form: V, w, w₀, ν and μ in numbers (LevelColumns,).
        boxes: How many boxes the proof looked at.
    """

    loop: ClosedLoop
    form: np.ndarray
    boxes: int

    from_reference = False  # whether the robot drives as its reference does before the start, or as the law asks there

    @property
    def region(self) -> float:
        """V on the region's boundary."""
        form = LevelColumns(self.form)
        return float(form.share * form.outer)

    @property
    def ultimate(self) -> float:
        """V below which every trajectory comes."""
        form = LevelColumns(self.form)
        return float(form.fall * form.share * form.inner)

    @property
    def rate(self) -> float:
        """The decay rate of √V [1/s]."""
        return -math.log(float(LevelColumns(self.form).fall)) / (2 * self.loop.model.period)

    @property
    def P(self) -> np.ndarray:
        """V = z'Pz of z = (X, Y, ψ) (3, 3)."""
        form = LevelColumns(self.form)
        return np.array([[form.a, 0, 0], [0, form.b + form.m**2, form.m], [0, form.m, 1.0]], dtype=float)

    def half_widths(self, level: float | None = None) -> np.ndarray:
        """How far V <= level, by default the region, reaches (3,) [m, m, rad]."""
        return np.sqrt((self.region if level is None else level) * np.diag(np.linalg.inv(self.P)))

    def level(self, errors: np.ndarray) -> np.ndarray:
        """V (...) of errors (..., 3)."""
        return np.einsum("...i,ij,...j->...", errors, self.P, errors)

    def levels(self, errors: np.ndarray, drives: Drives) -> np.ndarray:
        """V (samples, starts) in drives: of the errors alone."""
        return self.level(errors)


def levels_of(form: np.ndarray, step: float = _STEP) -> np.ndarray:
    """The w at which is looked at what the law asks for, falling from the greatest to the least."""
    column = LevelColumns(form)
    outer, inner = float(column.outer), float(column.inner)
    count = max(1, math.ceil(math.log(inner / outer) / math.log(step) - 1e-9))
    return np.asarray(outer * (inner / outer) ** (np.arange(count + 1) / count))


def cells_of(loop: ClosedLoop) -> list[np.ndarray]:
    """Ranges of v_r and of the curvature (2, 2) that together are all."""
    model = loop.model
    count = max(1, math.ceil(math.log(model.speed_high / model.speed_low) / math.log(_CELL)))
    ends = model.speed_low * (model.speed_high / model.speed_low) ** (np.arange(count + 1) / count)
    ends[-1] = model.speed_high
    return [np.array([[a, b], [-model.curvature, model.curvature]]) for a, b in itertools.pairwise(ends)]


def _table(loop: ClosedLoop, form: np.ndarray, cell: np.ndarray, levels: np.ndarray, parts: np.ndarray) -> np.ndarray:
    found = np.empty((len(levels), 5))
    tabulate(loop.numbers, form, loop.system, cell, parts, levels, found)
    return found


def prove_cell(loop: ClosedLoop, form: np.ndarray, cell: np.ndarray, most: int) -> tuple[int, Failure | None]:
    """Prove the claim for one cell of references, with as many boxes as are allowed."""
    levels, failed, stack = levels_of(form), np.zeros((6, 2)), np.zeros((_DEPTH, 5, 2))
    column = LevelColumns(form)
    reach = np.sqrt(float(column.outer) * np.array([1 / column.a, 1 / column.b, 1 + column.m**2 / column.b]))
    stack[0, :3, 0], stack[0, :3, 1], stack[0, 3:] = -reach * (1 + 1e-9), reach * (1 + 1e-9), cell
    tables = _table(loop, form, cell, levels, _PARTS)
    count = prove(loop.numbers, form, loop.system, levels, tables, stack, 1, _SIZES, most, _LEAST, failed)
    if count > 0:
        return count, None
    why = int(failed[5, 0])
    return -count, Failure(failed[:5], float(failed[5, 1]), next(text for bit, text in _WHY.items() if why & bit))


class _Points:
    """Errors, as directions and levels, and references at which a candidate is tried."""

    def __init__(self, loop: ClosedLoop, count: int) -> None:
        rng, model = np.random.default_rng(0), loop.model
        speeds = np.geomspace(model.speed_low, model.speed_high, 4)
        self.loop, self.references = (
            loop,
            np.array([(v, k) for v in speeds for k in (-model.curvature, model.curvature)]),
        )
        direction = rng.standard_normal((count, 3))
        self.direction = direction / np.linalg.norm(direction, axis=1)[:, None]
        self.size = 0.05 ** (1 - rng.permutation(count) / count)
        self.chosen = rng.integers(len(self.references), size=count)

    def add(self, form: np.ndarray, failure: Failure) -> None:
        """Try from now on where a proof failed, too, with some points about it."""
        column, box = LevelColumns(form), failure.box.mean(axis=1)
        s = np.array([math.sqrt(column.a) * box[0], math.sqrt(column.b) * box[1], box[2] + column.m * box[1]])
        size = max(float(s @ s / column.outer), 1e-6)
        near = s + 0.05 * math.sqrt(s @ s) * np.random.default_rng(1).standard_normal((5, 3))
        self.direction = np.vstack([self.direction, near / np.linalg.norm(near, axis=1)[:, None]])
        off = np.abs(np.log(self.references[:, 0] / box[3])) + (self.references[:, 1] * box[4] < 0)
        self.chosen = np.append(self.chosen, np.full(5, np.argmin(off)))
        self.size = np.append(self.size, np.full(5, min(size, float(column.share))))

    def errors(self, form: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """V over the greatest w at each point, and the errors (n, 3)."""
        column = LevelColumns(form)
        size = np.minimum(self.size, float(column.share))
        z = self.direction * np.sqrt(size * float(column.outer))[:, None]
        z /= np.array([math.sqrt(float(column.a)), math.sqrt(float(column.b)), 1.0])
        z[:, 2] -= float(column.m) * z[:, 1]
        return size, z

    def changes(self, form: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """V over the greatest w at each point, and by which part V may change there in a period."""
        loop, levels, (size, z), found = self.loop, levels_of(form, 0.8), self.errors(form), np.empty(len(self.size))
        cells = [np.array([[v, v], [k, k]]) for v, k in self.references]
        tables = np.array([_table(loop, form, cell, levels, _PARTS // 2) for cell in cells])
        at_points(loop.numbers, form, loop.system, self.references[self.chosen], z, levels, tables[self.chosen], found)
        return size, np.minimum(found, 1e3)


def _form(shape: np.ndarray, outer: float, inner: float, loop: ClosedLoop) -> np.ndarray:
    return np.array(
        [math.exp(shape[0]), math.exp(shape[1]), shape[2], outer, inner, _SHARE, fall(loop.numbers, _SHARE)]
    )


def certify_loop(loop: ClosedLoop, effort: SearchEffort) -> tuple[LoopCertificate | None, Failure | None]:
    """Look for ever greater regions that can be proven; without one, say where the proof of the last one tried ends."""
    ends, tried = time.monotonic() + effort.seconds, _Points(loop, effort.points)
    shape, found, failure = _SHAPE, None, None
    for outer in effort.sizes:
        for k in range(effort.rounds):
            slow = _slow(loop, tried, shape, outer)
            if slow > _RIM or k > 0:
                shape = _search(loop, tried, shape, outer, effort.trials)
                slow = _slow(loop, tried, shape, outer)
            if slow > _RIM:
                failure = _no_fall(loop, tried, shape, outer)
                break
            form = _form(shape, outer, outer * max(1.15 * slow / _SHARE, effort.shell), loop)
            count, failure = _prove(loop, form, effort.boxes)
            if failure is None:
                found = LoopCertificate(loop, form, count)
                break
            if time.monotonic() > ends:
                break
            tried.add(form, failure)
        if failure is not None or time.monotonic() > ends:
            break
    return found, None if found else failure


def _slow(loop: ClosedLoop, tried: "_Points", shape: np.ndarray, outer: float) -> float:
    """The greatest V, over the greatest w, at which V falls too slowly for a proof to be worth a try."""
    size, changes = tried.changes(_form(shape, outer, 0.05 * outer, loop))
    return float(size[changes > -_SLACK * (1 - fall(loop.numbers, _SHARE))].max(initial=0.0))


def _search(loop: ClosedLoop, tried: "_Points", shape: np.ndarray, outer: float, trials: int) -> np.ndarray:
    """The shape of V by which it falls fastest where it falls slowest."""

    def cost(x: np.ndarray) -> float:
        _, changes = tried.changes(_form(x, outer, 0.05 * outer, loop))
        return float(np.sort(changes)[-max(2, len(changes) // 100) :].mean())

    start = np.vstack([shape, shape + 0.4 * np.eye(3)])
    options = {"maxfev": trials, "initial_simplex": start}
    return np.asarray(minimize(cost, shape, method="Nelder-Mead", options=options).x)


def _no_fall(loop: ClosedLoop, tried: "_Points", shape: np.ndarray, outer: float) -> Failure:
    """The point at which the best candidate falls least."""
    z, changes = tried.errors(form := _form(shape, outer, 0.25 * outer, loop))[1], tried.changes(form)[1]
    k = int(np.argmax(changes))
    v_r, curvature = tried.references[tried.chosen[k]]
    box = np.repeat(np.array([*z[k], v_r, curvature])[:, None], 2, axis=1)
    return Failure(box, float(changes[k]), _WHY[GROWS])


def _prove(loop: ClosedLoop, form: np.ndarray, most: int) -> tuple[int, Failure | None]:
    counts = 0

    def one(cell: np.ndarray) -> tuple[int, Failure | None]:
        return prove_cell(loop, form, cell, most)

    cells = cells_of(loop)
    order = [cells[0], cells[-1], *cells[1:-1]] if len(cells) > 1 else cells
    for k in range(0, len(order), 2):
        for count, failure in share_out(one, order[k : k + 2]):
            counts += count
            if failure is not None:
                return counts, failure
    return counts, None


def where(failure: Failure) -> str:
    """Where a proof ends, in words."""
    names = ("X", "Y", "ψ", "v_r", "curvature")
    places = (f"{n} {a:.3g} to {b:.3g}" for n, (a, b) in zip(names, failure.box, strict=True))
    change = "may grow by" if failure.growth > 0 else "is only sure to fall by"
    return f"{failure.why} at {', '.join(places)}, where it {change} {100 * abs(failure.growth):.2g} % in a period"
