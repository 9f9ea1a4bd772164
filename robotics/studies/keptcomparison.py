"""Comparisons in a folder: what is done is kept as it goes, and the same work goes on from there after a stop.

A chunk holds the runs of one controller on one scenario, DRAWN_SEEDS of them at most; of a design, of several points.
While the work goes on, or where it was stopped, the folder PIECES_FOLDER of the results holds its chunks; they are
discarded when all that is made of them is written.
"""

import json
from bisect import bisect_left
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from itertools import accumulate, islice
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple
from uuid import uuid4

import numpy as np
import pandas as pd

from fuzzy.errors import InputError
from fuzzy.files.atomic import replacing
from fuzzy.shell.progress import Advance
from robotics.laws.catalogue import as_law, chosen_laws
from robotics.laws.law import Law
from robotics.measures.outside import OutsideInput, merged
from robotics.measures.own import OwnMetrics
from robotics.measures.quantities import measured, quantity_called
from robotics.measures.registry import own_metrics
from robotics.simulation.loop import simulate
from robotics.simulation.run import Run
from robotics.simulation.scenario.description import Scenario
from robotics.studies.chunks import Chunk, KeptChunks, run_chunk
from robotics.studies.comparison import DRAWN_SEEDS, Comparison, RunNotes, RunsAgain, column_titles, rows_of
from robotics.studies.design import Point, ScenarioDesign
from robotics.studies.executors import Workers
from robotics.studies.versions import digest, versions

if TYPE_CHECKING:
    import pyarrow as pa

Quantity = tuple[str, str]  # of a claim: what is measured, and whose number of a run it is
PACKAGES = ("fuzzyfleet", "numba", "numpy", "pyarrow", "scipy")  # on which numbers, and the bytes of chunks, depend
PIECES_FOLDER = "pieces"  # the folder of chunks, in that of the results
_NOTES, _VALUE = "notes ", "value of "  # columns of chunks, beside those of the table
_ROW_GROUP = 65_536  # rows of a Parquet file that are written at a time
_PASSES = 10  # of a design in a chunk, at most, so that several workers have something to do


@dataclass(frozen=True)
class Case:
    """A scenario of a comparison with the controllers that drive it, perhaps at many points of a design.

    Attributes:
        scenario: The scenario, as it is without the design; its name is that of the case.
        laws: The controllers, or their specifications, by their names.
        plain: What the table calls the scenario, where it is not the case's name.
        condition: Under which condition.
        design: What a point changes of the scenario and of gains.
        points: The points.
        chunk: How many runs are computed and written at a time, at most.
    """

    scenario: Scenario
    laws: Mapping[str, Law[Any] | str]
    plain: str = ""
    condition: str = ""
    design: ScenarioDesign | None = None
    points: Sequence[Point] = ((),)
    chunk: int = DRAWN_SEEDS

    @property
    def about(self) -> dict[str, str]:
        """Digests of all that determines its runs, but for the laws."""
        table = self.design and digest(self.design.table)
        axes = {"axes": digest([repr(self.design.axes), self.points])} if self.design else {}
        return {"scenario": digest([repr(self.scenario), repr(self.scenario.robots), self.condition, table]), **axes}

    def chunks(self, seeds: Sequence[int]) -> int:
        """The number of chunks of its runs with some seeds."""
        return -(-len(self.points) * len(self.laws) * self._stretches(seeds) // self._size(seeds))

    def passes(self, place: int, seeds: Sequence[int], asked: Mapping[tuple[str, str], Iterable[Quantity]]) -> "Passes":
        """The passes of the chunk at a ``place``: points vary slowest, then controllers, then stretches of seeds.

        ``asked`` are what claims ask for, by the names of case and controller.
        """
        laws, stretches, size = list(self.laws), self._stretches(seeds), self._size(seeds)
        found = []
        for index in range(place * size, min((place + 1) * size, len(self.points) * len(laws) * stretches)):
            rest, stretch = divmod(index, stretches)
            point, law = divmod(rest, len(laws))
            name = laws[law]
            found.append(
                RunsPass(
                    replace(self, laws={name: self.laws[name]}, points=(self.points[point],)),
                    tuple(seeds[stretch * self._stretch : (stretch + 1) * self._stretch]),
                    tuple(dict.fromkeys(asked.get((self.scenario.name, name), ()))),
                    point + 1,
                )
            )
        return tuple(found)

    def _size(self, seeds: Sequence[int]) -> int:
        """The number of passes in a chunk: of a design several."""
        return 1 if self.design is None else max(1, min(self.chunk // len(seeds), _PASSES))

    @property
    def _stretch(self) -> int:
        """The number of seeds that are simulated in one go, at most."""
        return min(self.chunk, DRAWN_SEEDS)

    def _stretches(self, seeds: Sequence[int]) -> int:
        """The number of stretches into which seeds are cut."""
        return -(-len(seeds) // self._stretch)


@dataclass(frozen=True)
class RunsPass:
    """The runs of a controller in a case, at one point of its design, and what of them claims ask for."""

    case: Case  # with this controller and this point alone
    seeds: tuple[int, ...]
    quantities: tuple[Quantity, ...] = ()
    point: int = 1  # its number

    @property
    def controller(self) -> str:
        """What the controller is called."""
        return next(iter(self.case.laws))

    @property
    def key(self) -> tuple[str, str]:
        """The names of case and controller."""
        return self.case.scenario.name, self.controller

    @property
    def values(self) -> Point:
        """What the axes of the design have at the point."""
        return self.case.points[0]

    @property
    def columns(self) -> dict[str, Any]:
        """The columns that stand beside the scenario's."""
        condition, design = self.case.condition, self.case.design
        found: dict[str, Any] = {"condition": condition} if condition else {}
        return found | ({"point": self.point} | design.columns(self.values) if design is not None else {})

    def driven(self) -> tuple[Scenario, Law[Any] | str]:
        """The scenario and the controller at the point."""
        design, (law,) = self.case.design, self.case.laws.values()
        if design is None:
            return self.case.scenario, law
        return design.scenario_at(self.values), design.law_at(str(law), self.values)


Passes = tuple[RunsPass, ...]


def run_pass(
    metrics: OwnMetrics,
    kept: Callable[[tuple[str, str], Run], None] | None,
    progress: Callable[[], None] | None,
    part: RunsPass,
) -> pd.DataFrame:
    """Simulate and measure a pass into the rows of the comparison's table, with the notes on its runs.

    Args:
        metrics: The user's own metrics.
        kept: Is given the run, with the names of scenario and controller.
        progress: Called after every simulated period.
        part: The pass.
    """
    own = own_metrics(metrics)
    scenario, law = part.driven()
    run = simulate(scenario, as_law(law), part.seeds, name=part.controller, progress=progress)
    if kept is not None and part.case.design is None:
        kept(part.key, run)
    rows = rows_of(run, own)
    robots = run.stopped.shape[1]
    for metric, whose in part.quantities:
        values = measured(run, quantity_called(metric, own), whose)
        rows[f"{_VALUE}{metric}, {whose}"] = np.repeat(values, robots)
    if part.case.plain:
        rows["scenario"] = part.case.plain
    for place, (name, value) in enumerate(part.columns.items(), start=1):
        rows.insert(place, name, value)
    notes = RunNotes.of(run)
    said = json.dumps([notes.divergences, [list(one) for one in notes.outside]])
    rows[_NOTES] = [said, *[""] * (len(rows) - 1)]
    return rows


def _place(part: RunsPass) -> str:
    scenario, controller = part.key
    if part.case.design is None:
        return f"scenario {scenario!r}, controller {controller!r}"
    point, (first, *_, last) = part.case.design.described(part.point, part.values), (*part.seeds, part.seeds[-1])
    seeds = f"seed {first}" if first == last else f"seeds {first} to {last}"
    return f"scenario {scenario!r}, {point}, controller {controller!r}, {seeds}"


class TableCounts(NamedTuple):
    """What a table holds."""

    rows: int  # one a run and robot
    diverged: int  # of robots that were stopped
    contacts: int  # runs in which robots touched each other or an obstacle


@dataclass(frozen=True)
class KeptComparisons:
    """Comparisons with the same seeds, whose chunks stand in a folder that belongs to them alone.

    Attributes:
        folder: The folder of the chunks.
        about: All that the numbers depend on, as JSON can hold it.
        lasting: Whether that tells, after a stop, that the chunks are of the same work.
        groups: The cases of each comparison: scenarios of a kind, that the same controllers drive.
        seeds: The seeds.
        quantities: What claims ask for, by the names of scenario and controller.
        metrics: The user's own metrics, by name.
        named: The same, by their specifications where they have one: what other processes are told.
        workers: Who does the work, by default this process.
        drawn: Whether runs stay in memory, for pictures, unless there are too many seeds.
        kind: What messages call the work.
        fault: The error of a chunk that fails, where the others are kept; None: what went wrong comes as it was raised.
    """

    folder: Path
    about: Mapping[str, Any]
    lasting: bool
    groups: Sequence[Sequence[Case]]
    seeds: Sequence[int]
    quantities: Mapping[tuple[str, str], Iterable[Quantity]] = field(default_factory=dict)
    metrics: OwnMetrics = field(default_factory=dict)
    named: OwnMetrics = field(default_factory=dict)
    workers: Workers | None = None
    drawn: bool = False
    kind: str = "study"
    fault: type[InputError] | None = None
    runs: dict[tuple[str, str], Run] = field(default_factory=dict)  # that stayed in memory
    session: str = field(default_factory=lambda: uuid4().hex)  # tells chunks of what cannot be told

    @cached_property
    def cases(self) -> list[Case]:
        """The cases of all comparisons."""
        return [case for group in self.groups for case in group]

    @cached_property
    def ends(self) -> list[int]:
        """The number of the last chunk of each case."""
        return list(accumulate(case.chunks(self.seeds) for case in self.cases))

    def chunk(self, number: int) -> Chunk[RunsPass]:
        """The chunk of that ``number``, from 1; each is of one case."""
        place = bisect_left(self.ends, number)
        before = self.ends[place - 1] if place else 0
        return Chunk(number, self.cases[place].passes(number - 1 - before, self.seeds, self.quantities))

    def compute(self, begin: Callable[[str, int], Advance], resumed: Callable[[int, int], None]) -> int:
        """Do what is left; return how many chunks that was.

        ``resumed`` is called with how many chunks are there already, and of how many.
        """
        todo = self.chunks().missing()
        if len(todo) < self.ends[-1]:
            resumed(self.ends[-1] - len(todo), self.ends[-1])
        if not todo:
            return 0
        ticks = (part.case.scenario.ticks + 1 for number in todo for part in self.chunk(number).passes)
        advance = begin("simulating", len(todo) if self.workers else sum(ticks))
        self.chunks(advance).compute(todo, advance if self.workers else None)
        return len(todo)

    def landed(self) -> tuple[int, int]:
        """How many chunks are there, and of how many."""
        return self.ends[-1] - len(self.chunks().missing()), self.ends[-1]

    def chunks(self, progress: Advance | None = None) -> KeptChunks[RunsPass]:
        """The chunks in the folder; ``progress`` is called after every period that this process simulates."""
        keep = self.drawn and len(self.seeds) <= DRAWN_SEEDS
        one: Callable[[RunsPass], pd.DataFrame]
        if self.workers is None:
            one = partial(run_pass, self.metrics, self.runs.__setitem__ if keep else None, progress)
        else:
            one = partial(run_pass, self.named, None, None)
        return KeptChunks(
            folder=self.folder,
            kind=self.kind,
            key=digest([self.about, sorted(self.quantities.items())]) if self.lasting else self.session,
            count=self.ends[-1],
            chunk=self.chunk,
            one=partial(run_chunk, one, _place, versions(*PACKAGES) if self.workers else {}, self.fault),
            place=_place,
            fault=self.fault,
            workers=self.workers,
        )

    def write_parquet(self, path: Path) -> TableCounts:
        """Write the rows of all chunks into a Parquet file, whole or not at all; only some are in memory at a time.

        Each column says in its metadata its title and unit. One that only some chunks have is empty elsewhere.
        """
        import pyarrow as pa
        import pyarrow.compute as pc
        import pyarrow.parquet as pq

        def tables() -> "Iterator[pa.Table]":
            for table in self.chunks().tables():
                yield table.drop_columns([n for n in table.column_names if n.startswith((_NOTES, _VALUE))])

        schema = pa.unify_schemas([table.schema for table in tables()], promote_options="permissive")
        about = column_titles(schema.names, self.metrics)
        columns = [each.with_metadata(dict(zip(("title", "unit"), about[each.name], strict=True))) for each in schema]
        schema = pa.schema(columns, metadata={self.kind: self.chunks().key})
        rows = diverged = contacts = 0
        with replacing(path) as temporary, pq.ParquetWriter(temporary, schema) as writer:
            batch: list[pa.Table] = []
            for number, table in enumerate(tables(), start=1):
                batch.append(table)
                if sum(map(len, batch)) < _ROW_GROUP and number < self.ends[-1]:
                    continue
                joined = pa.concat_tables([schema.empty_table(), *batch], promote_options="permissive")
                writer.write_table(joined.select(schema.names).cast(schema))
                rows, batch = rows + len(joined), []
                diverged += pc.sum(joined["diverged"]).as_py()
                if "contact" in schema.names:
                    touched = pc.and_(joined["contact"].fill_null(False), pc.equal(joined["robot"], 1))
                    contacts += pc.sum(touched).as_py()
        return TableCounts(rows, diverged, contacts)

    def rows(self) -> pd.DataFrame:
        """The rows of all chunks that are there, in the order of the whole table."""
        there = map(self.chunks().there, range(1, self.ends[-1] + 1))
        tables = [_shown(table.to_pandas()) for table in there if table is not None]
        return pd.concat(tables, ignore_index=True) if tables else pd.DataFrame()

    def comparisons(self) -> tuple[Comparison, ...]:
        """The comparisons, one for each group, when all is done; the runs of all points of a design count alike."""
        tables = self.chunks().tables()
        whole = {
            case.scenario.name: pd.concat(
                [table.to_pandas() for table in islice(tables, case.chunks(self.seeds))], ignore_index=True
            )
            for case in self.cases
        }
        return tuple(self._comparison(group, [whole[case.scenario.name] for case in group]) for group in self.groups)

    def _comparison(self, group: Sequence[Case], tables: Sequence[pd.DataFrame]) -> Comparison:
        laws = group[0].laws
        notes, values = dict[tuple[str, str], RunNotes](), dict[tuple[str, str, str, str], np.ndarray]()
        for case, table in zip(group, tables, strict=True):
            for law in laws:
                key, mine = (case.scenario.name, law), table[table["controller"] == law]
                notes[key] = _notes(mine)
                for metric, whose in self.quantities.get(key, ()):
                    column = mine.loc[mine["robot"] == 1, f"{_VALUE}{metric}, {whose}"]
                    values[(*key, metric, whose)] = np.array(column.tolist())
        pooled = [self._pooled(case, _shown(table)) for case, table in zip(group, tables, strict=True)]
        return Comparison(
            scenarios=tuple(case.scenario for case in group),
            controllers=chosen_laws(laws),
            seeds=tuple(self.seeds)
            if group[0].design is None
            else tuple(range(len(group[0].points) * len(self.seeds))),
            table=pd.concat(pooled, ignore_index=True),
            runs=RunsAgain([case.scenario for case in group], laws, self.seeds, self.runs),
            metrics=own_metrics(self.metrics),
            notes=notes,
            values=values,
            points=len(group[0].points),
        )

    def _pooled(self, case: Case, table: pd.DataFrame) -> pd.DataFrame:
        """The table of a case by its name; the runs of a design are numbered through."""
        if case.plain:
            table["scenario"] = case.scenario.name
        if case.design is not None:
            table["seed"] += (table["point"] - 1) * len(self.seeds) - self.seeds[0]
            table = table.drop(columns=["point", *(axis.name for axis in case.design.axes)])
        return table.drop(columns="condition", errors="ignore")


def _shown(table: pd.DataFrame) -> pd.DataFrame:
    """What a user sees of the table of chunks."""
    return table.drop(columns=[name for name in map(str, table) if name.startswith((_NOTES, _VALUE))])


def _notes(rows: pd.DataFrame) -> RunNotes:
    """The notes on the runs of one controller in one case."""
    said = [json.loads(text) for text in rows[_NOTES] if text]
    found = [[OutsideInput(*one)._replace(universe=tuple(one[6])) for one in left] for _, left in said]
    counts = np.diff([*np.flatnonzero(rows[_NOTES] != ""), len(rows)]).tolist()
    return RunNotes(tuple(line for lines, _ in said for line in lines), merged(found, counts))
