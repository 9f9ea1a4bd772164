"""What somebody probably meant who mistyped a name."""

import os
from collections.abc import Callable, Collection, Iterable
from difflib import get_close_matches
from pathlib import Path

from fuzzy.errors import InputError, quoted, shortened

_COMPARED = 1000  # known names, at most, that a mistyped one is compared with: more take seconds
_LISTED = 2000  # characters of the list of known names that a message shows


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """The end of a sentence with the nearest ``known`` name, "" if none is near."""
    folded = {n.casefold(): n for n in known}
    near = list(folded)[:_COMPARED] if len(name) <= _COMPARED else []
    close = get_close_matches(name.casefold(), near, n=1, cutoff=0.5)
    return f"; did you mean {folded[close[0]]!r}?" if close else ""


def expected(name: str, known: Iterable[str], what: str) -> str:
    """Say that ``name`` is not a known ``what``; name the nearest one and all accepted ones.

    >>> expected("fra", ["near", "far"], "term")
    "unknown term 'fra'; did you mean 'far'? Known: near, far"
    """
    names = list(known)
    hint = did_you_mean(name, names) or "."
    return f"unknown {what} {quoted(name)}{hint} Known: {shortened(', '.join(names), _LISTED) if names else '(none)'}"


def file_beside(path: str | os.PathLike[str]) -> str:
    """The hint "; did you mean 'tipper.fis'?" where ``path`` is not there and a file beside it is called nearly so."""
    wanted = Path(path)
    try:
        beside = {} if wanted.exists() else {p.stem: p for p in wanted.parent.iterdir() if p.suffix == wanted.suffix}
    except (OSError, ValueError):  # no folder, or no name of a file
        return ""
    close = get_close_matches(wanted.stem, list(beside)[:_COMPARED], n=1, cutoff=0.6)
    return f"; did you mean {str(beside[close[0]])!r}?" if close else ""


def check_known(
    name: object,
    known: Collection[object],
    what: str,
    error: Callable[[str], InputError] = InputError,
    *keys: str | int,
    where: str = "",
) -> str:
    """Return ``name``; raise an ``error`` about the value under ``keys`` unless it is a ``known`` ``what``.

    Its message is that of :func:`expected`, after ``where`` and a colon if that is given.
    """
    if name not in [*known]:  # which also holds for what cannot be hashed
        text = expected(str(name), map(str, known), what)
        raise error(f"{where}: {text}" if where else text).about(*keys)
    return str(name)
