"""Processes that die, what a stress test keeps then, and signals that are put off."""

import os
import signal
import threading
from contextlib import contextmanager

import pandas as pd
import pytest

from robotics.plugins.stress.crew import Crew
from robotics.plugins.stress.outcome import StressOutcome
from robotics.plugins.stress.running import in_pieces
from robotics.studies.executors import WorkerError, processes, uninterrupted

pytestmark = pytest.mark.skipif(os.name == "nt", reason="signals")


def dies_once(flag):
    if not flag.exists():
        flag.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return "done"


def dies():
    os._exit(3)


def fails():
    raise ValueError("no")


def outcome_of(seeds):
    return StressOutcome(pd.DataFrame({"seed": seeds, "robot": 1}))


def seeds_but_two(seeds):
    return dies() if 2 in seeds else outcome_of(seeds)


def test_a_process_that_dies_loses_nothing_and_one_that_always_dies_only_its_own(tmp_path, monkeypatch):
    with processes(2, [__name__]) as workers:
        submit = workers.executor.submit
        first, always, wrong = submit(dies_once, tmp_path / "flag"), submit(dies), submit(fails)
        others = [submit(pow, 2, k) for k in range(6)]
        assert [future.result() for future in others] == [2**k for k in range(6)]
        assert first.result() == "done"
        assert isinstance(always.exception(), WorkerError)
        assert isinstance(wrong.exception(), ValueError)

        @contextmanager
        def these(count, preload):
            yield workers

        monkeypatch.setattr("robotics.plugins.stress.crew.processes", these)
        found = in_pieces(seeds_but_two, 600, range(4), Crew(workers=2))
    assert (found.table["seed"].tolist(), found.missing, found.interrupted) == ([0, 1, 3], (range(2, 3),), False)
    assert "died" in found.reason


def test_ctrl_c_keeps_the_pieces_that_are_done():
    def stress(seeds):
        if 2 in seeds:
            raise KeyboardInterrupt
        return outcome_of(seeds)

    found = in_pieces(stress, 600, range(4), Crew(workers=1))
    assert (found.table["seed"].tolist(), found.missing, found.interrupted) == (
        [0, 1],
        (range(2, 3), range(3, 4)),
        True,
    )


def test_ctrl_c_is_put_off_where_there_are_other_threads_too():
    """The system gives a signal that the main thread does not take to another, and Python raises in the main one."""
    over, inside = threading.Event(), []
    thread = threading.Thread(target=over.wait)
    thread.start()
    before = signal.getsignal(signal.SIGINT)
    try:
        with uninterrupted():
            os.kill(os.getpid(), signal.SIGINT)
            threading.Event().wait(0.05)
            inside.append("to the end")
    except KeyboardInterrupt:
        inside.append("interrupted")
    finally:
        over.set()
        thread.join()
    assert inside == ["to the end", "interrupted"]
    assert signal.getsignal(signal.SIGINT) is before
