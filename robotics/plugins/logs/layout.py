"""A Foxglove layout for the log of a run: the scene in 3D, curves over time, modes and rules, and what is said.

It is the JSON that Foxglove and Lichtblick export and import: a configuration for each panel by its name and number,
and a tree that shares out the window.
"""

import json
from itertools import permutations
from pathlib import Path
from typing import Any

from fuzzy.figures.palette import COLORS
from fuzzy.files.atomic import write_json
from robotics.plugins.logs.names import INFO, MAP, SCENE, Names, firing, rule_base
from robotics.simulation.run import Run

MOST_ROBOTS = 6  # whose curves are drawn: more are no picture any more
_MOST_RULES = 12  # whose shares are drawn of a rule base, of the first robot


def layout_of(run: Run) -> dict[str, Any]:
    """The layout for the log of ``run``, in JSON's types."""
    count = len(run.about.robots)
    robots = [Names.of(i, count) for i in range(1, count + 1)]
    drawn, first = robots[:MOST_ROBOTS], robots[0].topic("state")
    panels: dict[str, dict[str, Any]] = {
        "3D!scene": _scene(robots),
        "Plot!speed": _plot("Speed [m/s]", _curves(drawn, ("v", "v_demand"))),
        "Plot!turn": _plot("Turn rate [rad/s]", _curves(drawn, ("w", "w_demand"))),
        # Of the first robot alone: the curves of such a panel share their x
        "Plot!track": _plot(
            "Track [m]",
            [(f"{first}.y", _label(robots[0], "y over x"))],
            xAxisVal="custom",
            xAxisPath={"value": f"{first}.x", "enabled": True},
        ),
    }
    states = [_path(f"{names.topic('state')}.mode", _label(names, "mode")) for names in drawn if run.modes is not None]
    bases = run.about.rule_bases if run.inputs is not None and run.about.rule_bases else {}
    for task in bases:
        states += [_path(f"{firing(names, task)}.strongest_rule", _label(names, task)) for names in drawn]
    if states:
        panels["StateTransitions!modes"] = {"paths": states, "isSynced": True}
    for k, (task, system) in enumerate(bases.items()):
        if k < 2:
            rules = range(min(len(system.rules), _MOST_RULES))
            shares = [(f"{firing(robots[0], task)}.shares[{n}]", f"rule {n + 1}") for n in rules]
            panels[f"Plot!rules{k}"] = _plot(f"Shares of the rules: {task}", shares)
    if run.message_ages is not None and count > 1:
        pairs = [(drawn[i], j) for i, j in permutations(range(min(count, 3)), 2)]
        ages = [(f"{a.topic('radio_ages')}.age[{j}]", f"{a.namespace} of robot {j + 1}") for a, j in pairs]
        panels["Plot!ages"] = _plot("Age of what was heard [s]", ages)
    panels["RawMessages!about"] = _preset("RawMessages", topicPath=rule_base(next(iter(bases))) if bases else INFO)
    panels["RawMessages!state"] = _preset("RawMessages", topicPath=first)
    layout = {
        "direction": "row",
        "first": _column(["3D!scene", "Plot!track"], 60),
        "second": _column([name for name in panels if name not in ("3D!scene", "Plot!track")]),
        "splitPercentage": 50,
    }
    return _preset("window", configById=panels, layout=layout)


def _preset(kind: str, **settings: Any) -> dict[str, Any]:
    """A panel of that kind, or the window: what ``panels.json`` always says of it, with these settings."""
    text = Path(__file__).with_name("panels.json").read_text(encoding="utf-8")
    return dict(json.loads(text)[kind]) | settings


def write_layout(run: Run, path: str | Path) -> None:
    """Write the layout of Foxglove for the log of a run, whole or not at all.

    Args:
        run: The run.
        path: The .json file.

    Raises:
        OSError: The file cannot be written.
    """
    write_json(path, layout_of(run))


def _scene(robots: list[Names]) -> dict[str, Any]:
    """The panel 3D: seen from above, all that stands and moves."""
    topics: dict[str, Any] = {SCENE: {"visible": True}}
    for i, names in enumerate(robots):
        colour = COLORS[i % len(COLORS)]
        topics[names.topic("path")] = {"visible": True, "type": "line", "lineWidth": 0.015, "gradient": [colour] * 2}
        topics[names.topic("odom")] = {"visible": False}
    return _preset("3D", followTf=MAP, topics=topics)


def _plot(title: str, curves: list[tuple[str, str]], **more: str | dict[str, Any]) -> dict[str, Any]:
    """A panel Plot of curves: the path of a number, and what it is called."""
    always = {"enabled": True, "timestampMethod": "receiveTime"}
    paths = [
        {"value": value, "label": label, **always, "color": COLORS[k % len(COLORS)]}
        for k, (value, label) in enumerate(curves)
    ]
    synced = {"paths": paths, "isSynced": "xAxisPath" not in more, "foxglovePanelTitle": title}
    return _preset("Plot", **synced, **more)


def _curves(robots: list[Names], fields: tuple[str, ...]) -> list[tuple[str, str]]:
    return [(f"{names.topic('state')}.{field}", _label(names, field)) for names in robots for field in fields]


def _path(value: str, label: str) -> dict[str, str]:
    return {"value": value, "label": label, "timestampMethod": "receiveTime"}


def _label(names: Names, what: str) -> str:
    return f"{names.namespace.removeprefix('/')} {what}".strip()


def _column(panels: list[str], share: float | None = None) -> Any:
    """Panels one above the other, equally high, or the first by its ``share`` in percent."""
    if len(panels) == 1:
        return panels[0]
    percent = round(100 / len(panels), 1) if share is None else share
    return {"direction": "column", "first": panels[0], "second": _column(panels[1:]), "splitPercentage": percent}
