"""The line of a TOML file on which a key stands."""

import re

_HEADER = re.compile(r"^\s*(\[\[?)\s*([^\]]+?)\s*\]\]?\s*(#.*)?$")
_KEY = re.compile(r"^\s*([\w\-\".]+)\s*=")


def line_of(text: str, keys: tuple[str | int, ...]) -> int:
    """The line (from 1) where ``keys`` stand in TOML ``text``: the deepest of them that has a line of its own."""
    wanted = [str(k) for k in keys]
    best, best_depth = 1, 0
    prefix: list[str] = []
    counts: dict[tuple[str, ...], int] = {}  # of tables [[...]], by their names
    for number, line in enumerate(text.splitlines(), start=1):
        header, key = _HEADER.match(line), _KEY.match(line)
        if header:
            names = [n.strip().strip('"') for n in header[2].split(".")]
            prefix = []
            for n, name in enumerate(names, start=1):
                prefix.append(name)
                if n == len(names) and header[1] == "[[":
                    counts[tuple(prefix)] = counts.get(tuple(prefix), -1) + 1
                if tuple(prefix) in counts:
                    prefix.append(str(counts[tuple(prefix)]))
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
