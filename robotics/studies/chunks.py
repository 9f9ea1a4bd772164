"""Chunks of runs: simulated by whoever does the work, kept in a folder, a Parquet file each, read back in their order.

Only the process that plans writes; a chunk's file appears whole or not at all and carries its number, the digest of
all that its numbers depend on, and a checksum. Work that was killed at any moment and is begun again computes the
chunks that have no file yet, or one that is not as it was written.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Generic, TypeVar

from fuzzy.errors import InputError
from fuzzy.files.atomic import write_whole
from fuzzy.files.sealed import UNSIGNED, intact, sealed
from fuzzy.shell.progress import Advance
from robotics.studies.executors import WorkerError, Workers
from robotics.studies.pieces import kept_piece, run_pieces
from robotics.studies.versions import versions

if TYPE_CHECKING:
    import pandas as pd
    import pyarrow as pa

_TRIES = 3  # times that a chunk is read, and computed again, when what was written cannot be read back


Pass = TypeVar("Pass")  # the runs that are simulated in one go: one scenario, one controller, some seeds


@dataclass(frozen=True)
class Chunk(Generic[Pass]):
    """The runs that are computed and written at a time, whole or not at all."""

    number: int  # from 1
    passes: tuple[Pass, ...]


def run_chunk(
    one: "Callable[[Pass], pd.DataFrame]",
    place: Callable[[Pass], str],
    expected: dict[str, str],
    fault: type[InputError] | None,
    chunk: Chunk[Pass],
) -> "pa.Table":
    """Simulate and measure a chunk, as a worker does, into a table with one row for each run and robot.

    Args:
        one: Simulates and measures a pass.
        place: What messages call a pass.
        expected: The versions with which the work was planned.
        fault: The error of a pass that fails, which names it; None: what went wrong comes as it was raised.
        chunk: The chunk.

    Raises ``fault`` where a run fails, and where the versions differ.
    """
    import pyarrow as pa

    for name, own in versions(*expected).items() if expected else ():
        if own != expected[name]:
            raise (fault or InputError)(f"a worker has {name} {own} where this was planned with {expected[name]}")
    tables = []
    for part in chunk.passes:
        try:
            rows = one(part)
        except Exception as error:
            if fault is None:
                raise
            # A worker's traceback is of little use far away; what was run can be run again by hand.
            message = str(error) if isinstance(error, InputError) else f"{type(error).__name__}: {error}"
            raise fault(f"{place(part)}: {message}") from error
        tables.append(pa.Table.from_pandas(rows, preserve_index=False).replace_schema_metadata())
    return pa.concat_tables(tables, promote_options="default").combine_chunks()


@dataclass(frozen=True)
class KeptChunks(Generic[Pass]):
    """The chunks of some work in a folder that belongs to it alone.

    Attributes:
        folder: The folder of the chunks.
        kind: What messages call such work: "sweep".
        key: The digest of all that the numbers depend on.
        count: The number of chunks.
        chunk: A chunk by its number, from 1.
        one: Computes a chunk, as a worker does.
        place: What messages call a pass.
        fault: The error of a chunk that fails; None: what went wrong comes as it was raised.
        workers: Who does the work, by default this process.
    """

    folder: Path
    kind: str
    key: str
    count: int
    chunk: Callable[[int], Chunk[Pass]]
    one: "Callable[[Chunk[Pass]], pa.Table]"
    place: Callable[[Pass], str]
    fault: type[InputError] | None = None
    workers: Workers | None = None

    def missing(self) -> list[int]:
        """The numbers of the chunks that are still to be computed; what a killed process was writing is removed."""
        self.folder.mkdir(parents=True, exist_ok=True)
        for left in self.folder.glob(".chunk-*"):
            left.unlink()
        return [number for number in range(1, self.count + 1) if self.content(number) is None]

    def compute(
        self,
        numbers: Iterable[int],
        advance: Advance | None = None,
        lost: Callable[[WorkerError], None] | None = None,
    ) -> None:
        """Compute chunks and write them, each as it gets done; ``lost`` is that of :func:`run_pieces`."""
        chunks = map(self.chunk, numbers)
        for chunk, table in run_pieces(
            self.one, chunks, self.workers, called=self._places, kept=self.fault, lost=lost, advance=advance
        ):
            _write(table, self.file(chunk.number), self.kind, self.key, chunk.number)

    def tables(self) -> "Iterator[pa.Table]":
        """The chunks in their order; one that cannot be read back is computed again."""
        return map(self.table, range(1, self.count + 1))

    def table(self, number: int) -> "pa.Table":
        """A chunk; one that cannot be read back is computed again."""
        for _ in range(_TRIES):
            if (found := self.there(number)) is not None:
                return found
            self.compute([number])
        raise (self.fault or InputError)(f"{self.file(number)}: what is written here cannot be read back")

    def there(self, number: int) -> "pa.Table | None":
        """A chunk, if its file is as it was written."""
        import pyarrow as pa
        import pyarrow.parquet as pq

        content = self.content(number)
        return None if content is None else pq.ParquetFile(pa.BufferReader(content)).read()

    def _places(self, chunk: Chunk[Pass]) -> str:
        first, *others = chunk.passes
        return self.place(first) + (" and what follows in its chunk" if others else "")

    def file(self, number: int) -> Path:
        """The file of a chunk."""
        return self.folder / f"chunk-{number:06}.parquet"

    def content(self, number: int) -> bytes | None:
        """The bytes of a chunk's file, if they are as they were written, and of that chunk of this very work."""
        import pyarrow as pa
        import pyarrow.parquet as pq

        def read(path: Path) -> bytes | None:
            try:
                content = path.read_bytes()
                metadata = pq.read_metadata(pa.BufferReader(content)).metadata if intact(content) else {}
            except (OSError, pa.ArrowInvalid):
                return None
            own = metadata.get(self.kind.encode()), metadata.get(b"chunk")
            return content if own == (self.key.encode(), str(number).encode()) else None

        return kept_piece(self.file(number), read, self.kind)


def discard_chunks(folder: Path) -> None:
    """Remove the chunks that a folder has."""
    for old in folder.glob("*chunk-*.parquet"):
        old.unlink(missing_ok=True)


def _write(table: "pa.Table", path: Path, kind: str, key: str, number: int) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    content = pa.BufferOutputStream()
    about = {kind: key, "chunk": str(number), "sha256": UNSIGNED}
    pq.write_table(table.replace_schema_metadata({**(table.schema.metadata or {}), **about}), content)
    write_whole(path, sealed(content.getvalue().to_pybytes()))
