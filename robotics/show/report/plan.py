"""Studies as data: scenarios × controllers × seeds with claims of their own, read from a TOML file.

All that is wrong with a file is a StudyError that names the file, the line, the key, the value and what is accepted.
"""

import copy
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain
from pathlib import Path
from typing import Any, NamedTuple

from fuzzy.errors import InputError
from fuzzy.naming import check_known, expected
from fuzzy.quantity import check_quantities, described, whole
from fuzzy.shell.progress import Begin
from robotics.laws.catalogue import located, make_controller, presets
from robotics.laws.law import Law, check_needs
from robotics.laws.specification import Specification
from robotics.measures.evidence import FEWEST_RUNS
from robotics.measures.own import installed_metrics, metric_at
from robotics.measures.quantities import MEASURED_QUANTITIES
from robotics.measures.registry import ALL_METRICS, metrics_of, named_by_scenarios, own_metrics
from robotics.measures.tracking import Metric
from robotics.show.report.claims import ALL_SCENARIOS, NAME_LISTS, Condition, Statement, statements
from robotics.show.report.questions import QUESTIONS, question_called
from robotics.simulation.scenario.description import Scenario
from robotics.simulation.scenario.reading import load_scenario
from robotics.simulation.scenario.robots import robot_tables
from robotics.studies.axes import (
    AXIS_VALUES,
    SWEEP_KEYS,
    StudyAxis,
    check_design,
    dotted,
    scenario_source,
    study_axes,
    sweep_as_study,
)
from robotics.studies.design import Axis, Method, Point, ScenarioDesign, assign, design_points
from robotics.studies.keptcomparison import Case
from robotics.studies.tuning.file import StudyTuning
from robotics.studies.tuning.space import NothingMovesError
from robotics.tables.build import Builder, Keys
from robotics.tables.files import TomlFile, TomlFiles
from robotics.tables.text import line_of, reading


class StudyError(InputError):
    """A study that cannot be run. The message names the file, line, key and what is accepted."""


class ScenarioGroup(NamedTuple):
    """Scenarios of one kind that the same controllers drive: what one comparison can hold."""

    kind: str
    scenarios: tuple[Scenario, ...]
    laws: Mapping[str, Law[Any] | str]  # the controllers, or their specifications, by their names
    skipped: Mapping[str, tuple[str, ...]]  # by scenario: a sentence for each controller that does not drive there


@dataclass(frozen=True, kw_only=True)
class StudyPlan:
    """A study before it is run.

    Files are relative to ``folder``. A controller of a file, such as ``mylaw.py:MyLaw``, is called as it is written,
    unless ``names`` gives it a shorter name.

    Attributes:
        name: What it is called: its file's name.
        found: The specifications of tuned controllers, by the names of the published ones.
        folder: Where files are looked for.
        file: The file, in messages and in the record of what was run.
        content: The text of the file.
        own_metrics: The user's own metrics, by name.
        metric_files: Their files as they are written, by those names.

    Raises:
        StudyError: A study that cannot be run.
    """

    name: str
    title: str = described("The title of the report.", "", example="Two laws on my paths")
    author: str = described("Who makes the study; stands below the title.", "", example="A. Author")
    text: str = described(
        "What the study asks, for the head of the report; blank lines part its paragraphs.", "", example="What I ask."
    )
    scenarios: tuple[str, ...] = described(
        "Names of scenarios, or .toml files, relative to this file.", example=["lyapunov-sine"]
    )
    controllers: tuple[str, ...] = described(
        "The controllers: names with gains, such as csm:k=0.3, file.py:Law or file.fis, relative to this file.",
        example=["fuzzy", "lyapunov"],
    )
    names: tuple[str, ...] = described(
        "What the controllers are called, in their order. Default: as written.", (), example=["rules", "rival"]
    )
    seeds: int = whole(FEWEST_RUNS, least=1, most=100_000, doc="Number of seeds; a verdict on a claim needs 20.")
    first_seed: int = whole(0, least=0, most=10**15, doc="The first seed.")
    metrics: tuple[str, ...] = described(
        "Metrics that come first in tables; the first one says who leads. A name, or file.py:function of your own.",
        (),
        example=["max_cross_track_m"],
    )
    claims: tuple[Statement, ...] = described("The claims, tables [[claims]].", ())
    conditions: Mapping[str, Mapping[str, Any]] = described(
        "Sets of keys of the scenarios' files, by their dotted names: every scenario is driven under each.",
        default_factory=dict,
    )
    axes: tuple[StudyAxis, ...] = described("What is varied: every scenario is driven at every point.", ())
    method: Method = described(
        "How points are chosen: all combinations of the axes' values (grid), at random, or as a Latin hypercube.",
        "grid",
    )
    samples: int | None = whole(None, least=1, doc="How many points a random design has.", example=50)
    seed: int | None = whole(None, least=0, doc="The seed of a random design; left out: 0.", example=0)
    chunk: int = whole(100, least=1, doc="How many runs are computed and written at a time, at most.")
    tune: StudyTuning | None = described("Controllers are tuned first, and take part in both forms.", None)
    questions: tuple[str, ...] = described(
        f"Questions to the table of all runs: of {', '.join(QUESTIONS)}, or file.py:function of your own.",
        (),
        example=["leads", "rates"],
    )
    chapters: str = described(
        "Python that makes chapters after the comparison: package.module:function.",
        "",
        example="mypackage.mine:chapters",
    )
    save_runs: bool = described("true: save the runs of the comparison in the folder runs of the results.", False)
    out: str = described(
        "The folder of the results, relative to this file. Default: out/NAME where you are.", "", example="results"
    )
    found: Mapping[str, str] = field(default_factory=dict)
    folder: Path = field(default=Path(), compare=False)
    file: str = field(default="", compare=False)
    content: str = field(default="", compare=False, repr=False)
    own_metrics: dict[str, Metric] = field(init=False, default_factory=dict, repr=False, compare=False)
    metric_files: dict[str, str] = field(init=False, default_factory=dict, repr=False, compare=False)

    def __post_init__(self) -> None:
        check_quantities(self, StudyError)
        _ = self.laws
        _refuse_twice("metrics", self.shown_metrics)
        for name, text in named_by_scenarios(self.settings).items():
            if name not in self.own_metrics:
                self._metric(text, ("scenarios",))
        for i, claim in enumerate(self.claims):
            for j, condition in enumerate(claim.parts):
                self._check(condition, ("claims", i) if claim.direct else ("claims", i, "parts", j))
        _refuse_twice("claims", [claim.name for claim in self.claims])
        check_design(self.method, self.samples, self.seed)
        _ = self.points
        _refuse_twice("questions", self.questions)
        for i, name in enumerate(self.questions):
            try:
                question_called(name, self.folder)
            except InputError as error:
                raise StudyError(f"questions: {error}").about("questions", i) from None
        _ = self.cases

    @property
    def row(self) -> range:
        """The seeds that it runs with."""
        return range(self.first_seed, self.first_seed + self.seeds)

    @property
    def paragraphs(self) -> tuple[str, ...]:
        """The text in paragraphs, one line each."""
        return tuple(" ".join(part.split()) for part in self.text.split("\n\n") if part.strip())

    @cached_property
    def groups(self) -> tuple[ScenarioGroup, ...]:
        """The scenarios by their kind and by who drives them, in the order of the first of each."""
        found: dict[tuple[Any, ...], list[tuple[Scenario, dict[str, str]]]] = {}
        made = {name: make_controller(law) for name, law in self.laws.items()}
        drives = dict.fromkeys(made, False)
        for scenario in self.settings:
            refused = {name: why for name, law in made.items() if (why := _refusal(scenario, law))}
            if len(refused) == len(made):
                why = next(iter(refused.values()))
                raise StudyError(f"no controller of the study drives {scenario.name}: {why}").about("scenarios")
            able = tuple(name for name in made if name not in refused)
            drives |= dict.fromkeys(able, True)
            found.setdefault((scenario.kind, able), []).append((scenario, refused))
        for i, (name, any_) in enumerate(drives.items()):
            if not any_:
                why = _refusal(self.settings[0], made[name])
                raise StudyError(f"{name} drives no scenario of the study: {why}").about("controllers", i)
        return tuple(
            ScenarioGroup(
                kind,
                tuple(scenario for scenario, _ in rows),
                {name: self.laws[name] for name in able},
                {s.name: tuple(f"{n} does not drive here: {why}" for n, why in refused.items()) for s, refused in rows},
            )
            for (kind, able), rows in found.items()
        )

    @cached_property
    def cases(self) -> tuple[tuple[Case, ...], ...]:
        """The scenarios of each group under every condition, with the points of the design."""
        return tuple(tuple(self._cases(group)) for group in self.groups)

    def _cases(self, group: ScenarioGroup) -> Iterator[Case]:
        for scenario in group.scenarios:
            place = self.settings.index(scenario)
            for condition, changes in self.conditions.items() or [("", {})]:
                name = _case_name(scenario.name, condition)
                told: dict[str, Any] = {"plain": scenario.name, "condition": condition, "chunk": self.chunk}
                if not (changes or self.axes):
                    yield Case(replace(scenario, name=name) if condition else scenario, group.laws, **told)
                    continue
                source, table, _, home = scenario_source(self.scenarios[place], self.folder)
                design = ScenarioDesign(
                    scenario=name,
                    table=robot_tables(copy.deepcopy(table)),
                    home=home,
                    file=self.file,
                    line=line_of(self.content, ("controllers",)),
                )
                for key, value in changes.items():
                    try:
                        assign(design.table, key.split("."), value, key)
                        changed = design.scenario_at(())
                    except InputError as error:
                        about = StudyError(f"conditions: {condition}: {source}: {error}")
                        raise about.about("conditions", condition, key) from None
                if not changes:
                    changed = design.scenario_at(())
                varied = replace(design, axes=self.axis_list) if self.axes else None
                yield Case(changed, group.laws, **told, design=varied, points=self.points)

    def case_names(self, scenario: str) -> list[str]:
        """What a ``scenario`` is called under each condition."""
        return [_case_name(scenario, condition) for condition in self.conditions or [""]]

    def check_points(self, begin: Begin) -> None:
        """Build the scenarios and the controllers of every point, with a bar that ``begin`` starts.

        Raises SweepError where one is refused.
        """
        designs = [(case, case.design) for case in chain(*self.cases) if case.design is not None]
        if not designs:
            return
        advance = begin("checking every point", sum(len(case.points) for case, _ in designs))
        for case, design in designs:
            design.check(case.points, map(str, case.laws.values()), advance)

    @property
    def runs(self) -> int:
        """The number of runs that it makes."""
        return sum(len(case.laws) * len(case.points) * self.seeds for case in chain(*self.cases))

    @property
    def rows(self) -> int:
        """The number of rows of its table."""
        each = ((case, len(case.scenario.robots)) for case in chain(*self.cases))
        return sum(robots * len(case.laws) * len(case.points) * self.seeds for case, robots in each)

    @property
    def metrics_located(self) -> dict[str, str]:
        """The user's own metrics by name, as specifications seen from the current folder."""
        files = {name: str(Specification.of(text).located(self.folder)) for name, text in self.metric_files.items()}
        return {name: files.get(name, name) for name in self.own_metrics}

    def metric_called(self, metric: str) -> str:
        """What tables call a ``metric`` of a claim."""
        return self._metric(metric, ())

    @property
    def quantities(self) -> dict[tuple[str, str], list[tuple[str, str]]]:
        """What claims ask for, by scenario and controller: what is measured, and whose number of a run it is."""
        found: dict[tuple[str, str], list[tuple[str, str]]] = {}
        for condition in (part for claim in self.claims for part in claim.parts):
            asked = self.metric_called(condition.metric), condition.robots
            for scenario in self.scenarios_of(condition):
                for case in self.case_names(scenario.name):
                    for _, law in condition.named:
                        found.setdefault((case, self.law_called(law)), []).append(asked)
        return found

    def scenarios_of(self, condition: Condition) -> list[Scenario]:
        """The scenarios on which ``condition``, a part of a claim, is measured."""
        pairs = zip(self.settings, self.scenarios, strict=True)
        return [s for s, text in pairs if {ALL_SCENARIOS, s.name, text} & {*condition.on}]

    def law_called(self, name: str) -> str:
        """The controller that a claim calls ``name``: its name or its specification."""
        if name in self.laws or name not in self.controllers:
            return name
        return list(self.laws)[self.controllers.index(name)]

    @cached_property
    def settings(self) -> tuple[Scenario, ...]:
        """The scenarios, read."""
        if not self.scenarios:
            raise StudyError('scenarios must name at least one, such as ["lyapunov-sine", "mine.toml"]').about(
                "scenarios"
            )
        found: dict[str, Scenario] = {}
        for i, text in enumerate(self.scenarios):
            try:
                made = load_scenario(text, self.folder)
            except InputError as error:
                raise StudyError(f"scenarios: {error}").about("scenarios", i) from None
            if made.name in found:
                raise StudyError(f"scenarios: {made.name!r} is given twice").about("scenarios", i)
            found[made.name] = made
        return tuple(found.values())

    @cached_property
    def laws(self) -> Mapping[str, str]:
        """The specifications of the controllers, located, by name."""
        if not self.controllers:
            raise StudyError('controllers must name at least one, such as ["fuzzy", "csm:k=0.3"]').about("controllers")
        _refuse_twice("controllers", self.controllers)
        laws = []
        for i, text in enumerate(self.controllers):
            laws.append(located(text, self.folder))
            try:
                make_controller(laws[-1])
            except InputError as error:
                raise StudyError(f"controllers: {error}").about("controllers", i) from None
        names = self.names or self.controllers
        if len(names) != len(laws):
            what = f"names must be as many as controllers, {len(laws)}, in their order; got {len(names)}"
            raise StudyError(what).about("names")
        _refuse_twice("names", names)
        for name, text in zip(names, self.controllers, strict=True):
            if name != text and (name in presets() or not name.strip()):
                why = "is the name of another controller" if name.strip() else "is empty"
                raise StudyError(f"names: {name!r}, for {text}, {why}; choose another").about("names")
        published = dict(zip(names, laws, strict=True))
        tuned = {tuned_name(n): self.found.get(n, published[n]) for n in self._tunable(published)}
        if twice := {*published} & {*tuned}:
            raise StudyError(f"names: {min(twice)!r} is what a tuned controller will be called").about("names")
        return published | tuned

    def _tunable(self, published: Mapping[str, str]) -> list[str]:
        """The names of the controllers that are tuned."""
        if self.tune is None:
            return []
        for i, name in enumerate(self.tune.controllers):
            check_known(name, published, "controller of the study", StudyError, "tune", "controllers", i)
        for i, name in enumerate(self.tune.on):
            if name not in {*self.scenarios, *(s.name for s in self.settings)}:
                known = [s.name for s in self.settings]
                raise StudyError(expected(name, known, "scenario of the study")).about("tune", "on", i)
        moving, found = self.tune.file(self.folder), []
        for name in self.tune.controllers or published:
            try:
                moving.space(make_controller(published[name]))
            except NothingMovesError as error:
                if self.tune.controllers:
                    raise StudyError(f"tune: {name}: {error}").about("tune", "controllers") from None
            else:
                found.append(name)
        return found

    @property
    def tuned(self) -> list[str]:
        """The names of the controllers that are tuned."""
        return [name for name in self.laws if tuned_name(name) in self.laws]

    @property
    def written(self) -> dict[str, str]:
        """The controllers as the file has them, by their names."""
        published = dict(zip(self.laws, self.controllers, strict=False))
        return published | {tuned_name(name): f"{published[name]}, tuned" for name in self.tuned}

    def tuned_on(self, name: str) -> list[Scenario]:
        """The scenarios on which the controller called ``name`` is tuned, of those that it drives."""
        wanted = {*self.tune.on} if self.tune is not None else set()
        pairs = zip(self.settings, self.scenarios, strict=True)
        law = make_controller(self.laws[name])
        return [s for s, text in pairs if (not wanted or wanted & {s.name, text}) and not _refusal(s, law)]

    @cached_property
    def shown_metrics(self) -> tuple[str, ...]:
        """The metrics that come first, by their names in tables."""
        return tuple(self._metric(text, ("metrics",)) for text in self.metrics)

    @cached_property
    def axis_list(self) -> tuple[Axis, ...]:
        """The axes, with their values."""
        return study_axes(self.axes, self.method, self.content)

    @cached_property
    def points(self) -> tuple[Point, ...]:
        """The points of the design."""
        design = (self.axis_list, self.method, self.samples or 0, self.seed or 0)
        return design_points(*design, self.file) if self.axes else ((),)

    def _metric(self, text: str, keys: Keys) -> str:
        """The name of a metric in tables; one of the user's own is kept among these."""
        own, about = self.own_metrics, Specification.of(text)
        if about.file.endswith(".py"):
            try:
                name, found = metric_at(str(about.located(self.folder)))
                own_metrics({name: found})
            except InputError as error:
                raise StudyError(str(error)).about(*keys) from None
            if self.metric_files.setdefault(name, text) != text:
                what = f"{text} and {self.metric_files[name]} would both be called {name} in tables"
                raise StudyError(f"{what}; rename one").about(*keys)
            if name in MEASURED_QUANTITIES:
                raise StudyError(f"{text}: {name} is the name of a metric of the package").about(*keys)
            own.setdefault(name, found)
            return name
        if text in installed_metrics()[0]:
            own.setdefault(text, installed_metrics()[0][text])
            return text
        if text not in MEASURED_QUANTITIES and text not in own:
            what = expected(text, [*own, *MEASURED_QUANTITIES], "metric")
            raise StudyError(f"{what}; or a function of your own, file.py:function").about(*keys)
        return text

    def _check(self, condition: Condition, keys: Keys) -> None:
        """Refuse a part of a claim about what the study does not run or measure."""
        metric = self._metric(condition.metric, (*keys, "metric"))
        known = [*dict.fromkeys([*(s.name for s in self.settings), *self.scenarios])]
        for name in condition.on:
            if name != ALL_SCENARIOS and name not in known:
                raise StudyError(f"{expected(name, known, 'scenario of the study')}, or {ALL_SCENARIOS!r}").about(
                    *keys, "on"
                )
        if not condition.of:
            raise StudyError(f"whose {metric}? It needs of = NAME, one of {', '.join(self.laws)}").about(*keys, "of")
        if condition.rivals and not condition.against:
            raise StudyError(
                f"{condition.relation} compares to other controllers: it needs against = NAME, or several of "
                f"{', '.join(self.laws)}"
            ).about(*keys, condition.relation)
        for key, name in condition.named:
            check_known(self.law_called(name), self.laws, "controller of the study", StudyError, *keys, key)
        if self.law_called(condition.of) in map(self.law_called, condition.against):
            raise StudyError(f"{condition.of} is compared to itself").about(*keys, "against")
        for scenario in self.scenarios_of(condition):
            self._check_on(scenario, condition, metric, keys)

    def _check_on(self, scenario: Scenario, condition: Condition, metric: str, keys: Keys) -> None:
        # An emergency rule belongs to the law, which says itself whether it has one.
        here = metrics_of(scenario.kind, scenario.setting.has_others, guard=True)
        if metric in ALL_METRICS and metric not in here:
            text = f"{metric} is not measured on {scenario.name}, which is of kind {scenario.kind!r}"
            raise StudyError(f"{text}; measured there: {', '.join(here)}").about(*keys, "metric")
        count = len(scenario.robots)
        if condition.robot is not None and condition.robot > count:
            text = f"robot must be one of {scenario.name}, 1 to {count}; got {condition.robot}"
            raise StudyError(text).about(*keys, "robot")
        for key, name in condition.named:
            if why := _refusal(scenario, make_controller(self.laws[self.law_called(name)])):
                raise StudyError(f"{name} does not drive {scenario.name}: {why}").about(*keys, key)


_FILES = TomlFiles("studies", "study", StudyError)
_SWEEPS = TomlFiles("sweeps", "sweep", StudyError)


def study_names() -> list[str]:
    """The names of the studies that come with the package."""
    return _FILES.names()


def load_study(name: str | Path) -> StudyPlan:
    """Read a study.

    Args:
        name: One of :func:`study_names`, or a ``.toml`` file.

    Returns:
        The study before it is run.

    Raises:
        StudyError: No such study, or a file that makes none; the message names file, line and key.
    """
    found = _FILES.find(name)
    return parse_study(found.text, found.name, found.file, found.folder)


def load_sweep(name: str | Path) -> StudyPlan:
    """Read the packaged sweep of that name, or a ``.toml`` file of a sweep or study. Raises StudyError."""
    found = _SWEEPS.find(name)
    return parse_study(found.text, found.name, found.file, found.folder)


def parse_study(text: str, name: str = "study", file: str = "<text>", folder: Path = Path()) -> StudyPlan:
    """Read the study, or the sweep, that a TOML text describes. Raises StudyError.

    Args:
        text: The TOML text.
        name: The study's name.
        file: The file's name in messages.
        folder: The folder to which paths in it are relative.
    """
    with reading(text, file, StudyError) as table:
        return study_from_table(table, TomlFile(text, name, file, folder, Path(file)))


def study_from_table(table: Mapping[str, Any], about: TomlFile) -> StudyPlan:
    """Make the study, or the sweep, of the ``table`` of a file, which is left as it is.

    Raises an InputError whose ``at`` holds the keys of the table that it is about.
    """
    rest = dict(table)
    given: dict[str, Any] = {"claims": statements(rest.pop("claims", []), ("claims",), StudyError)}
    if SWEEP_KEYS & {*rest} and "scenarios" not in rest:
        given["axes"] = sweep_as_study(rest, about.folder)
    given |= {"name": about.name, "folder": about.folder, "file": about.file, "content": about.text}
    builder = Builder(StudyError, {**NAME_LISTS, **AXIS_VALUES, ConditionsByName: _conditions})
    made = builder.build(StudyPlan, rest, (), ("claims", *SWEEP_KEYS), **given)
    assert isinstance(made, StudyPlan)
    return made


ConditionsByName = Mapping[str, Mapping[str, Any]]  # the type of such a field


def _conditions(value: Any, keys: Keys) -> dict[str, dict[str, Any]]:
    builder, found = Builder(StudyError), dict[str, dict[str, Any]]()
    for name, changes in builder.table(value, keys).items():
        found[name] = dict(dotted(builder.table(changes, (*keys, name))))
    return found


def tuned_name(name: str) -> str:
    """What the tuned form of a controller is called."""
    return f"{name} (tuned)"


def _case_name(scenario: str, condition: str) -> str:
    return f"{scenario}, {condition}" if condition else scenario


def _refusal(scenario: Scenario, law: Law[Any]) -> str:
    """Why ``law`` cannot drive the scenario; "" if it can."""
    try:
        check_needs(scenario.setting, law)
        law.init(scenario.setting, 1)
    except InputError as error:
        return str(error)
    return ""


def _refuse_twice(key: str, names: Any) -> None:
    for name in names:
        if list(names).count(name) > 1:
            raise StudyError(f"{key}: {name!r} is given twice").about(key)
