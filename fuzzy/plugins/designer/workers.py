"""Long work in other processes, so that the page never waits for it."""

import asyncio
import gc
import multiprocessing
import os
import pickle
import signal
import sys
import threading
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from typing import Any, TypeVar

from fuzzy.errors import InputError
from fuzzy.files.fislines import FisFileError

T = TypeVar("T")


class WorkError(RuntimeError):
    """A bug in the function that a worker ran, or the end of its process."""


class DesignerWorkers:
    """Worker processes, started when they are first needed; they end with this process, however it ends."""

    def __init__(self, count: int = 2) -> None:
        self._count = count
        self._pool: ProcessPoolExecutor | None = None

    async def run(self, function: Callable[..., T], *args: Any) -> T:
        """Run ``function(*args)``, both picklable. Raises InputError where the function did, else WorkError."""
        if self._pool is None:
            # Fresh interpreters: a copy of this one would hold its sockets and locks.
            context = multiprocessing.get_context("spawn")
            self._pool = ProcessPoolExecutor(self._count, mp_context=context, initializer=follow_parent)
        pool = self._pool
        try:
            outcome, value = await asyncio.get_running_loop().run_in_executor(pool, _work, function, args)
        except BrokenProcessPool:
            if self._pool is pool:
                self._pool = None
            raise WorkError("the process that worked on this ended; perhaps it ran out of memory") from None
        except RuntimeError as error:  # the pool has been closed meanwhile
            raise WorkError(str(error)) from None
        if outcome == "refused":
            raise value if isinstance(value, FisFileError) else InputError(value)
        if outcome == "failed":
            raise WorkError(value)
        return value

    def close(self) -> None:
        """End the processes, whatever they are doing."""
        if self._pool is not None:
            processes = list((self._pool._processes or {}).values())
            for process in processes:
                process.kill()
            self._pool.shutdown(wait=True, cancel_futures=True)
            self._pool = None


class TimedWorkers:
    """Processes for what somebody else's file may make slow: one task after the other in each, within a time limit.

    A file that takes long keeps one of them busy, and the next file is read in another.
    """

    def __init__(self, limit: float, count: int = 2) -> None:
        self._limit = limit  # s, from when a task's turn comes
        self._workers = [DesignerWorkers(1) for _ in range(count)]
        self._free = list(self._workers)  # the last one was used last
        self._turns = asyncio.Semaphore(count)

    async def run(self, late: str, function: Callable[..., T], *args: Any) -> T:
        """Run ``function(*args)`` as :meth:`DesignerWorkers.run` does.

        Raises InputError with the sentence ``late``, and ends the process, where that takes too long.
        """
        async with self._turns:
            worker = self._free.pop()
            try:
                await worker.run(_arrived, function)  # a process that begins loads the function's modules first
                return await asyncio.wait_for(worker.run(function, *args), self._limit)
            except TimeoutError:
                worker.close()
                raise InputError(late) from None
            finally:
                self._free.append(worker)

    def close(self) -> None:
        """End the processes, whatever they are doing."""
        for worker in self._workers:
            worker.close()


def follow_parent() -> None:
    """Let this process end with the one that began it, however that ends."""
    # Ctrl-C is for the server, which ends its workers itself; where it was killed they go too.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    parent = multiprocessing.parent_process()

    def follow() -> None:
        if parent is not None:
            parent.join()
            os._exit(1)

    threading.Thread(target=follow, daemon=True).start()


def _arrived(function: Callable[..., Any]) -> None:
    """Do nothing: whoever was sent a function has its modules."""


_seen: set[int] = set()  # how many modules there were when they were set aside


def set_imports_aside() -> None:
    """Take what modules that are new have made out of the garbage collector's sight: it stays as long as the process.

    To look through all of it takes 80 ms, during which nobody's drag is answered.
    """
    if len(sys.modules) not in _seen:
        _seen.add(len(sys.modules))
        gc.collect()
        gc.freeze()


def _work(function: Callable[..., Any], args: tuple[Any, ...]) -> tuple[str, Any]:
    """What became of it: other exceptions travel as text, because not every one can be pickled."""
    try:
        value = function(*args)
        pickle.dumps(value)
        set_imports_aside()
        return "done", value
    except FisFileError as error:  # its line is wanted
        return "refused", error
    except InputError as error:
        return "refused", str(error)
    except Exception as error:
        return "failed", f"{type(error).__name__}: {error}"
