"""The report in a browser: on a telephone, in the dark, on paper, with figures that open and players that unpack."""

import re
from base64 import b64decode
from collections.abc import Iterator
from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from fuzzy.figures.drawing import PAGE_WIDTH, new_figure
from robotics.show.playback.player import player_fragment
from robotics.show.report.chapter import Chapter, Film, Grid, Picture
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
    picture = Picture("large", "Large.", "A large picture.", lambda: new_figure(9.0, 2.0))
    chapter = Chapter("own", "Mine", ("The ESM.",), [wide], [wide], [picture], films=[film._replace(beside="large")])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("robotics.show.report.plates.DPI", DPI)
        page = write_report([comparison], CLAIMS, folder, chapters=[chapter], command="robotics compare there " * 9)
    with Browser(tmp_path_factory.mktemp("chromium")) as opened:
        opened.size(390, 844)
        opened.open(page)
        yield opened


def test_a_telephone_shows_the_whole_width(browser: Browser) -> None:
    assert browser.js("document.documentElement.scrollWidth") == 390
    assert browser.js("Math.max(...[...document.querySelectorAll('.drawn')].map((i) => i.offsetWidth))") < 390
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
    shown = browser.until("document.querySelector('#enlarged[open] img')?.offsetWidth")
    assert shown == int(browser.js("document.querySelector('#enlarged img').getAttribute('width')"))
    for kind in ("keyDown", "keyUp"):
        browser.call("Input.dispatchKeyEvent", type=kind, key="Escape", code="Escape", windowsVirtualKeyCode=27)
    browser.until("!document.querySelector('#enlarged').open")
    assert browser.js("document.activeElement.className") == "enlarge"


def turn(browser: Browser, anchor: str) -> None:
    browser.js(f"location.hash = '{anchor}'")
    browser.until(f"document.getElementById('{anchor}').checkVisibility({{ contentVisibilityAuto: true }})")


def test_one_page_is_in_sight_and_keys_turn_it(browser: Browser) -> None:
    seen = "[...document.querySelectorAll('main > article')].filter((a) => !a.hidden).map((a) => a.innerText)"
    turn(browser, "front")
    (front,) = browser.js(seen)
    assert "What to look at" in front
    browser.js("document.querySelector('.behind a[href=\"#scenario-there\"]').focus()")
    browser.key("Enter")
    browser.until("document.title.startsWith('there')")
    (there,) = browser.js(seen)
    assert "Conditions" in there
    assert browser.js("document.querySelector('.contents [aria-current]').textContent") == "there"
    browser.js("document.querySelector('article:not([hidden]) [rel=next]').click()")
    browser.until("document.title.startsWith('Mine')")
    browser.js("history.back()")
    browser.until("document.title.startsWith('there')")
    # What the browser's search finds where nobody looks is turned to
    assert browser.js("document.getElementById('terms').parentElement.getAttribute('hidden')") == "until-found"
    browser.js("document.getElementById('terms').parentElement.dispatchEvent(new Event('beforematch'))")
    browser.until("document.title.startsWith('What was compared')")
    turn(browser, "figure-large")
    assert browser.js("document.querySelector('#figure-large + .film') !== null")  # it is played where it is drawn


def test_a_large_picture_scrolls_in_its_box(browser: Browser) -> None:
    turn(browser, "figure-large")
    box, picture = (browser.js(f"document.querySelector('#figure-large {on}').clientWidth") for on in (".drawn", "img"))
    assert picture > 9.0 * 76 - 20 > box
    assert browser.js("document.documentElement.scrollWidth") == 390
    turn(browser, "front")


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


def test_pictures_follow_the_dark(browser: Browser) -> None:
    """The paper of a picture becomes that of the page; hues and the contrast of letters stay."""
    turn(browser, "front")
    browser.js("document.querySelector('main img').scrollIntoView()")
    light, dark = (shown(browser, scheme) for scheme in ("light", "dark"))
    assert (np.median(light.reshape(-1, 3), axis=0) == 255).all()
    assert np.median(dark.reshape(-1, 3), axis=0) == pytest.approx([21, 24, 28], abs=2)
    assert light.min() < 60
    assert dark.max() > 220
    blue = np.abs(light - [0, 114, 178]).sum(axis=2) < 24  # of the first series
    assert blue.any()
    red, green, stays = dark[blue].mean(axis=0)
    assert stays > green > red
    browser.media(prefers_color_scheme="light")


def shown(browser: Browser, scheme: str) -> np.ndarray:
    """The pixels (rows, columns, 3) of the first picture, light or dark."""
    browser.media(prefers_color_scheme=scheme)
    browser.js("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(1))))")
    box = browser.js("(() => { const b = document.querySelector('main img').getBoundingClientRect(); "
                     "return [b.x, b.y + scrollY, b.width, b.height]; })()")  # fmt: skip
    clip = dict(zip(("x", "y", "width", "height"), box, strict=True)) | {"scale": 1}
    image = browser.call("Page.captureScreenshot", clip=clip, captureBeyondViewport=True)["data"]
    return np.asarray(Image.open(BytesIO(b64decode(image))).convert("RGB"), int)


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
        ("#scenario-there thead", "display", "table-header-group"),
        ("article[hidden]", "contentVisibility", "visible"),
    ):
        assert browser.js(f"getComputedStyle(document.querySelector('{on}')).{name}") == value
    browser.call("Emulation.setEmulatedMedia", media="")
