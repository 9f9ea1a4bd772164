"""Saving over a file that others may have changed meanwhile: nothing is replaced that nobody here has read."""

import hashlib
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from fuzzy.errors import InputError
from fuzzy.files.atomic import write_whole


class DocumentError(InputError):
    """A file that cannot be opened or saved as asked. The message names it and says what helps."""


class OverwriteError(DocumentError):
    """A file that saving would replace although the designer does not know what it holds."""


def digest_of(path: Path) -> str | None:
    """The digest of the file's bytes; None where there is none. DocumentError where it cannot be read."""
    data = bytes_of(path)
    return None if data is None else hashlib.sha256(data).hexdigest()


def bytes_of(path: Path) -> bytes | None:
    """The file's bytes; None where there is none. DocumentError where it cannot be read."""
    try:
        if not path.is_file():
            if path.exists():
                raise DocumentError(f"{path} is not a file")
            return None
        return path.read_bytes()
    except OSError as error:
        raise DocumentError(f"{path} cannot be read: {error.strerror or error}") from None


def check_untouched(path: Path, known: str | None, own: bool) -> None:
    """Raise OverwriteError where saving in ``path`` would replace what nobody here has read.

    Args:
        path: The file.
        known: The digest of what it held when it was read or written here last; None: it was not there.
        own: Whether it is the file that was opened; another one must not exist.
    """
    present = digest_of(path)
    if present is None or (own and present == known):
        return
    if not own:
        raise OverwriteError(f"{path.name} exists already; overwrite it or choose another name")
    raise OverwriteError(
        f"{path.name} was changed on disk by another program since it was opened here; "
        "save under another name, or overwrite it"
    )


@contextmanager
def alone_in(folder: Path) -> Iterator[None]:
    """Keep other processes from saving in the folder meanwhile, where the system can."""
    try:
        import fcntl
    except ImportError:  # Windows: two programs that save within the same millisecond are not told apart
        yield
        return
    try:
        handle = os.open(folder, os.O_RDONLY)
    except OSError as error:
        raise DocumentError(f"{folder} cannot be opened: {error.strerror or error}") from None
    try:
        fcntl.flock(handle, fcntl.LOCK_EX)
        yield
    finally:
        os.close(handle)


def save_text(path: Path, text: str, known: str | None, own: bool, overwrite: bool = False) -> str:
    """Write a text file in UTF-8, whole or not at all; give the digest of what it holds now.

    Raises OverwriteError, as of :func:`check_untouched`, unless ``overwrite``; DocumentError if it cannot be written.
    """
    if not path.parent.is_dir():
        raise DocumentError(f"{path}: there is no folder {path.parent}")
    data = text.encode("utf-8")
    with alone_in(path.parent):
        if not overwrite:
            check_untouched(path, known, own)
        try:
            write_whole(path, data)
        except OSError as error:
            raise DocumentError(f"{path.name} cannot be written: {error.strerror or error}") from None
    return hashlib.sha256(data).hexdigest()
