"""The tab "Tune" end to end: a real server process, which is killed on the way, and a real browser."""

import json
import re
import signal
from collections.abc import Iterator
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

import psutil
import pytest

from fuzzy.files.fisfile import read_fis, write_fis
from robotics.laws.tracking.fuzzy_tracking import load_rule_base
from tests.fuzzy.plugins.designer.conftest import browser as browser
from tests.fuzzy.plugins.designer.served import PATIENCE, Server, Watched

pytestmark = pytest.mark.long
LONG = 3 * PATIENCE


@pytest.fixture
def server(tmp_path: Path) -> Iterator[Any]:
    if not [point for point in entry_points(group="fuzzyfleet.designer") if point.name == "tune"]:
        pytest.skip("the package was installed before it had the panel; install it again")
    write_fis(load_rule_base("tracking"), tmp_path / "tipper.fis")
    server = Server(tmp_path)
    yield server
    if server.process.poll() is None:
        server.end()


@pytest.fixture
def tab(server: Any, browser: Any) -> Iterator[Watched]:
    context = browser.new_context(viewport={"width": 1600, "height": 1000})
    tab = Watched(context, server)
    opened(tab, server.address)
    yield tab
    context.close()


def opened(tab: Watched, address: str) -> Any:
    page = tab.open(address)
    page.get_by_role("button", name="Improve").click()
    page.get_by_role("menuitem", name=": Tune").click()
    page.wait_for_selector(".fd-tuning .pn-main:not([disabled])", timeout=LONG)
    page.wait_for_selector(".tu-many input:checked")
    return page


def begin(page: Any, evaluations: int) -> None:
    """Start a search in which the shipped rule base is soon improved."""
    page.locator(".tu-many input[value=fuzzy-off-path]").check()
    page.locator(".tu-many input[value=lyapunov-sine]").uncheck()
    for label, value in (("Runs (seeds) of each", 3), ("Evaluations", evaluations)):
        page.get_by_label(label, exact=True).fill(str(value))
        page.get_by_label(label, exact=True).press("Tab")
    page.get_by_role("button", name="Start").click()


def state(page: Any) -> str:
    return str(page.locator(".pn-said[role=status]").inner_text())


def paths(page: Any) -> list[str]:
    return [p.get_attribute("d") for p in page.locator(".pn-views svg[aria-label*=path] path.tu-best").all()]


def undo(page: Any) -> Any:
    return page.locator("button", has_text=re.compile("^Undo")).first


def test_the_best_is_shown_while_it_is_searched_and_kept_or_discarded(tab: Watched, server: Any) -> None:
    page, file = tab.page, server.folder / "tipper.fis"
    begin(page, 100_000)
    track = ".pn-views svg[aria-label*='with the best so far'] path.tu-best"
    page.wait_for_selector(track, state="attached", timeout=LONG)
    first = page.locator(track).first.get_attribute("d")
    page.wait_for_function("([s, d]) => document.querySelector(s).getAttribute('d') !== d", arg=[track, first])
    page.get_by_role("button", name="Stop").click()
    page.wait_for_selector(".tu-verdict:text('unseen seeds')", timeout=LONG)
    before, best = map(float, re.findall(r"cost ([\d.]+) before, ([\d.]+) at best", state(page))[0])
    assert best < before
    page.get_by_role("button", name="Keep").click()
    page.wait_for_selector(".tu-verdict:text('is kept')")
    page.keyboard.press("Control+s")
    page.wait_for_selector(".state:not(.unsaved)")
    kept = read_fis(file)
    assert kept != load_rule_base("tracking")
    assert [v.name for v in kept.inputs] == [v.name for v in load_rule_base("tracking").inputs]
    page.keyboard.press("Control+z")  # one step, and all is as it was
    page.wait_for_selector(".state.unsaved")
    page.keyboard.press("Control+s")
    page.wait_for_selector(".state:not(.unsaved)")
    assert read_fis(file) == load_rule_base("tracking")
    assert not (server.folder / ".fuzzy-design" / "tipper.fis.tuning").exists()
    assert tab.wrong == []


def test_a_killed_server_keeps_the_best_and_goes_on(tab: Watched, server: Any) -> None:
    page, place = tab.page, server.folder / ".fuzzy-design" / "tipper.fis.tuning"
    begin(page, 100_000)
    page.wait_for_selector(".pn-views svg[aria-label*='with the best so far']", timeout=LONG)
    tab.forgiven = True
    workers = psutil.Process(server.process.pid).children(recursive=True)
    server.end(signal.SIGKILL)
    assert not psutil.wait_procs(workers, timeout=30)[1]  # what searched ends by itself
    best = json.loads((place / "best.json").read_text())
    rows = len((place / "history.csv").read_text().splitlines()) - 1
    assert best["cost"] < best["before"]
    assert rows > 1
    page.goto("about:blank")  # the page would come back by itself, at any moment
    server.start()
    page = opened(tab, server.address)
    page.wait_for_selector(".tu-left:not([hidden])")
    page.get_by_role("button", name="Go on").click()
    page.wait_for_function(
        "n => Number(document.querySelector('.fd-tuning progress').value) > n", arg=rows, timeout=LONG
    )
    page.get_by_role("button", name="Stop").click()
    page.wait_for_selector(".tu-verdict:text('unseen seeds')", timeout=LONG)
    assert float(re.findall(r"([\d.]+) at best", state(page))[0]) <= best["cost"] * 1.001
    page.get_by_role("button", name="Discard").click()
    page.wait_for_selector(".tu-verdict:text('as it was before')")
    assert not place.exists()
