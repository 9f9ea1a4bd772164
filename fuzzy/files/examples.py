"""Small files that come with the package, so that the examples of every ``--help`` run as they are printed."""

from collections.abc import Sequence
from contextlib import ExitStack
from importlib import resources
from pathlib import Path

from fuzzy.errors import InputError
from fuzzy.files.atomic import replacing
from fuzzy.naming import expected

# What each file holds, by its name; a file's example is called by its stem.
EXAMPLES = {
    "tipper.fis": "a system: the tip for a meal, in %, by service and food",
    "mixing.fis": "a controller with its loop: a PID for each flow through a tank and a pipe, blended between",
    "meals.csv": "inputs of tipper.fis: 7 meals, service and food from 0 to 10",
    "samples.csv": "samples to learn from: 160 places x and y (m), and the speed v there (m/s)",
    "check.csv": "60 other samples of the same function, to check what was learnt",
    "errors.csv": "inputs of the packaged rule base lateral: 9 distances y_err from a path (m)",
}


class ExampleError(InputError):
    """The error for a name that no example has, or for a file that stands in the way."""


def example_names() -> list[str]:
    """The names of the examples: those of their files without the ending."""
    return [Path(file).stem for file in EXAMPLES]


def example_file(name: str) -> str:
    """The name of an example's file, ``tipper.fis`` of ``tipper`` and of itself. Raises ExampleError."""
    for file in EXAMPLES:
        if name in (file, Path(file).stem):
            return file
    raise ExampleError(expected(name, example_names(), "example"))


def is_example(path: Path) -> bool:
    """Whether the file holds what an example does, byte for byte."""
    folder = resources.files("fuzzy") / "examples"
    return path.name in EXAMPLES and path.is_file() and path.read_bytes() == (folder / path.name).read_bytes()


def write_examples(targets: Sequence[tuple[str, Path]], force: bool = False) -> None:
    """Write examples, given with the paths to write to: all of them or none.

    A file that is there already with the same content stays. Raises ExampleError for an unknown name and, without
    ``force``, for a file with another content; OSError where a file cannot be written.
    """
    folder = resources.files("fuzzy") / "examples"
    texts = {path: (folder / example_file(name)).read_bytes() for name, path in targets}
    other = [str(path) for path, text in texts.items() if path.is_file() and path.read_bytes() != text]
    if other and not force:
        verb = "exists" if len(other) == 1 else "exist"
        raise ExampleError(f"{', '.join(other)} {verb} already, nothing was written; --force overwrites")
    with ExitStack() as stack:
        for path, text in texts.items():
            stack.enter_context(replacing(path)).write_bytes(text)
