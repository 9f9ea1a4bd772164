"""A whole study in a folder: comparisons, claims, chapters that may be added, and the report."""

import json
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field, replace
from functools import partial
from importlib import import_module
from pathlib import Path
from shutil import rmtree
from types import MappingProxyType
from typing import Any, cast

import numpy as np
import pandas as pd
from threadpoolctl import threadpool_limits

from fuzzy.errors import InputError
from fuzzy.files.atomic import write_json
from fuzzy.files.claim import claimed
from fuzzy.files.table import write_frame
from fuzzy.shell.progress import Begin, Mover, unwatched
from fuzzy.tuning.search import Evaluations
from fuzzy.words import counted, listed
from robotics.laws.catalogue import (
    OwnLaws,
    chosen_laws,
    files_of,
    fis_files_named,
    gains_of,
    make_controller,
    named_laws,
    shown_gain,
)
from robotics.laws.law import Law
from robotics.laws.specification import Specification
from robotics.measures.evidence import FEWEST_RUNS, Part
from robotics.measures.own import NO_METRICS, OwnMetrics
from robotics.measures.quantities import quantity_called
from robotics.measures.registry import own_metrics, with_named
from robotics.show.report.chapter import Chapter, Claim, Front, judged_together
from robotics.show.report.claims import Condition, Measure, decided, run_name
from robotics.show.report.page import Heading, draw_sections, figure_count, write_report
from robotics.show.report.plan import StudyError, StudyPlan
from robotics.show.report.questions import Answer, answer_chapters, asked, described_table
from robotics.show.report.summarytable import leading_metric
from robotics.simulation.scenario.description import Scenario
from robotics.simulation.scenario.reading import scenario_file
from robotics.simulation.scenario.robots import robot_files
from robotics.studies.chunks import discard_chunks
from robotics.studies.comparison import Comparison, RunsAgain, check_comparison, column_titles, contact_runs, summarise
from robotics.studies.design import SweepError
from robotics.studies.executors import WorkerError, Workers, uninterrupted, workers_at
from robotics.studies.keptcomparison import PIECES_FOLDER, Case, KeptComparisons, TableCounts
from robotics.studies.tuning.results import write_tuned
from robotics.studies.tuning.tune import tune
from robotics.studies.versions import digest_of, versions
from robotics.tables.text import parse_table

# Makes chapters beside the comparison, from a function that begins a progress bar, the folder, the first seed and
# whether pictures are wanted. Entering it gives a function that waits for the chapters; leaving it stops the work.
MakeChapters = Callable[[Begin, Path, int, bool], AbstractContextManager[Callable[[], list[Chapter]]]]
_RESULTS = ("results.csv", "columns.csv", "summary.csv", "claims.csv", "evidence.csv", "answers.json", "report.html")
MakeFront = Callable[[Begin, Path], Front]  # what opens the report, from a progress display and the folder


@dataclass(frozen=True, eq=False)
class Study:
    """The outcome of a study.

    Attributes:
        comparisons: One for the scenarios of a kind that the same controllers drive.
        summary: Of :func:`robotics.studies.comparison.summarise`.
        claims: The verdicts on the study's claims.
        shown: The file to open: the report, or the table of results.
        files: All files that were written, relative to the folder.
        first: Metrics that come before the others.
        skipped: A sentence for each controller and scenario that it does not drive.
        answers: The answers to the study's questions, by their names.
    """

    comparisons: tuple[Comparison, ...]
    summary: pd.DataFrame
    claims: list[Claim]
    shown: Path
    files: list[str]
    first: tuple[str, ...] = ()
    skipped: tuple[str, ...] = ()
    answers: Mapping[str, Answer] = field(default_factory=dict)

    @property
    def comparison(self) -> Comparison:
        """The comparison, where there is only one; otherwise the first."""
        return self.comparisons[0]

    @property
    def divergences(self) -> list[str]:
        """A sentence for every robot that was stopped."""
        return [line for comparison in self.comparisons for line in comparison.divergences]


def write_study(
    folder: Path,
    scenarios: Sequence[Scenario],
    controllers: OwnLaws,
    seeds: Sequence[int],
    *,
    begin: Begin,
    metrics: OwnMetrics = NO_METRICS,
    chapters: MakeChapters | None = None,
    front: MakeFront | None = None,
    report: bool = True,
    command: str | None = None,
    kept: Callable[[int], None] = lambda rows: None,
    fresh: bool = False,
    resumed: Callable[[int, int], None] = lambda done, pieces: None,
) -> Study:
    """Compare controllers on scenarios, and write all results into a folder.

    The files are configuration.json, results.csv (one row for each seed and robot), columns.csv (what its columns are),
    summary.csv, claims.csv and evidence.csv if ``chapters`` are made, and with ``report`` also report.html and
    figures/. What is done is kept in the folder until all is written; after a stop the same work goes on from there,
    with the same bytes in the end.

    Args:
        folder: The folder of the results.
        scenarios: Scenarios of one kind.
        controllers: Controllers, as :func:`robotics.studies.comparison.compare` takes them.
        seeds: The seeds.
        begin: Starts a bar of a progress display, by its text and total.
        metrics: The user's own metrics, as :func:`robotics.studies.comparison.compare` takes them.
        chapters: Makes chapters beside the comparison.
        front: Makes what opens the report, such as an entry point of the group fuzzyfleet.fronts.
        report: Whether figures and the report are made.
        command: The command line that the report names.
        kept: Called with the number of rows that are written, also where the work is interrupted.
        fresh: Whether to discard what the folder has of a study that was interrupted.
        resumed: Called with how many pieces are there already, and of how many.

    Raises ComparisonError, ControllerError, MetricError, StudyError where the folder holds another study that was
    interrupted, and OSError.
    """
    check_comparison(scenarios, controllers, metrics)
    metrics = with_named(scenarios, metrics)
    laws, own = dict(named_laws(controllers)), list(metrics.values() if isinstance(metrics, Mapping) else metrics)
    configuration = {
        "scenarios": [scenario.name for scenario in scenarios],
        "controllers": {name: gains_of(law) for name, law in chosen_laws(controllers).items()},
        "metrics": [*own_metrics(metrics)],
        "files_sha256": {name: digest_of(file) for name, file in sorted(_files_named(laws, own).items())},
        "seeds": list(seeds),
        "versions": versions(),
    }
    named = all(isinstance(each, str) for each in (*laws.values(), *own))
    cases = [Case(scenario, laws) for scenario in scenarios]
    work = _work(folder, configuration, [cases], seeds, metrics, report, named=named)
    watch = _Watch(begin, kept, resumed)
    return _written(work, configuration, watch, chapters, front, report, command, fresh=fresh)


def run_study(
    plan: StudyPlan,
    out: str | Path | None = None,
    *,
    jobs: int = 1,
    dask: str | None = None,
    report: bool = True,
    begin: Begin = unwatched,
    chapters: MakeChapters | None = None,
    front: MakeFront | None = None,
    command: str | None = None,
    kept: Callable[[int], None] = lambda rows: None,
    fresh: bool = False,
    resumed: Callable[[int, int], None] = lambda done, pieces: None,
) -> Study:
    """Run a study: scenarios × controllers × seeds, its claims judged, all results in a folder.

    The files are those of :func:`write_study`, claims.csv and evidence.csv where the study has claims; the report has
    the study's title and text, and the claims with their verdicts before the comparison. A claim is judged by
    :mod:`robotics.measures.evidence`, and told only where at least 20 runs stand behind it.

    Args:
        plan: The study, such as :func:`robotics.show.report.plan.load_study` reads it.
        out: The folder of the results. Default: the plan's.
        jobs: Number of processes that simulate; the numbers do not depend on it.
        dask: The address of a Dask scheduler whose workers simulate instead, such as ``tcp://127.0.0.1:8786``.
        report: Whether figures and the report are made.
        begin: Starts a bar of a progress display, by its text and total. Default: none is shown.
        chapters: Makes chapters beside the comparison. Default: those that the plan names.
        front: Makes what opens the report, such as an entry point of the group fuzzyfleet.fronts.
        command: The command line that the report names.
        kept: Called with the number of rows that are written, also where the work is interrupted.
        fresh: Whether to discard what the folder has of a study that was interrupted.
        resumed: Called with how many pieces are there already, and of how many.

    Returns:
        The comparisons, the summary, the verdicts and the files.

    Raises:
        StudyError: A study that cannot be run, or a folder that holds another one, which was interrupted.
        WorkerError: Workers have died, or cannot be reached; what is done is kept.
        MetricError: A metric cannot be used, or fails.
        ControllerError: A controller that is unknown, or cannot drive the scenario.
        OSError: Files cannot be written.
    """
    folder = Path(out) if out is not None else default_folder(plan)
    chapters = chapters or (_chapters_named(plan) if plan.chapters else None)
    command = command or f"robotics study {plan.file or plan.name} --seeds {plan.seeds}"
    plan = _tuned(plan, folder, begin, fresh) if plan.tune is not None else plan
    watch, configuration = _Watch(begin, kept, resumed), _configuration(plan)
    plan.check_points(begin)
    with workers_at(jobs if jobs > 1 else None, dask, ["robotics.studies.keptcomparison"]) as workers:
        work = _work(
            folder,
            configuration,
            plan.cases,
            plan.row,
            plan.own_metrics,
            report or plan.save_runs,
            quantities=plan.quantities,
            metric_files=plan.metrics_located,
            workers=workers,
        )
        return _written(work, configuration, watch, chapters, front, report, command, plan, fresh=fresh)


@dataclass(frozen=True)
class TableOutcome:
    """A table that was written: its file, what it holds, how many chunks there are and were computed this time."""

    results: Path
    counts: TableCounts
    chunks: int
    computed: int


def run_table(
    plan: StudyPlan,
    folder: Path,
    workers: Workers | None = None,
    *,
    begin: Begin = unwatched,
    fresh: bool = False,
    resumed: Callable[[int, int], None] = lambda done, pieces: None,
    stopped: Callable[[int, int], None] = lambda done, pieces: None,
) -> TableOutcome:
    """Run a study into one table, ``folder/results.parquet``, a row for each run and robot, and nothing else.

    It is for runs in any number: they are read back chunk by chunk. The chunks stay in the folder, where the same work
    goes on after a stop, and after a run that failed.

    Args:
        plan: The study; of its claims, questions and pictures nothing becomes.
        folder: The folder of the results.
        workers: Who simulates, by default this process.
        begin: Starts a bar of a progress display, by its text and total. Default: none is shown.
        fresh: Whether to discard what the folder has of another sweep.
        resumed: Called with how many chunks are there already, and of how many.
        stopped: Likewise, called where Ctrl-C ends the work.

    Raises SweepError where the folder holds another sweep, a point is refused or a run fails; what was written stays.
    """
    made = _work(
        folder, _configuration(plan), plan.cases, plan.row, plan.own_metrics, False,
        metric_files=plan.metrics_located, workers=workers,
    )  # fmt: skip
    work, results = replace(made, kind="sweep", fault=SweepError), folder / "results.parquet"

    def prepare() -> None:
        plan.check_points(begin)
        results.unlink(missing_ok=True)
        discard_chunks(work.folder)

    with claimed(work.folder, "plan.json", work.about, prepare, kind="sweep", fault=SweepError, fresh=fresh):
        try:
            computed = work.compute(begin, resumed)
            counts = work.write_parquet(results)
        except KeyboardInterrupt:
            stopped(*work.landed())
            raise
    return TableOutcome(results, counts, work.ends[-1], computed)


def _tuned(plan: StudyPlan, folder: Path, begin: Begin, fresh: bool) -> StudyPlan:
    """The study with its controllers tuned, each in a folder of its own, where its search goes on after a stop."""
    assert plan.tune is not None
    asked, about, found = plan.tune, plan.tune.file(plan.folder), {}
    for place, name in enumerate(plan.tuned, start=1):
        law, moved = plan.laws[name], Mover(begin(f"tuning {name}", asked.evaluations))
        where = folder / "tuned" / f"{place}-{re.sub(r'[^A-Za-z0-9.=-]+', '-', name)}"
        where.mkdir(parents=True, exist_ok=True)
        tuned = tune(
            about.space(make_controller(law)),
            plan.tuned_on(name),
            specification=law,
            runs=asked.runs,
            evaluations=asked.evaluations,
            seed=asked.seed,
            engine=asked.engine,
            cost=about.made_cost(),
            folder=where,
            fresh=fresh,
            progress=partial(_tell, moved),
        )
        found[name] = write_tuned(tuned, law, where)
    return replace(plan, found=found)


def _tell(moved: Mover, tried: Evaluations) -> None:
    moved(len(tried))


def default_folder(plan: StudyPlan) -> Path:
    """The folder of a study's results, where none is asked for."""
    return plan.folder / plan.out if plan.out else Path("out") / plan.name


@dataclass(frozen=True)
class _Watch:
    """Who is told how far the work is."""

    begin: Begin
    kept: Callable[[int], None]
    resumed: Callable[[int, int], None]


def _work(
    folder: Path,
    configuration: Mapping[str, Any],
    groups: Sequence[Sequence[Case]],
    seeds: Sequence[int],
    metrics: OwnMetrics,
    drawn: bool,
    *,
    named: bool = True,
    quantities: Mapping[tuple[str, str], Sequence[tuple[str, str]]] = MappingProxyType({}),
    metric_files: OwnMetrics = NO_METRICS,
    workers: Workers | None = None,
) -> KeptComparisons:
    """The runs of a study. What is not ``named`` in files cannot be told from another: nobody goes on with its runs."""
    cases = {case.scenario.name: case.about for group in groups for case in group}
    about: dict[str, Any] = {
        "scenarios": {name: found["scenario"] for name, found in cases.items()},
        "axes": {name: found["axes"] for name, found in cases.items() if "axes" in found},
        "chunk": groups[0][0].chunk,
    }
    about |= {name: configuration[name] for name in ("controllers", "metrics", "files_sha256", "seeds", "versions")}
    return KeptComparisons(
        folder=folder / PIECES_FOLDER,
        about=json.loads(json.dumps(about, default=shown_gain)),
        lasting=named,
        groups=groups,
        seeds=seeds,
        quantities=quantities,
        metrics=metrics,
        named=metric_files,
        workers=workers,
        drawn=drawn,
    )


def _written(
    work: KeptComparisons,
    configuration: Mapping[str, Any],
    watch: _Watch,
    chapters: MakeChapters | None,
    front: MakeFront | None,
    report: bool,
    command: str | None,
    plan: StudyPlan | None = None,
    *,
    fresh: bool = False,
) -> Study:
    """Do what is left of the work, and write all that becomes of it and of the chapters that are made beside."""
    folder, begin = work.folder.parent, watch.begin
    first = plan.shown_metrics if plan is not None else ()

    def prepare() -> None:
        """Remove the results that the folder has: none of them stands beside those of another study."""
        for name in _RESULTS:
            (folder / name).unlink(missing_ok=True)
        discard_chunks(work.folder)

    with (
        claimed(
            work.folder, "plan.json", work.about, prepare, kind="study", fault=StudyError,
            fresh=fresh or not work.lasting,
        ),
        # Matrices here are small: with more threads they wait for each other, and last digits depend on the machine.
        threadpool_limits(1, "blas"),
        chapters(begin, folder, work.seeds[0], report) if chapters is not None else nullcontext(list[Chapter]) as wait,
    ):  # fmt: skip
        write_json(folder / "configuration.json", configuration, default=shown_gain)
        comparisons, table = _compared(work, watch)
        summary = pd.concat([summarise(c.table, c.metrics) for c in comparisons], ignore_index=True)
        write_frame(summary, folder / "summary.csv")
        titles = column_titles(map(str, table), work.metrics)
        about = [{"column": name, "title": title, "unit": unit} for name, (title, unit) in titles.items()]
        write_frame(pd.DataFrame(about), folder / "columns.csv")
        if plan is not None and plan.save_runs:
            _save_runs(comparisons, folder / "runs")
        claims = judged(plan, comparisons) if plan is not None else []
        answers = _answers(plan, comparisons, table, folder) if plan is not None and plan.questions else {}
        sections = []
        if report:
            sections = draw_sections(comparisons, begin("drawing", figure_count(comparisons)), first)
        opening = front(begin, folder) if front is not None and report else None
        claims, made = judged_together(claims, wait())
        all_claims = [*claims, *(claim for chapter in made for claim in chapter.claims)]
        if chapters is not None or all_claims:
            write_frame(pd.DataFrame([claim.row() for claim in all_claims]), folder / "claims.csv")
            rows = [row for claim in all_claims for row in claim.evidence()]
            write_frame(pd.DataFrame(rows), folder / "evidence.csv")
        shown = folder / "results.csv"
        if report:
            shown = write_report(
                comparisons,
                claims,
                folder,
                chapters=[*answer_chapters(answers), *made],
                command=command,
                sections=sections,
                heading=_heading(plan) if plan is not None else None,
                first=first,
                front=opening,
            )
        rmtree(work.folder)
    files = sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())
    groups = plan.groups if plan is not None else ()
    skipped = tuple(f"{on}: {line}" for g in groups for on, lines in g.skipped.items() for line in lines)
    return Study(comparisons, summary, all_claims, shown, files, first, skipped, answers)


def _answers(plan: StudyPlan, comparisons: Sequence[Comparison], rows: pd.DataFrame, folder: Path) -> dict[str, Answer]:
    """The answers to the study's questions about the ``rows`` of results.csv; answers.json has them, too."""
    one = comparisons[0]
    first, _ = leading_metric(one, one.scenarios[0], plan.shown_metrics)
    table = described_table(rows, plan.own_metrics, first, [axis.name for axis in plan.axis_list])
    answers = asked(plan.questions, table, plan.folder, plan.own_metrics)
    write_json(folder / "answers.json", {name: answer.row() for name, answer in answers.items()})
    return answers


def _compared(work: KeptComparisons, watch: _Watch) -> tuple[tuple[Comparison, ...], pd.DataFrame]:
    """The comparisons and their rows; results.csv holds these, or what there is of them after an interruption."""

    def keep(rows: pd.DataFrame) -> None:
        with uninterrupted():  # what is said to be kept is what was written
            if len(rows):
                write_frame(rows, work.folder.parent / "results.csv")
            watch.kept(len(rows))

    try:
        work.compute(watch.begin, watch.resumed)
    except (KeyboardInterrupt, InputError) as error:
        keep(work.rows())
        if isinstance(error, InputError) and not isinstance(error, WorkerError):
            rmtree(work.folder)  # the same command would fail again, and what is mended begins anew
        raise
    keep(rows := work.rows())
    return work.comparisons(), rows


def _chapters_named(plan: StudyPlan) -> MakeChapters:
    """The function that the plan's key ``chapters`` names."""
    module, _, name = plan.chapters.partition(":")
    try:
        made: MakeChapters = getattr(import_module(module), name)
    except (ImportError, AttributeError, ValueError) as error:
        raise StudyError(
            f"{plan.file}: chapters must be package.module:function; got {plan.chapters!r}: {error}"
        ) from None
    return made


# Judging ----------------------------------------------------------------------------------------------------------


def judged(plan: StudyPlan, comparisons: Sequence[Comparison]) -> list[Claim]:
    """The claims of a study, judged by the runs of its comparisons."""
    return [
        Claim(**claim.texts, parts=tuple(part for c in claim.parts for part in _parts(plan, c, comparisons)))
        for claim in plan.claims
    ]


def _parts(plan: StudyPlan, condition: Condition, comparisons: Sequence[Comparison]) -> Iterator[Part]:
    """A part for each scenario on which the condition is measured."""
    metric = plan.metric_called(condition.metric)
    about = quantity_called(metric, plan.own_metrics)
    of, *against = (plan.law_called(name) for name in (condition.of, *condition.against))
    for case in (name for scenario in plan.scenarios_of(condition) for name in plan.case_names(scenario.name)):
        here = next(c for c in comparisons if case in [s.name for s in c.scenarios])

        def values(law: str, on: str = case, found: Comparison = here) -> np.ndarray:
            return found.values[on, law, metric, condition.robots]

        yield decided(
            condition,
            Measure(about.title or condition.metric, about.unit, about.larger),
            values,
            on=case,
            of=of,
            against=against,
            fewest=FEWEST_RUNS,
            note="; ".join(filter(None, (_note(here.table, case, law) for law in (of, *against)))),
        )


def _note(table: pd.DataFrame, scenario: str, law: str) -> str:
    """What became of runs that count only in part."""
    touched, runs = contact_runs(table, scenario, law)
    rows = table[(table["scenario"] == scenario) & (table["controller"] == law)]
    stopped = int(rows.groupby("seed")["diverged"].any().sum())
    said = []
    if touched:
        said.append(f"had a contact in {touched} of {runs} runs, which count up to the first")
    if stopped:
        said.append(f"lost its reference in {stopped} of {runs} runs, which count up to then")
    return f"✕ {law} {' and '.join(said)}" if said else ""


# What is written --------------------------------------------------------------------------------------------------


def _heading(plan: StudyPlan) -> Heading:
    file = plan.file or plan.name
    packaged = not plan.file or (plan.file == f"{plan.name}.toml" and not (plan.folder / plan.file).is_file())
    return Heading(
        title=plan.title or plan.name,
        author=plan.author,
        text=(*plan.paragraphs, *_pooling(plan)),
        program=(
            "import robotics\n\n"
            f'plan = robotics.load_study("{plan.name if packaged else Path(file).as_posix()}")\n'
            'study = robotics.run_study(plan, out="out")\n'
        ),
        folder=_prefix(plan),
        written=plan.written,
        skipped={scenario: lines for group in plan.groups for scenario, lines in group.skipped.items()},
    )


def _pooling(plan: StudyPlan) -> list[str]:
    """What a reader must know of numbers over the points of a design."""
    if not plan.axes:
        return []
    names, points = listed([axis.name for axis in plan.axis_list]), counted(len(plan.points), "point")
    said = f"Every scenario was driven at {points} of {names}: numbers are of the runs at all points alike, and the "
    return [f"{said}pictures of runs show the scenario as its file has it."]


def _configuration(plan: StudyPlan) -> dict[str, Any]:
    """What was run, and with which files: enough to run it again, and to see whether a file has changed."""
    return {
        "study": plan.name,
        "scenarios": [scenario.name for scenario in plan.settings],
        "controllers": {
            name: {"specification": plan.written[name], "gains": _gains(plan, law)} for name, law in plan.laws.items()
        },
        "metrics": [*plan.own_metrics],
        "seeds": list(plan.row),
        "file": plan.content,
        "files_sha256": {name: digest_of(file) for name, file in sorted(_files(plan).items())},
        "versions": versions(),
        **({"questions_sha256": _question_files(plan)} if plan.questions else {}),
    }


def _question_files(plan: StudyPlan) -> dict[str, str]:
    """The files of a user's own questions, which change no number, with their digests."""
    named = {name: Specification.of(name).located(plan.folder).file for name in plan.questions}
    return {name: digest_of(Path(file)) for name, file in named.items() if file.endswith(".py")}


def _prefix(plan: StudyPlan) -> str:
    """What is left out of the paths of the study's files; "" where there is nothing."""
    return "" if plan.folder == Path() else f"{plan.folder}/"


def _gains(plan: StudyPlan, law: str) -> dict[str, Any]:
    gains, prefix = gains_of(make_controller(law)), _prefix(plan)
    return {n: v.removeprefix(prefix) if isinstance(v, str) and prefix else v for n, v in gains.items()}


def _files(plan: StudyPlan) -> dict[str, Path]:
    """The files that a study reads, by their paths from its folder; packaged scenarios by their names."""
    found: dict[str, Path] = {}
    for text in plan.scenarios:
        file = scenario_file(text, plan.folder)
        found[text] = file.path
        for robot in robot_files(parse_table(file.text, file.file, StudyError), file.folder).values():
            found[_from(plan.folder, robot, str(robot))] = robot
        found |= _files_of_axes(plan, file.folder)
    for law in plan.laws.values():
        for text, path in files_of(law).items():
            found[_from(plan.folder, path, text)] = path
    for text in plan.metric_files.values():
        named = Specification.of(text)
        found[named.file] = Path(named.located(plan.folder).file)
    return found


def _files_of_axes(plan: StudyPlan, home: Path) -> dict[str, Path]:
    """The files of robots and rule bases that values of the axes name; ``home`` is the folder of a scenario."""
    found: dict[str, Path] = {}
    for axis in plan.axis_list:
        for level in (level for level in axis.levels if isinstance(level, str)):
            if axis.target == "controller":
                found |= fis_files_named(level)
            elif axis.name.split(".")[-1] in ("robot", "model"):
                found |= robot_files({"robots": [{"robot": level}]}, home)
    return found


def _files_named(laws: Mapping[str, Law[Any] | str], metrics: Sequence[Any]) -> dict[str, Path]:
    """The files that specifications name: of laws, their gains, and metrics."""
    found: dict[str, Path] = {}
    for law in laws.values():
        found |= files_of(law) if isinstance(law, str) else {}
    for metric in metrics:
        if isinstance(metric, str) and (file := Specification.of(metric).file):
            found[file] = Path(file)
    return found


def _from(folder: Path, path: Path, text: str) -> str:
    return path.relative_to(folder).as_posix() if path.is_relative_to(folder) else text


def _save_runs(comparisons: Sequence[Comparison], folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for comparison in comparisons:
        for key in comparison.notes:
            runs, seeds = comparison.runs, comparison.seeds
            again = isinstance(runs, RunsAgain) and len(runs.seeds) < len(seeds)
            run = cast(RunsAgain, runs).simulated(key, seeds) if again else runs[key]
            run.save(folder / f"{run_name(*key)}.npz")


def with_seeds(plan: StudyPlan, seeds: int | None = None, first: int | None = None) -> StudyPlan:
    """The same study with another number of seeds, or another first one."""
    asked: dict[str, Any] = {"seeds": seeds, "first_seed": first}
    return replace(plan, **{name: value for name, value in asked.items() if value is not None})
