"""Running a sweep: chunks through any ``concurrent.futures.Executor``, into one Parquet file each, then one table.

Only the process that plans writes; a chunk's file appears whole or not at all and carries its number, the sweep's
digest and a checksum. A sweep that was killed at any moment and is begun again computes the chunks that have no file
yet, or one that is not as it was written.
"""

import json
from collections.abc import Callable, Iterable
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fuzzy.errors import InputError
from fuzzy.files.atomic import replacing, write_whole
from fuzzy.files.claim import claimed
from fuzzy.files.sealed import UNSIGNED, intact, sealed
from fuzzy.shell.progress import Advance, Begin, unwatched
from robotics.laws.catalogue import make_controller
from robotics.measures.registry import measure_all, own_metrics
from robotics.simulation.loop import simulate
from robotics.studies.executors import Workers
from robotics.studies.pieces import kept_piece, run_pieces
from robotics.studies.sweeps.plan import (
    Chunk,
    Pass,
    Sweep,
    SweepError,
    SweepPlan,
    check_plan,
    controller_at,
    described,
    digest,
    identity,
    metrics_at,
    scenario_at,
    touchable,
)
from robotics.studies.versions import versions

if TYPE_CHECKING:
    import pyarrow as pa

_PLAN, RESULTS, CHUNKS = "plan.json", "results.parquet", "chunks"
ROW_GROUP = 65_536  # rows
_TRIES = 3  # times that a chunk is read, and computed again, when what was written cannot be read back


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


# One chunk --------------------------------------------------------------------------------------------------------


def run_chunk(sweep: Sweep, expected: dict[str, str], chunk: Chunk) -> "pa.Table":
    """Simulate and measure a chunk, as a worker does, into a table with one row for each run and robot.

    Args:
        sweep: The sweep.
        expected: The versions with which the sweep was planned.
        chunk: The chunk.

    Raises SweepError, naming point and seeds, where a run fails, and where the versions differ.
    """
    import pyarrow as pa

    for name, own in versions(*expected).items():
        if own != expected[name]:
            raise SweepError(f"a worker has {name} {own} where the sweep was planned with {expected[name]}")
    tables = []
    for part in chunk.passes:
        try:
            tables.append(_run_pass(sweep, part))
        except Exception as error:
            # A worker's traceback is of little use far away; what was run can be run again by hand.
            message = str(error) if isinstance(error, InputError) else f"{type(error).__name__}: {error}"
            raise SweepError(f"{_place(sweep, part)}: {message}") from error
    return pa.concat_tables(tables).combine_chunks()


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
    columns |= {a.name: _column(v, runs * robots) for a, v in zip(sweep.axes, part.values, strict=True)}
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


def _column(value: Any, rows: int) -> "pa.Array":
    """An axis's column: of its levels' type, or JSON text for what is neither number, text nor truth value."""
    import pyarrow as pa

    if isinstance(value, (bool, int, float, str)):
        return pa.array([value] * rows)
    return pa.array([json.dumps(value, ensure_ascii=False, default=str)] * rows)


def _place(sweep: Sweep, part: Pass) -> str:
    seeds = f"seed {part.seeds[0]}" if len(part.seeds) == 1 else f"seeds {part.seeds[0]} to {part.seeds[-1]}"
    return f"{described(sweep, part.point, part.values)}, controller {part.controller!r}, {seeds}"


def _places(sweep: Sweep, chunk: Chunk) -> str:
    first, *others = chunk.passes
    return _place(sweep, first) + (" and what follows in its chunk" if others else "")


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
    key, computed = digest(about), list[int]()

    def prepare() -> None:
        check_plan(plan, begin("checking every point", len(plan.points)))
        for old in (folder / RESULTS, *(folder / CHUNKS).glob("chunk-*.parquet")):
            old.unlink(missing_ok=True)

    def compute(numbers: Iterable[int], advance: Advance | None = None) -> None:
        work, called = partial(run_chunk, plan.sweep, about["versions"]), partial(_places, plan.sweep)
        chunks = map(plan.chunk, numbers)
        for chunk, table in run_pieces(work, chunks, workers, called=called, kept=SweepError, advance=advance):
            _write(table, _file(folder, chunk.number), key, chunk.number)
            computed.append(chunk.number)

    def content(number: int) -> bytes:
        for _ in range(_TRIES):
            if (found := _content(folder, key, number)) is not None:
                return found
            compute([number])
        raise SweepError(f"{_file(folder, number)}: what is written here cannot be read back")

    with claimed(folder, _PLAN, about, prepare, kind="sweep", fault=SweepError, fresh=fresh):
        (folder / CHUNKS).mkdir(exist_ok=True)
        for left in (folder / CHUNKS).glob(".chunk-*"):  # what a killed process was just writing
            left.unlink()
        todo = [number for number in range(1, plan.chunks + 1) if _content(folder, key, number) is None]
        if len(todo) < plan.chunks:
            resumed(plan.chunks - len(todo), plan.chunks)
        if todo:
            compute(todo, begin(f"{plan.sweep.name}: {plan.chunks} chunks", len(todo)))
        rows, diverged, contacts = _gather(plan, folder, key, content)
    return SweepOutcome(folder / RESULTS, rows, plan.runs, diverged, contacts, plan.chunks, len(computed))


def landed_chunks(plan: SweepPlan, folder: Path) -> int:
    """The number of chunks of the sweep that ``folder`` holds."""
    key = digest(identity(plan))
    return sum(_content(folder, key, number) is not None for number in range(1, plan.chunks + 1))


# The folder -------------------------------------------------------------------------------------------------------


def _file(folder: Path, number: int) -> Path:
    return folder / CHUNKS / f"chunk-{number:06}.parquet"


def _content(folder: Path, key: str, number: int) -> bytes | None:
    """The bytes of a chunk's file, if they are as they were written, and of that chunk of that sweep."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    def read(path: Path) -> bytes | None:
        try:
            content = path.read_bytes()
            metadata = pq.read_metadata(pa.BufferReader(content)).metadata if intact(content) else {}
        except (OSError, pa.ArrowInvalid):
            return None
        own = metadata.get(b"sweep"), metadata.get(b"chunk")
        return content if own == (key.encode(), str(number).encode()) else None

    return kept_piece(_file(folder, number), read, "sweep")


def _write(table: "pa.Table", path: Path, key: str, number: int) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    content = pa.BufferOutputStream()
    about = {"sweep": key, "chunk": str(number), "sha256": UNSIGNED}
    pq.write_table(table.replace_schema_metadata(about), content)
    write_whole(path, sealed(content.getvalue().to_pybytes()))


def _gather(plan: SweepPlan, folder: Path, key: str, content: Callable[[int], bytes]) -> tuple[int, int, int]:
    """All chunks in one file, in the plan's order; how many rows, rows of stopped robots, and runs with contacts."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    rows = diverged = contacts = 0
    with replacing(folder / RESULTS) as temporary, ExitStack() as stack:
        writer: pq.ParquetWriter | None = None
        batch: list[pa.Table] = []
        for number in range(1, plan.chunks + 1):
            table = pq.ParquetFile(pa.BufferReader(content(number))).read()
            batch.append(table.replace_schema_metadata({"sweep": key}))
            if sum(t.num_rows for t in batch) >= ROW_GROUP or number == plan.chunks:
                table = pa.concat_tables(batch).combine_chunks()
                rows, batch = rows + table.num_rows, []
                diverged += int(np.count_nonzero(table["diverged"].to_numpy()))
                if "contact" in table.column_names:
                    touched = table["contact"].to_numpy() & (table["robot"].to_numpy() == 1)
                    contacts += int(np.count_nonzero(touched))
                writer = writer or stack.enter_context(pq.ParquetWriter(temporary, table.schema))
                writer.write_table(table)
    return rows, diverged, contacts
