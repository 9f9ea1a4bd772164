"""The command line ``robotics stress``: its commands."""

import typer

from robotics.commands.stress_crossing import crossing
from robotics.commands.stress_obstacles import obstacles

stress = typer.Typer(
    help="Simulate thousands of random scenarios and count what goes wrong.",
    rich_markup_mode=None,
    no_args_is_help=True,
)
stress.command()(crossing)
stress.command()(obstacles)
