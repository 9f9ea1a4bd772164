"""The command ``robotics new``: a commented, runnable file to begin with."""

from pathlib import Path
from typing import Annotated

import typer

from fuzzy.errors import InputError
from fuzzy.files.atomic import replacing
from fuzzy.naming import expected
from fuzzy.shell.terminal import print_json
from robotics.commands.filekinds import KINDS
from robotics.commands.scenario import file_kind
from robotics.commands.shared import Json


def new(
    kind: Annotated[str, typer.Argument(metavar="FILEKIND", help=f"One of {', '.join(KINDS)}.", show_default=False)],
    out: Annotated[
        Path | None, typer.Option("--out", "-o", metavar="FILE", help="The file. Default: my-KIND.toml; - is stdout.")
    ] = None,
    variant: Annotated[
        str | None, typer.Option("--kind", help="Of a scenario: tracking, team or formation.", show_default=False)
    ] = None,
    minimal: Annotated[bool, typer.Option("--minimal", help="Write only what is set, without comments.")] = False,
    force: Annotated[bool, typer.Option("--force", help="Overwrite a file that is there already.")] = False,
    json: Json = False,
) -> None:
    """Write a file that runs: what is needed is set, all that is optional stands there as a comment that explains it.

    Example: robotics new scenario --kind team -o mine.toml, then robotics check mine.toml
    """
    from robotics.tables.template import commented_file

    made = file_kind(kind)
    if variant is not None and variant not in made.values:
        raise InputError(expected(variant, made.values, f"kind of {kind}"))
    values = made.values[variant] if variant is not None else next(iter(made.values.values()))
    file = out if out is not None else Path(f"my-{kind}.toml")
    if str(file) != "-" and file.exists() and not force:
        raise InputError(f"{file} exists already, nothing was written; --force overwrites")
    use = made.use.replace("FILE", str(file))
    text = commented_file(made.table(), values, made.read, f"{made.title}: {use}", minimal)
    if str(file) == "-":
        print(text, end="")
        return
    with replacing(file) as path:
        path.write_text(text, encoding="utf-8")
    if json:
        print_json({"file": str(file), "use": use})
    else:
        print(f"{file}\n  {use}")
