"""Damage to good files: bytes, characters, numbers and lines that change, go missing, repeat or grow."""

import re
from collections.abc import Callable, Sequence

import numpy as np

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
    other = corpus[rng.integers(len(corpus))]
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


DAMAGE: tuple[Mutation, ...] = (flip_bit, change_byte, cut_off, lose, repeat, splice)
MISTAKES: tuple[Mutation, ...] = (change_number, change_number, insert_text, change_lines)


def mutated(rng: np.random.Generator, corpus: Sequence[bytes], mutations: Sequence[Mutation]) -> bytes:
    """A file of ``corpus`` with one to four of ``mutations``, one after the other."""
    data = corpus[rng.integers(len(corpus))]
    for _ in range(int(rng.integers(1, 5))):
        if data:
            data = mutations[rng.integers(len(mutations))](rng, data, corpus)
    return data


def _piece(rng: np.random.Generator, data: bytes) -> tuple[int, int]:
    """Where a piece of at most 200 bytes begins and ends."""
    first = int(rng.integers(len(data)))
    return first, min(len(data), first + int(rng.integers(1, 200)))
