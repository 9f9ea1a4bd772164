"""A browser for each file of tests, whose pages are its tabs; a server for all files; a design's file."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import fuzzy
from fuzzy.files.fisfile import write_quietly
from tests.browsers import started
from tests.fuzzy.plugins.designer.design_messages import system
from tests.fuzzy.plugins.designer.served import Server, tipper


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """Headless Chromium, until the file's last test."""
    with started() as window:
        yield window


@pytest.fixture(scope="package")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """The designer in a process of its own; its folder holds tipper.fis, and what tests write there."""
    folder = tmp_path_factory.mktemp("served")
    fuzzy.write_fis(tipper(), folder / "tipper.fis")
    server = Server(folder)
    yield server
    assert server.end() == (0, "")  # Ctrl-C ends it cleanly, and no handler failed meanwhile


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """A design's file in a folder of its own."""
    folder = tmp_path / "designs"
    folder.mkdir()
    write_quietly(system(), folder / "demo.fis")
    return folder / "demo.fis"
