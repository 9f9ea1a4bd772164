"""Comparisons and studies that are killed, and go on where they were: with the same bytes in the end."""

import contextlib
import shutil
import subprocess
import sys
import time
from typing import Any

import numpy as np
import psutil
import pytest

from robotics.commands.application import main
from tests.robotics.commands.test_sweep_command import SCENARIO
from tests.robotics.commands.warmstart import PATIENCE, Warm, landed, wait_for_the_end_of, wait_until

STUDY = """
scenarios = ["short.toml", "other.toml"]
controllers = ["lyapunov", "csm", "esm"]
seeds = 40
questions = ["leads", "axes"]

[conditions]
calm = {}
noisy = { sensing.position_noise = 0.01 }

[[axes]]
key = "latency"
values = [0.0, 0.05]

[[claims]]
name = "One"
metric = "rms_cross_track_m"
of = "lyapunov"
against = ["csm", "esm"]
less = true
"""
TABLES = (
    "results.csv",
    "columns.csv",
    "summary.csv",
    "claims.csv",
    "evidence.csv",
    "answers.json",
    "configuration.json",
)
# Of a comparison 2 scenarios × 3 laws × 130 seeds; of the study 2 scenarios × 2 conditions × 6 passes, by 2
CHUNKS = 12


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A folder with a study, and its results from a run that nothing disturbs."""
    folder = tmp_path_factory.mktemp("study")
    (folder / "short.toml").write_text(SCENARIO, encoding="utf-8")
    (folder / "other.toml").write_text(SCENARIO.replace("speed = 0.3", "speed = 0.2"), encoding="utf-8")
    (folder / "study.toml").write_text(STUDY, encoding="utf-8")
    for name in ("study", "compare"):
        assert main(command(name, folder, folder / name)) == 0
    return folder


@pytest.fixture(scope="module")
def warm(place):
    parent = Warm(place, place / "short.toml")
    with parent.process:
        yield parent
        parent.process.stdin.close()


def command(name, place, out, *options):
    if name == "study":
        return ["study", str(place / "study.toml"), "--out", str(out), "--no-report", "-q", *options]
    files = [str(place / "short.toml"), str(place / "other.toml"), "--controllers", "lyapunov,csm,esm"]
    return ["compare", *files, "--seeds", "130", "--out", str(out), "--no-report", "-q", *options]


def whole(out):
    return {name: (out / name).read_bytes() for name in TABLES if (out / name).exists()}


def check_end(place, name, out):
    assert whole(out) == whole(place / name)
    assert len(whole(out)) == (7 if name == "study" else 4)
    assert not (out / "pieces").exists()


@pytest.mark.parametrize(("name", "kills"), [("compare", 2), pytest.param("study", 4, marks=pytest.mark.long)])
def test_it_survives_sigkill_at_random_moments(place, tmp_path, warm, name, kills):
    """Killed a random number of pieces after each start, and a random moment later; the study with two processes.

    `python -m tests.kill_studies` kills studies of every kind as often as one likes.
    """
    random = np.random.default_rng(kills)
    out, before, done = tmp_path / "out", dict[str, Any](), 0
    options = ["--workers", "2"] if name == "study" else []
    for _ in range(kills):
        child = warm.start(command(name, place, out, *options))
        count, moment = len(before) + int(random.integers(1, 4)), random.uniform(0, 0.05)
        wait_until(lambda count=count: len(landed(out, "pieces")) >= count, child.is_running)
        time.sleep(moment)
        workers = []
        with contextlib.suppress(psutil.NoSuchProcess):
            workers = child.children(recursive=True)
            child.kill()
        if warm.end()[0] == 0:  # too late: it had finished
            check_end(place, name, out)
            shutil.rmtree(out)
            before, done = {}, done + 1
            continue
        if workers:
            wait_for_the_end_of(workers)
        if not (out / "results.csv").exists():  # else the pieces were being discarded
            assert before.items() <= landed(out, "pieces").items(), "a piece was done twice"
        before = landed(out, "pieces")
    arguments = [sys.executable, "-m", "robotics", *command(name, place, out, *options)]
    ended = subprocess.run(arguments, capture_output=True, text=True, timeout=PATIENCE, check=False)
    assert (ended.returncode, ended.stderr.replace("\n", "")) == (0, "")
    check_end(place, name, out)
    assert done <= kills / 2 or kills < 3


def test_damaged_and_foreign_pieces_are_refused_and_done_again(place, tmp_path, warm, capsys):
    out = tmp_path / "out"
    child = warm.start(command("study", place, out))
    wait_until(lambda: len(landed(out, "pieces")) >= 5, child.is_running)
    child.kill()
    warm.end()
    chunks = sorted((out / "pieces").glob("chunk-*.parquet"))
    damaged = bytearray(chunks[0].read_bytes())
    damaged[len(damaged) // 2] ^= 1
    chunks[0].write_bytes(damaged)
    chunks[1].write_bytes(chunks[2].read_bytes())  # whole, but of another piece
    assert main(command("study", place, out)) == 0
    told = capsys.readouterr().err.splitlines()
    refused = "is damaged, or is not of this study; it is computed again"
    assert told == [f"warning: {chunk} {refused}" for chunk in chunks[:2]]
    check_end(place, "study", out)


def test_a_folder_with_another_study_that_was_interrupted_is_refused(place, tmp_path, warm, capsys):
    out = tmp_path / "out"
    child = warm.start(command("compare", place, out))
    wait_until(lambda: len(landed(out, "pieces")) >= 2, child.is_running)
    child.kill()
    warm.end()
    assert main([*command("compare", place, out), "--seed", "1"]) == 2
    assert "holds another study: seeds changed; give another --out, or --fresh" in capsys.readouterr().err
    assert main([*command("compare", place, out), "--fresh"]) == 0
    check_end(place, "compare", out)


MEASURED = """
import resource, sys
from robotics.commands.application import main
assert main(sys.argv[1:]) == 0
print("peak", resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


@pytest.mark.long
def test_memory_does_not_grow_with_the_number_of_seeds(place, tmp_path):
    """Ten times the seeds, with the report's pictures, in less than 1.2 times the memory."""
    peaks = []
    for seeds in (200, 2000):
        arguments = ["compare", str(place / "short.toml"), "--controllers", "lyapunov,csm", f"--seeds={seeds}", "-q"]
        program = [sys.executable, "-c", MEASURED, *arguments, "--out", str(tmp_path / str(seeds))]
        ended = subprocess.run(program, capture_output=True, text=True, timeout=PATIENCE, check=True)
        peaks.append(int(ended.stdout.rsplit("peak ", 1)[1]))
    assert peaks[1] < 1.2 * peaks[0]
    page = (tmp_path / "2000" / "report.html").read_text(encoding="utf-8")
    assert "median and band of the first 100 seeds" in page
