"""Running a sweep: chunks through any ``concurrent.futures.Executor``, into one Parquet file each, then one table."""

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fuzzy.files.atomic import replacing
from fuzzy.files.claim import claimed
from fuzzy.shell.progress import Begin, unwatched
from robotics.laws.catalogue import make_controller
from robotics.measures.registry import measure_all, own_metrics
from robotics.simulation.loop import simulate
from robotics.studies.chunks import KeptChunks, discard_chunks, run_chunk
from robotics.studies.executors import Workers
from robotics.studies.sweeps.plan import (
    Pass,
    Sweep,
    SweepError,
    SweepPlan,
    check_plan,
    column_value,
    controller_at,
    described,
    digest,
    identity,
    metrics_at,
    scenario_at,
    touchable,
)

if TYPE_CHECKING:
    import pyarrow as pa

_PLAN, RESULTS, CHUNKS = "plan.json", "results.parquet", "chunks"
ROW_GROUP = 65_536  # rows


@dataclass(frozen=True)
class SweepOutcome:
    """What a finished sweep left in its folder."""

    results: Path
    rows: int  # one a run and robot
    runs: int
    diverged: int  # rows of robots that were stopped
    contacts: int  # runs in which robots touched each other or an obstacle
    chunks: int
    computed: int  # chunks of this time; the others were there


# One pass --------------------------------------------------------------------------------------------------------


def _run_pass(sweep: Sweep, part: Pass) -> "pa.Table":
    import pyarrow as pa

    scenario = scenario_at(sweep, part.values)
    run = simulate(scenario, make_controller(controller_at(sweep, part.controller, part.values)), part.seeds)
    runs, robots = run.stopped.shape
    columns: dict[str, Any] = {
        "scenario": pa.array([sweep.scenario] * (runs * robots)),
        "point": np.full(runs * robots, part.point),
        "controller": pa.array([part.controller] * (runs * robots)),
        "seed": np.repeat(np.array(run.seeds, dtype=np.int64), robots),
        "robot": np.tile(np.arange(1, robots + 1), runs),
    }
    columns |= {
        a.name: pa.array([column_value(v)] * (runs * robots)) for a, v in zip(sweep.axes, part.values, strict=True)
    }
    own = own_metrics(metrics_at(sweep), scenario.kind)
    values = dict.fromkeys(own, np.full((runs, robots), np.nan)) | measure_all(run, own)
    # Whether there are contacts may differ from point to point, the columns may not.
    touched = values.pop("contacts", np.zeros((runs, robots)))
    clearance = values.pop("min_clearance_m", np.full((runs, robots), np.inf))
    values.pop("emergency_share", None)  # nor may they from law to law
    columns |= {name: np.ascontiguousarray(v, dtype=float).ravel() for name, v in values.items()}
    columns["diverged"] = run.diverged.ravel()
    if touchable(sweep):
        columns |= {"contacts": touched.ravel(), "min_clearance_m": clearance.ravel()}
        columns["contact"] = np.repeat((touched > 0).any(axis=1), robots)
    return pa.table(columns)


def _place(sweep: Sweep, part: Pass) -> str:
    seeds = f"seed {part.seeds[0]}" if len(part.seeds) == 1 else f"seeds {part.seeds[0]} to {part.seeds[-1]}"
    return f"{described(sweep, part.point, part.values)}, controller {part.controller!r}, {seeds}"


# All of them ------------------------------------------------------------------------------------------------------


def run_sweep(
    plan: SweepPlan,
    folder: Path,
    workers: Workers | None = None,
    *,
    fresh: bool = False,
    begin: Begin = unwatched,
    resumed: Callable[[int, int], None] = lambda done, chunks: None,
) -> SweepOutcome:
    """Do what is left of a sweep and write ``folder/results.parquet``, in the plan's order, whole or not at all.

    Args:
        plan: The plan.
        folder: The folder of the results.
        workers: What runs the chunks, by default this process.
        fresh: Whether to discard what the folder holds of a sweep.
        begin: Starts a bar of a progress display, by its text and total.
        resumed: Called with how many chunks are already there, and of how many.

    Raises SweepError where the folder holds another sweep, a point is refused or a run fails; what was written stays.
    """
    about = identity(plan)
    chunks = _chunks(plan, folder, about, workers)

    def prepare() -> None:
        check_plan(plan, begin("checking every point", len(plan.points)))
        (folder / RESULTS).unlink(missing_ok=True)
        discard_chunks(folder / CHUNKS)

    with claimed(folder, _PLAN, about, prepare, kind="sweep", fault=SweepError, fresh=fresh):
        todo = chunks.missing()
        if len(todo) < plan.chunks:
            resumed(plan.chunks - len(todo), plan.chunks)
        if todo:
            chunks.compute(todo, begin(f"{plan.sweep.name}: {plan.chunks} chunks", len(todo)))
        rows, diverged, contacts = _gather(chunks, folder)
    return SweepOutcome(folder / RESULTS, rows, plan.runs, diverged, contacts, plan.chunks, len(chunks.computed))


def landed_chunks(plan: SweepPlan, folder: Path) -> int:
    """The number of chunks of the sweep that ``folder`` holds."""
    chunks = _chunks(plan, folder, identity(plan))
    return sum(chunks.content(number) is not None for number in range(1, plan.chunks + 1))


def _chunks(plan: SweepPlan, folder: Path, about: dict[str, Any], workers: Workers | None = None) -> KeptChunks[Pass]:
    place = partial(_place, plan.sweep)
    one = partial(run_chunk, partial(_run_pass, plan.sweep), place, about["versions"], SweepError)
    return KeptChunks(folder / CHUNKS, "sweep", digest(about), plan.chunks, plan.chunk, one, place, SweepError, workers)


def _gather(chunks: KeptChunks[Pass], folder: Path) -> tuple[int, int, int]:
    """All chunks in one file, in the plan's order; how many rows, rows of stopped robots, and runs with contacts."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    rows = diverged = contacts = 0
    with replacing(folder / RESULTS) as temporary, ExitStack() as stack:
        writer: pq.ParquetWriter | None = None
        batch: list[pa.Table] = []
        for number, table in enumerate(chunks.tables(), start=1):
            batch.append(table.replace_schema_metadata({"sweep": chunks.key}))
            if sum(t.num_rows for t in batch) >= ROW_GROUP or number == chunks.count:
                table = pa.concat_tables(batch).combine_chunks()
                rows, batch = rows + table.num_rows, []
                diverged += int(np.count_nonzero(table["diverged"].to_numpy()))
                if "contact" in table.column_names:
                    touched = table["contact"].to_numpy() & (table["robot"].to_numpy() == 1)
                    contacts += int(np.count_nonzero(touched))
                writer = writer or stack.enter_context(pq.ParquetWriter(temporary, table.schema))
                writer.write_table(table)
    return rows, diverged, contacts
