"""Where work is done: in this process, in processes of this machine, or on a Dask cluster.

Each is a ``concurrent.futures.Executor``. Leaving one by an exception stops its work at once, mid-computation.
"""

import logging
import multiprocessing
import os
import re
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import forkserver
from multiprocessing.connection import Connection
from typing import Any

from fuzzy.errors import InputError
from fuzzy.extras import install_command

# What the numerical libraries read when they are loaded: each worker has one core
THREADS = ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
AHEAD = 2  # pieces of work for each worker: the next lies ready when one is done
_FORKSERVER = "forkserver"
CONNECT = 10  # s to reach a scheduler, and to see a first worker


class ExecutorError(InputError):
    """A cluster that cannot be reached or has no workers."""


@dataclass(frozen=True)
class Workers:
    """An executor, and how it is to be used."""

    executor: Executor
    in_flight: int = 1  # how many pieces of work it is given at a time
    alive: Callable[[], bool] = lambda: True  # asked while waiting: can what is in flight still be answered?


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


@contextmanager
def processes(count: int, preload: Sequence[str] = ()) -> Iterator[Workers]:
    """Start ``count`` processes of this machine, one thread each; they end with this one, even if it is killed.

    The modules ``preload`` are imported once for all of them, where the system can.
    """
    context: Any = multiprocessing.get_context("spawn")
    if _FORKSERVER in multiprocessing.get_all_start_methods():
        context = multiprocessing.get_context(_FORKSERVER)
        context.set_forkserver_preload(list(preload))
    lifeline, held = context.Pipe(duplex=False)
    with _environment(dict.fromkeys(THREADS, "1")):
        pool = _Processes(count, mp_context=context, initializer=_stay, initargs=(lifeline,))
        try:
            yield Workers(pool, AHEAD * count)
        except BaseException:
            held.close()
            raise
        finally:
            pool.shutdown(wait=True, cancel_futures=True)
            held.close()
            lifeline.close()


def import_ahead(modules: Sequence[str]) -> None:
    """Let the server that makes later :func:`processes` begin to import their modules, while this process goes on."""
    if _FORKSERVER in multiprocessing.get_all_start_methods():
        multiprocessing.set_forkserver_preload(list(modules))
        with _environment(dict.fromkeys(THREADS, "1")), uninterrupted():
            forkserver.ensure_running()


class _Processes(ProcessPoolExecutor):
    """A pool whose processes are started with Ctrl-C blocked, because this process answers it."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> "Future[Any]":
        with uninterrupted():
            return super().submit(fn, *args, **kwargs)


@contextmanager
def uninterrupted() -> Iterator[None]:
    """Put off Ctrl-C: it acts when the block is done, and not at all on processes that are started in it."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _stay(lifeline: Connection) -> None:
    """Let this worker live as long as the other end of ``lifeline`` is open, whatever it is doing."""

    def watch() -> None:
        try:
            lifeline.recv_bytes()
        except (EOFError, OSError):
            os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


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

    The packages, and the files that controllers read, must be there too. Raises ExecutorError where no scheduler
    answers, it has no workers, or ``distributed`` (the extra ``cluster``) is not installed.
    """
    try:
        from distributed import Client
    except ImportError:
        raise ExecutorError(f"--dask needs Dask: {install_command('cluster')}") from None
    if not re.fullmatch(r"(tcp|tls|wss?)://\S+:\d+", address):
        raise ExecutorError(f"--dask must be a scheduler's address, such as tcp://127.0.0.1:8786; got {address!r}")
    # What goes wrong is said once, by us.
    for name in ("distributed", "distributed.client", "tornado.application", "asyncio"):
        logging.getLogger(name).setLevel(logging.CRITICAL)
    try:
        client = Client(address, timeout=CONNECT, set_as_default=False)
    except (OSError, ValueError, ImportError) as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise ExecutorError(f"--dask {address}: no scheduler answers: {reason}") from None
    try:
        try:
            client.wait_for_workers(1, timeout=CONNECT)
        except TimeoutError:
            raise ExecutorError(f"--dask {address}: the cluster has no workers: dask worker {address}") from None
        executor = client.get_executor(pure=False)
        connection = client.scheduler_comm

        def alive() -> bool:  # a result on its way when the connection broke is never answered
            return client.status == "running" and client.scheduler_comm is connection

        try:
            yield Workers(executor, AHEAD * sum(client.nthreads().values()), alive)
        except BaseException:
            executor.shutdown(wait=False)
            raise
    finally:
        client.close()
