"""Files that appear whole or not at all: they are written beside the target and then put in its place."""

import errno
import json
import os
import re
import secrets
import shutil
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any

from fuzzy.errors import InputError

_YOUNG = 1.0  # s: a file as young as that may not be locked yet
_FORGOTTEN = 3600.0  # s without a change, after which an unfinished file is left over where files cannot be locked
_swept: set[Path] = set()  # the targets beside which this process has cleared up


class TargetError(InputError):
    """A file or a folder into which nothing can be written. The message names it and says why."""


@contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """Give a path to write to, and put that file in the place of ``path`` when the block ends.

    On an error the new file is removed and ``path`` stays as it was. A link keeps its target, and an existing file
    keeps its permissions. A pipe or a device (/dev/stdout) cannot be replaced and is written directly. What a process
    that was killed has left unfinished beside ``path`` is removed by the next that writes it.

    Raises OSError, naming ``path``, where nothing can be written and where the block cannot write, as on a full disk.
    """
    target = Path(os.path.realpath(path))
    if target.is_dir():
        raise IsADirectoryError(errno.EISDIR, "is a directory, not a file to write", str(path))
    if target.exists() and not target.is_file():
        with _naming(path, target):
            yield target
        return
    if not target.parent.is_dir():
        raise _no_folder(path)
    _sweep(target)
    # The suffix stays, because writers of pictures choose the format by it.
    temporary = target.with_name(f".{_begin(target)}{secrets.token_hex(4)}{target.suffix}")
    with _naming(path, temporary), _locked(temporary):
        try:
            yield temporary
            if target.exists():
                shutil.copymode(target, temporary)
            temporary.replace(target)
        finally:
            temporary.unlink(missing_ok=True)


def write_whole(path: str | Path, content: str | bytes) -> None:
    """Write a file of text, as UTF-8 with its line ends as they are, or of bytes: whole or not at all.

    Raises OSError, as :func:`replacing` does.
    """
    data = content.encode() if isinstance(content, str) else content
    with replacing(path) as temporary:
        temporary.write_bytes(data)


def write_together(folder: str | Path, texts: Mapping[str, str]) -> list[Path]:
    """Write several files of text, as UTF-8, into a folder, which is made if it is not there; return their paths.

    All are written before the last of them is put in its place, then the others, the first one at the end: an error
    leaves what was there. Raises TargetError, OSError and UnicodeEncodeError.
    """
    folder = Path(folder)
    check_folder(folder)
    folder.mkdir(parents=True, exist_ok=True)
    with ExitStack() as stack:
        for name, text in texts.items():
            stack.enter_context(replacing(folder / name)).write_bytes(text.encode())
    return [folder / name for name in texts]


def write_json(path: str | Path, value: Any, default: Callable[[Any], Any] | None = None) -> None:
    """Write a value as JSON for people to read: whole or not at all.

    Args:
        path: The file.
        value: The value.
        default: Gives what stands for a value that JSON does not have.

    Raises OSError, as :func:`replacing` does.
    """
    write_whole(path, json.dumps(value, indent=2, ensure_ascii=False, default=default) + "\n")


def check_target(path: str | Path | None, *suffixes: str, folder_is_made: bool = False) -> None:
    """See, before long work, that ``path`` can be written. Raises TargetError.

    Args:
        path: The file; None: none is written.
        suffixes: The endings that its name may have, such as ".csv"; none: any.
        folder_is_made: Whether who writes it makes a folder that is missing.
    """
    if path is None:
        return
    target = Path(os.path.realpath(path))
    if suffixes and Path(path).suffix.lower() not in suffixes:
        raise TargetError(f"{path}: the file's name must end in {', '.join(suffixes)}")
    if target.is_dir():
        raise TargetError(f"{path}: is a directory, not a file to write")
    if target.exists() and not target.is_file():
        return
    if folder_is_made:
        check_folder(Path(path).parent)
    elif not target.parent.is_dir():
        raise TargetError(f"{path}: {_no_folder(path).strerror}")
    else:
        _check_open(path, target.parent)


def check_folder(path: str | Path) -> None:
    """See, before long work, that the folder ``path`` is there or can be made, and written into. Raises TargetError."""
    target = Path(os.path.realpath(path))
    there = next(place for place in (target, *target.parents) if place.exists())
    if not there.is_dir():
        raise TargetError(f"{path}: {str(there)!r} is a file, not a folder")
    _check_open(path, there)


def _check_open(path: str | Path, folder: Path) -> None:
    if not os.access(folder, os.W_OK | os.X_OK):
        raise TargetError(f"{path}: nothing can be written into the folder {str(folder)!r}")


def _no_folder(path: str | Path) -> FileNotFoundError:
    return FileNotFoundError(errno.ENOENT, f"there is no folder {str(Path(path).parent)!r} to write into", str(path))


@contextmanager
def _naming(path: str | Path, written: Path) -> Iterator[None]:
    """Let an OSError about ``written``, or about no file, name ``path``, for which it stands."""
    try:
        yield
    except OSError as error:
        if error.filename not in (None, str(written), written):
            raise
        number = error.errno or errno.EIO
        reason = os.strerror(error.errno) if error.errno else str(error)
        raise OSError(number, reason, str(path)) from None


@contextmanager
def _locked(temporary: Path) -> Iterator[None]:
    """Make the file, and hold its lock, which the system gives back however the process ends."""
    with temporary.open("xb") as file:
        if sys.platform != "win32":
            import fcntl

            with suppress(OSError):  # a file system without locks
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            yield
            return
    yield


def _begin(target: Path) -> str:
    return f"{target.stem[:40]}-"


def _sweep(target: Path) -> None:
    """Remove what killed processes have left of ``target``, once in a process."""
    if target in _swept:
        return
    _swept.add(target)
    own = re.compile(rf"\.{re.escape(_begin(target))}[0-9a-f]{{8}}{re.escape(target.suffix)}")
    with suppress(OSError):
        for entry in os.scandir(target.parent):
            if own.fullmatch(entry.name) and entry.is_file(follow_symlinks=False):
                with suppress(OSError):
                    _remove_stale(Path(entry.path))


def _remove_stale(path: Path) -> None:
    age = time.time() - path.stat().st_mtime
    if sys.platform == "win32":
        if age > _FORGOTTEN:
            path.unlink()
        return
    if age < _YOUNG:
        return
    import fcntl

    with path.open("rb") as file:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)  # OSError: somebody is writing it
        path.unlink()
