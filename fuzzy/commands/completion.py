"""Names that a shell completes after Tab: found without what the commands import, so that a key press is quick."""

from collections.abc import Collection, Iterable
from pathlib import Path


def completed(incomplete: str, names: Collection[str], endings: tuple[str, ...] = ()) -> list[str]:
    """The names that begin as the incomplete word does; if one was begun, also files with the endings, and folders.

    Args:
        incomplete: The word so far.
        names: The names that are accepted.
        endings: Endings of files that are accepted as well, such as ``.fis``.
    """
    found = [name for name in names if name.startswith(incomplete)]
    if not endings or (names and not incomplete):
        return found
    folder, slash, start = incomplete.rpartition("/")
    try:
        beside = sorted(Path(folder + slash or ".").iterdir())
    except OSError:
        return found
    for path in beside:
        if path.name.startswith(start) and (start or path.name[0] != "."):
            ends = "/" if path.is_dir() else "" if path.suffix in endings else None
            found += [] if ends is None else [f"{folder}{slash}{path.name}{ends}"]
    return found


def last_of_list(incomplete: str, names: Iterable[str]) -> list[str]:
    """The continuations of a list with commas, ``fuzzy,lyap``: its last word completed."""
    done, comma, word = incomplete.rpartition(",")
    return [f"{done}{comma}{name}" for name in names if name.startswith(word)]


def rule_bases(incomplete: str) -> list[str]:
    """Packaged rule bases, and .fis files."""
    from fuzzy.files.packaged import packaged_fis_files

    return completed(incomplete, packaged_fis_files(), (".fis",))


def examples(incomplete: str) -> list[str]:
    """The examples that come with the package."""
    from fuzzy.files.examples import example_names

    return completed(incomplete, example_names())
