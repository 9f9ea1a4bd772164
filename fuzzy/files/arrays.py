"""Named arrays in an .npz archive: what they are is read from their headers, before anything is unpacked."""

import os
from collections.abc import Mapping
from io import BytesIO
from math import prod
from pathlib import Path
from typing import NamedTuple
from zipfile import ZipFile, ZipInfo

import numpy as np
from numpy.lib import format as npy

from fuzzy.errors import InputError, quoted

MOST_BYTES = 4 * 2**30  # of all arrays of an archive, unpacked


class ArchiveError(InputError):
    """An archive that holds no named arrays of numbers or texts, or too much. The message names no file."""


class Header(NamedTuple):
    """What the header of an array says."""

    shape: tuple[int, ...]
    dtype: np.dtype

    @property
    def bytes(self) -> int:
        """The size of the array."""
        return prod(self.shape) * self.dtype.itemsize


def read_archive(path: str | Path) -> bytes:
    """The bytes of a file. Raises ArchiveError for one larger than MOST_BYTES, OSError where it cannot be read."""
    with Path(path).open("rb") as file:
        size = os.fstat(file.fileno()).st_size
        if size > MOST_BYTES:
            raise ArchiveError(f"the file takes {sized(size)}; at most {sized(MOST_BYTES)} are read")
        return file.read(size)


def headers(content: bytes) -> dict[str, Header]:
    """The headers of the arrays in the .npz archive ``content``, by name.

    Raises ArchiveError for arrays that are larger than the archive says, or than MOST_BYTES together, and for members
    that are no arrays of numbers or texts; what zipfile and numpy raise passes.
    """
    found: dict[str, Header] = {}
    with ZipFile(BytesIO(content)) as archive:
        for member in archive.infolist():
            name = member.filename.removesuffix(".npy")
            if name in found or name == member.filename:
                raise ArchiveError(f"{quoted(member.filename)} is no array, or stands there twice")
            found[name] = _header(archive, member, name)
    total = sum(header.bytes for header in found.values())
    if total > MOST_BYTES:
        raise ArchiveError(f"its arrays would take {sized(total)}; at most {sized(MOST_BYTES)} are read")
    return found


def unpacked(content: bytes) -> Mapping[str, np.ndarray]:
    """The arrays of an archive whose :func:`headers` have been looked at. What zipfile and numpy raise passes."""
    with np.load(BytesIO(content), allow_pickle=False) as archive:
        return {name: archive[name] for name in archive.files}


def sized(count: int) -> str:
    """A number of bytes, as people read it.

    >>> sized(4 * 2**30)
    '4.0 GiB'
    """
    return f"{count / 2**30:.1f} GiB" if count < 2**40 else f"{count / 2**40:.1f} TiB"


def _header(archive: ZipFile, member: ZipInfo, name: str) -> Header:
    with archive.open(member) as file:
        version = npy.read_magic(file)
        if version not in ((1, 0), (2, 0)):
            raise ArchiveError(f"{quoted(name)} is no array of numbers or texts")
        read = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
        shape, _, dtype = read(file)
        header = Header(shape, dtype)
        if dtype.kind not in "biufU" or min(shape, default=0) < 0:
            raise ArchiveError(f"{quoted(name)} is no array of numbers or texts")
        if file.tell() + header.bytes != member.file_size:
            raise ArchiveError(
                f"{quoted(name)} says that it takes {sized(header.bytes)}, and its part of the file is of another size"
            )
    return header
