"""The command ``fuzzy design``: the designer in the browser."""

from pathlib import Path
from typing import Annotated

from fuzzy.errors import InputError
from fuzzy.shell.options import argument, option


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
    from fuzzy.designer.folder import open_folder
    from fuzzy.designer.server import serve
    from fuzzy.files.fisfile import read_fis

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
