"""The command ``fuzzy show``: a system in words."""

from fuzzy.commands.shared import FisFile, read_system
from fuzzy.shell.options import Json
from fuzzy.shell.terminal import print_json


def show(file: FisFile, json: Json = False) -> None:
    """Show the system: its choices, variables, terms and rules.

    \b
    Example:
      fuzzy example tipper
      fuzzy show tipper.fis
      fuzzy show tracking
    """
    from fuzzy.insight.description import as_dict, describe

    fis = read_system(file)
    print_json(as_dict(fis)) if json else print(describe(fis))
