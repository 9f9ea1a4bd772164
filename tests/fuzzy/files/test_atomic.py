"""Files written whole or not at all: full disks, and what killed processes leave behind."""

import errno
import os
import subprocess
import sys

import pytest

from fuzzy.files import atomic
from fuzzy.files.atomic import TargetError, check_folder, check_target, replacing

KILLED = """
import os, sys
from fuzzy.files.atomic import replacing
with replacing(sys.argv[1]) as part:
    part.write_text("half")
    os.kill(os.getpid(), 9)
"""


def full():
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def test_a_full_disk_is_said_of_the_file_that_was_to_be_written(tmp_path):
    (tmp_path / "a.csv").write_text("old")
    with pytest.raises(OSError, match="No space left") as caught, replacing(tmp_path / "a.csv"):
        full()
    assert caught.value.filename == str(tmp_path / "a.csv")
    with pytest.raises(FileNotFoundError) as other, replacing(tmp_path / "a.csv"):
        (tmp_path / "other").read_text()
    assert other.value.filename == str(tmp_path / "other")  # an error about another file stays as it is
    assert [(f.name, f.read_text()) for f in tmp_path.iterdir()] == [("a.csv", "old")]


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="a device that is always full")  # noqa: PTH110
def test_a_full_device_is_named_too():
    with pytest.raises(OSError, match="No space left") as caught, replacing("/dev/full") as part:
        part.write_text("much")
    assert caught.value.filename == "/dev/full"


@pytest.mark.skipif(sys.platform == "win32", reason="files that are locked")
def test_what_a_killed_process_left_is_cleared_up_by_the_next_writer(tmp_path, monkeypatch):
    target = tmp_path / "a.ck"
    assert subprocess.run([sys.executable, "-c", KILLED, str(target)], check=False, timeout=60).returncode == -9
    assert len(list(tmp_path.iterdir())) == 1
    for other in (".a-1234567.ck", ".b-01234567.ck", ".a-01234567.fis"):
        (tmp_path / other).write_text("of somebody else")
    monkeypatch.setattr(atomic, "_YOUNG", -1.0)
    with replacing(target) as mine:
        mine.write_text("whole")
        atomic._swept.clear()
        with replacing(target) as second:  # somebody else writes the same: what the first is writing stays
            second.write_text("second")
        assert mine.exists()
    assert target.read_text() == "whole"
    assert {f.name for f in tmp_path.iterdir()} == {"a.ck", ".a-1234567.ck", ".b-01234567.ck", ".a-01234567.fis"}


def test_a_target_is_judged_before_the_work(tmp_path):
    check_target(tmp_path / "a.csv", ".csv")
    check_folder(tmp_path / "new" / "newer")
    with pytest.raises(TargetError, match=r"a\.txt: the file's name must end in \.csv"):
        check_target(tmp_path / "a.txt", ".csv")
    with pytest.raises(TargetError, match=r"there is no folder '.*none' to write into"):
        check_target(tmp_path / "none" / "a.csv")
    with pytest.raises(TargetError, match="is a directory"):
        check_target(tmp_path)
    (tmp_path / "file").write_text("")
    with pytest.raises(TargetError, match="is a file, not a folder"):
        check_folder(tmp_path / "file" / "below")
