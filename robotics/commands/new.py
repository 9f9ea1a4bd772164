"""The command ``robotics new``: a commented, runnable file to begin with."""

from pathlib import Path
from typing import Annotated

from fuzzy.errors import InputError
from fuzzy.files.atomic import write_whole
from fuzzy.naming import check_known, expected
from fuzzy.shell.options import Json, argument, option
from robotics.commands.completion import one_of
from robotics.commands.filekinds import FILE_KINDS, TEMPLATES, file_kind, template_text, write_template
from robotics.commands.shared import print_result

_KINDS = (*FILE_KINDS, *TEMPLATES)


def new(
    kind: Annotated[str, argument(f"One of {', '.join(_KINDS)}.", "FILEKIND", autocompletion=one_of(_KINDS))],
    out: Annotated[
        Path | None, option("The file. Default: my-KIND.toml, mylaw.py ...; - is stdout.", "--out", "-o", "FILE")
    ] = None,
    variant: Annotated[
        str | None, option("Kind of a scenario: tracking, team, formation or goal.", "--kind", show_default=False)
    ] = None,
    minimal: Annotated[bool, option("Write only what is set, without comments.")] = False,
    force: Annotated[bool, option("Overwrite a file that is there already.")] = False,
    json: Json = False,
) -> None:
    """Write a file that runs: what is needed is set, and comments explain all that is optional.

    \b
    Example:
      robotics new scenario --kind team -o mine.toml
      robotics check mine.toml
    """
    from robotics.tables.template import commented_file

    check_known(kind, _KINDS, "kind of file")
    if kind in TEMPLATES and (variant is not None or minimal):
        raise InputError(f"--kind and --minimal belong to TOML files, not to a {kind}")
    if kind in FILE_KINDS and variant is not None and variant not in file_kind(kind).templates:
        raise InputError(expected(variant, file_kind(kind).templates, f"kind of {kind}"))
    file = out or Path(TEMPLATES[kind][1] if kind in TEMPLATES else f"my-{kind}.toml")
    printed = str(file) == "-"
    if file.exists() and not (force or printed):
        raise InputError(f"{file} exists already, nothing was written; --force overwrites")
    if kind in TEMPLATES:
        if printed:
            print(template_text(kind), end="")
            return
        use = write_template(kind, file)
    else:
        made = file_kind(kind)
        use = made.use.replace("FILE", str(file))
        values = made.values[variant or next(iter(made.templates))]
        text = commented_file(made.table(), values, made.read, f"{made.title}: {use}", minimal)
        if printed:
            print(text, end="")
            return
        write_whole(file, text)
    print_result(json, {"file": str(file), "use": use}, f"{file}\n  {use}")
