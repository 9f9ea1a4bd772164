"""What is run so that kernels are compiled: nothing of it is for its results."""

import contextlib
import io
import os
import tempfile
import time
import tomllib
import traceback
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from robotics import CATALOGUE, scenario_names
from tests.helpexamples import helps
from tests.snippets import run_commands, run_python, snippets

ROOT = Path(__file__).parents[1]
# The designer's server never ends, and what it computes a script does; an arena takes minutes, and has no kernel more.
_LEFT_OUT = (("fuzzy", "design"), ("robotics", "arena"))


class Task(NamedTuple):
    """Commands, or a script, that run in a folder of their own."""

    name: str
    text: str
    script: bool = False


def everyday() -> list[Task]:
    """Every law, every scenario, and what most programs do; the first are those that most others share kernels with."""
    listed = _listed()
    commands = [Task(name, text) for name, text in listed["commands"].items()]
    scripts = [Task(name, text, script=True) for name, text in listed["scripts"].items()]
    return [*commands[:2], *_runs(listed["scenarios"]), *commands[2:], *scripts]


def wide() -> list[Task]:
    """What is compiled with :func:`fuzzy.compiled.vectors.wide_vectors`, and nothing beside it."""
    name = "many points"
    return [Task(name, _listed()["scripts"][name], script=True)]


def tasks() -> list[Task]:
    """Those, and all that users copy: pages, the examples of every --help, and the gallery."""
    found = everyday()
    for page in _listed()["pages"]:
        text = "\n".join(text for kind, text in snippets(ROOT / page) if kind == "python")
        found.append(Task(page, text, script=True))
    found += [Task(" ".join(h.words), "\n".join(h.examples)) for h in helps() if h.words not in _LEFT_OUT]
    gallery = sorted((ROOT / "examples").rglob("*.py"))
    return found + [Task(f"{f.parent.name}/{f.name}", f.read_text(encoding="utf-8"), script=True) for f in gallery]


def _listed() -> dict[str, Any]:
    return tomllib.loads(Path(__file__).with_name("list.toml").read_text(encoding="utf-8"))


def _runs(scenarios: dict[str, list[str]]) -> Iterator[Task]:
    """Every law on the scenarios of its kind, and every packaged scenario under its own law."""
    for name, preset in CATALOGUE.items():
        lines = [f"robotics run {scenario} -c {name} --quiet" for scenario in scenarios[preset.kind]]
        yield Task(f"the law {name}", "\n".join(lines))
    for scenario in scenario_names():
        yield Task(scenario, f"robotics run {scenario} --quiet")


def do(task: Task) -> tuple[float, int, str]:
    """Run one task; returns how long it took, how many functions were compiled, and what went wrong."""
    from numba.core.event import install_recorder

    began, said, home = time.monotonic(), io.StringIO(), Path.cwd()
    with tempfile.TemporaryDirectory() as folder, install_recorder("numba:compile") as recorder:
        os.chdir(folder)
        try:
            with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
                if task.script:
                    run_python(task.text, task.name)
                else:
                    run_commands(task.text)
            error = ""
        except (Exception, SystemExit):
            error = traceback.format_exc().splitlines()[-1] + said.getvalue()[-300:]
        finally:
            os.chdir(home)
    return time.monotonic() - began, len(recorder.buffer) // 2, error
