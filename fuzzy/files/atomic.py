"""Files that appear whole or not at all: they are written beside the target and then put in its place."""

import os
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """Give a path to write to, and put that file in the place of ``path`` when the block ends.

    On an error the new file is removed and ``path`` stays as it was. A link keeps its target, and an existing file
    keeps its permissions. A pipe or a device (/dev/stdout) cannot be replaced and is written directly.

    Raises OSError, naming ``path``, where nothing can be written.
    """
    target = Path(os.path.realpath(path))
    if target.is_dir():
        raise IsADirectoryError(21, "is a directory, not a file to write", str(path))
    if target.exists() and not target.is_file():
        yield target
        return
    if not target.parent.is_dir():
        raise FileNotFoundError(2, f"there is no folder {str(target.parent)!r} to write into", str(path))
    # The suffix stays, because writers of pictures choose the format by it.
    temporary = target.with_name(f".{target.stem[:40]}-{secrets.token_hex(4)}{target.suffix}")
    try:
        temporary.touch(exist_ok=False)
    except OSError as error:
        raise type(error)(error.errno, error.strerror, str(path)) from None
    try:
        yield temporary
        if target.exists():
            shutil.copymode(target, temporary)
        temporary.replace(target)
    finally:
        temporary.unlink(missing_ok=True)
