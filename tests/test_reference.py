"""The reference is complete: every public name says what it takes, gives and refuses, by rules that can fail.

A *name* is one of a package's ``__all__``, or a public method or property of a public class, inherited ones of our own
classes included. The rules read signatures, annotations and the function's own body:

- every parameter has an entry below ``Args:``; a method's may stand in its text as ````parameter````;
- every field of a dataclass or named tuple has an entry below ``Attributes:``, or a sentence in its metadata;
- a function that returns something has ``Returns:``, or begins with what that is: "The ...", "Whether ...", and
  "Draw ..." for a picture;
- every error of ours that the body raises stands below ``Raises:``, or as "Raises NameOfError";
- where an array is taken, given or held, its shape is named, such as (runs, robots) or (..., inputs);
- a parameter or a field with a name of :data:`PHYSICAL` has a unit, in brackets, in words, or in its metadata.
"""

import ast
import dataclasses
import importlib
import inspect
import re
import textwrap
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from fuzzy.errors import InputError

PACKAGES = ("fuzzy", "anfis", "robotics")
NOUNS = ("A", "All", "An", "Each", "Every", "How", "L", "Sentences", "The", "What", "Whether")  # L: the Laplacian
SHAPE = re.compile(r"\((?:\.\.\.|\w[\w +*]*)(?:, [\w +*.]+)*,?\)|of any shape|any shape")
# Names of what is measured in a unit, and how a unit is said.
PHYSICAL = [
    "dead_time",
    "delay",
    "deviation",
    "divergence",
    "duration",
    "end",
    "error_rate",
    "error_sum",
    "frequencies",
    "gap",
    "heading",
    "latency",
    "length",
    "look_ahead",
    "outage",
    "period",
    "ramp",
    "sample_time",
    "spacing",
    "speed",
    "start",
    "time",
    "times",
    "v",
    "v_max",
    "w",
    "w_max",
    "width",
    "x_rate",
]
UNIT = re.compile(
    r"\[[^\]]*\b(?:m|s|rad|rad/s|m/s|1/s|N m)\b[^\]]*\]|\binches\b|\bunits?\b|\b(?:m/s|rad/s|rad|m|s)\b[:,]|real time"
)
# Members that the rules do not suit, each with the reason.
EXCEPTIONS = {
    "grid": "a class's table of a grid's parameters, a lambda in its field",
    "log_formula": "a class's formula in its field, which its docstring prints",
}


class Told(NamedTuple):
    """A name, what it is, and what is said of it."""

    name: str
    thing: Any
    doc: str


def ours(thing: Any) -> bool:
    return (getattr(thing, "__module__", None) or "").partition(".")[0] in PACKAGES


def names() -> Iterator[Told]:
    seen = set()
    for package in PACKAGES:
        module = importlib.import_module(package)
        for name in module.__all__:
            thing = getattr(module, name)
            if not (inspect.isclass(thing) or inspect.isroutine(thing)) or thing in seen:
                continue
            seen.add(thing)
            yield Told(f"{package}.{name}", thing, inspect.getdoc(thing) or "")
            if inspect.isclass(thing):
                yield from members(f"{package}.{name}", thing)


def members(name: str, kind: type) -> Iterator[Told]:
    for each in dir(kind):
        if each.startswith("_"):
            continue
        home = next((c for c in kind.__mro__ if each in vars(c)), None)
        thing = inspect.getattr_static(kind, each)
        thing = getattr(thing, "__func__", thing)
        if not (home and ours(home) and (inspect.isfunction(thing) or isinstance(thing, property))):
            continue
        if ours(thing.fget if isinstance(thing, property) else thing):
            yield Told(f"{name}.{each}", thing, inspect.getdoc(getattr(kind, each)) or "")


def section(doc: str, *titles: str) -> str:
    """The text of a section; empty where there is none."""
    found = re.search(rf"^(?:{'|'.join(titles)}):\n((?:    .*\n?|\n(?=    ))*)", doc, re.MULTILINE)
    return found[1] if found else ""


def entries(doc: str, *titles: str) -> set[str]:
    return set(re.findall(r"^    \*{0,2}(\w+): \S", section(doc, *titles), re.MULTILINE))


def parameters(thing: Any) -> list[inspect.Parameter]:
    if isinstance(thing, property):
        return []
    return [
        p
        for p in inspect.signature(thing).parameters.values()
        if p.name not in ("self", "cls") and not p.name.startswith("_")
    ]


def fields(kind: type) -> dict[str, Any]:
    """The public fields of a dataclass or of a named tuple, with their metadata."""
    if dataclasses.is_dataclass(kind):
        return {f.name: f.metadata for f in dataclasses.fields(kind) if not f.name.startswith("_")}
    return {name: {} for name in getattr(kind, "_fields", ())}


def body(thing: Any) -> ast.AST:
    function = inspect.unwrap(thing.fget if isinstance(thing, property) else thing)
    made = function.__code__.co_filename.startswith("<")  # by dataclass, without a text of its own
    return ast.parse("" if made else textwrap.dedent(inspect.getsource(function)))


def raised(thing: Any) -> set[str]:
    """The errors of ours that the body itself raises, in the words of its module."""
    function = inspect.unwrap(thing.fget if isinstance(thing, property) else thing)
    found = set()
    for node in ast.walk(body(thing)):
        if isinstance(node, ast.Raise) and node.exc is not None:
            for name in (n.id for n in ast.walk(node.exc) if isinstance(n, ast.Name)):
                error = function.__globals__.get(name)
                if inspect.isclass(error) and issubclass(error, InputError):
                    found.add(name)
    return found


def gives(thing: Any) -> str:
    function = thing.fget if isinstance(thing, property) else thing
    return str(inspect.signature(function).return_annotation)


def missing_parameters(told: Told) -> list[str]:
    thing, doc = told.thing, told.doc
    if inspect.isclass(thing):
        described = entries(doc, "Args", "Attributes")
        held = fields(thing)
        if held:
            return [n for n, m in held.items() if n not in described and not (m.get("doc") or m.get("words"))]
        if issubclass(thing, BaseException) or "__init__" not in vars(thing):
            return []
        return [p.name for p in parameters(thing) if p.name not in described]
    described = entries(doc, "Args")
    if told.name.count(".") > 1:  # a method
        described |= set(re.findall(r"``(\w+)``", doc))
    return [p.name for p in parameters(thing) if p.name not in described]


def silent_of_what_it_returns(told: Told) -> bool:
    if not inspect.isroutine(told.thing) or gives(told.thing) in ("None", "<class 'inspect._empty'>"):
        return False
    if "Figure" in gives(told.thing) and told.doc.startswith("Draw "):
        return False
    return not section(told.doc, "Returns") and told.doc.split(" ")[0].rstrip(",") not in NOUNS


def missing_errors(told: Told) -> list[str]:
    doc, thing = told.doc, told.thing
    if inspect.isclass(thing):
        makers = [vars(thing)[m] for m in ("__init__", "__post_init__") if inspect.isfunction(vars(thing).get(m))]
        found = {name for maker in makers if ours(maker) for name in raised(maker)}
        found = set() if issubclass(thing, BaseException) else found
    else:
        found = raised(thing)
    said = entries(doc, "Raises") | set(re.findall(r"[Rr]aises? (\w+Error)", doc))
    return sorted(found - said)


def shapeless(told: Told) -> list[str]:
    """The arrays of a signature, and of fields, that have no shape."""
    doc, thing, found = told.doc, told.thing, []
    if inspect.isclass(thing):
        lines = dict(re.findall(r"^    (\w+): ((?:.*\n?)(?:        .*\n?)*)", section(doc, "Attributes", "Args"), re.M))
        held = {n: str(t) for n, t in inspect.get_annotations(thing).items() if n in fields(thing)}
        return [
            n for n, t in held.items() if re.search(r"ndarray|Tensor|Array\b", t) and not SHAPE.search(lines.get(n, ""))
        ]
    if re.search(r"ndarray|Tensor", gives(thing)) and not SHAPE.search(doc):
        found.append("what it returns")
    lines = dict(re.findall(r"^    (\w+): ((?:.*\n?)(?:        .*\n?)*)", section(doc, "Args"), re.MULTILINE))
    for p in parameters(thing):
        if re.search(r"ndarray|Tensor", str(p.annotation)) and not SHAPE.search(lines.get(p.name, doc)):
            found.append(p.name)
    return found


def unitless(told: Told) -> list[str]:
    """The physical parameters and fields of numbers that have no unit."""
    doc, thing = told.doc, told.thing
    lines = dict(
        re.findall(r"^    (\w+): ((?:.*\n?)(?:        .*\n?)*)", section(doc, "Attributes", "Args"), re.MULTILINE)
    )
    if inspect.isclass(thing):
        asked = [n for n, m in fields(thing).items() if not (m.get("doc") or m.get("unit") or m.get("words"))]
    else:  # a start may be a system as well as a time
        numbers = [p for p in parameters(thing) if not re.search(r"Sugeno|Callable", str(p.annotation))]
        asked = [p.name for p in numbers]
    return [n for n in asked if n in PHYSICAL and not UNIT.search(lines.get(n, doc))]


def complaints(told_of: Iterator[Told]) -> Iterator[str]:
    for told in told_of:
        if told.name.count(".") > 1 and told.name.rpartition(".")[2] in EXCEPTIONS:
            continue
        if len(told.doc) <= 10:
            yield f"{told.name}: says nothing"
        if missing := missing_parameters(told):
            yield f"{told.name}: what is {', '.join(missing)}?"
        if silent_of_what_it_returns(told):
            yield f"{told.name}: what does it return?"
        if missing := missing_errors(told):
            yield f"{told.name}: does not say that it raises {', '.join(missing)}"
        if missing := shapeless(told):
            yield f"{told.name}: what shape has {', '.join(missing)}?"
        if missing := unitless(told):
            yield f"{told.name}: what unit has {', '.join(missing)}?"


def test_every_public_name_says_what_it_takes_gives_and_refuses():
    assert list(complaints(names())) == []


def mute(x: np.ndarray, scale: float, speed: float) -> np.ndarray:
    """Multiply the ``x``.

    Args:
        x: What is multiplied.
        speed: How fast.
    """
    if scale == 0:
        raise InputError("scale must not be 0")
    return x * scale * speed


@dataclasses.dataclass(frozen=True)
class Mute:
    """A pair.

    Attributes:
        values: Its numbers.
    """

    values: np.ndarray
    unit: str

    def at(self, place: int) -> float:
        """Look up a number."""
        return float(self.values[place])


def test_the_rules_can_fail():
    told = [Told("fuzzy.mute", mute, inspect.getdoc(mute) or ""), Told("fuzzy.Mute", Mute, inspect.getdoc(Mute) or "")]
    told.append(Told("fuzzy.Mute.at", Mute.at, inspect.getdoc(Mute.at) or ""))
    assert list(complaints(iter(told))) == [
        "fuzzy.mute: what is scale?",
        "fuzzy.mute: what does it return?",
        "fuzzy.mute: does not say that it raises InputError",
        "fuzzy.mute: what shape has what it returns, x?",
        "fuzzy.mute: what unit has speed?",
        "fuzzy.Mute: what is unit?",
        "fuzzy.Mute: what shape has values?",
        "fuzzy.Mute.at: what is place?",
        "fuzzy.Mute.at: what does it return?",
    ]
