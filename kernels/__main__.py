"""Compile the kernels of the packaged commands for a wheel, or with ``--here`` for this machine.

Those of a wheel come into ``build/kernels/wheel``, an archive a baseline; ``make wheel`` hands that folder to
kernels/wheel.py. What was done before an interruption is not done again, unless a source has changed.
"""

import argparse
import hashlib
import io
import lzma
import multiprocessing
import os
import re
import sys
import time
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from zipfile import ZipFile, ZipInfo

from numba.core import config

from fuzzy.compiled.jit import BASELINES, with_digest
from kernels.tasks import ROOT, Task, do, everyday, tasks, wide

BUILD = ROOT / "build" / "kernels"
PACKAGES = ("fuzzy", "anfis", "robotics")
# All for the CPUs of the last ten years, what is used every day for older ones, and what gains by wider vectors for
# those that have them: together no more than 12 MB.
WANTED = {"x86-64-v4": wide, "x86-64-v3": tasks, "x86-64-v2": everyday}


def main() -> int:
    """Compile, and return 1 if a task failed."""
    asks = argparse.ArgumentParser(prog="python -m kernels", description="Compile the kernels of packaged commands.")
    asks.add_argument("--here", action="store_true", help="those of every day, into the cache of this machine")
    asks.add_argument("--baseline", action="append", choices=[*BASELINES], help="default: all of them")
    asks.add_argument("--out", type=Path, default=BUILD, metavar="FOLDER", help="default: %(default)s")
    asks.add_argument("--only", default="", metavar="REGEX", help="only tasks whose name matches")
    asks.add_argument("--workers", type=int, default=2, help="processes at a time (default: %(default)s)")
    asked = asks.parse_args()
    if config.USING_SVML and not asked.here:  # type: ignore[attr-defined]
        asks.error("uninstall icc_rt first: its users' machines would need it, too")
    if asked.here:
        return int(not _run(_wanted(everyday(), asked.only), asked.workers, {}, None))
    fine = True
    for baseline in asked.baseline or BASELINES:
        wanted = _wanted(WANTED[baseline](), asked.only)
        work = asked.out.resolve() / "work" / f"{baseline}-{_sources()}"
        machine = {"NUMBA_CPU_NAME": baseline, "NUMBA_CPU_FEATURES": "", "NUMBA_CACHE_DIR": str(work / "cache")}
        fine &= _run(wanted, asked.workers, machine, work / "done")
        pack(sorted((work / "cache").rglob("*.nbc")), asked.out / "wheel" / f"{baseline}.kernels")
    return int(not fine)


def _wanted(known: list[Task], only: str) -> list[Task]:
    return [task for task in known if re.search(only, task.name)]


def pack(files: list[Path], archive: Path) -> None:
    """Write files into an archive that fuzzy/compiled/jit.py unpacks."""
    stored = io.BytesIO()
    with ZipFile(stored, "w") as into:
        for file in sorted(files, key=lambda file: file.name):
            into.writestr(ZipInfo(file.name), file.read_bytes())  # of no time: the same files, the same archive
    archive.parent.mkdir(parents=True, exist_ok=True)
    archive.write_bytes(with_digest(lzma.compress(stored.getvalue(), preset=9)))
    print(f"{archive.name}: {len(files)} kernels, {archive.stat().st_size / 1e6:.1f} MB", flush=True)


def _sources() -> str:
    """A digest of all that is compiled: kernels of other sources would be of no use."""
    files = sorted(file for package in PACKAGES for file in (ROOT / package).rglob("*.py"))
    return hashlib.sha256(b"".join(file.read_bytes() for file in files)).hexdigest()[:12]


def _run(wanted: list[Task], workers: int, environment: dict[str, str], done: Path | None) -> bool:
    """Run tasks, several at a time, and return whether all succeeded; ``done`` is where it is noted which were run."""
    os.environ |= environment | {"MPLBACKEND": "Agg", "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    marks = {task.name: done / re.sub(r"\W+", "-", task.name) if done else None for task in wanted}
    left = [task for task in wanted if not (mark := marks[task.name]) or not mark.exists()]
    began, fine = time.monotonic(), True
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(workers, spawn) as pool:
        running = {pool.submit(do, task): task for task in left}
        for number, future in enumerate(as_completed(running), 1):
            task, (seconds, compiled, error) = running[future], future.result()
            said = f"{compiled:3} compiled in {seconds:5.1f} s  {task.name}{': ' if error else ''}{error}"
            print(f"{time.monotonic() - began:5.0f} s  {number:3} of {len(left)}  {said}", flush=True)
            fine &= not error
            if not error and (mark := marks[task.name]):
                mark.parent.mkdir(parents=True, exist_ok=True)
                mark.touch()
    return fine


if __name__ == "__main__":
    sys.exit(main())
