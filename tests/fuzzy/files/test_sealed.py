"""Checksums inside files, by another reader of their formats."""

import hashlib
import io
import zipfile

import pytest

from fuzzy.files.arrays import ArchiveError, headers
from fuzzy.files.sealed import UNSIGNED, intact, is_sealed, sealed, sealed_archive


def archive():
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w") as file:
        file.writestr("a.txt", "some text")
    return content.getvalue()


def test_the_seal_is_the_checksum_of_the_rest_and_the_archive_stays_one():
    content = sealed_archive(archive())
    with zipfile.ZipFile(io.BytesIO(content)) as file:
        assert file.read("a.txt") == b"some text"
        mark, digits = file.comment.decode().split(":")
    assert mark == "fuzzyfleet-sha256"
    assert digits == hashlib.sha256(content[:-64] + b"0" * 64).hexdigest()


def test_every_flipped_bit_is_seen():
    content = sealed(b"before " + UNSIGNED.encode() + b" after")
    assert intact(content)
    for bit in range(8 * len(content)):
        flipped = bytearray(content)
        flipped[bit // 8] ^= 1 << bit % 8
        assert not intact(bytes(flipped))


def test_what_has_no_place_for_a_seal():
    assert not is_sealed(b"PK")
    with pytest.raises(ValueError, match="no place for a seal"):
        sealed(b"text")
    with pytest.raises(ValueError, match="has a comment already"):
        sealed_archive(sealed_archive(archive()))


def test_an_archive_of_something_else():
    with pytest.raises(ArchiveError, match=r"'a\.txt' is no array"):
        headers(archive())
