"""The commands ``robotics export``: a law for a robot."""

from fuzzy.shell.terminal import application
from robotics.commands.export_c import c

export = application("Write a control law for a robot.", "robotics export c fuzzy -o out")
export.command("c")(c)


@export.callback()
def _group() -> None:
    pass
