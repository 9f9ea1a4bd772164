"""Kill every kind of study at random moments, let it go on, and compare the files with those of an undisturbed run.

    python -m tests.kill_studies                           20 kills each, on processes and on a Dask cluster
    python -m tests.kill_studies --kinds tune,arena --kills 5

A moment is drawn from all that the whole takes, beginning when the first file is there. What has come to its end is
compared, discarded and begun anew until there were so many kills. Prints a row a kind; exits with 1 if a byte differs.
"""

import argparse
import shutil
import sys
import tempfile
import time
from contextlib import suppress
from pathlib import Path

import numpy as np
import psutil

from tests.robotics.commands.test_going_on import STUDY
from tests.robotics.commands.test_sweep_command import SCENARIO, SPEC
from tests.robotics.commands.warmstart import Warm, dask_cluster, wait_for_the_end_of, wait_until
from tests.robotics.plugins.arena.test_running import TEXT as ARENA
from tests.robotics.plugins.stress.test_going_on import TESTS

FILES = {
    "short.toml": SCENARIO,
    "other.toml": SCENARIO.replace("speed = 0.3", "speed = 0.2"),
    "study.toml": STUDY,
    "sweep.toml": SPEC,
    "arena.toml": ARENA,
}
# What is called, and the files that hold neither a date nor what a clock said
KINDS = {
    "compare": (
        ["compare", "short.toml", "other.toml", "--controllers", "lyapunov,csm,esm", "--seeds", "300", "--no-report"],
        ("results.csv", "summary.csv"),
    ),
    "study": (
        ["study", "study.toml", "--no-report"],
        ("results.csv", "summary.csv", "claims.csv", "evidence.csv", "answers.json"),
    ),
    "sweep": (["sweep", "sweep.toml"], ("results.parquet",)),
    "stress crossing": (["stress", "crossing", *TESTS["crossing"]], ("results.csv",)),
    "stress obstacles": (["stress", "obstacles", *TESTS["obstacles"]], ("results.csv",)),
    "arena": (["arena", "arena.toml"], ("results.csv", "scenarios.csv", "presets/presets.toml")),
    "tune": (
        ["tune", "fuzzy", "short.toml", "--seeds", "2", "--evaluations", "2400", "--check-seeds", "20"],
        ("history.csv", "result.json", "tracking.fis"),
    ),
}
ALONE = {"compare"}  # in threads of the process that is killed


def run_to_end(warm: Warm, words: list[str]) -> float:
    """Run a command line; return how long it took [s]."""
    began = time.monotonic()
    warm.start(words)
    status, _, error = warm.end()
    assert status == 0, error
    return time.monotonic() - began


def contents(out: Path, names: tuple[str, ...]) -> dict[str, bytes]:
    """The files by name."""
    return {name: (out / name).read_bytes() for name in names}


def kill(warm: Warm, words: list[str], out: Path, moment: float, apart: bool) -> bool:
    """Run a command line and kill it ``moment`` s after its first file; return whether it was still running."""
    there = len(list(out.rglob("*")))
    child, workers = warm.start(words), []
    wait_until(lambda: len(list(out.rglob("*"))) > max(there, 1), child.is_running)
    deadline = time.monotonic() + moment
    wait_until(lambda: time.monotonic() >= deadline, child.is_running)
    with suppress(psutil.NoSuchProcess):
        workers = child.children(recursive=True)
        child.kill()
    killed = bool(warm.end()[0] != 0)
    if workers and not apart:
        wait_for_the_end_of(workers)
    return killed


def main() -> int:
    """Print a row a kind and place."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0] if __doc__ else "")
    parser.add_argument("--kinds", default=",".join(KINDS))
    parser.add_argument("--kills", type=int, default=20)
    given = parser.parse_args()
    random, wrong = np.random.default_rng(1), 0
    print(f"{'kind':18}{'where':11}{'kills':>6}{'ends':>6}  files that differ")
    with tempfile.TemporaryDirectory() as name, dask_cluster(Path(name)) as address:
        place = Path(name)
        for file, text in FILES.items():
            (place / file).write_text(text, encoding="utf-8")
        warm = Warm(place, place / "short.toml")
        for kind in given.kinds.split(","):
            words, names = KINDS[kind]
            words = [str(place / word) if word in FILES else word for word in words]
            for where, options in (("processes", ["--workers", "2"]), ("dask", ["--dask", address])):
                if kind in ALONE and where == "dask":
                    continue
                options = [] if kind in ALONE else options
                told = [*words, *options, "-q", "--out", str(place / "whole")]
                run_to_end(warm, told)  # what is compiled is there afterwards
                shutil.rmtree(place / "whole")
                took, whole = run_to_end(warm, told), contents(place / "whole", names)
                kills = ends = 0
                differ: set[str] = set()
                told = [*words, *options, "-q", "--out", str(place / "killed")]
                while kills < given.kills or (place / "killed").exists():
                    if kills == given.kills:
                        run_to_end(warm, told)
                    elif kill(warm, told, place / "killed", random.uniform(0, took), where == "dask"):
                        kills += 1
                        continue
                    found = contents(place / "killed", names)
                    differ |= {file for file in names if found[file] != whole[file]}
                    ends += 1
                    shutil.rmtree(place / "killed")
                shutil.rmtree(place / "whole")
                wrong += len(differ)
                print(f"{kind:18}{where:11}{kills:6}{ends:6}  {', '.join(sorted(differ)) or 'none'}", flush=True)
        warm.process.stdin.close()
        warm.process.wait()
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
