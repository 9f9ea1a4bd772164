"""The thesis's claims about one robot, each put to the test on this simulator."""

from dataclasses import dataclass
from typing import Literal

Verdict = Literal["holds", "holds in part", "does not hold"]


@dataclass(frozen=True)
class Claim:
    """One claim, what was measured, and whether it holds here."""

    name: str
    source: str  # where the thesis makes it
    statement: str  # what the thesis says, in a sentence
    measured: str  # what was run and what came out, with the numbers
    verdict: Verdict
