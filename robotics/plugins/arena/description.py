"""Arenas of tracking as data, and the reading of all arenas: who is compared, on what, with what budget, in TOML."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, Literal, Self

from fuzzy.naming import check_known
from fuzzy.quantity import described, whole
from robotics.measures.registry import ALL_METRICS
from robotics.plugins.arena.families import Conditions, Family
from robotics.plugins.arena.kinds import load_plan, parse_plan
from robotics.plugins.arena.plan import BLOCKS, MOST_SEEDS, PLAN_BUILDER, ArenaError, ArenaPlan, Block
from robotics.simulation.scenario.description import Scenario
from robotics.studies.tuning.cost import COST_TERMS, Cost, Term
from robotics.studies.tuning.space import LawSpace
from robotics.studies.tuning.tune import reached

ARENA_PAGE = "arena.html"


@dataclass(frozen=True, kw_only=True)
class Arena(ArenaPlan):
    """An arena of tracking before it is held: one robot on one path, and a cost that is a sum of metrics.

    Attributes:
        name: What it is called: its file's name.
        folder: Where files that it names are looked for first.

    Raises:
        ArenaError: An arena that cannot be held.
    """

    kind = "tracking"
    filled = (*ArenaPlan.filled, "cost")

    reference: str = described(
        "The law whose tuned cost the others' are told in; left out: the law with the least.", ""
    )
    runs: int = whole(2, least=1, most=10_000, doc="Seeds of each candidate on each scenario that is tuned on.")
    choosing_runs: int = whole(10, least=2, most=MOST_SEEDS, doc="Seeds of each scenario by which is chosen.")
    testing_runs: int = whole(200, least=2, most=MOST_SEEDS, doc="Seeds of each scenario that is tested on.")
    robustness_runs: int = whole(25, least=2, most=MOST_SEEDS, doc="Likewise for each change that no law is told of.")
    conditions: Conditions = described("What all scenarios share.", default_factory=Conditions)
    under: tuple[Conditions, ...] = described(
        "Conditions under which it is held again, every law tuned anew: a title, and what differs.", ()
    )
    cost: tuple[Term, ...] = described("The terms of the cost, whose sum is made smaller.", COST_TERMS)
    tune: tuple[Family, ...] = described("The scenarios that are tuned on.")
    choose: tuple[Family, ...] = described("The scenarios by which is chosen among what was tuned.")
    test: tuple[Family, ...] = described("The scenarios that nobody has seen before.")

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.reference:
            check_known(self.reference, self.laws, "law of the arena", ArenaError, "reference")
        for i, other in enumerate(self.under):
            if other.title in ("", self.conditions.title, *(before.title for before in self.under[:i])):
                raise ArenaError("under: each of the conditions needs a title of its own").about("under", i)
        if self.repeats * self.runs > MOST_SEEDS:
            raise ArenaError(f"repeats times runs must be <= {MOST_SEEDS}; got {self.repeats * self.runs}").about(
                "repeats"
            )

    def reached(self, space: LawSpace) -> LawSpace:
        """The ``space`` in which what the tuning runs say nothing of is held."""
        return reached(space, self.scenarios("tune"), [self.tuning_seed(0)])

    @property
    def tested(self) -> str:
        """How many seeds are tested on."""
        return f"; {self.testing_runs} seeds of each that is tested on"

    @property
    def made_cost(self) -> Cost:
        """What a run costs."""
        return Cost(terms=self.cost)

    def scenarios(self, block: Block) -> tuple[Scenario, ...]:
        """The scenarios of ``block``: "tune", "choose" or "test", drawn. Raises ArenaError, and RobotError."""
        return _drawn(getattr(self, block), BLOCKS[block], self.conditions)

    def tuning_seed(self, repeat: int) -> int:
        """The first seed that ``repeat``, from 0, of the search drives with, its ``runs`` seeds from there on."""
        return BLOCKS["tune"] + repeat * self.runs

    def seeds(self, block: Literal["choose", "test"], runs: int | None = None) -> range:
        """The seeds of ``block``, "choose" or "test", or the first ``runs`` of them."""
        all_of_them = self.choosing_runs if block == "choose" else self.testing_runs
        first = BLOCKS[block]
        return range(first, first + (all_of_them if runs is None else min(runs, all_of_them)))

    def about(self) -> dict[str, Any]:
        """All that determines its numbers, as JSON can hold it."""
        scenarios = {
            block: [repr(scenario) + repr(scenario.robots) for scenario in self.scenarios(block)] for block in BLOCKS
        }
        plain = ("reference", "engines", "move", "evaluations", "runs", "repeats", "choosing_runs", "testing_runs")
        return {
            "laws": {law: repr(self.law(law)) for law in self.laws},
            **{name: getattr(self, name) for name in (*plain, "robustness_runs", "seed")},
            "exceptions": dict(self.exceptions),
            "cost": self.made_cost.about(),
            "conditions": repr(self.conditions),
            "scenarios": scenarios,
        }

    def with_laws(self, laws: Sequence[str]) -> Self:
        """The same arena with other ``laws``, their specifications. Raises ArenaError."""
        reference = self.reference if self.reference in laws else ""
        return super(Arena, replace(self, reference=reference)).with_laws(laws)

    @property
    def unseen_sorts(self) -> list[str]:
        """The sorts of the test's scenarios that are not among those tuned on: other paths, speeds, starts, robots."""
        known = [replace(family, count=1, title="") for family in self.tune]
        return [f.label for f in self.test if replace(f, count=1, title="") not in known]


@cache
def _drawn(families: tuple[Family, ...], first: int, conditions: Conditions) -> tuple[Scenario, ...]:
    found: list[Scenario] = []
    for family in families:
        for _ in range(family.count):
            number = first + len(found)
            found.append(family.scenario(number, conditions))
    return tuple(found)


def load_arena(name: str | Path = "default") -> Arena:
    """Read an arena of tracking.

    Args:
        name: The name of one that comes with the package, or a ``.toml`` file.

    Returns:
        The arena.

    Raises:
        ArenaError: No such arena, or a file that makes none; the message names file, line and key.
    """
    return _of_tracking(load_plan(name))


def parse_arena(text: str, name: str = "arena", file: str = "<text>", folder: Path = Path()) -> Arena:
    """Read the arena of tracking that a TOML text describes, as :func:`parse_plan` does. Raises ArenaError."""
    return _of_tracking(parse_plan(text, name, file, folder))


def _of_tracking(plan: ArenaPlan) -> Arena:
    if not isinstance(plan, Arena):
        raise ArenaError(f"{plan.name} is an arena of {plan.kind}; here one of tracking is meant")
    return plan


def tracking_from_table(table: Mapping[str, Any], name: str, folder: Path) -> Arena:
    """Make an arena of tracking of a table. Raises an InputError whose ``at`` holds the keys that it is about."""
    whole = dict(table)
    shared, others = whole.get("conditions"), whole.get("under")
    if isinstance(shared, dict) and isinstance(others, list):
        whole["under"] = [{**shared, **other} if isinstance(other, dict) else other for other in others]
    made: Arena = PLAN_BUILDER.build(Arena, whole, (), ("like", "kind"), name=name, folder=folder)
    for n, term in enumerate(made.cost):
        check_known(term.metric, ALL_METRICS, "metric", ArenaError, "cost", n, "metric")
    return made
