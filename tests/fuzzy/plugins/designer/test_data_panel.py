"""The panel "Data": its figures against figures computed otherwise from the file, its session, and its page."""

import asyncio
import math
import threading
import tomllib
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest
from scipy import stats

import fuzzy
from fuzzy.files.table import write_table
from fuzzy.plugins.designer.datapanel import DataSession, panel
from fuzzy.plugins.designer.datapictures import BINS, DRAWN, Rows, chosen_points, data_pictures, histograms, predicted
from fuzzy.plugins.designer.design import design_of, point_in
from fuzzy.plugins.designer.edits import apply
from fuzzy.plugins.designer.latest import Latest
from fuzzy.plugins.designer.panel import PagePart, Workbench
from fuzzy.plugins.designer.workers import DesignerWorkers
from tests.browsers import place_of, rest, run_apart
from tests.fuzzy.plugins.designer.module_page import ROOT, ModulePage

STATIC = "fuzzy/plugins/designer/static"


def system() -> fuzzy.Sugeno:
    """Two inputs; where d is above 1.2 and a below -1 no rule fires."""
    d = {"near": fuzzy.Triangle(-1.2, 0.0, 1.2), "far": fuzzy.Triangle(0.4, 2.0, 3.6)}
    a = {"left": fuzzy.Triangle(-5.0, -3.0, -1.0), "right": fuzzy.Triangle(-1.0, 3.0, 7.0)}
    rules = [
        "if d is near then v is slow and w is none",
        "if d is far and a is right then v is fast and w is some",
    ]
    inputs = [fuzzy.Variable("d", (0.0, 2.0), d, "m"), fuzzy.Variable("a", (-3.0, 3.0), a)]
    v = fuzzy.Variable("v", (0.0, 1.0), {"slow": 0.2, "fast": fuzzy.Linear((0.1, 0.05), 0.6)}, "m/s")
    return fuzzy.Sugeno(inputs, [v, fuzzy.Variable("w", (-1.0, 1.0), {"none": 0.0, "some": 0.5})], rules, name="small")


def measured(count: int = 300, seed: int = 5) -> np.ndarray:
    """Rows t, d, a, v (rows, 4): some inputs outside their universes, some rows without a rule."""
    rng = np.random.default_rng(seed)
    d, a = rng.uniform(-0.1, 2.2, count), rng.normal(0.0, 1.6, count)
    v = 0.2 + 0.3 * d + 0.05 * a + rng.normal(0.0, 0.05, count)
    return np.column_stack([0.1 * np.arange(count), d, a, v])


NAMES, UNITS = ["t", "D", "a", "v"], ["s", "m", "", "m/s"]


def one_by_one(fis: fuzzy.Sugeno, x: np.ndarray) -> np.ndarray:
    """The outputs (rows, outputs) from the definition of a weighted average, rule by rule."""
    found = []
    for point in x:
        above, below = np.zeros(2), 0.0
        for rule in fis.rules:
            degrees = [
                float(v.terms[c.term](np.array(point[i])))
                for c in rule.when
                for i, v in enumerate(fis.inputs)
                if v.name == c.variable
            ]
            firing = math.prod(degrees)
            for j, (output, term) in enumerate(rule.then):
                value = fis.outputs[j].terms[term]
                assert output == fis.outputs[j].name
                slopes, constant = (
                    ((), value.parameters[0])
                    if len(value.parameters) == 1
                    else (
                        value.parameters[:-1],
                        value.parameters[-1],
                    )
                )
                above[j] += firing * (constant + sum(s * p for s, p in zip(slopes, point, strict=False)))
            below += firing
        found.append(above / below if below > 0 else [0.5, 0.0])
    return np.array(found)


def test_the_figures_are_those_of_the_written_file(tmp_path: Path) -> None:
    table, fis = measured(), replace(system(), out_of_range="error")
    write_table(tmp_path / "plant.csv", NAMES, table, UNITS)
    frame = pd.read_csv(tmp_path / "plant.csv")
    x, y = frame[["D [m]", "a"]].to_numpy(), frame["v [m/s]"].to_numpy()
    said = one_by_one(fis, x)[:, 0]
    error = y - said
    checking = np.arange(len(y)) % 4 == 0
    rows = Rows(
        x, np.column_stack([y, np.full_like(y, np.nan)]), np.arange(2, len(y) + 2), checking, frame["t [s]"].to_numpy()
    )
    data = data_pictures(fis, rows, output=1)  # w has no column: v is drawn
    assert data["output"] == {"number": 0, "name": "v", "unit": "m/s"}
    for found, of in zip(data["figures"], (~checking, checking), strict=True):
        assert found["rows"] == of.sum()
        assert found["rmse"] == pytest.approx(np.linalg.norm(error[of]) / math.sqrt(of.sum()), rel=1e-12)
        assert found["mae"] == pytest.approx(pd.Series(error[of]).abs().mean(), rel=1e-12)
        assert found["max"] == pytest.approx(max(-error[of].min(), error[of].max()), rel=1e-12)
        # scipy's own: the squares about the line y = prediction, over those about the mean
        assert found["r2"] == pytest.approx(
            1 - stats.moment(error[of], 2, center=0) / stats.moment(y[of], 2), rel=1e-12
        )
    worst = sorted(range(len(y)), key=lambda k: -abs(error[k]))[:10]
    assert [row["row"] for row in data["worst"]] == worst
    assert [row["line"] for row in data["worst"]] == [k + 2 for k in worst]
    assert [row["kind"] for row in data["worst"]] == [("training", "checking")[int(checking[k])] for k in worst]
    np.testing.assert_allclose([row["residual"] for row in data["worst"]], error[worst], rtol=1e-9)
    assert data["points"]["row"] == list(range(len(y)))
    np.testing.assert_allclose(data["residual"], error, rtol=1e-5, atol=1e-12)
    np.testing.assert_allclose(data["points"]["along"], table[:, 0], rtol=1e-5)
    silent = sum(p[0] >= 1.2 and p[1] <= -1 for p in x)
    assert 5 < silent < 100
    assert data["words"][0] == (
        f"No rule fires for v in {silent} of 300 rows ({100 * silent / 300:.3g} %); "
        "there the middle of its range, 0.5 m/s, stands."
    )


def test_histograms_count_what_lies_where() -> None:
    fis, table = system(), measured()
    found = histograms(fis.inputs, Rows(table[:, 1:3], table[:, 3:], np.arange(300)))
    for histogram, values, (low, high) in zip(found, table[:, 1:3].T, ((0.0, 2.0), (-3.0, 3.0)), strict=True):
        edges = [low + (high - low) * k / BINS for k in range(BINS + 1)]
        counts = [sum(a <= v < b for v in values) for a, b in pairwise(edges)]
        assert histogram["counts"] == [counts]
        assert (histogram["below"], histogram["above"]) == (sum(values < low), sum(values > high))
        assert sum(counts) + histogram["below"] + histogram["above"] == 300
    outside = found[0]["below"] + found[0]["above"]
    assert f"{outside} of 300 rows ({100 * outside / 300:.3g} %) lie outside 0 to 2 m" in found[0]["words"]
    inside = histograms(fis.inputs[:1], Rows(np.array([[0.5], [1.0]]), np.empty((2, 0)), np.arange(2)))
    assert inside[0]["words"] == "d: the rows reach from 0.5 to 1 m, all within the universe."


@pytest.mark.parametrize("instead", ["midrange", "nan", "error"])
@pytest.mark.parametrize("changes", [{}, {"defuzzification": "wtsum"}, {"out_of_range": "clip"}])
def test_predictions_are_the_inferences_and_nothing_is_raised(instead: Any, changes: dict[str, Any]) -> None:
    fis = replace(system(), no_rule_fires=instead, **changes)
    x = np.vstack([measured()[:, 1:3], [[np.nan, 0.0]]])
    said, silent = predicted(replace(fis, out_of_range=changes.get("out_of_range", "error")), x)
    quiet = replace(fis, no_rule_fires="midrange", out_of_range=changes.get("out_of_range", "ignore"))
    with pytest.warns(fuzzy.InferenceWarning, match="no rule fires"):
        wanted = fuzzy.infer(quiet, x)
    assert np.array_equal(silent[:-1], ~wanted.fired[:-1])
    assert not silent[-1].any()
    output = wanted.output if instead == "midrange" else np.where(silent, np.nan, wanted.output)
    np.testing.assert_allclose(said, output, rtol=1e-12, atol=1e-14)
    rows = Rows(x, said, np.arange(len(x)))
    figures = data_pictures(fis, rows)["figures"]
    assert [f["rows"] for f in figures] == [int(np.isfinite(column).sum()) for column in said.T]
    assert [f["max"] for f in figures] == [0.0, 0.0]


def test_many_rows_are_drawn_by_their_extremes_and_counted_all() -> None:
    table, fis = measured(100_000), system()
    rows = Rows(table[:, 1:3], np.column_stack([table[:, 3], table[:, 3]]), np.arange(100_000) + 2)
    data = data_pictures(fis, rows)
    residual = table[:, 3] - predicted(fis, table[:, 1:3])[0][:, 0]
    drawn = np.array(data["points"]["row"])
    assert len(np.unique(drawn)) == len(drawn) <= DRAWN
    assert data["figures"][0]["rmse"] == pytest.approx(math.sqrt(np.dot(residual, residual) / 1e5), rel=1e-12)
    assert {row["row"] for row in data["worst"]} <= set(drawn.tolist())
    # Along every axis: the ends, and in each hundredth of it nearly the extremes of the residual there.
    for values in (*table[:, 1:3].T, np.arange(100_000.0)):
        assert {int(values.argmin()), int(values.argmax())} <= set(drawn.tolist())
        edges = np.linspace(values.min(), values.max(), 26)
        for low, high in pairwise(edges):
            every = (values >= low) & (values <= high)
            some = np.isin(np.arange(100_000), drawn) & every
            if every.sum() > 50:
                assert residual[some].max() >= np.quantile(residual[every], 0.99)
                assert residual[some].min() <= np.quantile(residual[every], 0.01)
    few = np.where(residual > 0, residual, np.nan)[:900]
    assert np.array_equal(chosen_points([residual[:900]], few), np.flatnonzero(residual[:900] > 0))


def test_numbers_whose_squares_are_none_make_no_error() -> None:
    table = measured(3000)
    table[7, 1:] = 1e300
    table[8, 1:] = -1e300
    rows = Rows(table[:, 1:3], np.column_stack([table[:, 3], table[:, 3]]), np.arange(3000) + 2)
    data = data_pictures(system(), rows)
    assert {data["worst"][0]["row"], data["worst"][1]["row"]} == {7, 8}
    assert data["figures"][0]["max"] > 1e299


def test_of_wishes_that_wait_only_the_latest_is_done() -> None:
    async def scene() -> None:
        done: list[int] = []
        asked, gate = [0], asyncio.Event()

        async def work() -> None:
            mine = asked[-1]
            await gate.wait()
            done.append(mine)

        latest = Latest(work)
        for now in range(5):
            asked.append(now)
            latest.wish()
            await asyncio.sleep(0)
        gate.set()
        assert latest.task is not None
        await latest.task
        assert done == [0, 4]

    run_apart(scene())


# The session ----------------------------------------------------------------------------------------------------


class Document:
    """A document without a file: what it shows is told to the bench."""

    def __init__(self, folder: Path, fis: fuzzy.Sugeno) -> None:
        self.folder, self.design = folder, design_of(fis)
        self.revision = 0
        self.table = ""

    def apply(self, message: dict[str, Any]) -> None:
        self.design = apply(self.design, message)


class Bench(Workbench):
    """A workbench without a page: the widget's traits are kept, and work is done at once."""

    heard: Any  # what the panel listens with

    def __init__(self, folder: Path, fis: fuzzy.Sugeno) -> None:
        super().__init__(Document(folder, fis), DesignerWorkers(), str, lambda sentence, problem: None)  # type: ignore[arg-type]
        self.traits: Any = {}
        self.brought: list[str] = []
        self.place = PagePart()
        self.lead(["Viewer"], self.brought.append)
        with self.building(self.place):
            self.session = DataSession(self)

    def widget(self, module: Path, **traits: Any) -> Any:
        assert module.is_file()
        self.traits.update(traits)
        return SimpleNamespace(update=self.traits.update, on_message=lambda callback: setattr(self, "heard", callback))

    async def background(self, function: Any, *args: Any) -> Any:
        return await asyncio.to_thread(function, *args)

    async def read(self, name: str, function: Any, *args: Any) -> Any:
        return await asyncio.to_thread(function, *args)

    async def say(self, message: Any) -> str:
        """Send a message, wait for all that follows, and give what is refused."""
        await self.heard(message)
        return await self.settled()

    async def edit(self, message: dict[str, Any]) -> str:
        self.document.apply(message)
        await self.changed()
        return await self.settled()

    async def settled(self) -> str:
        for latest in (self.session.pictures, self.session.spread):
            if latest.task is not None:
                await latest.task
        return (self.traits["problem"] or {}).get("message", "")


def test_from_a_file_to_its_worst_rows_and_the_viewer(tmp_path: Path) -> None:
    table = measured()
    write_table(tmp_path / "plant.csv", NAMES, table, UNITS)

    async def scene() -> None:
        bench = Bench(tmp_path, system())
        traits = bench.traits
        assert traits["sources"] == ["plant.csv"]
        assert await bench.say({"do": "file", "name": "plant.csv"}) == ""
        assert traits["columns"] == {"input d": "D", "input a": "a", "output v": "v", "output w": ""}
        assert traits["choice"]["along"] == "t"
        assert [h["name"] for h in bench.shared["histograms"]] == ["d", "a"]
        np.testing.assert_array_equal(bench.pictured["data"][0], table[:, 1:3])  # for a set of pictures
        before = traits["pictures"]["worst"]
        assert [f["output"] for f in traits["pictures"]["figures"]] == ["v"]
        row = before[3]
        assert await bench.say({"do": "look", "row": row["row"]}) == ""
        assert bench.brought == ["Viewer"]
        assert bench.document.design.point == tuple(table[row["row"], 1:3]) == tuple(row["x"])
        # An edit of a consequent: other residuals, other worst rows.
        await bench.edit({"edit": "term", "kind": "output", "variable": "v", "term": "slow", "parameters": [0.9]})
        after = traits["pictures"]["worst"]
        assert after != before
        said = one_by_one(bench.document.design.in_force, table[:, 1:3])[:, 0]
        worst = np.argsort(-abs(table[:, 3] - said), kind="stable")[:10]
        assert [r["row"] for r in after] == worst.tolist()
        # While the tab is hidden its pictures rest, but the histograms below the memberships follow the universe.
        bench.place.shown = False
        await bench.edit({"edit": "universe", "kind": "input", "variable": "d", "low": 0, "high": 1, "scale": False})
        assert bench.shared["histograms"][0]["above"] == sum(table[:, 1] > 1)
        assert traits["pictures"]["histograms"][0]["above"] == sum(table[:, 1] > 2)
        bench.place.shown = True
        # A renamed variable keeps its column; one that is removed takes it along.
        await bench.edit({"edit": "rename_variable", "kind": "input", "variable": "d", "name": "distance"})
        assert traits["columns"] == {"input distance": "D", "input a": "a", "output v": "v", "output w": ""}
        assert traits["pictures"]["histograms"][0]["name"] == "distance"
        await bench.edit({"edit": "remove_variable", "kind": "input", "variable": "a"})
        assert [h["name"] for h in traits["pictures"]["histograms"]] == ["distance"]

    run_apart(scene())


def test_columns_by_hand_and_without_outputs(tmp_path: Path) -> None:
    table = measured(40)
    (tmp_path / "other.csv").write_text(
        "when;range (cm);a;speed\n" + "".join(f"{n};{r[1]:.6f};{r[2]:.6f};{r[3]:.6f}\n" for n, r in enumerate(table))
    )

    (tmp_path / "bare.csv").write_text("".join(f"{r[1]},{r[2]},{r[3]},0\n" for r in table))

    async def scene() -> None:
        bench = Bench(tmp_path, system())
        await bench.say({"do": "file", "name": "bare.csv"})  # no header, as many columns as variables
        assert list(bench.traits["columns"].values()) == ["column1", "column2", "column3", "column4"]
        assert [f["output"] for f in bench.traits["pictures"]["figures"]] == ["v", "w"]
        await bench.say({"do": "file", "name": "other.csv"})
        assert bench.traits["columns"] == {"input d": "", "input a": "a", "output v": "", "output w": ""}
        pictures = bench.traits["pictures"]
        assert [h["name"] for h in pictures["histograms"]] == ["a"]  # what is known is drawn
        assert pictures["figures"] == []
        assert "choose a column for every input" in await bench.say({"do": "look", "row": 3})
        await bench.say({"do": "column", "name": "input d", "value": "range"})
        pictures = bench.traits["pictures"]
        assert [h["name"] for h in pictures["histograms"]] == ["d", "a"]
        assert pictures["words"][-1] == "The column 'range' is in cm, d in m: the numbers are taken as they are."
        assert pictures["figures"] == pictures["worst"] == []
        assert not bench.traits["points"]
        for output in "vw":
            await bench.say({"do": "column", "name": f"output {output}", "value": "speed"})
        assert [f["output"] for f in bench.traits["pictures"]["figures"]] == ["v", "w"]
        assert bench.traits["pictures"]["output"]["name"] == "v"
        await bench.say({"do": "choose", "name": "output", "value": 1})
        assert bench.traits["pictures"]["output"]["name"] == "w"
        await bench.say({"do": "choose", "name": "along", "value": "when"})
        np.testing.assert_allclose(bench.traits["points"]["along"], range(40))

    run_apart(scene())


def test_an_upload_rows_without_numbers_and_what_is_no_table(tmp_path: Path) -> None:
    folder = tmp_path / "open"
    folder.mkdir()
    (tmp_path / "secret.csv").write_text("d,a\n1,2\n")
    (folder / "link.csv").symlink_to(tmp_path / "secret.csv")
    (folder / "quote.csv").write_text('d,a\n1,"x\n')
    (folder / "bytes.csv").write_bytes(b"\xff\xfe\x00")
    (folder / "other.csv").write_text("p,q\n1,2\n")
    (folder / "empty.csv").write_text("")
    (folder / "words.csv").write_text("d,a\nx,y\n")
    (folder / "large.csv").write_bytes(b"d,a\n" + b"1,2\n" * 500_000)

    async def scene() -> None:
        bench = Bench(folder, system())
        for message, says in (
            (None, "unknown wish"),
            ({"do": ["file"]}, "unknown wish"),
            ({"do": "file", "name": "link.csv"}, "unknown file of the folder 'link.csv'"),
            ({"do": "file", "name": "../secret.csv"}, "unknown file of the folder"),
            ({"do": "file", "name": "quote.csv"}, "quote.csv, line 2: a quotation mark is not closed"),
            ({"do": "file", "name": "bytes.csv"}, "bytes.csv: not text in UTF-16"),
            ({"do": "file", "name": "empty.csv"}, "empty.csv: the file is empty, expected rows of numbers"),
            ({"do": "file", "name": "large.csv"}, "large.csv is larger than 2 MB; use fuzzy evaluate for large tables"),
            ({"do": "piece", "name": "x.csv", "number": 2, "text": "1"}, "did not arrive whole"),
            ({"do": "look", "row": 0}, "there is no such row"),
            ({"do": "column", "name": "input x", "value": "a"}, "unknown variable 'input x'"),
            ({"do": "column", "name": "input a", "value": "a"}, "unknown column 'a'"),
            ({"do": "choose", "name": "colour", "value": 1}, "unknown setting 'colour'"),
            ({"do": "choose", "name": "output", "value": 7}, "unknown output '7'"),
            ({"do": "choose", "name": "along", "value": []}, "unknown along"),
        ):
            assert says in await bench.say(message), message
        assert bench.traits["table"] is None
        assert "no column is chosen for an input yet" in await bench.say({"do": "file", "name": "other.csv"})
        assert "words.csv: 'd' holds no numbers" in await bench.say({"do": "file", "name": "words.csv"})
        assert [bench.traits["pictures"], bench.shared["histograms"]] == [None, None]
        text = "d;a;v\n0,5;1;0,3\n;2;0,4\n1,5;x;0,5\n1,0;0;0,6\n"
        await bench.say({"do": "piece", "name": "../up.csv", "number": 0, "text": text[:9]})
        said = await bench.say({"do": "piece", "name": "../up.csv", "number": 1, "text": text[9:], "last": True})
        lack = "2 of 4 rows have no number in 'd', 'a' (lines 3 and 4)"
        assert said == f"up.csv: {lack}; leave such rows out, or choose other columns"
        assert bench.traits["lack"] == lack
        assert not bench.traits["pictures"]
        assert await bench.say({"do": "choose", "name": "skip_bad", "value": True}) == ""
        assert bench.traits["pictures"]["rows"] == 2
        assert sorted(r["line"] for r in bench.traits["pictures"]["worst"]) == [2, 5]
        assert sorted(p.name for p in folder.iterdir() if "up" in p.name) == []  # an upload is not written

    run_apart(scene())


def test_pyproject_names_the_panel() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert project["entry-points"]["fuzzyfleet.designer"]["data"] == "fuzzy.plugins.designer.datapanel:panel"
    assert (panel.title, panel.order) == ("Data", 40)


# The page -------------------------------------------------------------------------------------------------------


class Page(ModulePage):
    """A page with the module, and a session in a loop of its own behind it."""

    def __init__(self, page: Any, folder: Path) -> None:
        self.loop = asyncio.new_event_loop()
        self.thread = threading.Thread(target=self.loop.run_forever)
        self.thread.start()
        self.bench: Bench = self.call(self._made(folder))
        page.expose_function("python", lambda message: (self.call(self.bench.say(message)), self.bench.traits)[1])
        super().__init__(page, sheet=f"{STATIC}/designer.css")
        self.render(f"{STATIC}/data.js", self.bench.traits)

    async def _made(self, folder: Path) -> Bench:
        return Bench(folder, system())

    def call(self, work: Any) -> Any:
        return asyncio.run_coroutine_threadsafe(work, self.loop).result(60)

    def edit(self, **message: Any) -> None:
        self.call(self.bench.edit(message))
        self.give(**self.bench.traits)

    def end(self) -> None:
        self.loop.call_soon_threadsafe(self.loop.stop)
        self.thread.join()
        self.loop.close()


@pytest.fixture
def shown(browser: Any, tmp_path: Path) -> Iterator[Page]:
    write_table(tmp_path / "plant.csv", NAMES, measured(), UNITS)
    (tmp_path / "bad.csv").write_text('d,a\n1,"x\n')
    page = Page(browser.new_page(), tmp_path)
    yield page
    page.end()
    assert page.leave() == (0, 0)
    assert page.problems == []


def test_a_file_an_edit_and_a_row_on_the_page(shown: Page) -> None:
    page, table = shown.page, measured()
    file = page.get_by_label("File of the folder")
    file.select_option("bad.csv")
    page.wait_for_selector(".pn-problem:not([hidden])")
    assert page.locator(".pn-problem").inner_text() == "bad.csv, line 2: a quotation mark is not closed"
    file.select_option("plant.csv")
    page.wait_for_selector(".dp-worst tbody tr")
    assert page.locator(".pn-problem").is_hidden()
    assert page.get_by_label("d (input): its column").input_value() == "D"
    lines = lambda: page.locator(".dp-worst tbody button").all_inner_texts()  # noqa: E731
    before = lines()
    assert len(before) == 10
    assert page.locator(".dp-cloud").count() == 3
    assert "m/s" in page.locator(".dp-cloud").first.text_content()
    shown.edit(edit="term", kind="output", variable="v", term="slow", parameters=[0.9])
    assert lines() != before
    said = one_by_one(shown.bench.document.design.in_force, table[:, 1:3])[:, 0]
    worst = np.argsort(-abs(table[:, 3] - said), kind="stable")[:10]
    assert lines() == [str(k + 2) for k in worst]
    # A row by Enter, a point by a click, another by the keys: each time the viewer is at that row's inputs.
    looked = lambda: shown.bench.document.design.point  # noqa: E731
    page.locator(".dp-worst tbody button").nth(1).press("Enter")
    page.wait_for_function("window.model.sent.some((m) => m.do === 'look')")
    rest(page)
    assert looked() == tuple(table[worst[1], 1:3])
    assert shown.bench.brought == ["Viewer"]
    shown.forget()
    cursor = page.get_by_role("slider").nth(2)  # over the time
    cursor.press("End")
    assert cursor.get_attribute("aria-valuetext").startswith("line 301: measured ")
    cursor.press("Shift+ArrowLeft")
    cursor.press("Enter")
    page.wait_for_function("window.model.sent.length === 1")
    rest(page)
    assert looked() == tuple(table[289, 1:3])
    mark = place_of(page.locator(".dp-mark").nth(2))
    page.mouse.click(mark["x"] + mark["width"] / 2 + 1, mark["y"] + mark["height"] / 2)
    page.wait_for_function("window.model.sent.length === 2")
    assert shown.sent()[1] == {"do": "look", "row": 289}
    for width in (1100, 390):
        page.set_viewport_size({"width": width, "height": 900})
        rest(page)
        assert page.evaluate("document.documentElement.scrollWidth") <= width


def test_the_rows_lie_below_the_curves_of_the_tab_memberships(browser: Any) -> None:
    from fuzzy.plugins.designer.views import design_data, functions_data

    page = ModulePage(browser.new_page(), sheet=f"{STATIC}/designer.css")
    fis, table = system(), measured()
    design = design_of(fis)
    traits = {
        "design": design_data(design),
        "functions": functions_data(),
        "point": list(point_in(fis, design)),
        "selected": {"kind": "input", "variable": "d", "term": None},
    }
    page.render(f"{STATIC}/terms.js", traits)
    strip = page.page.locator(".fd-terms .fd-rows g[role=img]")
    assert strip.count() == 0
    found = histograms(fis.inputs, Rows(table[:, 1:3], table[:, 3:], np.arange(300)))
    page.give(histograms=found)
    assert found[0]["words"] in strip.get_attribute("aria-label")
    bars, curve = (
        page.page.locator(f".fd-terms {at}").first.bounding_box() for at in (".fd-bars", "[data-curve=near]")
    )
    assert bars["y"] > curve["y"] + curve["height"]
    assert abs(bars["x"] - curve["x"]) < 3
    assert abs(bars["width"] - curve["width"]) < 6
    page.give(histograms=None)
    assert strip.count() == 0
    assert page.leave() == (0, 0)
    assert page.problems == []
