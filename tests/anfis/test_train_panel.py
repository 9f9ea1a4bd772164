"""The panel "Train": a task learns what anfis.train learns, in a process that can be stopped; its module shows it."""

import asyncio
import os
import shutil
import signal
import threading
import time
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import anfis
import fuzzy
from anfis import designpanel
from anfis.designpanel import Session, generators, variables
from anfis.traintask import (
    METHODS,
    Columns,
    Task,
    TaskError,
    TrainingProcess,
    guessed,
    learn,
    read_columns,
    split,
    starting_system,
    task_of,
)
from fuzzy.errors import InputError

RNG = np.random.default_rng(5)
X = RNG.uniform([-1, 10], [3, 30], (60, 2))
Y = np.stack([np.sin(X[:, 0]), 0.002 * X[:, 1] ** 2], axis=1)
TABLE = Columns("made up", ("a", "b", "y", "z"), np.concatenate([X, Y], axis=1))
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
        (ROLES, {"start": "grid", "mfs": 1}, "mfs must be a whole number >= 2 and <= 20, got 1"),
        (ROLES, {"start": "grid", "epochs": 1.5}, "epochs must be a whole number"),
        (ROLES, {"start": "grid", "epochs": True}, "epochs must be a whole number"),
        (ROLES, {"start": "grid", "method": "jang"}, "unknown method"),
        (ROLES, {"start": "subtractive", "radius": 0}, "radius must be a number > 0"),
        (ROLES, {"start": "subtractive", "radius": None}, "radius must be a number"),
        (ROLES, {"start": "grid", "share": 0.9}, "share must be a number >= 0 and <= 0.8"),
        (ROLES, {"start": "grid", "goal": float("nan")}, "goal must be a number >= 0"),
        (ROLES, {"start": "grid", "lucky": 7}, "unknown setting 'lucky'"),
    ],
)
def test_choices_that_do_not_go_together(columns: dict[str, str], settings: dict[str, Any], says: str) -> None:
    with pytest.raises(TaskError) as caught:
        task_of(TABLE, columns, START, **settings)
    assert says in str(caught.value)


def test_what_cannot_be_learnt_is_said() -> None:
    with pytest.raises(TaskError, match="has no rule in force"):
        learn(task_of(TABLE, {n: n for n in "abyz"}, replace(START, rules=())), quiet)
    with pytest.raises(InputError, match="rules, more than"):
        learn(task_of(TABLE, {**ROLES, "y": "input"}, None, start="grid", mfs=20), quiet)
    few = Columns("few", TABLE.names, TABLE.values[:1])
    with pytest.raises(TaskError, match="leave none to learn from"):
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
    with pytest.raises(TaskError, match=r"^x\.csv, line 3, column 2 \(b\): expected a number, got 'two'$"):
        read_columns("x.csv", "a,b\n1,2\n1,two\n")


def test_data_come_from_whoever_makes_some() -> None:
    assert {g.name for g in generators()} >= {"formation-literal", "formation-well-posed"}


# The process ----------------------------------------------------------------------------------------------------


def until_over(process: TrainingProcess) -> list[tuple[str, Any]]:
    news, end = [], time.monotonic() + 120
    while process.alive:
        assert time.monotonic() < end
        news += process.news()
        time.sleep(0.02)
    return news


def test_what_goes_wrong_in_the_process_is_news() -> None:
    process = TrainingProcess(task_of(TABLE, {n: n for n in "abyz"}, replace(START, rules=())))
    assert until_over(process) == [
        ("problem", "start has no rule in force, so there is nothing to learn: start from clusters")
    ]
    process.close()
    killed = TrainingProcess(task_of(TABLE, {n: n for n in "abyz"}, START, epochs=10_000))
    assert killed._process.pid is not None
    os.kill(killed._process.pid, signal.SIGKILL)
    assert until_over(killed) == [("problem", "the training ended unexpectedly (exit code -9)")]
    killed.stop()  # nobody hears it, and nothing happens
    killed.close()
    closed = TrainingProcess(task_of(TABLE, {n: n for n in "abyz"}, START, epochs=10_000))
    closed.close()
    assert not closed._process.is_alive()
    assert closed.news() == []


# The session ----------------------------------------------------------------------------------------------------


class Bench:
    """What the designer's page offers to a panel, without a page."""

    def __init__(self, fis: fuzzy.Sugeno, folder: Path) -> None:
        self.document: Any = SimpleNamespace(
            design=SimpleNamespace(in_force=fis), folder=folder, replace=lambda *args: self.edits.append(args)
        )
        self.edits: list[Any] = []
        self.traits: dict[str, Any] = {}
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

    @property
    def said(self) -> str:
        return (self.traits["problem"] or {}).get("message", "")


def test_from_a_file_to_one_edit_of_the_design(tmp_path: Path) -> None:
    (tmp_path / "made.csv").write_text(TEXT)

    async def scene() -> None:
        bench = Bench(START, tmp_path)
        session = Session(bench)
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
        assert bench.traits["before"] == variables(START)
        assert bench.traits["after"] == variables(direct.system)
        await bench.say({"do": "take"})
        assert bench.edits == [
            (replace(direct.system, out_of_range="warn"), f"train (second-order, epoch {direct.best})")
        ]

    asyncio.run(scene())


class Idle:
    """A process that says nothing until it is told to end."""

    def __init__(self, task: Task) -> None:
        self.task, self.alive, self.heard = task, True, ""

    def news(self) -> list[Any]:
        return []

    def stop(self) -> None:
        self.heard = "stop"

    def close(self) -> None:
        self.alive = False


def test_closing_the_page_ends_the_training(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(designpanel, "TrainingProcess", Idle)

    async def scene() -> None:
        bench = Bench(START, tmp_path)
        session = Session(bench)
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
        await session.watching  # type: ignore[misc]

    asyncio.run(scene())


def test_wrong_wishes_get_sentences(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    secret = tmp_path / "secret.csv"
    secret.write_text("a,b\n1,2\n")
    folder = tmp_path / "open"
    folder.mkdir()
    (folder / "link.csv").symlink_to(secret)
    (folder / "bad.csv").write_text("a,b\n1,x\n")
    (folder / "bytes.csv").write_bytes(b"\xff\xfe\x00")
    monkeypatch.setattr(designpanel, "_MOST", 1000)

    async def scene() -> None:
        bench = Bench(START, folder)
        Session(bench)
        for message, says in (
            (None, "unknown wish"),
            ({"do": ["train"]}, "unknown wish"),
            ({"do": "train"}, "choose data first"),
            ({"do": "stop"}, "no training runs"),
            ({"do": "file", "name": "link.csv"}, "unknown file of the folder 'link.csv'"),
            ({"do": "file", "name": "../secret.csv"}, "unknown file of the folder"),
            ({"do": "file", "name": ["bad.csv"]}, "unknown file of the folder"),
            ({"do": "file", "name": "bad.csv"}, "bad.csv, line 2, column 2 (b): expected a number, got 'x'"),
            ({"do": "file", "name": "bytes.csv"}, "bytes.csv is not text in UTF-8"),
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

    asyncio.run(scene())


# The module, in Chromium ----------------------------------------------------------------------------------------

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
ROOT = Path(__file__).parents[2]
PAGE = """<!doctype html><html lang="en"><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<link rel="icon" href="data:,"><title>panel</title><body style="margin: 16px"><div id="here"></div>"""
BEGIN = """async ([module, values]) => {
  const on = new Map();
  window.sent = [];
  const model = { get: (n) => values[n], set() {}, save_changes() {}, send: (m) => sent.push(m),
    on(n, f) { on.set(n, [...(on.get(n) ?? []), f]); },
    off(n, f) { on.set(n, (on.get(n) ?? []).filter((g) => g !== f)); } };
  window.listeners = () => [...on.values()].flat().length;
  window.give = (news) => {
    Object.assign(values, news);
    for (const n of Object.keys(news)) for (const f of on.get(`change:${n}`) ?? []) f();
    return new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
  };
  window.end = (await import(module)).default.render({ model, el: document.getElementById("here") });
}"""
MODULE = "/anfis/static/training.js"


class Quiet(SimpleHTTPRequestHandler):
    def log_message(self, *_: Any) -> None:
        pass


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    if CHROMIUM is None:
        pytest.skip("Chromium is not installed")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        found = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox", "--disable-gpu"])
        yield found
        found.close()


@pytest.fixture
def page(browser: Any) -> Iterator[Any]:
    """An empty page; a console error or a request that leaves the machine fails the test."""
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(ROOT)))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    base = f"http://127.0.0.1:{server.server_address[1]}/"
    page = browser.new_page(viewport={"width": 800, "height": 900})
    problems: list[str] = []
    page.on("console", lambda m: problems.append(m.text) if m.type in ("error", "warning") else None)
    page.on("pageerror", lambda e: problems.append(str(e)))
    page.on("request", lambda r: None if r.url.startswith((base, "data:", "blob:")) else problems.append(r.url))
    page.route("**/panel.html", lambda route: route.fulfill(body=PAGE, content_type="text/html"))
    page.goto(base + "panel.html")
    yield page
    page.close()
    server.shutdown()
    server.server_close()
    assert problems == []


IDLE = {
    "state": "idle",
    "epochs": 60,
    "epoch": [],
    "train": [],
    "check": None,
    "best": None,
    "first": None,
    "rules": None,
    "outputs": None,
    "parameters": None,
    "stopped": None,
    "words": [],
}
TRAITS: dict[str, Any] = {
    "sources": {"files": ["made.csv"], "generators": [["formation", "Formation data"]]},
    "accepted": {"start": ["present", "subtractive", "grid"], "method": list(METHODS)},
    "table": None,
    "choice": {"start": "present", "radius": 0.5, "mfs": 3, "method": "hybrid", "epochs": 60, "goal": 0.0}
    | {"share": 0.2, "seed": 0},
    "columns": {},
    "system": {"name": "start", "inputs": ["a", "b"], "outputs": ["y", "z"], "rules": 4},
    "progress": IDLE,
    "before": None,
    "after": None,
    "problem": None,
}
DATA: dict[str, Any] = {
    "table": {
        "name": "made.csv",
        "rows": 60,
        "columns": [{"name": n, "low": 0.0, "high": 1.0} for n in ("a", "b", "y", "<b>z</b>")],
    },
    "columns": {"a": "a", "b": "b", "y": "y"},
}
DONE = IDLE | {
    "state": "done",
    "epoch": [0, 1, 2, 3],
    "train": [1.0, 0.1, 0.01, 0.001],
    "check": [1.0, 0.2, 0.1, 0.4],
    "best": {"epoch": 2, "error": 0.1, "checked": True},
    "first": 1.0,
    "rules": 4,
    "outputs": 2,
    "parameters": 30,
    "stopped": "callback",
    "words": ["input 'a' is constant"],
}


def test_data_columns_and_settings_are_chosen(page: Any) -> None:
    page.evaluate(BEGIN, [MODULE, TRAITS])
    assert page.get_by_role("button", name="Train").is_disabled()
    page.get_by_label("Data from a file").select_option("g:formation")
    page.get_by_label("Upload a CSV file").set_input_files(
        {"name": "up.csv", "mimeType": "text/csv", "buffer": ("1,2\n" * 60_000).encode()}
    )
    page.wait_for_function("sent.length === 3")
    sent = page.evaluate("sent")
    assert sent[0] == {"do": "generate", "name": "formation"}
    assert "".join(m["text"] for m in sent[1:]) == "1,2\n" * 60_000
    assert [(m["do"], m["name"], m["number"], m["last"]) for m in sent[1:]] == [
        ("piece", "up.csv", 0, False),
        ("piece", "up.csv", 1, True),
    ]
    page.evaluate("sent.length = 0")
    page.evaluate("(news) => give(news)", DATA)
    page.get_by_label("Column of the output z").select_option("<b>z</b>")
    page.get_by_label("Epochs", exact=True).fill("12")
    page.keyboard.press("Tab")
    page.get_by_label("Share of the samples").fill("25")
    page.keyboard.press("Tab")
    page.get_by_label("Epochs", exact=True).fill("-1")  # no number of epochs: no message
    page.keyboard.press("Tab")
    page.get_by_label("Start from", exact=True).select_option("grid")
    page.get_by_role("button", name="Train").press("Enter")
    assert page.evaluate("sent") == [
        {"do": "column", "name": "z", "value": "<b>z</b>"},
        {"do": "choose", "name": "epochs", "value": 12},
        {"do": "choose", "name": "share", "value": 0.25},
        {"do": "choose", "name": "start", "value": "grid"},
        {"do": "train"},
    ]
    page.evaluate("(news) => give(news)", {"choice": TRAITS["choice"] | {"start": "grid"}, "columns": ROLES})
    assert page.get_by_label("Role of the column a").input_value() == "input"
    assert page.get_by_label("Terms an input").input_value() == "3"
    assert not page.get_by_label("Radius of a cluster").is_visible()


def test_the_error_curve_is_logarithmic_with_its_least_checking_error(page: Any) -> None:
    page.evaluate(BEGIN, [MODULE, TRAITS | DATA | {"progress": DONE, "before": variables(START)}])
    place = page.evaluate("""() => ["tn-train", "tn-check"].map((kind) =>
      document.querySelector(`path.${kind}[d*=L]:not([d="M1 5H33"])`).getAttribute("d").split(/[ML]/).slice(1)
        .map((pair) => pair.split(" ").map(Number)))""")
    train, check = np.array(place)
    steps = np.diff(train[:, 1])
    np.testing.assert_allclose(steps, steps[0], atol=0.03)  # a decade an epoch is a straight line
    assert steps[0] > 0
    marker = page.evaluate("(({cx, cy}) => [cx.baseVal.value, cy.baseVal.value])(document.querySelector('.tn-best'))")
    np.testing.assert_allclose(marker, check[2], atol=0.02)
    status = page.get_by_role("status").inner_text()
    assert "4 rules · 30 parameters · epoch 3 · least checking error 0.1 at epoch 2" in status
    assert "stopped by hand" in status
    assert page.get_by_text("The 2 outputs are learnt together").is_visible()
    assert page.get_by_text("input 'a' is constant").is_visible()
    # before and after
    assert page.evaluate("document.querySelectorAll('svg[role=img] path.tn-before').length") == 4
    moved = replace(START, inputs=[replace(v, terms=dict(v.terms)) for v in START.inputs])
    page.evaluate("(news) => give(news)", {"after": variables(moved)})
    curves = page.evaluate("""[...document.querySelectorAll("svg[aria-label^=Membership]")].map((svg) =>
      ["path.tn-before", "path[stroke]"].map((kind) => [...svg.querySelectorAll(kind)]
        .map((p) => p.getAttribute("d"))))""")
    assert len(curves) == 2
    assert all(before == after and len(after) == 2 for before, after in curves)  # the same terms lie on each other
    page.get_by_role("button", name="Take the best into the design").click()
    assert page.evaluate("sent.at(-1)") == {"do": "take"}
    page.evaluate("(news) => give(news)", {"progress": DONE | {"state": "learning", "stopped": None}})
    assert page.get_by_role("button", name="Take the best").is_disabled()
    page.get_by_role("button", name="Stop").click()
    assert page.evaluate("sent.at(-1)") == {"do": "stop"}
    page.evaluate("(news) => give(news)", {"problem": {"message": "made.csv, line 3: <i>no</i>"}})
    assert page.get_by_role("alert").inner_text() == "made.csv, line 3: <i>no</i>"
    page.evaluate("end()")
    assert page.evaluate("[document.getElementById('here').childElementCount, listeners()]") == [0, 0]


@pytest.mark.parametrize("width", [390, 1600])
def test_it_fits_the_page(page: Any, width: int) -> None:
    page.set_viewport_size({"width": width, "height": 900})
    page.evaluate(BEGIN, [MODULE, TRAITS | DATA | {"progress": DONE, "before": variables(START)}])
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    assert page.evaluate("[...document.querySelectorAll('input, select')].every((c) => c.ariaLabel)")
