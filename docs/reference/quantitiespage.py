"""The page ``docs/reference/quantities.md``: what a robot can know, and what a rule base can say.

``python docs/reference/quantitiespage.py > docs/reference/quantities.md`` makes it of ``quantitiespage.txt`` and of the
tables of :mod:`robotics.laws.rules`.
"""

from collections.abc import Iterable, Mapping
from pathlib import Path
from string import Template

import numpy as np

from fuzzy.words import listed
from robotics.laws.rules import fuzzy_team, own_rules
from robotics.laws.rules.clearances import ABEAM, AHEAD
from robotics.laws.rules.evaluation import ADDED
from robotics.laws.rules.quantities import PATTERNS, QUANTITY_GROUPS, Quantity, quantity_of
from robotics.laws.rules.situation import FARTHEST, NOTHING_NEAR, SIDE_TIME
from robotics.laws.tracking.fuzzy_tracking import TRACKING_INPUTS

_COLUMNS = ("name", "unit", "meaning", "needs")


def page() -> str:
    """The text of the page, in Markdown: ``quantitiespage.txt`` with the tables and numbers that it names."""
    some = {name: quantity_of(name.replace("N_", "1_").replace("SECONDS", "1"), name) for name in PATTERNS}
    named = [(name, *words, _needs(some[name])) for name, words in PATTERNS.items()]
    team = [
        (f"*{task}*", f"`{name}`", words, f"{fuzzy_team.NEUTRAL[task][name]:g}")
        for task, outputs in fuzzy_team.TEAM_OUTPUTS.items()
        for name, words in outputs.items()
    ]
    values = {title.lower().replace(" ", "_"): _quantities(group) for title, group in QUANTITY_GROUPS.items()} | {
        "named": _table(_COLUMNS, [(f"`{name}`", *rest) for name, *rest in named]),
        "outputs": _table(("output", "unit and meaning"), [(f"`{n}`", w) for n, w in own_rules.RULE_OUTPUTS.items()]),
        "team_outputs": _table(("task", "output", "unit and meaning", "where there is none"), team),
        "ahead": f"{np.degrees(AHEAD):.0f}",
        "abeam": f"{np.degrees(ABEAM):.0f}",
        "none": f"{NOTHING_NEAR:g}",
        "farthest": f"{FARTHEST:g}",
        "side": f"{SIDE_TIME:g}",
        "added": _coded(sorted(ADDED)),
        "tracking": _coded(TRACKING_INPUTS),
    }
    return Template(Path(__file__).with_suffix(".txt").read_text(encoding="utf-8")).substitute(values)


def _quantities(group: Mapping[str, Quantity]) -> str:
    return _table(_COLUMNS, [(f"`{name}`", q.unit, q.meaning, _needs(q)) for name, q in group.items()])


def _needs(quantity: Quantity) -> str:
    return "the radio" if quantity.radio else "range sensors" if quantity.ranges else ""


def _table(head: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> str:
    lines = [head, ("---",) * len(head), *rows]
    return "\n".join("| " + " | ".join(cells) + " |" for cells in lines)


def _coded(names: Iterable[str]) -> str:
    return listed(f"`{name}`" for name in names)


if __name__ == "__main__":
    print(page(), end="")
