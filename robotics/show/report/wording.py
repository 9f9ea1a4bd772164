"""Numbers with their intervals in words: what tables, claims and pictures of a report say of them."""

from math import floor, isfinite, log10

from fuzzy.words import counted
from robotics.laws.catalogue import law_title
from robotics.measures.evidence import CLOSE, Estimate, Part
from robotics.measures.statistics.intervals import LEVEL

_FINEST = 6  # decimal places: what is smaller is written with its power of ten
_PREFIXED = ("m", "rad", "m/s", "rad/s")  # units that may take the prefix milli


def shown(estimate: Estimate, unit: str, *, signed: bool = False) -> str:
    """A number with half its interval and its unit, such as "2.1 ± 0.2 mm"; a rate in per cent with its interval.

    Args:
        estimate: The number.
        unit: Its unit, "" or "1" for none; that of a norm of unlike things, such as "m, rad", is left out.
        signed: Whether a plus is written too.
    """
    if estimate.kind == "rate":
        return f"{100 * estimate.value:.0f} % ({100 * estimate.low:.0f} to {100 * estimate.high:.0f})"
    if not isfinite(estimate.value):
        return _infinite(unit) if estimate.value > 0 else "unknown"
    factor, unit = scaled(unit, estimate.value)
    number, half = digits(factor * estimate.value, factor * (estimate.high - estimate.low) / 2)
    text = ("+" if signed and estimate.value > 0 else "") + number + (f" ± {half}" if half else "")
    never = f", {_infinite(unit)} in {estimate.lost} of {estimate.runs}" if estimate.lost else ""
    return text + _after(unit) + never


def digits(value: float, half: float) -> tuple[str, str]:
    """A number and half its interval, which is "" where there is none, or where nothing of it is left to be seen."""
    told = isfinite(half) and half > 1e-6 * abs(value)
    # Two digits of the interval, but no more than four of the number; three where there is no interval.
    places = min(places_of(half, 2), places_of(value, 4)) if told else places_of(value, 3)
    return plain(value, places), plain(half, places) if told and round(half, places) > 0 else ""


def bound_text(value: float, unit: str, kind: str = "mean") -> str:
    """A bound with its unit, such as "10 mm"; that of a rate in per cent."""
    if kind == "rate":
        return f"{100 * value:g} %"
    factor, unit = scaled(unit, value)
    return f"{factor * value:g}{_after(unit)}"


def scaled(unit: str, value: float) -> tuple[float, str]:
    """The factor and the unit with which a number reads most easily: thousandths below a tenth."""
    return (1000.0, f"m{unit}") if unit in _PREFIXED and 0 < abs(value) < 0.1 else (1.0, unit)


def reading(part: Part) -> str:
    """The number that decides a part, beside its bound; of a comparison both sides too."""
    runs = part.estimate.runs
    few = f"only {counted(runs, 'run')}, a verdict needs {part.fewest}" if runs < part.fewest else ""
    close = f"within {100 * CLOSE:g} % of the bound" if part.close else ""
    origin = f"the bound: {part.origin}" if part.origin else ""
    looks = ""
    if part.adjusted is not None and part.adjusted >= 1 - LEVEL and not few:
        looks = f"p = {part.adjusted:.2g}, adjusted for all parts"
    return "; ".join(filter(None, (_reading(part), few, looks, close, origin, part.note)))


def _reading(part: Part) -> str:
    sign = "<" if part.sense == "below" else ">"
    if part.limit is not None:
        (number,), (sense, value) = part.sides, part.limit
        kept = f"{part.kept} of {part.estimate.runs} {'<' if sense == 'below' else '>'} {bound_text(value, part.unit)}"
        low, high = (f"{100 * end:.0f}" for end in (part.estimate.low, part.estimate.high))
        asked = f"({low} to {high} %), asked for > {100 * part.bound:g} %"
        return f"{law_title(part.of)} {shown(number, part.unit)}; {kept} {asked}"
    if not part.against:
        bound = bound_text(part.bound, part.unit, part.estimate.kind)
        return f"{law_title(part.of)} {shown(part.estimate, part.unit)}, asked for {sign} {bound}"
    names = [law_title(name) for name in (part.of, *part.against)]
    sides = ", ".join(f"{n} {shown(e, part.unit)}" for n, e in zip(names, part.sides, strict=True))
    if part.estimate.kind == "rate":
        return f"{sides}; the other way round in {shown(part.estimate, '1')} of the runs, asked for < 50 %"
    to = "" if part.scale == 1 else f" to {100 * part.scale:g} % of it"
    bound = bound_text(part.bound, part.unit).replace("-", "−") if part.bound else "0"
    return f"{sides}; difference{to} {shown(part.estimate, part.unit, signed=True)}, asked for {sign} {bound}"


def sentence(part: Part) -> str:
    """What a part says, what became of it, and the numbers; of a law without forms also where."""
    known = {"holds": "holds", "fails": "fails", "open": "cannot be told"}
    place = "" if part.form else f"{part.on}: "
    return f"{place}{part.says}: {known[part.outcome]} ({reading(part)})"


def _infinite(unit: str) -> str:
    return "never" if unit == "s" else "without bound"


def _after(unit: str) -> str:
    return f" {unit}" if unit not in ("", "1") and "," not in unit else ""


def places_of(value: float, digits: int) -> int:
    """Decimal places, 0 to 6, that show that many significant ``digits`` of ``value``."""
    return 0 if value == 0 else min(max(digits - 1 - floor(log10(abs(value))), 0), _FINEST)


def plain(value: float, places: int) -> str:
    """A number with so many decimal places, and one kind of minus sign; there is no minus zero."""
    text = f"{value:.{places}f}"
    if value and float(text) == 0 and places == _FINEST:
        return f"{value:.0e}".replace("-", "−")
    return text.lstrip("-") if float(text) == 0 else text.replace("-", "−")
