"""A rule base that is tried on a robot: what the designer's panel "Try it" shows, without the page.

The system takes the place of a rule base in a law, as :mod:`robotics.plugins.designer.uses` finds it; all else belongs
to the scenario and the law. The numbers are those of :func:`robotics.simulation.loop.simulate` and
:func:`robotics.measures.registry.measure_all`, to the last bit; only the curves that are drawn are rounded, to a tenth
of a millimetre.
"""

import re
import warnings
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from fuzzy.errors import InputError
from fuzzy.naming import check_known, expected
from fuzzy.quantity import check_quantities, quantity, whole
from fuzzy.system import Sugeno
from robotics.laws.catalogue import preset_of, presets
from robotics.laws.equation import EquationLaw
from robotics.laws.law import Law
from robotics.laws.tracking.fuzzy_tracking import FuzzyTracking
from robotics.measures.clearance import clearances, robot_gaps
from robotics.measures.contacts import can_touch, contact_sentences, contacts, who
from robotics.measures.outside import outside, outside_sentence
from robotics.measures.own import installed_metrics
from robotics.measures.registry import ALL_METRICS, headlines, measure_all, panel_metrics
from robotics.measures.tracking import SCENARIO_KINDS, Metric, cross_track_error
from robotics.plugins.designer.conditions import GIVEN_TO_LAWS, conditioned, file_name, robot_from, scenario_of
from robotics.plugins.designer.moments import asked_of, bends, evenly, motion_curves, reference_curves, rounded_list
from robotics.plugins.designer.tunetask import terms_of
from robotics.plugins.designer.uses import TryoutError, Use, law_of, uses_of
from robotics.show.playback.player import player_data
from robotics.simulation.loop import simulate
from robotics.simulation.run import Run
from robotics.simulation.scenario.conditions import AMONG_OBSTACLES, CONDITION_GROUPS, MEETINGS, group_of, noises
from robotics.simulation.scenario.description import Scenario
from robotics.simulation.scenario.reading import scenario_names
from robotics.simulation.scenario.robots import load_robot, robot_names
from robotics.studies.forewarnings import forewarnings, shortcomings
from robotics.studies.tuning.cost import Cost, Term
from robotics.world.environment.world import outlines

_POINTS = 600  # points of a path that is drawn, at most
_FRAMES = 1001  # of a run that is played, at most: more than a line over time has pixels
_MOVES = 0.05  # m/s: a robot that is slower stands
_TOLD = ("contacts", "min_clearance_m", "arrival_time_s")  # metrics of which more is made than a number in the table
_IN_PYTHON = re.compile(r" \((?:no_rule_fires|out_of_range) = [^)]*\)$")  # how Python chooses, in a warning


@dataclass(frozen=True, kw_only=True)
class TryoutTrial:
    """The conditions under which a system is tried; :func:`settled` chooses for a system what is left empty.

    Raises TryoutError for a choice that cannot be.
    """

    scenario: str = ""  # a scenario that comes with the package, or the name of the file that holds ``text``
    text: str | None = None  # of a scenario file of one's own
    law: str = ""  # a name of the catalogue
    task: str = ""  # of that law, whose rule base is replaced
    look_ahead: float = quantity(0.4, "s", least=0, most=10)  # of a single robot's tracking law
    seed: int = whole(0, least=0, most=2**32 - 1, doc="Of all noise.")
    robot: str = ""  # as the scenario says; or one of the package, or the name of the file that holds ``robot_text``
    robot_text: str | None = None  # of a robot file of one's own
    robot_of: int = whole(0, least=0, doc="The robot that is another, from 1; 0: all of them.")
    folder: str = ""  # the opened one, where the files are that a scenario's file names
    noise: bool = True  # see robotics.plugins.designer.conditions.exact
    given: str = ""  # to every law that can use it, of robotics.plugins.designer.conditions.GIVEN_TO_LAWS
    terms: tuple[tuple[str, float, float], ...] = ()  # metric, scale, weight: what a run costs; by default as Tune's

    def __post_init__(self) -> None:
        check_quantities(self, TryoutError)
        if not isinstance(self.noise, bool):
            raise TryoutError(f"noise must be true or false, got {self.noise!r}")
        for name in ("scenario", "law", "task", "robot", "folder", "given"):
            if not isinstance(getattr(self, name), str):
                raise TryoutError(f"{name} must be a name, got {getattr(self, name)!r}")
        if self.given:
            check_known(self.given, GIVEN_TO_LAWS, "knowledge", TryoutError)

    def conditioned(self) -> Scenario:
        """The scenario under the trial's conditions. Raises ScenarioError, RobotError or TryoutError."""
        robot = (self.robot, self.robot_text, self.robot_of)
        return conditioned((self.scenario, self.text, self.folder), robot, self.noise, self.given)


class Attempt(NamedTuple):
    """A run, and the notes on it."""

    run: Run
    warned: tuple[str, ...]  # sentences: what could be told before the run
    notes: tuple[str, ...]  # sentences: inputs that left their universes
    divergence: float  # m: the scenario's, see Scenario


# What there is to choose ----------------------------------------------------------------------------------------


def choices() -> dict[str, Any]:
    """The package's scenarios and robots, and the laws to compare with, in JSON's types."""
    rivals: dict[str, list[list[str]]] = {kind: [] for kind in SCENARIO_KINDS}
    for name, preset in presets().items():
        rivals[preset.kind].append([name, preset.title])
    found = [(name, scenario_of(name, None)) for name in scenario_names()]
    return {
        "groups": list(CONDITION_GROUPS),
        "scenarios": [{"name": n, "title": s.title or n, "kind": s.kind, "group": group_of(s)} for n, s in found],
        "rivals": rivals,
        "robots": [[name, load_robot(name).title] for name in robot_names()],
        "given": [["", "what the scenario says"], *([name, name] for name in GIVEN_TO_LAWS)],
    }


def settled(fis: Sugeno, wish: TryoutTrial, file: str = "") -> TryoutTrial:
    """The trial of a system with all that ``wish`` leaves empty: the law, the task and the scenario that suit it.

    A law that does not drive the scenario gives way to one that does. Raises TryoutError where there is none, or the
    choices do not exist, and what reading the scenario raises.

    Args:
        fis: The system.
        wish: What was chosen.
        file: The name of the system's file.
    """
    uses = uses_of(fis, file)
    scenario = wish.conditioned() if wish.scenario or wish.text is not None else None
    fitting = [use for use in uses if scenario is None or scenario.kind in use.kinds]
    if scenario is not None and not fitting:
        kinds = " or ".join(dict.fromkeys(kind for use in uses for kind in use.kinds))
        raise TryoutError(
            f'{wish.scenario} is of kind "{scenario.kind}", and the laws that {fis.name} fits drive scenarios of kind '
            f"{kinds}: {', '.join(dict.fromkeys(use.law for use in uses))}"
        )
    if wish.law and wish.law not in presets():
        raise TryoutError(expected(wish.law, [use.law for use in uses], "law"))
    use = _chosen(fitting, wish, scenario)
    return replace(wish, law=use.law, task=use.task, scenario=wish.scenario or use.scenarios[0])


def _chosen(uses: list[Use], wish: TryoutTrial, scenario: Scenario | None) -> Use:
    """The use with the law and task of ``wish``; otherwise that of the scenario's own law, or the most likely."""
    asked = [use for use in uses if use.law == wish.law and wish.task in ("", use.task)]
    if asked:
        return asked[0]
    first = uses[0]
    if scenario is None or first.task != "tracking" or scenario.kind != "team":
        return first
    tracking = {use.law: use for use in uses if use.task == "tracking"}
    # Where robots would touch each other or an obstacle, one that does not avoid them shows nothing of the rule base.
    usual = {MEETINGS: "crash-yielding", AMONG_OBSTACLES: "obstacles"}.get(group_of(scenario), "cooperation")
    return tracking.get(scenario.controller.partition(":")[0]) or tracking[usual]


def driven_law(fis: Sugeno, trial: TryoutTrial) -> Law[Any]:
    """The law of a settled trial with ``fis`` as the rule base of the trial's task. Raises an InputError."""
    if not fis.rules:
        raise TryoutError(f"{fis.name} cannot drive a robot yet: it has no rule in force.")
    gains = f":look_ahead={trial.look_ahead!r}" if has_look_ahead(trial) else ""
    return law_of(trial.law + gains).with_fuzzy_system(trial.task, fis)


def has_look_ahead(trial: TryoutTrial) -> bool:
    """Whether the trial's look-ahead has an effect: it is that of a tracking law alone."""
    return isinstance(law_of(trial.law), FuzzyTracking)


# The runs -------------------------------------------------------------------------------------------------------


def run_design(fis: Sugeno, trial: TryoutTrial) -> Attempt:
    """Run ``fis`` in the closed loop, once, with the trial's seed.

    Raises TryoutError for a system that does not fit, and an InputError for one that refuses an input on the way.
    """
    trial = _complete(fis, trial)
    return _run(driven_law(fis, trial), trial, fis.name)


def _complete(fis: Sugeno, trial: TryoutTrial) -> TryoutTrial:
    return trial if trial.scenario and trial.law and trial.task else settled(fis, trial)


def rival_law(specification: str) -> Law[Any]:
    """The law of a specification: that of a file is made of what stands there now. Raises ControllerError."""
    preset_of(specification)
    return law_of(specification)


def _run(law: Law[Any], trial: TryoutTrial, name: str) -> Attempt:
    scenario = trial.conditioned()
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        # The wheels' torques are drawn of a robot that is alone.
        message_ages, torques = scenario.kind == "team", not _played(scenario)
        run = simulate(scenario, law, (trial.seed,), name=name, message_ages=message_ages, torques=torques)
    # The same is told every period; what to write in Python is nothing to write on the page.
    notes = dict.fromkeys(_IN_PYTHON.sub("; choose under Inference what counts there", str(w.message)) for w in told)
    left = outside(run)
    beyond = [outside_sentence(left)] if left else []
    warned = tuple(forewarnings(scenario.setting, law, "this law"))
    return Attempt(run, warned, (*notes, *beyond), scenario.divergence)


def outcomes(run: Run, divergence: float, place: int = 0) -> list[list[str]]:
    """What ended the run's seed at ``place`` early: "contact" or "stopped", each with a sentence.

    Args:
        run: The run.
        divergence: The distance [m] from its reference at which the scenario stops a robot.
        place: The place of the seed.
    """
    touched = contact_sentences(run.only(run.seeds[place]))
    why = f"its command was no number, or it was more than {divergence:g} m from its reference"
    stops = {robot + 1: run.time[run.stopped[place, robot]] for robot in np.flatnonzero(run.diverged[place])}
    return [
        *(["contact", f"{line.partition(': ')[2]}; what comes after it is not measured"] for line in touched),
        *(["stopped", f"robot {robot} was stopped at {time:.2f} s: {why}"] for robot, time in stops.items()),
    ]


# What is shown --------------------------------------------------------------------------------------------------


def course_data(trial: TryoutTrial) -> dict[str, Any]:
    """What all runs of a trial share, in JSON's types: the paths to follow, the starts, the metrics' names."""
    scenario = trial.conditioned()
    world = scenario.setting.world
    bodies = [] if world is None else outlines(world.rest)  # where each is at the start
    cost = cost_of(trial, scenario.kind)
    metrics = _shown_metrics(scenario.kind, scenario.setting.has_others, cost)
    touching = sum(metric.needs_others for metric in metrics.values())
    rows = [{"name": n, "title": m.title, "unit": m.unit, "larger": m.larger} for n, m in metrics.items()]
    return {
        "scenario": trial.scenario,
        "title": scenario.title or scenario.name,
        "kind": scenario.kind,
        "group": group_of(scenario),
        "played": _played(scenario),
        "duration": scenario.duration,
        "noises": noises(replace(trial, noise=True).conditioned()),
        "paths": [_curve(path.table[0], path.table[1]) for path in scenario.trajectory.paths],
        "obstacles": [[rounded_list(row) for row in body.T] for body in bodies],
        "starts": [list(member.start) for member in scenario.robots],
        "metrics": [*rows[:touching], *([_COST_ROW] if cost else []), *rows[touching:]],
    }


def place_data(fis: Sugeno, wish: TryoutTrial, file: str = "") -> dict[str, Any]:
    """The place that a system finds (:func:`settled`), in JSON's types: the trial, its course, and what else it fits.

    The laws that it fits are [law, task, title, kinds]; "suggested" are scenarios in which the chosen one shows what
    the system does, "rival" is a law to compare it with, and "marks" tell, by name, what laws that do not suit the
    scenario leave out of account.
    """
    trial = settled(fis, wish, file)
    uses = uses_of(fis, file)
    mine = next(use for use in uses if (use.law, use.task) == (trial.law, trial.task))
    course = course_data(trial)
    kind = course["kind"]
    rival = mine.rival if preset_of(mine.rival).kind == kind else _RIVALS[kind]
    if kind == "team" and mine.task == "tracking":
        rival = {MEETINGS: "right-of-way", AMONG_OBSTACLES: "fuzzy-team"}.get(course["group"], rival)
    return {
        "trial": asdict(trial),
        "course": course
        | {
            "laws": [[use.law, use.task, use.title, list(use.kinds)] for use in uses],
            "suggested": list(mine.scenarios),
            "rival": rival,
            "marks": _marks(trial, kind, uses),
            "ahead": has_look_ahead(trial),
            "untaken": untaken(law_of(trial.law).with_fuzzy_system(trial.task, fis)),
        },
    }


def untaken(law: Law[Any]) -> list[str]:
    """What of GIVEN_TO_LAWS a law does not take, in few words each, with the reason."""
    if not isinstance(law, EquationLaw):
        return ["no lead, no low-pass: it has no equation"]
    words = {"lead": "lead", "smooth": "low-pass", "estimator": "filter"}
    own = [word for name, word in words.items() if getattr(law, name) is not None]
    found = [f"its own {' and '.join(own)}"] if own else []
    return found + [f"no {words[name]}: {why}" for name, why in law.barred.items()]


def _marks(trial: TryoutTrial, kind: str, uses: Sequence[Use]) -> dict[str, str]:
    """What the laws that can be chosen do not look at in the trial's scenario, in few words, by their names."""
    names = {name for name, preset in presets().items() if preset.kind == kind} | {use.law for use in uses}
    return shortcomings(trial.conditioned().setting, {name: law_of(name) for name in sorted(names)})


_COST = "cost"  # beside the names of metrics
_COST_ROW = {"name": _COST, "title": "cost, as Tune counts it", "unit": "1", "larger": False}
_COSTING = ("tracking", "team")  # kinds of scenarios for which Tune has a cost
_RIVALS = {"tracking": "lyapunov", "team": "virtual-structure", "formation": "formation-teacher", "goal": "polar"}


def _played(scenario: Scenario) -> bool:
    """Whether its runs are played; those of a robot that is alone are drawn beside each other."""
    return scenario.kind != "tracking" or scenario.setting.has_others


def cost_of(trial: TryoutTrial, kind: str) -> Cost | None:
    """What runs of a kind of scenario cost: by the trial's terms, or those with which Tune begins; None: nothing."""
    if kind not in _COSTING:
        return None
    terms = trial.terms or terms_of(kind)
    return Cost(terms=tuple(Term(metric=name, scale=scale, weight=weight) for name, scale, weight in terms if weight))


def _shown_metrics(kind: str, others: bool, cost: Cost | None = None) -> dict[str, Metric]:
    """The metrics that are shown, by name: what touches what first, next the terms of the cost, and strangers' last."""
    own = installed_metrics()[0]
    found = (panel_metrics(kind, others) or headlines(kind, others)) | panel_metrics(kind, others, own)
    terms = {name: ALL_METRICS[name] for name in (cost.metrics if cost else ()) if name in ALL_METRICS}
    return dict(sorted((terms | found).items(), key=lambda item: not item[1].needs_others))


def design_data(fis: Sugeno, trial: TryoutTrial) -> dict[str, Any]:
    """The run of ``fis`` (:func:`run_design`), as the panel's module takes it, and what its rule base was "asked".

    That is a :class:`robotics.plugins.designer.moments.Asked`, or None, for
    :class:`robotics.plugins.designer.moments.RunMoments`.
    """
    trial = _complete(fis, trial)
    attempt = run_design(fis, trial)
    cost = cost_of(trial, attempt.run.about.kind)
    found = shown(attempt, fis.name, cost) | {"asked": asked_of(attempt.run, trial.task)}
    return found if "player" in found else found | {"reference": reference_curves(attempt.run)}


def rival_data(rival: Sugeno | str, trial: TryoutTrial, file: str = "") -> dict[str, Any]:
    """The run of another law or system on the same scenario with its seed, as the panel's module takes it.

    A law is a name of the catalogue, or the path of a file with one. A system, of which ``file`` is the name of the
    file, drives in the trial's own law or in one that it fits. Raises TryoutError where there is none, and an
    InputError where it cannot drive the scenario.
    """
    if isinstance(rival, Sugeno):
        attempt, title = run_design(rival, settled(rival, trial, file)), file
    else:
        attempt, title = _run(rival_law(rival), trial, rival), preset_of(rival).title
    return shown(attempt, title, cost_of(trial, attempt.run.about.kind))


def checked(what: str, name: str, text: str, folder: str = "") -> dict[str, Any]:
    """What is wrong with the text of a scenario or a robot file: its line, if it is known, and the message; or nothing.

    Args:
        what: "scenario" or "robot".
        name: The name of the file.
        text: What stands in it.
        folder: The opened folder.
    """
    try:
        if what == "scenario":
            scenario_of(name, text, folder)
        else:
            robot_from(name, text)
    except InputError as error:
        line = re.match(re.escape(file_name(name)) + r":(\d+): ", str(error))
        return {"line": int(line[1]) if line else None, "message": str(error)}
    return {}


def shown(attempt: Attempt, label: str, cost: Cost | None = None) -> dict[str, Any]:
    """What the panel shows of a run, in JSON's types; not-a-number is null, infinite is "never".

    For a robot that is alone these are label, seed, warned, notes, outcomes (what ended it early, and a sentence),
    metrics, contacts (time [s], x, y [m], words), and x, y [m] and cross_track [m] over time [s], and its motion
    (:func:`robotics.plugins.designer.moments.motion_curves`); otherwise a verdict, the moment [s] that matters most and
    the player's data take the place of the curves. A metric is the mean over the robots, or the least or the largest,
    as its ``of_run`` says (the least, if larger is better).

    Args:
        attempt: The run.
        label: The name of the run on the page.
        cost: What it costs, if it has a cost.
    """
    run = attempt.run
    wanted = [*_shown_metrics(run.about.kind, others=True, cost=cost), *_TOLD]
    measured = measure_all(run, installed_metrics()[0], only=wanted)
    data = {"label": label, "warned": list(attempt.warned), "notes": list(attempt.notes)}
    data |= seed_data(run, measured, attempt.divergence, cost=cost)
    if run.about.kind != "tracking" or can_touch(run):
        played = player_data(run, frames=_FRAMES)
        return data | {"verdict": _verdict(run, measured), "moment": _moment(run), "player": played}
    return data | path_data(run, len(run.time)) | {"motion": motion_curves(run)}


def seed_data(
    run: Run,
    measured: dict[str, np.ndarray],
    divergence: float,
    place: int = 0,
    most: int | None = None,
    cost: Cost | None = None,
) -> dict[str, Any]:
    """What became of the run's seed at ``place``: the seed, outcomes, metrics, and ``most`` contacts; None: all.

    With a cost also the metric "cost", and the share that each of its terms has in it.

    Args:
        run: The run.
        measured: As of :func:`robotics.measures.registry.measure_all`.
        divergence: The distance [m] from its reference at which the scenario stops a robot.
        place: The place of the seed.
        most: How many contacts are drawn.
        cost: What a run costs.
    """
    metrics, shares = reduced_metrics(run.about.kind, measured, place, cost), dict[str, Any]()
    if cost is not None:
        here = {name: rows[place] for name, rows in measured.items()}
        total = cost.objectives_of(here, run.diverged[place]).sum()
        metrics = {_COST: _number(float(total)), **metrics}
        parts = zip(cost.terms, cost.parts_of(here), strict=True)
        shares = {term.name: _number(float(part / total)) for term, part in parts if total < cost.failed}
    return {
        "seed": run.seeds[place],
        "outcomes": outcomes(run, divergence, place),
        "metrics": metrics,
        "shares": shares,
        "contacts": [[c.start, c.x, c.y, who(c.robot, c.other, c.obstacle)] for c in contacts(run, place, most)],
    }


def path_data(run: Run, points: int, place: int = 0) -> dict[str, Any]:
    """The paths x, y [m] of the robots of the seed at ``place``, at so many times at most, closer where they bend.

    Of a robot that is alone also the cross_track error [m] over time [s].
    """
    kept, x, y = evenly(len(run.time), points), run["x"][place], run["y"][place]
    at = [bends(*path, points) for path in zip(x, y, strict=True)]
    drawn: dict[str, Any] = {
        name: [rounded_list(row[k]) for row, k in zip(rows, at, strict=True)] for name, rows in (("x", x), ("y", y))
    }
    if run.about.kind == "tracking" and not can_touch(run):
        error = cross_track_error(run)[place]
        drawn |= {"cross_track": [rounded_list(row[kept]) for row in error], "time": rounded_list(run.time[kept])}
    return drawn


def reduced_metrics(
    kind: str, measured: dict[str, np.ndarray], place: int, cost: Cost | None = None
) -> dict[str, float | str | None]:
    """The metrics that are shown of a run's seed at ``place``, one number each; not-a-number is null, infinite "never".

    Args:
        kind: The kind of the scenario.
        measured: As of :func:`robotics.measures.registry.measure_all`.
        place: The place of the seed.
        cost: Whose terms are among them.
    """
    reduced: dict[str, Any] = {"mean": np.mean, "min": np.min, "max": np.max}
    wanted = {n: m for n, m in _shown_metrics(kind, others=True, cost=cost).items() if n in measured}
    how = {n: reduced["min" if m.larger else m.of_run] for n, m in wanted.items()}
    return {n: _number(float(of(measured[n][place]))) for n, of in how.items()}


def _verdict(run: Run, measured: dict[str, np.ndarray]) -> str:
    """What became of a run among others, in a few words: who touched what, how near they came, who arrived."""
    touched, room = contacts(run), float(measured["min_clearance_m"][0].min())
    if touched:
        first = touched[0]
        words = [f"{who(first.robot, first.other, first.obstacle)} touch at {first.start:.1f} s"]
        if len(touched) > 1:
            words = [f"{len(touched)} contacts: {words[0]} first"]
    else:
        words = ["no contact", f"least clearance {100 * room:.1f} cm"] if np.isfinite(room) else ["no contact"]
    if "arrival_time_s" in measured:
        arrivals = measured["arrival_time_s"][0]
        missing = [str(robot + 1) for robot in np.flatnonzero(~np.isfinite(arrivals))]
        if not missing:
            words.append(f"all arrive within {max(np.ptp(arrivals), 0.1):.1f} s, the last at {arrivals.max():.1f} s")
        elif len(missing) == len(arrivals):
            words.append("nobody arrives")
        else:
            words.append(f"robot{'s' * (len(missing) > 1)} {', '.join(missing)} did not arrive")
    return "; ".join(words)


def _moment(run: Run) -> float:
    """The time [s] of the first contact, or else when a robot that moves is nearest to another or an obstacle."""
    touched = contacts(run, most=1)
    if touched:
        return float(touched[0].start)
    sizes = [robot.turning_circle for robot in run.about.robots]
    room = clearances(run, 0)
    for (i, j), gap in robot_gaps(run, 0).items():
        room[[i, j]] = np.minimum(room[[i, j]], gap - sizes[i] - sizes[j])
    moves = np.abs(run["v"][0]) > _MOVES
    return float(run.time[np.nanargmin(np.where(moves, room, np.inf).min(axis=0))])


def _number(value: float) -> float | str | None:
    return float(value) if np.isfinite(value) else ("never" if np.isinf(value) else None)


def _curve(x: np.ndarray, y: np.ndarray) -> dict[str, list[float | None]]:
    kept = evenly(len(x), _POINTS)
    return {"x": rounded_list(x[kept]), "y": rounded_list(y[kept])}
