"""The thesis's chapters of the report, each made in a process of its own, side by side.

A chapter that comes back is finished: numbers, text and drawn pictures. It does not depend on the number of processes.
"""

import queue
import threading
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from itertools import chain
from multiprocessing import Manager
from operator import itemgetter
from pathlib import Path
from typing import Any

from fuzzy.compiled.threads import processors
from fuzzy.shell.progress import Begin
from robotics.plugins.thesis import avoidance, avoidance_runs, formations, team_runs, teams, tracking
from robotics.plugins.thesis.claims import Needed, run_file
from robotics.plugins.thesis.experiment import THOROUGH, USUAL, ChapterMaker, Effort, Experiment, results_of
from robotics.show.report.chapter import Chapter
from robotics.show.report.plates import plate
from robotics.show.report.study import MakeChapters
from robotics.simulation.run import Run
from robotics.studies.executors import processes
from robotics.studies.pieces import run_pieces

PROCESSES = 2  # number of processes; this one meanwhile runs and draws the comparison
CHAPTERS = (  # in the order of the report
    ChapterMaker("judging the tracking laws", tracking.experiments, tracking.chapter_of, 8.0),
    ChapterMaker("learning formations", formations.experiments, formations.chapter_of, 22.0),
    ChapterMaker("driving teams", team_runs.experiments, teams.chapter_of, 35.0),
    ChapterMaker("avoiding each other", avoidance_runs.experiments, avoidance.chapter_of, 33.0),
)


@contextmanager
def judging(
    begin: Begin, folder: Path, seed: int, draw: bool, *, effort: Effort = USUAL, save_runs: bool = False
) -> Iterator[Callable[[], list[Chapter]]]:
    """Start making CHAPTERS, for a ``with`` block: gives a function that waits for them and returns them.

    Leaving by an exception stops the work at once. Raises what the chapters raise.

    Args:
        begin: Starts a bar of a progress display, by its text and total.
        folder: The folder of the report; networks that are learnt go to its folder networks.
        seed: The seed of the experiments.
        draw: Whether pictures and films are made.
        effort: The number of runs behind a verdict.
        save_runs: Whether the runs behind the verdicts are saved, in the folder ``runs`` of the report's.
    """
    with Manager() as manager, processes(min(PROCESSES, processors()), [__name__]) as workers:
        ticks = manager.Queue()
        bars = [begin(maker.title, len(maker.experiments(str(folder), seed, effort))) for maker in CHAPTERS]
        threading.Thread(target=_count, args=(ticks, bars), daemon=True).start()
        one = partial(_made, str(folder), seed, effort, draw, ticks.put, save_runs)
        # The longest first: the processes are then done at about the same time.
        places = sorted(range(len(CHAPTERS)), key=lambda i: -CHAPTERS[i].seconds)
        workers = replace(workers, in_flight=len(places))
        made = run_pieces(one, places, workers, called=lambda i: CHAPTERS[i].title)

        def judged() -> list[Chapter]:
            found = [chapter for _, chapter in sorted(made, key=itemgetter(0))]
            for _, caught in found:
                for message in caught:
                    warnings.warn(message, stacklevel=2)
            return [chapter for chapter, _ in found]

        try:
            yield judged
        finally:
            ticks.put(None)


def suite(thorough: bool, save_runs: bool) -> MakeChapters:
    """The chapters for ``robotics compare``, by the runs that it asks for."""
    return partial(judging, effort=THOROUGH if thorough else USUAL, save_runs=save_runs)


def _count(ticks: "queue.Queue[int | None]", bars: list[Any]) -> None:
    """Advance the bars until the end is put in."""
    try:
        while (i := ticks.get()) is not None:
            bars[i]()
    except (EOFError, OSError):  # interrupted
        return


def _made(
    folder: str, seed: int, effort: Effort, draw: bool, tick: Callable[[int], None], save_runs: bool, place: int
) -> tuple[Chapter, list[Warning]]:
    """In a worker: the chapter at that place of CHAPTERS, drawn, and the warnings on the way."""
    maker = CHAPTERS[place]
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("default")
        experiments = maker.experiments(folder, seed, effort)
        results = results_of(experiments, partial(tick, place))
        if save_runs:
            save_results(results, experiments, Path(folder) / "runs")
        made = maker.chapter(results)
        pictures = [plate(picture) for picture in made.pictures] if draw else []
        films = [film._replace(make=partial(str, film.make())) for film in made.films] if draw else []
    done = replace(made, pictures=pictures, films=films)
    return done, [warning.message for warning in caught if isinstance(warning.message, Warning)]


def save_results(results: Mapping[Any, Any], experiments: Iterable[Experiment], folder: Path) -> None:
    """Write the runs behind the results to ``folder``: on packaged scenarios each as :func:`run_file` calls it."""
    folder.mkdir(parents=True, exist_ok=True)
    for key, found in results.items():
        for run in found if isinstance(found, list) else [found]:
            if isinstance(run, Run):
                need = key if isinstance(key, Needed) else Needed(run.scenario, run.controller, False)
                run.save(folder / run_file(need))
    for name, run in chain.from_iterable(one.runs() for one in experiments if one.runs is not None):
        run.save(folder / f"{name}.npz")
