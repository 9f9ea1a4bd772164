"""The command line ``robotics stress``: its commands."""

from fuzzy.shell.terminal import application

stress = application(
    "Simulate thousands of random scenarios and count what goes wrong.",
    "robotics stress crossing --runs 20",
    modules="robotics.plugins.stress.commands_stress_",
    commands="crossing obstacles",
)
