"""The rule matrix, and the list's sorting and selection, in a real browser with the design's own edits behind them."""

from collections.abc import Iterator
from itertools import product
from typing import Any

import numpy as np
import pytest

import fuzzy
from fuzzy.plugins.designer.views import viewer_data
from tests.browsers import Finger, drag, place_of, touch
from tests.fuzzy.plugins.designer.design_bench import Bench

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def page(browser: Any) -> Bench:
    return Bench(browser.new_context(has_touch=True).new_page())


@pytest.fixture
def bench(page: Bench) -> Iterator[Bench]:
    page.problems.clear()
    yield page
    page.settled()
    assert page.problems == []


NAMES = ("N", "Z", "P")


def table(*rules: str, size: int = 3) -> fuzzy.Sugeno:
    """Inputs e and c (its terms written from right to left) and an input of two terms, on [-1, 1]; outputs u and w."""
    names = NAMES if size == 3 else tuple(f"t{k:02}" for k in range(size))
    at = np.linspace(-1.0, 1.0, size)
    terms = {n: fuzzy.Triangle(x - at[1] + at[0], x, x + at[1] - at[0]) for n, x in zip(names, at, strict=True)}
    inputs = [
        fuzzy.Variable("e", (-1.0, 1.0), terms, "m"),
        fuzzy.Variable("c", (-1.0, 1.0), dict(reversed(terms.items()))),
        fuzzy.Variable("mode", (0.0, 1.0), {"a": fuzzy.Triangle(-1, 0, 1), "b": fuzzy.Triangle(0, 1, 2)}),
    ]
    consequents = {"low": -1.0, "mid": fuzzy.Linear((0.5, 0.0, 0.0), 0.0), "high": 1.0, "huge": 3.0}
    outputs = [fuzzy.Variable("u", (-1.0, 3.0), consequents), fuzzy.Variable("w", (0.0, 1.0), {"on": 1.0})]
    return fuzzy.Sugeno(inputs, outputs, rules, name="table")


RULES = (
    "if e is N and c is N and mode is a then u is low",
    "if e is N and c is Z and mode is a then u is mid and w is on",
    "if e is Z and c is Z and mode is a then u is high with 0.5",
    "if e is Z and c is Z and mode is a then u is low",
    "if e is P and mode is a then u is high",
    "if e is P and c is not Z then u is huge",
    "if e is N and c is N and mode is b then u is huge",
)


def cells(bench: Bench) -> dict[tuple[str, str], str]:
    """What the matrix shows: the consequents by the headings of their row and column."""
    shown = bench.page.evaluate(
        """() => {
          const head = (selector, at) => [...document.querySelectorAll(selector)]
            .find((node) => node.style.gridArea.split(" / ")[at] === at_(node, at))?.textContent;
          const at_ = (node, at) => node.style.gridArea.split(" / ")[at];
          const by = (selector, at) => Object.fromEntries([...document.querySelectorAll(selector)]
            .map((node) => [at_(node, at), node.textContent]));
          const rows = by(".fd-mleft", 0), columns = by(".fd-mtop", 1);
          return [...document.querySelectorAll(".fd-mcell")].map((node) => [
            rows[at_(node, 0)], columns[at_(node, 1)], node.dataset.term ?? null]);
        }"""
    )
    return {(row, column): term for row, column, term in shown if term is not None}


def read(bench: Bench, output: str = "u", **fixed: str) -> dict[tuple[str, str], str]:
    """The same from the rules as sentences are parsed: the first that is on, of those with exactly these terms."""
    found: dict[tuple[str, str], str] = {}
    for line in reversed(bench.design.lines):
        rule, when = line.rule, {c.variable: c.term for c in line.rule.when}
        if (
            any(c.negated or c.power != 1 for c in rule.when)
            or rule.connective == "or"
            or output not in dict(rule.then)
        ):
            continue
        if {name: term for name, term in when.items() if name not in ("e", "c")} == fixed:
            found[when.get("e", "any"), when.get("c", "any")] = dict(rule.then)[output]
    return found


def open_matrix(bench: Bench, fis: fuzzy.Sugeno, width: int = 900) -> None:
    bench.show("rules", fis, width=width)
    bench.page.get_by_role("button", name="Matrix").click()
    bench.settled()


def cell(bench: Bench, row: str, column: str) -> Any:
    head = lambda kind, name: bench.page.locator(f".fd-m{kind}").get_by_text(name, exact=True)  # noqa: E731
    place = lambda node, at: node.evaluate(f"(node) => node.style.gridArea.split(' / ')[{at}]")  # noqa: E731
    r, c = place(head("left", row), 0), place(head("top", column), 1)
    return bench.page.locator(f"[data-cell='{int(r) - 2},{int(c) - 2}']")


def test_a_matrix_is_read_and_filled_by_the_mouse(bench: Bench) -> None:
    open_matrix(bench, table(*RULES))
    page = bench.page
    # Terms stand in the order of their places; "any" where rules use it.
    assert page.locator(".fd-mleft").all_inner_texts() == ["N", "Z", "P"]
    assert page.locator(".fd-mtop").all_inner_texts() == ["N", "Z", "P", "any"]
    assert page.get_by_label("mode of the rules shown").input_value() == '"a"'  # where the first rule is
    first = {("N", "N"): "low", ("N", "Z"): "mid", ("Z", "Z"): "high", ("P", "any"): "high"}
    assert cells(bench) == read(bench, mode="a") == first
    assert (
        cell(bench, "Z", "Z").get_attribute("aria-label")
        == "e Z, c Z, mode a: high; 2 rules, 3, 4; weight 0.5; fires 0.50"
    )
    assert cell(bench, "P", "N").inner_text() == "+\n◥"
    told = page.locator(".fd-apart").inner_text()
    assert "rule 3 if e is Z and c is Z" in told.replace("\n", " ")
    assert "if e is P and c is not Z then u is huge" in told
    assert "5 of 7 rules for u stand here, 1 at other terms" in page.locator(".fd-as-matrix .fd-note").inner_text()
    # Looking changes nothing; a brush fills by a click, and along a drag as one edit.
    cell(bench, "Z", "P").click()
    assert [m for m in bench.sent() if "edit" in m] == []
    page.get_by_role("radio", name="huge").click()
    cell(bench, "P", "Z").click()
    bench.settled()
    assert bench.texts()[-1] == "if e is P and c is Z and mode is a then u is huge"
    bench.forget()
    page.get_by_role("radio", name="low").click()
    away = place_of(cell(bench, "Z", "P")), place_of(cell(bench, "Z", "N"))
    drag(page, cell(bench, "Z", "N"), (away[0]["x"] - away[1]["x"], 0))
    assert cell(bench, "Z", "P").get_attribute("data-term") == "low"  # at once
    assert bench.sent() == []
    page.mouse.up()
    bench.settled()
    (sent,) = [m for m in bench.sent() if "edit" in m]
    assert (sent["edit"], len(sent["cells"])) == ("fill_rules", 3)
    assert {("Z", column): "low" for column in NAMES}.items() <= cells(bench).items()
    assert cells(bench) == read(bench, mode="a")
    assert "Several rules" not in page.locator(".fd-apart").inner_text()  # one of the two is left
    # Escape takes a drag back; the right button clears.
    drag(page, cell(bench, "N", "P"), (0, 60))
    page.keyboard.press("Escape")
    page.mouse.up()
    cell(bench, "N", "Z").click(button="right")
    bench.settled()
    assert "if e is N and c is Z and mode is a then w is on" in bench.texts()  # its other output stays
    assert cells(bench) == read(bench, mode="a")
    assert ("N", "P") not in cells(bench)
    page.get_by_label("mode of the rules shown").select_option("b")
    assert cells(bench) == read(bench, mode="b") == {("N", "N"): "huge"}
    page.get_by_label("output").select_option("w")
    page.get_by_label("mode of the rules shown").select_option("a")
    assert cells(bench) == read(bench, "w", mode="a") == {("N", "Z"): "on"}
    # A link leads to the sentence.
    page.get_by_label("output").select_option("u")
    page.locator(".fd-apart").get_by_role("button").first.click()
    bench.settled()
    assert page.evaluate("document.activeElement.value").startswith("if e is P and c is not Z")
    assert bench.leave() == (0, 0)


def test_a_matrix_by_keys(bench: Bench) -> None:
    open_matrix(bench, table(*RULES))
    page = bench.page
    page.locator(".fd-mcell[tabindex='0']").focus()
    label = "document.activeElement.ariaLabel"
    assert page.evaluate(label) == "e N, c N, mode a: low; rule 1"
    page.keyboard.press("Enter")
    assert "Choose a consequent first" in page.locator(".fd-mtold").inner_text()
    page.keyboard.press("ArrowDown")
    page.keyboard.press("End")
    assert page.evaluate(label).startswith("e Z, mode a: no rule")
    page.keyboard.press("ArrowLeft")
    page.keyboard.press("Shift+ArrowDown")
    page.keyboard.press("Shift+ArrowLeft")
    assert page.locator(".fd-mcell[aria-selected=true]").count() == 4
    bench.forget()
    page.keyboard.press("h")
    page.keyboard.press("h")  # the next that begins so
    assert page.get_by_role("radio", name="huge").get_attribute("aria-checked") == "true"
    page.keyboard.press("Enter")
    bench.settled()
    assert len([m for m in bench.sent() if "edit" in m]) == 1
    wanted = dict.fromkeys(product(("Z", "P"), ("Z", "P")), "huge")
    assert wanted.items() <= cells(bench).items()
    assert cells(bench) == read(bench, mode="a")
    assert page.evaluate("document.activeElement.role") == "gridcell"  # the focus stays
    page.keyboard.press("Delete")
    bench.settled()
    assert not set(wanted) & set(cells(bench))
    page.keyboard.press("Control+a")
    assert page.locator(".fd-mcell[aria-selected=true]").count() == 12
    page.keyboard.press("Escape")
    assert page.locator(".fd-mcell[aria-selected=true]").count() == 1
    # What fires is framed, with its strength; the strongest is found wherever it is.
    page.get_by_label("mode of the rules shown").select_option("b")
    bench.give(point=[-0.9, -0.8, 0.2], viewer=viewer_data(bench.design, [-0.9, -0.8, 0.2]))
    page.get_by_role("button", name="Strongest now").click()
    assert page.evaluate(label) == "e N, c N, mode a: low; rule 1; fires 0.58"  # 0.9 · 0.8 · 0.8
    fires = page.locator(".fd-mfires").evaluate_all("(all) => all.map((each) => Number(each.dataset.firing))")
    assert fires == pytest.approx([0.576, 0.144])
    assert bench.leave() == (0, 0)


def test_fifteen_by_fifteen_is_filled_and_scrolls_inside_itself(bench: Bench) -> None:
    open_matrix(bench, table(size=15), width=390)
    page = bench.page
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    assert page.locator(".fd-mcell").count() < 15 * 15  # those in view
    page.locator(".fd-mcell[tabindex='0']").focus()
    page.keyboard.press("Control+a")
    page.get_by_role("radio", name="high").click()
    page.get_by_role("button", name="Fill selected").click()
    bench.settled()
    assert len(bench.design.lines) == 15 * 15
    page.locator(".fd-mcell[tabindex='0']").focus()
    page.keyboard.press("Control+End")
    assert page.evaluate("document.activeElement.ariaLabel").startswith("e t14, c t14: high")
    bench.settled()
    left, box = place_of(page.locator(".fd-mleft").last), place_of(page.locator(".fd-matrix"))
    assert left["x"] == pytest.approx(box["x"] + 1, abs=1)  # the headings stay
    assert place_of(page.locator(".fd-mtop").last)["y"] == pytest.approx(box["y"] + 1, abs=1)
    # A finger taps to fill, and scrolls where it moves.
    page.get_by_role("radio", name="low").click()
    one = page.locator("[data-cell='13,13']")
    one.tap()
    bench.settled()
    assert one.get_attribute("data-term") == "low"
    before = page.evaluate("document.querySelector('.fd-matrix').scrollLeft")
    bench.forget()
    touch(page, page.locator("[data-cell='12,12']"), 80)
    page.wait_for_function("(before) => document.querySelector('.fd-matrix').scrollLeft < before", arg=before)
    bench.settled()
    assert [m for m in bench.sent() if "edit" in m] == []
    # One that rests first fills where it goes.
    rest_and_move(page, page.locator("[data-cell='11,11']"), -60)
    bench.settled()
    (sent,) = [m for m in bench.sent() if "edit" in m]
    assert [when["e"] for when, _ in sent["cells"]] == ["t11", "t11"]
    assert bench.leave() == (0, 0)


def rest_and_move(page: Any, node: Any, dx: float) -> None:
    """Lay a finger on a cell, let it rest until the cell is filled, and move it."""
    finger, brush = Finger(page, node), page.locator(".fd-brush[aria-checked=true]").inner_text()
    page.wait_for_function(
        "([cell, brush]) => document.querySelector(`[data-cell='${cell}']`)?.dataset.term === brush",
        arg=[node.get_attribute("data-cell"), brush],
    )
    finger.move(dx, 2)
    finger.lift()


def test_colours_are_ordered_and_their_text_is_readable(bench: Bench) -> None:
    bench.show("rules", table(*RULES))
    shown = bench.page.evaluate(
        """async () => {
          const { colours } = await import("/fuzzy/plugins/designer/static/matrixcells.js");
          const lum = (text) => text.match(/[\\d.]+/g).map(Number).map((c) => c / 255)
            .map((c) => c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4)
            .reduce((sum, c, k) => sum + c * [0.2126, 0.7152, 0.0722][k], 0);
          const inputs = [{ low: 0, high: 2 }];
          const terms = Array.from({ length: 41 }, (_, k) => ({ name: `t${k}`, type: "constant", parameters: [k] }));
          terms.push({ name: "plane", type: "linear", parameters: [10, 10.5] });  // in the middle 20.5
          return [...colours({ terms }, inputs)].map(([name, { back, ink, mean }]) => {
            const [a, b] = [lum(back), ink === "white" ? 1 : 0];
            return [name, mean, a, (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05)];
          });
        }"""
    )
    assert min(contrast for *_, contrast in shown) >= 4.5
    by_mean = [light for _, _, light, _ in sorted(shown, key=lambda row: row[1])]
    assert by_mean == sorted(by_mean)  # lighter the higher
    assert {name: mean for name, mean, *_ in shown}["plane"] == 20.5


# The list -------------------------------------------------------------------------------------------------------


def order(bench: Bench) -> list[int]:
    keys = bench.page.locator(".fd-rule").evaluate_all("(rows) => rows.map((row) => Number(row.dataset.key))")
    return [int(key) for key in keys]


def test_rules_are_sorted_in_view_only(bench: Bench) -> None:
    bench.show("rules", table(*RULES))
    page, texts = bench.page, bench.texts()
    sort = page.get_by_label("sort")
    sort.select_option(label="consequent: u")  # by their values: low -1, mid 0 in the middle, high 1, huge 3
    assert order(bench) == [0, 3, 1, 2, 4, 5, 6]
    sort.select_option(label="term: c")  # by their places; without one last
    assert order(bench) == [0, 6, 1, 2, 3, 5, 4]
    bench.give(point=[0.9, 0.9, 0.1], viewer=viewer_data(bench.design, [0.9, 0.9, 0.1]))
    sort.select_option(label="strength now")
    strengths = {row["key"]: row["firing"] for row in viewer_data(bench.design, [0.9, 0.9, 0.1])["rules"]}
    assert [strengths[key] for key in order(bench)] == sorted(strengths.values(), reverse=True)
    assert page.get_by_role("button", name="move up rule 5").is_disabled()  # there is no place to move to
    page.get_by_role("textbox", name="rule 5", exact=True).press("Alt+ArrowDown")
    assert bench.texts() == texts
    sort.select_option(label="as written")
    assert order(bench) == list(range(7))


def test_several_rules_are_selected_and_edited_at_once(bench: Bench) -> None:
    bench.show("rules", table(*RULES))
    page = bench.page
    boxes = page.locator(".fd-pick")
    boxes.nth(1).click()
    boxes.nth(3).click(modifiers=["Shift"])
    bar = page.get_by_role("group", name="Selected rules")
    assert bar.get_by_role("status").inner_text() == "3 selected"
    bench.forget()
    bar.get_by_role("button", name="Off").click()
    bench.settled()
    assert [line.enabled for line in bench.design.lines] == [True, False, False, False, True, True, True]
    bar.get_by_role("button", name="On").click()
    bar.get_by_label("weight").fill("0.25")
    bar.get_by_label("weight").press("Enter")
    bar.get_by_label("u of the selected rules").select_option(label="u is huge")
    bench.settled()
    assert [line.rule.weight for line in bench.design.lines[1:4]] == [0.25] * 3
    assert [dict(line.rule.then)["u"] for line in bench.design.lines[1:4]] == ["huge"] * 3
    bar.get_by_role("button", name="move the selected rules down").click()
    bench.settled()
    assert order(bench) == [0, 4, 1, 2, 3, 5, 6]
    assert len([m for m in bench.sent() if "edit" in m]) == 5  # one each
    # By keys: arrows with Shift on a box, Alt with an arrow, Ctrl+A, Delete, Escape
    boxes.nth(2).focus()
    page.keyboard.press("Escape")
    assert bar.is_hidden()
    page.keyboard.press("Shift+ArrowDown")
    page.keyboard.press("Shift+ArrowDown")
    page.keyboard.press("Shift+ArrowUp")
    assert page.locator(".fd-pick:checked").count() == 2
    page.keyboard.press("Alt+ArrowUp")
    bench.settled()
    assert order(bench) == [0, 1, 2, 4, 3, 5, 6]
    assert page.evaluate("document.activeElement.ariaLabel") == "select rule 3"
    page.keyboard.press("Delete")
    bench.settled()
    assert order(bench) == [0, 4, 3, 5, 6]
    assert page.evaluate("document.activeElement.ariaLabel") == "select rule 2"
    # In a sentence Ctrl+A takes its text first; what is filtered out is not selected.
    page.get_by_label("find rules").fill("is P")
    field = page.get_by_role("textbox", name="rule 2", exact=True)
    field.press("Control+a")
    assert bar.is_hidden()
    field.press("Control+a")
    assert bar.get_by_role("status").inner_text() == "2 selected"
    bar.get_by_role("button", name="Delete").click()
    page.get_by_label("find rules").fill("")
    bench.settled()
    assert order(bench) == [0, 3, 6]
    page.get_by_label("select all rules").check()
    assert page.locator(".fd-pick:checked").count() == 3
    assert bench.leave() == (0, 0)


@pytest.mark.long
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_every_form_is_accessible_at_every_width(bench: Bench, scheme: Any) -> None:
    axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="axe-core comes with the extra test")
    page, grave = bench.page, []
    page.emulate_media(color_scheme=scheme)
    for width in (390, 800, 1100, 1600):
        for fis in (table(*RULES), table(size=15)):
            bench.show("rules", fis, width=width)
            for form in ("Matrix", "Table", "Sentences"):
                page.get_by_role("button", name=form, exact=True).click()
                page.locator(".fd-pick:visible, .fd-mcell:visible").first.click() if fis.rules else None
                bench.settled()
                assert page.evaluate("document.documentElement.scrollWidth <= innerWidth"), (width, form)
                found = axe.Axe().run(page, context=".fd-rules").response["violations"]
                grave += [(width, form, rule["id"]) for rule in found if rule["impact"] in ("serious", "critical")]
    page.emulate_media(color_scheme="light")
    assert grave == []
