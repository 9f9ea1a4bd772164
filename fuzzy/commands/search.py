"""The command ``fuzzy search``: settings of clustering for a wanted number of rules."""

import sys
from typing import TYPE_CHECKING, Annotated

import typer

from fuzzy.commands.datafile import SkipBad
from fuzzy.commands.samples import (
    Inputs,
    Order,
    Outputs,
    Plot,
    Ridge,
    Table,
    draw_search,
    sample_table,
    searched,
    setting_of,
)
from fuzzy.commands.shared import check_plot
from fuzzy.shell.options import Json, option
from fuzzy.shell.terminal import FAILED, print_json
from fuzzy.shown import shown

if TYPE_CHECKING:
    from fuzzy.fitting.search import SearchResult


def search(
    file: Table,
    inputs: Inputs = None,
    outputs: Outputs = None,
    rules: Annotated[int, option("The number of rules that is wanted.", "N", min=1)] = 8,
    radii: Annotated[str | None, option("Radii to try. [default: 0.3,0.5,0.7,0.9]", "R,R")] = None,
    order: Order = 1,
    ridge: Ridge = 0.0,
    plot: Plot = None,
    skip_bad: SkipBad = False,
    json: Json = False,
) -> None:
    """Try every setting of subtractive clustering: the best error for each number of rules.

    The exit code is 1 if no setting gives the wanted number. `fuzzy identify --rules N` writes the best system.

    \b
    Example:
      fuzzy example samples
      fuzzy search samples.csv --inputs x,y --outputs v --rules 8 --plot error.png
    """
    check_plot(plot)
    samples = sample_table(file, inputs, outputs, skip_bad)
    result = searched(samples, rules, order, ridge, radii)
    if result.by_rules:
        draw_search(result, plot)
    missing = rules not in result.by_rules
    if json:
        rows = [{"rules": t.rules, "error": t.error, "rmse": t.rmse, **setting_of(t)} for t in result.by_rules.values()]
        counted = {"samples": len(samples.x), "skipped": samples.skipped, "settings": len(result.trials)}
        print_json({**counted, "wanted": rules, "found": not missing, "best": rows})
    else:
        print(f"{len(result.trials)} settings, {result.fitted} different systems; error: {_error_name(result)}")
        print("  rules  error      radius  squash  accept  reject")
        for trial in result.by_rules.values():
            radius, *rest = setting_of(trial).values()
            numbers = "".join(f"{value:8g}" for value in rest)
            mark = "  <- wanted" if trial.rules == rules else ""
            print(f"  {trial.rules:5d}  {shown(trial.error):>9}{radius:8g}{numbers}{mark}")
    if missing:
        print(f"no setting gives {rules} rules; try other --radii", file=sys.stderr)
        raise typer.Exit(FAILED)


def _error_name(result: "SearchResult") -> str:
    if len(result.outputs) > 1:
        return "RMSE / range over all outputs"
    name, unit = result.outputs[0]
    return f"RMSE of {name} [{unit}]" if unit else f"RMSE of {name}"
