"""What a module of a panel asks for: messages that name a wish, each done by its act."""

import asyncio
from collections.abc import Callable, Mapping
from typing import Any

from fuzzy.designer.workers import WorkError
from fuzzy.errors import InputError
from fuzzy.naming import expected

Act = Callable[[dict[str, Any]], Any]  # takes the message; may be a coroutine function


class Wishes:
    """Does what messages {"do": wish, ...} ask for, in the order in which they ask."""

    def __init__(
        self,
        acts: Mapping[str, Act],
        refuse: Callable[[Exception, dict[str, Any]], None],
        error: Callable[[str], InputError],
        begin: Callable[[], None] = lambda: None,
        also: tuple[type[Exception], ...] = (),
    ) -> None:
        """Nothing is done yet.

        Args:
            acts: What does each wish, by its name.
            refuse: Called with what went wrong, an InputError or a WorkError, and the message ({} where it was none).
            error: Makes the error of a wish that is not known.
            begin: Called before each act.
            also: Further exceptions that are refusals.
        """
        self._acts, self._refuse, self._error, self._begin = acts, refuse, error, begin
        self._refusals: tuple[type[Exception], ...] = (InputError, WorkError, *also)
        self._doing: asyncio.Task[None] | None = None  # a task that nobody holds may vanish

    def heard(self, message: Any) -> "asyncio.Task[None]":
        """Do what the page asks; an error becomes a refusal."""
        self._doing = asyncio.get_running_loop().create_task(self._do(message if isinstance(message, dict) else {}))
        return self._doing

    async def _do(self, message: dict[str, Any]) -> None:
        try:
            wish = message.get("do")
            if not isinstance(wish, str) or wish not in self._acts:
                raise self._error(expected(str(wish), self._acts, "wish"))
            self._begin()
            answer = self._acts[wish](message)
            if answer is not None:
                await answer
        except self._refusals as error:
            self._refuse(error, message)


def refusal_of_choice(error: Exception, message: Mapping[str, Any]) -> dict[str, Any]:
    """A refusal for the page: under the setting or the column that was chosen, or where the wish itself stands."""
    what, name = message.get("do"), message.get("name")
    field, column = (name if what == "choose" else what), (name if what == "column" else None)
    return {"message": str(error), "field": field, "column": column}


def refusal_at(error: Exception, otherwise: Any = None) -> dict[str, Any]:
    """A refusal for the page: under the field that the error is about (``InputError.about``), or ``otherwise``."""
    keys = [key for key in getattr(error, "at", ()) if isinstance(key, str)]
    return {"message": str(error), "field": keys[0] if keys else otherwise}
