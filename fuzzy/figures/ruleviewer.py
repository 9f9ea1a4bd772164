"""The rule viewer: a picture of what every rule does at one point."""

from collections.abc import Sequence
from textwrap import fill
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fuzzy.detached import detached
from fuzzy.figures.drawing import DOUBLE, number, quantity, shortened, styled_figure, text_width
from fuzzy.figures.palette import COLORS, HIGHLIGHT
from fuzzy.inference import Inference, infer_quietly
from fuzzy.insight.universe import universe_grid
from fuzzy.rule import Clause, hedge_words
from fuzzy.system import FuzzySystemError, Sugeno, Variable

_FILL = 0.72  # the part of a row that a degree of 1 fills
_SMALL = 6.5  # text in the rows, in points


def plot_rules(fis: Sugeno, x: Any, only_fired: bool = False, title: str | None = None) -> Figure:
    """Draw the rule viewer: a row for each rule, a column for each input and output.

    In an input's column the clause's degree of membership (with its "not" and hedges) is filled up to the degree
    at the input's value, the vertical line. A bar shows the rule's firing strength, a stem its proposal for each
    output: as high as the rule's share in the result, which stands in the last row.

    Args:
        fis: The system.
        x: The point (inputs,), each in the unit of its variable.
        only_fired: Whether rules with below 0.1 % of the result are left out.
        title: What stands over the picture.

    Raises:
        FuzzySystemError: A point of the wrong shape, or a system without rules.
    """
    fis = detached(fis)
    x = np.asarray(x, dtype=float)
    if x.shape != (len(fis.inputs),):
        raise FuzzySystemError(
            f"the rule viewer shows one point of {len(fis.inputs)} inputs "
            f"({', '.join(v.name for v in fis.inputs)}), got shape {x.shape}"
        )
    if not fis.rules:
        raise FuzzySystemError(f"{fis.name} has no rules to show")
    result = infer_quietly(fis, x)  # the picture says both that an input is out of range and that no rule fires
    shown = [r for r in range(len(fis.rules)) if not only_fired or result.weights[r] >= 1e-3]
    row = min(0.5, max(0.26, 6.5 / max(len(shown), 1)))  # inches
    body, head, foot, axis = row * max(len(shown), 1), 0.42 if title is None else 0.68, 0.62, 0.25
    widths = [0.35, *[1.5] * len(fis.inputs), 0.8, *[1.5] * len(fis.outputs)]
    total = max(DOUBLE * 0.75, min(DOUBLE, sum(widths) + 0.2), 0.75 * len(widths))
    height = head + body + foot + axis
    with styled_figure(total, height, constrained=False) as figure:
        grid = figure.add_gridspec(
            2,
            len(widths),
            width_ratios=widths,
            height_ratios=[body, foot],
            left=0.1 / total,
            right=1 - 0.2 / total,
            top=1 - head / height,
            bottom=axis / height,
            wspace=0.14,
            hspace=0.0,
        )
        columns = [figure.add_subplot(grid[0, c]) for c in range(len(widths))]
        for ax in columns:
            _prepare(ax, len(shown))
        inches = total / sum(widths) * 0.9
        _numbers(columns[0], fis, shown)
        for i, variable in enumerate(fis.inputs):
            _input_column(columns[1 + i], fis, i, float(x[i]), shown, inches * widths[1 + i])
            above = f"{_label(variable, inches * widths[1 + i])}\n= {number(float(x[i]))}"
            columns[1 + i].set_title(above, parse_math=False)
        middle = 1 + len(fis.inputs)
        _firing_column(columns[middle], result.firing, shown)
        for j, variable in enumerate(fis.outputs):
            c = middle + 1 + j
            bottom = figure.add_subplot(grid[1, c])
            _output_column(columns[c], bottom, fis, j, result, shown, inches * widths[c])
            columns[c].set_title(f"{_label(variable, inches * widths[c])}\nproposed", parse_math=False)
        rule = "average" if fis.defuzzification == "wtaver" else "sum"
        below = (foot / 2 + axis) / height
        right = columns[middle].get_position().x1
        text = f"result: the weighted {rule} of the proposals; a bar is as high as the rule's share"
        text = fill(text, max(14, min(48, int((right * total - 0.1) / 0.052))))  # 0.052 in a letter at this size
        if title is not None:
            figure.text(0.1 / total, 1 - 0.06 / height, title, va="top", fontsize=9, parse_math=False)
        figure.text(right, below - 0.12 / height, text, ha="right", va="center", fontsize=_SMALL, color="0.3")
        return figure


def _label(variable: Variable, width: float) -> str:
    """The name with the unit on one line; only the name is shortened."""
    unit = f" [{variable.unit}]" if variable.unit else ""
    return shortened(variable.name, width - text_width(unit, 8), 8) + unit


def _prepare(ax: Axes, rows: int) -> None:
    ax.set_ylim(rows, 0)
    ax.set_yticks([])
    ax.grid(False)
    for side in ("left", "top", "right"):
        ax.spines[side].set_visible(False)
    for row in range(rows + 1):
        ax.axhline(row, color="0.85", linewidth=0.4, zorder=0, clip_on=False)


def _base(row: int) -> float:
    return row + 0.5 + _FILL / 2 + 0.06


def _numbers(ax: Axes, fis: Sugeno, shown: Sequence[int]) -> None:
    ax.set_xticks([])
    ax.set_xlim(0, 1)
    ax.spines["bottom"].set_visible(False)
    ax.set_title("rule\n", fontsize=8)
    for row, r in enumerate(shown):
        rule = fis.rules[r]
        words = [str(r + 1)]
        if rule.connective == "or" and len(rule.when) > 1:
            words.append("or")
        if rule.weight != 1:
            words.append(f"×{number(rule.weight)}")
        ax.text(0.5, row + 0.5, "\n".join(words), ha="center", va="center", fontsize=7, linespacing=0.95)


def _clause_label(clause: Clause) -> str:
    hedges = hedge_words(clause.power)
    term = f"{clause.term}^{clause.power:g}" if hedges is None else f"{hedges} {clause.term}".strip()
    return f"not {term}" if clause.negated else term


def _input_column(ax: Axes, fis: Sugeno, i: int, value: float, shown: Sequence[int], inches: float) -> None:
    variable = fis.inputs[i]
    low, high = variable.universe
    inside = min(max(value, low), high) if np.isfinite(value) else value
    # A system that clips its inputs evaluates the terms at the edge.
    used = inside if fis.out_of_range == "clip" else value
    x = universe_grid(variable, 201)
    for row, r in enumerate(shown):
        base = _base(row)
        clause = next((c for c in fis.rules[r].when if c.variable == variable.name), None)
        if clause is None:
            side = 0.75 if inside < (low + high) / 2 else 0.25
            ax.text(
                low + side * (high - low), row + 0.5, "any", color="0.55", fontsize=_SMALL, ha="center", va="center"
            )
            continue
        term = variable.terms[clause.term]
        curve, degree = clause.degree(np.asarray(term(x))), float(clause.degree(np.asarray(term(used))))
        color = COLORS[list(variable.terms).index(clause.term) % len(COLORS)]
        if np.isfinite(degree):
            filled = base - _FILL * np.minimum(curve, degree)
            ax.fill_between(x, base, filled, color=color, alpha=0.45, linewidth=0, clip_on=False)
        ax.plot(x, base - _FILL * curve, color=color, linestyle="-", linewidth=0.9, clip_on=False)
        ax.plot([low, high], [base, base], color="0.6", linewidth=0.4, linestyle="-")
        _label_where_free(ax, x, curve, inside, base, _clause_label(clause), inches)
    if np.isfinite(inside):
        ax.axvline(inside, color=HIGHLIGHT, linestyle="-" if inside == value else ":", linewidth=1.0, zorder=3)
    ax.set_xlim((low, high) if high > low else (low - 0.5, high + 0.5))
    _ends_only(ax, low, high, inches)


def _label_where_free(
    ax: Axes, x: np.ndarray, curve: np.ndarray, value: float, base: float, text: str, inches: float
) -> None:
    """Write the clause where neither its curve nor the input's line passes: above a low part, or below a high one."""
    text = shortened(text, 0.75 * inches, _SMALL)
    part = text_width(text, _SMALL) / inches + 0.04
    low, high = float(x[0]), float(x[-1])
    scale = (high - low) or 1.0
    position, line = (x - low) / scale, (value - low) / scale
    best, cost = ("left", "top"), np.inf
    for side, start in (("left", 0.0), ("right", 1.0 - part), ("center", 0.5 - part / 2)):
        covered = curve[(position >= start) & (position <= start + part)]
        crossed = 0.3 if start <= line <= start + part else 0.0
        for edge, height in (("top", covered.max(initial=0)), ("bottom", 1.05 - covered.min(initial=1))):
            if height + crossed < cost - 1e-9:
                best, cost = (side, edge), height + crossed
    side, edge = best
    ax.text(
        low + {"left": 0.02, "center": 0.5, "right": 0.98}[side] * scale,
        base - _FILL + 0.02 if edge == "top" else base - 0.04,
        text,
        fontsize=_SMALL,
        ha=side,
        va=edge,
        parse_math=False,
        zorder=4,
        bbox={"facecolor": "white", "alpha": 0.75, "edgecolor": "none", "pad": 0.3} if edge == "top" else None,
    )


def _ends_only(ax: Axes, low: float, high: float, inches: float) -> None:
    """Ticks at the two ends and the middle, the end labels inside the column so that neighbours do not meet.

    Where the middle's label has no room between them, its tick has none.
    """
    words = [number(low), number((low + high) / 2), number(high)]
    ends, middle = (text_width(word, 7) for word in (max(words[::2], key=len), words[1]))
    if ends + middle / 2 + 0.06 > inches / 2:
        words[1] = ""
    ax.set_xticks([low, (low + high) / 2, high], words)
    labels = ax.get_xticklabels()
    labels[0].set_horizontalalignment("left")
    labels[-1].set_horizontalalignment("right")


def _firing_column(ax: Axes, firing: np.ndarray, shown: Sequence[int]) -> None:
    ax.set_xlim(0, 1)
    ax.set_xticks([0, 1], ["0", "1"])
    ax.set_title("firing\nstrength")
    for row, r in enumerate(shown):
        strength = float(firing[r])
        if not np.isfinite(strength):
            continue
        ax.barh(row + 0.5, strength, height=0.5, color=COLORS[4], linewidth=0, gid=f"firing-{r + 1}")
        text = f"{strength:.3f}" if strength >= 5e-4 or strength == 0 else "<0.001"
        outside = strength < 0.45
        ax.text(
            strength + 0.04 if outside else strength - 0.04,
            row + 0.5,
            text,
            fontsize=_SMALL,
            ha="left" if outside else "right",
            va="center",
            color="0.55" if strength == 0 else "black",
        )


def _output_column(
    ax: Axes, bottom: Axes, fis: Sugeno, j: int, result: Inference, shown: Sequence[int], inches: float
) -> None:
    output = fis.outputs[j]
    takes_part = fis.structure.consequent[j] >= 0
    proposed = result.rule_outputs[:, j]
    weights = np.where(takes_part, result.weights, 0.0)
    shares = weights / weights.sum() if weights.sum() > 0 else weights
    value = float(result.output[j])
    all_values = [*proposed[takes_part], value]
    finite = [v for v in all_values if np.isfinite(v)]
    low, high = min([output.universe[0], *finite]), max([output.universe[1], *finite])
    margin = 0.06 * (high - low) or 0.5
    low, high = low - margin, high + margin
    for row, r in enumerate(shown):
        if not takes_part[r]:
            ax.text((low + high) / 2, row + 0.5, "–", color="0.55", fontsize=_SMALL, ha="center", va="center")
            continue
        z, base = float(proposed[r]), _base(row)
        if not np.isfinite(z):
            continue
        ax.plot([low, high], [base, base], color="0.6", linewidth=0.4, linestyle="-")
        ax.plot([z, z], [base, base - _FILL], color="0.75", linestyle="-", linewidth=0.8)
        ax.plot([z, z], [base, base - _FILL * shares[r]], color=COLORS[0], linestyle="-", linewidth=2.2)
        left = z > (low + high) / 2
        room = max(z - low, high - z) / (high - low) - 0.04
        term, said = dict(fis.rules[r].then)[output.name], f" = {number(z)}"
        ax.text(
            z + (-0.02 if left else 0.02) * (high - low),
            row + 0.5,
            shortened(term, room * inches - text_width(said, _SMALL), _SMALL) + said,
            fontsize=_SMALL,
            ha="right" if left else "left",
            va="center",
            parse_math=False,
            color="0.45" if shares[r] == 0 else "black",
        )
    ax.set_xlim(low, high)
    ax.set_xticks([])
    ax.spines["bottom"].set_visible(False)
    for r in range(len(fis.rules)):
        if takes_part[r] and shares[r] > 0:
            bottom.plot([proposed[r]] * 2, [0, shares[r]], color=COLORS[0], linestyle="-", linewidth=2.2)
    bottom.set(xlim=(low, high), ylim=(0, 2.0))
    bottom.set_yticks([])
    bottom.grid(False)
    bottom.spines["left"].set_visible(False)
    _ends_only(bottom, low + margin, high - margin, inches * (1 - 2 * margin / (high - low)))
    if np.isfinite(value):
        bottom.plot([value] * 2, [0, 1.15], color=HIGHLIGHT, linestyle="-", linewidth=1.2)
    said = f"= {quantity(value, output)}" if np.isfinite(value) else "not a number"
    if not result.fired[j]:
        said = f"no rule fires: {quantity(value, output)}" if np.isfinite(value) else "no rule fires"
    bottom.text(
        0.5, 0.92, shortened(said, inches, 8), transform=bottom.transAxes, ha="center", va="top",
        color=HIGHLIGHT, fontsize=8, parse_math=False,
    )  # fmt: skip
