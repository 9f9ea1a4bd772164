"""Measured rows beside a system, as numbers for pictures: where the rows lie, and how far the system is off.

A residual is measured - predicted. All figures are of all rows; only points that are drawn are a choice of them.
"""

import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fuzzy.inference import InferenceWarning
from fuzzy.shown import shown, typeset
from fuzzy.system import Sugeno, Variable

BINS = 40  # of a histogram, over the universe
DRAWN = 2_000  # points of a picture, at most
_WORST = 10  # rows that are listed
_KINDS = ("training", "checking")


@dataclass(frozen=True, eq=False)
class Rows:
    """The rows of a table that are looked at, in the order of a system's variables."""

    x: np.ndarray  # (rows, inputs); not-a-number all along an input that has no column
    y: np.ndarray  # (rows, outputs); not-a-number all along an output that has no column
    lines: np.ndarray  # (rows,) int: the line of the file at which each begins
    checking: np.ndarray | None = None  # (rows,) bool: which are for checking and not learnt from; None: no such split
    along: np.ndarray | None = None  # (rows,): what residuals are drawn over beside the inputs; None: the row's number

    @property
    def kinds(self) -> list[tuple[str, np.ndarray]]:
        """The name and the rows (rows,) bool of each kind; one without a name where there is no split."""
        if self.checking is None:
            return [("", np.ones(len(self.x), dtype=bool))]
        return [(name, which) for name, which in zip(_KINDS, (~self.checking, self.checking), strict=True)]


def predicted(fis: Sugeno, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What ``fis`` says at ``x`` (rows, inputs): outputs (rows, outputs), and where no rule fires for them (bool).

    Nothing is raised nor warned of; where a system would raise an error as no rule fires, the output is not-a-number.
    """
    quiet = replace(fis, no_rule_fires="nan", out_of_range="clip" if fis.out_of_range == "clip" else "ignore")
    known = np.isfinite(x).all(axis=1)
    output = np.full((len(x), len(fis.outputs)), np.nan)
    output[known] = _evaluated(quiet, x[known])
    lost = known & np.isnan(output).any(axis=1)
    silent = np.zeros(output.shape, dtype=bool)
    if lost.any():
        # An output may be no number where a rule fires, too: of a degree 0 times infinity.
        filled = _evaluated(replace(quiet, no_rule_fires="midrange"), x[lost])
        silent[lost] = np.isnan(output[lost]) & np.isfinite(filled)
        if fis.no_rule_fires == "midrange":
            output[lost] = filled
    return output, silent


def _evaluated(fis: Sugeno, x: np.ndarray) -> np.ndarray:
    from fuzzy.compiled.sugeno import outputs_of  # imports Numba, which only a worker needs

    with warnings.catch_warnings(action="ignore", category=InferenceWarning), np.errstate(all="ignore"):
        return outputs_of(fis, x)


def histograms(inputs: Sequence[Variable], rows: Rows) -> list[dict[str, Any]]:
    """The histogram of each input that has a column, over its universe.

    ``counts`` has BINS numbers for each kind of rows, from ``low`` to ``high``; ``below`` and ``above`` are how many
    rows lie outside, and ``words`` says it.
    """
    found = []
    for variable, values in zip(inputs, rows.x.T, strict=True):
        (low, high), number = variable.universe, np.isfinite(values)
        if not number.any():
            continue
        counts = [np.histogram(values[of & number], BINS, (low, high))[0].tolist() for _, of in rows.kinds]
        below, above = int((values < low).sum()), int((values > high).sum())
        found.append(
            {
                "name": variable.name,
                "unit": variable.unit,
                "low": low,
                "high": high,
                "kinds": [name for name, _ in rows.kinds],
                "counts": counts,
                "below": below,
                "above": above,
                "words": _outside(variable, below, above, int(number.sum()), values[number]),
            }
        )
    return found


def _outside(variable: Variable, below: int, above: int, count: int, values: np.ndarray) -> str:
    low, high = variable.universe

    def span(a: float, b: float) -> str:
        return typeset(f"{shown(float(a), high - low)} to {_quantity(float(b), variable.unit, high - low)}")

    rows = f"{variable.name}: the rows reach from {span(values.min(), values.max())}"
    if not below + above:
        return f"{rows}, all within the universe."
    return f"{rows}; {_share(below + above, count)} lie outside {span(low, high)}, {below} below and {above} above."


def _share(part: int, count: int) -> str:
    percent = 100 * part / count
    text = f"{percent:.3g}" if percent >= 0.1 else f"{percent:.1g}"
    return f"{part} of {count} rows ({text} %)"


def _quantity(value: float, unit: str, span: float = 0.0) -> str:
    return typeset(f"{shown(value, span)} {unit}".strip())


def figures(rows: Rows, output: np.ndarray, outputs: Sequence[Variable]) -> list[dict[str, Any]]:
    """The errors of each output that has a column: of each kind of rows RMSE, mean and largest |error|, and R².

    Rows without a prediction are counted in ``without`` and in nothing else. ``r2`` is None where the measured values
    are all the same.
    """
    found = []
    for j, variable in enumerate(outputs):
        measured = np.isfinite(rows.y[:, j])
        if not measured.any():
            continue
        for name, of in rows.kinds:
            counted = of & measured & np.isfinite(output[:, j])
            y, error = rows.y[counted, j], rows.y[counted, j] - output[counted, j]
            about: dict[str, Any] = {"output": variable.name, "unit": variable.unit, "kind": name}
            about |= {"rows": len(y), "without": int((of & measured).sum()) - len(y)}
            if len(y):
                squares, spread = float(np.sum(error**2)), float(np.sum((y - y.mean()) ** 2))
                about["rmse"] = math.sqrt(squares / len(y))
                about["mae"] = float(np.mean(np.abs(error)))
                about["max"] = float(np.max(np.abs(error)))
                about["r2"] = 1 - squares / spread if spread > 0 else None
            found.append(about)
    return found


def chosen_points(axes: Sequence[np.ndarray], residual: np.ndarray, most: int = DRAWN) -> np.ndarray:
    """The rows (indices, ascending) that are drawn of many: the extremes of the residual all along each axis, and
    others evenly spread over the rows.

    Args:
        axes: What the pictures have as their abscissas, (rows,) each.
        residual: (rows,); rows where it is not-a-number are not drawn.
        most: How many rows are drawn.
    """
    rows = np.flatnonzero(np.isfinite(residual))
    if len(rows) <= most:
        return rows
    order = rows[np.argsort(residual[rows], kind="stable")]
    kept = [order[:_WORST], order[-_WORST:]]
    bins = max(2, most // (4 * len(axes)))
    for values in axes:
        finite = order[np.isfinite(values[order])]
        if not len(finite):
            continue
        at = values[finite]
        low, high = at.min(), at.max()
        place = np.minimum(bins - 1, ((at - low) / (high - low or 1.0) * bins).astype(int))
        # In ascending order of the residual the first row of a bin is its least, the last its greatest.
        kept.append(finite[np.unique(place, return_index=True)[1]])
        kept.append(finite[len(finite) - 1 - np.unique(place[::-1], return_index=True)[1]])
        kept.append(finite[[int(at.argmin()), int(at.argmax())]])
    extremes = np.unique(np.concatenate(kept))
    spread = rows[np.linspace(0, len(rows) - 1, max(0, most - len(extremes))).astype(int)]
    return np.union1d(extremes, spread)[: max(most, len(extremes))]


def data_pictures(fis: Sugeno, rows: Rows, output: int = 0) -> dict[str, Any]:
    """All that the module ``datapictures.js`` draws of ``rows`` beside ``fis``, in JSON's types.

    Args:
        fis: The system, with the rules in force.
        rows: The rows; an input without a column leaves the histograms of the others only.
        output: The output, by number, of points and worst rows; another one that has a column where it has none.
    """
    with np.errstate(all="ignore"):  # a table may hold numbers whose squares are none
        return _pictures(fis, rows, output)


def _pictures(fis: Sugeno, rows: Rows, output: int) -> dict[str, Any]:
    data: dict[str, Any] = {
        "rows": len(rows.x),
        "inputs": [{"name": v.name, "unit": v.unit} for v in fis.inputs],
        "kinds": [name for name, _ in rows.kinds],
        "histograms": histograms(fis.inputs, rows),
        "figures": [],
        "output": None,
        "points": None,
        "residual": None,
        "worst": [],
        "words": [],
    }
    if not np.isfinite(rows.x).any(axis=0).all():
        return data
    said, silent = predicted(fis, rows.x)
    data["words"] = _silence(fis, silent)
    measured = np.isfinite(rows.y).any(axis=0)
    if not measured.any():
        return data
    j = output if output < len(measured) and measured[output] else int(np.argmax(measured))
    residual = rows.y[:, j] - said[:, j]
    along = np.arange(1.0, len(rows.x) + 1) if rows.along is None else rows.along
    drawn = chosen_points([*rows.x.T, rows.y[:, j], along], residual)
    data["figures"] = figures(rows, said, fis.outputs)
    data["output"] = {"number": j, "name": fis.outputs[j].name, "unit": fis.outputs[j].unit}
    data["points"] = {
        "row": drawn.tolist(),
        "line": rows.lines[drawn].tolist(),
        "x": [_rounded(values[drawn]) for values in rows.x.T],
        "along": _rounded(along[drawn]),
        "measured": _rounded(rows.y[drawn, j]),
        "checking": None if rows.checking is None else rows.checking[drawn].tolist(),
    }
    data["residual"] = _rounded(residual[drawn])  # by itself: it alone changes while one edits
    data["worst"] = [_row_data(rows, said, j, int(row)) for row in _worst(residual)]
    return data


def _worst(residual: np.ndarray) -> np.ndarray:
    """The rows of the largest |residual|, the largest first; of equal ones the first rows."""
    rows = np.flatnonzero(np.isfinite(residual))
    return rows[np.argsort(-np.abs(residual[rows]), kind="stable")[:_WORST]]


def _row_data(rows: Rows, said: np.ndarray, j: int, row: int) -> dict[str, Any]:
    return {
        "row": row,
        "line": int(rows.lines[row]),
        "x": rows.x[row].tolist(),
        "measured": float(rows.y[row, j]),
        "predicted": float(said[row, j]),
        "residual": float(rows.y[row, j] - said[row, j]),
        "kind": "" if rows.checking is None else _KINDS[int(rows.checking[row])],
    }


def _silence(fis: Sugeno, silent: np.ndarray) -> list[str]:
    """Say of each output in how many rows no rule fires for it."""
    found = []
    for variable, rows in zip(fis.outputs, silent.T, strict=True):
        count = int(rows.sum())
        if not count:
            continue
        middle = _quantity(variable.midrange, variable.unit)
        instead = (
            f"there the middle of its range, {middle}, stands"
            if fis.no_rule_fires == "midrange"
            else ("these rows have no prediction and are left out of the errors")
        )
        found.append(f"No rule fires for {variable.name} in {_share(count, len(rows))}; {instead}.")
    return found or [f"A rule fires in every one of the {len(silent)} rows."]


def _rounded(values: np.ndarray) -> list[float | None]:
    """The values with six significant digits, which is more than a picture shows."""
    return [float(f"{value:.6g}") if math.isfinite(value) else None for value in values.tolist()]
