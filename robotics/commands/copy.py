"""The command ``robotics copy``: packaged rule bases, scenarios and robots as files of one's own."""

from pathlib import Path
from typing import Annotated

import typer

from fuzzy.shell.options import Json
from fuzzy.shell.terminal import print_json
from robotics.commands.completion import copies


def copy(
    names: Annotated[
        list[str],
        typer.Argument(
            metavar="NAME",
            help="Rule bases, folders of them, scenarios, robots; write tracking.fis or x.toml where a name is both.",
            show_default=False,
            autocompletion=copies,
        ),
    ],
    to: Annotated[Path, typer.Option("--to", metavar="FOLDER", help="Where the copies go; made if need be.")] = Path(),
    force: Annotated[bool, typer.Option("--force", help="Overwrite files that are there already.")] = False,
    json: Json = False,
) -> None:
    """Copy packaged rule bases, scenarios and robots, to change them; `robotics list` says which there are.

    \b
    Example:
      robotics copy tracking three-cross --to mine
      robotics run mine/three-cross.toml --controller cooperation:rule_base=mine/tracking.fis
    """
    from robotics.scenario.copying import copy_packaged

    copies = copy_packaged(names, to, force)
    if json:
        print_json({"copies": [{"name": c.name, "file": str(c.file), "use": c.use} for c in copies]})
        return
    for place, each in enumerate(copies):
        print(each.file)
        if [c.use for c in copies[place + 1 : place + 2]] != [each.use]:  # files that are used together
            print(f"  {each.use}")
