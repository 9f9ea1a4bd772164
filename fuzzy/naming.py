"""What somebody probably meant who mistyped a name."""

from collections.abc import Iterable
from difflib import get_close_matches


def expected(name: str, known: Iterable[str], what: str) -> str:
    """Say that ``name`` is not a known ``what``; name the nearest one and all accepted ones.

    >>> expected("fra", ["near", "far"], "term")
    "unknown term 'fra'; did you mean 'far'? Known: near, far"
    """
    names = list(known)
    folded = {n.casefold(): n for n in names}
    close = get_close_matches(name.casefold(), folded, n=1, cutoff=0.5)
    hint = f"; did you mean {folded[close[0]]!r}?" if close else "."
    return f"unknown {what} {name!r}{hint} Known: {', '.join(names) if names else '(none)'}"
