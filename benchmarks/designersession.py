"""The designer in a real browser, for measuring it and for taking its pictures: a server of its own, and Chromium."""

import os
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from fuzzy.files.fisfile import read_fis, write_fis
from fuzzy.files.table import write_table
from fuzzy.plugins.designer.starts.control import rule_table
from fuzzy.plugins.type2.system import to_type2
from fuzzy.system import Terms

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
FLAGS = ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking"]
PATIENCE = 120_000  # ms that a step may take on a busy machine
_PAST_A_POST = """\
title = "Close past a post"
duration = 12.0
sensing = { posture = "pose", position_noise = 0.02, heading_noise = 0.02, start_position = 0.03 }

[[robots]]
start = [0.0, 0.1, 0.0]
path = { shape = "line", start = [0.0, 0.0], end = [3.0, 0.0] }
timing = { duration = 10.0 }

[[obstacles]]
shape = "disc"
position = [1.5, 0.205]
radius = 0.1
"""
_START = "import sys; from fuzzy.commands.application import main; sys.exit(main(sys.argv[1:]))"


def missing() -> str | None:
    """Why there is no designer to be seen here, in a sentence; None where there is one."""
    for package, extra in (("nicegui", "design"), ("playwright", "test")):
        try:
            __import__(package)
        except ImportError:
            return f"the designer is left out: {package} is not installed (extra {extra})"
    return None if CHROMIUM else "the designer is left out: no Chromium is installed"


def workplace(folder: Path) -> Path:
    """A folder with two packaged rule bases, another one, a fuzzy PD, a scenario, and two tables, one of a drive."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in ("tracking.fis", "correcting.fis"):
        text = (files("robotics") / "data" / "rulebases" / name).read_text(encoding="utf-8")
        (folder / name).write_text(text, encoding="utf-8")
    fis = read_fis(folder / "tracking.fis")
    # The other design turns more sharply, and takes "Far" for nearer.
    outputs = []
    for variable in fis.outputs:
        terms = [(name, replace(term, value=1.5 * term.value)) for name, term in variable.terms.items()]
        outputs.append(replace(variable, terms=Terms(terms)) if variable.unit == "rad/s" else variable)
    first = fis.inputs[0]
    near = [(name, replace(t, b=0.3, c=0.8) if name == "Far" else t) for name, t in first.terms.items()]
    inputs = (replace(first, terms=Terms(near)), *fis.inputs[1:])
    write_fis(replace(fis, inputs=inputs, outputs=tuple(outputs), name="sharper"), folder / "sharper.fis")
    write_fis(rule_table("pd", 5), folder / "pd.fis")
    write_fis(to_type2(rule_table("pd", 5), lag=0.2, scale=0.8), folder / "pd2.fis")
    (folder / "past-a-post.toml").write_text(_PAST_A_POST, encoding="utf-8")
    rng = np.random.default_rng(0)
    x = rng.uniform(-3.0, 3.0, (400, 2))
    z = np.sinc(x[:, 0]) * np.sinc(x[:, 1])
    rows = "\n".join(f"{a:.5f},{b:.5f},{c:.5f}" for (a, b), c in zip(x, z, strict=True))
    (folder / "sinc.csv").write_text(f"x,y,z\n{rows}\n", encoding="utf-8")
    # A drive on which the robot was slower than it should have been, the more the farther it had to go.
    variables = (*fis.inputs, *fis.outputs)
    x = np.column_stack([rng.uniform(1.15 * v.universe[0], 1.15 * v.universe[1], 800) for v in fis.inputs])
    y = fis(x) + rng.normal(0.0, 0.02, (800, len(fis.outputs)))
    y[:, 0] *= 1 - 0.1 * x[:, 0] / fis.inputs[0].universe[1]
    names, units = ["t", *(v.name for v in variables)], ["s", *(v.unit for v in variables)]
    write_table(folder / "drive.csv", names, np.column_stack([0.05 * np.arange(800), x, y]), units)
    return folder


@contextmanager
def served(folder: Path, name: str) -> Iterator[tuple[str, int]]:
    """``fuzzy design`` on a file of ``folder`` in a process of its own: its address and process number."""
    environment = {key: value for key, value in os.environ.items() if not key.startswith("NICEGUI")}
    process = subprocess.Popen(
        [sys.executable, "-c", _START, "design", name, "--no-browser"],
        cwd=folder,
        env=environment,
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        said = process.stdout.readline() if process.stdout else ""
        found = re.search(r"http://127\.0\.0\.1:\d+/\S*", said)  # with the token
        if found is None:
            raise RuntimeError(f"the designer did not start: {said}")
        yield found[0], process.pid
    finally:
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=60)


@contextmanager
def browser() -> Iterator[Any]:
    """Headless Chromium, by playwright."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as started:
        opened = started.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        try:
            yield opened
        finally:
            opened.close()


def show(page: Any, url: str) -> None:
    """Load the designer and wait until its first view is drawn."""
    page.set_default_timeout(PATIENCE)
    page.goto(url)
    page.wait_for_selector(".shell-header[data-ready]")
    page.wait_for_selector(".fd-terms [role=slider]")


def tab(page: Any, name: str) -> None:
    """Show a view of the page, or a drawer over the editors."""
    if name == "History":
        page.get_by_role("button", name="History", exact=True).click()
    elif name in ("Train", "Tune", "Tune the loop"):
        page.get_by_role("button", name="Improve").click()
        page.get_by_role("menuitem", name=f": {name}").click()
    else:
        page.get_by_role("tab", name=name, exact=True).click()


def purpose(page: Any, name: str) -> None:
    """Say what the rule base is for: "Function", "Loop" or "Robot"."""
    page.get_by_role("radio", name=name, exact=True).click()


def menu(page: Any, entry: str) -> None:
    """Choose an entry of the file's menu."""
    page.get_by_role("button", name="File ▾").click()
    page.get_by_role("menuitem", name=entry).click()


def grip(page: Any, handle: Any) -> tuple[float, float]:
    """Press the mouse in the middle of ``handle``; that place [px]."""
    box = handle.bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    return x, y
