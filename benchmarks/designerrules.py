"""Does the designer stall with 500 rules? The longest time in a real browser in which it answers nothing, by action.

A system of four inputs with five terms each has 500 rules. A stall is what the browser calls a long task (longer than
50 ms), or the time from an event, such as a click or a move of the mouse, to the picture after it, whichever is longer.
Both are recorded until all that follows from the action has been drawn.

Run ``python -m benchmarks.designerrules [--json]``; ``python -m benchmarks.designer`` prints it too.
"""

import tempfile
from collections.abc import Callable
from itertools import islice, product
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from benchmarks.designersession import browser, grip, missing, served, show, tab
from benchmarks.reporting import heading, machine, start
from fuzzy.files.fisfile import write_fis
from fuzzy.membership import Triangle
from fuzzy.system import Sugeno, Variable

RULES, REPEATS = 500, 3
AIM = 100.0  # ms
MOVES = 20  # of a drag
QUIET = 700  # ms without a long task after which an action is over

_RECORD = """() => {
  window.stalls = { tasks: [], events: [] };
  const observe = (type, list, more) => new PerformanceObserver((entries) => {
    for (const entry of entries.getEntries()) list.push([entry.startTime, entry.duration]);
  }).observe({ type, buffered: false, ...more });
  observe("longtask", stalls.tasks);
  observe("event", stalls.events, { durationThreshold: 16 });
  // The browser keeps no record of these.
  for (const name of ["pointermove", "wheel", "change", "input"])
    addEventListener(name, ({ timeStamp }) => requestAnimationFrame(() => setTimeout(() => {
      stalls.events.push([timeStamp, performance.now() - timeStamp]);
    })), { capture: true, passive: true });
}"""
_LONGEST = """async ([since, quiet]) => {
  const last = () => Math.max(since, ...stalls.tasks.map(([start, took]) => start + took));
  while (performance.now() - last() < quiet) await new Promise((done) => setTimeout(done, 50));
  const longest = (list) => Math.max(0, ...list.filter(([start]) => start >= since).map(([, took]) => took));
  return [longest(stalls.tasks), longest(stalls.events)];
}"""


def system(rules: int = RULES) -> Sugeno:
    """Four inputs of five terms, and a rule for each of the first combinations."""
    at = np.linspace(0.0, 1.0, 5)
    names = ("lowest", "low", "middle", "high", "highest")
    terms = {name: Triangle(float(x) - 0.25, float(x), float(x) + 0.25) for name, x in zip(names, at, strict=True)}
    inputs = [Variable(name, (0.0, 1.0), terms) for name in ("distance", "bearing", "speed", "slope")]
    output = Variable("force", (0.0, 8.0), {f"f{k}": float(k) for k in range(9)})
    sentences = []
    for combination in islice(product(range(5), repeat=4), rules):
        asked = " and ".join(f"{v.name} is {names[k]}" for v, k in zip(inputs, combination, strict=True))
        sentences.append(f"if {asked} then force is f{sum(combination) // 2}")
    return Sugeno(inputs, [output], sentences, name="many")


def _form(page: Any, name: str) -> None:
    page.locator(f".fd-rules .fd-tab[data-view={name}]").click()


def _add(page: Any) -> None:
    page.get_by_role("button", name="Add rule").click()


def _filter(page: Any) -> None:
    page.get_by_label("find rules").press_sequentially("high", delay=30)


def _select_all(page: Any) -> None:
    page.get_by_label("select all rules").check()


def _sort(page: Any) -> None:
    page.get_by_label("sort").select_option("firing")


def _drag(page: Any) -> None:
    """Drag a red line of the viewer, beside which the rules are."""
    _slide(page, page.locator(".fd-viewer").get_by_role("slider").first, -2)


def _drag_term(page: Any) -> None:
    """Drag a vertex of a membership function, beside the viewer."""
    _slide(page, page.locator(".fd-terms [role=slider]").nth(1), 2)


def _slide(page: Any, handle: Any, by: float) -> None:
    """Drag ``handle`` by so much [px] a move."""
    x, y = grip(page, handle)
    for step in range(1, MOVES + 1):
        page.mouse.move(x + by * step, y)
        page.wait_for_timeout(30)
    page.mouse.up()


def _fill(page: Any) -> None:
    """Drag over a row of the matrix."""
    page.get_by_role("radio", name="f3", exact=True).click()
    first, last = (page.locator(f"[data-cell='2,{column}']").bounding_box() for column in (0, 4))
    page.mouse.move(first["x"] + 20, first["y"] + 20)
    page.mouse.down()
    page.mouse.move(last["x"] + 20, last["y"] + 20, steps=8)
    page.mouse.up()


def _undo(page: Any) -> None:
    page.keyboard.press("Control+z")


def _sentences(page: Any) -> None:
    _form(page, "sentences")


def _scroll(page: Any) -> None:
    page.locator(".fd-rules .fd-list").hover()
    for _ in range(10):
        page.mouse.wheel(0, 1500)
        page.wait_for_timeout(40)


# What is measured, in this order: the action, and what leads back to where it began, which is not measured
_ACTIONS: tuple[tuple[str, Callable[[Any], None], Callable[[Any], None] | None], ...] = (
    ("drag a term beside the viewer", _drag_term, _undo),
    ("open the tab Rules", lambda page: tab(page, "Rules"), lambda page: tab(page, "Memberships")),
    ("add a rule", _add, _undo),
    ("scroll through the rules", _scroll, lambda page: page.mouse.wheel(0, -30000)),
    ("filter", _filter, lambda page: page.get_by_label("find rules").fill("")),
    ("sort by strength now", _sort, lambda page: page.get_by_label("sort").select_option("")),
    ("select all", _select_all, lambda page: page.get_by_label("select all rules").uncheck()),
    ("drag a line of the viewer", _drag, None),
    ("open the table", lambda page: _form(page, "table"), _sentences),
    ("scroll through the table", _scroll, lambda page: page.mouse.wheel(0, -30000)),
    ("open the matrix", lambda page: _form(page, "matrix"), _sentences),
    ("fill a row of the matrix", _fill, _undo),
    ("drag a line beside the matrix", _drag, None),
)


def _before(page: Any, name: str) -> None:
    """Bring the page to where an action begins."""
    if name != "drag a term beside the viewer" and name != "open the tab Rules":
        if page.get_by_role("tab", name="Rules", exact=True).get_attribute("aria-selected") != "true":
            tab(page, "Rules")
        form = "matrix" if "of the matrix" in name or "beside the matrix" in name else "sentences"
        _form(page, "table" if "through the table" in name else form)


def stalls(page: Any) -> dict[str, dict[str, float]]:
    """The longest stalls [ms] of each action over some repetitions, on a page of the designer with the system."""
    page.evaluate(_RECORD)
    result = {}
    for name, action, back in _ACTIONS:
        tasks, events = [], []
        for _ in range(REPEATS):
            _before(page, name)
            page.evaluate(_LONGEST, [page.evaluate("performance.now()"), QUIET])
            since = page.evaluate("performance.now()")
            action(page)
            task, event = page.evaluate(_LONGEST, [since, QUIET])
            tasks.append(float(task))
            events.append(float(event))
            if back is not None:
                back(page)
                page.wait_for_timeout(300)
        both = [max(pair) for pair in zip(tasks, events, strict=True)]
        result[name] = {"longest": max(both), "median": median(both), "task": max(tasks), "event": max(events)}
    return result


def measured() -> dict[str, Any]:
    """The stalls with 500 rules, in a designer and a browser of their own."""
    import psutil

    with tempfile.TemporaryDirectory() as folder:
        write_fis(system(), Path(folder) / "many.fis")
        with served(Path(folder), "many.fis") as (url, _), browser() as opened:
            version = opened.version
            page = opened.new_page(viewport={"width": 1600, "height": 1000})
            show(page, url)
            load, found = psutil.getloadavg()[0], stalls(page)
    about = {"load_average": load, "processors": psutil.cpu_count(), "chromium": version}
    return {"rules": RULES, **about, "stalls_ms": found}


def measure() -> dict[str, Any]:
    """Every number of the report, by name; or only why there is none."""
    about = machine(["nicegui", "numpy", "numba", "playwright"])
    why = missing()
    if why is not None:
        return about | {"skipped": why}
    found = measured()
    about["versions"]["Chromium"] = found["chromium"]
    return about | found


def section(result: dict[str, Any]) -> list[str]:
    """The lines of the report below its heading."""
    busy = f"load {result['load_average']:.1f} on {result['processors']} processors"
    lines = [f"{result['rules']} rules: the longest stall, ms, of {REPEATS} each (aim: below {AIM:g}; {busy})"]
    lines.append(f"  {'':32}{'longest':>8}{'median':>8}{'task':>8}{'event':>8}")
    for name, row in result["stalls_ms"].items():
        numbers = "".join(f"{row[key]:>8.0f}" for key in ("longest", "median", "task", "event"))
        lines.append(f"  {name:32}{numbers}")
    return lines


def report(result: dict[str, Any]) -> str:
    """The result as a table, beside what we aim for."""
    if "skipped" in result:
        return f"{heading(result)}\n\n{result['skipped']}"
    lines = [heading(result), "", *section(result), ""]
    lines.append("task: without an answer to anything; event: from a click, key or move to the picture after it")
    return "\n".join(lines)


if __name__ == "__main__":
    start(__doc__, measure, report)
