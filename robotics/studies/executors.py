"""Where work is done: in this process, in processes of this machine, or on a Dask cluster.

Each is a ``concurrent.futures.Executor``. Leaving one by an exception stops its work at once, mid-computation.
"""

import logging
import multiprocessing
import os
import pickle
import re
import signal
import threading
import traceback
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError, Executor, Future, ThreadPoolExecutor
from contextlib import AbstractContextManager, closing, contextmanager, nullcontext, suppress
from dataclasses import dataclass, field
from multiprocessing import forkserver
from multiprocessing.connection import Connection
from typing import Any

from fuzzy.errors import InputError
from fuzzy.extras import install_command

# What the numerical libraries read when they are loaded: each worker has one core
THREADS = ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
TRIES = 2  # processes that try the same piece of work, where they die
_AHEAD = 2  # pieces of work for each worker: the next lies ready when one is done
_FORKSERVER = "forkserver"
CONNECT = 10  # s to reach a scheduler, and to see a first worker


class WorkerError(InputError):
    """Workers that cannot be reached, or have died over a piece of work."""


class InProcess(Executor):
    """An executor that does what it is given at once, in this process."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> "Future[Any]":
        """Do the work now; the future that comes back is done."""
        future: Future[Any] = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future


@dataclass(frozen=True)
class Workers:
    """An executor, by default this process, and how it is to be used."""

    executor: Executor = field(default_factory=InProcess)
    in_flight: int = 1  # how many pieces of work it is given at a time
    alive: Callable[[], bool] = lambda: True  # asked while waiting: can what is in flight still be answered?
    idle: Callable[[], str] = lambda: ""  # asked while waiting: a sentence where there is nobody to do the work
    apart: bool = False  # whether they do not see this machine's folders


def check_workers(count: int | None, address: str | None) -> None:
    """Raise InputError where both processes of this machine and a cluster are asked for."""
    if count is not None and address is not None:
        raise InputError("give --workers or --dask, not both")


def workers_at(
    count: int | None = None, address: str | None = None, preload: Sequence[str] = ()
) -> "AbstractContextManager[Workers | None]":
    """Processes of this machine, so many, or the Dask cluster at ``address``, for a ``with`` block; None: this process.

    Raises InputError where both are given; see :func:`processes` and :func:`dask`.
    """
    check_workers(count, address)
    if address is not None:
        return dask(address)
    return processes(count, preload) if count is not None else nullcontext()


@contextmanager
def in_threads(count: int) -> Iterator[Workers]:
    """Start ``count`` threads of this process; what has not begun when the block is left is not done."""
    executor = ThreadPoolExecutor(count)
    try:
        yield Workers(executor, count)
    finally:
        executor.shutdown(cancel_futures=True)


@contextmanager
def processes(count: int, preload: Sequence[str] = ()) -> Iterator[Workers]:
    """Start ``count`` processes of this machine, one thread each; they end with this one, even if it is killed.

    The modules ``preload`` are imported once for all of them, where the system can. What a process was doing when it
    died is done once more, in another process; if that dies too, its future raises WorkerError, and the others go on.
    """
    context: Any = multiprocessing.get_context("spawn")
    if _FORKSERVER in multiprocessing.get_all_start_methods():
        context = multiprocessing.get_context(_FORKSERVER)
        context.set_forkserver_preload(list(preload))
    with _environment(dict.fromkeys(THREADS, "1")), _ProcessPool(count, context) as pool:
        yield Workers(pool, _AHEAD * count)


def import_ahead(modules: Sequence[str]) -> None:
    """Let the server that makes later :func:`processes` begin to import their modules, while this process goes on."""
    if _FORKSERVER in multiprocessing.get_all_start_methods():
        multiprocessing.set_forkserver_preload(list(modules))
        with _environment(dict.fromkeys(THREADS, "1")), uninterrupted():
            forkserver.ensure_running()


class _ProcessPool(ThreadPoolExecutor):
    """Threads that each have their work done by a process of their own.

    There is nothing between the processes that one which dies could spoil: it loses what it was doing, no more.
    """

    def __init__(self, count: int, context: Any) -> None:
        super().__init__(count)
        self.context, self.lock, self.stopped = context, threading.Lock(), threading.Event()
        self.own = threading.local()  # of each thread: its process, and the end of the pipe to it
        self.running: dict[Any, Connection] = {}

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> "Future[Any]":
        """Give work, which must be picklable, to the next process that is free."""
        with uninterrupted():  # the threads leave Ctrl-C and SIGTERM to the main one, and so do their processes
            return super().submit(self._done, pickle.dumps((fn, args, kwargs)))

    def __exit__(self, fault: type[BaseException] | None, *_: object) -> None:
        """Wait for what is being done, and end the processes; after an exception at once, whatever they are doing."""
        if fault is not None:
            self.stopped.set()
            with self.lock:
                for process in self.running:
                    process.kill()
        self.shutdown(cancel_futures=True)
        while self.running:
            self._ended(next(iter(self.running)))

    def _done(self, content: bytes) -> Any:
        """In a thread: the result of a piece of work; raises what its process raised."""
        for _ in range(TRIES):
            process = getattr(self.own, "process", None) or self._started()
            try:
                self.running[process].send_bytes(content)
                good, found = pickle.loads(self.running[process].recv_bytes())
            except (EOFError, OSError):  # it has died
                self._ended(process)
            else:
                if good:
                    return found
                raise found
        raise WorkerError("the worker process died (out of memory?), and so did the next")

    def _started(self) -> Any:
        """A new process of this thread."""
        ours, theirs = self.context.Pipe()
        process = self.context.Process(target=_work, args=(theirs,), daemon=False)
        with self.lock:
            if self.stopped.is_set():
                raise CancelledError
            process.start()
            self.running[process], self.own.process = ours, process
        theirs.close()
        return process

    def _ended(self, process: Any) -> None:
        with self.lock:
            self.running.pop(process).close()  # it then ends by itself
        process.join()
        self.own.process = None


def _work(connection: Connection) -> None:
    """In a worker: do what comes until the other end of ``connection`` is closed, or the process there has ended."""
    threading.Thread(target=_follow_parent, daemon=True).start()
    with suppress(EOFError, OSError):
        while True:
            piece = connection.recv_bytes()
            try:
                fn, args, kwargs = pickle.loads(piece)
                answer = pickle.dumps((True, fn(*args, **kwargs)))
            except BaseException as error:
                answer = _failure(error)
            connection.send_bytes(answer)
    os._exit(0)  # nothing here is to be tidied up


def _follow_parent() -> None:
    """End this process when the one that began it has ended, even in the midst of work."""
    parent = multiprocessing.parent_process()
    assert parent is not None
    parent.join()
    os._exit(0)


def _failure(error: BaseException) -> bytes:
    """``error`` for another process, with its traceback as a note; a RuntimeError in its place if it cannot go."""
    told = "".join(traceback.format_exception(error)).rstrip()
    try:
        if not isinstance(error, Exception):
            raise TypeError
        error.__cause__ = error.__context__ = None
        error.add_note(f"In a worker process:\n{told}")
        content = pickle.dumps((False, error))
        pickle.loads(content)
    except Exception:
        return pickle.dumps((False, RuntimeError(told)))
    return content


@contextmanager
def uninterrupted() -> Iterator[None]:
    """Put off Ctrl-C and SIGTERM: they act when the block is done, and not at all on processes started in it."""
    stops = (signal.SIGINT, signal.SIGTERM)
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    came: list[int] = []
    before: dict[int, Any] = {}
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, stops)
    if threading.current_thread() is threading.main_thread():
        # The mask is this thread's alone: where there are others, the system gives one of them the signal, and Python
        # then runs the handler here.
        before = {number: handler for number in stops if callable(handler := signal.getsignal(number))}
        for number in before:
            signal.signal(number, lambda number, frame: came.append(number))
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        for number in came:
            signal.raise_signal(number)  # it waits until the mask is taken away
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)


@contextmanager
def _environment(values: dict[str, str]) -> Iterator[None]:
    before = {name: os.environ.get(name) for name in values}
    os.environ.update(values)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


@contextmanager
def dask(address: str) -> Iterator[Workers]:
    """Connect to the Dask cluster at ``address``, such as tcp://127.0.0.1:8786.

    The packages, and the files that controllers read, must be there too. Raises WorkerError where no scheduler
    answers, it has no workers, or ``distributed`` (the extra ``cluster``) is not installed.
    """
    try:
        from distributed import Client
    except ImportError:
        raise WorkerError(f"--dask needs Dask: {install_command('cluster')}") from None
    if not re.fullmatch(r"(tcp|tls|wss?)://\S+:\d+", address):
        raise WorkerError(f"--dask must be a scheduler's address, such as tcp://127.0.0.1:8786; got {address!r}")
    # What goes wrong is said once, by us.
    for name in ("distributed", "distributed.client", "tornado.application", "asyncio"):
        logging.getLogger(name).setLevel(logging.CRITICAL)
    try:
        client = Client(address, timeout=CONNECT, set_as_default=False)
    except (OSError, ValueError, ImportError) as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise WorkerError(f"--dask {address}: no scheduler answers: {reason}") from None
    with closing(client):
        try:
            client.wait_for_workers(1, timeout=CONNECT)
        except TimeoutError:
            raise WorkerError(f"--dask {address}: the cluster has no workers: dask worker {address}") from None
        executor = client.get_executor(pure=False)
        connection = client.scheduler_comm

        def alive() -> bool:  # a result on its way when the connection broke is never answered
            return client.status == "running" and client.scheduler_comm is connection

        def idle() -> str:
            with suppress(OSError, TimeoutError):  # of which alive() tells
                if not client.nthreads():
                    return f"the cluster has no workers left; this waits until one comes: dask worker {address}"
            return ""

        try:
            yield Workers(executor, _AHEAD * sum(client.nthreads().values()), alive, idle, apart=True)
        except BaseException:
            executor.shutdown(wait=False)
            raise
