"""The page on which a rule base drives: its C and its WebAssembly drive the simulator's run, and it shows that."""

import ctypes
import json
import re
import shutil
import subprocess
from base64 import b64decode
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fuzzy
import robotics
from fuzzy.esmodule import composed
from fuzzy.plugins.ccode.compiler import CompilerError, find_compiler
from robotics.laws.catalogue import as_law
from robotics.laws.tracking.fuzzy_tracking import load_rule_base
from robotics.simulation.loop import record_run
from robotics.world.vehicle import plant
from tests.browsers import drag, started
from tests.conftest import module_in
from tests.test_site import opened, written

FOLDER = Path(__file__).parent.parent / "docs" / "interactive"
FINE = 1e12  # counts a turn
# law, path, seed, noise [m, rad], latency [s]
CASES = [
    ("tracking", "sine", 1, 0.003, 0.03),
    ("tracking", "circle", 2, 0.02, 0.0),
    ("correcting", "sine", 3, 0.006, 0.04),
    ("lyapunov", "sine", 1, 0.0, 0.02),
]
LATE = [("correcting", "sine", 2, 0.003, 0.15), ("lyapunov", "circle", 3, 0.01, 0.07)]
Drive = Callable[[dict[str, Any], list[Any]], list[Any]]


@pytest.fixture(scope="module")
def page_module() -> Any:
    return module_in(FOLDER / "interactive.py")


@pytest.fixture(scope="module")
def data(page_module: Any) -> dict[str, Any]:
    return json.loads(json.dumps(page_module.drive.data()))


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with started() as found:
        yield found


def simulated(page_module: Any, case: tuple[Any, ...], counts: float | None = None, law: Any = None) -> np.ndarray:
    """x, y, heading (samples, 3) of the simulator's own run."""
    name, path, seed, noise, latency = case
    sensing = robotics.Sensing(posture="pose", position_noise=noise, heading_noise=noise)
    setting = page_module.drive.scenario(path, latency=latency, sensing=sensing).setting
    if counts is not None:
        setting = replace(setting, robots=(replace(setting.robots[0], counts_per_turn=counts),))
    run = record_run(setting, law or as_law(page_module.drive.LAWS[name]), [seed])
    return np.stack([run[channel][0, 0] for channel in ("x", "y", "heading")], axis=1)


def test_the_c_drives_the_simulators_run_to_the_last_bit(
    page_module: Any, data: dict[str, Any], tmp_path: Path
) -> None:
    try:
        command = find_compiler().command
    except CompilerError as error:
        pytest.skip(str(error))
    sources = page_module.drive.written(tmp_path)
    flags = ("-std=c99", "-O1", "-ffp-contract=off", "-shared", "-fPIC", "-I.")
    subprocess.run([*command, *flags, *sources, "-o", "drive.so", "-lm"], cwd=tmp_path, check=True)
    library = ctypes.CDLL(str(tmp_path / "drive.so"))

    def put(name: str, values: Any) -> None:
        (ctypes.c_double * len(values)).in_dll(library, name)[:] = values

    def unpacked(text: str) -> list[float]:
        found: list[float] = np.frombuffer(b64decode(text), "<f8").tolist()
        return found

    put("parameters", data["robot"])
    for case in CASES:
        law, path, seed, noise, latency = case
        for name in ("aims", "ahead", "early"):
            put(name, unpacked(data["paths"][path][name]))
        put("draws", unpacked(data["draws"][str(seed)]))
        put("noise", [noise] * 3)
        if law in data["bases"]:
            put("rules", unpacked(data["bases"][law]["numbers"]))
        start = map(ctypes.c_double, data["paths"][path]["start"])
        library.drive(data["laws"].index(law), round(latency / plant.STEP), *start)
        found = np.array((ctypes.c_double * (3 * data["samples"])).in_dll(library, "trace")).reshape(-1, 3)
        assert np.abs(found - simulated(page_module, case)).max() <= 1e-9, case


RUNS = """async ([data, cases, simulator, packed]) => {
  const sim = await simulator(data);
  return cases.map(([law, path, seed, noise, latency]) => {
    const base = data.bases[law];
    return [...sim.drive(law, { path, seed, noise, latency }, base && packed(base, base.design))];
  });
}"""


def by_node(data: dict[str, Any], cases: list[Any]) -> list[Any]:
    """The runs of the module in Node.js."""
    if shutil.which("node") is None:
        pytest.skip("there is no Node.js")
    script = composed(
        FOLDER / "simulator.js",
        'import { readFileSync } from "node:fs";\nconst [data, cases] = JSON.parse(readFileSync(0, "utf8"));\n'
        f"console.log(JSON.stringify(await ({RUNS})([data, cases, entry.simulator, entry.packed])));",
    )
    line = ["node", "--input-type=module", "-e", script]
    done = subprocess.run(line, input=json.dumps([data, cases]), capture_output=True, text=True, check=True)
    found: list[Any] = json.loads(done.stdout)
    return found


def check_runs(page_module: Any, data: dict[str, Any], drive: Drive) -> None:
    """The runs are the simulator's: within 1e-9 m where encoders count finely, else within what their counts are."""
    robot = list(data["robot"])
    robot[plant.ParameterColumns.count.row] = FINE / (2 * np.pi)
    for given, counts, limit in ((robot, FINE, 1e-9), (data["robot"], None, 1e-3)):
        for case, run in zip([*CASES, *LATE], drive({**data, "robot": given}, [*CASES, *LATE]), strict=True):
            off = np.abs(np.reshape(run, (-1, 3)) - simulated(page_module, case, counts)).max()
            assert off <= limit, f"{case} is {off:.1e} m off: python docs/interactive/drive.py makes the module anew"


def test_the_module_drives_the_simulators_run(page_module: Any, data: dict[str, Any]) -> None:
    check_runs(page_module, data, by_node)


@pytest.mark.long
def test_the_module_drives_the_simulators_run_in_a_browser(
    page_module: Any, data: dict[str, Any], browser: Any, tmp_path: Path
) -> None:
    script = composed(FOLDER / "simulator.js", "Object.assign(window, entry, { ready: true });")
    page, problems = opened(browser, written(tmp_path, "light", f'<script type="module">{script}</script>'))
    page.wait_for_function("window.ready")
    call = f"([data, cases]) => ({RUNS})([data, cases, window.simulator, window.packed])"
    check_runs(page_module, data, lambda data, cases: page.evaluate(call, [data, cases]))
    assert problems == []


@pytest.mark.long
def test_the_module_that_is_kept_is_that_of_the_equations(page_module: Any, tmp_path: Path) -> None:
    said = (
        shutil.which("clang")
        and shutil.which("wasm-ld")
        and subprocess.run(["clang", "--version"], capture_output=True)
    )
    if not said or b"14.0.6" not in said.stdout:
        pytest.skip("the module was made by clang 14.0.6 (Debian 12: apt install clang lld), which is not here")
    assert page_module.drive.build(tmp_path / "drive.wasm").read_bytes() == page_module.drive.WASM.read_bytes()


def off_of(page: Any, law: int) -> tuple[float, float]:
    """What the page says of a law: how far off it is on average, and at most [mm]."""
    found = re.search(r": ([\d.]+) mm, at most ([\d.]+) mm", page.locator(".drive-key > span").nth(law).inner_text())
    assert found
    return float(found[1]), float(found[2])


@pytest.mark.long
@pytest.mark.parametrize(("width", "theme"), [(390, "dark"), (1280, "light")])
def test_what_is_dragged_drives(page_module: Any, browser: Any, tmp_path: Path, width: int, theme: str) -> None:
    file = written(tmp_path, theme, page_module.driving())
    page, problems = opened(browser, file, viewport={"width": width, "height": 900}, accept_downloads=True)
    page.wait_for_selector(".drive[data-ready]")
    assert page.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth") <= 0
    before, others = off_of(page, 0), (off_of(page, 1), off_of(page, 2))
    page.get_by_role("button", name="w", exact=True).click()
    consequent = page.get_by_role("slider", name="Positive: value", exact=True)
    consequent.press("Shift+ArrowLeft")
    page.wait_for_function(
        "(text) => !document.querySelector('.drive-key').innerText.includes(text)", arg=f"{before[0]} mm"
    )
    page.get_by_role("button", name="Play").click()
    page.wait_for_function("parseFloat(document.querySelector('.drive-clock .drive-value').innerText) < 15")
    page.get_by_role("button", name="Pause").click()
    page.get_by_role("button", name="alpha", exact=True).click()
    drag(page, page.get_by_role("slider", name="Big negative: right foot", exact=True), (15, 0), release=True)
    page.get_by_role("slider", name="Latency").press("ArrowRight")
    page.wait_for_function("() => location.hash.includes('latency=40') && /i1\\.0=/.test(location.hash)")
    shown = off_of(page, 0)
    assert (off_of(page, 1), off_of(page, 2)) != others
    axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="it needs axe").Axe()
    found = axe.run(page).response["violations"]
    assert [f["id"] for f in found if f["impact"] in ("serious", "critical")] == []
    # What the page says is what the simulator says of the file that it gives
    with page.expect_download() as download:
        page.get_by_role("link", name="Download tracking.fis").click()
    download.value.save_as(tmp_path / "mine.fis")
    mine, usual = fuzzy.read_fis(tmp_path / "mine.fis"), load_rule_base("tracking")
    assert mine.outputs[1].terms["Positive"] != usual.outputs[1].terms["Positive"]
    assert mine.inputs[1].terms["Big negative"] != usual.inputs[1].terms["Big negative"]
    assert mine.rules == usual.rules
    case = ("tracking", "sine", 1, 0.003, 0.04)
    run = simulated(page_module, case, law=as_law(f"fuzzy:rule_base={tmp_path / 'mine.fis'}"))
    setting = page_module.drive.scenario("sine").setting
    aims = np.stack(setting.references.sampled(setting.times))[:2, :, 0].T
    off = 1000 * np.hypot(*(run[:, :2] - aims).T)[round(10 / setting.period) :]
    assert shown == pytest.approx((off.mean(), off.max()), abs=0.03, rel=0.01)
    # The link keeps it, and a link of nonsense is taken as far as it makes sense
    again = browser.new_page()
    again.goto(page.url)
    again.wait_for_selector(".drive[data-ready]")
    assert off_of(again, 0) == shown
    again.goto(f"{file.as_uri()}#base=__proto__&noise=-1&latency=1e9&i1.2=NaN,1,2&o9.9=1&i0.0=3,2,1")
    again.wait_for_function(
        "(before) => document.querySelector('.drive-key').innerText.includes(before)", arg=f"{before[0]} mm"
    )
    assert off_of(again, 0) == before
    assert problems == []
