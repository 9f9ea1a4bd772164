"""Work that follows a page's wishes: one piece at a time, and of what was wished meanwhile only the latest."""

import asyncio
from collections.abc import Awaitable, Callable


class Latest:
    """Does ``work()`` whenever it is asked for, once for all wishes that come while it is being done."""

    def __init__(self, work: Callable[[], Awaitable[None]]) -> None:
        self._work = work
        self._wished = False
        self.task: asyncio.Task[None] | None = None  # done once all wishes are

    def wish(self) -> None:
        """Do the work soon; nothing waits for it here."""
        self._wished = True
        if self.task is None or self.task.done():
            self.task = asyncio.get_running_loop().create_task(self._follow())

    async def _follow(self) -> None:
        while self._wished:
            self._wished = False
            await self._work()
