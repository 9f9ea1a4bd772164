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
from contextlib import suppress
from multiprocessing.connection import Connection
from typing import Any, TypeVar

from fuzzy.errors import InputError
from fuzzy.files.fislines import FisFileError

T = TypeVar("T")
_SMALL = 32_768  # bytes that a pipe takes although nobody reads yet


class WorkError(RuntimeError):
    """A bug in the function that a worker ran, or the end of its process."""


class DesignerWorkers:
    """Worker processes, started when they are first needed; they end with this process, however it ends.

    A task goes to a process and back without a thread between: on a busy machine each that has to be woken may wait for
    some ms, and whoever drags with it. The process that worked last works next: what it needs is at hand there.
    """

    def __init__(self, count: int = 2) -> None:
        self._turns = asyncio.Semaphore(count)
        self._idle: list[_Worker] = []  # the last one was used last
        self._all: list[_Worker] = []

    async def run(self, function: Callable[..., T], *args: Any) -> T:
        """Run ``function(*args)``, both picklable. Raises InputError where the function did, else WorkError."""
        task = pickle.dumps((function, args))
        await self._turns.acquire()
        # Whoever waits no longer leaves the process to its work.
        outcome, value = await asyncio.shield(asyncio.ensure_future(self._done(task)))
        if outcome == "refused":
            raise value if isinstance(value, FisFileError) else InputError(value)
        if outcome == "failed":
            raise WorkError(value)
        return value

    async def _done(self, task: bytes) -> tuple[str, Any]:
        """What became of a task whose turn it is."""
        try:
            if not self._idle:
                # Fresh interpreters: a copy of this one would hold its sockets and locks.
                self._idle.append(_Worker(multiprocessing.get_context("spawn")))
                self._all.append(self._idle[-1])
            worker = self._idle.pop()
            try:
                answer = await worker.answer(task)
            except (EOFError, OSError):
                if worker in self._all:
                    self._all.remove(worker)
                raise WorkError("the process that worked on this ended; perhaps it ran out of memory") from None
            if worker in self._all:
                self._idle.append(worker)
            return answer
        finally:
            self._turns.release()

    def close(self) -> None:
        """End the processes, whatever they are doing."""
        for worker in self._all:
            worker.process.kill()
            worker.process.join()
        self._all, self._idle = [], []


class _Worker:
    """A process that does one task after the other, as they come through a pipe."""

    def __init__(self, context: multiprocessing.context.SpawnContext) -> None:
        self._pipe, there = context.Pipe()
        self.process = context.Process(target=_work, args=(there,), daemon=True)
        self.process.start()
        there.close()

    async def answer(self, task: bytes) -> Any:
        """What comes back for a task. Raises EOFError or OSError where the process has ended."""
        loop = asyncio.get_running_loop()
        if len(task) <= _SMALL:
            self._pipe.send_bytes(task)
        else:
            await asyncio.to_thread(self._pipe.send_bytes, task)
        if sys.platform == "win32":  # its loop cannot watch pipes
            await asyncio.to_thread(self._pipe.poll, None)
        else:
            there, pipe = loop.create_future(), self._pipe.fileno()
            loop.add_reader(pipe, there.set_result, None)
            try:
                await there
            finally:
                loop.remove_reader(pipe)
                os.set_blocking(pipe, True)  # uvloop reads from what does not block
        return pickle.loads(self._pipe.recv_bytes())


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


def _work(pipe: Connection) -> None:
    """Do what comes through the pipe, and send back what became of it."""
    follow_parent()
    with suppress(EOFError, OSError):  # nobody is there any more
        while True:
            pipe.send_bytes(_outcome(pipe.recv_bytes()))
            set_imports_aside()


def _outcome(task: bytes) -> bytes:
    """Do a task; other exceptions travel as text, because not every one can be pickled."""
    try:
        function, args = pickle.loads(task)
        return pickle.dumps(("done", function(*args)))
    except FisFileError as error:  # its line is wanted
        return pickle.dumps(("refused", error))
    except InputError as error:
        return pickle.dumps(("refused", str(error)))
    except Exception as error:
        return pickle.dumps(("failed", f"{type(error).__name__}: {error}"))
