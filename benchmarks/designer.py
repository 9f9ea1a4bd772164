"""How fast does the designer follow the hand? Measured in a real browser, on the tracking rule base (16 rules).

A vertex of a membership function is dragged by the mouse in steps; each time counts from the pointer's event until the
page holds the new picture, which the frame then under way shows: the curve itself, the firing bars of the viewer, the
surface, the path of a robot that drives for 22 s, the figures and paths of a team of three, one of which drives into a
trap (55 s), and the step response of a fuzzy PD. One step is made when the one before has arrived and the page is
still. Beside the times stand those that the server and its workers spend computing for a step (processor time), which a
busy machine does not stretch; there is none for the curve, which needs no server. Page load is from the address to the
first picture, with an empty cache.

Then 300 drags of five moves each beside the robot's path: heap, nodes and listeners must not grow.

With 500 rules the longest stalls are measured too, see ``benchmarks/designerrules.py``.

Run ``python -m benchmarks.designer [--json]``.
"""

import tempfile
from pathlib import Path
from statistics import median
from typing import Any

from benchmarks import designerrules
from benchmarks.designersession import browser, grip, missing, served, show, tab, workplace
from benchmarks.reporting import heading, machine, start

MOVES, WARM, LOADS, DRAGS = 40, 5, 5, 300
AIM = 100.0  # ms
TERM, HANDLE = "Far", "Far: right foot"

# What is looked at for a change: elements and their attribute, few enough that reading them costs nothing
WATCHED = {
    "curve": (".fd-terms .fd-curves path", "d"),
    "firing bars": (".fd-viewer .fd-firing", "width"),
    "surface": (".fd-surface path.fd-section", "d"),
    "robot's path": (".fd-tryout path[data-run=tried]", "d"),
    "team's paths": (
        ".fd-tryout .tr-metrics td",
        "",
    ),  # the table's text: the player's canvas is drawn in the same frame
    "step response": (".fd-step path.st-design", "d"),
}
VIEWS = {
    "curve": "Surface",
    "firing bars": "Surface",
    "surface": "Surface",
    "robot's path": "Try it",
    "team's paths": "Try it",
    "step response": "Step response",
}
STEP_FILE, STEP_TERM, STEP_HANDLE = "pd.fis", "ZE", "ZE: right foot"
TEAM = "trap-u"  # 55 s; the term under the hand matters there

# From a pointer's move until the watched part of the page is another; for the bars, those that Python computed.
_WATCH = """([selector, attribute]) => {
  window.arrived = null;
  const read = (node) => (attribute ? node.getAttribute(attribute) : node.textContent);
  const look = () => Array.from(document.querySelectorAll(selector), read).join();
  window.rest = async () => {  // until what followed from the step before is there: it is not the next one's
    for (let still = 0, last = look(); still < 4; ) {
      await new Promise((done) => setTimeout(done, 60));
      const now = look();
      still = now === last ? still + 1 : 0;
      last = now;
    }
  };
  window.measure = () => {
    const before = look();
    window.arrived = new Promise((done) => {
      addEventListener("pointermove", () => {
        const began = performance.now();
        // Looked at when something on the page has changed, not in every frame: looking must not slow down what it
        // looks at. Pictures are drawn as a frame begins, which then shows them.
        const watch = new MutationObserver(() => {
          if (look() === before) return;
          watch.disconnect();
          clearTimeout(late);
          done(performance.now() - began);
        });
        const late = setTimeout(() => { watch.disconnect(); done(null); }, 20000);
        const what = attribute ? { attributeFilter: [attribute] } : { characterData: true };
        watch.observe(document.body, { subtree: true, childList: true, ...what });
      }, { once: true, capture: true });
    });
  };
}"""


def drag(
    page: Any, watched: tuple[str, str], processes: list[Any], named: str = HANDLE
) -> tuple[list[float], list[float]]:
    """The times [ms] from move to picture, and the server's processor times [ms], a step each."""
    handle = page.get_by_role("slider", name=named)
    handle.scroll_into_view_if_needed()
    page.evaluate(_WATCH, list(watched))
    x, y = grip(page, handle)
    times, costs = [], []
    for step in range(WARM + MOVES):
        page.evaluate("rest()")
        page.evaluate("measure()")
        before = _processor_time(processes)
        # To and fro, always far enough for another number
        page.mouse.move(x - 4 - 3 * (step % 12 if step % 24 < 12 else 12 - step % 12), y)
        taken = page.evaluate("arrived")
        if taken is None:
            raise RuntimeError(f"{watched[0]} did not follow the mouse")
        if step >= WARM:
            times.append(float(taken))
            costs.append(1e3 * (_processor_time(processes) - before))
    page.mouse.up()
    page.keyboard.press("Control+z")
    page.wait_for_selector(".state:not(.unsaved)")
    return times, costs


def steady(page: Any) -> list[dict[str, float]]:
    """Heap [MB], nodes and listeners of the page after each hundred of many drags, garbage collected."""
    session = page.context.new_cdp_session(page)
    session.send("Performance.enable")
    handle = page.get_by_role("slider", name=HANDLE)
    found = []
    for k in range(DRAGS + 1):
        if k % (DRAGS // 3) == 0:
            page.wait_for_timeout(2000)
            session.send("HeapProfiler.collectGarbage")
            values = {each["name"]: each["value"] for each in session.send("Performance.getMetrics")["metrics"]}
            row = {"drags": k, "heap_mb": values["JSHeapUsedSize"] / 1e6}
            found.append(row | {"nodes": values["Nodes"], "listeners": values["JSEventListeners"]})
        x, y = grip(page, handle)
        for step in range(1, 6):
            page.mouse.move(x + (step if k % 2 else -step), y)
        page.mouse.up()
    return found


def _processor_time(processes: list[Any]) -> float:
    """User and system time [s] of the server and its workers."""
    total = 0.0
    for process in processes:
        for each in [process, *process.children(recursive=True)]:
            spent = each.cpu_times()
            total += spent.user + spent.system
    return total


def measure() -> dict[str, Any]:
    """Every number of the report, by name; or only why there is none."""
    about = machine(["nicegui", "numpy", "numba", "playwright"])
    why = missing()
    if why is not None:
        return about | {"skipped": why}
    import psutil

    with tempfile.TemporaryDirectory() as folder:
        workplace(Path(folder))
        with served(Path(folder), "tracking.fis") as (url, number), browser() as opened:
            about["versions"]["Chromium"] = opened.version
            load = []
            for _ in range(LOADS):
                with opened.new_context(viewport={"width": 1600, "height": 1000}) as context:
                    page = context.new_page()
                    show(page, url)
                    load.append(page.evaluate("performance.now()"))
            page = opened.new_page(viewport={"width": 1600, "height": 1000})
            show(page, url)
            page.get_by_role("treeitem", name=TERM, exact=False).get_by_text(TERM, exact=True).first.click()
            times, costs = {}, {}
            for name, watched in WATCHED.items():
                if name == "step response":
                    show(page, f"{url}&file={STEP_FILE}")
                    page.get_by_role("treeitem").get_by_text(STEP_TERM, exact=True).first.click()
                tab(page, VIEWS[name])
                page.wait_for_selector(watched[0], state="attached")
                if name == "team's paths":
                    page.locator(".fd-tryout details.pn-line").evaluate("(sheet) => { sheet.open = true; }")
                    page.get_by_label("Scenario", exact=True).select_option(TEAM)
                    page.locator(".fd-tryout details.pn-line").evaluate("(sheet) => { sheet.open = false; }")
                    page.wait_for_selector(".fd-tryout .fp-root")
                if VIEWS[name] == "Try it":  # until all of its runs are there
                    page.wait_for_function("document.querySelectorAll('.fd-tryout thead th').length >= 4")
                page.wait_for_timeout(500)
                named = STEP_HANDLE if name == "step response" else HANDLE
                times[name], costs[name] = drag(page, watched, [psutil.Process(number)], named)
            show(page, url)
            page.get_by_role("treeitem", name=TERM, exact=False).get_by_text(TERM, exact=True).first.click()
            tab(page, "Try it")
            page.wait_for_selector(WATCHED["robot's path"][0], state="attached")
            drags = steady(page)
            load_average = psutil.getloadavg()[0]
    return about | {
        "moves": MOVES,
        "load_average": load_average,
        "processors": psutil.cpu_count(),
        "page_load_ms": {"median": median(load), "most": max(load)},
        "latency_ms": {name: _summary(values) for name, values in times.items()},
        "server_processor_ms": {name: _summary(values) for name, values in costs.items()},
        "drags": drags,
        "many_rules": designerrules.measured(),
    }


def _summary(values: list[float]) -> dict[str, float]:
    ranked = sorted(values)
    high = ranked[min(len(ranked) - 1, round(0.95 * len(ranked)))]
    return {"median": median(ranked), "p95": high, "least": ranked[0]}


def report(result: dict[str, Any]) -> str:
    """The result as a table, beside what we aim for."""
    if "skipped" in result:
        return f"{heading(result)}\n\n{result['skipped']}"
    lines = [heading(result), ""]
    busy = f"load {result['load_average']:.1f} on {result['processors']} processors"
    lines.append(f"From the mouse's move to the picture, ms, {result['moves']} moves (aim: below {AIM:g}; {busy})")
    lines.append(f"  {'':14}{'median':>8}{'p95':>8}{'least':>8}{'server':>10}")
    for name, row in result["latency_ms"].items():
        cost = result["server_processor_ms"][name]["median"]
        lines.append(f"  {name:14}{row['median']:>8.1f}{row['p95']:>8.1f}{row['least']:>8.1f}{cost:>10.1f}")
    load = result["page_load_ms"]
    lines += ["", "server: processor time of the server and its workers for a step, autosave and all views included"]
    lines += [f"Page load: median {load['median']:.0f} ms, most {load['most']:.0f} ms"]
    for row in result["drags"]:
        said = f"heap {row['heap_mb']:.1f} MB, {row['nodes']:.0f} nodes, {row['listeners']:.0f} listeners"
        lines.append(f"After {row['drags']:.0f} drags: {said}")
    lines += ["", *designerrules.section(result["many_rules"])]
    return "\n".join(lines)


if __name__ == "__main__":
    start(__doc__, measure, report)
