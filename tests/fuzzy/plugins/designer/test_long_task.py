"""A long task of a panel: its news, what ends it, and that it does not outlive the process that began it."""

import os
import select
import signal
import subprocess
import sys
from multiprocessing import Pipe
from pathlib import Path
from typing import Any

import pytest

from fuzzy.errors import InputError
from fuzzy.plugins.designer import starting
from fuzzy.plugins.designer.longtask import Report, TaskProcess, do_task

LONG = 120.0  # s after which a process is given up


def count(most: int, report: Report) -> int:
    """Count until asked to stop: a task that ends at once."""
    for k in range(most):
        if not report("counted", k):
            return k
    return most


def refuse(name: str, report: Report) -> None:
    raise InputError(f"{name} is too large").about(name)


def open_forever(path: Path, report: Report) -> None:
    with path.open("w") as held:
        held.write("begun")
        held.flush()
        signal.pause()


def told(task: Any, work: Any, stop: bool = False) -> list[tuple[str, Any]]:
    ours, theirs = Pipe()
    if stop:
        ours.send("stop")
    do_task(task, work, theirs)
    found = []
    while ours.poll():
        found.append(ours.recv())
    return found


def test_what_a_task_reports_and_gives_is_news_until_it_is_asked_to_stop() -> None:
    assert told(2, count) == [("counted", 0), ("counted", 1), ("done", 2)]
    assert told(9, count, stop=True) == [("counted", 0), ("done", 0)]


def test_a_refusal_is_told_with_the_field_that_it_is_about() -> None:
    assert told("runs", refuse) == [("problem", {"message": "runs is too large", "field": "runs", "column": None})]


def test_a_start_of_a_stranger_that_fails_is_refused_with_what_it_raised(monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(*_: Any) -> Any:
        raise KeyError("sigma")

    monkeypatch.setattr(starting, "make", fails)
    ((what, about),) = told(("grid", {}, "new"), starting.report_making)
    assert (what, about["message"]) == ("problem", "KeyError: 'sigma'")


def test_nobody_who_listens_ends_a_task_without_a_word() -> None:
    ours, theirs = Pipe()
    ours.close()
    do_task(3, count, theirs)


def test_a_process_ends_with_its_result_or_when_it_is_closed() -> None:
    process = TaskProcess(10**9, count, "counting")
    news: list[tuple[str, Any]] = []
    while not news:
        news = process.news()
    process.stop()
    while process.alive:
        news += process.news()
    assert news[-1] == ("done", len(news) - 2)
    process.close()
    assert process.news() == []


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGTERM])
def test_a_task_is_killed_with_the_process_that_began_it(tmp_path: Path, how: signal.Signals) -> None:
    fifo = tmp_path / "held"
    os.mkfifo(fifo)
    text = (
        "import signal; from pathlib import Path; from fuzzy.plugins.designer.longtask import TaskProcess\n"
        "from tests.fuzzy.plugins.designer.test_long_task import open_forever\n"
        "if __name__ == '__main__':\n"
        f"    kept = TaskProcess(Path({str(fifo)!r}), open_forever, 'task')\n    signal.pause()\n"
    )
    (tmp_path / "began.py").write_text(text)
    root = str(Path(__file__).parents[4])
    path = os.pathsep.join([root, *filter(None, [os.environ.get("PYTHONPATH")])])
    parent = subprocess.Popen([sys.executable, tmp_path / "began.py"], env=os.environ | {"PYTHONPATH": path})
    with fifo.open("rb", buffering=0) as held:  # opens once the task does
        assert held.read(5) == b"begun"
        parent.send_signal(how)
        parent.wait()
        ready, _, _ = select.select([held], [], [], LONG)
        assert ready
        assert held.read() == b""  # whoever held the other end is gone
