"""Comparisons in a folder: what is done is kept as it goes, and the same work goes on from there after a stop.

A chunk holds the runs of one controller on one scenario, DRAWN_SEEDS of them at most; of a design, of several points.
While the work goes on, or where
it was stopped, the folder of the results holds its chunks; they are discarded when all that is made of them is written.
"""

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from itertools import groupby, islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

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
from robotics.studies.comparison import DRAWN_SEEDS, Comparison, RunNotes, RunsAgain, rows_of
from robotics.studies.executors import Workers
from robotics.studies.sweeps.plan import Sweep, SweepPlan, column_value, controller_at, described, scenario_at
from robotics.studies.versions import digest

if TYPE_CHECKING:
    import pyarrow as pa

Quantity = tuple[str, str]  # of a claim: what is measured, and whose number of a run it is
_NOTES, _VALUE = "notes ", "value of "  # columns of chunks, beside those of the table
_PASSES = 10  # of a design in a chunk, at most, so that several workers have something to do


@dataclass(frozen=True)
class Case:
    """A scenario of a comparison with the controllers that drive it, perhaps at many points of a design.

    Attributes:
        scenario: The scenario, as it is without the design; its name is that of the case.
        laws: The controllers, or their specifications, by their names.
        plain: What the table calls the scenario, where it is not the case's name.
        condition: Under which condition.
        design: The points at which scenario and gains are changed.
    """

    scenario: Scenario
    laws: Mapping[str, Law[Any] | str]
    plain: str = ""
    condition: str = ""
    design: SweepPlan | None = None

    @property
    def points(self) -> int:
        """The number of points."""
        return 1 if self.design is None else len(self.design.points)

    @property
    def about(self) -> list[Any]:
        """All that determines its runs, but for the laws."""
        design = self.design and [repr(self.design.sweep.axes), digest(self.design.sweep.table), self.design.points]
        return [repr(self.scenario), repr(self.scenario.robots), self.condition, design]

    def chunks(self, seeds: Sequence[int], asked: Mapping[str, Iterable[Quantity]]) -> Iterator[tuple["RunsPass", ...]]:
        """The passes of every controller with the same seeds, in chunks: of a design several at a time.

        ``asked`` are what claims ask for, by controller.
        """
        stretches = [tuple(seeds[first : first + DRAWN_SEEDS]) for first in range(0, len(seeds), DRAWN_SEEDS)]
        points = self.design.points if self.design is not None else ((),)
        every = (
            RunsPass(
                self.scenario,
                name,
                law,
                stretch,
                quantities=tuple(dict.fromkeys(asked.get(name, ()))),
                plain=self.plain,
                condition=self.condition,
                sweep=None if self.design is None else self.design.sweep,
                point=point,
                values=values,
            )
            for point, values in enumerate(points, start=1)
            for name, law in self.laws.items()
            for stretch in stretches
        )
        size = 1 if self.design is None else max(1, min(DRAWN_SEEDS // len(seeds), _PASSES))
        while chunk := tuple(islice(every, size)):
            yield chunk


@dataclass(frozen=True)
class RunsPass:
    """The runs of a controller in a case, at one point of its design, and what of them claims ask for."""

    scenario: Scenario = field(repr=False)  # of the case
    controller: str  # what it is called
    law: Law[Any] | str = field(repr=False)
    seeds: tuple[int, ...]
    quantities: tuple[Quantity, ...] = ()
    plain: str = ""
    condition: str = ""
    sweep: Sweep | None = field(default=None, repr=False)  # of the design
    point: int = 1
    values: tuple[Any, ...] = ()

    @property
    def key(self) -> tuple[str, str]:
        """The names of case and controller."""
        return self.scenario.name, self.controller

    @property
    def columns(self) -> dict[str, Any]:
        """The columns that stand beside the scenario's."""
        found: dict[str, Any] = {"condition": self.condition} if self.condition else {}
        if self.sweep is not None:
            axes = zip(self.sweep.axes, self.values, strict=True)
            found |= {"point": self.point} | {axis.name: column_value(value) for axis, value in axes}
        return found

    def driven(self) -> tuple[Scenario, Law[Any] | str]:
        """The scenario and the controller at the point."""
        if self.sweep is None:
            return self.scenario, self.law
        return scenario_at(self.sweep, self.values), controller_at(self.sweep, str(self.law), self.values)


def run_pass(
    metrics: OwnMetrics,
    kept: Callable[[tuple[str, str], Run], None] | None,
    progress: Callable[[], None] | None,
    part: RunsPass,
) -> "pa.Table":
    """Simulate and measure a pass into the rows of the comparison's table, with the notes on its runs.

    Args:
        metrics: The user's own metrics.
        kept: Is given the run, with the names of scenario and controller.
        progress: Called after every simulated period.
        part: The pass.
    """
    import pyarrow as pa

    own = own_metrics(metrics)
    scenario, law = part.driven()
    run = simulate(scenario, as_law(law), part.seeds, name=part.controller, progress=progress)
    if kept is not None and part.sweep is None:
        kept(part.key, run)
    rows = rows_of(run, own)
    robots = run.stopped.shape[1]
    for metric, whose in part.quantities:
        values = measured(run, quantity_called(metric, own), whose)
        rows[f"{_VALUE}{metric}, {whose}"] = np.repeat(values, robots)
    if part.plain:
        rows["scenario"] = part.plain
    for place, (name, value) in enumerate(part.columns.items(), start=1):
        rows.insert(place, name, value)
    notes = RunNotes.of(run)
    said = json.dumps([notes.divergences, [list(one) for one in notes.outside]])
    rows[_NOTES] = [said, *[""] * (len(rows) - 1)]
    return pa.Table.from_pandas(rows, preserve_index=False).replace_schema_metadata()


def _place(part: RunsPass) -> str:
    point = "" if part.sweep is None else f", {described(part.sweep, part.point, part.values)}"
    return f"scenario {part.scenario.name!r}{point}, controller {part.controller!r}"


@dataclass(frozen=True)
class KeptComparisons:
    """Comparisons with the same seeds, in a folder that belongs to them alone.

    Attributes:
        folder: The folder of the results.
        key: The digest of all that the numbers depend on.
        lasting: Whether the key tells, after a stop, that the chunks are of the same work.
        groups: The cases of each comparison: scenarios of a kind, that the same controllers drive.
        seeds: The seeds.
        quantities: What claims ask for, by the names of scenario and controller.
        metrics: The user's own metrics, by name.
        named: The same, by their specifications where they have one: what other processes are told.
        workers: Who does the work, by default this process.
        drawn: Whether runs stay in memory, for pictures, unless there are too many seeds.
    """

    folder: Path
    key: str
    lasting: bool
    groups: Sequence[Sequence[Case]]
    seeds: Sequence[int]
    quantities: Mapping[tuple[str, str], Iterable[Quantity]] = field(default_factory=dict)
    metrics: OwnMetrics = field(default_factory=dict)
    named: OwnMetrics = field(default_factory=dict)
    workers: Workers | None = None
    drawn: bool = False
    runs: dict[tuple[str, str], Run] = field(default_factory=dict)  # that stayed in memory

    @cached_property
    def work(self) -> list[tuple[RunsPass, ...]]:
        """The work, in chunks, each of one case."""
        cases = [case for group in self.groups for case in group]
        asked = {
            case.scenario.name: {n: self.quantities.get((case.scenario.name, n), ()) for n in case.laws}
            for case in cases
        }
        return [chunk for case in cases for chunk in case.chunks(self.seeds, asked[case.scenario.name])]

    def compute(self, begin: Callable[[str, int], Advance], resumed: Callable[[int, int], None]) -> None:
        """Do what is left. ``resumed`` is called with how many chunks are there already, and of how many."""
        todo = self.chunks().missing()
        if len(todo) < len(self.work):
            resumed(len(self.work) - len(todo), len(self.work))
        if not todo:
            return
        ticks = (part.scenario.ticks + 1 for number in todo for part in self.work[number - 1])
        advance = begin("simulating", len(todo) if self.workers else sum(ticks))
        self.chunks(advance).compute(todo, advance if self.workers else None)

    def chunks(self, progress: Advance | None = None) -> KeptChunks[RunsPass]:
        """The chunks in the folder; ``progress`` is called after every period that this process simulates."""
        keep = self.drawn and len(self.seeds) <= DRAWN_SEEDS
        one: Callable[[RunsPass], pa.Table]
        if self.workers is None:
            one = partial(run_pass, self.metrics, self.runs.__setitem__ if keep else None, progress)
        else:
            one = partial(run_pass, self.named, None, None)
        return KeptChunks(
            folder=self.folder,
            kind="study",
            key=self.key,
            count=len(self.work),
            chunk=lambda number: Chunk(number, self.work[number - 1]),
            one=partial(run_chunk, one, _place, {}, None),
            place=_place,
            workers=self.workers,
        )

    def rows(self) -> pd.DataFrame:
        """The rows of all chunks that are there, in the order of the whole table."""
        chunks = self.chunks()
        there = (number for number in range(1, chunks.count + 1) if chunks.content(number) is not None)
        tables = [_shown(chunks.table(number).to_pandas()) for number in there]
        return pd.concat(tables, ignore_index=True) if tables else pd.DataFrame()

    def comparisons(self) -> tuple[Comparison, ...]:
        """The comparisons, one for each group, when all is done; the runs of all points of a design count alike."""
        named = zip(self.work, self.chunks().tables(), strict=True)
        whole = {
            name: pd.concat([table.to_pandas() for _, table in parts], ignore_index=True)
            for name, parts in groupby(named, key=lambda part: part[0][0].scenario.name)
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
            seeds=tuple(self.seeds) if group[0].design is None else tuple(range(group[0].points * len(self.seeds))),
            table=pd.concat(pooled, ignore_index=True),
            runs=RunsAgain([case.scenario for case in group], laws, self.seeds, self.runs),
            metrics=own_metrics(self.metrics),
            notes=notes,
            values=values,
            points=group[0].points,
        )

    def _pooled(self, case: Case, table: pd.DataFrame) -> pd.DataFrame:
        """The table of a case by its name; the runs of a design are numbered through."""
        if case.plain:
            table["scenario"] = case.scenario.name
        if case.design is not None:
            table["seed"] += (table["point"] - 1) * len(self.seeds) - self.seeds[0]
            table = table.drop(columns=["point", *(axis.name for axis in case.design.sweep.axes)])
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
