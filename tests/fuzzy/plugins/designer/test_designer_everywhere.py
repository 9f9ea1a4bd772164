"""Every tab of the designer on every screen: accessible to axe-core, light and dark, and no wider than the screen."""

import shutil
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from tests.fuzzy.plugins.designer.served import PATIENCE

pytest.importorskip("nicegui", reason="the designer needs the extra design")
axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="axe-core comes with the extra test")
ROOT = Path(__file__).parents[4]
SCREENS = ((1600, 1000), (1100, 800), (800, 1000), (390, 844))
# Rules about a whole site, which one tool in one page is not held to.
ASIDE = {"rules": {"region": {"enabled": False}}}
COLOURS = {"runOnly": {"type": "rule", "values": ["color-contrast"]}}  # all that a dark screen changes
SHAPES = {"rules": {rule: {"enabled": False} for rule in ("region", "color-contrast")}}  # all that its size changes
QUIET = 400  # ms without a change of the page after which a tab has been built

_AT_REST = """(quiet) => new Promise((done) => {
  let timer = setTimeout(done, quiet);
  const again = () => { clearTimeout(timer); timer = setTimeout(end, quiet); };
  const watch = new MutationObserver(again);
  const end = () => { watch.disconnect(); done(); };
  watch.observe(document.body, { subtree: true, childList: true, attributes: true });
  setTimeout(end, 8000);
})"""


@pytest.fixture
def address(server):
    """The address of a rule base that drives a robot."""
    shutil.copy(ROOT / "robotics" / "data" / "rulebases" / "tracking.fis", server.folder / "everywhere.fis")
    return f"{server.address}&file=everywhere.fis"


def grave(page: Any, options: dict[str, Any] = ASIDE) -> list[str]:
    """What axe-core calls serious or critical, a sentence each."""
    found = axe.Axe().run(page, options=options).response["violations"]
    return [
        f"{rule['id']}: {node['target']} {node['failureSummary']}"
        for rule in found
        if rule["impact"] in ("serious", "critical")
        for node in rule["nodes"]
    ]


def places(page: Any) -> Iterator[tuple[str, Callable[[], Any]]]:
    """Each view of each purpose, the editors, and the drawers, with what leads there."""

    def improve(way: str) -> None:
        page.get_by_role("button", name="Improve").click()
        page.get_by_role("menuitem", name=f": {way}").click()

    for title in ("Memberships", "Rules"):
        yield title, page.get_by_role("tab", name=title).click
    yield "Check", page.locator(".shell-badge").click
    yield "History", page.get_by_role("button", name="History", exact=True).click
    ways = {"Function": ["Train"], "Loop": ["Tune the loop"], "Robot": ["Tune"]}
    seen = {"Function": ["Surface", "Data"], "Loop": ["Step response"], "Robot": ["Certificate", "Try it"]}
    for purpose, views in seen.items():
        yield purpose, page.get_by_role("radio", name=purpose).click
        for view in views:
            yield view, page.get_by_role("tab", name=view).click
        for way in ways[purpose]:
            yield way, partial(improve, way)
    yield "Settings", page.locator(".fd-tryout details.pn-line > summary").click
    yield "Pictures", page.get_by_role("button", name="Pictures …").click


def look_through(browser: Any, address: str, screen: tuple[int, int], tabs: bool = True) -> list[str]:
    """What is wrong with the page as it is opened, and with each of its tabs; in its colours on the widest screen."""
    width, height = screen
    coloured = screen == SCREENS[0]
    context = browser.new_context(viewport={"width": width, "height": height}, color_scheme="light")
    page = context.new_page()
    page.emulate_media(color_scheme="light", reduced_motion="reduce")
    page.set_default_timeout(PATIENCE)
    page.goto(address)
    page.wait_for_selector(".fd-terms [role=slider]")
    wrong = [f"as opened: {sentence}" for sentence in grave(page)]
    for name, go in places(page) if tabs else ():
        go()
        page.evaluate(_AT_REST, QUIET)
        wide = page.evaluate("document.documentElement.scrollWidth")
        wrong += [f"{name}: the page is {wide} px wide on {width}"] if wide > width else []
        if width >= 900 and (start := page.locator(".pn-acts .pn-main:visible")).count():
            box = start.bounding_box()
            below = box["y"] + box["height"] - height
            wrong += [f"{name}: {start.inner_text()} is {below:.0f} px below the edge"] if below > 0 else []
        wrong += [f"{name}: {sentence}" for sentence in grave(page, ASIDE if coloured else SHAPES)]
        if coloured:
            page.emulate_media(color_scheme="dark")
            wrong += [f"{name}, dark: {sentence}" for sentence in grave(page, COLOURS)]
            page.emulate_media(color_scheme="light")
    context.close()
    return wrong


@pytest.mark.long
def test_the_page_is_accessible(browser, address):
    assert look_through(browser, address, (1100, 800), tabs=False) == []


@pytest.mark.long
@pytest.mark.parametrize("screen", SCREENS)
def test_every_tab_is_accessible_on_every_screen(browser, address, screen):
    assert look_through(browser, address, screen) == []


@pytest.mark.long
@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("screen", SCREENS)
def test_snapshots_are_accessible_and_touched_on_every_screen(browser, server, address, screen, scheme):
    width, height = screen
    context = browser.new_context(viewport={"width": width, "height": height}, color_scheme=scheme, has_touch=True)
    page = context.new_page()
    page.set_default_timeout(PATIENCE)
    page.goto(address)
    page.wait_for_selector(".fd-terms [role=slider]")
    page.get_by_role("button", name="History", exact=True).tap()
    damaged = server.folder / ".fuzzy-design" / "everywhere.fis.snapshots" / f"{0:016x}.json"
    shots = page.locator(".fd-shot")
    for count, name in enumerate((f"{scheme} {'W' * 60} {width}", "another"), 1):
        page.get_by_label("Name of a snapshot").fill(name)
        page.get_by_role("button", name="Take a snapshot").tap()
        page.wait_for_function("(n) => document.querySelectorAll('.fd-shot').length === n", arg=count)
        damaged.write_text("{")
    shots.nth(0).get_by_role("button", name="Remove").tap()
    page.wait_for_selector(".fd-shot-removed button")
    page.wait_for_selector(".fd-shot-damaged li")
    shots.get_by_role("button", name="Compare").tap()
    page.wait_for_selector(".fd-shot [aria-pressed=true]")
    shots.get_by_role("button", name="Rename").tap()
    page.wait_for_selector(".fd-shot-field")
    assert grave(page) == []
    for target in page.locator(".fd-history button").all():
        box = target.bounding_box()
        assert min(box["width"], box["height"]) >= 24
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    page.keyboard.press("Escape")
    shots.get_by_role("button", name="Remove").tap()
    shots.wait_for(state="detached")
    page.locator(".fd-edits button").last.tap()
    page.wait_for_selector(".fd-edits li:last-child [aria-current]")
    damaged.unlink()
    context.close()
