"""Headless Chromium for tests, driven by playwright; tests are skipped where there is none."""

import shutil
from collections.abc import Iterator
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
