"""The commands ``fuzzy export``: a system for other machines."""

from fuzzy.shell.terminal import application

export = application(
    "Write a system for another machine.",
    "fuzzy example tipper",
    "fuzzy export c tipper.fis -o out",
    modules="fuzzy.commands.export_",
    commands="c",
)
