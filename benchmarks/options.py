"""Every command of the three programs with one number of its options that nobody means: nan, 1e308, 10^30, -1 ...

    python -m benchmarks.options --runs 300

Each run is the last example of a command's --help with one option more, in a folder where the examples before it have
run. Nothing but success, an exit code and a sentence may come of it, within a time limit. Ends with 1 if anything else
did. Numbers that are merely large, such as a million runs, take as long as they take: they are listed as slow.
"""

import argparse
import re
import shlex
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np

from tests.helpexamples import Help, helps

VALUES = ("nan", "inf", "-inf", "1e308", "-1e308", "1e-308", "1e20", "-1", "0", "1" + "0" * 30, "1_000", "0x10", "")
SERVES = ("fuzzy design",)  # never ends by itself


class Case(NamedTuple):
    """A command's examples before the last, and the last with an option more."""

    before: tuple[str, ...]
    line: str


def numeric_options(each: Help) -> list[str]:
    """The long names of a command's options that its help says take a number."""
    context = each.command.make_context(" ".join(each.words), ["-"], resilient_parsing=True)
    return re.findall(r"^  (?:-\w, )?(--[a-z-]+)(?:, -\w)?\s+<(?:int|float)", context.get_help(), re.MULTILINE)


def cases(rng: np.random.Generator, count: int, wanted: str) -> list[Case]:
    """``count`` cases at random, of commands that begin with ``wanted``."""
    known: list[tuple[Help, str, str]] = []
    for each in helps():
        name = " ".join(each.words)
        own = [line for line in each.examples if f"{line} ".startswith(f"{name} ")]
        if own and name.startswith(wanted) and name not in SERVES and not hasattr(each.command, "commands"):
            known += [(each, own[-1], option) for option in numeric_options(each)]
    found = []
    for k in rng.integers(len(known), size=count):
        each, line, option = known[int(k)]
        value = VALUES[int(rng.integers(len(VALUES)))]
        before = each.examples[: each.examples.index(line)]
        found.append(Case(before, f"{line.partition(' > ')[0]} {option}={shlex.quote(value)}"))
    return found


def outcome(case: Case, folder: Path, limit: float) -> str:
    """What is wrong with a run; empty if nothing is."""
    try:
        done = subprocess.run(_called(case.line), cwd=folder, timeout=limit, capture_output=True, text=True)
    except subprocess.TimeoutExpired:
        return f"slow: not done after {limit:g} s"
    if "Traceback" in done.stderr or done.returncode not in (0, 1, 2):
        return f"rc {done.returncode}: {done.stderr.strip()[-300:]}"
    if done.returncode == 2 and not done.stderr.strip():
        return "rc 2 without a word"
    if len(done.stderr) > 3000:
        return f"a message of {len(done.stderr)} characters"
    return ""


def _called(line: str) -> list[str]:
    program, *words = shlex.split(line)
    return [sys.executable, "-m", program, *words]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=300, help="how many (300)")
    parser.add_argument("--seed", type=int, default=0, help="the seed (0)")
    parser.add_argument("--limit", type=float, default=60.0, help="seconds after which a run is slow (60)")
    parser.add_argument("--command", default="", help="only commands that begin so, such as 'fuzzy identify'")
    options = parser.parse_args()
    wrong = slow = 0
    ready: dict[tuple[str, ...], Path] = {}
    with tempfile.TemporaryDirectory() as root:
        for k, case in enumerate(cases(np.random.default_rng(options.seed), options.runs, options.command)):
            if case.before not in ready:
                ready[case.before] = folder = Path(root, str(len(ready)))
                folder.mkdir()
                for line in case.before:
                    subprocess.run(_called(line.partition(" > ")[0]), cwd=folder, capture_output=True, check=False)
            begun = time.perf_counter()
            what = outcome(case, ready[case.before], options.limit)
            if what:
                slow, wrong = slow + what.startswith("slow"), wrong + (not what.startswith("slow"))
                print(f"#{k} {case.line}\n    {what} ({time.perf_counter() - begun:.0f} s)", flush=True)
    print(f"{options.runs} runs: {wrong} wrong, {slow} slow")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
