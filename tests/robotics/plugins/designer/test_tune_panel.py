"""The panel "Tune": what it refuses, what it keeps of a search, and what becomes of the design meanwhile."""

import asyncio
import json
from collections.abc import Awaitable, Callable
from dataclasses import replace
from multiprocessing import Pipe
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from fuzzy.errors import InputError
from fuzzy.files.fisfile import format_fis, parse_fis, write_fis
from fuzzy.plugins.designer import longtask
from fuzzy.plugins.designer.document import Document
from fuzzy.plugins.designer.longtask import do_task
from fuzzy.system import Constant, Sugeno
from fuzzy.tuning.parameter import TuningError
from robotics.laws.tracking.fuzzy_tracking import load_rule_base
from robotics.plugins.designer import tunetask
from robotics.plugins.designer.tunepanel import TuneSession
from robotics.plugins.designer.tunetask import (
    TuneTask,
    checked,
    found_at,
    offered,
    place_of,
    search_best,
    terms_of,
    write_task,
)
from tests.browsers import run_apart

BASE = load_rule_base("tracking")
CHOICE: dict[str, Any] = {
    "law": "fuzzy/tracking", "move": ["consequents"], "still": [], "symmetric": True, "scenarios": ["fuzzy-off-path"],
    "noise": True, "terms": terms_of("tracking"), "runs": 2, "evaluations": 30, "engine": "random", "seed": 1,
}  # fmt: skip


def task_in(folder: Path, **more: Any) -> TuneTask:
    settings: dict[str, Any] = {
        "system": format_fis(BASE), "law": "fuzzy", "task": "tracking", "move": ("consequents",),
        "scenarios": (("fuzzy-off-path", None),), "terms": tuple(map(tuple, terms_of("tracking"))), "runs": 2,
        "evaluations": 30, "engine": "random", "folder": str(folder), "place": str(place_of(folder / "demo.fis")),
    }  # fmt: skip
    return TuneTask(**settings | more)


def moved(fis: Sugeno, value: float) -> Sugeno:
    output = fis.outputs[0]
    terms = dict(output.terms) | {list(output.terms)[-1]: Constant(value)}
    return replace(fis, outputs=[replace(output, terms=terms), *fis.outputs[1:]])


@pytest.mark.parametrize(
    ("field", "value", "says"),
    [
        ("runs", 0, "runs must be a whole number from 1 to 1000; got 0"),
        ("evaluations", 2.5, "evaluations must be a whole number"),
        ("seed", True, "seed must be a whole number"),
        ("engine", "cma", "did you mean 'cmaes'"),
        ("move", [], "choose what may move"),
        ("move", ["membership"], "did you mean 'memberships'"),
        ("scenarios", [], "choose at least one scenario"),
        ("noise", 1, "noise must be true or false"),
        ("terms", [["rms_distance_late_m", 0, 1]], "the scale of rms_distance_late_m must be a number > 0"),
        ("terms", [["rms_distance", 1, 1]], "rms_distance"),
        ("terms", [["rms_distance_late_m", 1, 0]], "at least one term of the cost needs a weight > 0"),
    ],
)
def test_what_cannot_be_asked_is_said_about_its_field(field: str, value: Any, says: str) -> None:
    checked(CHOICE)
    with pytest.raises(TuningError) as caught:
        checked(CHOICE | {field: value})
    assert says in str(caught.value)
    assert caught.value.at == (field,)


def test_a_system_is_offered_its_laws_and_what_stays_still_does_not_move(tmp_path: Path) -> None:
    about = offered(BASE, "demo.fis")
    assert about["laws"][0]["law"] == "fuzzy"
    assert about["symmetric"]
    names = [p.name for p in task_in(tmp_path).space().parameters]
    still = [p.name for p in task_in(tmp_path, still=("v",)).space().parameters]
    assert still == [name for name in names if not name.startswith("v.")]
    assert 0 < len(still) < len(names)
    with pytest.raises(TuningError, match="nothing may move"):
        task_in(tmp_path, still=("v", "w")).space()
    strange = replace(BASE, inputs=[replace(BASE.inputs[0], name="mood"), *BASE.inputs[1:]], rules=())
    with pytest.raises(InputError, match="no robot knows the input 'mood'"):
        offered(strange, "demo.fis")


def test_a_search_leaves_its_best_and_goes_on_to_the_same(tmp_path: Path) -> None:
    def searched(task: TuneTask, stop: bool) -> list[Any]:
        ours, theirs = Pipe()
        if stop:
            ours.send("stop")
        do_task(task, search_best, theirs)
        found = []
        while ours.poll():
            found.append(ours.recv())
        return found

    whole = task_in(tmp_path / "a", place=str(tmp_path / "a" / "x"))
    write_task(whole)
    news = searched(whole, stop=False)
    assert [what for what, _ in news][:2] == ["start", "search"]
    assert news[-1][0] == "done", news[-1]
    assert "50 unseen seeds" in news[-1][1]["sentence"]
    left = found_at(Path(whole.place), tmp_path / "a")
    assert left is not None
    assert left["task"] == whole
    assert left["best"]["cost"] < left["best"]["before"]
    shown = [about["candidate"] for what, about in news if what == "search" and "candidate" in about]
    assert parse_fis(shown[-1]["system"]) == parse_fis(left["best"]["system"]) != BASE
    assert shown[-1]["paths"][0] != news[0][1]["paths"][0]

    part = task_in(tmp_path / "b", place=str(tmp_path / "b" / "x"))
    write_task(part)
    assert searched(part, stop=True)[-1][1]["stopped"]
    first = json.loads((tmp_path / "b" / "x" / "best.json").read_text())
    assert first["cost"] == first["before"]  # after the first generation, which is the system as it was
    assert searched(part, stop=False)[-1] == news[-1]
    assert (tmp_path / "b" / "x" / "history.csv").read_bytes() == (tmp_path / "a" / "x" / "history.csv").read_bytes()


def test_too_little_memory_is_said_where_it_can_be_helped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(*_: Any) -> Any:
        raise MemoryError

    monkeypatch.setattr(tunetask, "simulate", fails)
    with pytest.raises(TuningError, match="needs more memory than there is: fewer runs") as caught:
        search_best(task_in(tmp_path), lambda what, about: True)
    assert caught.value.at == ("runs",)


class Scripted:
    """A process whose news are the test's."""

    def __init__(self, task: TuneTask, *_: Any) -> None:
        self.task, self.stopped, self.alive = task, False, True
        self.script: list[Any] = []

    def news(self) -> list[Any]:
        told, self.script = self.script, []
        if self.stopped and not told:
            told = [("done", {"sentence": "said", "stopped": True, "gains": {}})]
        self.alive = not (told and told[-1][0] in ("done", "problem"))
        return told

    def stop(self) -> None:
        self.stopped = True

    def close(self) -> None:
        self.alive = False


class Bench:
    """What the designer's page offers to a panel, without a page, and with a real document."""

    say: Any
    closed = False

    def __init__(self, folder: Path) -> None:
        if not (folder / "demo.fis").exists():
            write_fis(BASE, folder / "demo.fis")
        self.document = Document("demo.fis", folder)
        self.traits: dict[str, Any] = {}

    def widget(self, module: Path, **traits: Any) -> Any:
        assert module.is_file()
        self.traits.update(traits)
        return SimpleNamespace(update=self.traits.update, on_message=lambda f: setattr(self, "say", f))

    def on_change(self, callback: Any) -> None:
        pass

    def on_close(self, callback: Any) -> None:
        pass

    async def background(self, function: Any, *args: Any) -> Any:
        return await asyncio.to_thread(function, *args)

    async def read(self, name: str, function: Any, *args: Any) -> Any:
        return await asyncio.to_thread(function, *args)


def candidate(value: float, cost: float) -> tuple[str, Any]:
    about = {"system": format_fis(moved(BASE, value)), "cost": cost, "before": 2.0, "paths": [], "gains": {}}
    return "search", {"evaluations": 9, "curve": [[1, 2.0], [9, cost]], "candidate": about}


def scene(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, play: Callable[[Bench, TuneSession], Awaitable[None]]
) -> None:
    monkeypatch.setattr(longtask, "TaskProcess", Scripted)
    monkeypatch.setattr(longtask, "EVERY", 0.001)

    async def whole() -> None:
        bench = Bench(tmp_path)
        session = TuneSession(bench)
        await session.asking
        session.choice = dict(CHOICE)
        await play(bench, session)
        session.close()

    run_apart(whole())


async def begun(bench: Bench, session: TuneSession) -> Any:
    await bench.say({"do": "start"})
    assert bench.traits["problem"] is None
    process: Any = session.process
    process.script = [("start", {"parameters": 4, "courses": [], "paths": []}), candidate(0.3, 1.5)]
    await until(lambda: bench.document.design.in_force == moved(BASE, 0.3))
    process.script = [candidate(0.35, 1.2)]
    await until(lambda: bench.document.design.in_force == moved(BASE, 0.35))
    return process


async def until(true: Callable[[], bool]) -> None:
    for _ in range(2000):
        if true():
            return
        await asyncio.sleep(0.001)
    raise AssertionError("it did not become true")


def test_all_candidates_are_one_edit_that_is_kept_undone_or_discarded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def play(bench: Bench, session: TuneSession) -> None:
        await begun(bench, session)
        await bench.say({"do": "start"})
        assert "a search runs already" in bench.traits["problem"]["message"]
        await bench.say({"do": "stop"})
        await until(lambda: session.state == "done")
        await bench.say({"do": "compare", "value": True})
        assert bench.document.compared is not None
        await bench.say({"do": "keep"})
        assert bench.document.compared is None
        assert bench.document.design.in_force == moved(BASE, 0.35)
        assert bench.traits["left"] is None
        bench.document.undo()
        assert bench.document.design.in_force == BASE
        assert bench.document.can_undo is None
        process = await begun(bench, session)
        process.stop()
        await until(lambda: session.state == "done")
        await bench.say({"do": "discard"})
        assert bench.document.design.in_force == BASE
        assert bench.document.can_undo is None

    scene(tmp_path, monkeypatch, play)


def test_an_edit_by_hand_stands_and_ends_the_search(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    async def play(bench: Bench, session: TuneSession) -> None:
        process = await begun(bench, session)
        by_hand = moved(BASE, 0.1)
        bench.document.replace(by_hand, "by hand")
        assert process.stopped
        process.script = [candidate(0.37, 1.1)]  # what was under way
        await until(lambda: session.state == "done")
        assert bench.document.design.in_force == by_hand
        assert "the edit stands" in bench.traits["progress"]["words"]

    scene(tmp_path, monkeypatch, play)


def test_what_a_killed_server_left_is_offered(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_fis(BASE, tmp_path / "demo.fis")
    task = task_in(tmp_path)
    write_task(task)
    best = {"system": format_fis(moved(BASE, 0.3)), "cost": 1.0, "before": 2.0, "evaluations": 9, "gains": {}}
    (Path(task.place) / "best.json").write_text(json.dumps(best))

    async def play(bench: Bench, session: TuneSession) -> None:
        left = {"evaluations": 9, "of": 30, "cost": 1.0, "before": 2.0, "scenarios": ["fuzzy-off-path"]}
        assert bench.traits["left"] == left
        await bench.say({"do": "go on"})
        process: Any = session.process
        assert process.task == task
        process.stop()
        await until(lambda: session.state == "done")
        await bench.say({"do": "take"})
        assert bench.document.design.in_force == moved(BASE, 0.3)
        assert bench.traits["left"] is None
        bench.document.undo()
        assert bench.document.design.in_force == BASE

    scene(tmp_path, monkeypatch, play)


def test_damaged_and_foreign_places_hold_nothing(tmp_path: Path) -> None:
    inside, outside = tmp_path / "in", tmp_path / "out"
    task = task_in(outside)
    write_task(task)
    inside.mkdir()
    (inside / "link").symlink_to(task.place)
    assert found_at(inside / "link", inside) is None
    assert found_at(Path(task.place), outside) is not None
    (Path(task.place) / "task.json").write_text("{")
    assert found_at(Path(task.place), outside) is None
