"""Damage to good files: bytes, characters, numbers and lines that change, go missing, repeat or grow."""

import io
import re
from collections.abc import Callable, Sequence
from zipfile import ZIP_STORED, ZipFile

import numpy as np

from fuzzy.files.sealed import sealed_archive

NUMBER = re.compile(rb"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
# What numbers become: not numbers, nothing, beyond a float, below one, counts that nobody has.
NUMBERS = (
    b"nan",
    b"-inf",
    b"1e308",
    b"-1e308",
    b"1e-320",
    b"1" + b"0" * 30,
    b"1000000000",
    b"0",
    b"-0.0",
    b"-1",
    b"1_000",
    b"0x10",
    b"1e",
    b"",
)
# What text becomes: quotes, brackets, line ends, bytes of no text.
TEXTS = (
    b"\0",
    b"\xff\xfe",
    b"'",
    b'"',
    b"[",
    b"]]",
    b"=",
    b"\r",
    b"\n\n",
    b",",
    b";",
    b"\xe2\x80\xae",
    b"=>",
    b"#",
    b" " * 50,
)

Mutation = Callable[[np.random.Generator, bytes, Sequence[bytes]], bytes]


def flip_bit(rng: np.random.Generator, data: bytes, corpus: Sequence[bytes]) -> bytes:
    """One bit is another."""
    changed = bytearray(data)
    changed[rng.integers(len(data))] ^= 1 << int(rng.integers(8))
    return bytes(changed)


def change_byte(rng: np.random.Generator, data: bytes, corpus: Sequence[bytes]) -> bytes:
    """One byte is another."""
    at = int(rng.integers(len(data)))
    return data[:at] + bytes([rng.integers(256)]) + data[at + 1 :]


def cut_off(rng: np.random.Generator, data: bytes, corpus: Sequence[bytes]) -> bytes:
    """The file ends early."""
    return data[: rng.integers(len(data))]


def lose(rng: np.random.Generator, data: bytes, corpus: Sequence[bytes]) -> bytes:
    """A piece is missing."""
    first, last = _piece(rng, data)
    return data[:first] + data[last:]


def repeat(rng: np.random.Generator, data: bytes, corpus: Sequence[bytes]) -> bytes:
    """A piece stands there several times."""
    first, last = _piece(rng, data)
    return data[:last] + data[first:last] * int(rng.integers(1, 40)) + data[last:]


def splice(rng: np.random.Generator, data: bytes, corpus: Sequence[bytes]) -> bytes:
    """A piece of another file stands there."""
    other = corpus[int(rng.integers(len(corpus)))]
    at, (first, last) = int(rng.integers(len(data))), _piece(rng, other)
    return data[:at] + other[first:last] + data[at:]


def insert_text(rng: np.random.Generator, data: bytes, corpus: Sequence[bytes]) -> bytes:
    """Something of :data:`TEXTS` stands there."""
    at = int(rng.integers(len(data) + 1))
    return data[:at] + TEXTS[rng.integers(len(TEXTS))] + data[at:]


def change_number(rng: np.random.Generator, data: bytes, corpus: Sequence[bytes]) -> bytes:
    """A number is one of :data:`NUMBERS`, or another number of the file."""
    found = list(NUMBER.finditer(data))
    if not found:
        return data
    at = found[rng.integers(len(found))]
    others = (*NUMBERS, found[rng.integers(len(found))][0])
    return data[: at.start()] + others[rng.integers(len(others))] + data[at.end() :]


def change_lines(rng: np.random.Generator, data: bytes, corpus: Sequence[bytes]) -> bytes:
    """A line is missing, stands twice, or stands elsewhere."""
    lines = data.split(b"\n")
    at, to, what = int(rng.integers(len(lines))), int(rng.integers(len(lines))), rng.integers(3)
    line = lines[at] if what == 1 else lines.pop(at)
    if what > 0:
        lines.insert(to, line)
    return b"\n".join(lines)


def forge_archive(rng: np.random.Generator, data: bytes, corpus: Sequence[bytes]) -> bytes:
    """An .npz archive with a right checksum in which an array is damaged, missing, another, or of another name."""
    try:
        with ZipFile(io.BytesIO(data)) as archive:
            members = {name: archive.read(name) for name in archive.namelist()}
        return _forged(rng, members, corpus)
    except Exception:  # an earlier mutation has left no archive, or no array, and that has no end of exceptions
        return data


def _forged(rng: np.random.Generator, members: dict[str, bytes], corpus: Sequence[bytes]) -> bytes:
    names = list(members)
    one, other = (names[int(k)] for k in rng.integers(len(names), size=2))
    match int(rng.integers(6)):
        case 0:
            del members[one]
        case 1:
            members[one] = members[other]
        case 2:
            members[other + "x.npy"] = members.pop(one)
        case 3:
            members[one] = _other_array(rng, members[one])
        case 4 if "about.npy" in members:
            members["about.npy"] = _other_text(rng, members["about.npy"], corpus)
        case _:
            members[one] = DAMAGE[int(rng.integers(len(DAMAGE)))](rng, members[one], list(members.values()))
    content = io.BytesIO()
    with ZipFile(content, "w", ZIP_STORED) as archive:
        for name, member in members.items():
            archive.writestr(name, member)
    return sealed_archive(content.getvalue())


def _other_array(rng: np.random.Generator, member: bytes) -> bytes:
    """The array with another shape or type, or with numbers that nobody measures."""
    values = np.load(io.BytesIO(member), allow_pickle=False)
    match int(rng.integers(5)):
        case 0:
            values = values[..., None]
        case 1:
            values = values[: len(values) // 2] if values.ndim else np.array([values, values])
        case 2:
            values = np.moveaxis(values, 0, -1) if values.ndim else values
        case 3 if values.dtype.kind in "fiub":
            values = values.astype(rng.choice(("f4", "i8", "c16", "U8", "?")))
        case _ if values.dtype.kind in "fi" and values.size:
            values = values.copy()
            odd = (np.nan, np.inf, -1e300, 0.0, -1.0, 2.0**62) if values.dtype.kind == "f" else (-1, 2**30, 0, 255)
            with np.errstate(over="ignore"):  # what single precision cannot hold is infinite there
                values.flat[int(rng.integers(values.size))] = odd[int(rng.integers(len(odd)))]
    return _as_member(values)


def _other_text(rng: np.random.Generator, member: bytes, corpus: Sequence[bytes]) -> bytes:
    text = str(np.load(io.BytesIO(member), allow_pickle=False)).encode()
    changed = MISTAKES[int(rng.integers(len(MISTAKES)))](rng, text, corpus)
    return _as_member(np.array(changed.decode(errors="replace").replace("\0", " ")))


def _as_member(values: np.ndarray) -> bytes:
    content = io.BytesIO()
    np.save(content, values, allow_pickle=False)
    return content.getvalue()


DAMAGE: tuple[Mutation, ...] = (flip_bit, change_byte, cut_off, lose, repeat, splice)
MISTAKES: tuple[Mutation, ...] = (change_number, change_number, insert_text, change_lines)


def mutated(rng: np.random.Generator, corpus: Sequence[bytes], mutations: Sequence[Mutation]) -> bytes:
    """A file of ``corpus`` with one of ``mutations``, or, more seldom, with up to four, one after the other."""
    data = corpus[int(rng.integers(len(corpus)))]
    for _ in range(int(rng.choice((1, 1, 1, 2, 4)))):
        if data:
            data = mutations[int(rng.integers(len(mutations)))](rng, data, corpus)
    return data


def _piece(rng: np.random.Generator, data: bytes) -> tuple[int, int]:
    """Where a piece of at most 200 bytes begins and ends."""
    first = int(rng.integers(len(data)))
    return first, min(len(data), first + int(rng.integers(1, 200)))
