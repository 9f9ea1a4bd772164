"""Logs opened for reading: rosbag2 folders (mcap and sqlite3), single .mcap and .db3 files, and .bag files of ROS 1.

The definitions of types are those in the log; where it has none, those of a ROS 2 distribution.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from robotics.plugins.logs.typestore import (
    DEFAULT_DISTRIBUTION,
    LogError,
    check_distribution,
    check_installed,
    typestore,
)

SUFFIXES = (".mcap", ".db3", ".bag")
_TOPICS_NAMED = 12  # in a message


class Topic(NamedTuple):
    """A topic of a log."""

    name: str
    kind: str  # the type of its messages, such as nav_msgs/Odometry
    messages: int  # their number


class TopicColumn(NamedTuple):
    """The messages of a topic, each made into a row of numbers or into anything else."""

    arrival: np.ndarray  # (messages,) s: when each was written
    rows: list[Any]


class Bag:
    """An open log; see :func:`opened`."""

    def __init__(self, path: Path, reader: Any, distribution: str) -> None:
        self.path, self._reader, self._distribution = path, reader, distribution
        self._ros1 = path.suffix == ".bag" and path.is_file()
        counts: dict[tuple[str, str], int] = {}
        for one in reader.connections:
            key = (one.topic, one.msgtype.replace("/msg/", "/"))
            counts[key] = counts.get(key, 0) + one.msgcount
        self.topics = tuple(Topic(name, kind, count) for (name, kind), count in sorted(counts.items()))

    def said(self) -> str:
        """The topics with their types, for messages."""
        if not self.topics:
            return "it has no topics"
        shown = [f"{topic.name} ({topic.kind})" for topic in self.topics[:_TOPICS_NAMED]]
        more = len(self.topics) - len(shown)
        return f"it has {', '.join(shown)}{f' and {more} more' if more else ''}"

    def read(self, topic: Topic, row: Callable[[Any], Any]) -> TopicColumn:
        """All messages of ``topic`` in the order in which they were written, each as ``row`` makes it.

        Raises LogError where they cannot be read.
        """
        kind = topic.kind.replace("/", "/msg/")
        wanted = [one for one in self._reader.connections if (one.topic, one.msgtype) == (topic.name, kind)]
        store, times, rows = self._store(wanted), [], []
        with _readable(self.path, f"the messages of {topic.name} cannot be read"):
            for one, time, data in self._reader.messages(wanted):
                decode = store.deserialize_ros1 if self._ros1 else store.deserialize_cdr
                rows.append(row(decode(data, one.msgtype)))
                times.append(time)
        return TopicColumn(np.array(times, dtype=float) / 1e9, rows)

    def _store(self, connections: list[Any]) -> Any:
        """A typestore that knows the types of these topics, as the log itself defines them where it does."""
        from rosbags.interfaces import MessageDefinitionFormat
        from rosbags.typesys import Stores, get_types_from_idl, get_types_from_msg, get_typestore

        types: dict[str, Any] = {}
        for one in connections:
            text = one.msgdef.data
            with _readable(self.path, f"the definition of {one.msgtype} cannot be read"):
                if one.msgdef.format == MessageDefinitionFormat.MSG:
                    types |= get_types_from_msg(text, one.msgtype)
                elif one.msgdef.format == MessageDefinitionFormat.IDL:
                    rule = "=" * 80 + "\n"
                    parts = [part.partition("\n")[2] for part in text.split(rule)[1:]] if rule in text else [text]
                    for part in parts:
                        types |= get_types_from_idl(part)
        known = get_typestore(Stores.ROS1_NOETIC) if self._ros1 else typestore(self._distribution)
        if not types:
            for one in connections:
                if one.msgtype not in known.fielddefs:
                    raise LogError(
                        f"{self.path}: the log does not define {one.msgtype}, and ROS 2 {self._distribution} has none"
                    )
            return known
        store = get_typestore(Stores.EMPTY)
        with _readable(self.path, "the definitions of its types cannot be read"):
            store.register(types)
        return store


@contextmanager
def opened(path: str | Path, distribution: str = DEFAULT_DISTRIBUTION) -> Iterator[Bag]:
    """Open a log: a rosbag2 folder, or a file whose name ends in .mcap, .db3 or .bag.

    Args:
        path: The folder or file.
        distribution: The ROS 2 distribution whose types are meant where the log defines none.

    Raises LogError for what is no log, or is damaged.
    """
    check_installed()
    check_distribution(distribution)
    path = Path(path)
    if not path.exists():
        raise LogError(f"{path}: there is no such file or folder")
    if path.is_dir() and not (path / "metadata.yaml").is_file():
        inside = sorted(file.name for file in path.iterdir() if file.suffix in SUFFIXES)
        hint = f"; name the file {path / inside[0]}" if len(inside) == 1 else ""
        raise LogError(f"{path}: this folder is no rosbag2: it has no metadata.yaml{hint}")
    if path.is_file() and path.suffix not in SUFFIXES:
        raise LogError(f"{path}: a log is a rosbag2 folder or a file that ends in {', '.join(SUFFIXES)}")
    from rosbags.rosbag1 import Reader as FirstReader
    from rosbags.rosbag2 import Reader

    make: Any = FirstReader if path.is_file() and path.suffix == ".bag" else Reader
    with _readable(path, "this log cannot be opened"):
        reader = make(path)
        reader.open()
    try:
        yield Bag(path, reader, distribution)
    finally:
        reader.close()


@contextmanager
def _readable(path: Path, what: str) -> Iterator[None]:
    """Make a LogError of whatever reading raises: the libraries below raise errors of many kinds for broken bytes."""
    try:
        yield
    except LogError:
        raise
    except MemoryError:
        raise LogError(f"{path}: {what}: it asks for more memory than there is; it is damaged") from None
    except Exception as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise LogError(f"{path}: {what}: {reason}") from None
