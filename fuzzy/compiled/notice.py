"""One sentence to whoever waits while functions are compiled: a command says it on a terminal, the library nothing."""

import sys
import time

_NOTICEABLE = 2.0  # s
_watched = False
_since: float | None = None  # when the first function was missing


def watch(on: bool) -> None:
    """Say from now on, or say no longer, that functions are being compiled."""
    global _watched, _since
    _watched, _since = on, None


def compiling() -> None:
    """Note that a function is about to be compiled; says so, once, when the first was so some seconds ago."""
    global _watched, _since
    now = time.monotonic()
    _since = now if _since is None else _since
    if _watched and now - _since > _NOTICEABLE:
        _watched = False
        print("compiling functions for this machine, once; it can take a minute...", file=sys.stderr)
