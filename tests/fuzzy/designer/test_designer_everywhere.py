"""Every tab of the designer on every screen, light and dark: accessible to axe-core, never wider than the screen."""

import shutil
from pathlib import Path
from typing import Any

import pytest

from tests.fuzzy.designer.test_designer_page import PATIENCE, Server

pytest.importorskip("nicegui", reason="the designer needs the extra design")
axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="axe-core comes with the extra test")
ROOT = Path(__file__).parents[3]
SCREENS = ((1600, 1000), (1100, 800), (800, 1000), (390, 844))
# Rules about a whole site, which one tool in one page is not held to.
ASIDE = {"rules": {"region": {"enabled": False}}}
QUIET = 400  # ms without a change of the page after which a tab has been built

_AT_REST = """(quiet) => new Promise((done) => {
  let timer = setTimeout(done, quiet);
  const again = () => { clearTimeout(timer); timer = setTimeout(end, quiet); };
  const watch = new MutationObserver(again);
  const end = () => { watch.disconnect(); done(); };
  watch.observe(document.body, { subtree: true, childList: true, attributes: true });
  setTimeout(end, 8000);
})"""


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    folder = tmp_path_factory.mktemp("tracking")
    shutil.copy(ROOT / "robotics" / "rulebases" / "tracking.fis", folder / "tipper.fis")
    server = Server(folder)
    yield server
    assert server.end() == (0, "")


def grave(page: Any) -> list[str]:
    """What axe-core calls serious or critical, a sentence each."""
    found = axe.Axe().run(page, options=ASIDE).response["violations"]
    return [
        f"{rule['id']}: {node['target']} {node['failureSummary']}"
        for rule in found
        if rule["impact"] in ("serious", "critical")
        for node in rule["nodes"]
    ]


def look_through(browser: Any, server: Any, screen: tuple[int, int], scheme: str, tabs: bool = True) -> list[str]:
    """What is wrong with the page as it is opened, and with each of its tabs."""
    width, height = screen
    context = browser.new_context(viewport={"width": width, "height": height}, color_scheme=scheme)
    page = context.new_page()
    page.emulate_media(color_scheme=scheme, reduced_motion="reduce")
    page.set_default_timeout(PATIENCE)
    page.goto(server.address)
    page.wait_for_selector(".fd-terms [role=slider]")
    wrong = [f"as opened: {sentence}" for sentence in grave(page)]
    names = page.locator("[role=tab]").all_inner_texts()
    assert len(names) >= 8
    for name in names if tabs else ():
        page.locator(f"[role=tab]:text('{name}')").click()
        page.evaluate(_AT_REST, QUIET)
        wide = page.evaluate("document.documentElement.scrollWidth")
        wrong += [f"{name}: the page is {wide} px wide on {width}"] if wide > width else []
        wrong += [f"{name}: {sentence}" for sentence in grave(page)]
    context.close()
    return wrong


def test_the_page_is_accessible(browser, server):
    assert look_through(browser, server, (1100, 800), "light", tabs=False) == []


@pytest.mark.long
@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("screen", SCREENS)
def test_every_tab_is_accessible_on_every_screen(browser, server, screen, scheme):
    assert look_through(browser, server, screen, scheme) == []
