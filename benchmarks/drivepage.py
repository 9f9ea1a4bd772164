"""How fast does the page follow on which a rule base drives in the browser (``docs/interactive/drive.md``)?

What rules say of the turn rate is dragged on a screen as wide as a phone's, 390 px, a step at a time: from the
pointer's event until the page holds the path that the rules then drive. Then it is dragged from frame to frame: so many
frames a second. Beside the times stands the processor time of a step in the page's process, which a busy machine does
not stretch.

Run ``python -m benchmarks.drivepage [--json]``.
"""

import tempfile
from importlib.util import module_from_spec, spec_from_file_location
from itertools import pairwise
from pathlib import Path
from statistics import median
from typing import Any

from benchmarks.designersession import browser, grip, missing
from benchmarks.reporting import heading, machine, start

STEPS, WARM, FRAMES = 40, 5, 120
AIM = 32.0  # ms
SCREEN = {"width": 390, "height": 844}
VARIABLE, HANDLE = "w", "Positive: value"
_PATH = ".drive-top svg path.drive-line"
_STEP = """(path) => {
  window.arrived = new Promise((done) => {
    addEventListener("pointermove", () => {
      const began = performance.now();
      const watch = new MutationObserver(() => {
        watch.disconnect();
        done(performance.now() - began);
      });
      for (const node of document.querySelectorAll(path)) watch.observe(node, { attributeFilter: ["d"] });
    }, { once: true, capture: true });
  });
}"""
_FRAMES = """([frames, x, y]) => new Promise((done) => {
  const grip = document.activeElement, times = [];
  const move = (at) => {
    times.push(at);
    if (times.length > frames) return done(times);
    const to = { pointerId: 1, bubbles: true, clientX: x - 4 - (times.length % 12), clientY: y };
    grip.dispatchEvent(new PointerEvent("pointermove", to));
    requestAnimationFrame(move);
  };
  requestAnimationFrame(move);
})"""


def measure() -> dict[str, Any]:
    """Every number of the report, by name; or only why there is none."""
    about = machine(["playwright"])
    why = missing()
    if why is not None:
        return about | {"skipped": why}
    import psutil

    folder = Path(__file__).parent.parent / "docs" / "interactive"
    found = spec_from_file_location("interactive", folder / "interactive.py")
    assert found is not None
    assert found.loader is not None
    module = module_from_spec(found)
    found.loader.exec_module(module)
    with tempfile.TemporaryDirectory() as place, browser() as opened:
        file = Path(place) / "page.html"
        head = (
            '<!doctype html><html lang="en"><meta charset="utf-8"><meta name="viewport" content="width=device-width">'
        )
        file.write_text(f"{head}<title>t</title><body>{module.driving()}</body></html>", encoding="utf-8")
        about["versions"]["Chromium"] = opened.version
        page = opened.new_page(viewport=SCREEN)
        page.goto(file.as_uri())
        page.wait_for_selector(".drive[data-ready]")
        session = page.context.new_cdp_session(page)
        session.send("Performance.enable", {"timeDomain": "threadTicks"})
        page.get_by_role("button", name=VARIABLE, exact=True).click()
        handle = page.get_by_role("slider", name=HANDLE, exact=True)
        handle.scroll_into_view_if_needed()
        x, y = grip(page, handle)
        times, costs = [], []
        for step in range(WARM + STEPS):
            page.wait_for_timeout(300)  # the link has been kept by then
            page.evaluate(_STEP, _PATH)
            before = _busy(session)
            page.mouse.move(x - 4 - 2 * (step % 12 if step % 24 < 12 else 12 - step % 12), y)
            taken = page.evaluate("arrived")
            if step >= WARM:
                times.append(taken)
                costs.append(1e3 * (_busy(session) - before))
        at = page.evaluate(_FRAMES, [FRAMES, x, y])
        page.mouse.up()
    gaps = sorted(b - a for a, b in pairwise(at))
    ranked = sorted(times)
    return about | {
        "load_average": psutil.getloadavg()[0],
        "processors": psutil.cpu_count(),
        "latency_ms": {"median": median(ranked), "p95": ranked[round(0.95 * (len(ranked) - 1))], "least": ranked[0]},
        "page_processor_ms": median(costs),
        "frames_per_second": 1e3 * len(gaps) / (at[-1] - at[0]),
        "frame_ms_p95": gaps[round(0.95 * (len(gaps) - 1))],
    }


def _busy(session: Any) -> float:
    """Processor time [s] that the page's thread has spent on tasks."""
    found = session.send("Performance.getMetrics")["metrics"]
    return float(next(each["value"] for each in found if each["name"] == "TaskDuration"))


def report(result: dict[str, Any]) -> str:
    """The result as a table, beside what we aim for."""
    if "skipped" in result:
        return f"{heading(result)}\n\n{result['skipped']}"
    row, busy = result["latency_ms"], f"load {result['load_average']:.1f} on {result['processors']} processors"
    lines = [
        heading(result),
        "",
        f"From the mouse's move to the path, ms, {STEPS} moves (aim: 95 % below {AIM:g}; {busy})",
    ]
    lines.append(f"  median {row['median']:.1f}, p95 {row['p95']:.1f}, least {row['least']:.1f}")
    lines.append(f"  processor time of the page for a step: {result['page_processor_ms']:.1f} ms")
    frames = f"{result['frames_per_second']:.0f} frames a second, 95 % within {result['frame_ms_p95']:.1f} ms"
    return "\n".join([*lines, f"Dragged in each of {FRAMES} frames: {frames}"])


if __name__ == "__main__":
    start(__doc__, measure, report)
