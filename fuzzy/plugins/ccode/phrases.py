"""Phrases of C that systems in every type of numbers share, and laws too."""

import re
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np

from fuzzy.plugins.ccode.identifier import comment
from fuzzy.plugins.ccode.plan import CodePlan

if TYPE_CHECKING:
    from jinja2 import Environment

_COMMENT = re.compile(r"/\*.*?\*/", re.DOTALL)
_DEFINED = re.compile(r"^#define (\w+)|^} (\w+);|^static [\w ]*?(\w+)\(", re.MULTILINE)  # a macro, a type, a function


def called(file: str, code: str) -> str:
    """The functions of a ``file`` of C beside this module that ``code`` calls, with all that these call."""
    code, parts = _COMMENT.sub("", code), list[str]()
    for part, uses in reversed(_parts(file)):
        if uses.search(code):
            code += _COMMENT.sub("", part)
            parts.insert(0, part + "\n")
    return "".join(parts)


@cache
def _parts(file: str) -> list[tuple[str, re.Pattern[str]]]:
    """The parts of a file of C that define something, each with what finds a use of it."""
    found = []
    for part in Path(__file__).with_name(file).read_text(encoding="utf-8").removesuffix("\n").split("\n\n\n"):
        # A variable may have a function's name: only calls count.
        uses = [rf"{name}\(" if name else rf"{macro or kind}\b" for macro, kind, name in _DEFINED.findall(part)]
        if uses:
            found.append((part, re.compile(rf"\b(?:{'|'.join(uses)})")))
    return found


def filled(file: Path, **words: str) -> str:
    """The text of a ``file`` of C, with what stands for its ``words``."""
    return re.sub("|".join(words), lambda found: words[found[0]], file.read_text(encoding="utf-8"))


def rendered(template: str, plan: CodePlan, **values: Any) -> str:
    """The text of C that a ``template`` beside this module makes of a system and of what else it names."""
    about = {"plan": plan, "fis": plan.fis, "n": plan.rules, "upper": plan.name.upper(), "comment": comment}
    about |= {"clips": plan.fis.out_of_range == "clip", "multiplies": plan.fis.and_method == "prod"}
    about |= {"either": "both" if plan.fis.or_method == "probor" else "most"}
    return _environment().get_template(template).render(**about, **values)


@cache
def _environment() -> "Environment":
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    return Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        variable_start_string="${",
        variable_end_string="}",
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        undefined=StrictUndefined,
    )


def signature(name: str, real: str) -> str:
    """The head of the function that evaluates the system ``name``."""
    upper = name.upper()
    return f"int {name}_infer(const {real} x[{upper}_INPUTS], {real} y[{upper}_OUTPUTS])"


def limited_to(value: str, low: object, high: object) -> str:
    """A value within a range, as an expression."""
    return f"{value} < {low} ? {low} : ({value} > {high} ? {high} : {value})"


def whole(count: int) -> str:
    """The smallest type that numbers the things of which there are ``count``."""
    return "unsigned char" if count < 256 else "unsigned short" if count < 65536 else "int"


def table(kind: str, name: str, values: Sequence[object]) -> str:
    """A constant table of the type ``kind``."""
    rows = fill(
        ", ".join(map(str, values)), 116, initial_indent="    ", subsequent_indent="    ", break_on_hyphens=False
    )
    return f"static const {kind} {name}[{len(values)}] = {{\n{rows}\n}};"


def rule_tables(
    plan: CodePlan, real: str, powers: Sequence[object], weights: Sequence[object], truth: str
) -> list[str]:
    """The rules' sentences, and tables of their clauses, one after the other, and of where those of each rule end.

    Args:
        plan: The system.
        real: The type of powers and weights.
        powers: Of each clause, as C writes them.
        weights: Of each rule, as C writes them.
        truth: The type of what is 0 or 1.
    """
    rows = ["/* The rules:", *(f" * {r + 1}: {comment(str(rule))}" for r, rule in enumerate(plan.fis.rules))]
    rows[-1] += " */"
    rows.append(table(whole(len(plan.all_clauses)), "rule_end", np.cumsum([len(r) for r in plan.clauses]).tolist()))
    rows.append(table(whole(len(plan.terms)), "clause_term", [c.term for c in plan.all_clauses]))
    if plan.has_powers:
        rows.append(table(real, "clause_power", powers))
    if plan.has_negations:
        rows.append(table(truth, "clause_negated", [int(c.negated) for c in plan.all_clauses]))
    if plan.has_ors:
        rows.append(table(truth, "rule_or", plan.fis.structure.is_or.astype(int).tolist()))
    if plan.is_weighted:
        rows.append(table(real, "weight_of", weights))
    return rows
