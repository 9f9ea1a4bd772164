"""Named snapshots beside a design's file: kept whole or not at all, each alone, and opened as one edit."""

import os
import subprocess
import sys
from itertools import pairwise
from typing import Any

import pytest

import fuzzy
from fuzzy.plugins.designer import snapshots
from fuzzy.plugins.designer.design import design_of
from fuzzy.plugins.designer.document import Document
from fuzzy.plugins.designer.folder import FolderError
from fuzzy.plugins.designer.saving import DocumentError
from fuzzy.plugins.designer.views import surface_data
from tests.fuzzy.plugins.designer.design_messages import near, system, unsaved


def pictured(design):
    surface = surface_data(design, points=snapshots.PICTURE)
    return snapshots.surface_picture(surface, ("distance", "bearing"), "v")


def test_a_snapshot_comes_back_as_one_edit_with_rules_that_are_off_or_misspelt(file):
    document = Document(file)
    first, second, _ = (line.key for line in document.design.lines)
    document.apply(near(0.25))
    document.apply({"edit": "rule_enabled", "key": first, "enabled": False})
    document.apply({"edit": "rule_text", "key": second, "text": "if distance is nar then v is slow"})
    picture = pictured(document.design)
    key = snapshots.keep(file, document.design, " a  wider\tone ", picture)
    (shown,), problems = snapshots.listed(file)
    assert problems == ()
    assert (shown.key, shown.name, shown.summary) == (key, "a wider one", "2 inputs, 2 outputs, 3 rules")
    assert shown.picture == picture
    assert picture["shows"] == "v over distance and bearing"
    assert (len(picture["z"]), len(picture["z"][0])) == (snapshots.PICTURE,) * 2
    kept = document.design
    document.apply({"edit": "remove_variable", "kind": "input", "variable": "bearing"})
    document.apply({"look": "point", "point": [0.5]})
    before, edits = document.text(), len(document.history)
    name, design = snapshots.read(file, key)
    assert (name, design.lines, design.in_force) == ("a wider one", kept.lines, kept.in_force)
    document.take(design, f"open the snapshot {name}")
    assert document.design.in_force == kept.in_force
    assert [line.text for line in document.design.lines] == [line.text for line in kept.lines]
    assert document.design.point == (0.5, 0.0)  # one keeps looking at the same point
    assert len(document.history) == edits + 1
    keys = [line.key for line in document.design.lines]
    assert min(keys) > max(line.key for line in kept.lines)  # a key is never given twice
    document.undo()
    assert document.text() == before
    document.redo()
    assert document.design.in_force == kept.in_force


def test_names_removal_and_what_is_refused(file):
    design = design_of(system())
    keys = [snapshots.keep(file, design, name) for name in ("one", "two")]
    snapshots.rename(file, keys[0], "first")
    assert {s.name for s in snapshots.listed(file).snapshots} == {"first", "two"}
    before = snapshots.listed(file)
    for key, name in ((keys[0], "first"), (keys[1], "two")):  # the one before is then gone for good
        snapshots.remove(file, key)
        with pytest.raises(DocumentError, match="no such snapshot"):
            snapshots.read(file, key)
        snapshots.bring_back(file, key)
        assert snapshots.read(file, key) == (name, design)
    assert snapshots.listed(file) == before
    snapshots.remove(file, keys[0])
    snapshots.remove(file, keys[1])
    with pytest.raises(DocumentError, match="no such snapshot"):
        snapshots.bring_back(file, keys[0])
    wrong: Any
    for wrong in ("", " \n", 7, None, "x" * 81, "a\u202eb"):
        with pytest.raises(DocumentError, match="name"):
            snapshots.keep(file, design, wrong)
        with pytest.raises(DocumentError, match="name"):
            snapshots.rename(file, keys[0], wrong)
    for odd in ("../x", "", None, 3, "0" * 15, f"{'0' * 15}/"):
        with pytest.raises(DocumentError, match="by its key"):
            snapshots.read(file, odd)
    assert snapshots.listed(file) == ((), ())


def test_at_most_a_hundred_are_kept(file, monkeypatch):
    monkeypatch.setattr(snapshots, "MOST_SNAPSHOTS", 3)
    design = design_of(system())
    for k in range(3):
        snapshots.keep(file, design, str(k))
    with pytest.raises(DocumentError, match="has 3 snapshots, the most that are kept; remove one first"):
        snapshots.keep(file, design, "one more")
    kept = snapshots.listed(file).snapshots
    assert [s.name for s in kept] == ["2", "1", "0"]
    assert all(a.when >= b.when for a, b in pairwise(kept))


DAMAGE = ["", "{", "[]", "null", '{"format": 2}', '{"format": 1, "name": "x", "when": "yesterday"}']


def test_a_damaged_file_costs_one_snapshot_and_is_named(file):
    key = snapshots.keep(file, design_of(system()), "good", pictured(design_of(system())))
    folder = snapshots.place_for(file)
    whole = (folder / f"{key}.json").read_text()
    damage = [*DAMAGE, whole.replace('"z": [', '"z": [["<b>"], '), whole[:-100], whole.replace("Type=", "Typ=")]
    for k, text in enumerate(damage):
        (folder / f"{k:016x}.json").write_text(text)
    (folder / "notes.json").write_text(whole)
    document, listing = Document(file), snapshots.listed(file)
    # The system itself is read when it is opened, so that the last one is found then; and notes.json is none.
    assert [s.key for s in listing.snapshots if s.key == key] == [key]
    assert len(listing.problems) == len(damage[:-1]) + 1
    assert all("is damaged and is no snapshot; nothing else is lost" in sentence for sentence in listing.problems)
    assert ".fuzzy-design/demo.fis.snapshots/0000000000000000.json" in listing.problems[0]
    with pytest.raises(DocumentError, match="is damaged"):
        snapshots.read(file, f"{len(damage) - 1:016x}")
    # Neither the design nor unsaved work suffers.
    document.apply(near(0.5))
    document.autosave()
    assert unsaved(file).exists()
    assert Document(file).restored is not None
    assert snapshots.read(file, key)[0] == "good"


def test_links_lead_nowhere_and_large_systems_are_refused(file, tmp_path):
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    folder = snapshots.place_for(file)
    folder.parent.mkdir()
    folder.symlink_to(elsewhere)
    for act in (lambda: snapshots.keep(file, design_of(system()), "x"), lambda: snapshots.listed(file)):
        with pytest.raises(DocumentError, match="leads elsewhere by a link"):
            act()
    folder.unlink()
    key = snapshots.keep(file, design_of(system()), "x")
    link = folder / f"{1:016x}.json"
    link.symlink_to(folder / f"{key}.json")
    assert len(snapshots.listed(file).snapshots) == 1
    rules = ["if distance is near then v is slow"] * 2001
    many = fuzzy.Sugeno(system().inputs, system().outputs, rules, name="many")
    with pytest.raises(FolderError, match="2001 rules; the designer shows at most 2000"):
        snapshots.read(file, snapshots.keep(file, design_of(many), "many"))
    assert not list(elsewhere.iterdir())


KEEP = """
import sys
from pathlib import Path
from fuzzy.plugins.designer import snapshots
from fuzzy.plugins.designer.document import Document
file = Path(sys.argv[1])
design = Document(file).design
for k in range(100):
    print(snapshots.keep(file, design, f"number {k}"), flush=True)
"""


@pytest.mark.skipif(os.name != "posix", reason="kill -9 is POSIX's")
def test_a_killed_process_leaves_whole_snapshots(file):
    process = subprocess.Popen(
        [sys.executable, "-W", "ignore", "-c", KEEP, str(file)], stdout=subprocess.PIPE, text=True
    )
    told = {process.stdout.readline().strip() for _ in range(5)}
    process.kill()
    told |= {line.strip() for line in process.stdout if len(line) == 17}
    process.wait()
    process.stdout.close()
    folder = next((file.parent / ".fuzzy-design").glob("*.snapshots"))
    (folder / ".0123456789abcdef-01234567.json").write_text('{"name": "half')  # as a process that dies leaves it
    listing = snapshots.listed(file)
    assert listing.problems == ()
    assert told <= {s.key for s in listing.snapshots}
    assert all(snapshots.read(file, s.key)[1] == Document(file).design for s in listing.snapshots[:3])
