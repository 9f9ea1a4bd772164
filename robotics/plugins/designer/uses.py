"""The place of a rule base: laws that can drive by it, the task that it has there, and scenarios where that shows.

Variables are known by their names: the inputs are quantities of :mod:`robotics.laws.rules.quantities`, and the outputs
tell the task. Where they leave it open, as a turn and a speed do, the inputs tell it, and the name of the system.
"""

import re
from collections.abc import Collection, Mapping
from difflib import get_close_matches
from functools import lru_cache
from typing import Any, NamedTuple

from fuzzy.errors import InputError
from fuzzy.system import Sugeno
from fuzzy.words import listed
from robotics.laws.catalogue import label, make_controller, presets
from robotics.laws.formation import leader_follower
from robotics.laws.law import ControllerError, Law
from robotics.laws.rules import fuzzy_team, own_rules, quantities
from robotics.laws.rules.of_reference import CORRECTIONS
from robotics.laws.rules.quantities import QUANTITY_GROUPS, Quantity, quantity_of
from robotics.laws.specification import Specification
from robotics.laws.tracking.fuzzy_tracking import load_rule_base

_CURVES = ("eta", "theta", "lateral")  # rule bases of one input and one output
_ONE, _TEAM, _BOTH = ("tracking",), ("team",), ("team", "tracking")  # kinds of scenarios
_TASKS = {  # scenarios in which a task shows, and the law that it is compared with
    "tracking": (("crossing-in-turn", "formation-triangle"), "virtual-structure"),
    "cooperation": (("wait-for-one", "ahead-and-behind"), "obstacles"),
    "crash": (("three-cross", "two-meetings"), "right-of-way"),
    "obstacles": (("obstacles-on-two-paths", "trap-u"), "obstacles"),
    "supervisor": (("obstacles-on-two-paths", "three-cross"), "obstacles"),
    "eta": (("three-cross", "two-meetings"), "right-of-way"),
    "theta": (("obstacles-on-two-paths", "trap-u"), "obstacles-literal"),
    "formation": (("formation-behind", "formation-ahead"), "formation-teacher"),
}
_ALONE = (("fuzzy-off-path", "lyapunov-sine"), "lyapunov")  # likewise, of a robot that is alone
_PARKING = (("parking", "come-in"), "polar")
_SUITS = 2.0  # how likely a task is whose inputs are of the kind that it needs


class TryoutError(InputError):
    """A system that cannot drive a robot, or a choice that does not exist. The message says what is needed."""


class Use(NamedTuple):
    """A law in which a system can take the place of a rule base."""

    law: str  # a name of the catalogue
    task: str  # the law's, whose rule base is replaced
    kinds: tuple[str, ...]  # of the scenarios that it drives
    scenarios: tuple[str, ...]  # in which it shows what it does; the first is tried if no other is chosen
    rival: str  # the law that it is compared with if no other is chosen

    @property
    def title(self) -> str:
        """The law and, where it does not go without saying, the task, in words."""
        return label(self.law) + ("" if self.task in ("tracking", "own", "formation") else f": {self.task}")


def law_of(specification: str) -> Law[Any]:
    """The law of a specification; all runs share one that never changes, as that of a file may."""
    return make_controller(specification) if Specification.of(specification).file else _shared_law(specification)


_shared_law = lru_cache(maxsize=64)(make_controller)


def uses_of(fis: Sugeno, file: str = "") -> tuple[Use, ...]:
    """All uses of a system, the most likely first. Raises TryoutError, saying what is wrong, where there is none.

    Args:
        fis: The system.
        file: The name of its file, which may say what its variables leave open.
    """
    inputs, outputs = ({v.name for v in variables} for variables in (fis.inputs, fis.outputs))
    ranked = [*_team_uses(fis, file), *_curve_uses(fis, file)]
    if own_rules.is_tracking(fis):
        parks = {"distance", "heading_err"} <= inputs and "x_err" not in inputs  # it comes to a posture, not to a line
        ranked += [(4.0 if use.law == "fuzzy-park" and parks else 3.0, use) for use in _tracking_uses()]
    elif outputs <= {*own_rules.RULE_OUTPUTS} and not _unknown(fis):
        ranked.append((1.5, _own_use(fis)))
    if outputs <= {*leader_follower.FORMATION_OUTPUTS} and inputs <= {*leader_follower.FORMATION_INPUTS}:
        ranked.append((3.0, Use("formation", "formation", ("formation",), *_TASKS["formation"])))
    if not ranked:
        raise TryoutError(_why_none(fis))
    return tuple(use for _, use in sorted(ranked, key=lambda item: -item[0]))


def _team_uses(fis: Sugeno, file: str) -> list[tuple[float, Use]]:
    """The tasks of the fuzzy team whose outputs it has, each with how likely it is; some suit it, or all may."""
    found: list[tuple[float, Use]] = []
    if _unknown(fis):
        return []
    outputs, known = {v.name for v in fis.outputs}, _quantities(fis)
    for task, possible in fuzzy_team.TEAM_OUTPUTS.items():
        if not outputs <= {*possible}:
            continue
        packaged = {v.name for v in load_rule_base(task).inputs}
        alike = len(packaged & known.keys()) / len(packaged)
        typical = {"crash": any(q.pair for q in known.values()), "obstacles": _feels(known)}.get(task, True)
        likely = 4.0 * _named(task, fis, file) + _SUITS * typical + alike
        found.append((likely, Use("fuzzy-team", task, _BOTH, *_TASKS[task])))
    return [item for item in found if item[0] >= _SUITS] or found


def _curve_uses(fis: Sugeno, file: str) -> list[tuple[float, Use]]:
    """The laws that hold a curve of one input such as η of (6.4)."""
    if len(fis.inputs) != 1 or len(fis.outputs) != 1:
        return []
    found: list[tuple[float, Use]] = []
    for task in _CURVES:
        packaged = load_rule_base(task)
        same = packaged.inputs[0].name == fis.inputs[0].name and packaged.outputs[0].name == fis.outputs[0].name
        if same or _named(task, fis, file):
            for name, kind in _laws(task):
                use = Use(name, task, (kind,), *_TASKS.get(task, _ALONE))
                found.append((5.0 + (name == _USUAL.get(task)), use))
    return found


_USUAL = {"eta": "crash-yielding", "theta": "obstacles", "lateral": "fuzzy-lateral"}


def _tracking_uses() -> list[Use]:
    found = [Use("fuzzy", "tracking", _ONE, *_ALONE), Use("fuzzy-park", "tracking", ("goal",), *_PARKING)]
    for name, kind in _laws("tracking"):
        if kind == "team":
            alone = presets()[name].law is fuzzy_team.FuzzyTeam  # it drives a robot that is alone as well
            kinds = _BOTH if alone else _TEAM
            found.append(Use(name, "tracking", kinds, *_TASKS["tracking"]))
    return found


def _own_use(fis: Sugeno) -> Use:
    known = _quantities(fis)
    if "rate" in {v.name for v in fis.outputs}:
        task = "cooperation"
    elif any(q.radio for q in known.values()):
        task = "crash"
    elif _feels(known):
        task = "obstacles"
    else:
        corrects = CORRECTIONS & {v.name for v in fis.outputs}
        return Use("fuzzy-correcting" if corrects else "fuzzy", "own", (*_BOTH[::-1], "goal"), *_ALONE)
    return Use("fuzzy", "own", (*_BOTH, "goal"), *_TASKS[task])


@lru_cache(maxsize=16)
def _laws(task: str) -> tuple[tuple[str, str], ...]:
    """The names and kinds of the laws that hold a rule base of that task which has an effect."""
    laws = [(name, preset.kind, law_of(name)) for name, preset in presets().items()]
    return tuple((name, kind) for name, kind, law in laws if task in law.tasks and law.tasks[task] not in law.idle)


def _named(task: str, fis: Sugeno, file: str) -> bool:
    return any(task in re.split(r"[\W_]+", name.casefold()) for name in (fis.name, file))


def _quantities(fis: Sugeno) -> dict[str, Quantity]:
    """Its inputs that are quantities."""
    found = {}
    for variable in fis.inputs:
        try:
            found[variable.name] = quantity_of(variable.name, fis.name)
        except ControllerError:
            continue
    return found


def _feels(known: Mapping[str, Quantity]) -> bool:
    """Whether one of the quantities is about the room around the robot."""
    return any(name in QUANTITY_GROUPS["The room around it"] or q.sensor for name, q in known.items())


def _unknown(fis: Sugeno) -> list[str]:
    known = _quantities(fis)
    return [v.name for v in fis.inputs if v.name not in known]


# What is wrong --------------------------------------------------------------------------------------------------


def _why_none(fis: Sugeno) -> str:
    """Why no law takes ``fis``: its variables that nobody knows, each with the names that are nearest."""
    tasks = [name for possible in fuzzy_team.TEAM_OUTPUTS.values() for name in possible]
    outputs = list(dict.fromkeys([*own_rules.RULE_OUTPUTS, *tasks]))
    strange = [v.name for v in fis.outputs if v.name not in outputs]
    known = [*quantities.RULE_QUANTITIES, *quantities.PATTERNS]
    parts = [f"no robot knows the input {_meant(name, known)}" for name in _unknown(fis)[:3]]
    parts += [f"no law takes the output {_meant(name, outputs)}" for name in strange[:3]]
    if not parts:
        parts = [f"no law takes all of its outputs together: {listed(v.name for v in fis.outputs)}"]
    supervisor = listed(fuzzy_team.TEAM_OUTPUTS["supervisor"])
    return (
        f"{fis.name} cannot drive a robot: {'; '.join(parts)}. A law takes the outputs "
        f"{listed(own_rules.RULE_OUTPUTS)}, and the supervisor of a fuzzy team {supervisor}; "
        f"{quantities.QUANTITIES_PAGE} lists all that a robot knows, by these names."
    )


def _meant(name: str, known: Collection[str]) -> str:
    """The name, and those that it is near to."""
    folded = {n.casefold(): n for n in known}
    close = [repr(folded[n]) for n in get_close_matches(name.casefold(), folded, n=3, cutoff=0.55)]
    return f"{name!r}" + (f" (did you mean {listed(close, 'or')}?)" if close else "")
