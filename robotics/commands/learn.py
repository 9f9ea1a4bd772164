"""The command line ``robotics learn``: its commands."""

import typer

from robotics.commands.learn_formation import formation
from robotics.commands.learn_rules import rules_

learn = typer.Typer(
    help="Learn rule bases: of formations from data, or from what another law does.",
    rich_markup_mode=None,
    no_args_is_help=True,
)
learn.command()(formation)
learn.command("rules")(rules_)
