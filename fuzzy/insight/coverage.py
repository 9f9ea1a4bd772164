"""Places where no rule fires: their share of the input space, a box of them, and the gaps between terms."""

from collections.abc import Iterator

import numpy as np

from fuzzy.inference import infer_quietly
from fuzzy.insight.universe import universe_grid
from fuzzy.system import Sugeno, Variable

Box = list[tuple[float, float]]  # (inputs,): the lowest and highest value of each input


def spread_points(fis: Sugeno, points: int, seed: int = 0) -> np.ndarray:
    """Spread quasi-random points (points, inputs) evenly over the universes. ``seed`` shifts them all."""
    inputs = len(fis.inputs)
    # Roberts's additive recurrence: the golden ratio's generalisation solves g^(inputs + 1) = g + 1.
    ratio = 2.0
    for _ in range(60):
        ratio = (1 + ratio) ** (1 / (inputs + 1))
    steps = ratio ** -np.arange(1.0, inputs + 1)
    shift = np.random.default_rng(seed).random(inputs)
    unit = (shift + np.arange(1, points + 1)[:, None] * steps) % 1
    low, high = np.array([v.universe for v in fis.inputs]).T
    return low + unit * (high - low)


def uncovered(fis: Sugeno, points: int, seed: int = 0) -> Iterator[tuple[str, float, Box]]:
    """Yield outputs for which no rule fires somewhere: their names, the share of such places in percent, and a box.

    The share is counted at ``points`` quasi-random points, which ``seed`` shifts. No rule fires inside the box; this is
    checked on a grid of 200 places per input.
    """
    x = spread_points(fis, points, seed)
    fired: np.ndarray = infer_quietly(fis, x).fired  # (points, outputs)
    proposed = np.any(fis.structure.consequent >= 0, axis=1)
    seen: list[int] = []
    for j in range(len(fis.outputs)):
        if j in seen or fired[:, j].all() or not proposed[j]:
            continue
        same = [k for k in range(j, len(fis.outputs)) if (fired[:, k] == fired[:, j]).all() and proposed[k]]
        seen += same
        names = " and ".join(fis.outputs[k].name for k in same)
        empty = np.flatnonzero(~fired[:, j])
        boxes = [_box(fis, j, x[n]) for n in empty[:: max(1, len(empty) // 5)]]
        sizes = [np.prod([high - low for low, high in box]) for box in boxes]
        yield names, 100 * len(empty) / points, boxes[int(np.argmax(sizes))]


def _box(fis: Sugeno, output: int, point: np.ndarray) -> Box:
    """A box round ``point`` in which no rule for the output fires, grown step by step in all directions."""
    s = fis.structure
    rules = np.flatnonzero((s.consequent[output] >= 0) & (s.weight > 0))
    grids: list[np.ndarray] = []
    positive: list[np.ndarray] = []
    for i, variable in enumerate(fis.inputs):
        grid = np.union1d(universe_grid(variable, 201), point[i])
        grids.append(grid)
        positive.append(_positive(fis, i, grid, rules))
    low = np.array([int(np.searchsorted(grid, value)) for grid, value in zip(grids, point, strict=True)])
    high = low.copy()

    def is_empty() -> bool:
        alive = [np.any(p[:, a : b + 1], axis=1) for p, a, b in zip(positive, low, high, strict=True)]
        return not _may_fire(fis, rules, np.array(alive))

    for step in (64, 16, 4, 1):
        grew = True
        while grew:
            grew = False
            for i in range(len(grids)):
                for ends, sign in ((low, -1), (high, 1)):
                    before = ends[i]
                    ends[i] = min(max(before + sign * step, 0), len(grids[i]) - 1)
                    if ends[i] != before and is_empty():
                        grew = True
                    else:
                        ends[i] = before
    return [(float(grid[a]), float(grid[b])) for grid, a, b in zip(grids, low, high, strict=True)]


def _positive(fis: Sugeno, i: int, grid: np.ndarray, rules: np.ndarray) -> np.ndarray:
    """Where on the grid each rule's clause about input ``i`` has a degree above 0: (rules, places) bool."""
    s = fis.structure
    functions = list(fis.inputs[i].terms.values())
    positive = np.ones((len(rules), len(grid)), dtype=bool)
    for row, r in enumerate(rules):
        if s.term[i, r] >= 0:
            degree = np.asarray(functions[s.term[i, r]](grid)) ** s.power[i, r]
            positive[row] = degree < 1 if s.negated[i, r] else degree > 0
    return positive


def _may_fire(fis: Sugeno, rules: np.ndarray, alive: np.ndarray) -> bool:
    """Can any rule fire, where its clause about each input is alive or not: (inputs, rules) bool?"""
    asked = fis.structure.term[:, rules] >= 0
    every = np.all(alive | ~asked, axis=0)
    some = np.any(alive & asked, axis=0)
    return bool(np.any(np.where(fis.structure.is_or[rules], some, every)))


def gaps_of_variable(fis: Sugeno, variable: Variable) -> Iterator[tuple[float, float, bool]]:
    """Find the intervals of an input's universe without any term: (lowest, highest, whether a rule fires there).

    The ends are exact for terms made of straight lines or splines, which end at their parameters.
    """
    if not variable.terms:
        return
    grid = universe_grid(variable, 1001)
    none = np.all([np.asarray(function(grid)) <= 0 for function in variable.terms.values()], axis=0)
    edges = np.flatnonzero(np.diff(np.pad(none.astype(int), 1)))
    i = list(fis.inputs).index(variable)
    for start, end in zip(edges[::2], edges[1::2], strict=True):
        low, high = float(grid[start]), float(grid[end - 1])
        x = spread_points(fis, 256)
        x[:, i] = np.linspace(low, high, len(x))
        harmless = bool(infer_quietly(fis, x).fired.all()) if fis.rules else False
        # Degrees that are positive everywhere are 0 only by rounding, which inference by logarithms does not mind.
        if harmless and all(f.log_formula is not None for f in variable.terms.values()):
            continue
        yield low, high, harmless
