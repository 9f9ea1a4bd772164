"""The command ``fuzzy example``: the small files of the examples, as files of one's own."""

from pathlib import Path
from typing import Annotated

from fuzzy.commands.completion import examples
from fuzzy.commands.shared import usage
from fuzzy.shell.options import Json, argument, option
from fuzzy.shell.terminal import print_json


def example(
    names: Annotated[
        list[str] | None, argument("What to write; without a name all are listed.", "NAME", autocompletion=examples)
    ] = None,
    output_file: Annotated[Path | None, option("Another name for the one file.", "-o", "--output-file", "FILE")] = None,
    every: Annotated[bool, option("Write all of them into this folder.", "--all")] = False,
    force: Annotated[bool, option("Overwrite other files of these names.")] = False,
    json: Json = False,
) -> None:
    """List the small files that the examples of every --help use, or write them into this folder.

    \b
    Example:
      fuzzy example
      fuzzy example tipper
      fuzzy example samples -o mine.csv
      fuzzy example --all
    """
    from fuzzy.files.examples import EXAMPLES, example_file, example_names, write_examples

    wanted = example_names() if every else names or []
    if every and names:
        usage("give names or --all, not both")
    if output_file is not None and len(wanted) != 1:
        usage("-o names one file: give one example with it")
    if not wanted:
        if json:
            print_json({"examples": [{"file": file, "holds": holds} for file, holds in EXAMPLES.items()]})
            return
        for file, holds in EXAMPLES.items():
            print(f"{Path(file).stem:9} {file:12} {holds}")
        return
    targets = [(name, Path(example_file(name)) if output_file is None else output_file) for name in wanted]
    write_examples(targets, force)
    if json:
        print_json({"files": [str(path) for _, path in targets]})
    else:
        print(*(path for _, path in targets), sep="\n")
