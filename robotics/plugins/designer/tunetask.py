"""A rule base that is tuned through the closed loop: what the designer's panel "Tune" runs in another process.

What was asked, the search's journal and the best so far stand in a folder beside the design's unsaved work, so that a
search whose process was killed goes on where it was.
"""

import json
import math
import os
import shutil
import time
import warnings
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from fuzzy.errors import InputError
from fuzzy.files.atomic import write_json
from fuzzy.files.fisfile import format_fis, parse_fis
from fuzzy.naming import check_known
from fuzzy.plugins.designer import autosave
from fuzzy.plugins.designer.longtask import Report
from fuzzy.system import Sugeno
from fuzzy.tuning.parameter import TuningError
from fuzzy.tuning.search import Evaluations
from robotics.laws.law import Law
from robotics.measures.registry import ALL_METRICS
from robotics.plugins.designer.conditions import scenario_of
from robotics.plugins.designer.moments import evenly, rounded_list
from robotics.plugins.designer.uses import law_of, uses_of
from robotics.plugins.tuning.unseen import compared
from robotics.simulation.loop import simulate
from robotics.simulation.scenario.description import Scenario
from robotics.studies.tuning.cost import COST_TERMS, Cost, Term
from robotics.studies.tuning.file import load_tuning
from robotics.studies.tuning.space import PARTS, LawSpace
from robotics.studies.tuning.tune import TUNING, reached, tune, with_noise

OFFERED_ENGINES = ("cmaes", "random")
_UNSEEN = 50  # seeds with which before and after are compared
MOST_RUNS = 1000  # of a candidate
MOST_EVALUATIONS = 100_000
OFFERED_CHOICES = {"engine": [*OFFERED_ENGINES], "runs": MOST_RUNS, "evaluations": MOST_EVALUATIONS, "move": [*PARTS]}
_OFTEN = 0.4  # s between two candidates that are shown
_POINTS = 300  # of a path that is drawn, at most
_TASK, _BEST = "task.json", "best.json"


@dataclass(frozen=True, kw_only=True)
class TuneTask:
    """What is tuned, on what, and at what cost."""

    system: str  # the rule base as it was, as the text of a .fis file: the search begins with what is read from there
    law: str  # a name of the catalogue
    task: str  # of that law, whose rule base is tuned
    move: tuple[str, ...]  # of robotics.studies.tuning.space.PARTS
    still: tuple[str, ...] = ()  # inputs and outputs of which nothing moves
    symmetric: bool = True
    scenarios: tuple[tuple[str, str | None], ...]  # each a name of the package, or a file's name and its text
    noise: bool = True  # whether postures are measured with noise where nothing else is random
    terms: tuple[tuple[str, float, float], ...]  # of the cost: metric, scale, weight
    runs: int = 20
    evaluations: int = 500
    engine: str = "cmaes"
    seed: int = 1
    folder: str  # the opened one
    place: str  # the folder of the search

    def begun(self) -> Sugeno:
        """The rule base as it was."""
        return parse_fis(self.system)

    def space(self) -> LawSpace:
        """What moves. Raises TuningError where nothing does."""
        law: Law[Any] = law_of(self.law).with_fuzzy_system(self.task, self.begun())
        space = LawSpace(law, self.move, tasks=[self.task], symmetric=self.symmetric)
        fixed = [p.name for p in space.parameters if p.name.removeprefix(f"{self.task}.").split(".")[0] in self.still]
        if len(fixed) == len(space.parameters):
            raise TuningError("nothing may move: choose an input, an output or another part").about("move")
        return replace(space, fixed=fixed)

    def cost(self) -> Cost:
        """What a run costs."""
        terms = (Term(metric=name, scale=scale, weight=weight) for name, scale, weight in self.terms if weight)
        return Cost(terms=tuple(terms))

    def chosen(self) -> list[Scenario]:
        """The scenarios."""
        found = [scenario_of(name, text, self.folder) for name, text in self.scenarios]
        return [with_noise(scenario) for scenario in found] if self.noise else found


# What there is to choose ----------------------------------------------------------------------------------------


def place_of(file: Path) -> Path:
    """The folder in which the search for a .fis file's design is written down."""
    return autosave.place_for(file).with_name(f"{file.name}.tuning")


def offered(fis: Sugeno, file: str) -> dict[str, Any]:
    """What a system may be tuned in, in JSON's types: its laws with their scenarios, and whether it is symmetric.

    Raises TryoutError for a system that no law takes.
    """
    from fuzzy.tuning.mirror import mirror_of

    laws = [
        {"law": u.law, "task": u.task, "title": u.title, "kinds": list(u.kinds), "scenarios": list(u.scenarios)}
        for u in uses_of(fis, file)
    ]
    variables = [v.name for v in (*fis.inputs, *fis.outputs)]
    return {"laws": laws, "symmetric": mirror_of(fis) is not None, "variables": variables}


def terms_of(kind: str) -> list[list[Any]]:
    """The terms of the cost for scenarios of a kind, each [metric, scale, weight]."""
    terms = COST_TERMS if kind == "tracking" else _team_terms()
    return [[term.metric, term.scale, term.weight] for term in terms]


@cache
def _team_terms() -> tuple[Term, ...]:
    return load_tuning("team").cost  # read once: a drag asks at each step


def metrics() -> list[list[str]]:
    """All metrics that a cost may have: [name, title, unit]."""
    return [[name, metric.title, metric.unit] for name, metric in ALL_METRICS.items()]


def checked(choice: dict[str, Any]) -> None:
    """Raise TuningError, about the field, for what cannot be asked."""
    for name, most in (("runs", MOST_RUNS), ("evaluations", MOST_EVALUATIONS), ("seed", 2**31)):
        value = choice[name]
        least = 0 if name == "seed" else 1
        if isinstance(value, bool) or not isinstance(value, int) or not least <= value <= most:
            raise TuningError(f"{name} must be a whole number from {least} to {most}; got {value!r}").about(name)
    check_known(choice["engine"], OFFERED_ENGINES, "engine", TuningError, "engine")
    for name in ("symmetric", "noise"):
        if not isinstance(choice[name], bool):
            raise TuningError(f"{name} must be true or false; got {choice[name]!r}").about(name)
    for name in ("move", "still", "scenarios"):
        if not isinstance(choice[name], list) or not all(isinstance(v, str) for v in choice[name]):
            raise TuningError(f"{name} must be a list of names; got {choice[name]!r}").about(name)
    if not choice["move"]:
        raise TuningError("choose what may move").about("move")
    for part in choice["move"]:
        check_known(part, PARTS, "part that can move", TuningError, "move")
    if not choice["scenarios"]:
        raise TuningError("choose at least one scenario to tune on").about("scenarios")
    _check_terms(choice["terms"])


def _check_terms(terms: Any) -> None:
    if not isinstance(terms, list) or not all(isinstance(term, list) and len(term) == 3 for term in terms):
        raise TuningError("a term of the cost is a metric, a scale and a weight").about("terms")
    for name, scale, weight in terms:
        check_known(name, ALL_METRICS, "metric", TuningError, "terms")
        for what, value, least in (("scale", scale, "> 0"), ("weight", weight, ">= 0")):
            right = isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
            if not right or value < 0 or (what == "scale" and value == 0):
                raise TuningError(f"the {what} of {name} must be a number {least}; got {value!r}").about("terms")
    if not any(weight > 0 for _, _, weight in terms):
        raise TuningError("at least one term of the cost needs a weight > 0").about("terms")


# What is kept of a search ---------------------------------------------------------------------------------------


def write_task(task: TuneTask) -> None:
    """Write down what was asked, and forget what stood there."""
    place = Path(task.place)
    forget(place)
    place.mkdir(parents=True, exist_ok=True)
    write_json(place / _TASK, asdict(task))


def forget(place: Path) -> None:
    """Remove what is kept of a search."""
    if place.is_symlink():
        place.unlink()
    with suppress(OSError):
        shutil.rmtree(place)


def found_at(place: Path, folder: Path) -> dict[str, Any] | None:
    """What is kept of a search: {"task": TuneTask, "best": as :func:`_candidate` gives it, or None}; None: nothing."""
    if place.is_symlink() or not place.resolve().is_relative_to(folder):
        return None
    unreadable = (OSError, InputError, ValueError, KeyError, TypeError)
    try:
        told = json.loads((place / _TASK).read_text(encoding="utf-8"))
        told |= {name: tuple(told[name]) for name in ("move", "still")}
        told |= {name: tuple(map(tuple, told[name])) for name in ("scenarios", "terms")}
        task = TuneTask(**told | {"place": str(place), "folder": str(folder)})
        task.begun()
    except unreadable:
        return None
    try:
        best = json.loads((place / _BEST).read_text(encoding="utf-8"))
        best |= {"evaluations": int(best["evaluations"]), "cost": float(best["cost"]), "before": float(best["before"])}
        parse_fis(best["system"])
    except unreadable:
        best = None
    return {"task": task, "best": best}


# The search, in a process of its own ----------------------------------------------------------------------------


def search_best(task: TuneTask, report: Report) -> dict[str, Any]:
    """Tune, and tell of it: what a :class:`fuzzy.plugins.designer.longtask.TaskProcess` does.

    News are ("start", {...}) with the path before, ("search", {...}) after every generation, with "candidate" where the
    best is another, and ("testing", None).
    """
    if hasattr(os, "nice"):
        os.nice(5)  # the page goes first
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # a candidate may leave a universe: that is what its cost says
            return _searched(task, report)
    except MemoryError:
        raise TuningError("the search needs more memory than there is: fewer runs").about("runs") from None


def _searched(task: TuneTask, report: Report) -> dict[str, Any]:
    scenarios = task.chosen()
    space = reached(task.space(), scenarios, range(TUNING, TUNING + task.runs))
    about = {"parameters": len(space.parameters), "courses": [_course(s) for s in scenarios]}
    report("start", about | {"paths": [_path(s, space.law) for s in scenarios]})
    teller = _Teller(task, space, scenarios, report)
    threads = max(1, (os.cpu_count() or 2) - 1)
    tuned = tune(
        space,
        scenarios,
        specification=task.law,
        runs=task.runs,
        evaluations=task.evaluations,
        seed=task.seed,
        engine=task.engine,
        cost=task.cost(),
        folder=Path(task.place),
        threads=threads,
        progress=teller.tell,
    )
    if tuned.evaluated.best != teller.told:
        teller.tell(tuned.evaluated, last=True)
    report("testing", None)
    words = "no candidate was better than what it began with"
    if tuned.evaluated.best > 0:
        words = compared(tuned, scenarios, seeds=_UNSEEN, threads=threads)[0].sentence()
    return {"sentence": words, "stopped": tuned.evaluations < task.evaluations, "gains": teller.gains(tuned.evaluated)}


class _Teller:
    """Tells the page of a search, at most every _OFTEN seconds of a candidate."""

    def __init__(self, task: TuneTask, space: LawSpace, scenarios: list[Scenario], report: Report) -> None:
        self.task, self.space, self.scenarios, self.report = task, space, scenarios, report
        self.told, self.written, self.last = 0, -1, -math.inf
        self.best: dict[str, Any] = {}

    def tell(self, found: Evaluations, last: bool = False) -> bool:
        """Tell of a generation, of the ``last`` with its best; whether the search is to end."""
        news: dict[str, Any] = {"evaluations": len(found), "curve": _curve(found.costs)}
        if found.best != self.written:
            self.written, self.best = found.best, self._candidate(found)
            write_json(Path(self.task.place) / _BEST, self.best)
        if found.best != self.told and (last or time.monotonic() - self.last >= _OFTEN):
            law = self.space.made(found.values[found.best])
            self.told, paths = found.best, [_path(scenario, law) for scenario in self.scenarios]
            self.last = time.monotonic()
            news["candidate"] = self.best | {"paths": paths}
        return not self.report("search", news)

    def gains(self, found: Evaluations) -> dict[str, float]:
        """The gains of the best, which no rule base holds."""
        return self.space.gains_at(found.values[found.best])

    def _candidate(self, found: Evaluations) -> dict[str, Any]:
        systems = self.space.systems_of(found.values[found.best])
        system = next(iter(systems.values())) if systems else self.task.begun()
        costs = {"cost": float(found.costs[found.best]), "before": float(found.costs[0])}
        return {"system": format_fis(system), **costs, "evaluations": len(found), "gains": self.gains(found)}


def _curve(costs: np.ndarray) -> list[list[float]]:
    """The best so far: [evaluation, cost] where it became less, and at the end."""
    best = np.minimum.accumulate(costs)
    places = [0, *(np.flatnonzero(np.diff(best) < 0) + 1).tolist(), len(best) - 1]
    return [[place + 1, float(best[place])] for place in places]


def _course(scenario: Scenario) -> dict[str, Any]:
    """What is to be driven: the name, and the path x, y [m] of each robot."""
    paths = [_thinned(path.table[0], path.table[1]) for path in scenario.trajectory.paths]
    return {"name": scenario.name, "title": scenario.title or scenario.name, "paths": paths}


def _path(scenario: Scenario, law: Law[Any]) -> list[list[list[float | None]]]:
    """The path x, y [m] of each robot with the first seed that is tuned on; nothing of a law that cannot drive."""
    try:
        run = simulate(scenario, law, (TUNING,))
    except InputError:
        return []
    return [_thinned(x, y) for x, y in zip(run["x"][0], run["y"][0], strict=True)]


def _thinned(x: np.ndarray, y: np.ndarray) -> list[list[float | None]]:
    kept = evenly(len(x), _POINTS)
    return [rounded_list(x[kept]), rounded_list(y[kept])]
