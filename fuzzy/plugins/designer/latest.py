"""Work that follows a page's wishes: one piece at a time, only the latest, or once there was none for a while."""

import asyncio
from collections.abc import Awaitable, Callable
from typing import Any


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


class Postponed:
    """Does ``work()`` once, some ``seconds`` after it was asked for last."""

    def __init__(self, seconds: float, work: Callable[[], Any]) -> None:
        self._seconds, self._work = seconds, work
        self._timer: asyncio.TimerHandle | None = None

    def begin(self) -> None:
        """Wait from now on."""
        self.cancel()
        self._timer = asyncio.get_running_loop().call_later(self._seconds, self._work)

    def cancel(self) -> None:
        """Do it no more, until it is asked for again."""
        if self._timer is not None:
            self._timer.cancel()
