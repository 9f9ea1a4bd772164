"""Warnings before random crossings: what a law does not look at, and what it keeps too far from."""

from typing import Any, Literal

from robotics.laws.law import Law
from robotics.plugins.stress.conflict import CLEAR, CONFLICT
from robotics.plugins.stress.crossings import APART


def crossing_forewarnings(law: Law[Any], name: str, kind: Literal["A", "B"]) -> list[str]:
    """Sentences on what will go wrong in the random crossings of a ``kind``, whatever their seeds."""
    sentences = []
    if not law.yields:
        sentences.append(
            f"{name} takes no care of other robots: in every crossing two of them come nearer than {CONFLICT:g} m if "
            "all are on time"
        )
    room, of = (CLEAR, "from the paths of others") if kind == "A" else (APART, "from each other")
    if law.yields and law.safety_distance is not None and law.safety_distance > room:
        sentences.append(
            f"{name} keeps {law.safety_distance:g} m between robots, and starts and goals of class {kind} may be only "
            f"{room:g} m {of}: robots may wait for ever"
        )
    return sentences
