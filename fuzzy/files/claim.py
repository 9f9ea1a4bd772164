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


def claim(
    path: Path,
    about: Mapping[str, Any],
    discard: Callable[[], None],
    *,
    kind: str,
    elsewhere: str,
    fault: type[InputError],
    fresh: bool = False,
) -> None:
    """See that the folder of ``path`` holds results of this very work, or make it a folder for them.

    Args:
        path: The file that says what the folder's results are of.
        about: All that determines them, as JSON can hold it.
        discard: Removes all results from the folder: first, so that no moment finds old ones under a new ``path``.
        kind: What messages call such work: "search".
        elsewhere: What messages call another place: "folder".
        fault: The error of a folder that holds other results, or none that can be told.
        fresh: Whether to begin anew whatever stands there.
    """
    about = json.loads(json.dumps(about))
    if path.exists() and not fresh:
        try:
            there = json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise fault(f"{path}: this is no {kind}: {error}; --fresh starts over") from None
        if there == about:
            return
        there = there if isinstance(there, dict) else {}
        changed = [key for key in {**about, **there} if there.get(key) != about.get(key)]
        raise fault(
            f"{path.parent} holds another {kind}: {', '.join(changed)} changed; give another {elsewhere}, or --fresh "
            "to throw it away and start over"
        )
    discard()
    write_json(path, about)
