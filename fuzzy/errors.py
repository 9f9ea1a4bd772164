"""The errors that a user can mend: one class at each boundary, all of them ValueErrors."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Self

_LONGEST = 120  # characters of what was read that a message quotes


class InputError(ValueError):
    """Something given cannot be used. The message says where, what, and what is accepted.

    A command line prints the message and exits with 2; any other exception there is a bug.
    """

    at: tuple[str | int, ...] = ()  # where it belongs in what was read: the keys from the outermost in, the field last

    def about(self, *keys: str | int) -> Self:
        """The same error, now about the value under ``keys``; where it was already about a part, about that part of it.

        >>> InputError("must be > 0").about("mass").about("robots", 2).at
        ('robots', 2, 'mass')
        """
        self.at = (*keys, *self.at)
        return self


@contextmanager
def concerning(*keys: str | int) -> Iterator[None]:
    """Let the InputErrors of a ``with`` block be :meth:`InputError.about` the value under ``keys``."""
    try:
        yield
    except InputError as error:
        raise error.about(*keys) from None


def quoted(text: object, longest: int = _LONGEST) -> str:
    """``text`` in quotation marks, as messages repeat what was read: its beginning only where it is long.

    >>> quoted("a" * 10, longest=4)
    "'aaaa'... (10 characters)"
    """
    text = str(text)
    return repr(text) if len(text) <= longest else f"{text[:longest]!r}... ({len(text)} characters)"


def shortened(text: str, longest: int = _LONGEST) -> str:
    """``text`` without quotation marks, such as a line of a file: its beginning only where it is long.

    >>> shortened("a" * 10, longest=4)
    'aaaa... (10 characters)'
    """
    return text if len(text) <= longest else f"{text[:longest]}... ({len(text)} characters)"
