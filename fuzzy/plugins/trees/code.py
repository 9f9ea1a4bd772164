"""A tree in C: the files of each system, and a function that calls theirs one after the other."""

from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from fuzzy.files.atomic import write_together
from fuzzy.plugins.ccode.identifier import comment, identifiers
from fuzzy.plugins.ccode.numbertype import c_type
from fuzzy.plugins.ccode.phrases import signature
from fuzzy.plugins.ccode.plan import planned
from fuzzy.plugins.ccode.source import c_sources, header
from fuzzy.plugins.ccode.writing import CFiles
from fuzzy.plugins.trees.tree import Tree
from fuzzy.system import Sugeno
from fuzzy.words import counted


class TreeCFiles(NamedTuple):
    """The files of a tree in C.

    Attributes:
        header: The header (.h) of the tree's function.
        source: Its source (.c).
        systems: The files of each system, in the tree's order.
        name: The prefix of the tree's function.
        number: "double", "float" or "q16.16".
    """

    header: Path
    source: Path
    systems: tuple[CFiles, ...]
    name: str
    number: str


def write_c_tree(tree: Tree, folder: str | Path, number: str = "double", *, name: str = "") -> TreeCFiles:
    """Write a tree as C99 that allocates nothing: a header and a source of each system, and those of the tree.

    The tree's function calls those of its systems, and tells what they tell.

    Args:
        tree: The tree.
        folder: Where to write, made if it is not there.
        number: "double", "float", or "q16.16", fixed point without floating point at run time.
        name: The files' name and the functions' prefix; by default the tree's.

    Returns:
        The files that were written.

    Raises:
        ExportError: What C, or the type of numbers, does not have.
        OSError: Nothing can be written.
    """
    # The header knows inputs and outputs; what is between them is not asked for.
    shell = planned(Sugeno(tree.inputs, [replace(v, terms={}) for v in tree.outputs], (), tree.name), name)
    own, *names = identifiers([shell.name, *(f"{shell.name}_{system.lower()}" for system in tree.order)])
    kind = f"a tree of {counted(len(names), 'Takagi-Sugeno system')}"
    texts = {
        f"{own}.h": header(shell, c_type(number), kind, "what its system says"),
        f"{own}.c": _source(tree, own, names, c_type(number)),
    }
    for system, prefix in zip(tree.order, names, strict=True):
        texts |= c_sources(tree.systems[system], prefix, number).texts
    paths = write_together(folder, texts)
    systems = [CFiles(*each, number, None) for each in zip(paths[2::2], paths[3::2], names, strict=True)]
    return TreeCFiles(paths[0], paths[1], tuple(systems), own, number)


def _source(tree: Tree, own: str, names: list[str], real: str) -> str:
    """The tree's function: the values of all columns in one array, of which each system gets those that it takes."""
    made = len(tree.inputs)
    calls = []
    for system, prefix, wires in zip(tree.order, names, tree.wires, strict=True):
        taken = ", ".join(f"value[{k}]" for k in wires)
        calls.append(f"    {{ /* {comment(system)} */")
        calls.append(f"        const {real} in[{prefix.upper()}_INPUTS] = {{{taken}}};")
        calls.append(f"        told |= {prefix}_infer(in, value + {made});")
        calls.append("    }")
        made += len(tree.systems[system].outputs)
    copied = [f"    value[{k}] = x[{k}];" for k in range(len(tree.inputs))]
    given = [f"    y[{o}] = value[{k}]; /* {comment(tree.columns[k])} */" for o, k in enumerate(tree.answer_columns)]
    lines = [
        f"/* {comment(tree.name)}: see {own}.h. Made of the tree: change that. */",
        f'#include "{own}.h"',
        *(f'#include "{prefix}.h"' for prefix in names),
        "",
        f"{signature(own, real)} {{",
        f"    {real} value[{made}]; /* the inputs, and then what the systems answer */",
        "    int told = 0;",
        *copied,
        *calls,
        *given,
        "    return told;",
        "}",
        "",
    ]
    return "\n".join(lines)
