"""A whole comparison in a folder: its tables, chapters that may be added, and the report."""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from pathlib import Path

import pandas as pd
from threadpoolctl import threadpool_limits

from fuzzy.files.atomic import replacing
from fuzzy.files.table import write_frame
from fuzzy.shell.progress import Begin
from robotics.experiments.comparison import Comparison, check_comparison, compare, summarise
from robotics.experiments.executors import uninterrupted
from robotics.experiments.versions import digest_of, versions
from robotics.laws.catalogue import OwnLaws, chosen_laws, files_of, gains_of, named_laws, shown_gain
from robotics.laws.specification import Specification
from robotics.measures.own import NO_METRICS, OwnMetrics
from robotics.measures.registry import own_metrics
from robotics.report.chapter import Chapter, Claim
from robotics.report.page import draw_sections, figure_count, write_report
from robotics.scenario.description import Scenario

# Makes chapters beside the comparison, from a function that begins a progress bar, the folder, the first seed and
# whether pictures are wanted. Entering it gives a function that waits for the chapters; leaving it stops the work.
MakeChapters = Callable[[Begin, Path, int, bool], AbstractContextManager[Callable[[], list[Chapter]]]]


@dataclass(frozen=True, eq=False)
class Study:
    """The outcome of a study."""

    comparison: Comparison
    summary: pd.DataFrame  # of :func:`robotics.experiments.comparison.summarise`
    claims: list[Claim]
    shown: Path  # the file to open: the report, or the table of results
    files: list[str]  # all files that were written, relative to the folder


def write_study(
    folder: Path,
    scenarios: Sequence[Scenario],
    controllers: OwnLaws,
    seeds: Sequence[int],
    *,
    begin: Begin,
    metrics: OwnMetrics = NO_METRICS,
    chapters: MakeChapters | None = None,
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
        controllers: Controllers, as :func:`robotics.experiments.comparison.compare` takes them.
        seeds: The seeds.
        begin: Starts a bar of a progress display, by its text and total.
        metrics: The user's own metrics, as :func:`robotics.experiments.comparison.compare` takes them.
        chapters: Makes chapters beside the comparison.
        report: Whether figures and the report are made.
        command: The command line that the report names.
        kept: Called with the number of rows that are written, after every scenario and controller.

    Raises ComparisonError, ControllerError, MetricError and OSError.
    """
    check_comparison(scenarios, controllers, metrics)
    folder.mkdir(parents=True, exist_ok=True)
    _write_configuration(folder, scenarios, controllers, metrics, seeds)

    def keep(rows: pd.DataFrame) -> None:
        with uninterrupted():  # what is said to be kept is what was written
            write_frame(rows, folder / "results.csv")
            kept(len(rows))

    # Matrices here are small: with more threads they wait for each other, and last digits depend on the machine.
    with (
        threadpool_limits(1, "blas"),
        (chapters or _no_chapters)(begin, folder, seeds[0], report) as wait,
    ):
        advance = begin("simulating", sum(s.ticks + 1 for s in scenarios) * len(controllers))
        comparison = compare(scenarios, controllers, seeds, metrics=metrics, advance=advance, finished=keep)
        summary = summarise(comparison.table, comparison.metrics)
        write_frame(summary, folder / "summary.csv")
        sections = draw_sections(comparison, begin("drawing", figure_count(comparison))) if report else []
        made = wait()
    claims = [claim for chapter in made for claim in chapter.claims]
    if chapters is not None:
        write_frame(pd.DataFrame([claim.row() for claim in claims]), folder / "claims.csv")
        write_frame(pd.DataFrame([row for claim in claims for row in claim.evidence()]), folder / "evidence.csv")
    shown = folder / "results.csv"
    if report:
        shown = write_report(comparison, [], folder, chapters=made, command=command, sections=sections)
    files = sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())
    return Study(comparison, summary, claims, shown, files)


@contextmanager
def _no_chapters(begin: Begin, folder: Path, seed: int, draw: bool) -> Iterator[Callable[[], list[Chapter]]]:
    yield list


def _write_configuration(
    folder: Path, scenarios: Sequence[Scenario], controllers: OwnLaws, metrics: OwnMetrics, seeds: Sequence[int]
) -> None:
    configuration = {
        "scenarios": [scenario.name for scenario in scenarios],
        "controllers": {name: gains_of(law) for name, law in chosen_laws(controllers).items()},
        "metrics": [*own_metrics(metrics)],
        "files_sha256": {name: digest_of(file) for name, file in sorted(_files(controllers, metrics).items())},
        "seeds": list(seeds),
        "versions": versions(),
    }
    with replacing(folder / "configuration.json") as temporary:
        text = json.dumps(configuration, indent=2, ensure_ascii=False, default=shown_gain)
        temporary.write_text(text + "\n", encoding="utf-8")


def _files(controllers: OwnLaws, metrics: OwnMetrics) -> dict[str, Path]:
    """The files that specifications name: of laws, their gains, and metrics."""
    found: dict[str, Path] = {}
    for _, law in named_laws(controllers):
        found |= files_of(law) if isinstance(law, str) else {}
    for metric in metrics.values() if isinstance(metrics, Mapping) else metrics:
        if isinstance(metric, str) and (file := Specification.of(metric).file):
            found[file] = Path(file)
    return found
