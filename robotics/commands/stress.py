"""The command line ``robotics stress``: its commands."""

from fuzzy.shell.terminal import application
from robotics.commands.stress_crossing import crossing
from robotics.commands.stress_obstacles import obstacles

stress = application(
    "Simulate thousands of random scenarios and count what goes wrong.", "robotics stress crossing --runs 20"
)
stress.command()(crossing)
stress.command()(obstacles)
