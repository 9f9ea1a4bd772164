"""Work shared out over the processors, for compiled functions that run without Python's lock (``nogil``)."""

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import Any, TypeVar

Job = TypeVar("Job")
Result = TypeVar("Result")


def processors() -> int:
    """How many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def share_out(one: Callable[[Job], Result], jobs: Sequence[Job], threads: int | None = None) -> list[Result]:
    """Do ``one`` thing for each of ``jobs``; return the results in their order.

    Jobs are begun in their order. After one has failed no other is begun, and the error of the first that failed is
    raised when all that were begun have ended. A job may share out work of its own.

    Args:
        one: Does a job; for one job, or on one processor, no thread is started.
        jobs: One argument for each call.
        threads: How many threads at most, this one among them; by default one for each processor.
    """
    places = iter(range(len(jobs)))  # next() on it is one step for all threads, by Python's lock
    found: list[Any] = [None] * len(jobs)
    failed: dict[int, BaseException] = {}

    def stop() -> None:
        for _ in places:
            pass

    def work() -> None:
        for k in places:
            try:
                found[k] = one(jobs[k])
            except BaseException as error:
                failed[k] = error
                stop()

    count = min(len(jobs), processors() if threads is None else threads)
    others = [_threads().submit(work) for _ in range(count - 1)]
    try:
        work()
        for other in others:
            if not other.cancel():  # what has not begun yet has nothing left to do
                other.result()
    finally:
        stop()
    if failed:
        raise failed[min(failed)]
    return found


@cache
def _threads() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(max_workers=max(1, processors() - 1), thread_name_prefix="fuzzy")


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_threads.cache_clear)  # a child has its parent's pool, but none of its threads
