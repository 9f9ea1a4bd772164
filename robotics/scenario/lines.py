"""On which line of a TOML file a key stands."""

import re

_HEADER = re.compile(r"^\s*(\[\[?)\s*([^\]]+?)\s*\]\]?\s*(#.*)?$")
_KEY = re.compile(r"^\s*([\w\-\".]+)\s*=")


def line_of(text: str, keys: tuple[str | int, ...]) -> int:
    """The line (from 1) where ``keys`` stand in TOML ``text``: the deepest of them that has a line of its own."""
    wanted = [str(k) for k in keys]
    best, best_depth = 1, 0
    prefix: list[str] = []
    counts: dict[str, int] = {}
    for number, line in enumerate(text.splitlines(), start=1):
        header, key = _HEADER.match(line), _KEY.match(line)
        if header:
            names = [n.strip().strip('"') for n in header[2].split(".")]
            if header[1] == "[[":
                counts[header[2]] = counts.get(header[2], -1) + 1
            prefix = [part for n in names for part in ([n, str(counts[n])] if n in counts else [n])]
            here = prefix
        elif key:
            here = prefix + [n.strip('"') for n in key[1].split(".")]
        else:
            continue
        depth = 0
        while depth < min(len(here), len(wanted)) and here[depth] == wanted[depth]:
            depth += 1
        if depth == len(here) and depth > best_depth:
            best, best_depth = number, depth
    return best
