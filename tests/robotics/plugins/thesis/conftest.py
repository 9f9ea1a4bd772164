"""The experiments of the thesis's chapters, with few seeds; the costly ones are left out where a test does not ask."""

from collections.abc import Callable, Iterator
from typing import Any

import pytest

from robotics.plugins.thesis import avoidance_runs, team_runs, tracking
from robotics.plugins.thesis.experiment import Effort, results_of

FEW = Effort(seeds=4, trials=8)
Once = Callable[[str, Callable[[], Any]], Any]


def _results(module: Any, **changed: Any) -> dict[Any, Any]:
    patch = pytest.MonkeyPatch()
    for name, value in changed.items():
        patch.setattr(module, name, value)
    steps: list[int] = []
    wanted = module.experiments("", 3, FEW)
    found = results_of(wanted, lambda: steps.append(1))
    patch.undo()
    assert len(steps) == len(wanted) == len(found)  # the bar ends at its end, and no key stands twice
    return found


@pytest.fixture(scope="package")
def tracking_results(once: Once) -> Iterator[dict[Any, Any]]:
    """All experiments of the chapter on one robot, with one condition of the sweep for each latency."""
    patch = pytest.MonkeyPatch()
    patch.setattr(tracking, "_SWEEP", tracking._SWEEP[:3])
    yield once("tracking-results", lambda: _results(tracking))
    patch.undo()


@pytest.fixture(scope="package")
def team_results(once: Once) -> dict[Any, Any]:
    """All experiments of the chapter on teams, with smaller teams."""
    return dict(once("team-results", lambda: _results(team_runs, SIZES=(5, 10))))


@pytest.fixture(scope="package")
def avoidance_results(once: Once) -> dict[Any, Any]:
    """All experiments of the chapter on avoidance, with one case study and less time for what is not for claims."""
    less = {"FACTOR": 1.15, "LATEST": 1.1, "CASES": avoidance_runs.CASES[2:3]}
    return dict(once("avoidance-results", lambda: _results(avoidance_runs, **less)))
