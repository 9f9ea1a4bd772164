"""A folder of results belongs to one piece of work, and to one process at a time."""

import json
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from fuzzy.errors import InputError
from fuzzy.files.atomic import write_json


@contextmanager
def alone(folder: Path, busy: InputError) -> Iterator[None]:
    """Hold the folder's lock, which the system gives back however the process ends. Raises ``busy`` where it is held.

    Where files cannot be locked, as on Windows, nothing is held.
    """
    if sys.platform == "win32":
        yield
        return
    import fcntl

    with (folder / ".lock").open("w") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise busy from None
        yield


@contextmanager
def claimed(
    folder: Path,
    file: str,
    about: Mapping[str, Any],
    prepare: Callable[[], None],
    *,
    kind: str,
    fault: type[InputError],
    elsewhere: str = "--out",
    fresh: bool = False,
) -> Iterator[None]:
    """Hold a folder, which is made where it is missing, for the results of this very work, and for this process alone.

    Args:
        folder: The folder.
        file: The file in it that says what its results are of.
        about: All that determines them, as JSON can hold it; what the work itself says may stand below its ``kind``.
        prepare: Removes all results from the folder: first, so that no moment finds old ones under a new ``file``.
        kind: What messages call such work: "search".
        fault: The error of a folder that holds other results, or none that can be told, or is held by another process.
        elsewhere: What messages call another place: "folder".
        fresh: Whether to begin anew whatever stands there.
    """
    folder.mkdir(parents=True, exist_ok=True)
    path, about = folder / file, json.loads(json.dumps(about, default=str))
    busy = f"{folder}: another {kind} is at work here; wait for it, or give another {elsewhere}"
    with alone(folder, fault(busy)):
        if fresh or not path.exists():
            prepare()
            write_json(path, about)
        elif changed := _difference(_read(path, kind, fault), about, kind):
            raise fault(
                f"{folder} holds another {kind}: {changed}; give another {elsewhere}, or --fresh to throw it away and "
                "start over"
            )
        yield


def _read(path: Path, kind: str, fault: type[InputError]) -> Any:
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise fault(f"{path}: this is no {kind}: {error}; --fresh starts over") from None


def _difference(before: Any, now: Mapping[str, Any], kind: str) -> str:
    """What differs between all that determines some results and others, in words; "" if nothing does."""
    old, new = ({**_table(about), **_table(_table(about).get(kind))} for about in (before, now))
    changed = dict.fromkeys(key.removesuffix("_sha256") for key in {**new, **old} if old.get(key) != new.get(key))
    if [*changed] != ["versions"]:
        return f"{', '.join(k for k in changed if k != kind)} changed" if changed else ""
    was, own = _table(old.get("versions")), _table(new.get("versions"))
    return ", ".join(f"{k} {was.get(k)} became {own.get(k)}" for k in {**own, **was} if was.get(k) != own.get(k))


def _table(value: Any) -> dict[str, Any]:
    """A copy of a table; empty for what is none."""
    return dict(value) if isinstance(value, dict) else {}
