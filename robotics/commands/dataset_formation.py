"""The command ``robotics dataset formation``: data of leader-follower formations."""

from pathlib import Path
from typing import Annotated, Any

import typer

from fuzzy.errors import InputError
from fuzzy.shell.terminal import print_json
from robotics.commands.shared import Json


def formation(
    out: Annotated[Path, typer.Option("--out", "-o", metavar="FILE.csv", help="File into which the table goes.")],
    kind: Annotated[str, typer.Option(help="Kind of data: literal, or well-posed (with the lead dx).")] = "literal",
    check: Annotated[
        bool, typer.Option("--check", help="Make the checking set: the formation with the leader at -1.")
    ] = False,
    seed: Annotated[int, typer.Option(help="Seed of the displacements and of the cover.")] = 0,
    samples: Annotated[int, typer.Option(help="Number of samples of each formation.")] = 400,
    formations: Annotated[
        str | None, typer.Option(metavar="X,X,...", help="The leader's x at the start, in m. Default: -4,-2,0,2,4")
    ] = None,
    speed: Annotated[float | None, typer.Option(help="Desired speed v_d, m/s. Default: 0.1")] = None,
    coverage: Annotated[
        float | None, typer.Option(help="well-posed: share spread over (x_l, dx), the rest along runs. Default: 1")
    ] = None,
    jitter: Annotated[float | None, typer.Option(help="well-posed: share displaced. Default: 0.6")] = None,
    lateral: Annotated[float | None, typer.Option(help="well-posed: largest displacement, m. Default: 0.1")] = None,
    heading: Annotated[float | None, typer.Option(help="well-posed: largest rotation, rad. Default: 0.15")] = None,
    lead: Annotated[
        float | None, typer.Option(help="well-posed: largest change of dx along runs, m. Default: 0.5")
    ] = None,
    json: Json = False,
) -> None:
    """Make data of leader-follower formations: what all robots do, by the leader's posture.

    The same options give the same file. Example: robotics dataset formation --kind well-posed -o formation.csv
    """
    from robotics.experiments.learning.formationdata import Recipe, checking, formation_data, write_data
    from robotics.experiments.learning.scatter import DRAWS, NEIGHBOURS, SHARE, scatter

    _expect_csv(out)
    own = {"coverage": coverage, "jitter": jitter, "lateral": lateral, "heading": heading, "lead": lead}
    given: dict[str, Any] = {name: value for name, value in own.items() if value is not None}
    if kind == "literal" and given:
        raise InputError(f"--{next(iter(given))} belongs to --kind well-posed; literal data have nothing random")
    if check and formations is not None:
        raise InputError("--check is the formation with the leader at -1: give it or --formations, not both")
    if kind == "well-posed" and formations is not None and coverage is None:
        raise InputError("--formations needs --coverage below 1: without it no sample lies along a formation's run")
    if speed is not None:
        given["speed"] = speed
    if formations is not None:
        given["starts"] = _numbers(formations)
    recipe = Recipe(kind=kind, seed=seed, samples=samples, **given)  # type: ignore[arg-type]
    table = formation_data(checking(recipe) if check else recipe)
    write_data(out, table.names, table.values)
    inputs, outputs = table.names[: table.inputs], table.names[table.inputs :]
    found = None
    plenty = len(table.values) * SHARE > NEIGHBOURS
    if (
        kind == "literal" and not check and plenty
    ):  # one formation alone never contradicts itself, nor does the well-posed law
        found = scatter(table.values[:, : table.inputs], table.values[:, table.inputs :])
    if json:
        about = {"file": str(out), "kind": kind, "check": check, "seed": seed, "rows": len(table.values)}
        said = None
        if found is not None:
            rows = zip(outputs, *found, strict=True)
            said = {name: dict(zip(found._fields, map(float, row), strict=True)) for name, *row in rows}
        print_json(about | {"inputs": inputs, "outputs": outputs, "scatter": said})
        return
    print(f"{out}: {len(table.values)} rows, inputs {', '.join(inputs)}, outputs {', '.join(outputs)}")
    if found is not None:
        shown = ", ".join(f"{n} {r:.4f} ({a:.4f} to {b:.4f})" for n, r, a, b in zip(outputs, *found, strict=True))
        print(
            f"At equal inputs outputs scatter by about (RMS; Gamma test, mean and range of {DRAWS} draws): {shown}\n"
            "A smooth function errs by about that on fresh samples. A training error below it tells rows apart whose "
            "inputs are all but equal."
        )


def _expect_csv(path: Path) -> None:
    if path.suffix != ".csv":
        raise InputError(f"{path}: the file's name must end in .csv")


def _numbers(text: str) -> tuple[float, ...]:
    try:
        return tuple(float(part) for part in text.split(","))
    except ValueError:
        raise InputError(f"--formations must be numbers in m with commas between them, got {text!r}") from None
