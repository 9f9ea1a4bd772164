"""The report in a browser: on a telephone, in the dark, on paper, with figures that open and players that unpack."""

import re
from collections.abc import Iterator

import pytest

from fuzzy.figures.drawing import PAGE_WIDTH
from robotics.show.playback.player import player_fragment
from robotics.show.report.chapter import Chapter, Film, Grid
from robotics.show.report.page import write_report
from robotics.simulation.scenario.reading import parse_scenario
from robotics.studies.comparison import compare
from tests.robotics.show.playback.browser import CHROMIUM, Browser
from tests.robotics.show.report.test_report import CLAIMS, SCENARIO

DPI = 60  # drawn quickly

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no Chromium")


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    """A report with claims and a chapter with a wide table and a player, opened."""
    folder = tmp_path_factory.mktemp("page")
    comparison = compare([parse_scenario(SCENARIO.replace("5.0\ndiv", "1.0\ndiv"), "there")], ["fuzzy", "esm"], [1, 2])
    run = comparison.runs["there", "fuzzy"]
    wide = Grid("Wide", ("one", *["long heading of a column"] * 9), [("a", *["-12.345 ± 0.678"] * 9)])
    film = Film("To play: there.", lambda: player_fragment(run))
    chapter = Chapter("own", "Mine", ("The ESM.",), [wide], [wide], [], [], films=[film])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("robotics.show.report.plates.DPI", DPI)
        page = write_report([comparison], CLAIMS, folder, chapters=[chapter], command="robotics compare there " * 9)
    with Browser(tmp_path_factory.mktemp("chromium")) as opened:
        opened.size(390, 844)
        opened.open(page)
        yield opened


def test_a_telephone_shows_the_whole_width(browser: Browser) -> None:
    assert browser.js("document.documentElement.scrollWidth") == 390
    assert browser.js("Math.max(...[...document.querySelectorAll('figure img')].map((i) => i.offsetWidth))") < 390
    first = browser.js("document.querySelector('main img').getBoundingClientRect().top + scrollY")
    assert first < 844  # the first picture begins on the first screen
    # and is drawn for a telephone: of the width of other figures, not scaled down from a wide one
    drawn = browser.js("(async () => { const i = document.querySelector('main img'); const p = new Image(); "
                       "p.src = i.currentSrc; await p.decode(); return p.naturalWidth; })()")  # fmt: skip
    assert drawn == pytest.approx(PAGE_WIDTH * DPI, abs=2)
    browser.js("document.querySelectorAll('details:not(.film)').forEach((d) => { d.open = true; })")
    assert browser.js("document.documentElement.scrollWidth") == 390
    browser.js("document.querySelectorAll('main details').forEach((d) => { d.open = false; })")
    assert browser.problems == []


def test_a_figure_opens_in_full_size_and_closes_by_key(browser: Browser) -> None:
    browser.js("document.querySelector('.enlarge').focus()")
    browser.key(" ")
    shown = browser.until("document.querySelector('#enlarged[open] img')?.naturalWidth")
    assert shown == browser.js("document.querySelector('#enlarged img').offsetWidth")
    for kind in ("keyDown", "keyUp"):
        browser.call("Input.dispatchKeyEvent", type=kind, key="Escape", code="Escape", windowsVirtualKeyCode=27)
    browser.until("!document.querySelector('#enlarged').open")
    assert browser.js("document.activeElement.className") == "enlarge"


def test_a_link_opens_what_is_folded(browser: Browser) -> None:
    assert not browser.js("document.querySelector('#glossary details').open")
    browser.js("document.querySelector('a.term').click()")
    browser.until("document.querySelector('#glossary details').open")
    assert browser.js("location.hash").startswith("#term-")


def test_numbers_have_true_minus_signs(browser: Browser) -> None:
    cells = browser.js("[...document.querySelectorAll('td, dd, li')].map((cell) => cell.textContent)")
    assert cells.count("−12.345 ± 0.678") == 18
    assert not [cell for cell in cells if re.search(r"(?<![\w.-])-[\d.]", cell)]


def test_a_player_unpacks_when_it_is_opened(browser: Browser) -> None:
    assert not browser.js("document.querySelector('.film canvas')")
    browser.js("document.querySelector('.film').open = true")
    browser.until("document.querySelector('.film .clock') !== null")
    assert [url for url in browser.requests[1:] if not url.startswith(("data:", "blob:"))] == []  # the page alone
    assert browser.problems == []


def test_pictures_stay_light_in_the_dark(browser: Browser) -> None:
    browser.media(prefers_color_scheme="dark")
    colors = [f"getComputedStyle(document.querySelector('{on}')).backgroundColor" for on in ("body", ".enlarge")]
    browser.until(f"{colors[0]} === 'rgb(21, 24, 28)'")
    assert browser.js(colors[1]) == "rgb(255, 255, 255)"
    browser.media(prefers_color_scheme="light")


def test_paper_has_everything_open_and_numbered_pages(browser: Browser) -> None:
    browser.js("window.dispatchEvent(new Event('beforeprint'))")
    assert browser.js("document.querySelectorAll('details:not([open]):not(.film)').length") == 0
    browser.js("window.dispatchEvent(new Event('afterprint'))")
    assert browser.js("document.querySelectorAll('.claim[open]').length") == 0
    rules = "[...document.styleSheets[0].cssRules]"
    margin = browser.js(f"{rules}.find((rule) => rule instanceof CSSPageRule).cssText")
    assert "counter(page)" in margin
    browser.call("Emulation.setEmulatedMedia", media="print")
    for on, name, value in (
        ("h2", "breakAfter", "avoid"),
        ("figure", "breakInside", "avoid"),
        ("thead", "display", "table-header-group"),
    ):
        assert browser.js(f"getComputedStyle(document.querySelector('{on}')).{name}") == value
    browser.call("Emulation.setEmulatedMedia", media="")
