"""Entry points are looked up once, and again when something is installed."""

from importlib import metadata

import pytest

from fuzzy.entrypoints import entry_points
from tests.conftest import declare

GROUP = "fuzzyfleet.rulebases"


def test_what_is_installed_meanwhile_is_found(tmp_path, monkeypatch):
    before = set(entry_points(GROUP).names)
    assert before == set(metadata.entry_points(group=GROUP).names) != set()
    monkeypatch.syspath_prepend(tmp_path)
    declare(tmp_path, "boats", {GROUP: {"boats": "boats"}})
    assert set(entry_points(GROUP).names) == before | {"boats"}
    assert [point.value for point in entry_points(GROUP, "boats")] == ["boats"]
    declare(tmp_path, "trains", {GROUP: {"trains": "trains"}})
    assert set(entry_points(GROUP).names) == before | {"boats", "trains"}


def test_the_descriptions_of_packages_are_not_opened_again(monkeypatch):
    found = entry_points(GROUP)
    monkeypatch.setattr(metadata, "entry_points", lambda **_: pytest.fail("opened again"))
    assert entry_points(GROUP) is found
