"""The tab Data in the whole designer: a real server, Chromium, edits in another tab, on every screen."""

from importlib import metadata
from typing import Any

import numpy as np
import pytest

from fuzzy.files.fisfile import write_fis
from fuzzy.files.table import write_table
from fuzzy.plugins.designer.panel import PANEL_ENTRY_POINTS
from tests.browsers import rest
from tests.fuzzy.plugins.designer.served import Server, Watched, tipper
from tests.fuzzy.plugins.designer.test_designer_everywhere import SCREENS, grave

pytest.importorskip("nicegui", reason="the designer needs the extra design")
pytestmark = pytest.mark.long
COUNT = 2000


def meals() -> np.ndarray:
    """Rows time, service, food, tip (rows, 4)."""
    rng = np.random.default_rng(8)
    service, food = rng.uniform(0, 10, COUNT), rng.uniform(1, 9, COUNT)
    return np.column_stack([np.arange(COUNT) / 10, service, food, 3 + 2 * service + rng.normal(0, 1, COUNT)])


@pytest.fixture(scope="module")
def server(tmp_path_factory: Any) -> Any:
    folder = tmp_path_factory.mktemp("meals")
    write_fis(tipper(), folder / "tipper.fis")
    write_table(folder / "meals.csv", ["time", "service", "food", "tip"], meals(), ["s", "", "", "%"])
    with pytest.MonkeyPatch.context() as patch:
        if (
            "data" not in metadata.entry_points(group=PANEL_ENTRY_POINTS).names
        ):  # the installation is older than pyproject.toml
            about = tmp_path_factory.mktemp("site") / "datapanel-0.dist-info"
            about.mkdir()
            (about / "METADATA").write_text("Metadata-Version: 2.1\nName: datapanel\nVersion: 0\n")
            (about / "entry_points.txt").write_text(
                f"[{PANEL_ENTRY_POINTS}]\ndata = fuzzy.plugins.designer.datapanel:panel\n"
            )
            patch.setenv("PYTHONPATH", str(about.parent), prepend=":")
        server = Server(folder)
    yield server
    assert server.end() == (0, "")


def worst(page: Any) -> list[str]:
    lines: list[str] = page.locator(".fd-data .dp-worst button").all_inner_texts()
    return lines


def expected(table: np.ndarray, low: float) -> list[str]:
    """The lines of the ten worst rows, from the written-out tipper with another tip "low"."""
    service, food = table[:, 1], table[:, 2]
    tri = lambda x, a, b, c: np.maximum(0, np.minimum((x - a) / (b - a), (c - x) / (c - b)))  # noqa: E731
    firing = [
        np.minimum(tri(service, -4, 0, 5), tri(food, -6, 0, 7)),
        tri(service, 0, 5, 10),
        np.minimum(tri(service, 5, 10, 14), tri(food, 3, 10, 16)),
    ]
    if tipper().and_method == "prod":
        firing[0] = tri(service, -4, 0, 5) * tri(food, -6, 0, 7)
        firing[2] = tri(service, 5, 10, 14) * tri(food, 3, 10, 16)
    said = (low * firing[0] + 15 * firing[1] + 25 * firing[2]) / sum(firing)
    return [str(k + 2) for k in np.argsort(-abs(table[:, 3] - said), kind="stable")[:10]]


def test_worst_rows_follow_an_edit_and_lead_to_the_viewer(browser: Any, server: Any) -> None:
    context = browser.new_context(viewport={"width": 1600, "height": 1000})
    tab = Watched(context, server)
    page, table = tab.open(server.address), meals()
    page.get_by_role("tab", name="Data").click()
    page.locator(".fd-data").get_by_label("File of the folder").select_option("meals.csv")
    page.wait_for_selector(".fd-data .dp-worst button")
    assert worst(page) == expected(table, 5.0)
    page.locator(".fd-terms .fd-rows g[role=img]").wait_for()
    page.locator(".fd-terms .fd-tab.fd-output").click()
    field = page.get_by_role("spinbutton", name="value of low", exact=True)
    field.fill("25")
    field.press("Enter")
    changed = expected(table, 25.0)
    assert changed != expected(table, 5.0)
    page.wait_for_function(
        "(line) => document.querySelector('.fd-data .dp-worst button').innerText === line", arg=changed[0]
    )
    assert worst(page) == changed
    page.locator(".fd-data .dp-worst button").first.press("Enter")
    row = table[int(changed[0]) - 2]
    page.wait_for_function(
        "(at) => Math.abs(document.querySelector('.fd-viewer [role=slider]').ariaValueNow - at) < 1e-6", arg=row[1]
    )
    now = [float(s.get_attribute("aria-valuenow")) for s in page.locator(".fd-viewer [role=slider]").all()[:2]]
    np.testing.assert_allclose(now, row[1:3], atol=1e-6)
    assert tab.wrong == []
    context.close()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_pictures_fit_every_screen(browser: Any, server: Any, scheme: Any) -> None:
    context = browser.new_context(viewport={"width": 1600, "height": 1000}, color_scheme=scheme)
    tab = Watched(context, server)
    page = tab.open(server.address)
    page.get_by_role("tab", name="Data").click()
    chooser = page.locator(".fd-data").get_by_label("File of the folder")
    worst = page.locator(".fd-data .dp-worst button").first
    chooser.or_(worst).locator("visible=true").first.wait_for()
    if chooser.is_visible():  # else the table of the tab before is the first here
        chooser.select_option("meals.csv")
    worst.wait_for()
    wrong = []
    for width, height in SCREENS:
        page.set_viewport_size({"width": width, "height": height})
        rest(page)
        wide = page.evaluate("document.documentElement.scrollWidth")
        wrong += [f"{width}: the page is {wide} px wide"] if wide > width else []
        wrong += [f"{width}: {sentence}" for sentence in grave(page)]
        small = page.evaluate("""[...document.querySelectorAll(".fd-data button, .fd-data select, .fd-data input")]
          .map((node) => [node.outerHTML.slice(0, 80), node.getBoundingClientRect()])
          .filter(([, box]) => box.width && (box.height < 24 || box.width < 24)).map(([text]) => text)""")
        wrong += [f"{width}: too small: {text}" for text in small]
    assert wrong == []
    assert tab.wrong == []
    context.close()
