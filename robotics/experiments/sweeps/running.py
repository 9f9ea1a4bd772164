"""Running a sweep: chunks through any ``concurrent.futures.Executor``, into one Parquet file each, then one table.

Only the process that plans writes; a chunk's file appears whole or not at all and carries its number, the sweep's
digest and a checksum. A sweep that was killed at any moment and is begun again computes the chunks that have no file
yet, or one that is not as it was written.
"""

import json
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, CancelledError, Future
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fuzzy.errors import InputError
from fuzzy.files.atomic import replacing, write_json, write_whole
from fuzzy.files.claim import alone
from fuzzy.files.sealed import UNSIGNED, intact, sealed
from fuzzy.shell.progress import Begin
from robotics.experiments.executors import InProcess, WorkerError, Workers, as_done
from robotics.experiments.sweeps.plan import (
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
    versions,
)
from robotics.laws.catalogue import make_controller
from robotics.measures.registry import measure_all, own_metrics
from robotics.simulation.loop import simulate

if TYPE_CHECKING:
    import pyarrow as pa

_PLAN, RESULTS, CHUNKS = "plan.json", "results.parquet", "chunks"
ROW_GROUP = 65_536  # rows
_LOST = "the connection to the cluster is lost; the same command goes on from there"


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


def run_chunk(sweep: Sweep, chunk: Chunk, expected: dict[str, str]) -> "pa.Table":
    """Simulate and measure a chunk, as a worker does, into a table with one row for each run and robot.

    Args:
        sweep: The sweep.
        chunk: The chunk.
        expected: The versions with which the sweep was planned.

    Raises SweepError, naming point and seeds, where a run fails, and where the versions differ.
    """
    import pyarrow as pa

    for name, own in versions().items():
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
    begin: Begin | None = None,
    resumed: Callable[[int, int], None] | None = None,
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
    folder.mkdir(parents=True, exist_ok=True)
    busy = SweepError(f"{folder}: another sweep is at work here; wait for it, or give another --out")
    with alone(folder, busy):
        about = identity(plan)
        if fresh:
            _clear(folder)
        _open_plan(plan, folder, about, begin)
        key = digest(about)
        todo = _missing(plan, folder, key)
        if resumed is not None and len(todo) < plan.chunks:
            resumed(plan.chunks - len(todo), plan.chunks)
        advance = begin(f"{plan.sweep.name}: {plan.chunks} chunks", len(todo)) if begin and todo else None
        computed = 0
        while True:
            for number, table in _computed(plan, todo, workers or Workers(InProcess()), about["versions"]):
                _write(table, _file(folder, number), key, number)
                computed += 1
                if advance is not None:
                    advance()
            try:
                rows, diverged, contacts = _gather(plan, folder, key)
                break
            except _SpoiltError as spoilt:
                if computed > 2 * plan.chunks:
                    raise SweepError(
                        f"{_file(folder, spoilt.number)}: what is written here cannot be read back"
                    ) from None
                _say_spoilt(_file(folder, spoilt.number))
                todo = [spoilt.number]
    return SweepOutcome(folder / RESULTS, rows, plan.runs, diverged, contacts, plan.chunks, computed)


def landed_chunks(plan: SweepPlan, folder: Path) -> int:
    """The number of chunks of the sweep that ``folder`` holds."""
    key = digest(identity(plan))
    return sum(_landed(_file(folder, number), key, number) is True for number in range(1, plan.chunks + 1))


def _missing(plan: SweepPlan, folder: Path, key: str) -> list[int]:
    """The numbers of the chunks that are to be computed; of those with a file that cannot be used it is said."""
    todo = []
    for number in range(1, plan.chunks + 1):
        landed = _landed(_file(folder, number), key, number)
        if landed is None:
            _say_spoilt(_file(folder, number))
        if not landed:
            todo.append(number)
    return todo


def _say_spoilt(path: Path) -> None:
    warnings.warn(f"{path} is damaged, or is not this chunk of this sweep; it is computed again", stacklevel=2)


def _computed(
    plan: SweepPlan, todo: list[int], workers: Workers, expected: dict[str, str]
) -> "Iterator[tuple[int, pa.Table]]":
    """Chunks as they get done."""

    def submit(chunk: Chunk) -> "Future[Any]":
        return workers.executor.submit(run_chunk, plan.sweep, chunk, expected)

    for chunk, future in as_done(map(plan.chunk, todo), submit, workers, SweepError(_LOST)):
        try:
            table = future.result()
        except SweepError:
            raise
        except WorkerError as error:
            raise SweepError(f"{_places(plan.sweep, chunk)}: {error}; the same command goes on from there") from None
        except BrokenExecutor:
            raise SweepError("the workers are gone; the same command goes on from there") from None
        except CancelledError:
            raise SweepError(_LOST) from None
        except Exception as error:
            place = _places(plan.sweep, chunk)
            raise SweepError(f"{place}: {type(error).__name__}: {error}") from error
        yield chunk.number, table


# The folder -------------------------------------------------------------------------------------------------------


def _file(folder: Path, number: int) -> Path:
    return folder / CHUNKS / f"chunk-{number:06}.parquet"


def _clear(folder: Path) -> None:
    (folder / _PLAN).unlink(missing_ok=True)
    (folder / RESULTS).unlink(missing_ok=True)
    for file in (folder / CHUNKS).glob("chunk-*.parquet"):
        file.unlink()


def _open_plan(plan: SweepPlan, folder: Path, about: dict[str, Any], begin: Begin | None) -> None:
    """Check and write the plan, or see that the folder's is the same."""
    (folder / CHUNKS).mkdir(exist_ok=True)
    for place, name in ((folder, ".plan-*"), (folder, ".results-*"), (folder / CHUNKS, ".chunk-*")):
        for left in place.glob(name):  # what a killed process was just writing
            left.unlink()
    path = folder / _PLAN
    about = json.loads(json.dumps(about, default=str))
    if path.exists():
        try:
            found = json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise SweepError(f"{path}: this is no sweep's plan: {error}; --fresh starts over") from None
        changed = _changed(found, about)
        if changed:
            raise SweepError(
                f"{folder} holds results of another sweep: {changed} since they were computed; give another --out, "
                "or --fresh to throw them away and start over"
            )
        return
    check_plan(plan, begin("checking every point", len(plan.points)) if begin else None)
    (folder / RESULTS).unlink(missing_ok=True)
    write_json(path, about)


def _changed(found: Any, about: dict[str, Any]) -> str:
    """What differs between two plans, in words; "" if nothing does."""
    found = found if isinstance(found, dict) else {}
    sweeps = found.get("sweep") if isinstance(found.get("sweep"), dict) else {}
    fields = [name for name, value in about["sweep"].items() if sweeps.get(name) != value]
    if fields:
        return f"{', '.join(fields)} changed"
    if found.get("scenario_sha256") != about["scenario_sha256"]:
        return f"scenario {about['sweep']['scenario']!r} changed"
    if found.get("files_sha256") != about["files_sha256"]:
        return "a file that a controller reads changed"
    before = found.get("versions") if isinstance(found.get("versions"), dict) else {}
    packages = [f"{k} {before.get(k)} became {v}" for k, v in about["versions"].items() if before.get(k) != v]
    return ", ".join(packages)


class _SpoiltError(Exception):
    """A chunk's file that is not as it was written."""

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.number = number


def _landed(path: Path, key: str, number: int) -> bool | None:
    """Does ``path`` hold the chunk of that number of the sweep with that digest? None: it is something else."""
    if not path.exists():
        return False
    return True if _content(path, key, number) is not None else None


def _content(path: Path, key: str, number: int) -> bytes | None:
    """The bytes of a chunk's file, if they are as they were written, and of that chunk of that sweep."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        content = path.read_bytes()
        metadata = pq.read_metadata(pa.BufferReader(content)).metadata if intact(content) else None
    except (OSError, pa.ArrowInvalid):
        return None
    own = (metadata or {}).get(b"sweep"), (metadata or {}).get(b"chunk")
    return content if own == (key.encode(), str(number).encode()) else None


def _write(table: "pa.Table", path: Path, key: str, number: int) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    content = pa.BufferOutputStream()
    about = {"sweep": key, "chunk": str(number), "sha256": UNSIGNED}
    pq.write_table(table.replace_schema_metadata(about), content)
    write_whole(path, sealed(content.getvalue().to_pybytes()))


def _gather(plan: SweepPlan, folder: Path, key: str) -> tuple[int, int, int]:
    """All chunks in one file, in the plan's order; how many rows, rows of stopped robots, and runs with contacts.

    Raises _SpoiltError for a chunk whose file is not as it was written.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    rows = diverged = contacts = 0
    with replacing(folder / RESULTS) as temporary:
        writer: pq.ParquetWriter | None = None
        batch: list[pa.Table] = []
        try:
            for number in range(1, plan.chunks + 1):
                content = _content(_file(folder, number), key, number)
                if content is None:
                    raise _SpoiltError(number)
                batch.append(pq.ParquetFile(pa.BufferReader(content)).read().replace_schema_metadata({"sweep": key}))
                if sum(t.num_rows for t in batch) >= ROW_GROUP or number == plan.chunks:
                    table = pa.concat_tables(batch).combine_chunks()
                    rows, batch = rows + table.num_rows, []
                    diverged += int(np.count_nonzero(table["diverged"].to_numpy()))
                    if "contact" in table.column_names:
                        touched = table["contact"].to_numpy() & (table["robot"].to_numpy() == 1)
                        contacts += int(np.count_nonzero(touched))
                    writer = writer or pq.ParquetWriter(temporary, table.schema)
                    writer.write_table(table)
        finally:
            if writer is not None:
                writer.close()
    return rows, diverged, contacts
