"""A whole study in a folder: comparisons, claims, chapters that may be added, and the report."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from threadpoolctl import threadpool_limits

from fuzzy.files.atomic import write_json
from fuzzy.files.table import write_frame
from fuzzy.shell.progress import Advance, Begin, unwatched
from robotics.laws.catalogue import OwnLaws, chosen_laws, files_of, gains_of, make_controller, named_laws, shown_gain
from robotics.laws.law import Law
from robotics.laws.specification import Specification
from robotics.measures.contacts import can_touch
from robotics.measures.evidence import FEWEST_RUNS, Part
from robotics.measures.own import NO_METRICS, OwnMetrics
from robotics.measures.quantities import measured, runs_touched
from robotics.measures.registry import own_metrics
from robotics.show.report.chapter import Chapter, Claim, Front
from robotics.show.report.claims import Condition, Measure, decided, run_name
from robotics.show.report.page import Heading, draw_sections, figure_count, write_report
from robotics.show.report.plan import ScenarioGroup, StudyError, StudyPlan
from robotics.simulation.run import Run
from robotics.simulation.scenario.description import Scenario
from robotics.simulation.scenario.reading import scenario_file
from robotics.simulation.scenario.robots import robot_files
from robotics.studies.comparison import Comparison, check_comparison, compare, summarise
from robotics.studies.executors import Workers, uninterrupted, workers_at
from robotics.studies.versions import digest_of, versions
from robotics.tables.text import parse_table

# Makes chapters beside the comparison, from a function that begins a progress bar, the folder, the first seed and
# whether pictures are wanted. Entering it gives a function that waits for the chapters; leaving it stops the work.
MakeChapters = Callable[[Begin, Path, int, bool], AbstractContextManager[Callable[[], list[Chapter]]]]
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
    """

    comparisons: tuple[Comparison, ...]
    summary: pd.DataFrame
    claims: list[Claim]
    shown: Path
    files: list[str]
    first: tuple[str, ...] = ()
    skipped: tuple[str, ...] = ()

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
) -> Study:
    """Compare controllers on scenarios, and write all results into a folder.

    The files are configuration.json, results.csv (one row for each seed and robot), summary.csv, claims.csv and
    evidence.csv if ``chapters`` are made, and with ``report`` also report.html and figures/.

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
        kept: Called with the number of rows that are written, after every scenario and controller.

    Raises ComparisonError, ControllerError, MetricError and OSError.
    """
    check_comparison(scenarios, controllers, metrics)
    laws = dict(named_laws(controllers))
    configuration = {
        "scenarios": [scenario.name for scenario in scenarios],
        "controllers": {name: gains_of(law) for name, law in chosen_laws(controllers).items()},
        "metrics": [*own_metrics(metrics)],
        "files_sha256": {name: digest_of(file) for name, file in sorted(_files_named(laws, metrics).items())},
        "seeds": list(seeds),
        "versions": versions(),
    }
    compared = _compared(
        folder, [ScenarioGroup(scenarios[0].kind, tuple(scenarios), laws, {})], seeds, metrics, begin, None, kept
    )
    return _written(folder, configuration, compared, begin, chapters, front, report, command, seeds[0])


def run_study(
    plan: StudyPlan,
    out: str | Path | None = None,
    *,
    jobs: int = 1,
    report: bool = True,
    begin: Begin = unwatched,
    chapters: MakeChapters | None = None,
    front: MakeFront | None = None,
    command: str | None = None,
    kept: Callable[[int], None] = lambda rows: None,
) -> Study:
    """Run a study: scenarios × controllers × seeds, its claims judged, all results in a folder.

    The files are those of :func:`write_study`, claims.csv and evidence.csv where the study has claims; the report has
    the study's title and text, and the claims with their verdicts before the comparison. A claim is judged by
    :mod:`robotics.measures.evidence`, and told only where at least 20 runs stand behind it.

    Args:
        plan: The study, such as :func:`robotics.show.report.plan.load_study` reads it.
        out: The folder of the results. Default: the plan's.
        jobs: Number of processes that simulate; the numbers do not depend on it.
        report: Whether figures and the report are made.
        begin: Starts a bar of a progress display, by its text and total. Default: none is shown.
        chapters: Makes chapters beside the comparison. Default: those that the plan names.
        front: Makes what opens the report, such as an entry point of the group fuzzyfleet.fronts.
        command: The command line that the report names.
        kept: Called with the number of rows that are written, after every scenario and controller.

    Returns:
        The comparisons, the summary, the verdicts and the files.

    Raises:
        StudyError: A study that cannot be run.
        MetricError: A metric cannot be used, or fails.
        ControllerError: A controller that is unknown, or cannot drive the scenario.
        OSError: Files cannot be written.
    """
    folder = Path(out) if out is not None else default_folder(plan)
    chapters = chapters or (_chapters_named(plan) if plan.chapters else None)
    command = command or f"robotics study {plan.file or plan.name} --seeds {plan.seeds}"
    with workers_at(jobs if jobs > 1 else None, preload=["robotics.studies.comparison"]) as workers:
        compared = _compared(folder, plan.groups, plan.row, plan.own_metrics, begin, workers, kept)
        return _written(
            folder, _configuration(plan), compared, begin, chapters, front, report, command, plan.first_seed, plan
        )


def default_folder(plan: StudyPlan) -> Path:
    """The folder of a study's results, where none is asked for."""
    return plan.folder / plan.out if plan.out else Path("out") / plan.name


def _written(
    folder: Path,
    configuration: Mapping[str, Any],
    compared: Iterator[Comparison],
    begin: Begin,
    chapters: MakeChapters | None,
    front: MakeFront | None,
    report: bool,
    command: str | None,
    seed: int,
    plan: StudyPlan | None = None,
) -> Study:
    """Write all that becomes of comparisons, which are made meanwhile, and of the chapters that are made beside."""
    folder.mkdir(parents=True, exist_ok=True)
    write_json(folder / "configuration.json", configuration, default=shown_gain)
    first = plan.shown_metrics if plan is not None else ()
    # Matrices here are small: with more threads they wait for each other, and last digits depend on the machine.
    with (
        threadpool_limits(1, "blas"),
        chapters(begin, folder, seed, report) if chapters is not None else nullcontext(list[Chapter]) as wait,
    ):
        comparisons = tuple(compared)
        parts = [summarise(c.table, c.metrics) for c in comparisons]
        summary = pd.concat(parts, ignore_index=True)
        write_frame(summary, folder / "summary.csv")
        if plan is not None and plan.save_runs:
            _save_runs(comparisons, folder / "runs")
        claims = judged(plan, comparisons) if plan is not None else []
        sections = []
        if report:
            sections = draw_sections(comparisons, begin("drawing", figure_count(comparisons)), first)
        opening = front(begin, folder) if front is not None and report else None
        made = wait()
    all_claims = [*claims, *(claim for chapter in made for claim in chapter.claims)]
    if chapters is not None or all_claims:
        write_frame(pd.DataFrame([claim.row() for claim in all_claims]), folder / "claims.csv")
        write_frame(pd.DataFrame([row for claim in all_claims for row in claim.evidence()]), folder / "evidence.csv")
    shown = folder / "results.csv"
    if report:
        shown = write_report(
            comparisons,
            claims,
            folder,
            chapters=made,
            command=command,
            sections=sections,
            heading=_heading(plan) if plan is not None else None,
            first=first,
            front=opening,
        )
    files = sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())
    groups = plan.groups if plan is not None else ()
    skipped = tuple(f"{on}: {line}" for g in groups for on, lines in g.skipped.items() for line in lines)
    return Study(comparisons, summary, all_claims, shown, files, first, skipped)


def _compared(
    folder: Path,
    groups: Sequence[ScenarioGroup],
    seeds: Sequence[int],
    metrics: OwnMetrics,
    begin: Begin,
    workers: Workers | None,
    kept: Callable[[int], None],
) -> Iterator[Comparison]:
    """The comparisons of the groups; results.csv holds what is done so far."""
    total = sum((1 if workers else s.ticks + 1) * len(g.laws) for g in groups for s in g.scenarios)
    advance: Advance = begin("simulating", total)
    tables: list[pd.DataFrame] = []

    def keep(rows: pd.DataFrame) -> None:
        with uninterrupted():  # what is said to be kept is what was written
            whole = pd.concat([*tables, rows], ignore_index=True) if tables else rows
            write_frame(whole, folder / "results.csv")
            kept(len(whole))

    for group in groups:
        comparison = compare(
            group.scenarios,
            group.laws,
            seeds,
            metrics=metrics,
            workers=workers,
            advance=advance,
            finished=keep,
        )
        tables.append(comparison.table)
        yield comparison


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
    runs = {key: run for comparison in comparisons for key, run in comparison.runs.items()}
    return [
        Claim(**claim.texts, parts=tuple(part for c in claim.parts for part in _parts(plan, c, runs)))
        for claim in plan.claims
    ]


def _parts(plan: StudyPlan, condition: Condition, runs: Mapping[tuple[str, str], Run]) -> Iterator[Part]:
    """A part for each scenario on which the condition is measured."""
    about = plan.measured_by(condition.metric)
    of, *against = (plan.law_called(name) for name in (condition.of, *condition.against))
    for scenario in plan.scenarios_of(condition):

        def values(law: str, on: str = scenario.name) -> np.ndarray:
            return measured(runs[on, law], about, condition.robots)

        yield decided(
            condition,
            Measure(about.title or condition.metric, about.unit, about.larger),
            values,
            on=scenario.name,
            of=of,
            against=against,
            fewest=FEWEST_RUNS,
            note="; ".join(filter(None, (_note(runs[scenario.name, law], law) for law in (of, *against)))),
        )


def _note(run: Run, law: str) -> str:
    """What became of runs that count only in part."""
    touched = runs_touched(run) if can_touch(run) else 0
    stopped = int(run.diverged.any(axis=1).sum())
    said = []
    if touched:
        said.append(f"had a contact in {touched} of {len(run.seeds)} runs, which count up to the first")
    if stopped:
        said.append(f"lost its reference in {stopped} of {len(run.seeds)} runs, which count up to then")
    return f"✕ {law} {' and '.join(said)}" if said else ""


# What is written --------------------------------------------------------------------------------------------------


def _heading(plan: StudyPlan) -> Heading:
    file = plan.file or plan.name
    packaged = not plan.file or (plan.file == f"{plan.name}.toml" and not (plan.folder / plan.file).is_file())
    return Heading(
        title=plan.title or plan.name,
        author=plan.author,
        text=plan.paragraphs,
        program=(
            "import robotics\n\n"
            f'plan = robotics.load_study("{plan.name if packaged else Path(file).as_posix()}")\n'
            'study = robotics.run_study(plan, out="out")\n'
        ),
        folder=_prefix(plan),
        written=dict(zip(plan.laws, plan.controllers, strict=True)),
        skipped={scenario: lines for group in plan.groups for scenario, lines in group.skipped.items()},
    )


def _configuration(plan: StudyPlan) -> dict[str, Any]:
    """What was run, and with which files: enough to run it again, and to see whether a file has changed."""
    return {
        "study": plan.name,
        "scenarios": [scenario.name for scenario in plan.settings],
        "controllers": {
            name: {"specification": written, "gains": _gains(plan, law)}
            for (name, law), written in zip(plan.laws.items(), plan.controllers, strict=True)
        },
        "metrics": [*plan.own_metrics],
        "seeds": list(plan.row),
        "file": plan.content,
        "files_sha256": {name: digest_of(file) for name, file in sorted(_files(plan).items())},
        "versions": versions(),
    }


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
    for law in plan.laws.values():
        for text, path in files_of(law).items():
            found[_from(plan.folder, path, text)] = path
    for text in plan.metric_files.values():
        named = Specification.of(text).file
        found[named] = plan.folder / named
    return found


def _files_named(laws: Mapping[str, Law[Any] | str], metrics: OwnMetrics) -> dict[str, Path]:
    """The files that specifications name: of laws, their gains, and metrics."""
    found: dict[str, Path] = {}
    for law in laws.values():
        found |= files_of(law) if isinstance(law, str) else {}
    for metric in metrics.values() if isinstance(metrics, Mapping) else metrics:
        if isinstance(metric, str) and (file := Specification.of(metric).file):
            found[file] = Path(file)
    return found


def _from(folder: Path, path: Path, text: str) -> str:
    return path.relative_to(folder).as_posix() if path.is_relative_to(folder) else text


def _save_runs(comparisons: Sequence[Comparison], folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for comparison in comparisons:
        for (scenario, law), run in comparison.runs.items():
            run.save(folder / f"{run_name(scenario, law)}.npz")


def with_seeds(plan: StudyPlan, seeds: int | None = None, first: int | None = None) -> StudyPlan:
    """The same study with another number of seeds, or another first one."""
    asked: dict[str, Any] = {"seeds": seeds, "first_seed": first}
    return replace(plan, **{name: value for name, value in asked.items() if value is not None})
