"""The command line ``robotics dataset``: its commands."""

from fuzzy.shell.terminal import application

dataset = application(
    "Make training data.",
    "robotics dataset formation --kind well-posed -o formation.csv",
    program="robotics-dataset",
    modules="robotics.commands.dataset_",
    commands="formation",
)
