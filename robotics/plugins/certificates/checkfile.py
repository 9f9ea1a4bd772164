"""Check a certificate's file: whether its numbers are in range, and by one of two checkers whether it is true."""

# mypy: disable-error-code="no-untyped-def"
import json
import math

import numpy as np

from robotics.plugins.certificates.checker import TERM_PARTS, RefutedError, check_levels
from robotics.plugins.certificates.statechecker import STATES_FORMAT, check_states


def check(data):
    """Raise RefutedError unless a certificate, a file's bytes or what it holds, is true; return what it holds."""
    try:
        data = json.loads(data) if isinstance(data, bytes) else data
        check_loop(data["loop"])
        if data["rules"] is not None:
            check_rules(data["rules"])
        if data["format"] == STATES_FORMAT:
            check_states(data)
        else:
            check_levels(data)
    except (KeyError, IndexError, TypeError, ValueError, AttributeError, ArithmeticError) as error:
        raise RefutedError(f"the certificate cannot be read: {error!r}") from None
    return data


def check_loop(k):
    """Raise RefutedError for numbers of a loop that are out of range."""
    groups, numbers = int(k["groups"]), [n for v in k.values() for n in (v if isinstance(v, list) else [v])]
    past = [*k["last"], *(k[n] for n in ("memory", "forgotten", "prompt", "turning"))]
    signed = {"v_weight", "w_weight", "kx", "ky", "kpsi", "last"}
    for holds, wrong in (
        (np.isfinite(np.array(numbers, float)).all(), "a number of the loop is not finite"),
        (min(v for n, v in k.items() if n not in signed) >= 0, "a number of the loop is below 0"),
        (0 < k["speed_low"] <= k["speed_high"] and 0 < k["period"] <= 0.5, "speeds or period are out of range"),
        (groups > 0 <= min(past) and k["memory"] >= 1 and max(past) <= 1000, "what is remembered is out of range"),
        (abs(1 - math.exp(-k["period"] / max(k["smooth"], 1e-9)) - k["fresh"]) < 1e-9, "fresh is not of this smooth"),
        (all(abs(sum(k[n][:groups]) - 1) <= 1e-12 for n in ("v_weight", "w_weight")), "weights must be 1 in all"),
    ):
        if not holds:
            raise RefutedError(wrong)


# How many numbers a membership function has, and those whose numbers must not fall
_COUNTS = dict.fromkeys(TERM_PARTS, 4) | dict.fromkeys(("linsmf", "linzmf", "smf", "zmf", "gaussmf", "sigmf"), 2)
_COUNTS |= {"trimf": 3, "gbellmf": 3}
_ORDERED = {"linsmf", "linzmf", "trimf", "trapmf"}


def check_rules(rules):
    """Raise RefutedError for a rule base that is none."""
    inputs, found = rules["inputs"], rules["rules"]
    counts, asked = [len(i["terms"]) for i in inputs], [i["quantity"] for i in inputs]
    terms = [term for i in inputs for term in i["terms"]]
    clauses = [clause for rule in found for clause in rule["clauses"]]
    said = [n for rule in found for n in rule["then"] if n is not None]
    for holds, wrong in (
        (rules["and"] in ("prod", "min") and rules["or"] in ("probor", "max"), "'and' or 'or' is not known"),
        (len({*asked}) == len(asked) and all(i["low"] < i["high"] for i in inputs), "an input is wrong"),
        (all(len(n) == _COUNTS[kind] and np.isfinite(n).all() for kind, n in terms), "a term's numbers are wrong"),
        (all(kind not in _ORDERED or [*n] == sorted(n) for kind, n in terms), "a term's numbers fall"),
        (all(0 < n[1] <= 1000 for kind, n in terms if kind == "gbellmf"), "a bell's power is out of range"),
        (all(0 <= rule["weight"] <= 1 for rule in found), "a weight is not in [0, 1]"),
        (all(i >= 0 and 0 <= t < counts[i] and 0 < p < 100 for i, t, p, _ in clauses), "a clause is wrong"),
        (all(isinstance(b, bool) for b in [rules["clip"], *(c[3] for c in clauses)]), "a yes or no is neither"),
        (all(len(rule["then"]) == len(rules["outputs"]) for rule in found), "a rule's outputs are not complete"),
        ({*rules["outputs"]} <= {"dv", "bend", "dw"}, "an output is not known"),
        (all(len(n) == 1 + len(inputs) and np.isfinite(n).all() for n in said), "a consequent is wrong"),
    ):
        if not holds:
            raise RefutedError(wrong)
