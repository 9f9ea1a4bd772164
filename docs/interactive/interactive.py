"""The parts of the interactive pages, made before Sphinx reads the sources: a design, and runs in motion.

``write(folder)`` writes HTML fragments into the folder ``made`` there, which no version control keeps. They hold all
that they need, since a page that is opened from a disk may load no module beside it.
"""

import json
import re
import sys
from dataclasses import replace
from pathlib import Path

import fuzzy
import robotics
from fuzzy.esmodule import composed
from fuzzy.figures.palette import stylesheet
from fuzzy.plugins.designer.design import design_of
from fuzzy.plugins.designer.views import design_data, functions_data
from robotics.show.playback.player import player_fragment, player_script

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))
import drive  # noqa: E402, beside this file

STATIC = HERE.parent.parent / "fuzzy" / "plugins" / "designer" / "static"


def system() -> fuzzy.Sugeno:
    """The rule base that is shown."""
    distance = fuzzy.Variable(
        "distance", (0, 2), {"near": fuzzy.LinearZ(0.2, 1.0), "far": fuzzy.LinearS(0.2, 1.0)}, "m"
    )
    sides = {"right": fuzzy.ZShape(-1.2, 0), "ahead": fuzzy.Gaussian(0.35, 0), "left": fuzzy.SShape(0, 1.2)}
    return fuzzy.Sugeno(
        [distance, fuzzy.Variable("bearing", (-1.6, 1.6), sides, "rad")],
        [
            fuzzy.Variable("v", (0, 1), {"creep": 0.1, "cruise": 0.8}, "m/s"),
            fuzzy.Variable("w", (-2, 2), {"turn right": -1.5, "straight": 0, "turn left": 1.5}, "rad/s"),
        ],
        [
            "if distance is far and bearing is ahead then v is cruise",
            "if distance is near or bearing is not ahead then v is creep",
            "if bearing is left then w is 'turn left'",
            "if bearing is ahead then w is straight",
            "if bearing is right then w is 'turn right'",
        ],
        name="go",
        out_of_range="clip",
    )


def values(fis: fuzzy.Sugeno) -> dict[str, object]:
    """What the views show of the rule base at a point where four of its rules fire."""
    design = design_of(fis)
    first = fis.inputs[1].name
    return {
        "design": design_data(design),
        "functions": functions_data(),
        "point": [0.6, 0.4],
        "selected": {"kind": "input", "variable": first, "term": None},
        "problem": None,
        "compared": None,
        "histograms": [],
    }


def themed(css: str) -> str:
    """Style sheets of the packages, whose dark colors come with the site's theme and not with the system's."""
    [(light, dark)] = re.findall(
        r":root, :host \{ (.*?) \}\n@media \(prefers-color-scheme: dark\) \{ :root, :host \{ (.*?) \} \}", stylesheet()
    )
    return f'html[data-theme="light"] {{ {light} }}\nhtml[data-theme="dark"] {{ {dark} }}\n' + css.replace(
        "@media (prefers-color-scheme: dark) {\n  .fd {", 'html[data-theme="dark"] {\n  .fd {'
    )


def _json(value: object) -> str:
    return json.dumps(value).replace("</", "<\\/")


def page(module: str, kind: str, call: str, data: object, more: str = "") -> str:
    """A part of a page that a module of this folder fills, in the designer's looks and ``more``, with its data."""
    looks = themed((STATIC / "designer.css").read_text(encoding="utf-8")) + "\n.alone { margin-bottom: 1.5rem; }"
    looks += "\n.alone .fd input:disabled, .alone .fd select:disabled { opacity: 0.8; border-color: transparent; }"
    script = composed(HERE / module, f'entry.{call}(document.getElementById("part"), {_json(data)});')
    part = f'<div id="part" class="{kind}"></div>'
    return f'<style>{looks}\n{more}</style>\n{part}\n<script type="module">\n{script}</script>\n'


def designer() -> str:
    """The membership and rule views of a small system, as a part of a page."""
    return page("alone.js", "alone", "begin", values(system()))


def driving() -> str:
    """A rule base that steers a robot, as a part of a page."""
    return page("drive.js", "fd drive", "drive", drive.data(), (HERE / "drive.css").read_text(encoding="utf-8"))


def runs() -> list[tuple[str, robotics.Run]]:
    """Three runs with their titles."""
    noise = robotics.Sensing(posture="pose", position_noise=0.003, heading_noise=0.003)
    sine = replace(robotics.load_scenario("lyapunov-sine"), sensing=noise)
    return [
        ("A rule base on a sine", robotics.simulate(sine, "fuzzy", seeds=[1])),
        ("Three paths that cross", robotics.simulate(robotics.load_scenario("three-cross"), "right-of-way", seeds=[1])),
        (
            "Obstacles that nobody knows",
            robotics.simulate(robotics.load_scenario("obstacles-on-two-paths"), "fuzzy-team", seeds=[1]),
        ),
    ]


def players(runs: list[tuple[str, robotics.Run]]) -> str:
    """Runs in motion, as a part of a page."""
    # The site lays its tables out as blocks that scroll; those of a player are as wide as it is.
    room = ".fleet { margin-bottom: 1.5rem; }\n.fleet .fleet-player table { display: table; }"
    for scheme in ("light", "dark"):
        room += f'\nhtml[data-theme="{scheme}"] .fleet-player {{ color-scheme: {scheme}; }}'
    parts = [f"<style>{themed('')}\n{room}</style>"]
    for title, run in runs:
        parts.append(f'<h2>{title}</h2>\n<div class="fleet">{player_fragment(run)}</div>')
    return "\n".join([*parts, player_script()])


def write(folder: Path) -> None:
    """Write the fragments below ``folder``."""
    made = folder / "made"
    made.mkdir(exist_ok=True)
    for name, text in (
        ("designer.html", designer()),
        ("drive.html", driving()),
        ("players.html", players(runs())),
    ):
        (made / name).write_text(text, encoding="utf-8")
