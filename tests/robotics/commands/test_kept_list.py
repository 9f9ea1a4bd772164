"""`robotics list` keeps what it told, and tells it anew as soon as it may have changed."""

import os
import sys
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from fuzzy.errors import InputError
from robotics.commands import keptlist
from robotics.commands import list as listing
from robotics.commands.application import main
from robotics.commands.keptlist import CACHE_FOLDER, kept_or_made


@pytest.fixture
def package(tmp_path, monkeypatch):
    """Folders of a package with one file, of installations, and of the cache."""
    (tmp_path / "robotics" / "data").mkdir(parents=True)
    (tmp_path / "robotics" / "data" / "presets.toml").write_text("a = 1\n", encoding="utf-8")
    (tmp_path / "site").mkdir()
    monkeypatch.setattr(keptlist, "_PACKAGES", tmp_path)
    monkeypatch.setattr(sys, "path", ["", str(tmp_path / "site")])
    monkeypatch.setattr(keptlist, "entry_points", lambda group: [])
    monkeypatch.setenv(CACHE_FOLDER, str(tmp_path / "cache" / "deep"))
    return tmp_path


class Maker:
    """Makes a text that tells how often one was made."""

    def __init__(self, lasting: bool = True) -> None:
        self.made, self.lasting = 0, lasting

    def __call__(self) -> tuple[str, bool]:
        self.made += 1
        return f"made {self.made}\n\n2. line\n", self.lasting


def test_a_text_is_made_once_until_a_file_or_what_is_installed_changes(package):
    make = Maker()
    for _ in range(3):
        assert kept_or_made("list.txt", make) == "made 1\n\n2. line\n"
    assert kept_or_made("list.json", make).startswith("made 2")
    (package / "robotics" / "data" / "presets.toml").write_text("a = 10\n", encoding="utf-8")
    assert kept_or_made("list.txt", make).startswith("made 3")
    (package / "robotics" / "law.py").touch()
    assert kept_or_made("list.txt", make).startswith("made 4")
    os.utime(package / "site", (1, 1))
    assert kept_or_made("list.txt", make).startswith("made 5")
    assert kept_or_made("list.txt", make).startswith("made 5")


def test_nothing_is_kept_beside_plug_ins_of_others_or_where_it_cannot_be(package, monkeypatch):
    make = Maker()
    theirs = EntryPoint(name="mine", value="elsewhere:Law", group="fuzzyfleet.laws")
    monkeypatch.setattr(keptlist, "entry_points", lambda group: [theirs] if group == theirs.group else [])
    assert [kept_or_made("list.txt", make)[:6] for _ in range(2)] == ["made 1", "made 2"]
    monkeypatch.setattr(keptlist, "entry_points", lambda group: [])
    monkeypatch.setenv(CACHE_FOLDER, "")
    assert [kept_or_made("list.txt", make)[:6] for _ in range(2)] == ["made 3", "made 4"]
    (package / "file").touch()
    monkeypatch.setenv(CACHE_FOLDER, str(package / "file" / "folder"))
    assert [kept_or_made("list.txt", make)[:6] for _ in range(2)] == ["made 5", "made 6"]
    monkeypatch.setenv(CACHE_FOLDER, str(package / "cache"))
    unsure = Maker(lasting=False)
    assert [kept_or_made("list.txt", unsure)[:6] for _ in range(2)] == ["made 1", "made 2"]


def test_the_whole_list_is_kept_as_it_is_printed(tmp_path, monkeypatch, capsys):
    assert main(["list"]) == 0
    whole = capsys.readouterr().out
    monkeypatch.setenv(CACHE_FOLDER, str(tmp_path))
    assert main(["list"]) == 0
    assert Path(tmp_path, "list.txt").is_file()

    def fails() -> list[dict[str, object]]:
        raise InputError("it was found anew")

    for section, kind in listing._LISTINGS.items():
        monkeypatch.setitem(listing._LISTINGS, section, kind._replace(rows=fails))
    capsys.readouterr()
    assert main(["list"]) == 0
    assert capsys.readouterr().out == whole
    assert main(["list", "metrics"]) == 2
