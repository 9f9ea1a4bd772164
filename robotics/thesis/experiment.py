"""The experiments behind a chapter of the thesis: a list, so that progress is counted and not guessed."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from robotics.report.chapter import Chapter


class Experiment(NamedTuple):
    """One thing to run, and the key under which its result is found."""

    key: tuple[Any, ...]
    run: Callable[[], Any]


class ChapterMaker(NamedTuple):
    """How a chapter is made: its experiments, and the chapter that is written of their results."""

    title: str  # of its progress bar
    experiments: Callable[[str, int], Sequence[Experiment]]  # of the report's folder and a seed; nothing is run by it
    chapter: Callable[[Mapping[tuple[Any, ...], Any]], Chapter]  # of the results by key
    seconds: float  # that it takes, about: the longest is started first


def results_of(experiments: Sequence[Experiment], advance: Callable[[], None] | None = None) -> dict[Any, Any]:
    """Run the experiments in their order: results by key. ``advance`` is called after every one."""
    results = {}
    for experiment in experiments:
        results[experiment.key] = experiment.run()
        if advance is not None:
            advance()
    return results
