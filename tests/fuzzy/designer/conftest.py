"""A browser for each file of tests, whose pages are its tabs; a design's file for the tests that edit one."""

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import fuzzy
from tests.fuzzy.designer.design_messages import system

FLAGS = (
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """Headless Chromium, driven by playwright, whose event loop runs until the file's last test."""
    chromium = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if chromium is None:
        pytest.skip("the browser tests need Chromium, and none is installed")
    playwright = pytest.importorskip("playwright.sync_api", reason="the browser tests need playwright (extra test)")
    with playwright.sync_playwright() as driver:
        window = driver.chromium.launch(executable_path=chromium, args=list(FLAGS))
        yield window
        window.close()


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """A design's file in a folder of its own."""
    folder = tmp_path / "designs"
    folder.mkdir()
    fuzzy.write_fis(system(), folder / "demo.fis")
    return folder / "demo.fis"
