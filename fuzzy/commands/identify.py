"""The command ``fuzzy identify``: a system from a table of samples."""

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from fuzzy.commands.datafile import FoldsOrder, SkipBad
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
    selected,
    setting_of,
)
from fuzzy.commands.shared import check_plot, parsed, usage
from fuzzy.files.atomic import check_target
from fuzzy.shell.options import FieldOptions, Json, option
from fuzzy.shell.terminal import print_json
from fuzzy.shown import shown

if TYPE_CHECKING:
    from fuzzy.fitting.clustering import ClusteringOptions

Method = Literal["grid", "subtractive", "fcm"]  # how the antecedents are found


def identify(
    *,
    file: Table,
    inputs: Inputs = None,
    outputs: Outputs = None,
    method: Annotated[Method, option("How the antecedents are found.")] = "subtractive",
    output_file: Annotated[
        Path | None, option("By default DATA's name with .fis, here.", "-o", "--output-file", "OUT.fis")
    ] = None,
    rules: Annotated[int | None, option("Search the settings for N rules (subtractive).", "N", min=1)] = None,
    radius: Annotated[
        float | None, option("Radius of a cluster, a share of the range (subtractive). [default: 0.5]")
    ] = None,
    cluster: Annotated[
        "partial[ClusteringOptions]",
        FieldOptions("fuzzy.fitting.clustering:ClusteringOptions", given=True, of="subtractive"),
    ],
    mfs: Annotated[str | None, option("Terms an input, or of each (grid). [default: 2]", "N[,N...]")] = None,
    kind: Annotated[
        str | None, option("Membership functions, MATLAB's name (grid). [default: gbellmf]", "NAME")
    ] = None,
    clusters: Annotated[int | None, option("Number of clusters (fcm). [default: as subtractive finds]", min=1)] = None,
    seed: Annotated[int | None, option("Seed of the random start (fcm). [default: 0]", min=0)] = None,
    order: Order = 1,
    ridge: Ridge = 0.0,
    fit: Annotated[bool, option("Fit the consequents, or leave them 0.", "--fit/--no-fit")] = True,
    select: Annotated[
        bool, option("Take only the inputs that are needed, found one after the other by cross-validation.")
    ] = False,
    folds: Annotated[int | None, option("With --select: number of folds. [default: 5]", "K", min=2)] = None,
    fold_order: FoldsOrder = "shuffled",
    plot: Plot = None,
    skip_bad: SkipBad = False,
    json: Json = False,
) -> None:
    """Make a system from samples: antecedents by a grid or by clusters, consequents by least squares.

    With --rules the settings of subtractive clustering are searched for the best system with that number of rules,
    as `fuzzy search` does. A header "speed [m/s]" names the column speed. The table's columns are separated by commas,
    semicolons or tabs; numbers have a decimal point or a decimal comma. Columns that are not used may hold anything.
    Terms stand in the order of their places, which name them: low, middle, high. --select adds inputs while that
    lowers the error on held-back samples, and takes the fewest within one standard error of the least.

    \b
    Example:
      fuzzy example samples
      fuzzy identify samples.csv --inputs x,y --outputs v --method subtractive --radius 0.5 -o net.fis
      fuzzy identify samples.csv --outputs v --select
    """
    import numpy as np

    from fuzzy.files.fisfile import write_fis
    from fuzzy.fitting.identification import identify as identified
    from fuzzy.fitting.termnames import with_telling_names

    settings: dict[str, Any] = {"radius": radius, "mfs": mfs, "kind": kind, "clusters": clusters, "seed": seed}
    _only(method, "grid", {"mfs": mfs, "kind": kind})
    _only(method, "fcm", {"clusters": clusters, "seed": seed})
    _only(method, "subtractive", {"radius": radius, **cluster.keywords, "rules": rules, "plot": plot})
    if rules is not None and any(value is not None for value in (radius, *cluster.keywords.values())):
        usage("--rules searches radius, squash, accept and reject: leave them out")
    if select and (rules is not None or "," in (mfs or "")):
        usage("--select makes a system of many sets of inputs: leave --rules out, and give --mfs one number")
    if not select and (folds is not None or fold_order != "shuffled"):
        usage("--folds and --fold-order say how --select judges: they go with it")
    if plot is not None and rules is None:
        usage("--plot draws the search: it goes with --rules")
    if rules is not None and not fit:
        usage("--rules compares fitted systems: leave --no-fit out")
    check_plot(plot)
    target = Path(f"{file.stem}.fis") if output_file is None else output_file
    check_target(target)
    samples = sample_table(file, inputs, outputs, skip_bad)
    if mfs is not None:
        counts = [parsed(int, text, "expected a whole number") for text in mfs.split(",")]
        settings["mfs"] = counts[0] if len(counts) == 1 else counts
    if cluster.keywords:
        settings["options"] = cluster()
    found = None
    if rules is not None:
        found = searched(samples, rules, order, ridge)
        settings.update(radius=found.best.radius, options=found.best.options)
        draw_search(found, plot)
    about = {name: value for name, value in settings.items() if value is not None}
    selection = None
    if select:
        make = partial(identified, method=method, order=order, ridge=ridge, **about)  # type: ignore[arg-type]
        selection, samples = selected(samples, make, folds or 5, fold_order)
    fis = identified(
        samples.x,
        samples.y,
        method,
        name=target.stem,
        order=order,  # type: ignore[arg-type]
        fit=fit,
        ridge=ridge,
        **samples.names,
        **about,
    )
    fis = with_telling_names(fis)
    write_fis(fis, target)
    rmse = np.sqrt(np.mean((fis(samples.x) - samples.y) ** 2, axis=0))
    if json:
        errors = {v.name: float(error) for v, error in zip(fis.outputs, rmse, strict=True)}
        setting = {} if found is None else {"setting": setting_of(found.best)}
        counted = {"samples": len(samples.x), "skipped": samples.skipped}
        chosen = {} if selection is None else {"inputs": [v.name for v in fis.inputs], "steps": selection}
        print_json({"file": str(target), "rules": len(fis.rules), "rmse": errors, **counted, **setting, **chosen})
        return
    for step in selection or ():
        print(
            f"{', '.join(step['inputs'])}: {shown(step['error'])} ± {shown(step['deviation'])} of the outputs' spread"
        )
    if selection is not None:
        print(f"inputs: {', '.join(v.name for v in fis.inputs)}")
    if found is not None:
        print(", ".join(f"{name} {shown(value)}" for name, value in setting_of(found.best).items()))
    errors_text = ", ".join(
        f"{v.name} {shown(error)} {v.unit}".rstrip() for v, error in zip(fis.outputs, rmse, strict=True)
    )
    print(f"{target}: {len(fis.rules)} rules, RMSE of the samples: {errors_text}")


def _only(method: Method, where: Method, values: dict[str, Any]) -> None:
    given = [f"--{name}" for name, value in values.items() if value is not None]
    if given and method != where:
        usage(f"{', '.join(given)} goes with --method {where}, not {method}")
