"""The command ``robotics copy``: packaged rule bases, scenarios and robots as files of one's own."""

from pathlib import Path
from typing import Annotated

from fuzzy.shell.options import Json, argument, option
from fuzzy.shell.terminal import print_json
from robotics.commands.completion import copies


def copy(
    names: Annotated[
        list[str],
        argument(
            "Rule bases, folders of them, scenarios, robots; write tracking.fis or x.toml where a name is both.",
            "NAME",
            autocompletion=copies,
        ),
    ],
    to: Annotated[Path, option("Where the copies go; made if need be.", "FOLDER")] = Path(),
    force: Annotated[bool, option("Overwrite files that are there already.")] = False,
    json: Json = False,
) -> None:
    """Copy packaged rule bases, scenarios and robots, to change them; `robotics list` says which there are.

    \b
    Example:
      robotics copy tracking three-cross --to mine
      robotics run mine/three-cross.toml --controller cooperation:rule_base=mine/tracking.fis
    """
    from robotics.simulation.scenario.copying import copy_packaged

    copies = copy_packaged(names, to, force)
    if json:
        print_json({"copies": [{"name": c.name, "file": str(c.file), "use": c.use} for c in copies]})
        return
    for place, each in enumerate(copies):
        print(each.file)
        if [c.use for c in copies[place + 1 : place + 2]] != [each.use]:  # files that are used together
            print(f"  {each.use}")
