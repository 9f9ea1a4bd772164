"""The command ``fuzzy new``: a new rule base from a start."""

from pathlib import Path
from typing import Annotated, Any

import typer

from fuzzy.commands.completion import starts as known_starts
from fuzzy.commands.shared import usage
from fuzzy.errors import InputError
from fuzzy.shell.options import Json, argument, option
from fuzzy.shell.terminal import print_json


def new(
    start: Annotated[
        str | None, argument("What it begins with; without one all are listed.", "START", autocompletion=known_starts)
    ] = None,
    options: Annotated[list[str] | None, argument("The start's options.", "OPTION=VALUE")] = None,
    output_file: Annotated[
        Path | None, option("By default START's name with .fis, here.", "-o", "--output-file", "FILE.fis")
    ] = None,
    quiet: Annotated[bool, option("Show no progress.", "--quiet", "-q")] = False,
    json: Json = False,
) -> None:
    """Make a new rule base: an empty grid, clusters of a table, a control table, a shipped rule base, and others.

    They are those of the designer's menu File, New from. `fuzzy new` lists them with their options. A file that exists
    is never overwritten.

    \b
    Example:
      fuzzy new
      fuzzy new grid inputs=2 terms=5 shape=gaussmf -o mine.fis
      fuzzy example samples
      fuzzy new clusters file=samples.csv radius=0.4 -o speed.fis
    """
    from fuzzy.files.atomic import check_target
    from fuzzy.files.fisfile import write_fis
    from fuzzy.shell.progress import Mover, progress_bar
    from fuzzy.starts.catalogue import find_starts

    catalogue = find_starts()
    for sentence in catalogue.unusable:
        typer.echo(sentence, err=True)
    if start is None:
        _list(catalogue.starts, json)
        return
    chosen = catalogue.start(start)
    given: dict[str, Any] = {}
    for text in options or []:
        name, sign, value = text.partition("=")
        if not sign:
            usage(f"expected OPTION=VALUE, got {text!r}")
        if name in given:
            usage(f"two values for {name!r}")
        given[name] = value
    target = Path(f"{start.replace('/', '-')}.fis") if output_file is None else output_file
    check_target(target, ".fis")
    if target.exists():
        raise InputError(f"{target} exists already; choose another name with -o")
    with progress_bar(quiet or not chosen.reports, width=44) as begin:
        move = Mover(begin(chosen.title, 1000))
        fis = chosen.made(given, target.stem, lambda share, said: move(round(1000 * share), said))
    write_fis(fis, target)
    if json:
        print_json({"file": str(target), "start": start, "rules": len(fis.rules)})
        return
    ins, outs = (", ".join(v.name for v in group) for group in (fis.inputs, fis.outputs))
    print(f"{target}: {len(fis.rules)} rules, {ins} -> {outs}")


def _list(starts: Any, json: bool) -> None:
    if json:
        print_json({"starts": [start.described() for start in starts]})
        return
    group = None
    for start in starts:
        if start.group != group:
            print(f"{'' if group is None else chr(10)}{start.group}")
            group = start.group
        print(f"  {start.name:14} {start.sentence}")
        for each in start.options:
            print(f"    {each.name}={_accepted(each.described())}")


def _accepted(option: dict[str, Any]) -> str:
    """What an option accepts, and what it is by default, in a few words."""
    if option["kind"] == "choice":
        return f"{'|'.join(option['values'])} [{option['value']}]"
    if option["kind"] == "number":
        what = "" if option["whole"] else "any number "
        return f"{what}{option['low']:g} to {option['high']:g} [{option['value']:g}]"
    if option["kind"] == "file":
        return f"FILE{option['ending']}"
    return f"A,B [{option['usual']}]"
