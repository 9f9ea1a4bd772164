"""The panel "Train": a task learns what anfis.train learns, in a process that can be stopped; its module shows it."""

import asyncio
import os
import signal
import time
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any, ClassVar

import numpy as np
import pytest

import anfis
import fuzzy
from anfis.accuracy import accuracy
from anfis.methods.catalogue import METHODS
from anfis.plugins.designer import panel as designpanel
from anfis.plugins.designer import task as task_module
from anfis.plugins.designer.panel import TrainSession, generators, variables
from anfis.plugins.designer.task import (
    Ask,
    Generator,
    TrainingTask,
    TrainingTaskError,
    guessed,
    in_words,
    learn,
    split,
    starting_system,
    task_of,
    train_task,
)
from fuzzy.errors import InputError
from fuzzy.files.table import DataError
from fuzzy.fitting.clustering import DataWarning
from fuzzy.plugins.designer import longtask, tablesource
from fuzzy.plugins.designer.columns import LoadedTable, read_columns
from fuzzy.plugins.designer.longtask import TaskProcess
from fuzzy.plugins.designer.workers import WorkError
from tests.browsers import run_apart

RNG = np.random.default_rng(5)
X = RNG.uniform([-1, 10], [3, 30], (60, 2))
Y = np.stack([np.sin(X[:, 0]), 0.002 * X[:, 1] ** 2], axis=1)
TABLE = LoadedTable("made up", ("a", "b", "y", "z"), np.concatenate([X, Y], axis=1))
ROLES = {"a": "input", "b": "input", "y": "output", "z": "output"}
TEXT = "a,b,y,z\n" + "".join(",".join(map(repr, row)) + "\n" for row in TABLE.values.tolist())
START = fuzzy.identify(X, Y, "grid", mfs=2, input_names=["a", "b"], output_names=["y", "z"], name="start")


def quiet(what: str, about: Any) -> bool:
    return True


# The task -------------------------------------------------------------------------------------------------------


def test_the_split_is_the_seed_s_and_leaves_nothing_out() -> None:
    rows, held = split(60, 12, 3)
    assert len(held) == 12
    assert sorted([*rows, *held]) == list(range(60))
    assert np.array_equal(held, split(60, 12, 3)[1])
    assert not np.array_equal(held, split(60, 12, 4)[1])


@pytest.mark.parametrize("method", METHODS)
def test_a_task_learns_what_train_learns(method: Any) -> None:
    task = task_of(TABLE, ROLES, None, start="grid", mfs=2, method=method, epochs=4, share=0.25, seed=1)
    rows, held = split(60, 15, 1)
    begin = fuzzy.identify(X[rows], Y[rows], "grid", mfs=2, input_names=["a", "b"], output_names=["y", "z"])
    begin = replace(begin, name="learnt")
    direct = anfis.train(
        replace(begin, out_of_range="ignore"),
        X[rows],
        Y[rows],
        anfis.Options(method=method, epochs=4),
        check=(X[held], Y[held]),
    )
    heard: list[Any] = []
    result = learn(task, lambda what, about: heard.append((what, about)) or True)
    assert result.history == direct.history
    assert result.system == replace(direct.system, out_of_range="warn")
    assert heard[0] == ("start", begin)
    assert tuple(about for what, about in heard if what == "epoch") == direct.history


def test_it_stops_when_asked_and_gives_the_best_so_far() -> None:
    task = task_of(TABLE, {n: n for n in "abyz"}, START, method="second-order", epochs=50, share=0.2)
    asked: list[Any] = []

    def twice(what: str, about: Any) -> bool:
        asked.extend([about] if what == "epoch" else [])
        return len(asked) < 3

    result = learn(task, twice)
    assert result.stopped == "callback"
    assert len(result.history) == 3
    assert result.best == int(np.argmin([row.check for row in asked]))
    assert result.system.out_of_range == START.out_of_range


@pytest.mark.parametrize("share", [0.0, 0.3])
def test_the_best_so_far_is_told_with_each_improvement(monkeypatch: pytest.MonkeyPatch, share: float) -> None:
    monkeypatch.setattr(task_module, "_RARELY", 0.0)
    task = task_of(TABLE, ROLES, None, start="grid", mfs=2, method="second-order", epochs=6, share=share)
    heard: list[tuple[str, Any]] = []
    result = learn(task, lambda what, about: heard.append((what, about)) or True)
    rows, held = split(60, task.checking, task.seed)
    of, column = (held, "check") if share else (rows, "train")
    least, told = np.inf, 0
    for (before, system), (what, epoch) in pairwise(heard):
        if what != "epoch":
            continue
        error = getattr(epoch, column)
        assert (before == "best") == (error < least)
        if before == "best":
            least, told = error, told + 1
            off = replace(system, out_of_range="ignore")(X[of]) - Y[of]
            assert float(np.sqrt(np.mean(off**2))) == pytest.approx(error, rel=1e-9)
    assert told >= 2
    assert [about for what, about in heard if what == "best"][-1] == result.system
    monkeypatch.setattr(task_module, "_RARELY", 1e9)
    heard.clear()
    learn(task, lambda what, about: heard.append((what, about)) or True)
    assert [what for what, _ in heard].count("best") == 1  # the first, and then none for long


def test_starting_systems() -> None:
    present = task_of(TABLE, {n: n for n in "abyz"}, START)
    assert starting_system(present) is START
    clusters = starting_system(task_of(TABLE, ROLES, None, start="subtractive", radius=0.6, share=0.0))
    direct = fuzzy.identify(X, Y, "subtractive", radius=0.6, input_names=["a", "b"], output_names=["y", "z"])
    assert clusters == replace(direct, name="learnt")
    assert variables(START)[1] == {
        "name": "b",
        "unit": "",
        "low": X[:, 1].min(),
        "high": X[:, 1].max(),
        "terms": [
            {"name": name, "type": "gbellmf", "parameters": list(f.parameters)}
            for name, f in START.inputs[1].terms.items()
        ],
    }


@pytest.mark.parametrize(
    ("columns", "settings", "says"),
    [
        ({"a": "input"}, {"start": "grid"}, "one an output"),
        ({"a": "a", "b": "b", "y": "y"}, {}, "no column of made up is chosen for z"),
        ({"a": "a", "b": "a", "y": "y", "z": "z"}, {}, "column 'a' is chosen twice"),
        (ROLES, {"start": "grids"}, "did you mean 'grid'"),
        (ROLES, {"start": "grid", "mfs": 1}, "mfs must be a whole number >= 2 and <= 20; got 1"),
        (ROLES, {"start": "grid", "epochs": 1.5}, "epochs must be a whole number"),
        (ROLES, {"start": "grid", "epochs": True}, "epochs must be a whole number"),
        (ROLES, {"start": "grid", "method": "jang"}, "unknown method"),
        (ROLES, {"start": "subtractive", "radius": 0}, "radius must be a finite number, > 0"),
        (ROLES, {"start": "subtractive", "radius": None}, "radius must be a finite number"),
        (ROLES, {"start": "grid", "share": 0.9}, "share must be a finite number, >= 0 and <= 0.8"),
        (ROLES, {"start": "grid", "goal": float("nan")}, "goal must be a finite number, >= 0"),
        (ROLES, {"start": "grid", "lucky": 7}, "unknown setting 'lucky'"),
    ],
)
def test_choices_that_do_not_go_together(columns: dict[str, str], settings: dict[str, Any], says: str) -> None:
    with pytest.raises(TrainingTaskError) as caught:
        task_of(TABLE, columns, START, **settings)
    assert says in str(caught.value)


def test_what_cannot_be_learnt_is_said() -> None:
    with pytest.raises(TrainingTaskError, match="has no rule in force"):
        learn(task_of(TABLE, {n: n for n in "abyz"}, replace(START, rules=())), quiet)
    with pytest.raises(InputError, match="rules, more than"):
        learn(task_of(TABLE, {**ROLES, "y": "input"}, None, start="grid", mfs=20), quiet)
    few = LoadedTable("few", TABLE.names, TABLE.values[:1])
    with pytest.raises(TrainingTaskError, match="leave none to learn from"):
        task_of(few, ROLES, None, start="grid")


def test_tables_are_read_and_guessed() -> None:
    table = read_columns("x.csv", TEXT)
    assert table.names == TABLE.names
    assert np.array_equal(table.values, TABLE.values)
    assert guessed(table, START) == {n: n for n in "abyz"}
    assert guessed(table, None) == {"a": "input", "b": "input", "y": "input", "z": "output"}
    assert guessed(table._replace(inputs=1), None)["b"] == "output"
    bare = read_columns("bare.csv", TEXT.partition("\n")[2])
    assert bare.names == ("column1", "column2", "column3", "column4")
    assert guessed(bare, START) == dict(zip("abyz", bare.names, strict=True))
    with pytest.raises(DataError, match=r"^x\.csv, line 2: a quotation mark is not closed$"):
        read_columns("x.csv", 'a,b\n"1,2\n')
    with pytest.raises(DataError, match=r"^x\.csv: no row of numbers follows the header$"):
        read_columns("x.csv", "a,b\n")


LOG = """Time;T [°C];p (bar);T [K];;y [mm];Note
09:00;1,5;0;300;x;1,0;
09:01;2,5;1;301;x;2,0;late
09:02;3,5;;302;x;3,0;
09:03;4,5;3;303;x;4,0;
"""


def test_columns_that_cannot_be_learnt_from_are_not_in_the_way() -> None:
    table = read_columns("log.csv", LOG.encode("utf-16"))
    assert table.names == ("Time", "T [°C]", "p", "T [K]", "column5", "y", "Note")
    assert table.usable == ["T [°C]", "p", "T [K]", "y"]
    assert guessed(table, None) == {
        "Time": "unused", "T [°C]": "input", "p": "input", "T [K]": "input", "column5": "unused", "y": "output",
        "Note": "unused",
    }  # fmt: skip
    chosen = {"T [°C]": "input", "p": "input", "y": "output"}
    with pytest.raises(
        TrainingTaskError, match=r"log.csv: 1 of 4 rows has no number in 'p' \(line 4\); leave such rows out, or"
    ):
        task_of(table, chosen, None, start="grid", share=0)
    task = task_of(table, chosen, None, start="grid", share=0, skip_bad=True)
    assert task.x.tolist() == [[1.5, 0], [2.5, 1], [4.5, 3]]
    assert task.y.tolist() == [[1], [2], [4]]
    with pytest.warns(DataWarning, match="the 3 samples determine"):
        fis = starting_system(task)
    assert [(v.name, v.unit) for v in (*fis.inputs, *fis.outputs)] == [("T", "°C"), ("p", "bar"), ("y", "mm")]
    assert guessed(table, fis) == {"p": "p", "y": "y", "T": "T [°C]"}
    for more, says in (
        ({"T [K]": "input"}, "two chosen columns are called 'T'"),
        ({"Note": "input"}, "'Note' holds no numbers"),
    ):
        with pytest.raises(InputError, match=says):
            task_of(table, {**chosen, **more}, None, start="grid", skip_bad=True)
    doubtful = read_columns("d.csv", "x;y;z\n1.500;2,5;1\n1.750;3;2\n")
    with pytest.raises(DataError, match=r"d\.csv: 'x' holds '1\.500', of which the point may mark thousands"):
        task_of(doubtful, {"x": "input", "z": "output"}, None, start="grid")
    assert task_of(doubtful, {"y": "input", "z": "output"}, None, start="grid", share=0).x.tolist() == [[2.5], [3]]


def test_data_come_from_whoever_makes_some() -> None:
    found = {g.name: g for g in generators()}
    assert {*found} >= {"formation-literal", "formation-well-posed", "formation-scenario"}
    assert found["formation-literal"].asks is None


def test_a_generator_may_ask_before_it_makes_data(tmp_path: Path) -> None:
    asked = (Ask("who", "Robot", (), "2"), Ask("what", "Output", (("v", "speed"), ("w", "turn rate")), "v"))
    made: list[Any] = []

    def make(folder: Path, chosen: dict[str, str]) -> LoadedTable:
        made.append((folder, chosen))
        return TABLE

    async def scene() -> None:
        bench = Bench(START, tmp_path)
        session = TrainSession(bench)
        session.made["mine"] = Generator("mine", "Mine", make, lambda folder: asked)
        for chosen, says in (
            (None, "say what is chosen"),
            ({"who": 3}, "say what is chosen"),
            ({"who": "0"}, "Robot must be a whole number >= 1, got '0'"),
            ({"what": "x"}, "unknown output 'x'"),
        ):
            await bench.say({"do": "generate", "name": "mine", "chosen": chosen})
            assert says in bench.said
        assert made == []
        await bench.say({"do": "generate", "name": "mine", "chosen": {"what": "w"}})
        assert made == [(tmp_path, {"who": "2", "what": "w"})]
        assert bench.traits["table"]["rows"] == 60
        sources = {name: asks for name, _, asks in bench.traits["sources"]["generators"]}
        assert sources["mine"][1] == {"name": "what", "title": "Output", "options": asked[1].options, "value": "v"}

    run_apart(scene())


# The process ----------------------------------------------------------------------------------------------------


def until_over(process: TaskProcess) -> list[tuple[str, Any]]:
    news, end = [], time.monotonic() + 120
    while process.alive:
        assert time.monotonic() < end
        news += process.news()
        time.sleep(0.02)
    return [(what, about["message"] if what == "problem" else about) for what, about in news]


def begun(task: TrainingTask) -> TaskProcess:
    return TaskProcess(task, train_task, "training")


def test_what_goes_wrong_in_the_process_is_news() -> None:
    process = begun(task_of(TABLE, {n: n for n in "abyz"}, replace(START, rules=())))
    assert until_over(process) == [
        ("problem", "start has no rule in force, so there is nothing to learn: start from clusters")
    ]
    process.close()
    killed = begun(task_of(TABLE, {n: n for n in "abyz"}, START, epochs=10_000))
    assert killed._process.pid is not None
    os.kill(killed._process.pid, signal.SIGKILL)
    assert until_over(killed) == [("problem", "the training ended unexpectedly (exit code -9)")]
    killed.stop()  # nobody hears it, and nothing happens
    killed.close()
    closed = begun(task_of(TABLE, {n: n for n in "abyz"}, START, epochs=10_000))
    closed.close()
    assert not closed._process.is_alive()
    assert closed.news() == []


def test_too_little_memory_is_said_with_what_helps(monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(*_: Any) -> Any:
        raise MemoryError

    monkeypatch.setattr(task_module, "learn", fails)
    with pytest.raises(TrainingTaskError, match="needs more memory than there is: fewer rules or samples"):
        train_task(task_of(TABLE, {n: n for n in "abyz"}, START), quiet)


# The session ----------------------------------------------------------------------------------------------------


class Bench:
    """What the designer's page offers to a panel, without a page."""

    say: Any  # what the panel listens with

    def __init__(self, fis: fuzzy.Sugeno, folder: Path) -> None:
        self.document: Any = SimpleNamespace(
            design=SimpleNamespace(in_force=fis),
            folder=folder,
            table="",
            replace=lambda *args, **more: self.edits.append((*args, more)),
        )
        self.edits: list[Any] = []
        self.traits: dict[str, Any] = {}
        self.looked: list[tuple[Any, ...]] = []
        self.closers: list[Any] = []

    def widget(self, module: Path, **traits: Any) -> Any:
        assert module.is_file()
        self.traits.update(traits)
        return SimpleNamespace(update=self.traits.update, on_message=lambda f: setattr(self, "say", f))

    def on_change(self, callback: Any) -> None:
        self.changed = callback

    def on_close(self, callback: Any) -> None:
        self.closers.append(callback)

    async def background(self, function: Any, *args: Any) -> Any:
        return await asyncio.to_thread(function, *args)

    async def read(self, name: str, function: Any, *args: Any) -> Any:
        return await asyncio.to_thread(function, *args)

    def look_at(self, point: Any) -> None:
        self.looked.append((point,))

    def show(self, title: str) -> None:
        self.looked[-1] += (title,)

    @property
    def said(self) -> str:
        return (self.traits["problem"] or {}).get("message", "")


def test_from_a_file_to_one_edit_of_the_design(tmp_path: Path) -> None:
    (tmp_path / "made.csv").write_text(TEXT)

    async def scene() -> None:
        bench = Bench(START, tmp_path)
        session = TrainSession(bench)
        assert bench.traits["sources"]["files"] == ["made.csv"]
        await bench.say({"do": "file", "name": "made.csv"})
        assert bench.traits["table"]["rows"] == 60
        assert bench.traits["columns"] == {n: n for n in "abyz"}
        for name, value in (("method", "second-order"), ("epochs", 10_000), ("share", 0.25), ("seed", 2)):
            await bench.say({"do": "choose", "name": name, "value": value})
        await bench.say({"do": "take"})
        assert bench.said == "there is no trained system to take yet"
        await bench.say({"do": "train"})
        assert bench.said == ""
        await bench.say({"do": "train"})
        assert "runs already" in bench.said
        turns = 0
        while len(bench.traits["progress"]["epoch"]) < 3 and session.process is not None:
            turns += 1  # the page lives: its loop goes round while the process learns
            await asyncio.sleep(0.02)
        assert turns > 3
        await bench.say({"do": "stop"})
        assert session.watching is not None
        await session.watching
        progress = bench.traits["progress"]
        last = progress["epoch"][-1]
        rows, held = split(60, 15, 2)
        direct = anfis.train(
            replace(START, out_of_range="ignore"),
            X[rows],
            Y[rows],
            anfis.Options(method="second-order", epochs=last),
            check=(X[held], Y[held]),
        )
        assert progress["state"] == "done"
        assert progress["train"] == [row.train for row in direct.history]
        assert progress["check"] == [row.check for row in direct.history]
        assert progress["best"]["epoch"] == direct.best
        assert progress["outputs"] == 2
        # The samples beside the best system, training and checking samples apart
        assert session.pictures.task is not None
        await session.pictures.task
        pictures, points = bench.traits["pictures"], bench.traits["points"]
        for kind, of in (("training", rows), ("checking", held)):
            for name, wanted in accuracy(direct.system, X[of], Y[of]).items():
                found = next(f for f in pictures["figures"] if (f["output"], f["kind"]) == (name, kind))
                assert found["rows"] == len(of)
                assert [found[k] for k in wanted._fields] == pytest.approx(list(wanted), rel=1e-9)
        assert [row for row, checked in zip(points["row"], points["checking"], strict=True) if checked] == held.tolist()
        assert points["line"] == [k + 2 for k in range(60)]
        np.testing.assert_allclose(bench.traits["residual"], Y[:, 0] - direct.system(X)[:, 0], rtol=1e-5, atol=1e-9)
        await bench.say({"do": "output", "value": 1})
        await session.pictures.task
        np.testing.assert_allclose(bench.traits["residual"], Y[:, 1] - direct.system(X)[:, 1], rtol=1e-5, atol=1e-9)
        await bench.say({"do": "look", "row": 7})
        assert bench.looked == [(X[7].tolist(), "Viewer")]
        for message in ({"do": "look", "row": 60}, {"do": "look", "row": "7"}, {"do": "output", "value": 2}):
            await bench.say(message)
            assert "there is no such" in bench.said
        assert bench.traits["before"] == variables(START)
        assert bench.traits["after"] == variables(direct.system)
        await bench.say({"do": "take"})
        assert bench.edits == [
            (
                replace(direct.system, out_of_range="warn"),
                f"train (second-order, epoch {direct.best})",
                {"keep_disabled": True},  # rules that were not in force were not learnt either
            )
        ]

    run_apart(scene())


class Idle:
    """A process that says nothing until it is told to end."""

    def __init__(self, task: TrainingTask, *_: Any) -> None:
        self.task, self.alive, self.heard = task, True, ""

    def news(self) -> list[Any]:
        return []

    def stop(self) -> None:
        self.heard = "stop"

    def close(self) -> None:
        self.alive = False


def test_the_table_that_another_panel_looks_at_is_the_first(tmp_path: Path) -> None:
    (tmp_path / "made.csv").write_text(TEXT)

    async def scene() -> None:
        bench = Bench(START, tmp_path)
        TrainSession(bench)
        await bench.say({"do": "file", "name": "made.csv"})
        other = Bench(START, tmp_path)
        other.document = bench.document
        session = TrainSession(other)
        while other.traits["table"] is None:
            await asyncio.sleep(0.01)
        assert other.traits["columns"] == {n: n for n in "abyz"}
        (tmp_path / "made.csv").unlink()
        assert TrainSession(other).table is None
        session.close()

    run_apart(scene())


def test_closing_the_page_ends_the_training(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(longtask, "TaskProcess", Idle)

    async def scene() -> None:
        bench = Bench(START, tmp_path)
        session = TrainSession(bench)
        pieces = [TEXT[k : k + 500] for k in range(0, len(TEXT), 500)]
        for k, piece in enumerate(pieces):
            last = k == len(pieces) - 1
            await bench.say({"do": "piece", "name": "../up.csv", "number": k, "text": piece, "last": last})
        assert bench.traits["table"]["name"] == "up.csv"
        await bench.say({"do": "choose", "name": "start", "value": "grid"})
        assert bench.traits["columns"] == {"a": "input", "b": "input", "y": "input", "z": "output"}
        await bench.say({"do": "column", "name": "y", "value": "output"})
        await bench.say({"do": "train"})
        process: Any = session.process
        assert process.task.outputs == ("y", "z")
        assert np.array_equal(process.task.x, X)
        assert bench.traits["progress"]["state"] == "starting"
        for close in bench.closers:
            close()
        assert not process.alive
        assert session.process is None
        await session.watching

    run_apart(scene())


def test_rows_without_a_number_are_left_out_by_a_click(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "log.csv").write_text(LOG, encoding="utf-8")
    monkeypatch.setattr(designpanel, "generators", list)
    monkeypatch.setattr(longtask, "TaskProcess", Idle)

    async def scene() -> None:
        bench = Bench(START, tmp_path)
        session = TrainSession(bench)
        await bench.say({"do": "choose", "name": "start", "value": "grid"})
        await bench.say({"do": "file", "name": "log.csv"})
        about = {c["name"]: (c["unit"], c["low"], c["high"]) for c in bench.traits["table"]["columns"]}
        assert about["p"] == ("bar", 0.0, 3.0)
        assert about["Time"] == ("", None, None)
        assert bench.traits["lack"] == "1 of 4 rows has no number in 'p' (line 4)"
        assert bench.traits["unit"] == "mm"
        await bench.say({"do": "column", "name": "T [K]", "value": "unused"})
        await bench.say({"do": "train"})
        assert (
            bench.said
            == "log.csv: 1 of 4 rows has no number in 'p' (line 4); leave such rows out, or choose other columns"
        )
        await bench.say({"do": "choose", "name": "skip_bad", "value": True})
        await bench.say({"do": "train"})
        assert bench.said == ""
        process: Any = session.process
        assert len(process.task.x) == 3
        assert bench.traits["progress"]["unit"] == "mm"
        assert bench.traits["progress"]["words"] == ["1 of 4 rows are left out"]
        session.close()
        assert session.watching is not None
        await session.watching

    run_apart(scene())


class Slow(Idle):
    """A process that takes its time to start."""

    started: ClassVar[list["Slow"]] = []

    def __init__(self, task: TrainingTask, *_: Any) -> None:
        super().__init__(task)
        time.sleep(0.05)
        self.started.append(self)


@pytest.mark.parametrize("end", ["stop", "close", "neither"])
def test_two_wishes_to_train_at_once_start_one_process(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, end: str
) -> None:
    (tmp_path / "made.csv").write_text(TEXT)
    monkeypatch.setattr(longtask, "TaskProcess", Slow)
    monkeypatch.setattr(designpanel, "generators", list)
    Slow.started.clear()

    async def scene() -> None:
        bench = Bench(START, tmp_path)
        session = TrainSession(bench)
        await bench.say({"do": "file", "name": "made.csv"})
        first, second = bench.say({"do": "train"}), bench.say({"do": "train"})
        await asyncio.sleep(0.01)  # both have been heard, no process is up yet
        assert Slow.started == []
        if end == "stop":
            await bench.say({"do": "stop"})
        elif end == "close":
            session.close()
        await asyncio.gather(first, second)
        assert len(Slow.started) == 1
        if end == "close":
            assert not Slow.started[0].alive
            return
        assert Slow.started[0].heard == ("stop" if end == "stop" else "")
        assert bench.traits["progress"]["state"] == ("stopping" if end == "stop" else "starting")
        session.close()
        assert not Slow.started[0].alive
        assert session.watching is not None
        await session.watching

    run_apart(scene())


def test_a_process_that_cannot_be_started_leaves_the_way_free(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "made.csv").write_text(TEXT)

    def refuses(task: TrainingTask, *_: Any) -> Any:
        raise WorkError("no more processes")

    monkeypatch.setattr(longtask, "TaskProcess", refuses)
    monkeypatch.setattr(designpanel, "generators", list)

    async def scene() -> None:
        bench = Bench(START, tmp_path)
        TrainSession(bench)
        await bench.say({"do": "file", "name": "made.csv"})
        for _ in range(2):
            await bench.say({"do": "train"})
            assert bench.said == "no more processes"
            assert bench.traits["progress"]["state"] == "idle"

    run_apart(scene())


def test_wrong_wishes_get_sentences(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    secret = tmp_path / "secret.csv"
    secret.write_text("a,b\n1,2\n")
    folder = tmp_path / "open"
    folder.mkdir()
    (folder / "link.csv").symlink_to(secret)
    (folder / "bad.csv").write_text('a,b\n1,"x\n')
    (folder / "bytes.csv").write_bytes(b"\xff\xfe\x00")
    monkeypatch.setattr(tablesource, "LARGEST_FILE", 1000)

    async def scene() -> None:
        bench = Bench(START, folder)
        TrainSession(bench)
        for message, says in (
            (None, "unknown wish"),
            ({"do": ["train"]}, "unknown wish"),
            ({"do": "train"}, "choose data first"),
            ({"do": "stop"}, "no training runs"),
            ({"do": "file", "name": "link.csv"}, "unknown file of the folder 'link.csv'"),
            ({"do": "file", "name": "../secret.csv"}, "unknown file of the folder"),
            ({"do": "file", "name": ["bad.csv"]}, "unknown file of the folder"),
            ({"do": "file", "name": "bad.csv"}, "bad.csv, line 2: a quotation mark is not closed"),
            ({"do": "file", "name": "bytes.csv"}, "bytes.csv: not text in UTF-16"),
            ({"do": "generate", "name": "formation"}, "unknown generator of data"),
            ({"do": "piece", "name": "x.csv", "number": 3, "text": "1"}, "did not arrive whole"),
            ({"do": "piece", "name": "x.csv", "number": 0, "text": "1" * 1001}, "is larger than"),
            ({"do": "piece", "name": "x.csv", "number": 0}, "pieces of text"),
            ({"do": "choose", "name": "device", "value": "cuda"}, "unknown setting 'device'"),
            ({"do": "column", "name": "a", "value": 3}, "a choice of a column"),
        ):
            await bench.say(message)
            assert says in bench.said, message
        assert bench.traits["table"] is None

    run_apart(scene())


@pytest.mark.parametrize(
    ("history", "parameters", "samples", "said"),
    [
        # (epoch, training error, checking error): what a reader of the curve would say
        ([(0, 1.0, 1.0), (1, 0.5, 0.55), (2, 0.4, 0.45)], 10, 400, []),
        (
            [(0, 1.0, 1.0), (4, 0.25, 0.29), (60, 0.05, 2.0)],
            45,
            48,
            ["1.1 for each: few", "From epoch 4 on", "6.9 times"],
        ),
        ([(0, 1.0, 1.0), (9, 0.1, 0.5)], 10, 400, ["5 times the training error"]),
        ([(0, 1.0, float("nan")), (9, 0.1, float("nan"))], 10, 400, []),
        ([(0, 0.0, 0.1), (9, 0.0, 0.1)], 10, 400, []),
    ],
)
def test_numbers_of_a_training_are_said_in_words(history, parameters, samples, said):
    found = " ".join(in_words(history, parameters, samples))
    assert all(part in found for part in said)
    assert bool(found) == bool(said)
