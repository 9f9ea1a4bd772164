"""The command ``fuzzy explain``: why a system answers what it answers."""

from typing import Annotated

from fuzzy.commands.shared import FisOrTree, read_system, read_tree, usage, values_of
from fuzzy.shell.options import Json, argument
from fuzzy.shell.terminal import print_json


def explain(
    file: FisOrTree,
    values: Annotated[list[str], argument("Every input's value.", "INPUT=VALUE")],
    json: Json = False,
) -> None:
    """Explain why the system answers what it answers at one point; of a tree, each of its systems.

    \b
    Example:
      fuzzy example tipper
      fuzzy explain tipper.fis service=3 food=8
      fuzzy explain lateral y_err=0.1
    """
    import fuzzy

    fis = read_tree(file) or read_system(file)
    given = values_of(fis, values)
    missing = [v.name for v in fis.inputs if v.name not in given]
    if missing:
        usage(f"no value for {', '.join(missing)}; write {' '.join(f'{name}=...' for name in missing)}")
    point = [given[v.name] for v in fis.inputs]
    explanation = fuzzy.explain(fis, point) if isinstance(fis, fuzzy.Sugeno) else fuzzy.explain_tree(fis, point)
    print_json(explanation.as_dict()) if json else print(explanation)
