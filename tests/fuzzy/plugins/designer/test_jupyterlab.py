"""The widgets in a real JupyterLab (``make test-notebook``): keys are theirs, and a saved notebook shows stills."""

import json
import os
import re
import signal
import struct
import subprocess
import sys
import time
from base64 import b64decode
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from urllib.error import URLError
from urllib.request import Request, urlopen

import pytest

# Not imported: that takes seconds, and a JupyterLab runs in a process of its own.
MISSING = [name for name in ("jupyterlab", "anywidget") if find_spec(name) is None]
pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(bool(MISSING), reason=f"needs {', '.join(MISSING)}, of the extra jupyter"),
]

CELLS = (
    "import fuzzy, robotics\n"
    "d = {'near': fuzzy.Triangle(0.0, 0.5, 1.2), 'far': fuzzy.Gaussian(0.5, 2.0)}\n"
    "v = {'slow': 0.2, 'fast': 0.9}\n"
    "rules = ['if d is near then v is slow', 'if d is far then v is fast']\n"
    "d, v = fuzzy.Variable('d', (0.0, 2.0), d, 'm'), fuzzy.Variable('v', (0.0, 1.0), v)\n"
    "fis = fuzzy.Sugeno([d], [v], rules, name='x')\n"
    "editor = fuzzy.editor(fis)\n"
    "editor",
    "player = robotics.player(robotics.simulate(robotics.load_scenario('lyapunov-sine'), 'lyapunov'))\nplayer",
    "print('the peak is', list(editor.fis.inputs[0].terms['near'].parameters), 'the time', round(player.time, 2))",
)

STILL = ["Editor of x: 1 input, 1 output, 2 rules", "Player of Lyapunov on lyapunov-sine, seed 0"]


@pytest.fixture(scope="module")
def lab(tmp_path_factory: Any) -> Iterator[tuple[str, Path]]:
    """The address of a JupyterLab without a token, and its folder with one notebook."""
    folder = tmp_path_factory.mktemp("lab")
    cells = [
        {"cell_type": "code", "id": f"c{k}", "metadata": {}, "outputs": [], "execution_count": None, "source": source}
        for k, source in enumerate(CELLS)
    ]
    kernel = {"kernelspec": {"name": "python3", "display_name": "Python 3", "language": "python"}}
    notebook = {"nbformat": 4, "nbformat_minor": 5, "metadata": kernel, "cells": cells}
    (folder / "widgets.ipynb").write_text(json.dumps(notebook), encoding="utf-8")
    options = [
        "--no-browser",
        "--ServerApp.port=0",
        "--IdentityProvider.token=",
        "--ServerApp.disable_check_xsrf=True",
        f"--ServerApp.root_dir={folder}",
    ]
    homes = {name: str(folder / name.lower()) for name in ("HOME", "JUPYTER_CONFIG_DIR", "JUPYTER_RUNTIME_DIR")}
    process = subprocess.Popen(
        [sys.executable, "-m", "jupyterlab", "--allow-root", *options],
        env=os.environ | homes | {"PYTHONPATH": str(Path(__file__).parents[4])},
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    assert process.stderr is not None
    try:
        said = ""
        while (found := re.search(r"http://(?:localhost|127\.0\.0\.1):(\d+)/lab", said)) is None:
            line = process.stderr.readline()
            assert line, said
            said += line
        address = f"http://127.0.0.1:{found[1]}"
        start_kernel(address)
        yield f"{address}/lab/tree/", folder
    finally:
        os.killpg(process.pid, signal.SIGKILL)  # with its kernels, for which it may wait for minutes
        process.communicate(timeout=60)


def start_kernel(address: str) -> None:
    """Start a kernel for the notebook, so that the page need not ask which one to take."""
    session = {"path": "widgets.ipynb", "name": "", "type": "notebook", "kernel": {"name": "python3"}}
    request = Request(f"{address}/api/sessions", json.dumps(session).encode(), {"Content-Type": "application/json"})
    for _ in range(60):  # the address is said before anybody listens there
        try:
            with urlopen(request, timeout=120):
                return
        except URLError as error:
            refused = error
            time.sleep(1)
    raise refused


def cells(page: Any) -> int:
    number: int = page.evaluate("document.querySelectorAll('.jp-Notebook .jp-Cell').length")
    return number


def press(page: Any, node: Any, *keys: str) -> None:
    node.focus()
    for key in keys:
        page.keyboard.press(key)
    page.wait_for_timeout(100)  # a command of the notebook's takes its time


def until(page: Any, peak: str) -> None:
    page.wait_for_selector(f"[aria-label='near: peak'][aria-valuenow='{peak}']")


def test_keys_on_a_widget_stay_there_and_a_saved_notebook_has_stills(browser: Any, lab: tuple[str, Path]) -> None:
    url, folder = lab
    page = browser.new_page(viewport={"width": 1400, "height": 1800})
    page.set_default_timeout(60_000)
    page.goto(f"{url}widgets.ipynb?reset")
    page.wait_for_selector(".jp-Notebook .jp-Cell")
    handle, play = page.get_by_role("slider", name="near: peak"), page.locator(".fleet-player button.play")
    # Which kernel? It may be asked although one runs, when it likes, also between two clicks.
    question = page.locator("dialog button.jp-mod-accept").last
    page.add_locator_handler(question, lambda: question.click(), no_wait_after=True)
    peak, running = page.get_by_text("the peak is [0.0, 0.5, 1.2]"), page.locator(".jp-InputPrompt", has_text="*")
    for _ in range(6):  # what is run while the page still connects to its kernel is not run, or forgotten
        page.locator(".lm-MenuBar-item", has_text="Run").click()
        page.locator(".lm-Menu-item[data-command='runmenu:run-all']").click()
        page.wait_for_timeout(5000)
        while running.count() and not question.count():  # the limit of a test ends it
            page.wait_for_timeout(1000)
        if peak.count() and handle.count():
            break
    page.remove_locator_handler(question)
    handle.wait_for()
    peak.wait_for()
    assert page.locator(".fuzzy-editor").bounding_box()["height"] < 800

    # At the width of a notebook the editors stand beside the views, and the tree of the system is closed.
    edit, look = (page.get_by_role("region", name=name).bounding_box() for name in ("Edit the design", "Look at it"))
    assert edit["y"] == pytest.approx(look["y"], abs=2)
    assert edit["x"] + edit["width"] <= look["x"]
    assert min(edit["width"], look["width"]) > 300
    tree = page.locator(".fuzzy-editor").get_by_role("tree", name="System")
    assert not tree.is_visible()
    page.locator(".fuzzy-editor summary").click()
    tree.wait_for()
    page.locator(".fuzzy-editor summary").click()

    # In its command mode they are the notebook's: cut, delete, undo, insert, restart, interrupt.
    press(page, handle, "x", "d", "d", "z", "a", "b", "0", "0", "i", "i")
    assert cells(page) == len(CELLS)
    play.scroll_into_view_if_needed()
    press(page, play, "x", "d", "d", "z", "a", "b", "0", "0", "i", "i")
    assert cells(page) == len(CELLS)
    assert page.get_by_role("dialog").count() == 0

    # The arrows are the widget's, and so is undo.
    press(page, handle, "ArrowRight")
    until(page, "0.51")
    press(page, handle, "Control+z")
    until(page, "0.5")
    press(page, handle, "Control+Shift+z")
    until(page, "0.51")
    assert cells(page) == len(CELLS)

    # What is dragged is another value in Python.
    handle.scroll_into_view_if_needed()
    box = handle.bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 30, y, steps=6)
    page.mouse.up()
    page.wait_for_function(
        "() => Number(document.querySelector(\"[aria-label='near: peak']\").getAttribute('aria-valuenow')) > 0.55"
    )
    dragged = float(handle.get_attribute("aria-valuenow"))
    again = page.locator(".jp-Notebook .jp-CodeCell").nth(len(CELLS) - 1)
    again.locator(".cm-content").click()
    page.keyboard.press("Control+Enter")
    page.get_by_text(re.compile(rf"the peak is \[0\.0, {re.escape(str(dragged))}\d*, 1\.2\]")).wait_for()
    # The editor's cell is run again: what was dragged is still there, and it is said.
    page.locator(".jp-Notebook .jp-CodeCell").first.locator(".cm-content").click()
    page.keyboard.press("Control+Enter")
    page.locator(".fuzzy-editor [role=status]", has_text="Kept from before").wait_for()
    assert handle.get_attribute("aria-valuenow") == str(dragged)
    slider = page.locator(".fleet-player input[type=range]").first
    slider.scroll_into_view_if_needed()
    bar = slider.bounding_box()
    page.mouse.click(bar["x"] + bar["width"] / 2, bar["y"] + bar["height"] / 2)
    page.wait_for_timeout(1000)  # until Python has been told
    shown = float(slider.input_value())
    assert 5 < shown < 20
    again.locator(".cm-content").click()
    page.keyboard.press("Control+Enter")
    page.get_by_text(re.compile(rf"the time {re.escape(f'{shown:.2f}'.rstrip('0').rstrip('.'))}")).wait_for()

    # Ctrl+S is the notebook's from a widget too; what it saves shows stills where no kernel runs.
    press(page, handle, "Control+s")
    page.wait_for_selector(".jp-mod-dirty", state="detached")
    saved = (folder / "widgets.ipynb").read_text(encoding="utf-8")
    bundles = [cell["outputs"][0]["data"] for cell in json.loads(saved)["cells"][:2]]
    assert ["".join(bundle["text/plain"]) for bundle in bundles] == STILL
    for bundle in bundles:
        picture = b64decode(bundle["image/png"])
        assert picture.startswith(b"\x89PNG")
        wide, high = struct.unpack(">II", picture[16:24])
        assert min(wide, high) > 100
    # One that was sent to somebody else: not trusted, as the server knows no signature of it.
    (folder / "saved.ipynb").write_text(saved.replace("the peak", "The peak"), encoding="utf-8")
    page.goto(f"{url}saved.ipynb?reset")
    pictures = page.locator(".jp-Notebook .jp-OutputArea-output img[src^='data:image/png']")
    for k in range(2):
        pictures.nth(k).wait_for()
    page.close()
