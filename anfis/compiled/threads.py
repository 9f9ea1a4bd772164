"""The threads of compiled learning: blocks of samples are shared out over them.

What is computed does not depend on their number: a block's sums are its own, and are added in the blocks' order. Linear
algebra has one thread, because its last digits may depend on how many there are.
"""

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from functools import cache
from threading import Lock
from typing import Any, TypeVar

from threadpoolctl import ThreadpoolController

from fuzzy.compiled.threads import processors

T = TypeVar("T")


def count() -> int:
    """How many threads learning may use: the cores of this process, or fewer by OMP_NUM_THREADS."""
    asked = os.environ.get("OMP_NUM_THREADS", "")
    return min(processors(), int(asked)) if asked.isdigit() and int(asked) > 0 else processors()


@cache
def _pool(threads: int) -> ThreadPoolExecutor:
    return ThreadPoolExecutor(threads, "anfis")


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_pool.cache_clear)  # a child has its parent's pool, but none of its threads


def shared_out(work: Callable[[int], T], blocks: Sequence[int]) -> list[T]:
    """The results of ``work`` for each of ``blocks``, in their order; this thread takes its share."""
    threads = min(count(), len(blocks))
    if threads == 1:
        return [work(block) for block in blocks]
    others = [
        _pool(threads - 1).submit(lambda own: [work(b) for b in own], blocks[k::threads]) for k in range(1, threads)
    ]
    parts = [[work(block) for block in blocks[::threads]], *(other.result() for other in others)]
    return [parts[k % threads][k // threads] for k in range(len(blocks))]


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
