"""The designer's modules in a real browser, each alone on a page, with the design's own edits and views behind it."""

import json
import re
import shutil
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fuzzy
from fuzzy.designer.design import design_of
from fuzzy.designer.edits import apply
from fuzzy.designer.views import design_data, surface_data, viewer_data
from fuzzy.errors import InputError
from fuzzy.membership import FUNCTIONS, membership_function

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
FLAGS = (
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)
playwright = pytest.importorskip("playwright.sync_api", reason="drives the browser: pip install playwright")
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="the modules run in Chromium, and none is installed")

STATIC = Path(fuzzy.__file__).parent / "designer" / "static"
MODULES = ("terms", "tree", "rules", "viewer", "surface")
PAGE = """<!doctype html><html lang="en"><head><meta charset="utf-8"><title>module</title>
<link rel="icon" href="data:,">
<meta name="viewport" content="width=device-width"><link rel="stylesheet" href="designer.css">
<style>body { margin: 0; padding: 12px; background: Canvas; color-scheme: light dark }</style></head>
<body><main id="here"></main><script type="module">
// An anywidget model whose other side is the function "python" of the test; held = true keeps the answers back.
class Model {
  constructor(traits) { this.traits = traits; this.hands = new Map(); this.sent = []; this.held = false; }
  get(name) { return this.traits[name]; }
  set(name, value) { this.traits[name] = value; for (const f of this.hands.get(name) ?? []) f(); }
  save_changes() {}
  on(event, f) {
    const name = event.slice(7);
    if (!this.hands.has(name)) this.hands.set(name, new Set());
    this.hands.get(name).add(f);
  }
  off(event, f) { this.hands.get(event.slice(7))?.delete(f); }
  take(traits) { for (const [name, value] of Object.entries(traits)) this.set(name, value); }
  async send(content) {
    this.sent.push(structuredClone(content));
    if (!this.held) this.take(await window.python(content));
  }
}
window.show = async (name, traits) => {
  window.end?.();
  const module = await import(`./${name}.js`);
  window.model = new Model(traits);
  window.end = module.default.render({ model: window.model, el: document.getElementById("here") });
  await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
};
window.ready = true;
</script></body></html>"""


def system() -> fuzzy.Sugeno:
    d = {"near": fuzzy.Triangle(0.0, 0.5, 1.2), "far": fuzzy.Gaussian(0.5, 2.0)}
    a = {"left": fuzzy.ZShape(-2.0, 1.0), "right": fuzzy.SShape(-1.0, 2.0)}
    v = {"slow": 0.2, "fast": 0.9, "mixed": fuzzy.Linear((0.1, 0.2), 0.3)}
    rules = [
        "if d is near then v is slow",
        "if d is far and a is not very left then v is fast",
        "if a is right then v is mixed with 0.5",
    ]
    inputs = [fuzzy.Variable("d", (0.0, 2.0), d, "m"), fuzzy.Variable("a", (-3.0, 3.0), a)]
    return fuzzy.Sugeno(inputs, [fuzzy.Variable("v", (0.0, 1.0), v, "m/s")], rules, name="small")


class Bench:
    """A page with one module and a design behind it, changed by what the module sends."""

    def __init__(self, page: Any) -> None:
        self.page = page
        self.problems: list[str] = []
        page.on("console", lambda m: self.problems.append(m.text) if m.type in ("error", "warning") else None)
        page.on("pageerror", lambda error: self.problems.append(str(error)))
        page.route("**/*", self._serve)
        page.expose_function("python", self._answer)
        page.goto("http://127.0.0.1/")
        page.wait_for_function("window.ready")

    def _serve(self, route: Any) -> None:
        name = route.request.url.removeprefix("http://127.0.0.1/")
        if name == "":
            route.fulfill(body=PAGE, content_type="text/html")
        elif route.request.url.startswith("http://127.0.0.1/") and (STATIC / name).is_file():
            route.fulfill(path=STATIC / name)
        else:
            self.problems.append(f"request to {route.request.url}")
            route.abort()

    def show(self, module: str, fis: fuzzy.Sugeno | None = None, width: int = 900, **traits: Any) -> None:
        self.design = design_of(fis or system())
        self.look: dict[str, Any] = {"inputs": list(range(min(2, len(self.design.system.inputs)))), "output": 0}
        self.selected: dict[str, Any] = {}
        self.problem: dict[str, str] | None = None
        self.page.set_viewport_size({"width": width, "height": 900})
        self.page.evaluate("([name, traits]) => window.show(name, traits)", [module, {**self.traits(), **traits}])

    def traits(self) -> dict[str, Any]:
        return {
            "design": design_data(self.design),
            "point": list(self.design.point),
            "viewer": viewer_data(self.design),
            "surface": surface_data(self.design, self.look["inputs"], self.look["output"]),
            "selected": self.selected,
            "problem": self.problem,
            "compared": None,
        }

    def _answer(self, message: dict[str, Any]) -> dict[str, Any]:
        try:
            self.problem = None
            if message.get("look") == "surface":
                self.look = message
            elif message.get("look") == "select":
                self.selected = message
            else:
                self.design = apply(self.design, message)
        except InputError as error:
            self.problem = {"message": str(error)}
        traits = self.traits()
        del traits["compared"]
        return traits

    def sent(self) -> list[dict[str, Any]]:
        return self.page.evaluate("window.model.sent")

    def settled(self) -> None:
        self.page.evaluate(
            "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(done, 30))))"
        )

    def parameters(self, term: str) -> list[float]:
        return [
            float(p) for v in self.design.system.inputs for n, t in v.terms.items() if n == term for p in t.parameters
        ]

    def drag(self, locator: Any, *by: tuple[float, float]) -> None:
        box = locator.bounding_box()
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        self.page.mouse.move(x, y)
        self.page.mouse.down()
        for dx, dy in by:
            self.page.mouse.move(x + dx, y + dy, steps=3)


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with playwright.sync_playwright() as driver:
        window = driver.chromium.launch(executable_path=CHROMIUM, args=list(FLAGS))
        yield window
        window.close()


@pytest.fixture(scope="module")
def page(browser: Any) -> Bench:
    return Bench(browser.new_page())


@pytest.fixture
def bench(page: Bench) -> Iterator[Bench]:
    page.problems.clear()
    yield page
    page.settled()
    assert page.problems == []


# The formulas ---------------------------------------------------------------------------------------------------


def cases(rng: np.random.Generator) -> list[tuple[str, list[float]]]:
    """Parameters of every function: random ones, upright edges, crossed and turned ones."""
    out = []
    for function in FUNCTIONS:
        for _ in range(60):
            p = rng.uniform(-2, 2, len(function.roles))
            if function.matlab in ("trimf", "trapmf", "linsmf", "linzmf") and rng.random() < 0.8:
                p = np.sort(p)
            ties = rng.random(len(p)) < 0.2
            p[1:][ties[1:]] = p[:-1][ties[1:]]
            out.append((function.matlab, (np.round(p, 1) if rng.random() < 0.5 else p).tolist()))
        out.append((function.matlab, [1e-3, 40.0, 0.5, 0.5][: len(function.roles)]))
        out.append((function.matlab, [0.0, -3.0, 0.0, 200.0][: len(function.roles)]))
    legal = []
    for name, p in out:
        try:
            membership_function(name, p)
        except InputError:
            continue
        legal.append((name, p))
    return legal


def test_formulas_equal_pythons(bench: Bench) -> None:
    rng = np.random.default_rng(7)
    chosen = cases(rng)
    assert len(chosen) > 500
    assert {name for name, _ in chosen} == {f.matlab for f in FUNCTIONS}
    xs = [sorted({*p, *rng.uniform(-5, 5, 12), 0.0, -1e4, 1e4}) for _, p in chosen]
    script = """async (cases) => {
      const { degree } = await import("./membership.js");
      return cases.map(([name, p, xs]) => xs.map((x) => String(degree(name, x, p))));
    }"""
    theirs = bench.page.evaluate(script, [[name, p, x] for (name, p), x in zip(chosen, xs, strict=True)])
    for (name, p), x, got in zip(chosen, xs, theirs, strict=True):
        with np.errstate(all="ignore"):
            wanted = membership_function(name, p)(np.array(x))
        np.testing.assert_allclose([float(v) for v in got], wanted, rtol=1e-9, atol=1e-12, err_msg=f"{name} {p}")


ORDERED = ("trimf", "trapmf", "linsmf", "linzmf", "smf", "zmf", "pimf")


def test_handles_keep_the_order_and_stand_on_the_curve(bench: Bench) -> None:
    rng = np.random.default_rng(3)
    chosen = cases(rng)
    script = """async (cases) => {
      const { handles, degree } = await import("./membership.js");
      const about = (name, p, to, h) =>
        [h.index, h.name, h.x, h.y, degree(name, h.x, p), h.move(to, 1e-3), h.range.map(String)];
      return cases.map(([name, p, to]) => handles(name, p).map((h) => about(name, p, to, h)));
    }"""
    targets = rng.uniform(-4, 4, len(chosen)).tolist()
    answers = bench.page.evaluate(script, [[n, p, t] for (n, p), t in zip(chosen, targets, strict=True)])
    moved = 0
    for (name, p), to, handles in zip(chosen, targets, answers, strict=True):
        function = type(membership_function(name, p))
        places = {i for i, role in enumerate(function.roles) if role == "location"}
        assert places <= {h[0] for h in handles}, name
        for index, words, x, y, on_curve, after, ends in handles:
            membership_function(name, after)  # raises where the order is lost
            assert [a for i, a in enumerate(after) if i != index] == [b for i, b in enumerate(p) if i != index]
            if index in places:
                low, high = (float(e.replace("Infinity", "inf")) for e in ends)
                assert after[index] == min(max(to, low), high)
                for a, b in [(index - 1, index), (index, index + 1)]:
                    if name in ORDERED and a >= 0 and b < len(p) and p[a] <= p[b]:
                        assert after[a] <= after[b], (name, p, words)
            elif min(abs(q) for i, q in enumerate(p) if i not in places) > 0.05:
                assert y == pytest.approx(on_curve, abs=1e-6), (name, p, words, x)
            moved += after != p
    assert moved > 500


# The terms ------------------------------------------------------------------------------------------------------


def curve(bench: Bench, term: str) -> str:
    return bench.page.locator(f"[data-curve='{term}']").get_attribute("d")


def test_a_vertex_is_dragged_before_any_answer_as_one_gesture(bench: Bench) -> None:
    bench.show("terms")
    bench.page.evaluate("window.model.held = true")
    before, handle = curve(bench, "near"), bench.page.get_by_role("slider", name="near: peak")
    assert handle.get_attribute("aria-valuetext") == "0.5 m"
    bench.drag(handle, (20, 0), (60, 5))
    bench.settled()
    assert curve(bench, "near") != before  # the other side has said nothing yet
    messages = bench.sent()
    edits = [m for m in messages if m.get("edit") == "term"]
    assert edits
    assert {m["gesture"] for m in edits} != {None}
    assert len({m["gesture"] for m in edits}) == 1
    # What another says of the dragged term meanwhile is not taken over.
    held = curve(bench, "near")
    bench.page.evaluate("window.model.set('design', structuredClone(window.model.get('design')))")
    assert curve(bench, "near") == held
    bench.page.mouse.move(2000, 0, steps=3)  # far to the right: the right foot stops it
    bench.page.mouse.up()
    bench.settled()
    last = [m for m in bench.sent() if m.get("edit") == "term"]
    assert last[-1]["parameters"] == [0.0, 1.2, 1.2]
    assert {m["gesture"] for m in last} == {edits[0]["gesture"]}
    assert all(m["parameters"] == sorted(m["parameters"]) for m in last)


def test_a_drag_reaches_the_design_and_escape_takes_it_back(bench: Bench) -> None:
    bench.show("terms")
    handle = bench.page.get_by_role("slider", name="near: right foot")
    bench.drag(handle, (-60, 0))
    bench.page.mouse.up()
    bench.settled()
    moved = bench.parameters("near")
    assert moved[:2] == [0.0, 0.5]
    assert 0.5 < moved[2] < 1.2
    assert handle.get_attribute("aria-valuenow") == str(moved[2])
    bench.drag(handle, (30, 0))
    bench.page.keyboard.press("Escape")
    bench.page.mouse.up()
    bench.settled()
    assert bench.parameters("near") == moved
    # A whole curve moves all its places; a click only chooses it.
    x, y = bench.page.evaluate("""(() => {
      const path = document.querySelector("[data-curve='far']"), frame = path.getScreenCTM();
      const at = path.getPointAtLength(path.getTotalLength() * 0.6);
      return [at.x + frame.e, at.y + frame.f];
    })()""")
    bench.page.mouse.click(x, y)
    bench.settled()
    assert bench.selected["term"] == "far"
    assert bench.parameters("far") == [0.5, 2.0]
    bench.page.mouse.move(x, y)
    bench.page.mouse.down()
    bench.page.mouse.move(x - 80, y, steps=4)
    bench.page.mouse.up()
    bench.settled()
    assert bench.parameters("far")[0] == 0.5
    assert bench.parameters("far")[1] < 1.95


def test_keys_and_fields_move_the_same_parameters(bench: Bench) -> None:
    bench.show("terms")
    page = bench.page
    page.get_by_role("slider", name="near: peak").focus()
    page.keyboard.press("ArrowRight")
    bench.settled()
    assert bench.parameters("near") == [0.0, 0.51, 1.2]
    page.keyboard.press("Shift+ArrowLeft")
    page.keyboard.press("Alt+ArrowRight")
    bench.settled()
    assert bench.parameters("near") == pytest.approx([0.01, 0.42, 1.21])
    page.keyboard.press("End")
    bench.settled()
    assert bench.parameters("near") == pytest.approx([0.01, 1.21, 1.21])
    field = page.get_by_role("spinbutton", name="peak of near")
    field.fill("0.7")
    field.press("Enter")
    bench.settled()
    assert bench.parameters("near")[1] == 0.7
    field.press("ArrowUp")
    bench.settled()
    assert bench.parameters("near")[1] == 0.71
    field.fill("5")  # beyond its neighbour: refused in words, and the curve is the old one again
    field.press("Enter")
    page.wait_for_function("document.querySelector('.fd-problem').textContent !== ''")
    assert bench.parameters("near")[1] == 0.71
    page.get_by_role("slider", name="current d").press("Home")
    bench.settled()
    assert bench.design.point[0] == 0.0


def test_terms_and_variables_are_named_typed_and_ranged(bench: Bench) -> None:
    bench.show("terms")
    page = bench.page
    name = page.get_by_role("textbox", name="term's name").first
    name.fill("close by")
    name.press("Enter")
    bench.settled()
    assert list(bench.design.system.inputs[0].terms) == ["close by", "far"]
    assert "'close by'" in bench.design.lines[0].text
    assert page.get_by_role("slider", name="close by: peak").count() == 1
    page.get_by_label("type of close by").select_option("gbellmf")
    bench.settled()
    assert bench.design.system.inputs[0].terms["close by"].matlab == "gbellmf"
    assert page.get_by_role("slider", name="close by: steepness b").count() == 1
    page.get_by_role("button", name="add a term").click()
    page.get_by_role("spinbutton", name="highest value").fill("3")
    page.get_by_role("spinbutton", name="highest value").press("Enter")
    bench.settled()
    assert len(bench.design.system.inputs[0].terms) == 3
    assert bench.design.system.inputs[0].universe == (0.0, 3.0)
    page.get_by_role("button", name="remove the term far").click()
    page.get_by_role("button", name="v", exact=True).click()
    bench.settled()
    marker = page.get_by_role("slider", name="slow: value")
    bench.drag(marker, (40, 0))
    page.mouse.up()
    bench.settled()
    terms = bench.design.system.outputs[0].terms
    assert terms["slow"].value > 0.2
    assert "far" not in bench.design.system.inputs[0].terms
    page.get_by_role("spinbutton", name="× a of mixed").fill("-0.5")
    page.get_by_role("spinbutton", name="× a of mixed").press("Enter")
    bench.settled()
    assert bench.design.system.outputs[0].terms["mixed"].slopes == (0.1, -0.5)


def test_compared_curves_are_dashed_behind(bench: Bench) -> None:
    other = design_data(design_of(system()))
    bench.show("terms", compared={"name": "before", "inputs": other["inputs"], "surface": None})
    assert bench.page.locator(".fd-old path").count() == 2
    assert "dashed grey: before" in bench.page.locator(".fd-note").inner_text()


# Tree and rules -------------------------------------------------------------------------------------------------


def test_the_tree_is_walked_with_the_keys(bench: Bench) -> None:
    bench.show("tree")
    page = bench.page
    page.get_by_role("treeitem", name="Inputs").first.focus()
    for key in ("ArrowDown", "ArrowDown", "Enter"):
        page.keyboard.press(key)
    bench.settled()
    assert (bench.selected["variable"], bench.selected["term"]) == ("d", "near")
    assert page.get_by_role("treeitem", name="near, trimf").count() == 1
    page.keyboard.press("ArrowLeft")  # to its variable
    page.keyboard.press("ArrowLeft")  # which is folded
    assert page.get_by_role("treeitem", name="near, trimf").count() == 0
    page.get_by_label("and", exact=True).select_option("min")
    page.get_by_role("button", name="add an output").click()
    bench.settled()
    assert bench.design.system.and_method == "min"
    assert len(bench.design.system.outputs) == 2
    page.get_by_role("textbox", name="system's name").fill("renamed")
    page.get_by_role("textbox", name="system's name").press("Enter")
    bench.settled()
    assert bench.design.system.name == "renamed"


def texts(bench: Bench) -> list[str]:
    return [line.text for line in bench.design.lines]


def test_rules_are_moved_copied_weighed_and_deleted(bench: Bench) -> None:
    bench.show("rules")
    page, first = bench.page, texts(bench)
    page.get_by_role("button", name="move down rule 1").click()
    bench.settled()
    assert texts(bench) == [first[1], first[0], first[2]]
    focus = "document.activeElement.getAttribute('aria-label')"
    assert page.evaluate(focus) == "move down rule 2"  # the focus goes with the rule
    page.keyboard.press("Alt+ArrowDown")
    bench.settled()
    assert texts(bench) == [first[1], first[2], first[0]]
    page.keyboard.press("Alt+ArrowUp")
    page.get_by_role("button", name="copy rule 1").click()
    bench.settled()
    assert texts(bench) == [first[1], first[1], first[0], first[2]]
    page.get_by_role("button", name="delete rule 2").click()
    page.get_by_label("rule 1 in force").uncheck()
    weight = page.get_by_role("spinbutton", name="weight of rule 2")
    weight.fill("0.25")
    weight.press("Enter")
    bench.settled()
    assert not bench.design.lines[0].enabled
    assert bench.design.lines[1].rule.weight == 0.25
    page.get_by_role("button", name="add all combinations").click()
    bench.settled()
    assert len(bench.design.lines) > 3


def test_an_error_is_underlined_at_the_word(bench: Bench) -> None:
    bench.show("rules")
    page, good = bench.page, bench.design.lines[0].rule
    field = page.get_by_role("textbox", name="rule 1")
    field.fill("if d is nearish then v is slow")
    field.press("Enter")
    page.wait_for_selector(".fd-over mark")
    assert page.locator(".fd-over mark").inner_text() == "nearish"
    assert bench.design.lines[0].rule == good
    assert field.get_attribute("aria-invalid") == "true"
    told = page.locator(f"[id='{field.get_attribute('aria-describedby')}']").inner_text()
    assert "nearish" in told
    assert "near" in told.replace("nearish", "")
    field.fill("if d is far then v is slow")
    field.press("Enter")
    bench.settled()
    assert page.locator(".fd-over mark").count() == 0
    assert bench.design.lines[0].rule.when[0].term == "far"


def test_rules_as_a_table(bench: Bench) -> None:
    bench.show("rules")
    page = bench.page
    page.get_by_role("button", name="Table").click()
    row = page.get_by_role("group", name="rule 2 as a table")
    assert json.loads(row.get_by_label("a, manner").input_value()) == [True, 2]
    row.get_by_label("connective").select_option("or")
    row.get_by_label("a, manner").select_option(label="is somewhat")
    row.get_by_label("v, consequent").select_option("mixed")
    bench.settled()
    assert texts(bench)[1] == "if d is far or a is somewhat left then v is mixed"
    row.get_by_label("a, term").select_option("")
    bench.settled()
    assert texts(bench)[1] == "if d is far then v is mixed"


# Viewer and surface ---------------------------------------------------------------------------------------------


def test_the_viewer_follows_the_point(bench: Bench) -> None:
    bench.show("viewer")
    page = bench.page
    key = bench.design.lines[0].key
    firing = f"Number(document.querySelector('[data-rule=\"{key}\"]').dataset.firing)"
    bench.page.evaluate("window.model.held = true")
    before = page.evaluate(firing)
    assert before == pytest.approx(viewer_data(bench.design)["rules"][0]["firing"])
    page.get_by_role("slider", name="d", exact=True).press("Shift+ArrowLeft")
    bench.settled()
    assert page.evaluate(firing) > before  # at once, without an answer
    page.evaluate("(window.model.held = false, window.model.take({}))")
    box = page.locator(".fd-grid-of-rules").bounding_box()
    page.mouse.move(box["x"] + 100, box["y"] + 30)
    page.mouse.down()
    page.mouse.move(box["x"] + 70, box["y"] + 60, steps=4)
    page.mouse.up()
    bench.settled()
    assert 0 < bench.design.point[0] < 1
    rows = viewer_data(bench.design)
    assert page.evaluate(firing) == pytest.approx(rows["rules"][0]["firing"])
    assert page.locator("[data-output='v']").text_content() == f"= {rows['output'][0]:.4g} m/s"
    assert page.locator(".fd-words").text_content() == rows["words"]
    page.get_by_label("only rules that fire").check()
    fires = sum(row["firing"] > 0 for row in rows["rules"])
    assert page.locator(".fd-firing").count() == fires


def test_sections_of_the_surface(bench: Bench) -> None:
    bench.show("surface")
    page = bench.page
    section = page.locator("[data-along='x']")
    before = section.get_attribute("d")
    cross = page.get_by_role("slider", name="section at a")
    cross.press("Shift+ArrowUp")
    bench.settled()
    assert bench.design.point[1] == pytest.approx(0.3)
    assert section.get_attribute("d") != before
    box = page.locator(".fd-over-bands").bounding_box()
    page.mouse.move(box["x"] + 120, box["y"] + 80)
    page.mouse.down()
    page.mouse.move(box["x"] + 160, box["y"] + 120, steps=4)
    page.mouse.up()
    bench.settled()
    gestures = [m for m in bench.sent() if m.get("look") == "point"]
    assert 0 < bench.design.point[0] < 1
    assert gestures[-1]["point"] == list(bench.design.point)
    # The section is the surface's own row: compared with the system itself, through the picture's scale.
    d = [tuple(map(float, pair.split())) for pair in section.get_attribute("d")[1:].split("L") if "M" not in pair]
    fis = replace(bench.design.in_force)
    x = np.linspace(0, 2, 41)
    wanted = fuzzy.infer(fis, np.column_stack([x, np.full(41, bench.design.point[1])])).output[:, 0]
    assert len(d) == 41
    slope, shift = np.polyfit([y for _, y in d], wanted, 1)
    assert slope < 0
    assert np.abs(slope * np.array([y for _, y in d]) + shift - wanted).max() < 0.02


def test_the_surface_turns_and_gaps_are_hatched(bench: Bench) -> None:
    bench.show("surface")
    page = bench.page
    assert "no rule fires" in page.locator(".fd-note").inner_text()
    picture = "document.querySelector('.fd-relief').toDataURL()"
    page.get_by_role("button", name="3-D").click()
    relief = page.get_by_role("img", name="Surface of v")
    seen = [page.evaluate(picture)]
    relief.press("ArrowLeft")
    seen.append(page.evaluate(picture))
    bench.drag(relief, (50, 20))
    page.mouse.up()
    seen.append(page.evaluate(picture))
    assert len(set(seen)) == 3
    page.get_by_label("second input").select_option("")
    bench.settled()
    assert bench.look["inputs"] == [0]
    assert page.get_by_role("slider", name="current d").count() == 1
    page.get_by_role("slider", name="current d").press("End")
    bench.settled()
    assert bench.design.point[0] == 2.0


def test_difference_to_another_design(bench: Bench) -> None:
    fis = system()
    design = design_of(fis)
    rules = [replace(rule, weight=0.3) if n == 0 else rule for n, rule in enumerate(fis.rules)]
    surface = surface_data(design_of(replace(fis, rules=rules)))
    other = {"name": "before", "inputs": design_data(design)["inputs"], "surface": surface}
    bench.show("surface", compared=other)
    assert bench.page.locator(".fd-iso").count() > 2
    bench.page.get_by_label("other design").select_option("difference")
    assert bench.page.locator(".fd-iso").count() == 0
    assert "v − before's" in bench.page.locator(".fd-over-bands").text_content()


# Everybody ------------------------------------------------------------------------------------------------------


NAMED = ("slider", "spinbutton", "textbox", "combobox", "checkbox", "button", "treeitem", "img", "group", "list")


@pytest.mark.parametrize("module", MODULES)
def test_everything_has_a_role_a_name_and_room(bench: Bench, module: str) -> None:
    for width in (390, 1600):
        bench.show(module, width=width)
        assert bench.page.evaluate("document.documentElement.scrollWidth <= innerWidth"), width
    snapshot = bench.page.locator("#here").aria_snapshot()
    for line in snapshot.splitlines():
        words = line.strip().removeprefix("- ").removesuffix(":")
        if words.split(" ")[0] in NAMED:
            assert '"' in words, f"{module}: nameless {words}"
    focusable = """[...document.querySelectorAll("#here [tabindex='0'], #here button, #here input, #here select")]
      .filter((node) => node.checkVisibility() && node.getBoundingClientRect().width === 0).length"""
    assert bench.page.evaluate(focusable) == 0
    bench.page.evaluate("(window.end(), window.end = null)")
    assert bench.page.evaluate("document.getElementById('here').childElementCount") == 0
    assert bench.page.evaluate("[...window.model.hands.values()].every((set) => set.size === 0)")


def test_names_from_a_file_are_text(bench: Bench) -> None:
    evil = "<img src=x onerror=alert(1)>"
    fis = system()
    d = replace(fis.inputs[0], unit=evil, terms={evil: fis.inputs[0].terms["near"]})
    fis = replace(fis, name=evil, inputs=[d, fis.inputs[1]], rules=[f"if d is '{evil}' then v is slow"])
    for module in MODULES:
        bench.show(module, fis)
        assert bench.page.locator("#here img").count() == 0


@pytest.mark.parametrize("path", sorted(STATIC.glob("*.js")), ids=lambda path: path.name)
def test_modules_need_nothing_but_each_other(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert "innerHTML" not in text  # names come from files
    for source in re.findall(r"""\bfrom "([^"]+)";$|\bimport\("([^"]+)"\)""", text, re.MULTILINE):
        name = "".join(source)
        assert name.startswith("./"), name
        assert (STATIC / name).is_file(), name
    assert not re.findall(r"(?:https?:)?//(?!www\.w3\.org/2000/svg)\w+\.\w+", text)
