"""Many rows shared out over the processors, for compiled functions that run without Python's lock (``nogil``)."""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache


def processors() -> int:
    """How many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def share_out(work: Callable[[int, int], None], rows: int, size: int) -> None:
    """Call ``work(first, end)`` for blocks of ``size`` rows until all rows are done, on all processors.

    The blocks do not depend on the number of processors. On one processor no thread is started.
    """
    starts = iter(range(0, rows, size))  # next() on it is one step for all threads, by Python's lock

    def run() -> None:
        for first in starts:
            work(first, min(first + size, rows))

    count = min(processors(), -(-rows // size))
    others = [_threads().submit(run) for _ in range(count - 1)]
    run()
    for other in others:
        other.result()


@cache
def _threads() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(max_workers=max(1, processors() - 1), thread_name_prefix="fuzzy")


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_threads.cache_clear)  # a child has its parent's pool, but none of its threads
