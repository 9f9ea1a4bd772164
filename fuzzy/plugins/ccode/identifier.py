"""Names of variables, terms and systems as identifiers of C."""

import re
import unicodedata
from collections.abc import Iterable
from pathlib import Path

from fuzzy.compiled.tables import NUMBERS

_FUNCTIONS = tuple(kind.matlab for kind in NUMBERS)
# Keywords of C99 to C23 and C++, what math.h, stdint.h and the code that is written use, and what it calls its own
_WORDS = Path(__file__).with_name("reserved.txt").read_text(encoding="utf-8")
_TAKEN = {*_WORDS.split(), *(f"{log}{name}" for log in ("", "log_") for name in _FUNCTIONS)}


def identifier(text: str, taken: Iterable[str] = ()) -> str:
    """A text as an identifier of C: letters without accents, digits and "_", no keyword, none of those ``taken``.

    >>> identifier("Wheel speed [m/s]")
    'Wheel_speed_m_s'
    >>> identifier("2 far", ["in_2_far"]), identifier("double"), identifier("α")
    ('in_2_far_2', 'double_', 'alpha')
    """
    spelt = "".join(_plain(letter) for letter in text)
    name = re.sub(r"_+", "_", re.sub(r"[^A-Za-z0-9]+", "_", spelt)).strip("_") or "unnamed"
    if name[0].isdigit():
        name = f"in_{name}"
    name = name[:48]
    if name in _TAKEN:
        name += "_"
    others, first, number = set(taken), name, 2
    while name in others:
        name, number = f"{first}_{number}", number + 1
    return name


def identifiers(texts: Iterable[str], taken: Iterable[str] = ()) -> tuple[str, ...]:
    """Texts as identifiers of C, one after the other, of which no two are the same."""
    found: list[str] = []
    for text in texts:
        found.append(identifier(text, [*taken, *found]))
    return tuple(found)


def _plain(letter: str) -> str:
    if letter.isascii():
        return letter
    words = unicodedata.name(letter, "").lower().split()
    if "greek" in words and "letter" in words:
        return words[words.index("letter") + 1]
    return unicodedata.normalize("NFKD", letter).encode("ascii", "ignore").decode() or "_"


def comment(text: str) -> str:
    """A text that may stand in a comment of C, on one line."""
    plain = re.sub(r"\s+", " ", text).replace("\\", "/").replace("??", "? ?")
    return plain.replace("*/", "* /").replace("/*", "/ *")
