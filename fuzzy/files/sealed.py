"""Files that carry a checksum of themselves, so that one flipped bit is seen.

The seal is a mark and 64 hexadecimal digits: the SHA-256 of the whole file with zeros in their place. It stands where
the format has room for a text: an archive (.npz, a checkpoint) bears it as its comment, a Parquet file in its metadata.
"""

import hashlib
from struct import pack

_MARK = b"fuzzyfleet-sha256:"
_DIGITS = 64
UNSIGNED = (_MARK + b"0" * _DIGITS).decode()  # what a writer puts where the seal shall stand
_END = b"PK\5\6"  # begins the end of an archive, 22 bytes of which the last two are the length of its comment


def sealed(content: bytes) -> bytes:
    """``content`` with its checksum in the place of UNSIGNED, which it contains."""
    place = content.rfind(UNSIGNED.encode())
    if place < 0:
        raise ValueError("the content has no place for a seal")
    start = place + len(_MARK)
    return content[:start] + _digest(content, start) + content[start + _DIGITS :]


def sealed_archive(content: bytes) -> bytes:
    """A zip archive without a comment, with the seal as its comment."""
    if content[-22:-18] != _END or content[-2:] != b"\0\0":
        raise ValueError("the content is no zip archive, or has a comment already")
    return sealed(content[:-2] + pack("<H", len(UNSIGNED)) + UNSIGNED.encode())


def is_sealed(content: bytes) -> bool:
    """Whether ``content`` has a seal, unbroken or not."""
    return content.rfind(_MARK) >= 0


def intact(content: bytes) -> bool:
    """Whether ``content`` has a seal and is, to the last bit, what was sealed."""
    place = content.rfind(_MARK)
    if place < 0:
        return False
    start = place + len(_MARK)
    return content[start : start + _DIGITS] == _digest(content, start)


def _digest(content: bytes, start: int) -> bytes:
    parts = memoryview(content)
    whole = hashlib.sha256(parts[:start])
    whole.update(b"0" * _DIGITS)
    whole.update(parts[start + _DIGITS :])
    return whole.hexdigest().encode()
