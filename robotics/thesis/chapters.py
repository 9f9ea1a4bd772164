"""The thesis's claims and the report's chapters, each made in a process of its own, side by side.

What comes back is finished: numbers, text and drawn pictures. It does not depend on how many processes there are.
"""

import os
import queue
import threading
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from fuzzy.shell.progress import Begin
from robotics.experiments.executors import processes
from robotics.report.chapter import Chapter, Claim, Film

PROCESSES = 2  # beside this one, which meanwhile runs and draws the comparison


@dataclass(frozen=True)
class Judgement:
    """What the report says beyond the comparison itself."""

    claims: list[Claim]  # those of no chapter
    chapters: list[Chapter]

    @property
    def all_claims(self) -> list[Claim]:
        """Every claim, in the order of the report."""
        return [*self.claims, *(claim for chapter in self.chapters for claim in chapter.claims)]


@dataclass(frozen=True)
class _Part:
    title: str
    steps: int
    make: Callable[[str, int, Callable[[], None]], Any]  # of the folder, the seed and what counts steps


def _claims(folder: str, seed: int, advance: Callable[[], None]) -> list[Claim]:
    from robotics.thesis.tracking import judge_claims

    return judge_claims(advance)


def _formation(folder: str, seed: int, advance: Callable[[], None]) -> Chapter:
    from robotics.thesis.formations import formation_chapter

    return formation_chapter(folder, seed, advance)


def _teams(folder: str, seed: int, advance: Callable[[], None]) -> Chapter:
    from robotics.thesis.teams import team_chapter

    return team_chapter(seed, advance)


def _avoidance(folder: str, seed: int, advance: Callable[[], None]) -> Chapter:
    from robotics.thesis.avoidance import avoidance_chapter

    return avoidance_chapter(seed, advance)


def _parts() -> tuple[_Part, ...]:
    from robotics.thesis import (
        avoidance_runs as avoidanceexperiments,
    )
    from robotics.thesis import (
        formations as formation,
    )
    from robotics.thesis import (
        team_runs as teamexperiments,
    )
    from robotics.thesis import (
        tracking as claims,
    )

    return (
        _Part("judging the thesis's claims", claims.EXPERIMENTS, _claims),
        _Part("learning formations", formation.STEPS, _formation),
        _Part("driving teams", teamexperiments.STEPS, _teams),
        _Part("avoiding each other", avoidanceexperiments.STEPS, _avoidance),
    )


@contextmanager
def judging(begin: Begin, folder: Path, seed: int, draw: bool) -> Iterator[Callable[[], Judgement]]:
    """Start judging; what is given waits for the end of it.

    ``draw``: with pictures and films; networks that are learnt go to ``folder``/networks. Leaving by an exception
    stops the work at once. Raises what the chapters raise.
    """
    from multiprocessing import Manager

    parts = _parts()
    # The longest first: the processes are then done at about the same time.
    order = sorted(range(len(parts)), key=lambda i: parts[i].title != "driving teams")
    with Manager() as manager, processes(min(PROCESSES, os.cpu_count() or 1), ["robotics.report.page"]) as workers:
        ticks = manager.Queue()
        bars = [begin(part.title, part.steps) for part in parts]
        threading.Thread(target=_count, args=(ticks, bars), daemon=True).start()
        futures: list[Future[Any]] = [Future()] * len(parts)
        for i in order:
            futures[i] = workers.executor.submit(_made, parts[i].make, str(folder), seed, draw, partial(ticks.put, i))

        def judged() -> Judgement:
            found = []
            for future in futures:
                result, caught = future.result()
                for message in caught:
                    warnings.warn(message, stacklevel=2)
                found.append(result)
            return Judgement(found[0], found[1:])

        try:
            yield judged
        finally:
            ticks.put(None)


def _count(ticks: "queue.Queue[int | None]", bars: list[Any]) -> None:
    """Advance the bars until the end is put in."""
    try:
        while (i := ticks.get()) is not None:
            bars[i]()
    except (EOFError, OSError):  # interrupted
        return


def _made(
    make: Callable[..., Any], folder: str, seed: int, draw: bool, tick: Callable[[], None]
) -> tuple[Any, list[Warning]]:
    """In a worker: the claims or the chapter, drawn, and the warnings on the way."""
    from robotics.report.page import plate

    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("default")
        made = make(folder, seed, tick)
        if isinstance(made, Chapter):
            pictures = [plate(picture) for picture in made.pictures] if draw else []
            films = [Film(film.caption, partial(str, film.make())) for film in made.films] if draw else []
            made = replace(made, pictures=pictures, films=films)
    return made, [warning.message for warning in caught if isinstance(warning.message, Warning)]
