"""Reading what may move, and what a run costs, from TOML; what is wrong is a TuningError with file, line and field."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

from fuzzy.naming import check_known
from fuzzy.quantity import check_quantities, described, quantity, whole
from fuzzy.tuning.engines import ENGINES
from fuzzy.tuning.parameter import TuningError
from robotics.laws.law import Law
from robotics.laws.specification import Specification
from robotics.measures.registry import ALL_METRICS
from robotics.studies.tuning.cost import COST_TERMS, FAILED_COST, Cost, Term
from robotics.studies.tuning.space import PARTS, PARTS_MOVED, Bound, LawSpace, Unreached
from robotics.tables.build import Builder
from robotics.tables.files import TomlFiles
from robotics.tables.keys import Key, KeyTable, first_line, keys_of, table_of
from robotics.tables.text import reading


@dataclass(frozen=True, kw_only=True)
class TuningFile:
    """A tuning's file: what of a law may move, from where to where, and what a run costs."""

    title: str = described("What is tuned, in a line.", "", example="Precise, and quiet")
    move: tuple[str, ...] = described(
        f"What may move: of {', '.join(PARTS)}.", PARTS_MOVED, example=["gains", "consequents"]
    )
    gains: tuple[str, ...] | None = described(
        "The gains that may move; left out: all numbers with a unit that are not 0.", None, example=["look_ahead"]
    )
    rule_bases: tuple[str, ...] | None = described(
        "The tasks of the rule bases that may move; left out: all.", None, example=["tracking"]
    )
    fixed: tuple[str, ...] = described("Parameters that do not move.", (), example=["v.Zero"])
    symmetric: bool = described("Whether a rule base that answers to both sides alike keeps doing so.", True)
    unreached: Unreached = described(
        "Whether what the tuning runs say nothing of is held, or moves: rules that never outweigh all others.",
        "hold",
    )
    failed: float = quantity(
        FAILED_COST,
        "1",
        above=0,
        doc="What a run costs in which a robot was stopped or touched something, and at most.",
    )
    bounds: Mapping[str, Bound] | None = described("From where to where a parameter moves, instead of the rule.", None)
    cost: tuple[Term, ...] = described("The terms of the cost, whose sum is made smaller.", COST_TERMS)
    folder: Path = Path()  # of the file

    def __post_init__(self) -> None:
        check_quantities(self, TuningError)
        for part in self.move:
            check_known(part, PARTS, "part that can move", TuningError, "move")

    def space(self, law: Law[Any]) -> LawSpace:
        """What of a law may move. Raises TuningError for what the law does not have."""
        return LawSpace(
            law,
            self.move,
            self.gains,
            self.rule_bases,
            dict(self.bounds or {}),
            self.fixed,
            self.symmetric,
            self.unreached,
        )

    def made_cost(self) -> Cost:
        """What a run costs; functions in files are looked for beside the file first."""
        terms = (replace(term, metric=_located(term.metric, self.folder)) for term in self.cost)
        return Cost(terms=tuple(terms), failed=self.failed)


@dataclass(frozen=True, kw_only=True)
class StudyTuning:
    """What is tuned before a study is run: the tuned form of a controller takes part beside the published one."""

    controllers: tuple[str, ...] = described(
        "The controllers that are tuned, as the study calls them. Default: all of which something moves.",
        (),
        example=["fuzzy"],
    )
    on: tuple[str, ...] = described(
        "The scenarios that they are tuned on. Default: those of the study, with other seeds.",
        (),
        example=["lyapunov-sine"],
    )
    space: str = described("What may move, and what a run costs: a tuning's name or file.", "", example="tracking")
    evaluations: int = whole(300, least=1, most=1_000_000, doc="How many candidates are tried of each.")
    runs: int = whole(20, least=1, most=10_000, doc="Seeds of each candidate on each scenario.")
    seed: int = whole(1, least=0, most=10**9, doc="The seed of the searches.")
    engine: str = described("What searches: cmaes, or random.", "cmaes")

    def __post_init__(self) -> None:
        check_quantities(self, TuningError)
        check_known(self.engine, ENGINES, "engine", TuningError, "engine")

    def file(self, folder: Path) -> TuningFile:
        """What may move, and what a run costs. Raises TuningError."""
        beside = folder / self.space
        return load_tuning(beside if beside.is_file() else self.space) if self.space else TuningFile()


_FILES = TomlFiles("tunings", "tuning", TuningError)


def load_tuning(name: str | Path) -> TuningFile:
    """Read a tuning: a law, what may move of it, scenarios, a budget and a cost.

    Args:
        name: The name of one that comes with the package, or a ``.toml`` file.

    Returns:
        The tuning before it is done.

    Raises:
        TuningError: No such tuning, or a file that makes none; the message names file, line and key.
    """
    found = _FILES.find(name)
    return parse_tuning(found.text, found.file, found.folder)


def parse_tuning(text: str, file: str = "<text>", folder: Path = Path()) -> TuningFile:
    """Read the tuning that a TOML text describes. Raises TuningError.

    Args:
        text: The TOML text.
        file: The file's name in messages.
        folder: The folder in which functions of the user's own are looked for first.
    """
    with reading(text, file, TuningError) as table:
        return tuning_from_table(table, folder)


def tuning_from_table(table: Mapping[str, Any], folder: Path) -> TuningFile:
    """Make the tuning of a file's table. Raises an InputError whose ``at`` holds the keys that it is about."""
    found: TuningFile = Builder(TuningError).build(TuningFile, table, (), folder=folder)
    for n, term in enumerate(found.cost):
        if ":" not in term.metric:
            check_known(term.metric, ALL_METRICS, "metric", TuningError, "cost", n, "metric")
        if ":" in term.metric:
            file_of = _located(term.metric, found.folder).partition(":")[0]
            if not Path(file_of).is_file():
                raise TuningError(f"there is no file {file_of!r} with the function").about("cost", n, "metric")
    return found


def _located(metric: str, folder: Path) -> str:
    return str(Specification.of(metric).located(folder)) if ":" in metric else metric


@cache
def tuning_table() -> KeyTable:
    """The description of a tuning's file."""
    keys = keys_of(TuningFile, {Mapping[str, Bound] | None: _bound_key}, without=("cost",))
    cost = Key("cost", "A term of the cost, whose sum is made smaller.", "tables", table=table_of(Term, "term"))
    return KeyTable("tuning", first_line(TuningFile), (*keys, cost))


def _bound_key(name: str) -> Key:
    bound = Key("PARAMETER", "From where to where it moves.", "table", table=table_of(Bound, "bound"))
    return Key(name, "", "table", table=KeyTable(name, "Bounds by parameter.", any_key=bound))
