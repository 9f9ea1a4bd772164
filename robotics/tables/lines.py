"""The line of a TOML file on which a key stands."""

import re

_HEADER = re.compile(r"^\s*(\[\[?)\s*([^\]]+?)\s*\]\]?\s*(#.*)?$")
_KEY = re.compile(r"""^\s*((?:[\w\-.\s]|"[^"]*"|'[^']*')+?)\s*=""")


def line_of(text: str, keys: tuple[str | int, ...]) -> int:
    """The line (from 1) where ``keys`` stand in TOML ``text``: the deepest of them that has a line of its own."""
    wanted = _names(".".join(map(str, keys)))
    best, best_depth = 1, 0
    prefix: list[str] = []
    counts: dict[tuple[str, ...], int] = {}  # of tables [[...]], by their names
    for number, line in enumerate(text.splitlines(), start=1):
        header, key = _HEADER.match(line), _KEY.match(line)
        if header:
            names = _names(header[2])
            prefix = []
            for n, name in enumerate(names, start=1):
                prefix.append(name)
                if n == len(names) and header[1] == "[[":
                    counts[tuple(prefix)] = counts.get(tuple(prefix), -1) + 1
                if tuple(prefix) in counts:
                    prefix.append(str(counts[tuple(prefix)]))
            here = prefix
        elif key:
            here = prefix + _names(key[1])
        else:
            continue
        depth = 0
        while depth < min(len(here), len(wanted)) and here[depth] == wanted[depth]:
            depth += 1
        if depth == len(here) and depth > best_depth:
            best, best_depth = number, depth
    return best


def _names(dotted: str) -> list[str]:
    """The parts of a dotted key; one in quotes, which may have dots itself, is taken apart likewise."""
    return [name.strip().strip("\"'") for name in dotted.split(".")] if dotted else []
