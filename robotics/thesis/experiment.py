"""The experiments behind a chapter of the thesis, as a list, so that progress is counted and not guessed."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from robotics.report.chapter import Chapter


class Experiment(NamedTuple):
    """One thing to run, and the key under which its result is found."""

    key: tuple[Any, ...]
    run: Callable[[], Any]


class ChapterMaker(NamedTuple):
    """The way a chapter is made: its experiments, and the chapter that is written from their results."""

    title: str  # the text of its progress bar
    experiments: Callable[[str, int], Sequence[Experiment]]  # from the report's folder and a seed; it runs nothing
    chapter: Callable[[Mapping[tuple[Any, ...], Any]], Chapter]  # from the results by key
    seconds: float  # the time it takes, about: the longest is started first


def results_of(experiments: Sequence[Experiment], advance: Callable[[], None] | None = None) -> dict[Any, Any]:
    """Run the experiments in their order; return results by key. ``advance`` is called after each."""
    results = {}
    for experiment in experiments:
        results[experiment.key] = experiment.run()
        if advance is not None:
            advance()
    return results
