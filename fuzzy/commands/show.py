"""The command ``fuzzy show``: a system in words."""

from fuzzy.commands.shared import FisOrTree, read_system, read_tree
from fuzzy.shell.options import Json
from fuzzy.shell.terminal import print_json


def show(file: FisOrTree, json: Json = False) -> None:
    """Show the system: its choices, variables, terms and rules; of a tree also what goes where.

    \b
    Example:
      fuzzy example tipper
      fuzzy show tipper.fis
      fuzzy show tracking
    """
    from fuzzy.insight.description import as_dict, describe

    if tree := read_tree(file):
        print_json(tree.as_dict()) if json else print(tree.describe())
        return
    fis = read_system(file)
    print_json(as_dict(fis)) if json else print(describe(fis))
