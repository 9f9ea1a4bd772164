"""The commands ``robotics export``: a law for a robot."""

from fuzzy.shell.terminal import application

export = application(
    "Write a control law for a robot.",
    "robotics export c fuzzy -o out",
    modules="robotics.commands.export_",
    commands="c",
)
