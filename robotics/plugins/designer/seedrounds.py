"""Several seeds of the trial on the page, run in small portions once nothing else is to be run: the newest wins."""

import asyncio
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from fuzzy.errors import InputError
from fuzzy.plugins.designer.workers import WorkError

COUNTS = (1, 5, 20)
_PAUSE = 0.5  # s without an edit before several seeds are run
_PORTION = 10  # seeds at a time: between two portions an edit ends the round
Work = tuple[Any, ...]  # the first seed, a function for a background process, and its arguments but the seeds


@dataclass
class SeedRounds:
    """The rounds of one page."""

    background: Callable[..., Any]
    work: Callable[[], dict[str, Work]]  # of "tried", "before" and "rival"; empty: there is nothing to run
    progress: Callable[[], None]  # told when ``done`` is another
    publish: Callable[[str], None]  # told what has new rows
    count: int = 1
    picked: int | None = None  # the seed that was chosen by hand
    worst: int | None = None
    done: int | None = None  # seeds of the present round; None: there is no round
    rows: dict[str, tuple[Any, list[dict[str, Any]]]] = field(default_factory=dict)  # by name, with what made them
    _timer: asyncio.TimerHandle | None = None
    _task: asyncio.Task[None] | None = None
    _round: int = 0

    def shown(self, first: int) -> int:
        """The seed that is drawn and played, if the ``first`` is the trial's own."""
        if self.count == 1:
            return first
        return next((seed for seed in (self.picked, self.worst) if seed is not None), first)

    def seeds(self, first: int) -> list[int]:
        """All seeds."""
        return list(range(first, first + self.count))

    def forget(self) -> None:
        """Begin anew: the conditions are others."""
        self.rest()
        self.picked = self.worst = None
        self.rows.clear()

    def rest(self) -> None:
        """End the round: something else is to be run first."""
        self._round += 1
        if self._timer is not None:
            self._timer.cancel()
        if self.done is not None:
            self.done = None
            self.progress()

    def wake(self) -> None:
        """Begin a round after a pause, unless all is known."""
        self.rest()
        work = self.work() if self.count > 1 else {}
        if any(self._known(name, made) is None for name, made in work.items()):
            self.done = 0
            self.progress()
            self._timer = asyncio.get_running_loop().call_later(_PAUSE, self._begin, self._round)

    def known(self, name: str) -> list[dict[str, Any]] | None:
        """The rows of the present design, of the one before or of the rival; None while they are not known."""
        made = self.work().get(name) if self.count > 1 else None
        return None if made is None else self._known(name, made)

    def _known(self, name: str, made: Work) -> list[dict[str, Any]] | None:
        have = self.rows.get(name)
        return have[1] if have is not None and have[0] == (made, self.count) else None

    def _begin(self, number: int) -> None:
        self._task = asyncio.get_running_loop().create_task(self._run(number))

    async def _run(self, number: int) -> None:
        for name, made in self.work().items():
            if self._known(name, made) is not None:
                continue
            rows = await self._rows(number, made)
            if rows is None:
                return
            self.rows[name] = (made, self.count), rows
            self.publish(name)
            if number != self._round:
                return
        self.done = None
        self.progress()

    async def _rows(self, number: int, made: Work) -> list[dict[str, Any]] | None:
        """The rows of all seeds; None where the round has ended meanwhile."""
        first, function, *rest = made
        seeds = self.seeds(first)
        rows: list[dict[str, Any]] = []
        for begin in range(0, len(seeds), _PORTION):
            part: Sequence[int] = seeds[begin : begin + _PORTION]
            try:
                rows += await self.background(function, *rest, part)
            except (InputError, WorkError) as error:
                rows += [{"seed": seed, "why": str(error)} for seed in part]
            if number != self._round:
                return None
            self.done = (self.done or 0) + len(part)
            self.progress()
        return rows
