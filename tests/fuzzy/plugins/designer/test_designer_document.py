"""A document: history, saving, unsaved work that outlives a crash, and the folder that it does not leave."""

import contextlib
import json
import os
import subprocess
import sys
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import fuzzy
from fuzzy.files.fisfile import write_quietly
from fuzzy.plugins.designer.design import file_text
from fuzzy.plugins.designer.document import DEPTH, Document
from fuzzy.plugins.designer.saving import DocumentError
from fuzzy.plugins.designer.views import document_data
from tests.fuzzy.plugins.designer.design_messages import messages, near, peak, system, unsaved

# History ------------------------------------------------------------------------------------------------------


def test_undo_restores_the_bytes_a_hundred_deep(file):
    document = Document(file)
    texts = [document.text()]
    for k in range(1, DEPTH + 11):
        document.apply(near(k / 200))
        texts.append(document.text())
    assert len(set(texts)) == len(texts)
    for k in range(1, DEPTH + 1):
        assert document.can_undo == "move near"
        document.apply({"do": "undo"})
        assert document.text() == texts[-1 - k]
    assert document.can_undo is None
    document.undo()
    assert document.text() == texts[10]
    for k in range(11, DEPTH + 11):
        document.redo()
        assert document.text() == texts[k]
    assert document.can_redo is None


def test_a_gesture_is_one_edit(file):
    document = Document(file)
    for k in range(1, 20):
        document.apply(near(k / 20, gesture="drag-1"))
    document.apply(near(0.1, gesture="drag-2"))
    document.undo()
    assert peak(document) == 0.95
    document.undo()
    assert peak(document) == 0
    assert document.can_undo is None
    # A gesture that is refused in between goes on, one that comes back is none, and undoing ends it.
    document.apply(near(0.5, gesture=3))
    with pytest.raises(fuzzy.InputError):
        document.apply(near(1.5, gesture=3))
    document.apply(near(0.75, gesture=3))
    document.apply(near(0, gesture=3))
    assert (document.can_undo, document.can_redo) == (None, None)
    document.apply(near(0.5, gesture=4))
    document.undo()
    document.apply(near(0.25, gesture=4))
    document.apply(near(0.25))
    document.apply(near(0.75))
    document.undo()
    assert peak(document) == 0.25


def test_looking_is_no_edit(file):
    document = Document(file)
    document.apply({"look": "point", "point": [0.25, 1]})
    assert document.can_undo is None
    document.apply(near(0.5))
    document.apply({"look": "point", "point": [0.5, 2]})
    document.undo()
    assert document.design.point == (0.5, 2)
    assert document.saved


def test_a_whole_system_is_one_edit(file):
    document = Document(file)
    keys = {line.key for line in document.design.lines}
    other = fuzzy.Sugeno(
        [fuzzy.Variable("x", (0, 1), {"on": fuzzy.linsmf(0, 1)})], [fuzzy.Variable("z", (0, 1), {"full": 1.0})],
        ["if x is on then z is full"],
    )  # fmt: skip
    document.replace(other, "train for 20 epochs")
    assert document.design.system == other
    assert not keys & {line.key for line in document.design.lines}
    assert document_data(document)["undo"] == "train for 20 epochs"
    document.undo()
    assert document.text() == fuzzy.format_fis(system())
    with pytest.raises(fuzzy.FisFileError, match="line end"):
        document.replace(fuzzy.Sugeno(other.inputs, other.outputs, name="two\nlines"), "upload")
    assert document.design.system == system()


def test_all_who_look_are_told(file):
    document, told = Document(file), []
    unlisten = document.listen(lambda: told.append(document.revision))
    document.apply(near(0.5))
    document.apply({"look": "point", "point": [0.25, 1]})
    document.undo()
    document.compare(system())
    with pytest.raises(fuzzy.InputError):
        document.apply({"do": "everything"})
    assert told == [1, 2, 3, 4]
    unlisten()
    unlisten()
    document.redo()
    assert told == [1, 2, 3, 4]


@given(st.lists(st.tuples(messages(), st.none() | st.integers(0, 1)), max_size=12))
@settings(max_examples=25, suppress_health_check=list(HealthCheck))
def test_undoing_everything_gives_the_first_bytes(tmp_path_factory, sequence):
    path = tmp_path_factory.getbasetemp() / "random.fis"
    if not path.exists():
        write_quietly(system(), path)
    document = Document(path)
    for message, gesture in sequence:
        try:
            document.apply({**message, "gesture": gesture})
        except fuzzy.InputError:
            continue
    last = document.text()
    while document.can_undo:
        document.undo()
    assert document.text() == path.read_text()
    assert document.saved
    while document.can_redo:
        document.redo()
    assert document.text() == last


def made(path, sequence):
    """A document at ``path`` to which messages, each with a gesture, were applied; those it refuses are left out."""
    document = Document(path)
    for message, gesture in sequence:
        with contextlib.suppress(fuzzy.InputError):
            document.apply({**message, "gesture": gesture})
    return document


@given(
    st.lists(st.tuples(messages(), st.none() | st.integers(0, 1)), max_size=12),
    st.lists(st.floats(0, 1), min_size=1, max_size=4),
)
@settings(max_examples=25, suppress_health_check=list(HealthCheck))
def test_going_to_an_edit_is_as_many_undos_or_redos(tmp_path_factory, sequence, ways):
    path = tmp_path_factory.getbasetemp() / "random.fis"
    if not path.exists():
        write_quietly(system(), path)
    jumps, steps = made(path, sequence), made(path, sequence)
    count = len(jumps.history)
    told = []
    jumps.listen(lambda: told.append(jumps.revision))
    for way in ways:
        to = round(way * count)
        jumps.apply({"do": "go", "to": jumps.history[to - 1].number if to else None})
        now = sum(edit.done for edit in steps.history)
        for _ in range(abs(to - now)):
            steps.undo() if to < now else steps.redo()
        assert jumps.design == steps.design
        assert jumps.text() == steps.text()
        for documents in ([edit.name for edit in d.history] for d in (jumps, steps)):
            assert len(documents) == count  # nothing is lost
        assert [edit.done for edit in jumps.history] == [n < to for n in range(count)]
    assert len(told) == len(ways)


def test_the_history_says_what_was_done_and_when(file):
    before, document = datetime.now(UTC), Document(file)
    assert not document.history
    for k in range(3):
        document.apply(near(0.1 + k / 10, gesture="one drag"))
    document.apply({"edit": "rename", "name": "other"})
    first, second = document.history
    assert (first.name, second.name) == ("move near", "rename to other")
    assert before <= first.when <= second.when <= datetime.now(UTC)
    document.go(first.number)
    assert [edit.done for edit in document.history] == [True, False]
    assert document.history[1].when == second.when
    document.apply(near(0.75))  # which loses what was taken back
    assert [edit.name for edit in document.history] == ["move near", "move near"]
    for gone in (second.number, 17, True, "1", 1.0):
        with pytest.raises(DocumentError, match="no longer in the history"):
            document.go(gone)
    assert not document.forgotten
    for k in range(DEPTH):
        document.apply(near(k / 200))
    assert document.forgotten
    assert len(document.history) == DEPTH
    assert len({edit.number for edit in document.history}) == DEPTH


# Files --------------------------------------------------------------------------------------------------------


def test_saving_writes_what_is_shown(file):
    document = Document("demo.fis", file.parent)
    assert document.saved
    document.apply(near(0.5))
    assert not document.saved
    document.save()
    assert document.saved
    assert file.read_text() == document.text() == file_text(document.design)
    document.save()  # its own file has not changed behind its back
    document.undo()
    assert not document.saved
    document.save("copy.fis")
    assert document.path == file.parent / "copy.fis"
    assert document.saved
    assert fuzzy.read_fis(file.parent / "copy.fis") == system()
    with pytest.raises(DocumentError, match="exists already"):
        document.save("demo.fis")
    document.save("demo.fis", overwrite=True)
    assert fuzzy.read_fis(file) == system()


def test_a_file_that_changed_on_disk_is_not_overwritten(file):
    document = Document(file)
    document.apply(near(0.5))
    other = fuzzy.format_fis(system(name="by hand"))
    file.write_text(other)
    with pytest.raises(DocumentError, match="was changed on disk"):
        document.save()
    assert file.read_text() == other
    assert not document.saved
    document.save(overwrite=True)
    assert file.read_text() == document.text()
    document.apply(near(0.75))
    file.write_text("no system")
    with pytest.raises(fuzzy.FisFileError):
        document.discard()
    with pytest.raises(DocumentError, match="was changed on disk"):  # looking in vain is no leave to overwrite
        document.save()
    file.unlink()
    with pytest.raises(DocumentError, match="no longer exists"):
        document.discard()
    assert peak(document) == 0.75
    document.save()  # what is gone cannot be overwritten
    assert file.exists()


SAVE = """
import sys
from fuzzy.plugins.designer.document import Document
from fuzzy.plugins.designer.saving import DocumentError
document = Document(sys.argv[1])
print("open", flush=True)
for line in sys.stdin:
    command, value = line.split()
    try:
        if command == "move":
            document.apply({"edit": "term", "variable": "distance", "term": "near", "parameters": [0, float(value), 1]})
            document.autosave()
        elif command == "save":
            document.save()
        elif command == "drag":  # on and on
            for k in range(100_000):
                document.apply({"edit": "term", "variable": "distance", "term": "near", "parameters": [0, k / 1e5, 1]})
                document.autosave()
                print(k, flush=True)
        print("done", document.path.name, document.restored is not None, flush=True)
    except DocumentError as error:
        print("refused", error, flush=True)
"""


class Other:
    """A designer in a process of its own."""

    def __init__(self, file: Path) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-W", "ignore", "-c", SAVE, str(file)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        assert self.process.stdout.readline() == "open\n"

    def __call__(self, command: str) -> str:
        self.process.stdin.write(command + "\n")
        self.process.stdin.flush()
        return self.process.stdout.readline()

    def kill(self) -> None:
        self.process.kill()
        self.process.wait()
        self.process.stdin.close()
        self.process.stdout.close()


def test_two_processes_lose_nothing_of_each_other(file):
    """Both edit and autosave, one saves, the other is refused and killed: its work is taken up again."""
    other, here = Other(file), Document(file)
    try:
        assert other("move 0.25").startswith("done")
        here.apply(near(0.75))
        here.autosave()
        assert len(list((file.parent / ".fuzzy-design").iterdir())) == 2
        beside = Document(file)  # opened while the other works: told, but the other's work stays the other's
        assert peak(beside) == 0.75
        assert any("another designer has demo.fis open, with unsaved work" in note for note in beside.notes)
        here.save()
        assert other("save now").startswith("refused demo.fis was changed on disk")
        assert other("move 0.5").startswith("done")
    finally:
        other.kill()
    back = Document(file)
    assert (peak(back), back.restored is not None, back.saved) == (0.5, True, False)
    with pytest.raises(DocumentError, match="was changed on disk"):  # what it goes on from is not there any more
        back.save()
    back.undo()
    assert peak(back) == 0.75


def test_a_killed_process_loses_nothing(file):
    for k in range(2):  # killed after an edit; the second goes on where the first was killed
        other = Other(file)
        try:
            assert other(f"move {(k + 1) / 4}") == f"done demo.fis {k > 0}\n"
            if k == 1:  # and this one in the middle of a drag, whatever it is just doing
                other("drag now")
                told = [int(other.process.stdout.readline()) for _ in range(20)]
        finally:
            other.kill()
    assert fuzzy.read_fis(file) == system()
    document = Document(file)
    assert document.restored is not None
    assert told[-1] / 1e5 <= peak(document) < 0.25
    assert document.can_undo.startswith("take up unsaved work of 2")
    document.save()
    assert not unsaved(file).exists()
    assert Document(file).restored is None


# Unsaved work -------------------------------------------------------------------------------------------------


def test_unsaved_work_is_the_whole_design(file):
    document = Document(file)
    document.apply(near(0.5))
    document.apply({"edit": "rule_weight", "key": 1, "weight": 0.25})
    document.apply({"edit": "rule_enabled", "key": 1, "enabled": False})
    document.apply({"edit": "move_rule", "key": 2, "to": 0})
    document.apply({"edit": "rule_text", "key": 0, "text": "if distance is naer"})
    document.apply({"look": "point", "point": [0.25, 1]})
    before = datetime.now(UTC)
    document.autosave()
    back = Document(file)
    assert back.design == document.design
    assert before <= back.restored <= datetime.now(UTC)
    back.undo()
    assert back.text() == file.read_text()
    back.redo()
    back.discard()
    assert (back.saved, back.restored) == (True, None)
    assert not unsaved(file).exists()
    back.undo()
    assert back.text() == document.text()


def test_a_misspelt_sentence_alone_is_kept_too(file):
    document = Document(file)
    document.apply({"edit": "rule_text", "key": 0, "text": "if"})
    document.autosave()
    assert Document(file).design.lines[0].text == "if"
    document.undo()
    document.autosave()
    assert not unsaved(file).exists()


def test_unsaved_work_of_a_new_file(tmp_path):
    document = Document("new.fis", tmp_path)
    assert (document.saved, document.design.system.name, len(document.design.lines)) == (False, "new", 3)
    assert document.design.in_force([0.0]).tolist() == [0.0]
    document.apply({"edit": "rename", "name": "mine"})
    document.autosave()
    back = Document("new.fis", tmp_path)
    assert back.design.system.name == "mine"
    back.save()
    assert fuzzy.read_fis(tmp_path / "new.fis").name == "mine"


def test_a_new_system_is_called_as_the_file_that_it_is_saved_in(tmp_path):
    document = Document("untitled.fis", tmp_path)
    document.save("tipper.fis")
    assert (document.saved, fuzzy.read_fis(tmp_path / "tipper.fis").name) == (True, "tipper")
    document.save("another.fis")  # it has a file by now: a copy of it keeps the name
    assert fuzzy.read_fis(tmp_path / "another.fis").name == "tipper"


def crashed(file, value, name, hours):
    """Work on ``file`` that a crash left unsaved, and another program that wrote the file after it."""
    document = Document(file)
    document.apply(near(value))
    document.autosave()
    file.write_text(fuzzy.format_fis(system(name=name)))
    later = (datetime.now(UTC) + timedelta(hours=hours)).timestamp()
    os.utime(file, (later, later))
    return document.design


def test_work_older_than_the_file_waits_for_a_choice_and_a_second_crash_takes_nothing(file):
    first = crashed(file, 0.5, "newer", 1)
    back = Document(file)
    assert (back.design.system.name, back.restored) == ("newer", None)
    assert [work.design.system for work in back.aside] == [first.system]
    second = crashed(file, 0.6, "newest", 2)
    back = Document(file)
    assert {work.design.system for work in back.aside} == {first.system, second.system}
    newest = back.aside[0].design.system
    back.choose("work")
    assert back.design.system == newest
    assert back.can_undo.startswith("take up unsaved work of")
    again = Document(file)  # killed again: the work that was taken is the unsaved one, the other still waits
    assert again.design.system == newest
    assert len(again.aside) == 1
    again.choose("file")
    assert again.design.system == newest
    assert Document(file).aside == ()
    with pytest.raises(DocumentError, match="no unsaved work to choose"):
        again.choose("file")
    with pytest.raises(DocumentError, match="did you mean 'work'"):
        again.choose("wrk")


@pytest.mark.parametrize(
    "damage",
    [
        lambda content: content[: len(content) // 2],
        lambda content: "",
        lambda content: "[" * 100_000,
        lambda content: json.dumps({**json.loads(content), "when": "9999-12-31T23:59:59-23:00"}),
        lambda content: json.dumps({**json.loads(content), "point": [float("nan"), 0]}),
        lambda content: json.dumps({**json.loads(content), "rules": [{"key": 1}]}),
        lambda content: json.dumps({**json.loads(content), "file": "other.fis"}),
        lambda content: json.dumps({**json.loads(content), "system": "[System]"}),
    ],
)
def test_damaged_unsaved_work_is_no_hindrance(file, damage):
    document = Document(file)
    document.apply(near(0.5))
    document.autosave()
    unsaved(file).write_text(damage(unsaved(file).read_text()))
    back = Document(file)
    assert (back.text(), back.restored) == (file.read_text(), None)
    back.apply(near(0.25))
    back.autosave()
    assert peak(Document(file)) == 0.25
