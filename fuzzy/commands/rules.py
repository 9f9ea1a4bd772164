"""The command ``fuzzy rules``: the rules as sentences."""

from fuzzy.commands.shared import FisFile, read_system
from fuzzy.shell.options import Json
from fuzzy.shell.terminal import print_json


def rules(file: FisFile, json: Json = False) -> None:
    """Print the rules as sentences, one on each line.

    \b
    Example:
      fuzzy example tipper
      fuzzy rules tipper.fis
      fuzzy rules tracking
    """
    sentences = [str(rule) for rule in read_system(file).rules]
    if json:
        print_json({"rules": sentences})
    else:
        print("".join(sentence + "\n" for sentence in sentences), end="")
