"""A design to edit, where its unsaved work lies, and random messages for Hypothesis, not all of which make sense."""

from pathlib import Path
from typing import Any

from hypothesis import strategies as st

import fuzzy
from fuzzy.membershipfunction import MATLAB_NAMES
from fuzzy.plugins.designer.design import CHOICES
from fuzzy.plugins.designer.document import Document
from fuzzy.plugins.designer.edits import EDITS
from fuzzy.system import Linear, Sugeno, Variable


def system(name: str = "demo") -> Sugeno:
    """Two inputs, two outputs (one with a linear consequent), three rules."""
    distance = Variable("distance", (0, 2), {"near": fuzzy.trimf(0, 0, 1), "far": fuzzy.trapmf(0.5, 1, 2, 2)}, "m")
    bearing = Variable("bearing", (-3, 3), {"left": fuzzy.linsmf(0, 1), "right": fuzzy.gaussmf(1, -2)}, "rad")
    v = Variable("v", (0, 1), {"slow": 0.1, "fast": Linear((0.25, 0.0), 0.5)}, "m/s")
    w = Variable("w", (-1, 1), {"ccw": 1.0, "cw": -1.0}, "rad/s")
    rules = [
        "if distance is near and bearing is left then v is slow and w is ccw",
        "if distance is far or bearing is not very right then v is fast with 0.5",
        "if bearing is right then w is cw",
    ]
    return Sugeno([distance, bearing], [v, w], rules, name=name)


def near(b: float, **more) -> dict:
    """A message that moves the peak of near."""
    return {"edit": "term", "variable": "distance", "term": "near", "parameters": [0, b, 1], **more}


def peak(document: Document) -> float:
    return document.design.system["distance"].terms["near"].b


def unsaved(file: Path) -> Path:
    return file.parent / ".fuzzy-design" / f"{file.name}.json"


JUNK: Any = st.none() | st.booleans() | st.integers(-3, 12) | st.integers() | st.floats() | st.text(max_size=4)
JUNK = JUNK | st.lists(JUNK, max_size=3) | st.dictionaries(st.text(max_size=3), JUNK, max_size=2)
NAMES = st.sampled_from(
    [
        "distance",
        "bearing",
        "v",
        "w",
        "near",
        "far",
        "left",
        "right",
        "slow",
        "fast",
        "cw",
        "input3",
        "mf3",
        "is not",
        "ü'",
    ]
)
NUMBER = st.sampled_from([0, 1, -1, 0.5, 2, 0.1, 1e-300, 1e99, -1e99, 3.3])
FIELDS: dict[str, Any] = {
    **dict.fromkeys(("variable", "term", "name", "what"), NAMES | st.text(max_size=3)),
    "count": st.integers(1, 12),
    **dict.fromkeys(("parameters", "lower"), st.lists(NUMBER, max_size=5)),
    "type": st.sampled_from([*MATLAB_NAMES, "constant", "linear"]),
    "kind": st.sampled_from(["input", "output"]),
    **dict.fromkeys(("low", "high", "weight", "power"), NUMBER),
    **dict.fromkeys(("scale", "enabled", "negated"), st.booleans()),
    "unit": st.text(max_size=3),
    "value": st.sampled_from([value for values in CHOICES.values() for value in values]),
    **dict.fromkeys(("key", "after", "to"), st.integers(0, 6)),
    "connective": st.sampled_from(["and", "or"]),
    "cells": st.lists(st.tuples(st.dictionaries(NAMES, NAMES, max_size=2), NAMES | st.none()), max_size=4),
    "text": st.sampled_from(
        [
            "if distance is near then v is fast",
            "if bearing is not very left or distance is far then w is cw with 0.25",
            "if distance is near^1.25 then v is fast",
            "distance==near => v=slow (0)",
            "if",
            "",
        ]
    )
    | st.text(max_size=8),
}
NEEDS = {
    "term": "variable term parameters",
    "term_type": "variable term type",
    "term_types": "variable type",
    "spread_terms": "variable count",
    "add_term": "variable",
    "remove_term": "variable term",
    "rename_term": "variable term name",
    "add_variable": "kind",
    "remove_variable": "variable",
    "rename_variable": "variable name",
    "universe": "variable low high scale",
    "unit": "variable unit",
    "choice": "name value",
    "rename": "name",
    "loop": "text what",
    "footprint": "variable term lower",
    "rule_text": "key text",
    "add_rule": "after",
    "copy_rule": "key",
    "remove_rule": "key",
    "move_rule": "key to",
    "rule_weight": "key weight",
    "rule_enabled": "key enabled",
    "rule_clause": "key variable term negated power",
    "rule_then": "key variable term",
    "rule_connective": "key connective",
    "add_all_rules": "",
    "fill_rules": "variable cells",
}


SEVERAL = ("remove_rule", "move_rule", "rule_weight", "rule_enabled", "rule_then")  # take keys for key


TERMS = {"distance": ["near", "far"], "bearing": ["left", "right"], "v": ["slow", "fast"], "w": ["ccw", "cw"]}
OPS = [*EDITS, "term", "term_type", "rename_term", "rename_variable", "universe", "rule_clause", "rule_then"]


@st.composite
def messages(draw: st.DrawFn):
    """Most messages fit the first design, and many what others make of it; some fit nothing."""
    op = draw(st.sampled_from(OPS))
    message: dict[str, Any] = {"edit": op} | {field: draw(FIELDS[field]) for field in NEEDS[op].split()}
    if op in SEVERAL and draw(st.booleans()):
        del message["key"]
        message["keys"] = draw(st.lists(st.integers(0, 6), max_size=3))
    if draw(st.integers(0, 4)):
        if "variable" in message:
            outputs = {"rule_then": ["v", "w"], "fill_rules": ["v", "w"]}
            message["variable"] = draw(st.sampled_from(outputs.get(op, sorted(TERMS))))
            if "term" in message:
                message["term"] = draw(st.sampled_from(TERMS[message["variable"]]))
        if op == "term":
            count = {"near": 3, "far": 4, "left": 2, "right": 2, "fast": 3}.get(message["term"], 1)
            message["parameters"] = sorted(draw(st.lists(NUMBER, min_size=count, max_size=count)))
        if op in ("term_type", "term_types"):
            consequent = ["constant", "linear"]
            kinds = consequent if message["variable"] in ("v", "w") else list(MATLAB_NAMES)
            message["type"] = draw(st.sampled_from(kinds))
        if op == "universe":
            message["low"], message["high"] = draw(st.sampled_from([(0, 1), (-2, 8), (0, 1e99), (0, 1e-300), (-1, 0)]))
        if op == "fill_rules":
            asked = st.fixed_dictionaries(
                {}, optional={name: st.sampled_from(TERMS[name]) for name in ("distance", "bearing")}
            )
            then = st.none() | st.sampled_from(TERMS[message["variable"]])
            message["cells"] = draw(st.lists(st.tuples(asked, then), min_size=1, max_size=5))
        if op == "choice":
            message["name"] = draw(st.sampled_from(list(CHOICES)))
            message["value"] = draw(st.sampled_from(CHOICES[message["name"]]))
        if "power" in message:
            message["power"] = draw(st.sampled_from([0.1, 0.5, 2, 9.9]))
    if draw(st.integers(0, 19)) == 0:
        message[draw(st.sampled_from(["edit", *FIELDS]))] = draw(JUNK)
    if draw(st.integers(0, 19)) == 0:
        message.pop(draw(st.sampled_from(sorted(message))))
    return message
