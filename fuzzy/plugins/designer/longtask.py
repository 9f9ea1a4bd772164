"""A long task of a panel: work in a process of its own, which tells how it goes and ends when it is asked to.

The work knows nothing of the page. It is killed with the process that began it, however that ends.
"""

import asyncio
import multiprocessing
from collections.abc import Callable
from contextlib import suppress
from multiprocessing.connection import Connection
from typing import Any, ClassVar

from fuzzy.errors import InputError
from fuzzy.plugins.designer.session import PanelSession, refusal_of
from fuzzy.plugins.designer.workers import follow_parent

Report = Callable[[str, Any], bool]  # tells a piece of news, and whether to go on
Work = Callable[[Any, Report], Any]  # does a task; what it gives is told as "done"
EVERY = 0.1  # s between two looks at how it goes
_PATIENCE = 3.0  # s that a process is given to end by itself


class TaskProcess:
    """A task in a process of its own, watched by :meth:`news` and ended by :meth:`stop` or :meth:`close`.

    Args:
        task: The task, which can be pickled.
        work: The function of a module that does it there.
        name: What messages call it.
    """

    def __init__(self, task: Any, work: Work, name: str) -> None:
        # A fresh process: a forked one would share the threads' locks of torch and of the server.
        context = multiprocessing.get_context("spawn")
        self._ours, theirs = context.Pipe()
        self._process = context.Process(target=_begin, args=(task, work, theirs), daemon=True)
        self._name = name
        self._process.start()
        theirs.close()
        self._over = False

    @property
    def alive(self) -> bool:
        """Can there be more news?"""
        return not self._over

    def news(self) -> list[tuple[str, Any]]:
        """Give what has been reported since the last call, without waiting.

        The end is one of ("done", what the work gave) and ("problem", as of fuzzy.plugins.designer.session.refusal_of).
        """
        found: list[tuple[str, Any]] = []
        try:
            while not self._over and self._ours.poll():
                found.append(self._ours.recv())
                self._over = found[-1][0] in ("done", "problem")
        except (EOFError, OSError):
            self._over = True
            self._process.join(_PATIENCE)
            code = self._process.exitcode
            found.append(("problem", refusal_of(InputError(f"the {self._name} ended unexpectedly (exit code {code})"))))
        return found

    def stop(self) -> None:
        """Ask it to end after this step; the best so far follows as news."""
        with suppress(OSError):  # it has ended already
            self._ours.send("stop")

    def close(self) -> None:
        """End the process now; no news follows."""
        self._over = True
        self._ours.close()
        if self._process.is_alive():
            self._process.terminate()
        self._process.join(_PATIENCE)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()


def _begin(task: Any, work: Work, pipe: Connection) -> None:
    follow_parent()
    do_task(task, work, pipe)


def do_task(task: Any, work: Work, pipe: Connection) -> None:
    """Do a task and tell of it through the pipe, until something comes through it from the other end."""
    asked = False

    def report(what: str, about: Any) -> bool:
        nonlocal asked
        pipe.send((what, about))
        asked = asked or pipe.poll()
        return not asked

    with suppress(ConnectionError):  # nobody listens any more
        try:
            pipe.send(("done", work(task, report)))
        except InputError as error:
            pipe.send(("problem", refusal_of(error)))


class TaskSession(PanelSession):
    """A panel with one long task at a time: starting, watching and stopping it, and ending it with the page.

    ``state`` is "idle" or "done" while none runs, else "starting", "stopping", or a subclass's own word.
    A subclass says in :meth:`note` what each piece of news means, and in ``_progress`` what the page sees of it.
    """

    called: ClassVar[str]  # the task, in messages

    def __init__(self, bench: Any, **choice: Any) -> None:
        super().__init__(bench, **choice)
        self.state = "idle"
        self.process: TaskProcess | None = None
        self.watching: asyncio.Task[None] | None = None
        self.closed = False

    @property
    def runs(self) -> bool:
        """Is a task under way, from the wish to start it until its end?"""
        return self.state not in ("idle", "done")

    def check_idle(self) -> None:
        """Raise where a task runs."""
        if self.runs:
            raise self.error(f"a {self.called} runs already; stop it first")

    async def start(self, task: Any, work: Work) -> None:
        """Begin a task; ``state`` is "starting" before anything is waited for."""
        self.state = "starting"
        self.tell()
        try:
            process = await asyncio.to_thread(TaskProcess, task, work, self.called)
        except BaseException:
            self.ended()
            raise
        if self.closed:
            process.close()
            self.ended()
            return
        self.process = process
        if self.state == "stopping":
            process.stop()
        self.watching = asyncio.get_running_loop().create_task(self._watch(process))

    def _do_stop(self, _: dict[str, Any]) -> None:
        """End the task after its present step."""
        if not self.runs:
            raise self.error(f"no {self.called} runs")
        self.stop_soon()
        self.tell()

    def stop_soon(self) -> None:
        """Ask the process to end, also one that is only being started."""
        if self.process is not None:
            self.process.stop()
        self.state = "stopping"

    async def _watch(self, process: TaskProcess) -> None:
        while process.alive:
            await asyncio.sleep(EVERY)
            for what, about in process.news():
                with self.refusing({}):
                    self.note(what, about)
            if self.process is process:
                self.tell()
        if self.process is process:
            self.ended()
            await asyncio.to_thread(process.close)
            await self.settle()

    def note(self, what: str, about: Any) -> None:
        """Take a piece of news of the task."""
        if what == "problem":
            self.state = "idle"
            self.widget.update(problem=about)
        elif what == "done":
            self.state = "done"

    def tell(self) -> None:
        """Show the page how the task goes."""
        self.widget.update(progress=self._progress())

    def _progress(self) -> dict[str, Any]:
        raise NotImplementedError

    def ended(self) -> None:
        """Note that no task runs any more."""
        self.process = None
        self.state = self.state if self.state == "done" else "idle"
        self.tell()

    async def settle(self) -> None:
        """Do what waits for the end of a task that was not closed."""

    def close(self) -> None:
        """End the task that runs, because its page is closed."""
        self.closed = True
        process, self.process = self.process, None
        if process is not None:
            process.close()
