"""The tab "Step response" end to end: a real server process and a real browser."""

from collections.abc import Iterator
from importlib.metadata import entry_points
from typing import Any

import pytest

from fuzzy.files.fisfile import read_fis, write_fis
from fuzzy.plugins.designer.starts.control import rule_table
from fuzzy.plugins.loop.controller import Scale
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
    assert page.locator(".fd-step thead th").all_inner_texts() == ["Figure", "design", "file", "PID"]
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
    page.get_by_label("Numerator").fill("1 0 0 0 0")
    page.get_by_label("Numerator").press("Enter")
    page.wait_for_selector(".fd-step [aria-invalid=true]")
    assert "must be proper" in page.locator(".fd-step .pn-problem").inner_text()
    # A Python file runs once it is chosen
    page.get_by_role("button", name="Write plant.py").click()
    page.wait_for_selector(".fd-step tbody tr")
    assert (server.folder / "plant.py").is_file()
    assert "need a transfer function" in page.locator(".fd-step .pn-said").inner_text()
    page.get_by_label("Example").select_option("motor")
    page.wait_for_selector(".fd-step thead th:nth-child(3)")
    for width in (1100, 800, 390):
        page.set_viewport_size({"width": width, "height": 900})
        assert page.evaluate("document.documentElement.scrollWidth") <= width
    assert tab.wrong == []
