"""Stress tests that are killed, and go on where they were: with the same bytes in the end."""

import contextlib
import json

import numpy as np
import psutil
import pytest

from robotics.commands.application import main
from tests.robotics.commands.test_sweep_command import SCENARIO
from tests.robotics.commands.warmstart import Warm, landed, wait_for_the_end_of, wait_until

TESTS = {
    "crossing": ["--controller", "none", "--runs", "200", "--loss", "0.1"],  # in threads
    "obstacles": ["--robots", "3", "--lanes", "crossing", "--controller", "cooperation", "--runs", "100"],  # processes
}
PIECES = {"crossing": 10, "obstacles": 5}


def command(name, *options):
    return ["stress", name, *TESTS[name], "--workers", "2", "-q", "--json", *options]


@pytest.fixture(scope="module")
def warm(tmp_path_factory):
    folder = tmp_path_factory.mktemp("stress")
    (folder / "short.toml").write_text(SCENARIO, encoding="utf-8")
    parent = Warm(folder, folder / "short.toml")
    with parent.process:
        yield parent
        parent.process.stdin.close()


def killed(warm, name, out, pieces):
    """Begin, and kill when so many pieces are there; whether that was in the midst of it."""
    child, workers = warm.start(command(name, "--out", str(out))), []
    wait_until(lambda: len(landed(out, "pieces")) >= pieces, child.is_running)
    with contextlib.suppress(psutil.NoSuchProcess):
        workers = child.children(recursive=True)
        child.kill()
    killed = warm.end()[0] != 0
    if workers:
        wait_for_the_end_of(workers)
    return killed


@pytest.mark.long  # compare is killed among the short ones, by the same code
@pytest.mark.parametrize("name", ["crossing", "obstacles"])
def test_a_killed_stress_test_goes_on_to_the_same_bytes(tmp_path, capsys, warm, name):
    assert main(command(name, "--out", str(tmp_path / "whole"))) == 0
    whole = capsys.readouterr().out
    assert main(command(name)) == 0
    assert capsys.readouterr().out == whole  # nothing else is printed where nothing is kept
    out, random = tmp_path / "out", np.random.default_rng(0)
    assert killed(warm, name, out, 1)
    before = landed(out, "pieces")
    killed(warm, name, out, len(before) + int(random.integers(1, 3)))
    assert before.items() <= landed(out, "pieces").items(), "a piece was done twice"
    assert main(command(name, "--out", str(out))) == 0
    assert capsys.readouterr().out == whole
    assert len(landed(out, "pieces")) == PIECES[name]
    assert (out / "results.csv").read_bytes() == (tmp_path / "whole" / "results.csv").read_bytes()


def test_damaged_and_foreign_pieces_are_done_again_and_another_test_is_refused(tmp_path, capsys):
    out = tmp_path / "out"
    assert main(command("crossing", "--out", str(out))) == 0
    whole = capsys.readouterr().out
    first, second, third, *_ = sorted((out / "pieces").iterdir())
    content = bytearray(first.read_bytes())
    content[len(content) // 2] ^= 1
    first.write_bytes(content)
    second.write_bytes(third.read_bytes())  # whole, but of another piece
    assert main(command("crossing", "--out", str(out))) == 0
    told = capsys.readouterr()
    refused = "is damaged, or is not of this stress test; it is computed again"
    assert (told.out, told.err.splitlines()[1:]) == (whole, [f"warning: {file} {refused}" for file in (first, second)])
    assert main([*command("crossing", "--out", str(out)), "--loss", "0.2"]) == 2
    assert "holds another stress test: disturbance changed; give another --out, or --fresh" in capsys.readouterr().err
    assert main([*command("crossing", "--out", str(out)), "--loss", "0.2", "--fresh"]) == 0
    assert json.loads(capsys.readouterr().out) != json.loads(whole)
