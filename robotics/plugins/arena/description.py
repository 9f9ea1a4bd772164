"""Arenas as data: who is compared, on what, with what budget; read from a TOML file.

Three blocks of scenarios, and of seeds, have nothing in common: laws are tuned on the first, what was tuned is chosen
among on the second, and what is said of the chosen ones is measured on the third. Scenario number k of a block, and its
seeds, count from the first number of the block: 1,000,000 for tuning, 2,000,000 for choosing, 3,000,000 for testing.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from pathlib import Path
from typing import Any, Literal

from fuzzy.errors import InputError
from fuzzy.naming import check_known
from fuzzy.quantity import check_quantities, described, whole
from fuzzy.tuning.engines import ENGINES
from robotics.laws.catalogue import as_law, located
from robotics.laws.law import Law
from robotics.measures.registry import ALL_METRICS
from robotics.plugins.arena.families import ArenaError, Conditions, Family
from robotics.simulation.scenario.description import Scenario
from robotics.studies.tuning.cost import COST_TERMS, Cost, Term
from robotics.studies.tuning.space import PARTS, PARTS_MOVED, LawSpace, NothingMovesError
from robotics.studies.tuning.tune import CHOOSING, TESTING, TUNING, reached
from robotics.tables.build import Builder, Keys
from robotics.tables.files import TomlFiles
from robotics.tables.text import parse_table, reading

Block = Literal["tune", "choose", "test"]
BLOCKS: Mapping[Block, int] = {"tune": TUNING, "choose": CHOOSING, "test": TESTING}
MOST_SEEDS = 900_000  # of a block, so that it ends before the next one begins


@dataclass(frozen=True, kw_only=True)
class Arena:
    """An arena before it is held.

    Attributes:
        name: What it is called: its file's name.
        folder: Where files that it names are looked for first.

    Raises:
        ArenaError: An arena that cannot be held.
    """

    name: str
    title: str = described("What is asked, in a line.", "", example="Which law for my robot?")
    laws: tuple[str, ...] = described(
        "The laws: names with gains, mine.fis, mylaw.py:MyLaw; files are relative to this one.",
        example=["fuzzy", "lyapunov"],
    )
    reference: str = described(
        "The law whose tuned cost the others' are told in; left out: the law with the least.", ""
    )
    engines: tuple[str, ...] = described("The engines that search: of cmaes, random.", ("cmaes", "random"))
    move: tuple[str, ...] = described(f"What may move of a law: of {', '.join(PARTS)}.", PARTS_MOVED)
    evaluations: int = whole(300, least=1, most=1_000_000, doc="How many candidates each search tries.")
    runs: int = whole(2, least=1, most=10_000, doc="Seeds of each candidate on each scenario that is tuned on.")
    repeats: int = whole(2, least=1, most=100, doc="How often each engine searches, each time with other seeds.")
    choosing_runs: int = whole(10, least=2, most=MOST_SEEDS, doc="Seeds of each scenario by which is chosen.")
    testing_runs: int = whole(200, least=2, most=MOST_SEEDS, doc="Seeds of each scenario that is tested on.")
    robustness_runs: int = whole(25, least=2, most=MOST_SEEDS, doc="Likewise for each change that no law is told of.")
    seed: int = whole(1, least=0, most=10**9, doc="The seed of the searches and of the intervals.")
    conditions: Conditions = described("What all scenarios share.", default_factory=Conditions)
    under: tuple[Conditions, ...] = described(
        "Conditions under which it is held again, every law tuned anew: a title, and what differs.", ()
    )
    cost: tuple[Term, ...] = described("The terms of the cost, whose sum is made smaller.", COST_TERMS)
    exceptions: Mapping[str, int] = described(
        "Evaluations of laws that compute for too long: no longer the same budget, and said so.", default_factory=dict
    )
    tune: tuple[Family, ...] = described("The scenarios that are tuned on.")
    choose: tuple[Family, ...] = described("The scenarios by which is chosen among what was tuned.")
    test: tuple[Family, ...] = described("The scenarios that nobody has seen before.")
    folder: Path = field(default=Path(), compare=False)

    def __post_init__(self) -> None:
        check_quantities(self, ArenaError)
        for name in ("laws", "engines", "tune", "choose", "test", "cost"):
            values = getattr(self, name)
            if not values:
                raise ArenaError(f"{name} must have at least one").about(name)
            if name in ("laws", "engines") and len({*values}) < len(values):
                raise ArenaError(f"{name}: one of {', '.join(values)} is given twice").about(name)
        for engine in self.engines:
            check_known(engine, ENGINES, "engine", ArenaError, "engines")
        for part in self.move:
            check_known(part, PARTS, "part that can move", ArenaError, "move")
        for i, law in enumerate(self.laws):
            try:
                self._movable(law)
            except InputError as error:
                raise ArenaError(f"laws: {error}").about("laws", i) from None
        if len(self.untuned) == len(self.laws):
            raise ArenaError(f"laws: none has anything that moves, of {', '.join(self.move)}").about("laws")
        if self.reference:
            check_known(self.reference, self.laws, "law of the arena", ArenaError, "reference")
        for i, other in enumerate(self.under):
            if other.title in ("", self.conditions.title, *(before.title for before in self.under[:i])):
                raise ArenaError("under: each of the conditions needs a title of its own").about("under", i)
        for law in self.exceptions:
            check_known(law, self.laws, "law of the arena", ArenaError, "exceptions", law)
        if self.repeats * self.runs > MOST_SEEDS:
            raise ArenaError(f"repeats times runs must be <= {MOST_SEEDS}; got {self.repeats * self.runs}").about(
                "repeats"
            )

    def law(self, specification: str) -> Law[Any]:
        """The law of a ``specification``, its files looked for beside the arena's first."""
        return as_law(located(specification, self.folder))

    def space(self, law: str) -> LawSpace | None:
        """What may move of ``law``, a specification, by the one rule for all; None: it takes part as published."""
        if law not in self._spaces:
            whole = self._movable(law)
            self._spaces[law] = whole and reached(whole, self.scenarios("tune"), [self.tuning_seed(0)])
        return self._spaces[law]

    def _movable(self, law: str) -> LawSpace | None:
        """The same with what no tuning run reaches."""
        try:
            return LawSpace(self.law(law), self.move)
        except NothingMovesError:
            return None

    @cached_property
    def _spaces(self) -> dict[str, LawSpace | None]:
        """What may move, by law, as far as it was asked for."""
        return {}

    @cached_property
    def untuned(self) -> tuple[str, ...]:
        """The laws of which nothing moves: they take part as published."""
        return tuple(law for law in self.laws if self._movable(law) is None)

    def budget(self, law: str) -> int:
        """How many candidates each search of ``law``, a specification, tries: 0 where nothing of it moves."""
        return 0 if law in self.untuned else self.exceptions.get(law, self.evaluations)

    @property
    def made_cost(self) -> Cost:
        """What a run costs."""
        return Cost(terms=self.cost)

    def scenarios(self, block: Block) -> tuple[Scenario, ...]:
        """The scenarios of ``block``: "tune", "choose" or "test", drawn. Raises ArenaError, and RobotError."""
        return _drawn(getattr(self, block), BLOCKS[block], self.conditions)

    def labels(self, block: Block) -> list[str]:
        """What the scenarios of ``block`` are called, no two alike."""
        said = [family.label for family in getattr(self, block) for _ in range(family.count)]
        return [f"{text} {said[: n + 1].count(text)}" if said.count(text) > 1 else text for n, text in enumerate(said)]

    def tuning_seed(self, repeat: int) -> int:
        """The first seed that ``repeat``, from 0, of the search drives with, its ``runs`` seeds from there on."""
        return BLOCKS["tune"] + repeat * self.runs

    def seeds(self, block: Literal["choose", "test"], runs: int | None = None) -> range:
        """The seeds of ``block``, "choose" or "test", or the first ``runs`` of them."""
        all_of_them = self.choosing_runs if block == "choose" else self.testing_runs
        first = BLOCKS[block]
        return range(first, first + (all_of_them if runs is None else min(runs, all_of_them)))

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


_FILES = TomlFiles("arenas", "arena", ArenaError)


def arena_names() -> list[str]:
    """The names of the arenas that come with the package."""
    return _FILES.names()


def load_arena(name: str | Path = "default") -> Arena:
    """Read an arena.

    Args:
        name: The name of one that comes with the package, or a ``.toml`` file.

    Returns:
        The arena.

    Raises:
        ArenaError: No such arena, or a file that makes none; the message names file, line and key.
    """
    found = _FILES.find(name)
    return parse_arena(found.text, found.name, found.file, found.folder)


def parse_arena(text: str, name: str = "arena", file: str = "<text>", folder: Path = Path()) -> Arena:
    """Read the arena that a TOML text describes. Raises ArenaError.

    A key ``like`` names a packaged arena, whose keys count where the text has none.

    Args:
        text: The TOML text.
        name: The arena's name.
        file: The file's name in messages.
        folder: The folder to which paths in it are relative.
    """
    with reading(text, file, ArenaError) as table:
        return arena_from_table(table, name, folder)


def arena_from_table(table: Mapping[str, Any], name: str, folder: Path) -> Arena:
    """Make the arena of a file's table. Raises an InputError whose ``at`` holds the keys that it is about."""
    whole = _alike(dict(table))
    shared, others = whole.get("conditions"), whole.get("under")
    if isinstance(shared, dict) and isinstance(others, list):
        whole["under"] = [{**shared, **other} if isinstance(other, dict) else other for other in others]
    made: Arena = _BUILDER.build(Arena, whole, (), ("like",), name=name, folder=folder)
    for n, term in enumerate(made.cost):
        check_known(term.metric, ALL_METRICS, "metric", ArenaError, "cost", n, "metric")
    return made


def _alike(table: dict[str, Any]) -> dict[str, Any]:
    """The table with the keys of the packaged arena that it is ``like``, where it gives none itself."""
    like = table.pop("like", None)
    if like is None:
        return table
    check_known(like, arena_names(), "arena", ArenaError, "like", where="like")
    return {**_alike(parse_table(_FILES.find(like).text, f"{like}.toml", ArenaError)), **table}


def with_laws(arena: Arena, laws: Sequence[str]) -> Arena:
    """The same arena with other laws. Raises ArenaError."""
    kept = {law: count for law, count in arena.exceptions.items() if law in laws}
    reference = arena.reference if arena.reference in laws else ""
    return replace(arena, laws=tuple(laws), exceptions=kept, reference=reference)


def about(arena: Arena) -> dict[str, Any]:
    """All that determines the numbers of an arena, as JSON can hold it."""
    scenarios = {
        block: [repr(scenario) + repr(scenario.robots) for scenario in arena.scenarios(block)] for block in BLOCKS
    }
    plain = ("reference", "engines", "move", "evaluations", "runs", "repeats", "choosing_runs", "testing_runs")
    return {
        "laws": {law: repr(arena.law(law)) for law in arena.laws},
        **{name: getattr(arena, name) for name in (*plain, "robustness_runs", "seed")},
        "exceptions": dict(arena.exceptions),
        "cost": arena.made_cost.about(),
        "conditions": repr(arena.conditions),
        "scenarios": scenarios,
    }


def _exceptions(value: Any, keys: Keys) -> dict[str, int]:
    table = _BUILDER.table(value, keys)
    for law, count in table.items():
        if type(count) is not int or count < 1:
            raise ArenaError(f"the evaluations of {law} must be a whole number >= 1; got {count!r}").about(*keys, law)
    return table


_BUILDER = Builder(ArenaError, {Mapping[str, int]: _exceptions})
