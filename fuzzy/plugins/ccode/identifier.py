"""Names of variables, terms and systems as identifiers of C."""

import re
import unicodedata
from collections.abc import Iterable

from fuzzy.compiled.tables import NUMBERS

_FUNCTIONS = tuple(kind.matlab for kind in NUMBERS)
# Keywords of C99 to C23 and C++, and what math.h, stdint.h and the code that is written use.
_WORDS = (
    "alignas alignof asm auto bool break case catch char class const constexpr continue default delete do double "
    "else enum explicit export extern false float for friend goto if inline int long mutable namespace new nullptr "
    "operator private protected public register restrict return short signed sizeof static static_assert struct "
    "switch template this thread_local throw true try typedef typename typeof union unsigned using virtual void "
    "volatile wchar_t while and or not xor bitand bitor compl main errno "
    "acos asin atan ceil cos cosh erf exp fabs floor fma fmax fmin fmod gamma hypot isfinite isinf isnan j0 j1 jn "
    "ldexp log log10 log1p log2 modf nan pow remainder round scalb signbit sin sinh sqrt tan tanh trunc y0 y1 yn "
    "INFINITY NAN NULL ONE NEVER int8_t int16_t int32_t int64_t uint8_t uint16_t uint32_t uint64_t strength_t "
    # what the code calls its own
    "x y w r k p top total told unknown degree strength value clause halvings fires fewest fired said proposal "
    "behind share whole either one other rule_end rule_or clause_term clause_power clause_negated weight_of "
    "least most both limited rise hedged shifted line times spline exponential gauss log_gauss logarithm "
    "log_sigmoid sigmoid bell difference root strength_of"
)
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
