"""The command line ``robotics dataset``: its commands."""

import typer

from robotics.commands.dataset_formation import formation
from robotics.commands.dataset_regenerate import regenerate

dataset = typer.Typer(help="Make training data.", rich_markup_mode=None, no_args_is_help=True)
dataset.command()(formation)
dataset.command()(regenerate)
