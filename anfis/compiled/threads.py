"""The threads of compiled learning: how many share the blocks of samples out, and one for linear algebra.

What is computed does not depend on their number: a block's sums are its own, and are added in the blocks' order. Linear
algebra has one thread, because its last digits may depend on how many there are.
"""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from threading import Lock
from typing import Any

from threadpoolctl import ThreadpoolController

from fuzzy.compiled.threads import processors


def count() -> int:
    """How many threads learning may use: the cores of this process, or fewer by OMP_NUM_THREADS."""
    asked = os.environ.get("OMP_NUM_THREADS", "")
    return min(processors(), int(asked)) if asked.isdigit() and int(asked) > 0 else processors()


_lock = Lock()
_learning: list[Any] = []  # the limits that hold now, one while anything learns


@cache
def _libraries() -> ThreadpoolController:
    return ThreadpoolController()


@contextmanager
def one_for_linear_algebra() -> Iterator[None]:
    """One thread in every call of linear algebra; the setting is restored when the last one that learns leaves."""
    with _lock:
        _learning.append(_learning[0] if _learning else _libraries().limit(limits=1, user_api="blas"))
    try:
        yield
    finally:
        with _lock:
            limit = _learning.pop()
            if not _learning:
                limit.restore_original_limits()
