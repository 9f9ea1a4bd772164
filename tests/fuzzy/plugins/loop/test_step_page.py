"""The tab "Step response" end to end: a real server process and a real browser."""

from collections.abc import Iterator
from dataclasses import replace
from importlib import resources
from importlib.metadata import entry_points
from typing import Any

import pytest

from fuzzy.files.fisfile import read_fis, write_fis
from fuzzy.plugins.designer.starts.control import rule_table
from fuzzy.plugins.loop.controller import Scale
from fuzzy.plugins.loop.keptloop import kept_settings, kept_text
from fuzzy.plugins.loop.plantfile import PLANT_EXAMPLES
from fuzzy.plugins.loop.response import step_response
from tests.fuzzy.plugins.designer.conftest import browser as browser
from tests.fuzzy.plugins.designer.conftest import server as server
from tests.fuzzy.plugins.designer.served import PATIENCE, Server, Watched


@pytest.fixture
def tab(server: Server, browser: Any) -> Iterator[Watched]:
    if not [point for point in entry_points(group="fuzzyfleet.designer") if point.name == "step"]:
        pytest.skip("the package was installed before it had the panel; install it again")
    write_fis(rule_table("pd", 5), server.folder / "step.fis")
    context = browser.new_context(viewport={"width": 1600, "height": 1100})
    tab = Watched(context, server)
    tab.open(f"{server.address}&file=step.fis").get_by_role("tab", name="Step response").click()
    yield tab
    context.close()


def open_settings(page: Any) -> None:
    """Open the sheet with plant, roles and limits."""
    page.locator(".fd-step details.pn-line").evaluate("(sheet) => { sheet.open = true; }")


def settling(page: Any) -> str:
    text: str = page.get_by_role("row", name="Settling time").locator("td").first.inner_text()
    return text


def until(page: Any, condition: str, argument: Any) -> None:
    page.wait_for_function(condition, arg=argument, timeout=PATIENCE)


SAME = "(d) => document.querySelectorAll('.fd-step path.st-design')[1]?.getAttribute('d') === d"


@pytest.mark.long
def test_a_template_is_edited_and_undone_before_a_plant(tab: Watched, server: Server) -> None:
    page = tab.page
    page.wait_for_selector(".fd-step tbody tr")
    example = PLANT_EXAMPLES["integrating"]
    done = step_response(
        read_fis(server.folder / "step.fis"), example.plant, duration=example.duration, scale=Scale(*example.scale),
        limits=example.limits, disturbance=example.disturbance,
    )  # fmt: skip
    assert settling(page) == f"{done.figures.settling_time:.4g}"
    assert page.locator(".fd-step thead th").all_inner_texts() == ["Figure", "design", "PID"]
    # An edit draws the response anew, and the file's beside it; undoing leads back
    curve = page.locator(".fd-step path.st-design").nth(1)
    before = curve.get_attribute("d")
    page.get_by_label("peak of ZE", exact=True).fill("0.2")
    page.get_by_label("peak of ZE", exact=True).press("Enter")
    page.wait_for_selector(".fd-step path.st-file", state="attached")
    until(page, "(d) => document.querySelectorAll('.fd-step path.st-design')[1]?.getAttribute('d') !== d", before)
    assert page.locator(".fd-step thead th").all_inner_texts() == ["Figure", "design", "before", "PID"]
    page.get_by_role("button", name="Undo").click()
    page.wait_for_selector(".fd-step path.st-file", state="detached")
    until(page, SAME, before)
    # The time slider moves the viewer's point to what the rules knew then, which is no edit
    page.get_by_label("Time", exact=True).fill("40")
    page.wait_for_function(
        "(x) => [...document.querySelectorAll('main input')].some((i) => Math.abs(Number(i.value) - x) < 1e-4 && x)",
        arg=float(done.known[40, 0]),
        timeout=PATIENCE,
    )
    assert page.get_by_role("button", name="Redo").is_enabled()
    # What makes no plant is said under its field
    open_settings(page)
    page.get_by_label("Numerator").fill("1 0 0 0 0")
    page.get_by_label("Numerator").press("Enter")
    page.wait_for_selector(".fd-step [aria-invalid=true]")
    assert "must be proper" in page.locator(".fd-step .pn-problem").inner_text()
    # A Python file runs once it is chosen
    page.get_by_role("button", name="Write plant.py").click()
    page.wait_for_selector(".fd-step tbody tr")
    assert (server.folder / "plant.py").is_file()
    assert "need a transfer function" in page.locator(".fd-step .pn-said").inner_text()
    open_settings(page)
    page.get_by_label("Example").select_option("motor")
    page.wait_for_selector(".fd-step thead th:nth-child(3)")
    for width in (1100, 800, 390):
        page.set_viewport_size({"width": width, "height": 900})
        assert page.evaluate("document.documentElement.scrollWidth") <= width
    assert tab.wrong == []


@pytest.mark.long
def test_the_loop_is_part_of_the_design(tab: Watched, server: Server) -> None:
    page = tab.page
    page.wait_for_selector(".fd-step tbody tr")
    fields = {"Numerator": "2", "Denominator": "3 1 0", "Dead time": "0.1"}
    open_settings(page)
    for label, value in fields.items():
        page.get_by_label(label, exact=False).first.fill(value)
        page.get_by_label(label, exact=False).first.press("Enter")
    page.wait_for_function("() => !document.querySelector('.fd-step [aria-invalid=true]')", timeout=PATIENCE)
    page.get_by_role("button", name="Undo").click()
    until(page, "(x) => [...document.querySelectorAll('.fd-step input')].every((i) => i.value !== x)", "0.1")
    page.get_by_role("button", name="Redo").click()
    page.get_by_role("button", name="Save", exact=True).click()
    page.wait_for_function(
        "() => [...document.querySelectorAll('*')].some((e) => e.textContent.trim() === 'saved')", timeout=PATIENCE
    )
    kept = kept_settings(read_fis(server.folder / "step.fis").loop)
    assert (kept["numerator"], kept["denominator"], kept["dead_time"]) == ("2", "3 1 0", 0.1)
    page.reload()
    page.get_by_role("tab", name="Step response").click()
    page.wait_for_selector(".fd-step tbody tr")
    assert page.get_by_label("Denominator", exact=False).first.input_value() == "3 1 0"
    # A plant that is a Python file and came with the design does not run by itself
    fis = read_fis(server.folder / "step.fis")
    (server.folder / "theirs.py").write_text("from pathlib import Path\nPath('ran').write_text('')\n", encoding="utf-8")
    text = kept_text({**kept, "source": "theirs.py"})
    write_fis(replace(fis, loop=text), server.folder / "theirs.fis")
    page.goto(f"{server.address}&file=theirs.fis")
    page.get_by_role("tab", name="Step response").click()
    page.wait_for_selector(".fd-step .pn-problem:not(:empty)")
    assert "it runs when you choose it here" in page.locator(".fd-step .pn-problem").inner_text()
    assert not (server.folder / "ran").exists()
    assert tab.wrong == []


@pytest.mark.long
def test_gains_are_scheduled_over_an_operating_variable(tab: Watched, server: Server) -> None:
    """Points, course and role are chosen in the sheet, and kept; each point and the course are shown."""
    page = tab.page
    (server.folder / "flow.fis").write_text((resources.files("fuzzy") / "examples" / "mixing.fis").read_text("utf-8"))
    page.goto(f"{server.address}&file=flow.fis")
    page.get_by_role("tab", name="Step response").click()
    page.wait_for_selector(".fd-step tbody tr")
    heads = page.locator(".fd-step thead th")
    assert heads.all_inner_texts() == ["Figure", "design", "PID"]
    assert page.locator(".fd-step svg[aria-label='Operating variable over time'] path").count() > 0
    shown = page.get_by_label("Shown", exact=True)
    shown.select_option("points")
    until(page, "(n) => document.querySelectorAll('.fd-step thead th').length === n", 5)
    assert heads.all_inner_texts() == ["Figure", "at 0.5", "at 1", "at 2", "at 4"]
    shown.select_option("4")
    until(page, "(n) => document.querySelectorAll('.fd-step thead th').length === n", 3)
    # At a point the design is its PID
    assert len({*page.get_by_role("row", name="Settling time").locator("td").all_inner_texts()}) == 1
    open_settings(page)
    field = page.get_by_label("Operating points", exact=True)
    field.fill("1: 1; 2 1; 1 | 3: 1; 1 1 1; 1")
    field.press("Enter")
    page.wait_for_selector(".fd-step [aria-invalid=true]")
    assert "one degree" in page.locator(".fd-step .pn-problem").inner_text()
    field.fill("1: 1; 2 1; 1 | 3: 1; 1 1; 0.5")
    field.press("Enter")
    until(page, "(n) => document.querySelectorAll('.fd-step thead th').length === n", 3)
    page.locator(".fd-step details.pn-line").evaluate("(sheet) => { sheet.open = false; }")
    page.get_by_role("button", name="Start from the PID's gains").click()
    page.wait_for_selector("[role=treeitem] >> text=at_3")
    open_settings(page)
    page.locator(".fd-step details details").evaluate_all("(each) => each.forEach((d) => { d.open = true; })")
    course = page.get_by_label("Operating variable over time", exact=True).and_(page.locator("input"))
    course.fill("5,1 5,3")
    course.press("Enter")
    page.get_by_role("button", name="Save", exact=True).click()
    page.wait_for_function(
        "() => [...document.querySelectorAll('*')].some((e) => e.textContent.trim() === 'saved')", timeout=PATIENCE
    )
    fis = read_fis(server.folder / "flow.fis")
    kept = kept_settings(fis.loop)
    assert (kept["points"], kept["operating"]) == ("1: 1; 2 1; 1 | 3: 1; 1 1; 0.5", "5,1 5,3")
    assert kept["roles"] == {"flow": "scheduling"}
    assert [*fis["flow"].terms] == ["at_1", "at_3"]
    assert tab.wrong == []
