"""The experiments behind a chapter of the thesis, as a list, so that progress is counted and not guessed."""

from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from robotics.measures.evidence import FEWEST_RUNS, FEWEST_TRIALS
from robotics.show.report.chapter import Chapter
from robotics.simulation.run import Run


@dataclass(frozen=True)
class Effort:
    """The number of runs behind a verdict."""

    seeds: int = FEWEST_RUNS  # of each scenario and law
    trials: int = FEWEST_TRIALS  # of a rate

    def row(self, first: int) -> range:
        """The seeds of a mean, from ``first`` on."""
        return range(first, first + self.seeds)

    def many(self, first: int) -> range:
        """The seeds of a rate, from ``first`` on."""
        return range(first, first + self.trials)


USUAL, THOROUGH = Effort(), Effort(100, 1000)


class Experiment(NamedTuple):
    """One thing to run, and the key under which its result is found.

    Attributes:
        key: The key.
        run: Runs it.
        runs: Of a result that is no run: gives the runs behind it again, each with the name of its file.
    """

    key: Hashable
    run: Callable[[], Any]
    runs: Callable[[], Iterable[tuple[str, Run]]] | None = None


class ChapterMaker(NamedTuple):
    """The way a chapter is made: its experiments, and the chapter that is written from their results."""

    title: str  # the text of its progress bar
    # From the report's folder, the first seed and the number of runs; it runs nothing
    experiments: Callable[[str, int, Effort], Sequence[Experiment]]
    chapter: Callable[[Mapping[Any, Any]], Chapter]  # from the results by key
    seconds: float  # the time it takes, about: the longest is started first


def results_of(experiments: Sequence[Experiment], advance: Callable[[], None] | None = None) -> dict[Any, Any]:
    """Run the experiments in their order; return results by key. ``advance`` is called after each."""
    results = {}
    for experiment in experiments:
        results[experiment.key] = experiment.run()
        if advance is not None:
            advance()
    return results
