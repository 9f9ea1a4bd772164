"""The list of what is compiled for a wheel."""

from dataclasses import replace

import pytest

from kernels.tasks import ROOT, do, everyday, tasks
from robotics import CATALOGUE, scenario_names


def test_every_law_scenario_help_and_script_of_the_gallery_is_on_the_list(monkeypatch):
    monkeypatch.setitem(CATALOGUE, "new-law", replace(CATALOGUE["lyapunov"], title="New"))
    found = {task.name: task for task in tasks()}
    assert len(found) == len(tasks())  # names tell which were done
    for name in CATALOGUE:
        assert all(f" -c {name} " in line for line in found[f"the law {name}"].text.splitlines()), name
    assert {*scenario_names(), "anfis train", "robotics stress crossing", "systems/plot_surface.py"} <= {*found}
    assert len([task for task in found.values() if task.script]) >= len([*(ROOT / "examples").rglob("plot_*.py")])
    assert {task.name for task in everyday()} < {*found}


@pytest.mark.long
@pytest.mark.parametrize("task", [task for task in everyday() if task.script], ids=lambda task: task.name)
def test_a_script_of_the_list_runs(task, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert do(task)[2] == ""


def test_a_task_that_fails_says_why(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    (first, *_) = tasks()
    seconds, compiled, error = do(first._replace(text="robotics run no-such-scenario"))
    assert compiled == 0
    assert seconds > 0
    assert "no-such-scenario" in error
    assert do(first._replace(text="print(1 + 1)", script=True))[1:] == (0, "")
