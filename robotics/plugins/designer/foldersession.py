"""A panel whose choices may be files of the opened folder: read in another process, and read anew once they change."""

import asyncio
from collections.abc import Callable, Coroutine
from typing import Any

from fuzzy.errors import InputError
from fuzzy.plugins.designer.session import PanelSession
from fuzzy.plugins.designer.workers import WorkError
from robotics.plugins.designer.folderfiles import FolderOffers, changed_at

_LOOK = 1.0  # s between two looks at the files


class FolderSession(PanelSession):
    """The files that one page has chosen, by what they are to it; a page waits for none of them.

    A subclass says in :meth:`say_busy` that one is read, goes on in :meth:`go`, and reads in :meth:`reread` one that
    has changed. Of each kind the latest choice counts: what an earlier reading gives is dropped.
    """

    def __init__(self, bench: Any) -> None:
        super().__init__(bench)
        self.offers = FolderOffers(self.folder, bench.read)
        self.seen = False  # files are looked at for a page that somebody looks at
        self.reads: dict[str, object] = {}  # the mark of the latest reading of each kind
        self.reading: dict[str, asyncio.Task[None]] = {}
        self.watched: dict[str, tuple[str, Any]] = {}  # the name of each file, and its state when it was read
        self._watch: asyncio.TimerHandle | None = None

    def begin_reading(self, what: str, work: Callable[[object], Coroutine[Any, Any, None]]) -> asyncio.Task[None]:
        """Begin to read what is ``what``, with its mark in ``reads``; an earlier reading of that is overtaken."""
        self.reads[what] = mine = object()
        task = asyncio.get_running_loop().create_task(work(mine))
        self.reading[what] = task
        return task

    def read_then(self, what: str, name: str, then: Callable[[Any], None], function: Any, *args: Any) -> None:
        """Do ``then`` with what reading the file ``name`` gives, unless something else is ``what`` by then."""

        async def work(mine: object) -> None:
            self.say_busy("file")
            try:
                found = await self.bench.read(name, function, *args)
                if self.reads[what] is mine:
                    then(found)
            except (InputError, WorkError) as error:
                if self.reads[what] is mine:
                    self.refuse(error, {"do": "choose", "name": what})
            finally:
                self.say_busy(None)
            self.go()

        self.begin_reading(what, work)

    def list_files(self, _: dict[str, Any]) -> None:
        """Show what the folder offers, once it has been looked at."""
        if "list" not in self.reads:
            self.begin_reading("list", self._offer)

    _do_list = list_files

    async def _offer(self, _: object) -> None:
        # A file that takes too long is said and left out.
        try:
            late = await self.offers.look()
            self.widget.update(files=self.offers.found(self.bench.document.path))
            if late:
                self.widget.update(problem={"message": late})
        finally:
            del self.reads["list"]

    def watch(self, what: str, name: str) -> None:
        """Watch the file ``name`` as what is ``what``, from its present state on."""
        self.watched[what] = name, changed_at(self.folder, name)

    def forget_file(self, what: str) -> None:
        """Watch no longer what is ``what``, and drop what is being read of it."""
        self.reads[what] = object()
        self.watched.pop(what, None)

    def _look(self) -> None:
        """Read the files anew that have changed, and look again in a second while the panel is seen."""
        if self._watch is not None:
            self._watch.cancel()
        self._watch = asyncio.get_running_loop().call_later(_LOOK, self._look) if self.seen else None
        for what, (name, before) in list(self.watched.items()) if self.seen else ():
            if changed_at(self.folder, name) != before:
                self.watch(what, name)
                self.reread(what, name)

    def close(self) -> None:
        """Read and look no more."""
        self.seen = False
        for task in self.reading.values():
            task.cancel()
        if self._watch is not None:
            self._watch.cancel()

    def say_busy(self, what: str | None) -> None:
        """Say what is waited for; None: nothing."""
        raise NotImplementedError

    def go(self) -> None:
        """Go on after a choice."""
        raise NotImplementedError

    def reread(self, what: str, name: str) -> None:
        """Begin to read what is ``what`` anew: the file ``name`` has changed."""
        raise NotImplementedError
