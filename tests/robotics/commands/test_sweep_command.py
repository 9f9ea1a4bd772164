"""The command ``robotics sweep``, end to end: processes, a Dask cluster, Ctrl-C, and death at any moment."""

import contextlib
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from typing import Any

import numpy as np
import psutil
import pyarrow.parquet as pq
import pytest

from robotics.commands.application import main
from robotics.studies import executors, keptcomparison
from tests.robotics.commands.warmstart import PATIENCE, Warm, dask_cluster, landed, wait_for_the_end_of, wait_until

SCENARIO = """
duration = 1.0
plant = "kinematic"

[sensing]
posture = "pose"
position_noise = 0.002

[[robots]]
start = [0.0, 0.1, 0.0]
path = { shape = "line", start = [0.0, 0.0], end = [2.0, 0.0] }
timing = { speed = 0.3 }
"""
SPEC = """
scenario = "short.toml"
controllers = ["lyapunov", "fuzzy"]
seeds = 4
chunk = 2
method = "random"
samples = 15
seed = 7

[scenario_fields]
"sensing.position_noise" = { low = 1e-4, high = 1e-2, scale = "log" }
latency = { low = 0.0, high = 0.1, step = 0.05 }
"""
CHUNKS, RUNS = 60, 120


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A folder with the sweep's file, and its table from a run that nothing disturbs."""
    folder = tmp_path_factory.mktemp("sweep")
    (folder / "short.toml").write_text(SCENARIO, encoding="utf-8")
    (folder / "spec.toml").write_text(SPEC, encoding="utf-8")
    assert main(["sweep", str(folder / "spec.toml"), "--out", str(folder / "undisturbed"), "-q"]) == 0
    return folder


def expected(place):
    return (place / "undisturbed" / "results.parquet").read_bytes()


def command(place, out, *options):
    return ["sweep", str(place / "spec.toml"), "--out", str(out), "--json", "-q", *options]


@pytest.fixture(scope="module")
def warm(place):
    parent = Warm(place, place / "short.toml")
    with parent.process:
        yield parent
        parent.process.stdin.close()


def test_the_table_and_what_is_said(place, capsys):
    out = place / "undisturbed"
    assert main(command(place, out)) == 0
    said = json.loads(capsys.readouterr().out)
    assert (said["rows"], said["points"], said["runs"], said["chunks"]) == (RUNS, 15, RUNS, CHUNKS)
    assert said["computed"] == 0  # it was there
    assert said["results"] == str(out / "results.parquet")
    row = pq.read_table(out / "results.parquet").to_pylist()[5]
    assert (row["point"], row["controller"], row["seed"]) == (1, "fuzzy", 1)
    # The same run by hand
    text = SCENARIO.replace("0.002", repr(row["sensing.position_noise"])) + "\n"
    (place / "hand.toml").write_text(f"latency = {row['latency']}\n{text}", encoding="utf-8")
    assert main(["run", str(place / "hand.toml"), "-c", "fuzzy", "--seed", "1", "--json", "-q"]) == 0
    for name, values in json.loads(capsys.readouterr().out)["metrics"].items():
        assert row[name] == pytest.approx(values[0], rel=1e-12), name


def test_it_says_what_it_did_and_where_it_goes_on(place, tmp_path, capsys):
    shutil.copytree(place / "undisturbed", tmp_path / "out")
    for number in (1, 2, 3):
        (tmp_path / "out" / "pieces" / f"chunk-{number:06}.parquet").unlink()
    assert main(["sweep", str(place / "spec.toml"), "--out", str(tmp_path / "out")]) == 0
    printed = capsys.readouterr()
    assert f"{tmp_path / 'out'}: 57 of 60 chunks are there already" in printed.err
    assert "120 rows, 15 points × 2 controllers × 4 seeds" in printed.out
    assert "3 of 60 chunks computed now" in printed.out
    assert (tmp_path / "out" / "results.parquet").read_bytes() == expected(place)


def check_what_is_left(out, before):
    """After a kill every chunk's file is whole, and those of before have not been touched."""
    now = landed(out)
    assert before.items() <= now.items(), "a chunk was done twice"
    for name in now.keys() - before.keys():
        pq.ParquetFile(out / "pieces" / name).read()
    assert not (out / "results.parquet").exists()
    return now


def finish(place, out, before, *options):
    """Run the command as a user does: it does what is missing, and the table is that of the undisturbed run."""
    arguments = [sys.executable, "-m", "robotics", *command(place, out, *options)]
    done = subprocess.run(arguments, capture_output=True, text=True, timeout=PATIENCE, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert json.loads(done.stdout)["computed"] == CHUNKS - len(before)
    assert before.items() <= landed(out).items()
    assert (out / "results.parquet").read_bytes() == expected(place)


@pytest.mark.long
def test_it_survives_sigkill_at_random_moments(place, tmp_path, warm):
    """Killed a random number of chunks after each start, and a random moment later."""
    random = np.random.default_rng(0)
    out, before = tmp_path / "out", dict[str, Any]()
    for _ in range(6):
        child = warm.start(command(place, out))
        count, moment = len(before) + int(random.integers(0, 4)), random.uniform(0, 0.05)
        wait_until(lambda count=count: len(landed(out)) >= count, child.is_running)
        time.sleep(moment)
        with contextlib.suppress(psutil.NoSuchProcess):
            child.kill()
        if warm.end()[0] == 0:  # too late: it had finished
            assert (out / "results.parquet").read_bytes() == expected(place)
            shutil.rmtree(out)
            before = {}
        else:
            before = check_what_is_left(out, before)
    finish(place, out, before)


@pytest.mark.long
def test_workers_give_the_same_table_and_die_with_their_sweep(place, tmp_path, warm):
    """Killed with two processes at work, which must not stay behind."""
    random = np.random.default_rng(1)
    out, before = tmp_path / "out", dict[str, Any]()
    for _ in range(3):
        child = warm.start(command(place, out, "--workers", "2"))
        count = len(before) + int(random.integers(1, 5))
        wait_until(lambda count=count: len(landed(out)) >= count, child.is_running)
        time.sleep(random.uniform(0, 0.03))
        workers = child.children(recursive=True)
        assert len(workers) >= 2
        child.kill()
        assert warm.end()[0] == -signal.SIGKILL
        wait_for_the_end_of(workers)
        before = check_what_is_left(out, before)
    finish(place, out, before, "--workers", "2")


@pytest.mark.long
def test_a_killed_worker_costs_nothing(place, tmp_path, warm):
    child = warm.start(command(place, tmp_path / "out", "--workers", "1"))
    wait_until(lambda: len(landed(tmp_path / "out")) >= 2, child.is_running)
    # The worker is the only process that another one than the sweep itself has begun: its fork server
    (worker,) = (p for p in child.children(recursive=True) if p.ppid() != child.pid)
    worker.kill()
    status, printed, error = warm.end()
    assert (status, error, json.loads(printed)["computed"]) == (0, "", CHUNKS)
    assert (tmp_path / "out" / "results.parquet").read_bytes() == expected(place)


def test_an_interrupt_that_a_library_translates_keeps_what_is_done(place, tmp_path, monkeypatch, capsys):
    drives = keptcomparison.simulate

    def translates(scenario, *arguments, **options):
        if len(landed(tmp_path)) == 3:
            try:
                raise KeyboardInterrupt
            except KeyboardInterrupt as error:
                raise SystemError("returned a result with an exception set") from error
        return drives(scenario, *arguments, **options)

    monkeypatch.setattr(keptcomparison, "simulate", translates)
    assert main(command(place, tmp_path)) == 130
    assert "robotics: interrupted; 3 of 60 chunks are in " in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "number", "status", "word"),
    [
        ([], signal.SIGINT, 130, "interrupted"),
        ([], signal.SIGTERM, 143, "interrupted by SIGTERM"),
        pytest.param(["--workers", "2"], signal.SIGINT, 130, "interrupted", marks=pytest.mark.long),
    ],
)
def test_ctrl_c_keeps_what_is_done_and_says_so(place, tmp_path, warm, options, number, status, word):
    child = warm.start(command(place, tmp_path, *options))
    wait_until(lambda: len(landed(tmp_path)) >= 3, child.is_running)
    workers = child.children(recursive=True)
    child.send_signal(number)
    ended, printed, error = warm.end()
    assert (ended, printed) == (status, "")
    there = len(landed(tmp_path))
    assert error == (f"robotics: {word}; {there} of 60 chunks are in {tmp_path}; the same command goes on from there\n")
    assert not (tmp_path / "results.parquet").exists()
    if workers:
        wait_for_the_end_of(workers)


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    with dask_cluster(tmp_path_factory.mktemp("cluster")) as address:
        yield address


@pytest.mark.long
def test_a_dask_cluster_gives_the_same_table(place, tmp_path, cluster):
    finish(place, tmp_path / "out", {}, "--dask", cluster)


@pytest.mark.long
def test_a_study_on_a_cluster_has_the_same_tables(place, tmp_path, cluster):
    study = tmp_path / "study.toml"
    lines = (f'scenarios = ["{place / "short.toml"}"]', 'controllers = ["lyapunov", "fuzzy"]', "seeds = 3")
    axis = '[[axes]]\nkey = "latency"\nvalues = [0.0, 0.05]\n'
    study.write_text("\n".join((*lines, axis)), encoding="utf-8")
    for out, options in (("here", []), ("there", ["--dask", cluster])):
        assert main(["study", str(study), "--out", str(tmp_path / out), "--no-report", "-q", *options]) == 0
    for name in ("results.csv", "summary.csv"):
        assert (tmp_path / "here" / name).read_bytes() == (tmp_path / "there" / name).read_bytes()


@pytest.mark.long
def test_what_a_worker_of_a_cluster_refuses_is_said(place, tmp_path, cluster):
    """As if the sweep had been planned with another numpy than the workers have."""
    script = (
        "import sys\nfrom robotics.studies import keptcomparison as kept\n"
        "from robotics.commands.application import main\n"
        "true = kept.versions\nkept.versions = lambda *names: true(*names) | {'numpy': '1.0'}\n"
        f"sys.exit(main({command(place, tmp_path / 'out', '--dask', cluster)!r}))"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=PATIENCE, check=False)
    assert done.returncode == 2
    assert done.stderr == f"robotics: a worker has numpy {np.__version__} where this was planned with 1.0\n"


@pytest.mark.parametrize(
    ("options", "fragments"),
    [
        (["--workers", "2", "--dask", "tcp://127.0.0.1:1"], ["give --workers or --dask, not both"]),
        (["--workers", "0"], ["--workers"]),
        (
            ["--dask", "127.0.0.1"],
            ["--dask must be a scheduler's address, such as tcp://127.0.0.1:8786", "'127.0.0.1'"],
        ),
        (["--out", "/proc/none/x"], ["/proc/none"]),
    ],
)
def test_bad_options_are_one_message_and_exit_code_2(place, options, fragments, tmp_path, capsys):
    assert main(["sweep", str(place / "spec.toml"), "--out", str(tmp_path), "-q", *options]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert "Traceback" not in printed.err
    for fragment in fragments:
        assert fragment in printed.err


def test_a_cluster_that_does_not_answer_is_said(place, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(executors, "CONNECT", 0.3)
    assert main(command(place, tmp_path, "--dask", "tcp://127.0.0.1:1")) == 2
    assert "--dask tcp://127.0.0.1:1: no scheduler answers" in capsys.readouterr().err


def test_without_dask_its_extra_is_named(place, tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "distributed", None)
    assert main(command(place, tmp_path, "--dask", "tcp://127.0.0.1:1")) == 2
    assert "pip install 'distributed>=" in capsys.readouterr().err


def test_a_bad_file_is_named_with_its_line(place, capsys):
    bad = place / "bad.toml"
    bad.write_text(SPEC.replace("latency", "latncy"), encoding="utf-8")
    assert main(["sweep", str(bad), "--out", str(place / "bad"), "-q"]) == 2
    message = capsys.readouterr().err
    assert f"{bad}:12: point 1 (sensing.position_noise = " in message
    assert "unknown key 'latncy'; did you mean 'latency'" in message


def test_help_has_an_example_of_a_file(capsys):
    assert main(["sweep", "--help"]) == 0
    printed = capsys.readouterr().out
    assert "[scenario_fields]" in printed


def test_threads_of_the_workers_do_not_compete_and_the_environment_is_put_back(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    monkeypatch.delenv("NUMBA_NUM_THREADS", raising=False)
    with executors.processes(1) as crew:
        seen = [crew.executor.submit(os.getenv, name).result(timeout=PATIENCE) for name in executors.THREADS]
    assert seen == ["1"] * len(executors.THREADS)
    assert os.environ["OMP_NUM_THREADS"] == "7"
    assert "NUMBA_NUM_THREADS" not in os.environ
