"""Comparisons in a folder: what is done is kept as it goes, and the same work goes on from there after a stop.

A chunk holds the runs of one controller on one scenario, DRAWN_SEEDS of them at most. While the work goes on, or where
it was stopped, the folder of the results holds its chunks; they are discarded when all that is made of them is written.
"""

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from itertools import groupby
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

if TYPE_CHECKING:
    import pyarrow as pa

Quantity = tuple[str, str]  # of a claim: what is measured, and whose number of a run it is
_NOTES, _VALUE = "notes ", "value of "  # columns of chunks, beside those of the table


@dataclass(frozen=True)
class RunsPass:
    """The runs of a controller on a scenario with some seeds, and what of them claims ask for."""

    scenario: Scenario
    controller: str  # what it is called
    law: Law[Any] | str = field(repr=False)
    seeds: tuple[int, ...]
    quantities: tuple[Quantity, ...] = ()

    @property
    def key(self) -> tuple[str, str]:
        """The names of scenario and controller."""
        return self.scenario.name, self.controller


def passes(
    scenarios: Sequence[Scenario],
    laws: Mapping[str, Law[Any] | str],
    seeds: Sequence[int],
    quantities: Mapping[tuple[str, str], Iterable[Quantity]],
) -> Iterator[RunsPass]:
    """The passes of every controller on every scenario with the same seeds.

    ``quantities`` are what claims ask for, by the names of scenario and controller.
    """
    for scenario in scenarios:
        for name, law in laws.items():
            asked = tuple(dict.fromkeys(quantities.get((scenario.name, name), ())))
            for first in range(0, len(seeds), DRAWN_SEEDS):
                yield RunsPass(scenario, name, law, tuple(seeds[first : first + DRAWN_SEEDS]), asked)


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
    run = simulate(part.scenario, as_law(part.law), part.seeds, name=part.controller, progress=progress)
    if kept is not None:
        kept(part.key, run)
    rows = rows_of(run, own)
    robots = run.stopped.shape[1]
    for metric, whose in part.quantities:
        values = measured(run, quantity_called(metric, own), whose)
        rows[f"{_VALUE}{metric}, {whose}"] = np.repeat(values, robots)
    notes = RunNotes.of(run)
    said = json.dumps([notes.divergences, [list(one) for one in notes.outside]])
    rows[_NOTES] = [said, *[""] * (len(rows) - 1)]
    return pa.Table.from_pandas(rows, preserve_index=False).replace_schema_metadata()


def _place(part: RunsPass) -> str:
    return f"scenario {part.scenario.name!r}, controller {part.controller!r}"


@dataclass(frozen=True)
class KeptComparisons:
    """Comparisons with the same seeds, in a folder that belongs to them alone.

    Attributes:
        folder: The folder of the results.
        key: The digest of all that the numbers depend on.
        lasting: Whether the key tells, after a stop, that the chunks are of the same work.
        groups: The scenarios of a kind, each with the controllers that drive them.
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
    groups: Sequence[tuple[Sequence[Scenario], Mapping[str, Law[Any] | str]]]
    seeds: Sequence[int]
    quantities: Mapping[tuple[str, str], Iterable[Quantity]] = field(default_factory=dict)
    metrics: OwnMetrics = field(default_factory=dict)
    named: OwnMetrics = field(default_factory=dict)
    workers: Workers | None = None
    drawn: bool = False
    runs: dict[tuple[str, str], Run] = field(default_factory=dict)  # that stayed in memory

    @cached_property
    def passes(self) -> list[RunsPass]:
        """The work, a chunk each."""
        return [p for scenarios, laws in self.groups for p in passes(scenarios, laws, self.seeds, self.quantities)]

    def compute(self, begin: Callable[[str, int], Advance], resumed: Callable[[int, int], None]) -> None:
        """Do what is left. ``resumed`` is called with how many chunks are there already, and of how many."""
        todo = self.chunks().missing()
        if len(todo) < len(self.passes):
            resumed(len(self.passes) - len(todo), len(self.passes))
        if not todo:
            return
        ticks = (self.passes[number - 1].scenario.ticks + 1 for number in todo)
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
            count=len(self.passes),
            chunk=lambda number: Chunk(number, (self.passes[number - 1],)),
            one=partial(run_chunk, one, _place, {}, None),
            place=_place,
            workers=self.workers,
        )

    def rows(self) -> pd.DataFrame:
        """The rows of all chunks that are there, in the order of the whole table."""
        chunks, tables = self.chunks(), []
        for number in range(1, chunks.count + 1):
            if chunks.content(number) is not None:
                tables.append(_opened(chunks.table(number)).table)
        return pd.concat(tables, ignore_index=True) if tables else pd.DataFrame()

    def comparisons(self) -> tuple[Comparison, ...]:
        """The comparisons, one for each group, when all is done."""
        chunks, found = self.chunks().tables(), []
        parts = zip(self.passes, chunks, strict=True)
        whole = {key: [_opened(table) for _, table in rows] for key, rows in groupby(parts, key=lambda p: p[0].key)}
        for scenarios, laws in self.groups:
            mine = {(s.name, law): whole[s.name, law] for s in scenarios for law in laws}
            found.append(
                Comparison(
                    scenarios=tuple(scenarios),
                    controllers=chosen_laws(laws),
                    seeds=tuple(self.seeds),
                    table=pd.concat([part.table for parts in mine.values() for part in parts], ignore_index=True),
                    runs=RunsAgain(scenarios, laws, self.seeds, self.runs),
                    metrics=own_metrics(self.metrics),
                    notes={key: _joined(parts) for key, parts in mine.items()},
                    values={
                        (*key, *asked): np.concatenate([part.values[asked] for part in parts])
                        for key, parts in mine.items()
                        for asked in parts[0].values
                    },
                )
            )
        return tuple(found)


@dataclass(frozen=True)
class _Opened:
    """What a chunk's table holds."""

    table: pd.DataFrame
    notes: RunNotes
    values: dict[Quantity, np.ndarray]


def _opened(table: "pa.Table") -> _Opened:
    rows = table.to_pandas()
    divergences, left = json.loads(rows.pop(_NOTES)[0])
    first = rows["robot"].to_numpy() == 1
    values = {}
    for name in [name for name in rows if name.startswith(_VALUE)]:
        metric, _, whose = name.removeprefix(_VALUE).rpartition(", ")
        values[metric, whose] = rows.pop(name).to_numpy()[first]
    outside = tuple(OutsideInput(*one)._replace(universe=tuple(one[6])) for one in left)
    return _Opened(rows, RunNotes(tuple(divergences), outside), values)


def _joined(parts: Sequence[_Opened]) -> RunNotes:
    seeds = [part.table["seed"].nunique() for part in parts]
    left = merged([part.notes.outside for part in parts], seeds)
    return RunNotes(tuple(line for part in parts for line in part.notes.divergences), left)
