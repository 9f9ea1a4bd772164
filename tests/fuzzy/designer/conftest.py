"""A browser for each file of tests, whose pages are its tabs; a design's file for the tests that edit one."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import fuzzy
from tests.browsers import started
from tests.fuzzy.designer.design_messages import system


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """Headless Chromium, until the file's last test."""
    with started() as window:
        yield window


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """A design's file in a folder of its own."""
    folder = tmp_path / "designs"
    folder.mkdir()
    fuzzy.write_fis(system(), folder / "demo.fis")
    return folder / "demo.fis"
