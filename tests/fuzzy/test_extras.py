"""What a message says to install: it works from a checkout and from a wheel, and names no place on the machine."""

import importlib.metadata
import re
from pathlib import Path

import pytest

import fuzzy.extras
from fuzzy.extras import install_command

ROOT = Path(__file__).parents[2]


def test_the_packages_of_an_extra_are_named(monkeypatch):
    lines = ["numpy>=2.0", "nicegui>=3.18; extra == 'design'", 'a>=1; extra == "two"', "b[c]; extra == 'two'"]
    monkeypatch.setattr(fuzzy.extras, "requires", lambda name: lines)
    assert install_command("design") == "pip install 'nicegui>=3.18'"
    assert install_command("two") == "pip install 'a>=1' 'b[c]'"
    with pytest.raises(KeyError):
        install_command("sign")


def test_sources_that_are_not_installed_are_installed_first(monkeypatch):
    def missing(name):
        raise importlib.metadata.PackageNotFoundError(name)

    monkeypatch.setattr(fuzzy.extras, "requires", missing)
    assert install_command("design") == "pip install '.[design]' in the folder of fuzzyfleet"


def test_no_page_and_no_message_asks_for_what_no_index_has():
    texts = [*(f for p in ("fuzzy", "anfis", "robotics") for f in (ROOT / p).rglob("*.py")), *ROOT.glob("docs/*.md")]
    assert len(texts) > 300
    asked = [file.name for file in texts if re.search(r"fuzzyfleet\[", file.read_text(encoding="utf-8"))]
    assert asked == []
