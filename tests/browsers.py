"""Headless Chromium for tests, driven by playwright; tests are skipped where there is none.

Pages draw themselves anew while they scroll, are resized or hear from Python, so an element that a test has found may
be another one a frame later. Nothing here waits for a clock: what is asked for is waited for.
"""

import asyncio
import shutil
from collections.abc import Coroutine, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any

import pytest

FLAGS = (
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)


@contextmanager
def started() -> Iterator[Any]:
    """The browser, whose event loop runs until it is closed."""
    chromium = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if chromium is None:
        pytest.skip("the browser tests need Chromium, and none is installed")
    playwright = pytest.importorskip("playwright.sync_api", reason="the browser tests need playwright (extra test)")
    with playwright.sync_playwright() as driver:
        window = driver.chromium.launch(executable_path=chromium, args=list(FLAGS))
        yield window
        window.close()


REST = """() => new Promise((done) => {
  let still = 0;
  const again = () => (still = 0);
  const news = new MutationObserver(again);
  news.observe(document, { subtree: true, childList: true, attributes: true, characterData: true });
  document.addEventListener("scroll", again, { capture: true, passive: true });
  const moves = (each) => each.playState === "running" && each.effect?.getComputedTiming().endTime !== Infinity;
  const look = () => {
    if (window.model?.asked || document.getAnimations().some(moves)) again();
    if (still++ < 3) return requestAnimationFrame(look);
    news.disconnect();
    document.removeEventListener("scroll", again, { capture: true });
    done();
  };
  requestAnimationFrame(look);
})"""
PLACE = """(node) => new Promise((done) => {
  let still = 0, before = "";
  node.scrollIntoViewIfNeeded();
  const look = () => {
    const { x, y, width, height } = node.getBoundingClientRect(), now = [x, y, width, height].join();
    if (!node.isConnected) return done(null);
    still = now === before ? still + 1 : 0;
    before = now;
    if (still < 3) requestAnimationFrame(look);
    else done({ x, y, width, height });
  };
  requestAnimationFrame(look);
})"""


def run_apart(scene: Coroutine[Any, Any, Any]) -> Any:
    """Run a scene in a thread of its own: a browser that another test opened in this one has a loop that runs."""
    with ThreadPoolExecutor(1) as pool:
        return pool.submit(asyncio.run, scene).result()


def rest(page: Any) -> None:
    """Wait until nothing on the page has changed, scrolled or moved for three frames, and Python has answered it."""
    page.evaluate(REST)


def place_of(node: Any) -> dict[str, float]:
    """Bring the element of a locator into view; return its box once it rests there [px].

    An element that is replaced meanwhile is looked for again.
    """
    while (box := node.evaluate(PLACE)) is None:
        pass
    return dict(box)


def middle_of(node: Any) -> tuple[float, float]:
    """The middle of an element, which is brought into view and rests there [px]."""
    box = place_of(node)
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def drag(page: Any, handle: Any, *by: tuple[float, float], release: bool = False) -> None:
    """Press the mouse on ``handle`` and move it by each of ``by`` [px] from there."""
    x, y = middle_of(handle)
    page.mouse.move(x, y)
    page.mouse.down()
    for dx, dy in by:
        page.mouse.move(x + dx, y + dy, steps=3)
    if release:
        page.mouse.up()


class Finger:
    """A finger on a page."""

    def __init__(self, page: Any, node: Any) -> None:
        """Lay it on an element."""
        self.at = middle_of(node)
        self.session = page.context.new_cdp_session(page)
        self._send("touchStart", self.at)

    def _send(self, kind: str, *places: tuple[float, float]) -> None:
        points = [{"x": x, "y": y} for x, y in places]
        self.session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    def move(self, dx: float, steps: int) -> None:
        """Move it to the right."""
        for k in range(1, steps + 1):
            self._send("touchMove", (self.at[0] + dx * k / steps, self.at[1]))

    def lift(self) -> None:
        """Take it away."""
        self._send("touchEnd")
        self.session.detach()


def touch(page: Any, handle: Any, dx: float) -> None:
    """Drag ``handle`` to the right by ``dx`` [px] with a finger."""
    finger = Finger(page, handle)
    finger.move(dx, 5)
    page.wait_for_timeout(100)  # [ms] it rests: what it moved does not fly on
    finger.lift()
