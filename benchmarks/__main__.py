"""Every benchmark, one after the other, or those that are named.

python -m benchmarks [NAME ...] [--quick] [--write docs/reference/benchmarks.json]

With --write each table is also kept in that file, with machine, load and date; those of other benchmarks stay in it.
"""

import argparse
import datetime
import json
import os
import platform
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

from benchmarks.reporting import processor

# Each benchmark, and whether it has a short form.
BENCHMARKS = {
    "inference": False,
    "simulation": False,
    "closedloop": True,
    "learning": False,
    "predictive": False,
    "avoidance": True,
    "environments": False,
    "designer": False,
    "drivepage": False,
    "ros": True,
}


def measured(name: str, quick: bool) -> dict[str, Any]:
    """Run one benchmark in a process of its own, show what it prints, and say on what machine that was."""
    short = quick and BENCHMARKS[name]
    before, began = os.getloadavg()[0], time.monotonic()
    lines = []
    command = [sys.executable, "-m", f"benchmarks.{name}", *(["--quick"] if short else [])]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as running:
        assert running.stdout is not None
        for line in running.stdout:
            print(line, end="", flush=True)
            lines.append(line.rstrip())
    if running.returncode:
        sys.exit(running.returncode)
    return {
        "date": datetime.date.today().isoformat(),
        "processor": processor(),
        "processors": os.cpu_count(),
        "python": platform.python_version(),
        "load": [round(before, 2), round(os.getloadavg()[0], 2)],
        "seconds": round(time.monotonic() - began, 1),
        "quick": short,
        "report": lines,
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(BENCHMARKS))
    parser.add_argument("--quick", action="store_true", help="the short form of those that have one")
    parser.add_argument("--write", type=Path, metavar="FILE", help="keep the tables in this JSON file")
    arguments = parser.parse_args()
    for name in arguments.names:
        if name not in BENCHMARKS:
            parser.error(f"no benchmark is called {name!r}; there are {', '.join(BENCHMARKS)}")
    for name in arguments.names or BENCHMARKS:
        entry = measured(name, arguments.quick)
        print()
        if arguments.write:
            kept = json.loads(arguments.write.read_text(encoding="utf-8")) if arguments.write.exists() else {}
            text = json.dumps({**kept, name: entry}, indent=1, ensure_ascii=False)
            arguments.write.write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
