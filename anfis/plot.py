"""Pictures of learning: error curves, membership functions before and after, output against data.

Every function returns a matplotlib figure in the project's style (``figure.savefig("a.pdf")``).
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from anfis.data import DataError, samples
from anfis.pruning import Pruned
from anfis.state import Epoch
from fuzzy.detached import detached
from fuzzy.errors import InputError
from fuzzy.figures.drawing import COLUMN, DOUBLE, LINES, draw_ring, log_y, new_figure, style, styled_figure
from fuzzy.figures.figureset import SetPicture
from fuzzy.figures.palette import COLORS
from fuzzy.insight.universe import universe_grid
from fuzzy.system import Sugeno, Variable
from fuzzy.words import counted

_BEFORE, _AFTER = 0.5, 1.4  # widths [pt] of the lines of terms
_NAMED = 12  # terms of an input that a legend names, at most


class TrainingPlotError(InputError):
    """A picture that cannot be drawn: of an empty history, or of systems with different terms."""


def plot_training(history: Sequence[Epoch]) -> Figure:
    """Draw training and checking error over the epochs, logarithmic, with the least one marked; below, the step size.

    The step size is the hybrid method's step length (in ranges), the second-order method's damping or the learning
    rate. The axis is linear where an error is 0.

    Args:
        history: The epochs, such as ``Training.history``.

    Raises:
        TrainingPlotError: An empty history.
    """
    if not history:
        raise TrainingPlotError("the history holds no epoch: there is nothing to draw")
    epochs = [row.epoch for row in history]
    with styled_figure(COLUMN, 3.8) as figure:
        errors, steps = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
        marked, label = draw_errors(errors, history)
        best = int(np.nanargmin(marked))
        said = f"least {label} error: {marked[best]:.3g}, epoch {epochs[best]}"
        errors.plot(epochs[best], marked[best], "o", color="black", label=said, clip_on=False, zorder=3)
        errors.set_ylabel("RMSE [unit of the output]")
        figure.legend(loc="outside upper left")
        steps.plot(epochs, [row.step for row in history], color="0.3", drawstyle="steps-mid")
        steps.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
        steps.set(ylabel="step", xlabel="epoch")
        return figure


def draw_errors(ax: Axes, history: Sequence[Epoch]) -> tuple[list[float], str]:
    """Draw training and checking errors over the epochs, logarithmic unless one is 0.

    Returns the errors that count, those of checking if there are any, and what they are called.
    """
    epochs, train, check = zip(*((row.epoch, row.train, row.check) for row in history), strict=True)
    ax.plot(epochs, train, color=COLORS[0], linestyle="-", label="training")
    checked = bool(np.isfinite(check).any())
    if checked:
        ax.plot(epochs, check, color=COLORS[1], linestyle="--", label="checking")
    if min(train) > 0 and not np.nanmin(check if checked else train) <= 0:
        log_y(ax)
    return (list(check), "checking") if checked else (list(train), "training")


def plot_pruning(pruned: Pruned, unit: str = "") -> Figure:
    """Draw the errors against the number of rules, logarithmic, with a ring at the number that was chosen.

    The errors are those of the path, before the last training.

    Args:
        pruned: What pruning has found.
        unit: That of the outputs.
    """
    rules = [step.rules for step in pruned.path]
    with styled_figure(COLUMN, 2.9) as figure:
        ax = figure.add_subplot()
        drawn = []
        for k, (column, label) in enumerate((("train", "training"), ("check", "checking"), ("test", "test"))):
            errors = [getattr(step, column) for step in pruned.path]
            if np.isfinite(errors).any():
                ax.plot(rules, errors, color=COLORS[k], linestyle=LINES[k], marker=".", label=label)
                drawn.append((label, errors))
        label, errors = drawn[min(len(drawn) - 1, 1)] if np.isfinite(pruned.path[0].check) else drawn[0]
        said = f"{rules[pruned.chosen]} rules: {label} error {errors[pruned.chosen]:.3g}"
        draw_ring(ax, rules[pruned.chosen], errors[pruned.chosen], said, zorder=4)
        if min(min(values) for _, values in drawn) > 0:
            log_y(ax)
        ax.xaxis.set_major_locator(MaxNLocator(6, integer=True, min_n_ticks=1))
        ax.set_xlabel("number of rules")
        ax.set_ylabel(f"RMSE [{unit}]" if unit else "RMSE [unit of the output]", parse_math=False)
        figure.legend(loc="outside upper left", ncols=2)
        return figure


def plot_premises(before: Sugeno, after: Sugeno, width: float = DOUBLE) -> Figure:
    """Draw each input's membership functions before learning (thin) and after (wide)   [thesis, Fig 5.10].

    A term has the same colour and dashes in both.

    Args:
        before: The system before.
        after: The system after.
        width: That of the figure of several inputs, in inches.

    Raises:
        TrainingPlotError: The systems do not have the same inputs and terms.
    """
    before, after = detached(before), detached(after)
    names = [[(v.name, tuple(v.terms)) for v in fis.inputs] for fis in (before, after)]
    if names[0] != names[1]:
        raise TrainingPlotError(f"{before.name} and {after.name} do not have the same inputs and terms")
    with style():
        rows = (len(before.inputs) + 1) // 2
        columns = min(2, len(before.inputs))
        most = max(len(variable.terms) for variable in after.inputs)
        named, across = most if 1 < most <= _NAMED else 0, 5 if width > 5 and columns == 2 else 3
        legend_rows = -(-(2 + named) // across)
        figure = new_figure(width if columns == 2 else COLUMN, 0.1 + 0.15 * legend_rows + 1.75 * rows)
        axes = np.atleast_1d(figure.subplots(rows, columns)).ravel()
        for ax, old, new in zip(axes, before.inputs, after.inputs, strict=False):
            _draw_terms(ax, old, new)
        for ax in axes[len(before.inputs) :]:
            ax.set_visible(False)
        thin = Line2D([], [], color="0.4", linewidth=_BEFORE, linestyle="-")
        wide = Line2D([], [], color="0.4", linewidth=_AFTER, linestyle="-")
        handles, titles = [thin, wide], ["before learning", "after"]
        if named:
            handles += [Line2D([], [], linewidth=_AFTER, **_look(k)) for k in range(named)]
            titles += _term_names(after, named)
        legend = figure.legend(handles, titles, loc="outside upper left", ncols=across, handlelength=2.8)
        for text in legend.get_texts():
            text.set_parse_math(False)
        return figure


def _look(term: int) -> dict[str, Any]:
    """The colour and the dashes of a term: no two of the first 42 have both."""
    return {"color": COLORS[term % len(COLORS)], "linestyle": LINES[(term + term // len(COLORS)) % 6]}


def _term_names(fis: Sugeno, count: int) -> list[str]:
    """What the terms are called, where all inputs call them the same; otherwise their numbers."""
    called = {tuple(variable.terms) for variable in fis.inputs}
    return list(*called) if len(called) == 1 else [f"term {k}" for k in range(1, count + 1)]


def _draw_terms(ax: Any, old: Variable, new: Variable) -> None:
    x = np.union1d(universe_grid(old), universe_grid(new))
    for k, (name, function) in enumerate(new.terms.items()):
        ax.plot(x, old.terms[name](x), **_look(k), linewidth=_BEFORE, zorder=2)
        ax.plot(x, function(x), **_look(k), linewidth=_AFTER, zorder=3)
    ax.set_xlabel(old.label, parse_math=False)
    ax.set(ylabel="degree", ylim=(0, 1.05))
    ax.margins(x=0)


def data_pictures(fis: Sugeno, chosen: Mapping[str, Any]) -> list[SetPicture]:
    """The pictures of a set that need data: the system beside the rows of ``chosen["data"]``, inputs and outputs."""
    if chosen.get("data") is None:
        return []
    x, y = chosen["data"]
    measured = np.isfinite(y).any(axis=0)
    names = {variable.name for variable, there in zip(fis.outputs, measured, strict=True) if there}
    rules = [replace(rule, then=tuple(each for each in rule.then if each[0] in names)) for rule in fis.rules]
    outputs = [variable for variable in fis.outputs if variable.name in names]
    y = y[:, measured]
    known = np.isfinite(x).all(axis=1) & np.isfinite(y).all(axis=1)
    if not outputs or not known.any():
        raise DataError("no row of the data has all inputs and an output")
    fis = replace(fis, outputs=outputs, rules=[rule for rule in rules if rule.then])
    caption = f"The outputs beside {counted(int(known.sum()), 'row')} of data, against them, and the residuals."
    return [SetPicture("data", "data", caption, draw=partial(plot_fit, fis, x[known], y[known]))]


def plot_fit(fis: Sugeno, x: Any, y: Any) -> Figure:
    """Draw a system's outputs against data: over the samples, against the targets, and the residuals' histogram.

    One row of axes an output [thesis, Figs 5.8, 5.9, 5.12]. Data outside the universes are drawn without a warning.

    Args:
        fis: The system.
        x: The inputs (samples, inputs).
        y: The outputs (samples,) or (samples, outputs).

    Raises:
        DataError: Data that do not fit ``fis``.
    """
    fis = detached(fis)
    data = samples(fis, x, y, "given")
    quiet = replace(fis, out_of_range="ignore") if fis.out_of_range == "warn" else fis
    y, z = data.y, np.asarray(quiet(data.x))
    with styled_figure(DOUBLE, 0.25 + 1.9 * y.shape[1]) as figure:
        axes = np.atleast_2d(figure.subplots(y.shape[1], 3, width_ratios=(2, 1, 1)))
        for row, output, target, found in zip(axes, fis.outputs, y.T, z.T, strict=True):
            over, against, residuals = row
            over.plot(target, color=COLORS[0], label="data")
            over.plot(found, color=COLORS[1], linestyle="--", linewidth=0.9, label="system")
            over.set_xlabel("sample")
            over.set_ylabel(output.label, parse_math=False)
            unit = f" [{output.unit}]" if output.unit else ""
            ends = [np.nanmin([target, found]), np.nanmax([target, found])]
            against.plot(ends, ends, color="0.6", linewidth=0.8)
            against.plot(target, found, ".", markersize=2, color=COLORS[0])
            against.set_xlabel(f"data{unit}", parse_math=False)
            against.set_ylabel(f"system{unit}", parse_math=False)
            residual = found - target
            residuals.hist(residual[np.isfinite(residual)], bins="auto", color=COLORS[0])
            residuals.set_xlabel(f"system − data{unit}", parse_math=False)
            residuals.set_ylabel("samples")
            residuals.xaxis.set_major_locator(MaxNLocator(2, symmetric=True))  # their numbers may be long
        figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside upper left", ncols=2)
        return figure
