"""A rule base that is tried on a robot: what the designer's panel "Try it" shows, without the page.

The system takes the place of the tracking rule base in :class:`robotics.laws.tracking.fuzzy_tracking.FuzzyTracking`, or
in a team's law that is built on it; all else belongs to the scenario and the law. The numbers are those of
:func:`robotics.simulation.loop.simulate` and :func:`robotics.measures.registry.measure_all`, to the last bit; only the
curves that are drawn are rounded, to a tenth of a millimetre.
"""

import warnings
from copy import copy
from dataclasses import dataclass, fields, is_dataclass
from functools import cache, lru_cache
from typing import Any, NamedTuple

import numpy as np

from fuzzy.compiled.sugeno import compile_sugeno
from fuzzy.errors import InputError
from fuzzy.naming import expected
from fuzzy.system import Sugeno
from robotics.experiments.forewarnings import forewarnings
from robotics.laws.catalogue import label, make_controller, preset_of, presets
from robotics.laws.law import Law
from robotics.laws.tracking.fuzzy_tracking import INPUTS, FuzzyTracking
from robotics.measures.contacts import contact_sentences, contacts, who
from robotics.measures.registry import measure_all, tried
from robotics.measures.tracking import cross_track_error
from robotics.playback.player import player_data
from robotics.quantity import check_quantities, quantity
from robotics.scenario.description import Scenario
from robotics.scenario.reading import load_scenario, scenario_names
from robotics.simulation.loop import simulate
from robotics.simulation.run import Run

_POINTS = 600  # points of a path that is drawn, at most
_NEEDS = (
    "A tracking law gives a rule base any of distance [m], alpha [rad], x_err [m] and heading_err [rad], by these "
    "names, and takes two outputs, the speed v [m/s] and the turn rate w [rad/s], in this order"
)


class TryoutError(InputError):
    """A system that cannot drive a robot, or a choice that does not exist. The message says what is needed."""


@dataclass(frozen=True, kw_only=True)
class TryoutTrial:
    """The conditions under which a system is tried."""

    scenario: str = "fuzzy-off-path"
    law: str = (
        ""  # of a team: a law of the catalogue that holds a tracking rule base; none: the scenario's, or cooperation
    )
    look_ahead: float = quantity(0.4, "s", least=0, most=10)  # of a single robot's tracking law
    seed: int = 0

    def __post_init__(self) -> None:
        check_quantities(self, TryoutError)
        if isinstance(self.seed, bool) or not isinstance(self.seed, int) or not 0 <= self.seed < 2**32:
            raise TryoutError(f"seed must be a whole number >= 0, got {self.seed!r}")
        if self.scenario not in scenario_names():
            raise TryoutError(expected(str(self.scenario), scenario_names(), "scenario"))
        reason = why_not(_scenario(self.scenario))
        if reason:
            raise TryoutError(f"{self.scenario}: {reason}")
        if self.law and self.law not in _team_laws():
            raise TryoutError(expected(str(self.law), _team_laws(), "law"))

    @property
    def kind(self) -> str:
        """The kind of the scenario: "tracking" or "team"."""
        return _scenario(self.scenario).kind


class Attempt(NamedTuple):
    """A run, and the notes on it."""

    run: Run
    notes: tuple[str, ...]  # sentences: inputs that left their universes, contacts, robots that were stopped


# What there is to choose ----------------------------------------------------------------------------------------


def why_not(scenario: Scenario) -> str:
    """The reason why a tracking rule base cannot drive this scenario; empty if it can."""
    if scenario.kind == "formation":
        return "a formation is driven by networks that see the leader's posture, not by a tracking rule base"
    return ""


def choices() -> dict[str, Any]:
    """The scenarios, teams' laws and rivals that the panel offers, in JSON's types."""
    found = [(name, _scenario(name)) for name in scenario_names()]
    rivals: dict[str, list[list[str]]] = {"tracking": [], "team": []}
    for name, preset in presets().items():
        if preset.kind in rivals and not holds_tracking(_law(name)):
            rivals[preset.kind].append([name, preset.title])
    return {
        "scenarios": [{"name": name, "title": s.title or name, "kind": s.kind, "why": why_not(s)} for name, s in found],
        "laws": [[name, label(name)] for name in _team_laws()],
        "rivals": rivals,
    }


def law_name(trial: TryoutTrial) -> str:
    """The name of the law whose tracking rule base is replaced."""
    scenario = _scenario(trial.scenario)
    if scenario.kind != "team":
        return "fuzzy"
    own = scenario.controller.partition(":")[0]
    return trial.law or (own if own in _team_laws() else "cooperation")


@lru_cache(maxsize=1)
def _team_laws() -> tuple[str, ...]:
    return tuple(name for name, preset in presets().items() if preset.kind == "team" and holds_tracking(_law(name)))


# The package's own scenarios and laws do not change during design, and reading one takes longer than a drag may.
@cache
def _scenario(name: str) -> Scenario:
    return load_scenario(name)


@lru_cache(maxsize=64)
def _law(specification: str) -> Law[Any]:
    return make_controller(specification)


# The law --------------------------------------------------------------------------------------------------------


def check_fits(fis: Sugeno) -> None:
    """Raise TryoutError, saying what is needed, unless ``fis`` can be a tracking rule base."""
    wrong = [v.name for v in fis.inputs if v.name not in INPUTS]
    outputs = [v.name for v in fis.outputs]
    if wrong:
        raise TryoutError(f"{fis.name} cannot drive a robot: no law knows the input {wrong[0]!r}. {_NEEDS}.")
    if len(outputs) != 2:
        many = "1 output" if len(outputs) == 1 else f"{len(outputs)} outputs"
        raise TryoutError(f"{fis.name} cannot drive a robot: it has {many} ({', '.join(outputs)}). {_NEEDS}.")
    if outputs[0] == "w" or outputs[1] == "v":
        raise TryoutError(
            f"{fis.name} cannot drive a robot: its outputs are in the order {', '.join(outputs)}. {_NEEDS}."
        )
    if not fis.rules:
        raise TryoutError(f"{fis.name} cannot drive a robot yet: it has no rule in force.")


def holds_tracking(law: Any) -> bool:
    """Whether a law holds a tracking rule base."""
    return isinstance(law, FuzzyTracking) or any(holds_tracking(part) for part in _parts(law).values())


def driven_by(law: Any, fis: Sugeno) -> Any:
    """The same law with ``fis`` as its tracking rule base; its other rule bases stay. Raises TryoutError."""
    check_fits(fis)
    changed: dict[str, Any] = {name: driven_by(p, fis) for name, p in _parts(law).items() if holds_tracking(p)}
    if isinstance(law, FuzzyTracking):
        places = tuple(INPUTS.index(v.name) for v in fis.inputs)
        changed |= {"rule_base": fis.name, "tracking": compile_sugeno(fis), "inputs": places}
    other = copy(law)
    for name, part in changed.items():
        object.__setattr__(other, name, part)  # a rule base in hand, where the constructor would read a file
    return other


def _parts(law: Any) -> dict[str, Any]:
    held = {f.name: getattr(law, f.name) for f in fields(law)} if is_dataclass(law) else {}
    return {name: part for name, part in held.items() if hasattr(part, "control")}


# The runs -------------------------------------------------------------------------------------------------------


def run_design(fis: Sugeno, trial: TryoutTrial) -> Attempt:
    """Run ``fis`` in the closed loop, once, with the trial's seed.

    Raises TryoutError for a system that does not fit, and an InputError for one that refuses an input on the way.
    """
    name = law_name(trial)
    gains = f":look_ahead={trial.look_ahead!r}" if trial.kind == "tracking" else ""
    return _run(driven_by(_law(name + gains), fis), trial, fis.name)


def run_rival(specification: str, trial: TryoutTrial) -> Attempt:
    """Run a law of the catalogue on the trial's scenario with its seed. Raises an InputError if it cannot drive it."""
    preset_of(specification)
    return _run(_law(specification), trial, specification)


def _run(law: Law[Any], trial: TryoutTrial, name: str) -> Attempt:
    scenario = _scenario(trial.scenario)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        run = simulate(scenario, law, (trial.seed,), name=name, links=scenario.kind == "team")
    notes = dict.fromkeys(str(warning.message) for warning in told)  # the same is told every period
    stops = [
        f"robot {robot + 1} was stopped at {run.time[run.stopped[0, robot]]:.2f} s: its command was no number, or it "
        f"was more than {scenario.divergence:g} m from its reference"
        for robot in np.flatnonzero(run.diverged[0])
    ]
    touches = [f"{line.partition(': ')[2]}; what comes after it is not measured" for line in contact_sentences(run)]
    return Attempt(run, (*forewarnings(scenario.setting, law, "this law"), *notes, *touches, *stops))


# What is shown --------------------------------------------------------------------------------------------------


def course_data(trial: TryoutTrial) -> dict[str, Any]:
    """What all runs of a trial share, in JSON's types: the paths to follow, the starts, the metrics' names."""
    scenario = _scenario(trial.scenario)
    return {
        "scenario": scenario.name,
        "title": scenario.title or scenario.name,
        "kind": scenario.kind,
        "duration": scenario.duration,
        "law": law_name(trial),
        "paths": [_curve(path.table[0], path.table[1]) for path in scenario.trajectory.paths],
        "starts": [list(member.start) for member in scenario.robots],
        "metrics": [
            {"name": name, "title": metric.title, "unit": metric.unit, "larger": metric.larger}
            for name, metric in tried(scenario.kind, scenario.setting.has_others).items()
        ],
    }


def design_data(fis: Sugeno, trial: TryoutTrial) -> dict[str, Any]:
    """The run of ``fis`` (:func:`run_design`), as the panel's module takes it."""
    return shown(run_design(fis, trial), trial.kind, fis.name)


def rival_data(specification: str, trial: TryoutTrial) -> dict[str, Any]:
    """The run of a law of the catalogue (:func:`run_rival`), as the panel's module takes it."""
    return shown(run_rival(specification, trial), trial.kind, preset_of(specification).title)


def shown(attempt: Attempt, kind: str, label: str) -> dict[str, Any]:
    """What the panel shows of a run, in JSON's types; not-a-number is null, infinite is "never".

    For a single robot these are label, notes, metrics, contacts (time [s], x, y [m], words), and x, y [m] and
    cross_track [m] over time [s]; for a team the player's data take the place of the curves. A metric is the mean over
    the robots (the least, if larger is better).

    Args:
        attempt: The run.
        kind: The kind of the scenario, which chooses the metrics.
        label: The name of the run on the page.
    """
    run = attempt.run
    measured = measure_all(run)
    wanted = {name: metric for name, metric in tried(kind, others=True).items() if name in measured}
    metrics = {n: _number((np.min if m.larger else np.mean)(measured[n][0])) for n, m in wanted.items()}
    touched = [[c.start, c.x, c.y, who(c.robot, c.other, c.obstacle)] for c in contacts(run)]
    data: dict[str, Any] = {"label": label, "notes": list(attempt.notes), "metrics": metrics, "contacts": touched}
    if kind == "team":
        return data | {"player": player_data(run)}
    return data | {
        "time": [round(float(t), 4) for t in run.time],
        "x": [_rounded(row) for row in run["x"][0]],
        "y": [_rounded(row) for row in run["y"][0]],
        "cross_track": [_rounded(row) for row in cross_track_error(run)[0]],
    }


def _number(value: float) -> float | str | None:
    return float(value) if np.isfinite(value) else ("never" if np.isinf(value) else None)


def _rounded(values: np.ndarray) -> list[float | None]:
    return [v if v == v else None for v in (np.round(values, 4) + 0.0).tolist()]


def _curve(x: np.ndarray, y: np.ndarray) -> dict[str, list[float | None]]:
    kept = np.unique(np.linspace(0, len(x) - 1, min(len(x), _POINTS)).round().astype(int))
    return {"x": _rounded(x[kept]), "y": _rounded(y[kept])}
