"""The panels, the notebook's widgets and the formulas, each alone on a page: their traits are the test's."""

import contextlib
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fuzzy
from anfis.plugins.designer.panel import methods, variables
from fuzzy.membership import FUNCTIONS, membership_function
from fuzzy.plugins.designer.datapictures import Rows, data_pictures
from fuzzy.plugins.designer.views import functions_data
from fuzzy.rule import Clause, Rule
from robotics.laws.catalogue import presets
from robotics.laws.tracking.fuzzy_tracking import load_rule_base
from robotics.plugins.designer.severalseeds import design_seeds, state_of, summary
from robotics.plugins.designer.tryout import TryoutTrial, choices, course_data, place_data, rival_data
from robotics.simulation.scenario.reading import scenario_names
from tests.browsers import drag, rest
from tests.fuzzy.plugins.designer.design_bench import STATIC, Bench, system
from tests.fuzzy.plugins.designer.membership_cases import cases
from tests.fuzzy.plugins.designer.module_page import ModulePage
from tests.robotics.plugins.designer.tried import on_page

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def one_page(browser: Any) -> ModulePage:
    return ModulePage(browser.new_page(), sheet=f"{STATIC}/designer.css")


@pytest.fixture
def bench(one_page: ModulePage) -> Iterator[ModulePage]:
    one_page.problems.clear()
    yield one_page
    assert one_page.leave() == (0, 0)  # a module leaves nothing behind
    assert one_page.problems == []


# The formulas ---------------------------------------------------------------------------------------------------


def test_formulas_equal_pythons(bench: ModulePage) -> None:
    rng = np.random.default_rng(7)
    chosen = cases(rng)
    assert len(chosen) > 500
    assert {name for name, _ in chosen} == {f.matlab for f in FUNCTIONS}
    xs = [sorted({*p, *rng.uniform(-5, 5, 12), 0.0, -1e4, 1e4}) for _, p in chosen]
    script = """async (cases) => {
      const { degree } = await import("./fuzzy/plugins/designer/static/membership.js");
      return cases.map(([name, p, xs]) => xs.map((x) => String(degree(name, x, p))));
    }"""
    theirs = bench.page.evaluate(script, [[name, p, x] for (name, p), x in zip(chosen, xs, strict=True)])
    for (name, p), x, got in zip(chosen, xs, theirs, strict=True):
        with np.errstate(all="ignore"):
            wanted = membership_function(name, p)(np.array(x))
        np.testing.assert_allclose([float(v) for v in got], wanted, rtol=1e-9, atol=1e-12, err_msg=f"{name} {p}")


def test_lower_functions_equal_pythons(bench: ModulePage) -> None:
    rng, asked, wanted = np.random.default_rng(8), [], []
    for name, p in cases(rng)[::5]:
        own = fuzzy.Lower(rng.uniform(0.1, 1), (lag := rng.uniform(0, 0.9), lag if rng.random() < 0.5 else 0.3))
        x = fuzzy.Variable("x", (-2, 2), {"t": membership_function(name, p)})
        y = fuzzy.Variable("y", (0, 1), {"c": 1})
        fis = fuzzy.Sugeno([x], [y], ["if x is t then y is c"], out_of_range="ignore")
        at = np.sort(rng.uniform(-3, 3, 20))
        with contextlib.suppress(fuzzy.InputError), np.errstate(all="ignore"):  # two lags where no degree is 1
            wanted.append(fuzzy.Type2Sugeno(fis, {"x": {"t": own}}).degrees("x", "t", at)[0])
            asked.append([{"type": name, "parameters": p, "lower": [own.scale, *own.lag]}, at.tolist()])
    script = """async ([functions, cases]) => {
      const { lowerDegree } = await import("./fuzzy/plugins/designer/static/membership.js");
      return cases.map(([term, xs]) => xs.map(lowerDegree(term, functions[term.type], -2, 2)));
    }"""
    theirs = bench.page.evaluate(script, [functions_data(), asked])
    assert sum(len(set(term["lower"])) == 3 for term, _ in asked) > 20
    for (term, _), got, known in zip(asked, theirs, wanted, strict=True):
        np.testing.assert_allclose(
            [np.nan if v is None else v for v in got], known, rtol=1e-9, atol=1e-12, err_msg=term
        )


def test_handles_keep_the_order_and_stand_on_the_curve(bench: ModulePage) -> None:
    rng = np.random.default_rng(3)
    chosen = cases(rng)
    script = """async ([functions, cases]) => {
      const { handles, degree } = await import("./fuzzy/plugins/designer/static/membership.js");
      const about = (name, p, to, h) =>
        [h.index, h.name, h.x, h.y, degree(name, h.x, p), h.move(to, 1e-3), h.range.map(String)];
      return cases.map(([name, p, to]) => handles(name, functions[name], p).map((h) => about(name, p, to, h)));
    }"""
    targets = rng.uniform(-4, 4, len(chosen)).tolist()
    asked = [[n, p, t] for (n, p), t in zip(chosen, targets, strict=True)]
    answers = bench.page.evaluate(script, [functions_data(), asked])
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
                for a, b in pairwise(function.vertices):
                    if p[a] <= p[b]:
                        assert after[a] <= after[b], (name, p, words)
            elif min(abs(q) for i, q in enumerate(p) if i not in places) > 0.05:
                assert y == pytest.approx(on_curve, abs=1e-6), (name, p, words, x)
            moved += after != p
    assert moved > 500


# The panel "Train" ----------------------------------------------------------------------------------------------

TRAINING = "anfis/plugins/designer/static/training.js"
ROLES = {"a": "input", "b": "input", "y": "output", "z": "output"}
BELLS = {"low": fuzzy.gbellmf(1, 2, 0), "high": fuzzy.gbellmf(1, 2, 3)}
START = fuzzy.Sugeno(
    [fuzzy.Variable(name, (0.0, 3.0), BELLS) for name in "ab"],
    [fuzzy.Variable(name, (0.0, 1.0), {"on": 1.0}) for name in "yz"],
)
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
    "unit": "",
    "words": [],
}
TRAITS: dict[str, Any] = {
    "sources": {"files": ["made.csv"], "generators": [["formation", "Formation data"]]},
    "accepted": {"start": ["present", "subtractive", "grid"], "method": methods()},
    "table": None,
    "choice": {"start": "present", "radius": 0.5, "mfs": 3, "method": "hybrid", "epochs": 60, "goal": 0.0}
    | {"share": 0.2, "seed": 0},
    "columns": {},
    "system": {"name": "start", "inputs": ["a", "b"], "outputs": ["y", "z"], "rules": 4},
    "progress": IDLE,
    "before": None,
    "after": None,
    "problem": None,
    "unit": "",
    "lack": "",
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


def under(page: Any, label: str, words: str) -> None:
    """Check that one refusal is shown: ``words``, below the field with that name, which knows them."""
    field = page.get_by_label(label, exact=True)
    told = page.locator(f"#{field.get_attribute('aria-describedby')}")
    assert told.inner_text() == words
    assert told.bounding_box()["y"] >= field.bounding_box()["y"] + field.bounding_box()["height"]
    assert field.get_attribute("aria-invalid") == "true"
    assert page.locator("[aria-invalid]").count() == 1


def test_data_columns_and_settings_are_chosen(bench: ModulePage) -> None:
    page = bench.page
    bench.render(TRAINING, TRAITS)
    assert page.get_by_role("button", name="Train").is_disabled()
    page.get_by_label("File of the folder").select_option("g:formation")
    page.get_by_label("Upload a CSV file").set_input_files(
        {"name": "up.csv", "mimeType": "text/csv", "buffer": ("1,2\n" * 60_000).encode()}
    )
    page.wait_for_function("window.model.sent.length === 3")
    sent = bench.sent()
    assert sent[0] == {"do": "generate", "name": "formation"}
    assert "".join(m["text"] for m in sent[1:]) == "1,2\n" * 60_000
    assert [(m["do"], m["name"], m["number"], m["last"]) for m in sent[1:]] == [
        ("piece", "up.csv", 0, False),
        ("piece", "up.csv", 1, True),
    ]
    bench.forget()
    bench.give(**DATA)
    page.get_by_label("z (output)").select_option("<b>z</b>")
    page.get_by_label("Epochs", exact=True).fill("12")
    page.keyboard.press("Tab")
    page.get_by_label("Checking share").fill("25")
    page.keyboard.press("Tab")
    page.get_by_label("Epochs", exact=True).fill("-1")  # no number of epochs: no message to Python
    page.keyboard.press("Tab")
    under(page, "Epochs", "Epochs takes a whole number from 0 to 100000.")
    bench.give(problem={"message": "no column", "field": "column", "column": "z"})
    page.get_by_label("Epochs", exact=True).fill("12")
    page.keyboard.press("Tab")
    under(page, "z (output): its column", "no column")
    bench.give(problem=None)
    page.get_by_label("Start from", exact=True).select_option("grid")
    page.get_by_role("button", name="Train").press("Enter")
    assert bench.sent() == [
        {"do": "column", "name": "z", "value": "<b>z</b>"},
        {"do": "choose", "name": "epochs", "value": 12},
        {"do": "choose", "name": "share", "value": 0.25},
        {"do": "choose", "name": "epochs", "value": 12},
        {"do": "choose", "name": "start", "value": "grid"},
        {"do": "train"},
    ]
    bench.give(choice=TRAITS["choice"] | {"start": "grid"}, columns=ROLES)
    assert page.get_by_label("a, 0 to 1: its role").input_value() == "input"
    assert page.get_by_label("Terms per input").input_value() == "3"
    assert not page.get_by_label("Cluster radius").is_visible()


def test_units_are_shown_and_rows_without_numbers_left_out_by_a_click(bench: ModulePage) -> None:
    page = bench.page
    bench.render(TRAINING, TRAITS)
    page.get_by_label("Upload a CSV file").set_input_files(
        {"name": "wide.csv", "mimeType": "text/csv", "buffer": "T [°C];y\n1,5;2\n".encode("utf-16")}
    )
    page.wait_for_function("window.model.sent.length === 1")
    assert bench.sent()[0]["text"] == "T [°C];y\n1,5;2\n"
    page.get_by_label("Upload a CSV file").set_input_files(
        {"name": "old.csv", "mimeType": "text/csv", "buffer": "T [°C];y\n1;2\n".encode("cp1252")}
    )
    page.get_by_role("alert").get_by_text("old.csv is not text in UTF-8; save it as UTF-8").wait_for()
    bench.forget()
    skip = page.get_by_role("checkbox")
    assert not skip.is_visible()
    columns = [
        {"name": "T", "unit": "°C", "low": 0.0, "high": 1.0},
        {"name": "Time", "unit": "", "low": None, "high": None},
    ]
    bench.give(
        table={"name": "log.csv", "rows": 60, "columns": columns},
        choice=TRAITS["choice"] | {"start": "grid", "skip_bad": False},
        columns={"T": "input", "Time": "unused"},
        progress=DONE | {"unit": "mm"},
        unit="mm",
        lack="1 of 60 rows has no number in 'T' (line 4)",
    )
    assert page.get_by_text("T [°C], 0 to 1", exact=True).is_visible()
    assert page.get_by_text("Time, no numbers", exact=True).is_visible()
    assert page.get_by_text("Error goal (RMSE in mm)").is_visible()
    assert "smallest checking error 0.1 mm at epoch 2 (1 mm at the start)" in page.get_by_role("status").inner_text()
    assert page.locator("svg.pn-plot text", has_text="RMSE [mm]").is_visible()
    page.get_by_label("Leave out rows: 1 of 60 rows has no number in 'T' (line 4)").check()
    assert bench.sent() == [{"do": "choose", "name": "skip_bad", "value": True}]


def test_the_error_curve_is_logarithmic_with_its_least_checking_error(bench: ModulePage) -> None:
    page = bench.page
    bench.render(TRAINING, TRAITS | DATA | {"progress": DONE, "before": variables(START)})
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
    assert "4 rules · 30 parameters · epoch 3 · smallest checking error 0.1 at epoch 2" in status
    assert "stopped by hand" in status
    assert page.get_by_text("The 2 outputs are learnt together").is_visible()
    assert page.get_by_text("input 'a' is constant").is_visible()
    # before and after
    assert page.evaluate("document.querySelectorAll('svg[role=img] path.tn-before').length") == 4
    moved = replace(START, inputs=[replace(v, terms=dict(v.terms)) for v in START.inputs])
    bench.give(after=variables(moved))
    curves = page.evaluate("""[...document.querySelectorAll("svg[aria-label^=Membership]")].map((svg) =>
      ["path.tn-before", "path[stroke]"].map((kind) => [...svg.querySelectorAll(kind)]
        .map((p) => p.getAttribute("d"))))""")
    assert len(curves) == 2
    assert all(before == after and len(after) == 2 for before, after in curves)  # the same terms lie on each other
    page.get_by_role("button", name="Take the best into the design").click()
    assert bench.sent()[-1] == {"do": "take"}
    bench.give(progress=DONE | {"state": "learning", "stopped": None})
    assert page.get_by_role("button", name="Take the best").is_disabled()
    page.get_by_role("button", name="Stop").click()
    assert bench.sent()[-1] == {"do": "stop"}
    bench.give(problem={"message": "made.csv, line 3: <i>no</i>"})
    assert page.get_by_role("alert").inner_text() == "made.csv, line 3: <i>no</i>"


def test_training_and_checking_samples_are_drawn_apart(bench: ModulePage) -> None:
    page, rng = bench.page, np.random.default_rng(2)
    x, checking = rng.uniform(0, 3, (40, 2)), np.arange(40) % 4 == 0
    learnt = replace(START, rules=["if a is low then y is on and z is on"])
    data = data_pictures(learnt, Rows(x, rng.normal(size=(40, 2)), np.arange(40) + 2, checking))
    points, residual = data.pop("points"), data.pop("residual")
    drawn = {"pictures": data, "points": points, "residual": residual, "terms": variables(learnt)}
    about = {"outputs": ["y", "z"], "looks": True}
    bench.render(TRAINING, TRAITS | DATA | {"progress": DONE, "before": variables(START), "about": about} | drawn)
    for cloud in page.locator(".dp-cloud").all():
        marks = [path.get_attribute("d") for path in cloud.locator("path.dp-points").all()]
        assert [marks[0].count("h0"), marks[1].count("m0")] == [30, 10]
    assert page.locator(".dp-pictures .pn-keys").inner_text().split() == ["training", "checking"]
    worst = page.locator(".dp-worst tbody tr").all()
    told = [row.locator("td").first.inner_text() for row in worst]
    assert told == [("training", "checking")[int(checking[row["row"]])] for row in data["worst"]]
    worst[2].locator("td").last.click()
    page.get_by_label("Output", exact=True).select_option("1")
    assert bench.sent() == [{"do": "look", "row": data["worst"][2]["row"]}, {"do": "output", "value": 1}]
    bench.give(about=about | {"looks": False})  # the design has other inputs: there is nothing to look at
    assert page.locator(".dp-worst button").count() == 0


NAMES = """[...document.querySelectorAll("input, select")].map((c) => [
  c.ariaLabel, (c.labels[0]?.querySelector(":scope > span") ?? c.labels[0])?.textContent ?? ""])"""


@pytest.mark.parametrize("width", [390, 1600])
def test_training_fits_the_page(bench: ModulePage, width: int) -> None:
    page = bench.page
    bench.render(TRAINING, TRAITS | DATA | {"progress": DONE, "before": variables(START)}, width)
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    grid = {"choice": TRAITS["choice"] | {"start": "grid"}, "columns": ROLES, "lack": "2 rows", "unit": "V"}
    for extra in ({}, grid):
        bench.give(**extra)
        names = page.evaluate(NAMES)
        assert len(names) > 10
        assert [(name, seen) for name, seen in names if not name or not name.startswith(seen)] == []


# The panel "Try it" ---------------------------------------------------------------------------------------------

TRYOUT = "robotics/plugins/designer/static/tryout.js"


@pytest.fixture(scope="module")
def slower() -> fuzzy.Sugeno:
    """The package's rule base with a gentler turn: another system, with another path."""
    v, w = load_rule_base("tracking").outputs
    gentle = replace(w, terms={**w.terms, "Positive": fuzzy.Constant(1.5)})
    return replace(load_rule_base("tracking"), name="slower", outputs=(v, gentle))


@pytest.fixture(scope="module")
def traits(slower: fuzzy.Sugeno) -> dict[str, Any]:
    tracking = load_rule_base("tracking")
    place = place_data(tracking, TryoutTrial())
    trial = TryoutTrial(**place["trial"])
    return {
        "choices": choices(),
        "files": {"scenarios": ["mine.toml", "sub/<b>.toml"], "robots": ["small.toml"], "laws": []},
        "trial": place["trial"] | {"kind": "tracking", "rival": "lyapunov"},
        "course": place["course"],
        "tried": on_page(slower, trial) | {"notes": ["<img src=x onerror=alert(1)>"]},
        "before": on_page(tracking, trial) | {"label": "as opened"},
        "rival": rival_data("lyapunov", trial),
        "busy": None,
        "problem": None,
        "editor": None,
        "seeds": None,
        "round": None,
    }


def drawn(bench: ModulePage, name: str) -> list[str]:
    found: list[str] = bench.page.evaluate(
        f"[...document.querySelectorAll('path[data-run={name}]')].map((p) => p.getAttribute('d'))"
    )
    return found


def open_settings(page: Any) -> None:
    """Open the sheet with the settings of the runs, if it is not open."""
    page.locator(".fd-tryout details.pn-line").evaluate("(sheet) => { sheet.open = true; }")


def test_the_picture_follows_the_design(bench: ModulePage, traits: dict[str, Any]) -> None:
    page = bench.page
    bench.render(TRYOUT, traits)
    page.wait_for_function("window.model.sent.length > 0")
    assert bench.sent() == [{"do": "see", "on": True}]
    paths = "(name) => [...document.querySelectorAll(`path[data-run=${name}]`)].map((p) => p.getAttribute('d'))"
    page.wait_for_function(f"({paths})('tried').length === 6")  # speeds and torques follow the rest
    first = drawn(bench, "tried")
    assert len(first) == 6  # the top view, the error, both speeds, both wheels' torques
    rival = drawn(bench, "rival")
    bench.give(tried=traits["before"])
    assert drawn(bench, "tried") != first
    same = f"({paths})('tried').slice(0, 4).join() === ({paths})('before').join()"  # torques are the design's alone
    page.wait_for_function(same)
    assert drawn(bench, "rival")[:2] == rival[:2]  # the speeds' axes follow the largest
    # Equal axes: on the circle's picture a metre is the same both ways.
    circle = TryoutTrial(scenario="lyapunov-circle")
    bench.give(course=course_data(circle), tried=None, before=None, rival=None)
    widths = page.evaluate(
        "(({width, height}) => [width, height])(document.querySelector('g path.tr-reference').getBBox())"
    )
    assert widths[0] == pytest.approx(widths[1], rel=0.01)
    bench.give(problem={"message": "it has 1 output"})
    assert page.get_by_role("alert").inner_text() == "it has 1 output"


def test_figures_controls_and_keys(bench: ModulePage, traits: dict[str, Any]) -> None:
    page = bench.page
    bench.render(TRYOUT, traits)
    page.wait_for_function("window.model.sent.length > 0")
    open_settings(page)
    row = page.get_by_role("row", name="RMS cross-track error [m]")
    figures = [float(text) for text in row.get_by_role("cell").all_inner_texts()]
    wanted = [traits[name]["metrics"]["rms_cross_track_m"] for name in ("tried", "before", "rival")]
    assert figures == pytest.approx(wanted, rel=5e-3)
    assert row.locator(".tr-best").inner_text() == row.get_by_role("cell").nth(int(np.argmin(wanted))).inner_text()
    assert "<img" in page.locator(".pn-note").first.inner_text()  # words of a file are words
    # Scenarios stand in their groups, with the names of the command line, and the chosen one is drawn beside them.
    groups = page.evaluate(
        """Object.fromEntries([...document.querySelectorAll("[aria-label=Scenario] optgroup")]
          .map((group) => [group.label.split(":")[0], [...group.children].map((each) => each.textContent)]))"""
    )
    assert list(groups)[:3] == ["Suited to this rule base", "Files in this folder", "One robot"]
    assert {"Teams", "Meetings", "Obstacles"} < groups.keys()
    assert any(text.endswith("[trap-u]") for text in groups["Obstacles"])
    assert sum(len(names) for names in groups.values()) == len(scenario_names()) + 3  # the folder's, and another file
    assert page.locator(".tr-plan path.tr-course").count() == 1
    bench.give(
        course=traits["course"] | {"marks": {"esm": "ignores the others", "fuzzy-team": "does not avoid obstacles"}}
    )
    texts = page.get_by_label("Compare with", exact=True).locator("option").all_inner_texts()
    assert [text for text in texts if "(ignores the others)" in text] == [
        f"{presets()['esm'].title} (ignores the others)"
    ]
    texts = page.get_by_label("Law that holds the rule base", exact=True).locator("option").all_inner_texts()
    assert sum(text.endswith("(does not avoid obstacles)") for text in texts) == 1
    bench.forget()
    page.get_by_label("Scenario", exact=True).select_option("lyapunov-sine")
    page.get_by_label("Compare with", exact=True).select_option("esm")
    page.get_by_label("Scenario", exact=True).select_option("mine.toml")
    page.get_by_label("Law that holds the rule base", exact=True).select_option("fuzzy-team/tracking")
    page.get_by_label("Look-ahead [s]").fill("0.6")
    page.keyboard.press("Tab")
    page.get_by_label("Look-ahead [s]").fill("99")  # no number of seconds that there is: no message to Python
    page.keyboard.press("Tab")
    under(page, "Look-ahead [s]", "Look-ahead [s] takes a number from 0 to 10.")
    bench.give(problem={"message": "no such file", "field": "scenario"})
    page.get_by_label("Look-ahead [s]").fill("0.6")
    page.keyboard.press("Tab")
    under(page, "Scenario", "no such file")
    bench.give(problem=None)
    assert page.locator("[aria-invalid]").count() == 0
    page.get_by_role("button", name="Compare from here").press("Enter")
    assert [message for message in bench.sent() if message["do"] != "list"] == [
        {"do": "choose", "name": "scenario", "value": "lyapunov-sine"},
        {"do": "choose", "name": "rival", "value": "esm"},
        {"do": "choose", "name": "scenario", "value": "mine.toml"},
        {"do": "choose", "name": "law", "value": "fuzzy-team/tracking"},
        {"do": "choose", "name": "look_ahead", "value": 0.6},
        {"do": "choose", "name": "look_ahead", "value": 0.6},
        {"do": "pin"},
    ]
    time = page.get_by_role("slider", name="Time", exact=True)
    time.press("Home")
    assert page.locator("output").inner_text().startswith("0.0 s: −1.41 m")
    options = page.evaluate("[...document.querySelectorAll('option')].filter((o) => o.disabled).map((o) => o.value)")
    assert options == scenario_names("formation")


def test_the_time_is_dragged_clicked_and_played(bench: ModulePage, traits: dict[str, Any]) -> None:
    """All that shows a time shows the same one; Python is asked once at a time, and told which rule is wanted."""
    page = bench.page
    strip = {
        "number": 1,
        "edges": [0.0, 5.0, 10.0, 20.0],
        "rows": [
            {"rule": 3, "text": "if a is b then c is d", "shares": [0.2, 1.0, 0.5]},
            {"rule": 1, "text": "if a is x then c is y", "shares": [0.8, 0.0, None]},
        ],
    }
    fis = load_rule_base("tracking")
    tried = on_page(fis, TryoutTrial(**place_data(fis, TryoutTrial())["trial"])) | {"number": 1}
    bench.render(TRYOUT, traits | {"tried": tried, "rules": strip})
    page.wait_for_selector(".rs-plot")

    def asked() -> list[dict[str, Any]]:
        return [message for message in bench.sent() if message["do"] == "time"]

    def answer() -> None:
        bench.give(moment={"count": asked()[-1]["count"]})

    assert page.locator(".rs-name").all_inner_texts() == ["3: c is d ← a is b", "1: c is y ← a is x"]
    clock = page.get_by_role("slider", name="Time", exact=True)
    for value in ("1", "2", "7"):
        clock.fill(value)
    assert [message["time"] for message in asked()] == [1]  # one question at a time
    answer()
    assert [message["time"] for message in asked()] == [1, 7]  # and the latest of those that waited
    answer()
    assert page.locator(".rs-now").all_inner_texts() == ["100 %", "0 %"]
    assert page.locator(".fd-tryout output").inner_text().startswith("7.0 s")
    # A click on the way leads to when the robot was there, and to the rule that ruled.
    place = page.evaluate("""() => {
      const path = document.querySelector("path[data-run=tried]");
      const at = path.getPointAtLength(path.getTotalLength() / 2);
      const to = at.matrixTransform(path.getScreenCTM());
      return [to.x, to.y];
    }""")
    page.mouse.click(*place)
    answer()
    middle = asked()[-1]
    assert middle["rule"] == "strongest"
    k = min(range(len(tried["time"])), key=lambda n: abs(tried["time"][n] - middle["time"]))
    ways = np.cumsum([0, *np.hypot(np.diff(tried["x"][0]), np.diff(tried["y"][0]))])
    assert ways[k] == pytest.approx(ways[-1] / 2, rel=0.03)
    page.locator(".rs-plot").focus()
    page.keyboard.press("Home")
    answer()
    assert (asked()[-1]["time"], asked()[-1]["rule"]) == (0, None)
    page.locator(".rs-name").first.click()
    answer()
    assert asked()[-1]["rule"] == 3
    page.get_by_role("button", name="Play").click()
    page.wait_for_function("Number(document.querySelector('input[aria-label=Time]').value) > 1")
    page.get_by_role("button", name="Pause").click()


def test_what_a_run_leaves_on_the_page_is_what_a_new_page_shows(bench: ModulePage, traits: dict[str, Any]) -> None:
    page = bench.page
    shown = """[".tr-metrics", ".pn-chips", ".pn-keys", ".pn-views"].map((part) =>
      document.querySelector(part).innerHTML.replaceAll(/tr-[a-z0-9]{8,12}(?=["\\)])/g, "id"))"""
    seen = []
    # Another one, the same as the one before, and one of which nothing is known
    for tried in (traits["tried"], traits["before"], {"label": "it", "why": "it cannot"}):
        bench.render(TRYOUT, traits)
        page.wait_for_function("document.querySelectorAll('path[data-run=tried]').length === 6")
        bench.give(tried=tried)
        page.wait_for_timeout(250)  # speeds and torques follow
        seen.append(page.evaluate(shown))
        bench.render(TRYOUT, traits | {"tried": tried})
        page.wait_for_timeout(250)
        assert page.evaluate(shown) == seen[-1]
    assert len({str(each) for each in seen}) == 3


@pytest.mark.parametrize("width", [390, 1600])
def test_a_trial_fits_the_page(bench: ModulePage, traits: dict[str, Any], width: int) -> None:
    page = bench.page
    bench.render(TRYOUT, traits, width)
    page.wait_for_function("window.model.sent.length > 0")
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    plots = "document.querySelectorAll('.pn-views svg.pn-plot')"
    tops = page.evaluate(f"[...{plots}].map((s) => s.getBoundingClientRect().top)")
    assert tops[0] < tops[1]  # the top view stands alone
    assert (tops[1] == tops[2]) == (width == 1600)  # the curves over time side by side where there is room


def test_a_team_is_played(bench: ModulePage, traits: dict[str, Any], slower: fuzzy.Sugeno) -> None:
    page = bench.page
    place = place_data(slower, TryoutTrial(scenario="crossing-in-turn"))
    trial = TryoutTrial(**place["trial"])
    played = {
        "trial": place["trial"] | {"kind": "team", "rival": "virtual-structure"},
        "course": place["course"],
        "tried": on_page(slower, trial),
        "before": None,
        "rival": {"label": "Virtual structure", "why": "it cannot"},
    }
    bench.render(TRYOUT, traits | played)
    page.get_by_role("button", name="Play").wait_for()
    assert page.locator(".tr-end-refused").inner_text() == "Refused: Virtual structure, waiting. it cannot"
    assert not page.locator(".pn-views svg.pn-plot").first.is_visible()
    page.get_by_role("button", name="Play").click()
    page.wait_for_function("[...document.querySelectorAll('input[type=range]')].some((r) => Number(r.value) > 0)")
    # Another design, while it is played: it is played on.
    bench.give(tried=on_page(load_rule_base("tracking"), trial))
    assert page.get_by_role("button", name="Pause").is_visible()
    assert page.get_by_text("This design: no contact; least clearance ").is_visible()
    bench.give(**{name: traits[name] for name in ("trial", "course", "tried", "rival")})
    assert page.locator(".pn-views svg.pn-plot").first.is_visible()
    assert page.locator(".fp-root").count() == 0


def test_a_played_run_leaves_what_a_new_player_shows(bench: ModulePage, traits: dict[str, Any]) -> None:
    """Of a run that reaches as far the player keeps what stands; of one that reaches farther it shows more floor."""
    page, fis = bench.page, load_rule_base("tracking")
    place = place_data(fis, TryoutTrial(scenario="crossing-in-turn"))
    first = on_page(fis, TryoutTrial(**place["trial"]))
    shown = {"trial": place["trial"] | {"kind": "team", "rival": ""}, "course": place["course"], "before": None}
    x, (left, right, bottom, top) = first["player"]["channels"]["x"], first["player"]["bounds"]
    moved = {**first["player"]["channels"], "x": x | {"offset": x["offset"] + 0.2}}
    picture = "[...document.querySelectorAll('.fleet-player canvas')].map((canvas) => canvas.toDataURL()).join()"
    play, seen = page.get_by_role("button", name="Play"), [""]

    def render(tried: dict[str, Any]) -> None:
        bench.render(TRYOUT, traits | shown | {"tried": tried, "rival": None})
        play.wait_for()
        # A hand that was laid on it keeps its time.
        page.locator(".tr-stages").dispatch_event("pointerdown")

    for change in (
        {},
        {"channels": moved, "bounds": [left, right, bottom, top - 1e-4]},
        {"bounds": [left, right, bottom, top + 0.5]},
    ):
        tried = first | {"player": first["player"] | change}
        render(tried)
        assert page.evaluate(picture) != seen[-1]
        seen.append(page.evaluate(picture))
        render(first)
        bench.give(tried=tried)
        assert page.evaluate(picture) == seen[-1]


def test_a_run_that_nobody_touched_is_replayed_after_an_edit(bench: ModulePage, traits: dict[str, Any]) -> None:
    """From some seconds before the moment that matters most; and a long run says how far it is."""
    page = bench.page
    fis = load_rule_base("tracking")
    place = place_data(fis, TryoutTrial(scenario="crossing-in-turn"))
    tried = on_page(fis, TryoutTrial(**place["trial"]))
    shown = {"trial": place["trial"] | {"kind": "team", "rival": ""}, "course": place["course"], "tried": tried}
    bench.render(TRYOUT, traits | shown | {"before": None, "rival": None})
    page.get_by_role("button", name="Play").wait_for()
    # While one run follows another, as in a drag, none is played.
    said = page.evaluate(
        """async (tried) => {
          const said = new Set();
          for (let k = 0; k < 16; k += 1) {
            window.model.take({ tried: { ...tried, player: { ...tried.player, title: `${k}` } } });
            await new Promise((done) => setTimeout(done, 50));
            said.add(document.querySelector("button.play").textContent);
          }
          return [...said];
        }""",
        tried,
    )
    assert said == ["Play"]
    bench.give(tried=tried | {"player": {**tried["player"], "title": "another"}, "moment": 30.0})
    page.get_by_role("button", name="Pause").wait_for()
    assert 22.0 <= float(page.get_by_role("slider", name="Time", exact=True).input_value()) < 40.0
    bench.give(busy={"what": "tried", "took": 2.0})
    page.get_by_text("this design drives … 1 s").wait_for()
    assert 0.2 < float(page.get_by_role("progressbar").get_attribute("value") or 0) <= 0.97
    bench.give(busy=None)
    assert not page.get_by_role("progressbar").is_visible()


def test_a_scenario_file_from_elsewhere_is_sent(bench: ModulePage, traits: dict[str, Any], tmp_path: Path) -> None:
    page = bench.page
    bench.render(TRYOUT, traits)
    (tmp_path / "far.toml").write_text("duration = 1.0", encoding="utf-8")
    open_settings(page)
    with page.expect_file_chooser() as chooser:
        page.get_by_label("Scenario", exact=True).select_option(label="Another file …")
    chooser.value.set_files(tmp_path / "far.toml")
    page.wait_for_function("window.model.sent.some((message) => message.do === 'file')")
    assert bench.sent()[-1] == {"do": "file", "name": "far.toml", "text": "duration = 1.0"}
    trial = traits["trial"] | {"scenario": "far.toml"}
    bench.give(trial=trial, course=traits["course"] | {"title": "From far away"})
    assert page.get_by_label("Scenario", exact=True).input_value() == "far.toml"
    # With a system or scenario that is no good there is nothing to compare with
    bench.give(course=None, tried=None, before=None, rival=None, problem={"message": "far.toml:1: no robots"})
    assert page.get_by_role("alert").inner_text() == "far.toml:1: no robots"
    assert not page.get_by_label("Compare with", exact=True).is_visible()


DISC = """duration = 3.0
sensing = { posture = "pose", position_noise = 0.01, start_position = 0.03 }
[[robots]]
start = [0.0, 0.05, 0.0]
path = { shape = "line", start = [0.0, 0.0], end = [0.6, 0.0] }
timing = { duration = 3.0 }
"""
WALL = '[[obstacles]]\nshape = "disc"\nposition = [0.3, 0.2]\nradius = 0.12\n'


def test_seeds_contacts_and_a_text_in_place(bench: ModulePage, traits: dict[str, Any]) -> None:
    """The band holds all seeds, contacts are named and marked, and a text tells its fault at its line."""
    page, fis = bench.page, load_rule_base("tracking")

    def given(text: str) -> dict[str, Any]:
        place = place_data(fis, TryoutTrial(scenario="mine.toml", text=text))
        trial = TryoutTrial(**place["trial"])
        rows = design_seeds(fis, trial, 5, range(5))
        seeds = {"count": 5, "shown": 2, "worst": 2, "by": "RMS cross-track error"}
        seeds["runs"] = {"tried": summary(rows, place["course"]["metrics"])}
        seeds["rows"] = [row | {"state": state_of(row), "value": row["metrics"]["rms_cross_track_m"]} for row in rows]
        shown = {"kind": "tracking", "rival": "lyapunov", "count": 5, "text": None}
        runs = {"tried": on_page(fis, replace(trial, seed=2)), "before": None, "rival": None}
        return (
            traits | runs | {"trial": place["trial"] | shown, "course": place["course"], "seeds": seeds, "round": None}
        )

    alone = given(DISC)
    bench.render(TRYOUT, alone | {"editor": None})
    open_settings(page)
    assert page.get_by_text("off takes away: position ± 10 mm, start ± 30 mm").is_visible()
    assert page.locator("path.tr-band").count() == 1
    bar = page.locator(".tr-seeds progress")
    assert bar.is_hidden()
    assert bar.bounding_box()["height"] > 4  # it keeps its place
    assert page.locator(".pn-views path.tr-seed").count() == 4  # the other seeds
    worst = page.get_by_role("row", name="RMS cross-track error [m]").locator(".tr-worst")
    assert float(worst.inner_text()) == pytest.approx(max(row["value"] for row in alone["seeds"]["rows"]), rel=5e-3)
    page.get_by_role("button", name="Seed 2").press("ArrowRight")
    page.keyboard.press("Enter")
    assert bench.sent()[-1] == {"do": "choose", "name": "shown", "value": 3}
    touched = given(DISC + WALL)
    bench.give(**touched)
    assert page.get_by_text("Contact: this design. robot 1 and obstacle 1 touch at").is_visible()
    assert page.locator(".tr-every path.tr-contact").count() == 5
    assert "5 contact" in page.locator(".se-caption").inner_text()
    assert page.get_by_role("row", name="runs with a contact").get_by_role("cell").all_inner_texts() == ["5 of 5"]
    bench.give(tried={"label": "this", "why": "the law knows no safe way"}, seeds=None)
    assert page.get_by_text("Refused: this design. the law knows no safe way").is_visible()
    open_settings(page)
    page.get_by_role("button", name="Edit the scenario's file").click()
    assert bench.sent()[-1] == {"do": "edit", "what": "scenario"}
    editor = {"what": "scenario", "name": "mine.toml", "own": True, "text": DISC, "copy": 1, "saved": True}
    editor |= {"edited": False, "line": None, "message": "", "asks": ""}
    bench.give(editor=editor)
    area = page.get_by_label("Text of the scenario mine.toml")
    assert area.input_value() == DISC
    area.fill(DISC.replace("timing", "timming"))
    page.wait_for_function("window.model.sent.at(-1).do === 'text'")
    assert bench.sent()[-1]["text"] == DISC.replace("timing", "timming")
    bench.give(editor=editor | {"edited": True, "saved": False, "line": 6, "message": "mine.toml:6: unknown key"})
    assert page.locator(".te-wrong").inner_text() == "6"
    assert area.get_attribute("aria-invalid") == "true"
    assert area.input_value() == DISC.replace("timing", "timming")
    # What was never saved is there again when the page is.
    bench.render(TRYOUT, alone | {"editor": None}, width=390)
    page.get_by_role("button", name="Take them up").click()
    assert bench.sent()[-1] == {"do": "edit", "what": "scenario"}
    bench.give(editor=editor | {"copy": 2})
    assert area.input_value() == DISC.replace("timing", "timming")
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    page.get_by_role("button", name="Save", exact=True).click()
    assert bench.sent()[-1] == {"do": "save", "what": "scenario"}
    page.get_by_role("button", name="Revert").click()
    assert page.evaluate("localStorage.length") == 0


# Notebooks ------------------------------------------------------------------------------------------------------


def test_editor_in_a_notebook(bench: ModulePage) -> None:
    pytest.importorskip("anywidget")
    from fuzzy.plugins.designer.notebook import NotebookSession, editor

    page, fis = bench.page, system()
    widget, session = editor(fis), NotebookSession(fis)
    bench.render_text(widget._esm, widget._css, session.traits())
    drag(page, page.get_by_role("slider", name="near: right foot"), (50, 0), release=True)
    page.wait_for_function("window.model.sent.some((message) => message.edit === 'term')")
    for message in bench.sent():
        session.hear(message)
        widget._handle_custom_msg(message, [])
    bench.give(**session.traits())
    page.wait_for_function("window.model.get('seen') === window.model.get('design').revision")  # marimo hears of it
    assert widget.fis["d"].terms["near"].c > 1.25
    assert widget.fis == session.design.in_force
    assert widget.design == session.traits()["design"]
    page.get_by_role("button", name="Undo: move near").click()
    assert bench.sent()[-1] == {"do": "undo"}
    widget._handle_custom_msg({"do": "undo"}, [])
    assert widget.fis == fis
    # The tree is shut, two views stand side by side, and the whole is not higher than a screen.
    assert not page.locator(".fd-tree").is_visible()
    terms, viewer = (page.locator(part).bounding_box() for part in (".fd-terms", ".fd-viewer"))
    assert terms["x"] + terms["width"] < viewer["x"]
    assert page.locator(".fuzzy-editor").bounding_box()["height"] < 800
    for tab, part in (("Rules", "fd-rules"), ("Surface", "fd-surface"), ("Memberships", "fd-terms")):
        page.get_by_role("tab", name=tab).click()
        assert page.locator(f".{part}").is_visible()
    page.get_by_role("tab", name="Viewer").focus()
    page.keyboard.press("End")
    assert page.get_by_role("tab", name="Surface").get_attribute("aria-selected") == "true"
    # The cell is run again: what was redone is there, it is said, and a button starts from the cell's system.
    session.hear({"do": "redo"})
    again = NotebookSession(fis, session)
    bench.give(**again.traits())
    assert page.get_by_role("status").first.inner_text() == "Kept from before: 1 edit."
    page.get_by_role("button", name="Start from the cell's").click()
    again.hear(bench.sent()[-1])
    bench.give(**again.traits())
    assert again.design.in_force == fis
    assert not page.get_by_role("button", name="Start from the cell's").is_visible()
    assert page.get_by_role("button", name="Undo: the system of the cell").is_visible()


def test_a_cell_that_is_run_again_loses_no_edits() -> None:
    pytest.importorskip("anywidget")
    from fuzzy.plugins.designer.notebook import editor

    fis, other = system(), replace(system(), rules=system().rules[:2])
    first = editor(fis, key="rerun")
    foot = {"edit": "term", "variable": "d", "term": "near", "parameters": [0.0, 0.25, 1.0]}
    first._handle_custom_msg(foot, [])
    edited = first.fis
    assert edited != fis
    assert editor(fis, key="another name").fis == fis
    again = editor(fis, key="rerun")
    assert again.fis == edited
    assert again.notice == {"says": "Kept from before: 1 edit.", "anew": True}
    for _ in range(2):  # the cell was changed: its system is shown, and stays when it is run once more
        changed = editor(other, key="rerun")
        assert changed.fis == other
        assert changed.notice == {"says": "The cell gives another system. Undo brings back 1 edit.", "anew": False}
    changed._handle_custom_msg({"do": "undo"}, [])
    assert changed.fis == edited
    changed._handle_custom_msg({"do": "undo"}, [])
    assert changed.fis == fis
    assert first.fis == edited  # each widget has its own history


# As a notebook hears keys: JupyterLab before the page's own elements do, and then by the marks upwards from what has
# the focus; others after them. Chords with Ctrl are to reach it, other keys not.
NOTEBOOK = """() => {
  window.heard = [];
  document.addEventListener("keydown", (event) => {
    if (!event.target.hasAttribute("data-lm-suppress-shortcuts")) heard.push(`before ${event.key}`);
  }, true);
  document.addEventListener("keydown", (event) => {
    heard.push(`after ${event.key}`);
    if (event.key === "s") event.preventDefault();
  });
}"""


def test_keys_on_widgets_stay_from_the_notebook(browser: Any) -> None:
    pytest.importorskip("anywidget")
    import robotics
    from fuzzy.plugins.designer.notebook import NotebookSession, editor
    from robotics.plugins.films.notebook import player

    bench, fis = ModulePage(browser.new_page(), sheet=f"{STATIC}/designer.css"), system()
    page = bench.page
    page.evaluate(NOTEBOOK)
    widget = editor(fis)
    bench.render_text(widget._esm, widget._css, NotebookSession(fis).traits())
    handle = page.get_by_role("slider", name="near: peak")
    before = bench.page.locator("[data-curve='near']").get_attribute("d")
    drag(page, handle, (60, 0))
    page.keyboard.press("Escape")  # is heard before all others, and takes the vertex back
    page.mouse.up()
    rest(page)
    assert page.locator("[data-curve='near']").get_attribute("d") == before
    bench.forget()
    for key in ("d", "d", "a", "x", "z", "Enter", "ArrowRight"):
        handle.press(key)
    page.wait_for_function("window.model.sent.some((message) => message.edit === 'term')")
    bench.forget()
    for keys in ("Control+z", "Control+Shift+Z", "Control+y", "Control+s"):
        handle.press(keys)
    assert [message["do"] for message in bench.sent()] == ["undo", "redo", "redo"]
    assert [key for key in page.evaluate("heard") if key[-7:] != "Control" and key[-5:] != "Shift"] == [
        "before s",
        "after s",
    ]
    name = page.get_by_role("textbox").first
    name.fill("other")
    for keys in ("Control+z", "Control+a", "d"):  # what is being typed has its own undo
        name.press(keys)
    assert len(bench.sent()) == 3
    assert "after a" not in page.evaluate("heard")

    run = robotics.simulate(robotics.load_scenario("lyapunov-circle"), robotics.make_controller("lyapunov"), seeds=[3])
    shown = player(run, end=2.0)
    page.evaluate("heard.length = 0")
    bench.render_text(shown._esm, shown._css, {"run": shown.run, "speed": 1.0, "page": False})
    play = page.get_by_role("button", name="Play")
    for key in ("d", "d", "a", "End"):
        play.press(key)
    assert "2.0" in page.locator(".clock").inner_text()
    assert page.evaluate("heard") == []
    assert bench.problems == []
    page.close()


def test_a_saved_notebook_keeps_a_picture_and_a_sentence() -> None:
    pytest.importorskip("anywidget")
    from base64 import b64decode

    import robotics
    from fuzzy.esmodule import with_still
    from fuzzy.plugins.designer.notebook import editor
    from robotics.plugins.films.notebook import player

    run = robotics.simulate(robotics.load_scenario("lyapunov-circle"), robotics.make_controller("lyapunov"), seeds=[3])
    told = ["Editor of small: 2 inputs, 1 output, 3 rules", "Player of Lyapunov on lyapunov-circle, seed 3"]
    for widget, sentence in zip((editor(system()), player(run, end=2.0)), told, strict=True):
        data, _ = widget._repr_mimebundle_()
        assert data["application/vnd.jupyter.widget-view+json"]["model_id"] == widget.model_id
        assert data["text/plain"] == sentence
        picture = b64decode(data["image/png"])
        assert picture.startswith(b"\x89PNG")
        width, height = (int.from_bytes(picture[k : k + 4], "big") for k in (16, 20))
        assert 300 < width < 1000
        assert 200 < height < 1000

    def nothing() -> bytes:
        raise fuzzy.FuzzySystemError("there is nothing to draw")

    assert with_still(({"a": 1}, {}), "words", nothing) == ({"a": 1, "text/plain": "words"}, {})
    assert with_still(None, "words", nothing) is None


def test_player_in_a_notebook(bench: ModulePage) -> None:
    pytest.importorskip("anywidget")
    import robotics
    from robotics.plugins.films.notebook import player

    scenario = robotics.load_scenario("lyapunov-circle")
    run = robotics.simulate(scenario, robotics.make_controller("lyapunov"), seeds=[3])
    widget = player(run, end=2.0, speed=2.0)
    bench.render_text(widget._esm, widget._css, {"run": widget.run, "speed": widget.speed, "page": False})
    bench.page.get_by_role("slider").first.press("End")
    bench.page.wait_for_function("document.querySelector('.clock').innerText.includes('2.0')")
    bench.page.evaluate("document.querySelector('.fleet-player').remove()")  # the notebook's to take away


# Sentences ------------------------------------------------------------------------------------------------------


def test_words_that_fit_are_offered_and_terms_have_their_colours(browser: Any) -> None:
    """What may come next, by the grammar; Tab, arrows with Enter, and Escape; names with blanks in quotation marks."""
    bench = Bench(browser.new_page())
    page, fis = bench.page, system()
    spaced = replace(
        fis.inputs[1], name="the angle", terms={"far left": fuzzy.ZShape(-2.0, 1.0), "is": fuzzy.SShape(-1.0, 2.0)}
    )
    bench.show("rules", replace(fis, inputs=(fis.inputs[0], spaced), rules=("if d is near then v is slow",)))
    field = page.get_by_role("textbox", name="rule 1", exact=True)
    colours = page.locator(".fd-under .fd-word")
    assert colours.all_inner_texts() == ["near", "slow"]
    field.click()
    field.press("Control+a")

    def offered() -> list[str]:
        return page.locator(".fd-offers:not([hidden]) li").all_inner_texts()

    page.keyboard.type("i")
    assert offered() == ["if"]
    page.keyboard.press("Tab")
    assert (field.input_value(), offered()) == ("if ", ["d", "the angle"])
    page.keyboard.type("TH")
    page.keyboard.press("Tab")
    assert (field.input_value(), offered()) == ("if 'the angle' ", ["is"])
    page.keyboard.type("is ")
    assert offered() == ["far left", "is", "not", "very", "somewhat", "extremely"]
    for _ in range(2):
        page.keyboard.press("ArrowDown")
    assert field.get_attribute("aria-activedescendant") == page.locator("[aria-selected=true]").get_attribute("id")
    page.keyboard.press("Enter")
    assert (field.input_value(), offered()) == ("if 'the angle' is 'is' ", ["and", "or", "then"])
    page.keyboard.type("then v is s")
    assert offered() == ["slow"]  # of the output, and no manner
    page.locator(".fd-offers:not([hidden]) li").click()
    assert (field.input_value(), offered()) == ("if 'the angle' is 'is' then v is slow ", ["and", "with"])
    assert colours.all_inner_texts() == ["'is'", "slow"]
    sentence = field.input_value()
    for _ in range(len(" then v is slow ")):  # in the middle of it too
        page.keyboard.press("ArrowLeft")
    page.keyboard.type(" or T")
    assert offered() == ["the angle"]
    page.keyboard.press("Tab")
    assert " ".join(field.input_value().split()) + " " == "if 'the angle' is 'is' or 'the angle' then v is slow "
    page.keyboard.type("is fa")
    page.keyboard.press("Tab")
    assert (
        " ".join(field.input_value().split()) + " "
        == "if 'the angle' is 'is' or 'the angle' is 'far left' then v is slow "
    )
    page.keyboard.press("Control+a")
    page.keyboard.type(sentence)
    page.keyboard.press("Escape")
    assert offered() == []
    page.keyboard.press("Enter")  # nothing is offered any more: the sentence is taken
    page.wait_for_function("window.model.sent.some((message) => message.edit === 'rule_text')")
    assert [line.rule for line in bench.design.lines] == [Rule((Clause("the angle", "is"),), (("v", "slow"),))]
    field.press("Control+a")
    page.keyboard.type("if d is nea then v is slow")
    page.keyboard.press("Enter")
    page.wait_for_selector(".fd-rules mark")  # what is wrong is underlined as before
