"""Command lines in processes of their own that start at once, to be killed: for the tests of what a stop leaves."""

import json
import select
import subprocess
import sys
import time
from contextlib import contextmanager, suppress
from typing import Any

import psutil

PATIENCE = 120  # s, for a machine that is busy with other things
# Command lines in forks of a process that has everything imported: it is work that is killed, not imports
WARM = """
import json, os, sys
import pandas, pyarrow.parquet, robotics.simulation.scenario.description, robotics.simulation.loop
import robotics.show.report.study, robotics.studies.keptcomparison
from robotics.commands.application import main
from robotics.laws.catalogue import make_controller
law, scenario = make_controller("fuzzy"), robotics.simulation.scenario.reading.load_scenario(sys.argv[1])
robotics.studies.keptcomparison.rows_of(robotics.simulation.loop.simulate(scenario, law))
for line in sys.stdin:
    arguments, out, err = json.loads(line)
    child = os.fork()
    if child == 0:
        for number, path in enumerate((os.devnull, out, err)):
            os.dup2(os.open(path, os.O_RDWR | os.O_CREAT | os.O_TRUNC), number)
        status = main(arguments)
        sys.stdout.flush()
        os._exit(status)
    print(child, flush=True)
    print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)
"""


class Warm:
    """Starts command lines, one at a time, in processes of their own."""

    def __init__(self, folder, scenario):
        self.out, self.err = folder / "stdout", folder / "stderr"
        command = [sys.executable, "-c", WARM, str(scenario)]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def line(self):
        assert select.select([self.process.stdout], [], [], PATIENCE)[0]
        return self.process.stdout.readline()

    def start(self, arguments):
        self.process.stdin.write(json.dumps([arguments, str(self.out), str(self.err)]) + "\n")
        self.process.stdin.flush()
        return psutil.Process(int(self.line()))

    def end(self):
        """The exit code, stdout and stderr."""
        return int(self.line()), self.out.read_text(encoding="utf-8"), self.err.read_text(encoding="utf-8")


def landed(out, folder="pieces"):
    """The chunks that are there, by name, with what tells them from later ones."""
    found = {}
    for file in (out / folder).glob("chunk-*.parquet"):
        with suppress(FileNotFoundError):  # work that is done discards them
            about = file.stat()
            found[file.name] = about.st_ino, about.st_mtime_ns
    return found


def wait_until(condition, running):
    deadline = time.monotonic() + PATIENCE
    while running() and not condition():
        assert time.monotonic() < deadline
        time.sleep(0.005)


def ended(process):
    """Is it gone, or a corpse that nobody has fetched yet?"""
    try:
        return process.status() == psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return True


def wait_for_the_end_of(processes):
    assert len(processes) > 0
    wait_until(lambda: all(map(ended, processes)), lambda: True)


@contextmanager
def dask_cluster(folder):
    """A Dask scheduler and two worker processes on this machine: the scheduler's address."""
    about = folder / "scheduler.json"
    python, quiet = [sys.executable, "-m"], dict[str, Any](stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    shared = ["--host", "127.0.0.1", "--no-dashboard", "--scheduler-file", str(about)]
    members = [subprocess.Popen([*python, "distributed.cli.dask_scheduler", "--port", "0", *shared], **quiet)]
    try:
        wait_until(about.exists, lambda: members[0].poll() is None)
        worker = [*python, "distributed.cli.dask_worker", "--nthreads", "1", "--no-nanny", *shared]
        for name in ("one", "two"):
            members.append(subprocess.Popen([*worker, "--local-directory", str(folder / name)], **quiet))
        yield json.loads(about.read_text(encoding="utf-8"))["address"]
    finally:
        for member in members:
            member.kill()
        for member in members:
            member.wait(timeout=PATIENCE)
