"""A system under design: its rules are the lines of a table, of which some may be switched off or misspelt."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Literal, get_args, get_origin, get_type_hints

from fuzzy.detached import detached
from fuzzy.files.fisfile import FaultyRule, FisFileError, format_fis, parse_rule_line
from fuzzy.language import RuleError, parse_rule
from fuzzy.plugins.type2.reduction import Reduction
from fuzzy.plugins.type2.system import Lower, Type2Sugeno
from fuzzy.rule import Clause, Rule
from fuzzy.system import FuzzySystemError, Sugeno, Variable

# What a system can choose, in the order of its fields: and_method, or_method, defuzzification, ...
CHOICES: dict[str, tuple[str, ...]] = {
    name: get_args(hint) for name, hint in get_type_hints(Sugeno).items() if get_origin(hint) is Literal
}
TYPE_REDUCTION = "type_reduction"  # what a type-2 system can choose besides


@dataclass(frozen=True)
class Mistake:
    """A mistake in a sentence: ``text[start:end]`` is the word at fault (empty where one is missing)."""

    message: str
    start: int  # in characters (code points), from 0
    end: int


@dataclass(frozen=True)
class RuleLine:
    """One line of the rule table."""

    key: int  # stays with the line through edits and moves
    rule: Rule  # the last good rule, with its weight
    text: str  # what stands in the editor: str(rule), or a sentence with a problem
    enabled: bool = True
    problem: Mistake | None = None
    source: str | None = None  # a line of the file that is no rule: the rule is a stand-in, off until one is read here


@dataclass(frozen=True)
class Footprint:
    """What a type-2 system has beside its upper one. A term that is not named is of type 1."""

    lower: Mapping[str, Mapping[str, Lower]]  # by input and term
    reduction: Reduction

    def of(self, upper: Sugeno) -> Type2Sugeno:
        """The type-2 system of ``upper``."""
        return Type2Sugeno(upper, self.lower, self.reduction)


@dataclass(frozen=True)
class Design:
    """A system with its rules as lines, and the point that is looked at. Made by :func:`design_of`.

    ``system.rules`` are the lines' rules, enabled or not, in the lines' order.
    """

    system: Sugeno
    lines: tuple[RuleLine, ...]
    point: tuple[float, ...]  # (inputs,), each in the unit of its variable
    next_key: int = 0  # a key is never given twice in a design's history
    footprint: Footprint | None = None  # of a type-2 system, whose upper one is ``system``
    # What was renamed last, in order, as (which fields of a message, what takes their place): see edits.py
    renamed: tuple[tuple[dict[str, Any], dict[str, Any]], ...] = field(default=(), compare=False)

    @cached_property
    def in_force(self) -> Sugeno:
        """The system with the enabled rules only, which is shown and tried."""
        if all(line.enabled for line in self.lines):
            return self.system
        return replace(self.system, rules=tuple(line.rule for line in self.lines if line.enabled))

    @cached_property
    def shown(self) -> Sugeno | Type2Sugeno:
        """The system in force with its footprint of uncertainty, if it has one."""
        return self.in_force if self.footprint is None else self.footprint.of(self.in_force)

    @cached_property
    def written(self) -> Sugeno:
        """The system as a file holds it: a disabled rule has the weight 0, because MATLAB knows no "off"."""
        if all(line.enabled for line in self.lines):
            return self.system
        rules = (line.rule if line.enabled else replace(line.rule, weight=0.0) for line in self.lines)
        return replace(self.system, rules=tuple(rules))

    def place(self, key: int) -> int:
        """The place, from 0, of the line with that key. Raises FuzzySystemError where there is none."""
        for place, line in enumerate(self.lines):
            if line.key == key:
                return place
        raise FuzzySystemError(f"there is no rule with the key {key}; it may have been removed meanwhile")


def design_of(fis: Sugeno | Type2Sugeno, first_key: int = 0) -> Design:
    """Make a design from ``fis``, looked at in the middle of its inputs.

    A rule of the weight 0 does nothing: it becomes a disabled rule of the weight 1. Parameters that are arrays
    (torch tensors in training, say) become numbers. The lines' keys count from ``first_key``.
    """
    footprint = None if isinstance(fis, Sugeno) else Footprint(fis.lower, fis.reduction)
    fis = detached(fis.upper)
    lines = []
    for key, rule in enumerate(fis.rules, start=first_key):
        enabled = rule.weight > 0
        rule = rule if enabled else replace(rule, weight=1.0)
        lines.append(RuleLine(key, rule, str(rule), enabled))
    return with_lines(Design(fis, (), tuple(v.midrange for v in fis.inputs), footprint=footprint), lines)


def with_lines(design: Design, lines: Iterable[RuleLine]) -> Design:
    """``design`` with other lines; keys that are new are counted."""
    lines = tuple(lines)
    rules = tuple(line.rule for line in lines)
    system = design.system if rules == design.system.rules else replace(design.system, rules=rules)
    next_key = max([design.next_key, *(line.key + 1 for line in lines)])
    return replace(design, system=system, lines=lines, next_key=next_key)


def with_faults(design: Design, faults: Iterable[FaultyRule]) -> Design:
    """``design`` with lines of its file that are no rules, each at its place; they stay as they are until mended."""
    lines = list(design.lines)
    for key, fault in enumerate(faults, design.next_key):
        stand_in = RuleLine(key, _stand_in(design.system.inputs, design.system.outputs), "", False, None, fault.text)
        lines.insert(fault.place, read(design.system, stand_in, fault.text))
    return with_lines(design, lines)


def _stand_in(inputs: Sequence[Variable], outputs: Sequence[Variable]) -> Rule:
    """A rule for a line that is none; no rule of a matrix, which asks for plain terms."""
    when = next((Clause(v.name, term, negated=True) for v in inputs for term in v.terms), None)
    then = next(((v.name, term) for v in outputs for term in v.terms), None)
    if when is None or then is None:
        raise FuzzySystemError("mend or remove the rules that cannot be read first: no terms are left for them")
    return Rule((when,), (then,))


def unread(design: Design) -> str:
    """Why the design cannot be saved: a line of its file that is no rule yet; empty where there is none."""
    numbers = [number for number, line in enumerate(design.lines, 1) if line.source is not None]
    if not numbers:
        return ""
    which = f"rule {numbers[0]} is" if len(numbers) == 1 else f"{len(numbers)} rules, the first rule {numbers[0]}, are"
    it = "it" if len(numbers) == 1 else "them"
    return f"{which} not readable yet; mend or remove {it}, then save. The file stays as it is until then"


def with_disabled(new: Design, old: Design) -> Design:
    """``new`` with the disabled lines of ``old`` whose sentences ``new`` can read.

    They keep their places where ``new`` has as many lines as ``old`` has enabled ones, else they stand at the end.
    """
    beside = sum(line.enabled for line in old.lines) == len(new.lines)
    fresh = iter(new.lines)
    lines: list[RuleLine] = []
    left: list[RuleLine] = []
    for line in old.lines:
        if line.enabled:
            lines += [next(fresh)] if beside else []
            continue
        try:
            if line.source is not None:
                line = replace(line, rule=_stand_in(new.system.inputs, new.system.outputs))
            sentence(new.system, str(line.rule))
        except RuleError:
            continue
        (lines if beside else left).append(line)
    return with_lines(new, [*lines, *fresh, *left])


def with_variables(
    design: Design, inputs: Sequence[Variable], outputs: Sequence[Variable], rules: Sequence[Rule | None] | None = None
) -> Design:
    """A design with other variables. The point keeps the values of the inputs that stay, by name.

    Sentences with a problem are read again, because the names that they want may exist now. If only names change, the
    point also keeps the values of renamed inputs.

    Args:
        design: The design.
        inputs: The inputs.
        outputs: The outputs.
        rules: The rules that take the place of the lines' rules (None: the line goes); by default they stay.
    """
    kept = [line.rule for line in design.lines] if rules is None else list(rules)
    for place, line in enumerate(design.lines):
        if line.source is not None:
            kept[place] = _stand_in(inputs, outputs)
    pairs = [(line, rule) for line, rule in zip(design.lines, kept, strict=True) if rule is not None]
    system = replace(design.system, inputs=tuple(inputs), outputs=tuple(outputs), rules=tuple(r for _, r in pairs))
    lines = []
    for line, rule in pairs:
        lines.append(replace(line, rule=rule, text=line.text if line.problem else str(rule)))
    if any(line.problem for line in lines):
        # What numbers mean in a line of the file is not for a change of terms to say.
        lines = [read(system, line, line.text) if line.problem and line.text != line.source else line for line in lines]
        system = replace(system, rules=tuple(line.rule for line in lines))
    return replace(design, system=system, lines=tuple(lines), point=point_in(system, design))


def point_in(system: Sugeno, before: Design) -> tuple[float, ...]:
    """The point of ``before`` moved to ``system``.

    A value is that of the input of the same name, or of the same place where the inputs are as many, else the middle of
    the universe. It stays as it is while its universe does, and is moved to the edge of one that is another.
    """
    inputs = before.system.inputs
    places = {v.name: i for i, v in enumerate(inputs)}
    point = []
    for i, variable in enumerate(system.inputs):
        old = places.get(variable.name, i if len(inputs) == len(system.inputs) else None)
        value = variable.midrange if old is None else before.point[old]
        if old is None or inputs[old].universe != variable.universe:
            value = min(max(value, variable.universe[0]), variable.universe[1])
        point.append(value)
    return tuple(point)


def read(system: Sugeno, line: RuleLine, text: str) -> RuleLine:
    """A line with another sentence: its rule where it is one, else the old rule and the problem.

    Args:
        system: The system, whose variables and terms the sentence names.
        line: The line.
        text: The sentence; of a line of the file that is no rule also such a line.
    """
    try:
        written = line.source is not None and not text.lstrip().casefold().startswith("if")
        rule = parse_rule_line(text, system) if written else sentence(system, text)
    except FisFileError as error:
        return replace(line, text=text, problem=Mistake(f"{error.reason.partition(chr(10))[0]}{_EITHER}", 0, len(text)))
    except RuleError as error:
        return replace(line, text=text, problem=Mistake(error.reason, error.start, error.end))
    enabled = line.enabled or line.source is not None
    return replace(line, rule=rule, text=str(rule), problem=None, enabled=enabled, source=None)


def sentence(system: Sugeno, text: str) -> Rule:
    """The rule that ``text`` states. Raises RuleError where it states none, or one that a .fis file cannot hold."""
    rule = parse_rule(
        text, {v.name: tuple(v.terms) for v in system.inputs}, {v.name: tuple(v.terms) for v in system.outputs}
    )
    for clause in rule.when:
        if not holds_power(clause.power):
            raise RuleError(POWERS, text, 0, len(text))
    return rule


_EITHER = "; a sentence, if ... then ..., may stand here in the place of the numbers"
POWERS = "a hedge's power must be one of 0.1, 0.2, ... 9.9: a .fis file has no room for others"


def holds_power(power: float) -> bool:
    """Whether a .fis file can hold a hedge of this power: tenths below 10, as Octave writes them."""
    tenths = round(10 * power) if 0 < power < 10 else 0
    return 1 <= tenths <= 99 and tenths / 10 == power


def text_of(design: Design, system: Sugeno) -> str:
    """The text of a .fis file of ``system``, which has the variables of ``design``; raises as :func:`file_text`."""
    return format_fis(system if design.footprint is None else design.footprint.of(system))


def file_text(design: Design) -> str:
    """The text of the .fis file; a disabled rule has the weight 0 there, a line that is no rule is as it was.

    Raises FisFileError where the format cannot hold the system; no edit leads to that.
    """
    text = text_of(design, design.written)
    if not unread(design):
        return text
    lines = text.split("\n")  # the rules are the last ones, before an empty one
    for place, line in enumerate(design.lines, len(lines) - 1 - len(design.lines)):
        lines[place] = lines[place] if line.source is None else line.source
    return "\n".join(lines)
