"""The commands ``fuzzy export``: a system for other machines."""

from fuzzy.commands.export_c import c
from fuzzy.shell.terminal import application

export = application("Write a system for another machine.", "fuzzy example tipper", "fuzzy export c tipper.fis -o out")
export.command("c")(c)


@export.callback()
def _group() -> None:
    pass
