"""The designer's modules in a real browser, each alone on a page, with the design's own edits and views behind it."""

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
import pytest

import fuzzy
from fuzzy.membershipfunction import MATLAB_NAMES, register
from fuzzy.plugins.designer.design import design_of
from fuzzy.plugins.designer.edits import apply
from fuzzy.plugins.designer.views import design_data, surface_data, viewer_data
from tests.browsers import drag, touch
from tests.fuzzy.plugins.designer.design_bench import STATIC, Bench, system

pytestmark = pytest.mark.long

MODULES = ("terms", "tree", "rules", "check", "viewer", "surface")


@pytest.fixture(scope="module")
def page(browser: Any) -> Bench:
    return Bench(browser.new_page())


@pytest.fixture
def bench(page: Bench) -> Iterator[Bench]:
    page.problems.clear()
    yield page
    page.settled()
    assert page.problems == []


# The terms ------------------------------------------------------------------------------------------------------


def test_a_vertex_is_dragged_before_any_answer_as_one_gesture(bench: Bench) -> None:
    bench.show("terms")
    bench.page.evaluate("window.model.held = true")
    before, handle = bench.curve("near"), bench.page.get_by_role("slider", name="near: peak")
    assert handle.get_attribute("aria-valuetext") == "0.5 m"
    drag(bench.page, handle, (20, 0), (60, 5))
    bench.settled()
    assert bench.curve("near") != before  # the other side has said nothing yet
    messages = bench.sent()
    edits = [m for m in messages if m.get("edit") == "term"]
    assert edits
    assert {m["gesture"] for m in edits} != {None}
    assert len({m["gesture"] for m in edits}) == 1
    # What another says of the dragged term meanwhile is not taken over.
    held = bench.curve("near")
    bench.page.evaluate("window.model.set('design', structuredClone(window.model.get('design')))")
    assert bench.curve("near") == held
    bench.page.mouse.move(2000, 0, steps=3)  # far to the right: the right foot stops it
    bench.page.mouse.up()
    bench.settled()
    last = [m for m in bench.sent() if m.get("edit") == "term"]
    assert last[-1]["parameters"] == [0.0, 1.2, 1.2]
    assert {m["gesture"] for m in last} == {edits[0]["gesture"]}
    assert all(m["parameters"] == sorted(m["parameters"]) for m in last)


def test_a_hand_beyond_the_plot_takes_a_vertex_to_its_edge(bench: Bench) -> None:
    bench.show("terms")
    handle = bench.page.get_by_role("slider", name="near: right foot")
    drag(bench.page, handle, (3000, 0))
    bench.page.mouse.up()
    bench.settled()
    high = bench.page.evaluate("window.model.get('design').inputs[0].high")
    assert bench.parameters("near")[2] == high
    assert handle.get_attribute("aria-valuenow") == f"{high:g}"


def test_a_drag_reaches_the_design_and_escape_takes_it_back(bench: Bench) -> None:
    bench.show("terms")
    handle = bench.page.get_by_role("slider", name="near: right foot")
    drag(bench.page, handle, (-60, 0))
    bench.page.mouse.up()
    bench.settled()
    moved = bench.parameters("near")
    assert moved[:2] == [0.0, 0.5]
    assert 0.5 < moved[2] < 1.2
    assert handle.get_attribute("aria-valuenow") == str(moved[2])
    drag(bench.page, handle, (30, 0))
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


def test_a_finger_drags_a_vertex(bench: Bench) -> None:
    bench.show("terms")
    touch(bench.page, bench.page.get_by_role("slider", name="near: right foot"), -50)
    bench.settled()
    assert bench.parameters("near")[:2] == [0.0, 0.5]
    assert 0.5 < bench.parameters("near")[2] < 1.19


@pytest.fixture
def plateau() -> Iterator[type[fuzzy.MembershipFunction]]:
    """A registered function that has no line in membership.js."""

    @register
    @dataclass(frozen=True)
    class Plateau(fuzzy.Trapezoid):
        matlab: ClassVar[str] = "plateaumf"
        title: ClassVar[str] = "plateau"

    yield Plateau
    del MATLAB_NAMES["plateaumf"]


def test_a_function_without_a_formula_in_the_browser_has_fields_and_handles_but_no_curve(
    bench: Bench, plateau: Callable[..., fuzzy.MembershipFunction]
) -> None:
    fis, page = system(), bench.page
    terms = {"wide": plateau(0.0, 0.5, 1.0, 1.5), "near": fuzzy.Triangle(0.0, 0.5, 1.2)}
    d = replace(fis.inputs[0], terms=terms)
    bench.show("terms", replace(fis, inputs=[d, fis.inputs[1]], rules=["if d is near then v is slow"]))
    assert page.get_by_label("type of wide").locator("option:checked").inner_text() == "plateaumf · plateau"
    assert "L" not in bench.curve("wide")
    assert "L" in bench.curve("near")
    assert page.get_by_role("slider", name="wide").count() == 4  # the vertices
    field = page.get_by_role("spinbutton", name="right foot of wide")
    field.fill("1.75")
    field.press("Enter")
    bench.settled()
    assert bench.parameters("wide") == [0.0, 0.5, 1.0, 1.75]


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
    # Beyond its neighbour: refused below the field, in its words; what was typed stays, the curve is the old one.
    for text, told in (
        ("5", "the peak of near, 5, must not lie right of its right foot, 1.21"),
        ("much", "“much” is not a number"),
    ):
        field.fill(text)
        field.press("Enter")
        page.wait_for_function("document.activeElement.ariaInvalid === 'true'")
        assert page.locator(f"[id='{field.get_attribute('aria-describedby')}']").inner_text() == told
        bench.give(point=[0.2, 0.1])  # other news leave it alone
        assert (field.input_value(), bench.parameters("near")[1]) == (text, 0.71)
        assert page.locator(".fd-problem").inner_text() == ""
    field.press("Escape")
    assert (field.input_value(), field.get_attribute("aria-invalid")) == ("0.71", None)
    word = page.get_by_role("textbox", name="name of near")
    for text, told in (("far", "there is already a term of 'd' named 'far'"), (" ", "the name must not be empty")):
        word.fill(text)
        word.press("Enter")
        page.wait_for_function("document.activeElement.ariaInvalid === 'true'")
        assert page.locator(f"[id='{word.get_attribute('aria-describedby')}']").inner_text() == told
        assert word.input_value() == text
    page.get_by_role("slider", name="current d").press("Home")
    bench.settled()
    assert bench.design.point[0] == 0.0


def test_terms_and_variables_are_named_typed_and_ranged(bench: Bench) -> None:
    bench.show("terms")
    page = bench.page
    name = page.get_by_role("textbox", name="name of near")
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
    page.get_by_role("button", name="Add term").click()
    page.wait_for_function("document.activeElement.ariaLabel === 'name of mf3'")  # it is chosen, and to be named
    assert bench.selected["term"] == "mf3"
    # A new range asks what becomes of the terms; Escape or Cancel leaves all as it was.
    high = page.get_by_role("spinbutton", name="highest value")
    before = bench.design
    for end in ("Escape", None):
        high.fill("4")
        high.press("Enter")
        assert "From 0 to 4: scale the 3 terms" in page.locator(".fd-question").inner_text()
        page.keyboard.press(end) if end else page.get_by_role("button", name="Cancel").click()
        bench.settled()
        assert (bench.design, high.input_value()) == (before, "2")
    high.fill("4")
    high.press("Enter")
    page.keyboard.press("Enter")  # the first answer has the focus: the terms are scaled
    bench.settled()
    assert bench.design.system.inputs[0].universe == (0.0, 4.0)
    assert bench.parameters("far") == [1.0, 4.0]
    high.fill("3")
    high.press("Enter")
    page.get_by_role("button", name="Keep the terms").click()
    bench.settled()
    assert bench.parameters("far") == [1.0, 4.0]
    assert len(bench.design.system.inputs[0].terms) == 3
    assert bench.design.system.inputs[0].universe == (0.0, 3.0)
    page.get_by_role("button", name="remove the term far").click()
    page.get_by_role("button", name="v", exact=True).click()
    bench.settled()
    marker = page.get_by_role("slider", name="slow: value")
    drag(bench.page, marker, (40, 0))
    page.mouse.up()
    bench.settled()
    terms = bench.design.system.outputs[0].terms
    assert terms["slow"].value > 0.2
    assert "far" not in bench.design.system.inputs[0].terms
    page.get_by_role("spinbutton", name="× a of mixed").fill("-0.5")
    page.get_by_role("spinbutton", name="× a of mixed").press("Enter")
    bench.settled()
    assert bench.design.system.outputs[0].terms["mixed"].slopes == (0.05, -0.5)  # stretched with d


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
    assert page.get_by_role("treeitem", name="near trimf").count() == 1
    page.keyboard.press("ArrowLeft")  # to its variable
    page.keyboard.press("ArrowLeft")  # which is folded
    assert page.get_by_role("treeitem", name="near trimf").count() == 0
    page.get_by_label("and", exact=True).select_option("min")
    page.get_by_role("button", name="Add output").click()
    bench.settled()
    assert bench.design.system.and_method == "min"
    assert len(bench.design.system.outputs) == 2
    assert (bench.selected["kind"], bench.selected["variable"]) == ("output", "output2")  # it is to be named
    assert bench.selected["show"] is True
    page.get_by_role("textbox", name="system's name").fill("renamed")
    page.get_by_role("textbox", name="system's name").press("Enter")
    bench.settled()
    assert bench.design.system.name == "renamed"


def test_rules_are_moved_copied_weighed_and_deleted(bench: Bench) -> None:
    bench.show("rules")
    page, first = bench.page, bench.texts()
    page.get_by_role("button", name="tools of rule 1").hover()
    page.get_by_role("button", name="move down rule 1").click()
    bench.settled()
    assert bench.texts() == [first[1], first[0], first[2]]
    focus = "document.activeElement.getAttribute('aria-label')"
    assert page.evaluate(focus) == "move down rule 2"  # the focus goes with the rule
    page.keyboard.press("Alt+ArrowDown")
    bench.settled()
    assert bench.texts() == [first[1], first[2], first[0]]
    page.keyboard.press("Alt+ArrowUp")
    page.get_by_role("button", name="tools of rule 1").hover()
    page.get_by_role("button", name="copy rule 1").click()
    bench.settled()
    assert bench.texts() == [first[1], first[1], first[0], first[2]]
    page.get_by_role("button", name="delete rule 2").press("Enter")
    page.get_by_label("1, rule in force").uncheck()
    weight = page.get_by_role("spinbutton", name="weight of rule 2")
    weight.fill("0.25")
    weight.press("Enter")
    bench.settled()
    assert not bench.design.lines[0].enabled
    assert bench.design.lines[1].rule.weight == 0.25
    page.get_by_role("button", name="Add all combinations").click()
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
    field.press("Escape")  # the last good one is back
    bench.settled()
    assert field.input_value() == bench.texts()[0] == str(good)
    field.fill("if d is far then v is slow")
    field.press("Enter")
    bench.settled()
    assert page.locator(".fd-over mark").count() == 0
    assert bench.design.lines[0].rule.when[0].term == "far"


def choose(field: Any, *value: str, **how: str) -> None:
    """Choose from a list of the table, which has its options once it is used."""
    field.focus()
    field.select_option(*value, **how)


def test_rules_as_a_table(bench: Bench) -> None:
    bench.show("rules")
    page = bench.page
    page.get_by_role("button", name="Table").click()
    row = page.get_by_role("row", name="rule 2")
    assert row.get_attribute("aria-rowindex") == "3"  # below the headings
    assert page.get_by_role("table").get_attribute("aria-rowcount") == "4"
    assert json.loads(row.get_by_label("a, manner").input_value()) == [True, 2]
    choose(row.get_by_label("connective"), "or")
    choose(row.get_by_label("a, manner"), label="is somewhat")
    choose(row.get_by_label("v, consequent"), "mixed")
    bench.settled()
    assert bench.texts()[1] == "if d is far or a is somewhat left then v is mixed"
    choose(row.get_by_label("a, term"), "")
    bench.settled()
    assert bench.texts()[1] == "if d is far then v is mixed"


def many(count: int = 300) -> fuzzy.Sugeno:
    """A system of so many rules that only those in view are drawn."""
    terms = {f"m{k}": fuzzy.Triangle((k - 1) / 9, k / 9, (k + 1) / 9) for k in range(10)}
    inputs = [fuzzy.Variable(name, (0.0, 1.0), terms) for name in "abc"]
    output = fuzzy.Variable("v", (0.0, 1.0), {f"o{k}": k / 9 for k in range(10)})
    rules = [
        f"if a is m{n // 100} and b is m{n // 10 % 10} and c is m{n % 10} then v is o{n % 10}" for n in range(count)
    ]
    return fuzzy.Sugeno(inputs, [output], rules, name="many")


@pytest.mark.long
def test_of_many_rules_those_in_view_are_drawn(bench: Bench) -> None:
    bench.show("rules", many())
    page, rows = bench.page, bench.page.locator(".fd-rule")
    assert rows.count() < 80
    height = "document.documentElement.scrollHeight"
    assert page.evaluate(height) > 300 * 35
    first = page.get_by_role("textbox", name="rule 1", exact=True)
    first.focus()
    page.evaluate(f"scrollTo(0, {height} / 2)")
    page.wait_for_selector("[aria-posinset='150']")
    bench.settled()
    assert rows.count() < 80
    # The row with the focus stays, and keys reach it; a row knows its place among all.
    assert page.evaluate("document.activeElement.ariaLabel") == "rule 1"
    assert page.locator("[aria-posinset='150']").get_attribute("aria-setsize") == "300"
    page.keyboard.press("Alt+ArrowDown")
    bench.settled()
    assert "c is m1" in bench.texts()[0]
    page.get_by_role("button", name="Add rule").click()  # it is at the end, in view, and has the focus
    page.wait_for_function("document.activeElement.ariaLabel === 'rule 301'")
    page.wait_for_function("document.activeElement.getBoundingClientRect().bottom <= innerHeight")
    page.get_by_role("button", name="Table").click()
    bench.settled()
    assert page.get_by_role("table").get_attribute("aria-rowcount") == "302"
    assert rows.count() < 80
    # What one looks for: words, and what fires at the point
    page.get_by_label("find rules").fill("m5 M2")
    bench.settled()
    shown = int(page.get_by_text("of 301 rules").inner_text().split()[0])
    page.wait_for_function(f"document.querySelectorAll('.fd-rule').length === {shown}")  # some in each frame
    fires = {row["key"] for row in viewer_data(bench.design)["rules"] if row["firing"] > 0}
    page.get_by_label("find rules").fill("")
    bench.settled()
    bench.give(point=[0.2, 0.5, 0.5], viewer=viewer_data(bench.design, [0.2, 0.5, 0.5]))
    page.get_by_label("fires now").check()
    bench.settled()
    fires = {row["key"] for row in viewer_data(bench.design, [0.2, 0.5, 0.5])["rules"] if row["firing"] > 0}
    assert {int(key) for key in rows.evaluate_all("(rows) => rows.map((row) => row.dataset.key)")} == fires != set()
    assert bench.leave() == (0, 0)


def test_a_link_leads_to_a_rule_and_findings_have_links(bench: Bench) -> None:
    bench.show("rules", many(), sought={"key": 250, "number": 1})
    bench.settled()
    assert bench.page.evaluate("document.activeElement.ariaLabel") == "rule 251"
    fis = system()
    bench.show("check", replace(fis, rules=[*fis.rules, "if d is near then v is fast"]))
    item = bench.page.get_by_role("listitem").filter(has_text="rules 1 and 4")
    item.get_by_role("button", name="rule 4").click()
    assert bench.sent()[-1] == {"look": "rule", "key": 3}
    bench.give(findings=[])
    assert bench.page.get_by_role("status").inner_text() == "Nothing is wrong with the rules."
    bench.leave()


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


def test_of_many_rules_the_viewer_shows_those_that_fire(bench: Bench) -> None:
    bench.show("viewer", many())
    page, top = bench.page, "document.querySelector('.fd-scroll').scrollTop"
    assert page.locator(".fd-firing").count() < 40
    for point in ([0.0, 0.0, 0.05], [0.2, 0.95, 0.95]):
        shown = viewer_data(bench.design, point)
        bench.give(point=point, viewer=shown)
        bench.settled()
        strongest = max(range(300), key=lambda n: shown["rules"][n]["firing"])
        at = 56 * strongest - page.evaluate(top)  # a row's height is 56 px
        assert 0 <= at < page.locator(".fd-scroll").bounding_box()["height"] - 100
        assert page.locator(f"[data-rule='{strongest}']").count() == 1
    page.get_by_label("strongest first").check()
    page.evaluate(f"{top} = 0")
    bench.settled()
    firing = page.locator(".fd-firing").evaluate_all("(bars) => bars.map((bar) => Number(bar.dataset.firing))")
    assert firing == sorted(firing, reverse=True)
    assert firing[0] == max(rule["firing"] for rule in shown["rules"]) > 0
    # The red line of an input leaves the names of its terms free.
    lines = page.locator(".fd-now-line").first.get_attribute("d")
    labels = page.locator(".fd-clause").evaluate_all("(texts) => texts.map((text) => Number(text.getAttribute('y')))")
    spans = [tuple(map(float, part.split(" ")[1].split("V"))) for part in lines[1:].split("M")]
    assert not any(low <= y <= high for low, high in spans for y in labels)


def test_dust_is_not_shown_and_the_ends_of_an_axis_stand_apart(bench: Bench) -> None:
    fis = system()
    v = replace(fis.outputs[0], terms={"slow": -30.0, "fast": 30.0})
    bench.show("viewer", replace(fis, outputs=[v], rules=[str(rule) for rule in fis.rules[:2]]), width=600)
    shown = bench.traits()["viewer"] | {"output": [-8.882e-16]}
    bench.give(viewer=shown, point=[1e-17, -1.11022e-17])
    assert bench.page.locator(".fd-told").inner_text() == "v = 0 m/s"
    assert bench.page.locator("[data-output='v']").text_content() == "= 0 m/s"
    ends = bench.page.locator(".fd-footline .fd-tick").all()
    assert [end.text_content() for end in ends] == ["−30", "30"]
    left, right = (end.bounding_box() for end in ends)
    assert left["x"] + left["width"] + 4 < right["x"]
    # A width of 1000: the last number is not clipped, and no slope of a field is taken for dust.
    bench.show("terms", replace(fis, inputs=[replace(fis.inputs[0], universe=(0.0, 1000.0)), fis.inputs[1]]), width=420)
    bench.give(point=[-1.11022e-16, 0.5])
    assert bench.page.get_by_role("spinbutton", name="current value").input_value() == "0"
    last = bench.page.locator(".fd-axes .fd-tick").filter(has_text="1000").bounding_box()
    plot = bench.page.locator(".fd-plot").first.bounding_box()
    assert last["x"] + last["width"] <= plot["x"] + plot["width"]
    # Every text stands out from what is behind it.
    pale = bench.page.evaluate("""[...document.querySelectorAll("#here text")].filter((text) =>
      Number(getComputedStyle(text).opacity) < 1).length""")
    assert pale == 0


@pytest.mark.parametrize(("conjunction", "disjunction"), [("min", "max"), ("min", "probor"), ("prod", "max")])
def test_firing_is_that_of_the_chosen_operators(bench: Bench, conjunction: Any, disjunction: Any) -> None:
    fis = system()
    rules = [*fis.rules, "if d is near or a is left then v is fast with 0.5"]
    bench.show("viewer", replace(fis, rules=rules, and_method=conjunction, or_method=disjunction))
    bars = "[...document.querySelectorAll('[data-firing]')].map((bar) => Number(bar.dataset.firing))"
    wanted = [row["firing"] for row in viewer_data(bench.design)["rules"]]
    assert bench.page.evaluate(bars) == pytest.approx(wanted)
    assert len({round(firing, 6) for firing in wanted}) == len(rules)  # else it would prove little


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
    drag(bench.page, relief, (50, 20))
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


WRITTEN = """() => {
  const paint = CanvasRenderingContext2D.prototype, write = paint.fillText, clear = paint.clearRect;
  paint.clearRect = function (...area) { window.written = []; return clear.apply(this, area); };
  paint.fillText = function (text, x, y) {
    const wide = this.measureText(text).width;
    window.written.push([text, x - { left: 0, center: 0.5, right: 1 }[this.textAlign] * wide, wide, y]);
    return write.call(this, text, x, y);
  };
}"""


def test_no_number_of_a_relief_stands_on_another(bench: Bench) -> None:
    """Seen from any side, also where two axes meet in a corner."""
    fis = system()
    d, a = fis.inputs
    bench.show("surface", replace(fis, inputs=(d, replace(a, universe=(-2.0, 2.0)))))  # numbers at both ends of both
    bench.page.evaluate(WRITTEN)
    bench.page.get_by_role("button", name="3-D").click()
    relief = bench.page.get_by_role("img", name="Surface of v")
    for _ in range(18):  # all round
        relief.press("Shift+ArrowLeft")
        written = bench.page.evaluate("window.written")
        assert len(written) > 8
        for k, (text, left, wide, y) in enumerate(written):
            for other, left2, wide2, y2 in written[:k]:
                apart = max(left - left2 - wide2, left2 - left - wide), abs(y - y2) - 8  # 8 px: a digit's height
                assert max(apart) >= 0, (text, other)


def test_names_that_stand_higher_are_led_to_their_peaks(bench: Bench) -> None:
    terms = {
        "very near": fuzzy.Triangle(0, 0, 0.1),
        "near": fuzzy.Triangle(0, 0.1, 0.3),
        "far": fuzzy.Triangle(0, 2, 2),
    }
    rules = ["if d is far then v is fast"]
    inputs, outputs = [fuzzy.Variable("d", (0.0, 2.0), terms)], [fuzzy.Variable("v", (0.0, 1.0), {"fast": 1.0})]
    bench.show("terms", fuzzy.Sugeno(inputs, outputs, rules))
    (leader,) = bench.page.locator("path.fd-leader").all()
    end = leader.get_attribute("d").rpartition("L")[2]
    assert end in bench.curve("near")
    assert end not in bench.curve("very near")


@pytest.mark.parametrize(("module", "part"), [("terms", "svg.fd-chart"), ("tree", ".fd-branches")])
def test_what_an_edit_leaves_on_the_page_is_what_a_new_page_shows(bench: Bench, module: str, part: str) -> None:
    """A drag leaves what is alike as it is."""
    bench.show(module)
    page, picture = bench.page, f"document.querySelector('{part}').innerHTML"
    page.evaluate("window.first = document.querySelector('.fd-tick, [role=treeitem]')")
    for parameters in ([0.0, 0.5, 0.8], [0.0, 1.4, 1.8], [-0.3, 0.0, 1.8]):  # a foot; the peak, which moves the name
        before = page.evaluate(picture)
        message = {"edit": "term", "kind": "input", "variable": "d", "term": "near", "parameters": parameters}
        bench.design = apply(bench.design, {**message, "gesture": None})
        bench.give(**bench.traits())
        shown = page.evaluate(picture)
        assert shown != before
        assert page.evaluate("first.isConnected")
        bench.render(f"{STATIC}/{module}.js", bench.traits(), 900)
        assert page.evaluate(picture) == shown
        page.evaluate("window.first = document.querySelector('.fd-tick, [role=treeitem]')")


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


CLIPPED = """[...document.querySelectorAll("#here svg text")].filter((text) => {
  const own = text.getBoundingClientRect(), svg = text.ownerSVGElement.getBoundingClientRect();
  return own.width > 0 && (own.left < svg.left - 1 || own.right > svg.right + 1);
}).map((text) => text.textContent)"""


@pytest.mark.parametrize("module", ["terms", "viewer", "surface"])
def test_no_number_is_clipped(bench: Bench, module: str) -> None:
    x = fuzzy.Variable(
        "x", (-1000.0, 1000.0), {"low": fuzzy.Triangle(-2000, -1000, 1000), "high": fuzzy.Triangle(-1000, 1000, 2000)}
    )
    y = fuzzy.Variable(
        "y", (-100_000.0, 100_000.0), {"low": fuzzy.Constant(-123_456.0), "high": fuzzy.Constant(123_456.0)}
    )
    rules = ["if x is low and z is low then y is low", "if x is high and z is high then y is high"]
    fis = fuzzy.Sugeno([x, replace(x, name="z")], [y], rules, name="wide")
    for width in (390, 800):
        bench.show(module, fis, width=width)
        assert bench.page.evaluate("document.querySelectorAll('#here svg text').length") > 3
        assert bench.page.evaluate(CLIPPED) == [], width


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
    assert bench.leave() == (0, 0)


def test_names_from_a_file_are_text(bench: Bench) -> None:
    evil = "<img src=x onerror=alert(1)>"
    fis = system()
    d = replace(fis.inputs[0], unit=evil, terms={evil: fis.inputs[0].terms["near"]})
    fis = replace(fis, name=evil, inputs=[d, fis.inputs[1]], rules=[f"if d is '{evil}' then v is slow"])
    for module in MODULES:
        bench.show(module, fis)
        assert bench.page.locator("#here img").count() == 0
