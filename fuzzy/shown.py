"""Numbers as people read them: few digits, no floating dust, no minus zero."""

import math
import re

# Rounding leaves about 1e-16 of the values that were summed; this much of a range is nothing that anybody set.
_DUST = 1e-9
_LARGE = 1e7  # below it, thousands are written out
_NEGATIVE = re.compile(r"(?<![\w.)\]])-(?=[\d.∞])")  # a sign before a number, neither a hyphen nor an exponent's
_DIFFERENCE = re.compile(r"(?<= )-(?= )")
_EXPONENT = re.compile(r"(?<=\de)-(?=\d)")


def shown(value: float, span: float = 0.0, digits: int = 4) -> str:
    """Write ``value`` with few significant digits and a sign that can be copied: "-0.25", "12340", "1e-07", "∞".

    Args:
        value: The number.
        span: The width of the range it belongs to; what is less than 1e-9 of it is shown as 0.
        digits: How many significant digits.

    >>> shown(-8.882e-16, span=20.0), shown(-0.0), shown(0.1 + 0.2)
    ('0', '0', '0.3')
    """
    if math.isnan(value):
        return "not a number"
    if math.isinf(value):
        return "∞" if value > 0 else "-∞"
    if math.isfinite(span) and abs(value) < _DUST * abs(span):
        return "0"
    text = f"{value + 0.0:.{digits}g}"
    return f"{float(text):.0f}" if "e+" in text and abs(value) < _LARGE else text


def typeset(text: str) -> str:
    """``text`` with true minus signs before its numbers, as pages and pictures show it; hyphens stay.

    >>> typeset("min-max of -0.5 in [-1 1]")
    'min-max of −0.5 in [−1 1]'
    """
    return _EXPONENT.sub("−", _DIFFERENCE.sub("−", _NEGATIVE.sub("−", text)))
