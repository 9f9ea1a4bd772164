"""Runs written as logs: an MCAP file, or a rosbag2 folder, whole or not at all.

Both are written by the package ``rosbags``, without ROS. Definitions of all types stand in the log itself, so that
whoever reads it needs none. The same run gives the same bytes.
"""

import os
import secrets
import shutil
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any, Literal, get_args

from fuzzy.files.atomic import TargetError, check_folder, check_target, replacing
from fuzzy.naming import check_known
from robotics.plugins.logs.content import LogRecord, facts, records
from robotics.plugins.logs.messages import Composer, nanoseconds
from robotics.plugins.logs.typestore import DEFAULT_DISTRIBUTION, DISTRIBUTIONS, LogError, check_installed, typestore
from robotics.simulation.run import Run

Storage = Literal["mcap", "sqlite3"]
Records = Callable[[Composer], Iterable[LogRecord]]


def check_mcap(path: Path) -> None:
    """See, before long work, that an MCAP file can be written to ``path``. Raises LogError or TargetError."""
    check_installed()
    check_target(path, ".mcap")


def check_rosbag(folder: Path) -> None:
    """See, before long work, that a rosbag2 folder can be written to ``folder``. Raises LogError or TargetError."""
    check_installed()
    if os.path.lexists(folder):
        raise TargetError(f"{folder}: exists already, and a rosbag2 folder is never overwritten; name another")
    check_folder(folder)


def check_storage(storage: str) -> None:
    """Raise LogError for a storage of rosbag2 folders that there is not."""
    check_known(storage, get_args(Storage), "storage of a rosbag2 folder", LogError)


def write_mcap(
    run: Run,
    path: str | Path,
    *,
    seed: int | None = None,
    distribution: str = DEFAULT_DISTRIBUTION,
    progress: Callable[[], None] | None = None,
) -> None:
    """Write the run of one seed as an MCAP file of ROS 2 messages, which Foxglove opens.

    docs/howto/logs.md lists its topics.

    What the run does not keep is left out; ``simulate(..., message_ages=True, encoders=True, messages=True)`` keeps it.

    Args:
        run: The run.
        path: The file, whose name ends in .mcap; one that is there is replaced.
        seed: The seed, which a run of several needs.
        distribution: The ROS 2 distribution whose types of messages are used: humble, iron, jazzy or kilted.
        progress: Called after every sample.

    Raises:
        LogError: A seed or a distribution that is not there, or packages that are missing.
        TargetError: The place is not one to write to.
        OSError: The file cannot be written.
    """
    chosen = _seed(run, seed)
    write_records(partial(records, run, chosen), facts(run, chosen), path, distribution, progress)


def write_records(
    made: Records,
    about: Mapping[str, str],
    path: str | Path,
    distribution: str = DEFAULT_DISTRIBUTION,
    progress: Callable[[], None] | None = None,
) -> None:
    """Write messages as an MCAP file.

    Args:
        made: What makes the messages, in the order of time, with a composer of their types.
        about: What the log says of itself beside its topics.
        path: As of :func:`write_mcap`, which raises what this raises, with ``distribution`` and ``progress``.
        distribution: The ROS 2 distribution.
        progress: Called after every time at which there is a message.
    """
    path = Path(path)
    check_mcap(path)
    with replacing(path) as temporary, _beside(path) as room:
        folder = room / path.stem
        _write(made, about, folder, distribution, "mcap", progress)
        (folder / f"{folder.name}.mcap").replace(temporary)


def write_rosbag(
    run: Run,
    folder: str | Path,
    *,
    seed: int | None = None,
    distribution: str = DEFAULT_DISTRIBUTION,
    storage: Storage = "mcap",
    progress: Callable[[], None] | None = None,
) -> None:
    """Write the run of one seed as a rosbag2 folder, which ``ros2 bag`` reads; arguments as of :func:`write_mcap`.

    Args:
        run: The run.
        folder: The folder, which must not be there yet.
        seed: The seed, which a run of several needs.
        distribution: The ROS 2 distribution whose types of messages, and whose metadata, are used.
        storage: mcap, or sqlite3 as before ROS 2 Iron.
        progress: Called after every sample.

    Raises:
        LogError: As of :func:`write_mcap`; also an unknown storage.
        TargetError: The folder is there already, or is no place to write to.
        OSError: It cannot be written.
    """
    folder = Path(folder)
    check_rosbag(folder)
    check_storage(storage)
    folder.parent.mkdir(parents=True, exist_ok=True)
    with _beside(folder) as room:
        made, chosen = room / folder.name, _seed(run, seed)
        _write(partial(records, run, chosen), facts(run, chosen), made, distribution, storage, progress)
        made.rename(folder)


def _seed(run: Run, seed: int | None) -> int:
    """The seed that is meant. Raises LogError."""
    if seed is None and len(run.seeds) > 1:
        raise LogError(f"a log holds the run of one seed, and this run has {len(run.seeds)}: name the seed")
    chosen = run.seeds[0] if seed is None else seed
    if chosen not in run.seeds:
        raise LogError(f"the run has no seed {chosen}: it has {', '.join(map(str, run.seeds[:10]))}")
    return chosen


@contextmanager
def _beside(target: Path) -> Iterator[Path]:
    """A folder beside ``target`` to write in, which goes with all that is left in it."""
    room = Path(os.path.realpath(target)).with_name(f".{target.stem[:40]}-{secrets.token_hex(4)}")
    room.mkdir()
    try:
        yield room
    finally:
        shutil.rmtree(room, ignore_errors=True)


def _write(
    made: Records,
    about: Mapping[str, str],
    folder: Path,
    distribution: str,
    storage: Storage,
    progress: Callable[[], None] | None,
) -> None:
    """Write a rosbag2 folder."""
    store = typestore(distribution)
    from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer

    make: Any = Writer
    writer = make(folder, version=DISTRIBUTIONS[distribution], storage_plugin=StoragePlugin[storage.upper()])
    if storage == "mcap":
        writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
    for name, value in about.items():
        writer.set_custom_data(name, value)
    with writer:
        connections: dict[str, Any] = {}
        reached = 0.0
        for record in made(Composer(store)):
            kind = record.message.__msgtype__
            if record.topic not in connections:
                how = {"typestore": store, "offered_qos_profiles": [_quality(record)]}
                connections[record.topic] = writer.add_connection(record.topic, kind, **how)
            content = store.serialize_cdr(record.message, kind)
            writer.write(connections[record.topic], nanoseconds(record.time), content)
            if progress is not None and record.time > reached:
                reached = record.time
                progress()


def _quality(record: LogRecord) -> Any:
    """How a topic is offered: what is said once is kept for those that come later."""
    from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime

    never = QosTime(9223372036, 854775807)
    return Qos(
        QosHistory.KEEP_LAST,
        1 if record.once else 10,
        QosReliability.RELIABLE,
        QosDurability.TRANSIENT_LOCAL if record.once else QosDurability.VOLATILE,
        never,
        never,
        QosLiveliness.AUTOMATIC,
        never,
        False,
    )
