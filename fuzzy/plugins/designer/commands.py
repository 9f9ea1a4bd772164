"""The commands ``fuzzy design``, the designer in the browser, and ``fuzzy new``, a new rule base from a start."""

from pathlib import Path
from typing import Annotated, Any

import typer

from fuzzy.commands.completion import completed
from fuzzy.commands.shared import usage
from fuzzy.errors import InputError
from fuzzy.shell.options import Json, argument, option
from fuzzy.shell.terminal import print_json


class DesignError(InputError):
    """A designer that cannot start as it was told to."""


def design(
    file: Annotated[
        Path | None,
        argument(
            "The system, a new one if there is no such file; or a packaged one's name, to begin with a copy.",
            "FILE.fis",
        ),
    ] = None,
    port: Annotated[
        int | None, option("By default 8080, or the next that is free.", min=1, max=65535, show_default=False)
    ] = None,
    browser: Annotated[bool, option("Open the page in the browser.", "--browser/--no-browser")] = True,
    folder: Annotated[
        Path | None, option("What can be opened and saved; by default FILE's folder, else this one.", "FOLDER")
    ] = None,
) -> None:
    """Design a rule base in the browser: drag membership functions, edit rules, see what they do.

    The page is served on this machine only, to whoever has the token in the printed address; the environment variable
    FUZZYFLEET_TOKEN sets it, and empty asks for none. Nothing outside the folder is read or written. Unsaved work is
    kept beside the files and is back after a crash. A packaged rule base is copied: saving writes a new file in the
    folder.

    \b
    Example:
      fuzzy example tipper
      fuzzy design tipper.fis
      fuzzy design tracking
    """
    try:
        import nicegui  # noqa: F401
    except ImportError:
        from fuzzy.extras import install_command

        raise DesignError(f"the designer needs NiceGUI: {install_command('design')}") from None
    from fuzzy.files.fisfile import read_fis
    from fuzzy.plugins.designer.folder import open_folder
    from fuzzy.plugins.designer.server import serve

    if file is not None and (packaged := _packaged(file, folder)) is not None:
        opened = open_folder(folder or Path())
        serve(opened, opened.free_name("-".join(file.parts)), port, browser, begin=read_fis(packaged))
        return
    if folder is None:
        folder = Path() if file is None else file.resolve().parent
        if not folder.is_dir():
            raise DesignError(f"{file}: there is no folder {str(folder)!r} to put a new system into")
    opened = open_folder(folder)
    if file is None:
        name = opened.free_name()
    else:
        # A file is given from here, or from the folder.
        path = file.resolve() if file.exists() or not (opened.path / file).exists() else (opened.path / file).resolve()
        if not path.is_relative_to(opened.path):
            raise DesignError(f"{file} is not in the folder {opened.path}")
        name = opened.name(path)
    serve(opened, name, port, browser)


def _packaged(file: Path, folder: Path | None) -> Path | None:
    """The packaged rule base whose name ``file`` is; None if it is the path of a file, which need not exist.

    Raises FisNameError for what is neither.
    """
    from fuzzy.files.packaged import find_fis

    if file.suffix.lower() == ".fis" or (folder is not None and (folder / file).is_file()):
        return None
    found = find_fis(file)
    return None if found == file else found


def known_starts(incomplete: str) -> list[str]:
    """What a new rule base can begin with."""
    from fuzzy.plugins.designer.starts.catalogue import find_starts

    return completed(incomplete, [start.name for start in find_starts().starts])


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

    The starts are those of the designer's menu File, New from. `fuzzy new` lists them with their options. It never
    overwrites a file.

    \b
    Example:
      fuzzy new
      fuzzy new grid inputs=2 terms=5 shape=gaussmf -o mine.fis
      fuzzy example samples
      fuzzy new clusters file=samples.csv radius=0.4 -o speed.fis
    """
    from fuzzy.files.atomic import check_target
    from fuzzy.files.fisfile import write_fis
    from fuzzy.plugins.designer.starts.catalogue import find_starts
    from fuzzy.shell.progress import Mover, progress_bar

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
        for each in start.described()["options"]:
            print(f"    {each['name']}={_accepted(each)}")


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
