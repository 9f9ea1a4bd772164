"""The commands, and whether the packages are ours: other distributions install fuzzy, anfis and robotics, too.

pip lets the one that comes last overwrite the other's files without a word, and to uninstall one deletes them. This
module is in none of the three, so that it is there when they are somebody's.
"""

import re
import sys
from collections.abc import Iterator
from importlib.machinery import PathFinder
from os import listdir
from os.path import dirname, exists, join, realpath

PACKAGES = ("fuzzy", "anfis", "robotics")  # each imports those before it
_HERE = dirname(__file__)  # noqa: PTH120 - pathlib takes longer to import than all of this
_MARK = b"import _fuzzyfleet"  # which stands in each of our __init__.py
# What takes the place of a package, among the files that a distribution installed
_TAKES = rf"(?m)^(?:\.\./)*(({'|'.join(PACKAGES)})(?:/__init__\.py|\.py|(?:\.[\w-]+)?\.(?:so|pyd)))(?=,|$)"
_LISTS = ("RECORD", "installed-files.txt")  # of a wheel, and of installers before there were wheels
_STRANGERS = tuple(f"{name}-" for name in PACKAGES)  # how their descriptions begin, such as anfis-0.3.1.dist-info
_AGAIN = "pip install --force-reinstall fuzzyfleet --no-deps"
_checked = False


def check() -> None:
    """Warn, once in a process, of what stands in the way of a package, or can delete it.

    Raises:
        ImportError: fuzzy is not ours, without which nothing runs.
    """
    global _checked
    if _checked:
        return
    missing, found = _looked()
    for package, sentence in found:
        if package == "fuzzy" and "fuzzy" in missing:
            raise ImportError(sentence)
        import warnings

        warnings.warn(sentence, stacklevel=3)
    _checked = True


def troubles() -> list[tuple[str, str]]:
    """The packages in whose way something stands, or that it can delete, each with a sentence: what, and what mends it.

    All that is installed is read, be it of a distribution that nobody has heard of.
    """
    return _looked(thorough=True)[1]


def anfis() -> int:
    """The command ``anfis``."""
    return _run("anfis")


def fuzzy() -> int:
    """The command ``fuzzy``."""
    return _run("fuzzy")


def robotics() -> int:
    """The command ``robotics``."""
    return _run("robotics")


def _run(program: str) -> int:
    """Run a command, or say why it cannot run: its package may be somebody's, whose code says nothing of it."""
    global _checked
    missing, found = _looked()
    for _, sentence in found:
        print(f"{program}: {sentence}", file=sys.stderr)
    if missing & {*PACKAGES[: PACKAGES.index(program) + 1]}:
        return 2
    _checked = True
    from importlib import import_module

    code: int = import_module(f"{program}.commands.application").main()
    return code


def _looked(thorough: bool = False) -> tuple[set[str], list[tuple[str, str]]]:
    """The packages that are not ours, and what is wrong; what is installed is read only where something is."""
    places = {name: _place(name) for name in PACKAGES}
    missing = {name for name, (_, ours) in places.items() if not ours}
    if not (missing or thorough or _known_strangers()):
        return missing, []
    found = []
    for title, folder, file, name in _takers():
        place, ours = places[name]
        beside = realpath(folder) == realpath(_HERE)
        remove = f"pip uninstall {title.partition(' ')[0]}"
        if not ours and realpath(join(folder, file)) == realpath(place):  # noqa: PTH118
            how, mend = f"hides the package {name} of fuzzyfleet by {place}", remove
            if beside and file.endswith("/__init__.py"):
                how, mend = f"has overwritten {file} of fuzzyfleet", f"{remove}; {_AGAIN}"
        elif ours and beside and file.endswith("/__init__.py"):
            how, mend = f"counts {file} of fuzzyfleet among its files and would delete it", f"{remove}; {_AGAIN}"
        elif ours and beside:
            how, mend = f"installs {file}, which the package {name} of fuzzyfleet hides", remove
        else:
            continue
        found.append((name, f"the distribution {title} {how}: {mend}"))
    for name in PACKAGES:
        if name in missing - {package for package, _ in found}:
            found.append((name, _without_taker(name, places[name][0])))
    return missing, found


def _without_taker(name: str, file: str) -> str:
    if not exists(file):  # noqa: PTH110
        return f"{file} of fuzzyfleet is missing: {_AGAIN}"
    ending = "" if name == "fuzzy" else " if something needs that package"
    return f"{file} stands in the way of the package {name} of fuzzyfleet: rename it{ending}"


def _place(name: str) -> tuple[str, bool]:
    """The file that a package comes from, and whether it is ours; one that is not there stands in nobody's way."""
    spec = getattr(sys.modules.get(name), "__spec__", None) or PathFinder.find_spec(name)
    if spec is None:
        return "", True
    if spec.origin is None:  # a folder without __init__.py, such as ours after a stranger was uninstalled
        folders = [*(spec.submodule_search_locations or ())]
        file = join(_HERE, name, "__init__.py")  # noqa: PTH118
        return file, join(_HERE, name) not in folders  # noqa: PTH118
    read = getattr(spec.loader, "get_data", None)
    return spec.origin, read is not None and _MARK in read(spec.origin)


def _known_strangers() -> bool:
    """Whether a distribution of the name of a package has been installed here."""
    return any(entry.lower().startswith(_STRANGERS) for entry in (listdir(_HERE) if exists(_HERE) else ()))  # noqa: PTH110, PTH208


def _takers() -> Iterator[tuple[str, str, str, str]]:
    """Of other distributions the name and version, the folder, and a file that takes the place of a package."""
    from importlib.metadata import distributions

    for distribution in distributions():
        files = next(filter(None, map(distribution.read_text, _LISTS)), "")
        for file, name in re.findall(_TAKES, files):
            if distribution.name.lower() != "fuzzyfleet":
                yield f"{distribution.name} {distribution.version}", str(distribution.locate_file("")), file, name
