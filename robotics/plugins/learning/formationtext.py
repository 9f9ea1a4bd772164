"""The text of a scenario's file for a formation of one's own: a leader on any path, followers in a wedge or abreast."""

import json
import re
from dataclasses import dataclass
from math import ceil, pi
from pathlib import Path as FilePath
from typing import Any, Literal

from fuzzy.errors import InputError
from fuzzy.naming import check_known, expected
from fuzzy.quantity import check_quantities, described, quantity, whole
from robotics.simulation.scenario.description import ScenarioError
from robotics.simulation.scenario.reading import scenario_from_table
from robotics.tables.template import toml_value
from robotics.tables.text import parse_table, read_text
from robotics.world.paths.path import SHAPES

_SPARE = 1.25  # the scenario's duration over that of its timing: the leader waits for followers at times
_PART = re.compile(r"\s*(\w+)\s*=\s*([^,]+?)\s*")


@dataclass(frozen=True, kw_only=True)
class FormationPlan:
    """What a formation is made of. Raises ScenarioError for numbers out of their ranges."""

    amplitude: float = quantity(0.5, "m", least=0, doc="Amplitude of the leader's sine.")
    wavelength: float = quantity(6.0, "m", above=0, doc="Wavelength of the leader's sine, of which it drives two.")
    path: str = described("Path in its place: circle:radius=2, eight:width=8, or a .toml file's.", "")
    followers: int = whole(2, least=1, most=30, doc="Number of followers.")
    spacing: float = quantity(0.6, "m", above=0, doc="Spacing of the rows, and of the robots in a row.")
    speed: float = quantity(0.2, "m/s", above=0, doc="Speed of the leader.")
    arrangement: Literal["wedge", "abreast"] = described("The shape of the formation.", "wedge")

    def __post_init__(self) -> None:
        check_quantities(self, ScenarioError)
        check_known(self.arrangement, ("wedge", "abreast"), "arrangement", ScenarioError)

    @property
    def offsets(self) -> list[tuple[float, float]]:
        """The places of all robots, the leader first: m ahead of it, and to its left."""
        rows = [(k // 2 + 1, 1 if k % 2 == 0 else -1) for k in range(self.followers)]
        back = self.spacing if self.arrangement == "wedge" else 0.0
        return [(0.0, 0.0), *((-row * back, side * row * self.spacing) for row, side in rows)]


def path_table(specification: str) -> dict[str, Any]:
    """The table of a path "SHAPE:name=number,...", such as "circle:radius=2", or that of the leader of a .toml file.

    Raises ScenarioError.
    """
    if specification.endswith(".toml"):
        table = parse_table(read_text(FilePath(specification), ScenarioError), specification, ScenarioError)
        members = table.get("robots")
        owner = table.get("virtual", members[0] if isinstance(members, list) and members else {})
        if not isinstance(owner, dict) or not isinstance(owner.get("path"), dict):
            raise ScenarioError(f"{specification}: it has no [virtual] and no [[robots]] with a path")
        return dict(owner["path"])
    shape, _, rest = specification.partition(":")
    if shape.strip() not in SHAPES:
        raise ScenarioError(expected(shape.strip(), SHAPES, "path shape") + "; or the path of a .toml file")
    table = {"shape": shape.strip()}
    for part in filter(None, (p.strip() for p in rest.split(","))):
        found = _PART.fullmatch(part)
        if not found:
            raise ScenarioError(f"a path is SHAPE:name=value,name=value, such as circle:radius=2; got {part!r}")
        try:
            table[found[1]] = float(found[2])
        except ValueError:
            table[found[1]] = found[2]
    return table


def formation_text(plan: FormationPlan) -> str:
    """The text of the scenario's file. Raises ScenarioError where it cannot be driven, which names what is wrong."""
    if plan.path:
        path, what = path_table(plan.path), f"on {plan.path}"
    else:
        sine = {"amplitude": plan.amplitude, "wavenumber": 2 * pi / plan.wavelength, "x_end": 2 * plan.wavelength}
        path, what = {"shape": "sine", **sine}, f"on a sine of {plan.amplitude:g} m, {plan.wavelength:g} m long"
    followers = f"{plan.followers} follower{'s' * (plan.followers > 1)}"
    arranged = "in a wedge" if plan.arrangement == "wedge" else "abreast"
    lines = [
        'kind = "formation"',
        f"title = {json.dumps(f'A leader {what}, {followers} {arranged}')}",
        f'source = "robotics dataset formation; {plan.spacing:g} m apart, {plan.speed:g} m/s; noise: 3 mm, 3 mrad"',
        "duration = DURATION",
        'controller = "leader-follower"',
        "",
        "[sensing]",
        'posture = "pose"',
        "position_noise = 0.003",
        "heading_noise = 0.003",
        "",
        "[virtual] # offsets are measured from where this one is: m ahead, m to the left",
        f"path = {toml_value(path)}",
        f"timing = {{ speed = {plan.speed!r} }}",
    ]
    for i, (ahead, left) in enumerate(plan.offsets):
        lines += ["", "[[robots]]" + (" # the leader" if i == 0 else ""), f"offset = [{ahead!r}, {left!r}]"]
    text = "\n".join(lines) + "\n"
    try:
        short = parse_table(text.replace("DURATION", "1.0"), "formation", ScenarioError)
        needed = scenario_from_table(short, "formation").setting.references.ends.max()
    except InputError as error:
        places = ", ".join(f"[{ahead:g}, {left:g}]" for ahead, left in plan.offsets)
        raise ScenarioError(
            f"this formation, with robots at {places} m, cannot be driven: {error}; a smaller spacing, fewer "
            "followers, a wider path or a lower speed may do"
        ) from None
    return text.replace("DURATION", f"{ceil(_SPARE * float(needed) + 5.0):.1f}")
