"""A law with another rule base in the place of one of its own, without a file."""

from collections.abc import Mapping
from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fuzzy.compiled.sugeno import CompiledSugeno
from fuzzy.files.fisfile import write_fis
from fuzzy.system import Constant, Sugeno
from robotics.laws.catalogue import make_controller, presets
from robotics.laws.formation.leader_follower import load_networks
from robotics.laws.law import ControllerError, Law
from robotics.laws.rules.own_rules import OwnRules, is_tracking
from robotics.laws.tracking.fuzzy_tracking import load_rule_base
from robotics.simulation.loop import simulate
from robotics.simulation.scenario.reading import load_scenario


def other(name: str) -> Sugeno:
    """The package's rule base of that name with another number in the first term of its last output."""
    fis = load_rule_base(name)
    last = fis.outputs[-1]
    label, old = next(iter(last.terms.items()))
    changed = replace(last, terms={**last.terms, label: Constant(old.parameters[-1] * 0.5 + 0.05)})
    return replace(fis, name=f"other-{name}", outputs=(*fis.outputs[:-1], changed))


def held(part: Any) -> list[Sugeno]:
    """Every system that a law evaluates, wherever it holds it."""
    if isinstance(part, CompiledSugeno):
        return [part.fis]
    if isinstance(part, Mapping):
        return [fis for value in part.values() for fis in held(value)]
    if is_dataclass(part) and not isinstance(part, Sugeno):
        return [fis for f in fields(part) for fis in held(getattr(part, f.name))]
    return []


@pytest.mark.parametrize(
    ("name", "task", "gain"),
    [
        ("fuzzy", "tracking", "rule_base"),
        ("fuzzy-lateral", "lateral", "lateral_rule_base"),
        ("cooperation", "tracking", "rule_base"),
        ("crash-yielding", "eta", "eta_rule_base"),
        ("crash-yielding", "tracking", "rule_base"),
        ("obstacles", "theta", "theta_rule_base"),
        ("obstacles", "tracking", "rule_base"),
        ("fuzzy-team", "tracking", "tracking_rule_base"),
        *(("fuzzy-team", task, f"{task}_rule_base") for task in ("cooperation", "crash", "obstacles", "supervisor")),
    ],
)
def test_one_rule_base_is_replaced_as_by_a_file_and_the_law_itself_stays(name: str, task: str, gain: str) -> None:
    law: Law[Any] = make_controller(name)
    packaged, mine = load_rule_base(task), other(task)
    driven = law.with_fuzzy_system(task, mine)
    assert getattr(driven, gain) is mine
    # What a law makes of a rule base for itself, such as clipped inputs, it makes of this one
    names = [fis.name for fis in held(driven)]
    assert names == [mine.name if fis.name == packaged.name else fis.name for fis in held(law)]
    assert mine.name in names
    assert all(fis.outputs == mine.outputs for fis in held(driven) if fis.name == mine.name)
    assert held(law) == held(make_controller(name))


def test_it_drives_as_the_file_would(tmp_path: Path) -> None:
    write_fis(other("crash"), tmp_path / "mine.fis")
    setting = replace(load_scenario("three-cross"), duration=0.5)
    direct = simulate(setting, make_controller(f"fuzzy-team:crash_rule_base={tmp_path / 'mine.fis'}"))
    driven = simulate(setting, make_controller("fuzzy-team").with_fuzzy_system("crash", other("crash")))
    np.testing.assert_array_equal(driven.samples, direct.samples)


def test_a_network_of_a_formation_replaces_those_of_its_outputs() -> None:
    law: Law[Any] = make_controller("formation")
    networks = {fis.outputs[0].name: fis for fis in load_networks("formation")}
    thesis = next(fis for fis in load_networks("thesis") if fis.outputs[0].name == "v_l")
    driven: Any = law.with_fuzzy_system("formation", thesis)
    held = {system.fis.outputs[0].name: system.fis for system in driven.systems}
    assert held == networks | {"v_l": thesis}


def test_a_task_or_a_system_that_does_not_suit_is_refused() -> None:
    team: Law[Any] = make_controller("fuzzy-team")
    with pytest.raises(ControllerError, match="unknown task of a rule base in FuzzyTeam 'crsh'; did you mean 'crash'"):
        team.with_fuzzy_system("crsh", other("crash"))
    with pytest.raises(ControllerError, match="other-tracking: unknown output of crash 'v'"):
        team.with_fuzzy_system("crash", other("tracking"))
    with pytest.raises(ControllerError, match="task of a rule base in Lyapunov"):
        make_controller("lyapunov").with_fuzzy_system("tracking", other("tracking"))
    with pytest.raises(ControllerError, match="other-crash: unknown formation input 'gap'"):
        make_controller("formation").with_fuzzy_system("formation", other("crash"))


def test_every_task_names_a_gain() -> None:
    for name in presets():
        law = make_controller(name)
        assert all(hasattr(law, gain) for gain in law.tasks.values()), name
        # λ beneath crash avoidance is the package's; it is replaced in the law "fuzzy-lateral"
        # The networks of a formation have one task together
        assert "formation" in law.tasks or {*law.fuzzy_systems} - {"lateral"} <= {*law.tasks}, name


def test_what_a_rule_base_of_a_task_does_not_say_is_neutral() -> None:
    crash = load_rule_base("crash")
    turns = [replace(rule, then=tuple(c for c in rule.then if c[0] == "turn")) for rule in crash.rules]
    only = replace(crash, outputs=crash.outputs[:1], rules=[rule for rule in turns if rule.then])
    run = simulate(
        replace(load_scenario("three-cross"), duration=1.0),
        make_controller("fuzzy-team").with_fuzzy_system("crash", only),
    )
    assert not run.diverged.any()


def test_v_and_w_are_taken_by_name() -> None:
    """In another order, or without one of the two, a rule base of tracking's inputs is one of one's own."""
    fis = load_rule_base("tracking")
    v, w = fis.outputs
    assert is_tracking(fis)
    swapped = replace(fis, outputs=(w, v))
    faster = replace(
        fis, outputs=(v,), rules=[replace(r, then=tuple(c for c in r.then if c[0] == "v")) for r in fis.rules]
    )
    short = replace(load_scenario("fuzzy-off-path"), duration=2.0)
    runs = []
    for other_fis in (swapped, faster):
        law = OwnRules(rule_base=other_fis)
        assert law.own is not None
        runs.append(simulate(short, law)["v"])
    direct = simulate(short, make_controller("fuzzy:steering_distance=0"))["v"]
    np.testing.assert_allclose(runs[0], direct, atol=0.02)
    assert np.nanmax(runs[1]) > 0.1


ARRAYS = """
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any
from robotics import Command, Law

@dataclass(frozen=True, kw_only=True)
class Own(Law[None]):
    rule_base: Any = "tracking"
    tasks = MappingProxyType({"own": "rule_base"})

    def control(self, seen, memory, dt):
        return Command(seen.v, seen.w, seen.v, seen.w), None
"""


def test_a_law_of_arrays_stays_as_safe_as_it_was(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(ARRAYS, encoding="utf-8")
    law = make_controller(f"{tmp_path / 'mine.py'}:safe=yes")
    changed = law.with_fuzzy_system("own", other("tracking"))
    assert (law.safe, changed.safe) == ("yes", "yes")
    assert make_controller(f"{tmp_path / 'mine.py'}").with_fuzzy_system("own", other("tracking")).safe == ""
