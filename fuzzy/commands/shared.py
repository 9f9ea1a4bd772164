"""What several commands share: arguments and options, reading a system, and values given as INPUT=VALUE."""

import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NoReturn, TypeVar

import typer

from fuzzy.commands.completion import rule_bases
from fuzzy.shell.options import argument, option

if TYPE_CHECKING:
    from fuzzy import Tree, Type2Sugeno
    from fuzzy.system import Sugeno

T = TypeVar("T")
STDIN = Path("-")
FisFile = Annotated[
    Path,
    argument(
        "A Sugeno system: a .fis file, - for standard input, or a packaged one's name.",
        "FILE",
        autocompletion=rule_bases,
    ),
]
FisOrTree = Annotated[
    Path,
    argument(
        "A .fis file, - for standard input, a packaged system's name, or the folder of a tree of systems.",
        "FILE",
        autocompletion=rule_bases,
    ),
]
Picture = Annotated[Path | None, option("The picture to write: .png, .pdf or .svg.", "-o", "--output-file", "PICTURE")]
At = Annotated[
    list[str] | None, option("An input's value; repeat it. The others are at midrange.", "--at", "INPUT=VALUE")
]


def read_system(file: Path) -> "Sugeno":
    """Read the system in a .fis file, of standard input (-), or the packaged one of that name.

    Raises FisFileError, FisNameError.
    """
    from fuzzy.files.fisfile import parse_bytes, read_fis, warned
    from fuzzy.files.packaged import find_fis

    if _is_tree(file):
        usage(
            f"{file} is a tree of systems: evaluate, explain, export c, plot, show and tune take it, others a .fis "
            "file of it"
        )
    if file == STDIN:
        return warned(parse_bytes(sys.stdin.buffer.read(), "standard input")).system
    return read_fis(find_fis(file))


def read_tree(file: Path) -> "Tree | None":
    """Read the tree in a folder that holds a tree.toml, or in such a file; None where ``file`` is something else."""
    import fuzzy

    return fuzzy.read_tree(file) if _is_tree(file) else None


def _is_tree(file: Path) -> bool:
    return file.name == "tree.toml" or os.path.isfile(file / "tree.toml")  # noqa: PTH113 - raises nothing


def read_either(file: Path) -> "Sugeno | Type2Sugeno":
    """Read a system as :func:`read_system` does, or the interval type-2 system in a .fis file."""
    import fuzzy
    from fuzzy.files.packaged import find_fis

    try:
        return read_system(file)
    except fuzzy.Type2Error:
        if file == STDIN:
            raise
        return fuzzy.read_type2(find_fis(file))


def usage(message: str) -> NoReturn:
    """Refuse how the command was called, with this sentence."""
    raise typer.BadParameter(message)


def parsed(kind: Callable[[str], T], text: str, wanted: str) -> T:
    """A text as a number of a ``kind``, int or float; ``wanted`` begins the sentence that refuses another one."""
    try:
        return kind(text)
    except ValueError:
        usage(f"{wanted}, got {text!r}")


def values_of(fis: "Sugeno | Tree", texts: Sequence[str]) -> dict[str, float]:
    """Parse INPUT=VALUE texts into finite numbers, with a decimal point or comma, by the input's name."""
    from fuzzy.files.decimals import Marks, numbers_of, why_no_number
    from fuzzy.naming import expected

    values: dict[str, float] = {}
    for text in texts:
        # From the right: a name may hold an equals sign, a number cannot.
        name, sign, number = text.rpartition("=")
        if not sign:
            usage(f"expected INPUT=VALUE, got {text!r}")
        if name not in [v.name for v in fis.inputs]:
            usage(expected(name, [v.name for v in fis.inputs], "input"))
        if name in values:
            usage(f"two values for the input {name!r}")
        (values[name],), doubt = numbers_of([number], lambda: Marks(False, False), semicolons=False)
        if doubt:
            usage(f"the value of {name!r} {doubt}")
        if values[name] != values[name]:
            usage(f"the value of {name!r} must be a finite number: {why_no_number(number)}")
    return values


def check_plot(path: Path | None) -> None:
    """Refuse a picture of an unknown kind, if one is asked for, before anything is computed."""
    if path is not None:
        from fuzzy.figures.drawing import check_picture

        check_picture(path)


def picture_path(path: Path | None, file: Path, kind: str) -> Path:
    """The picture to write, refused before anything is drawn if its suffix is unknown.

    By default it is called by the system, a file or a packaged one's name, and stands in the present folder.
    """
    path = path or Path(f"{stem_of(file)}-{kind}.png")
    check_plot(path)
    return path


def stem_of(file: Path) -> str:
    """The beginning of the names of what is drawn of a system, a file or a packaged one's name."""
    from fuzzy.files.packaged import find_fis

    if file == STDIN:
        return "stdin"
    return file.stem if find_fis(file) == file else "-".join(file.parts)  # of formation/v_l: formation-v_l
