"""What all panels share of their state for one page: form values, messages from the page, and what is refused."""

import asyncio
import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, ClassVar

from fuzzy.errors import InputError
from fuzzy.naming import check_known
from fuzzy.plugins.designer.folder import open_folder
from fuzzy.plugins.designer.workers import WorkError
from fuzzy.system import Sugeno


def act_of(owner: object, wish: Any, doing: str = "_do_") -> Callable[[Any], Any] | None:
    """The method that does a ``wish`` of the page, "go on" is done by ``_do_go_on``; None: there is none.

    It takes the message, and may be a coroutine function. ``doing`` begins its name.
    """
    return getattr(owner, doing + re.sub(r"\W", "_", wish), None) if isinstance(wish, str) else None


class PanelSession:
    """A panel on one page: what is chosen there, and what is done for its messages {"do": wish, ...}.

    A wish is done by the method that :func:`act_of` finds.

    A subclass names the ``error`` of a wish that cannot be done, and further exceptions that are ``refusals``.
    """

    error: ClassVar[type[InputError]]
    refusals: ClassVar[tuple[type[Exception], ...]] = (InputError, WorkError)

    def __init__(self, bench: Any, **choice: Any) -> None:
        self.bench = bench
        self.folder = open_folder(bench.document.folder)
        self.choice = choice  # the values of the form, by name
        self._doing: asyncio.Task[None] | None = None  # a task that nobody holds may vanish

    def put(self, module: Path, **traits: Any) -> None:
        """Put the ``module`` on the page with its first ``traits``, and follow the page from now on."""
        self.widget = self.bench.widget(module, problem=None, **traits)
        self.widget.on_message(self.heard)
        self.bench.on_change(self.changed)
        self.bench.on_close(self.close)

    def changed(self) -> Any:
        """Follow a change of the document; it may be a coroutine function."""

    def close(self) -> None:
        """End what is being done, because the page is closed."""

    def heard(self, message: Any) -> Any:
        """Do what the page asks, in the order in which it asks; an error becomes a refusal.

        What takes no time is done at once: an undo that the page asks for right behind it must find it done.
        """
        message = message if isinstance(message, dict) else {}
        answer: Any = None
        with self.refusing(message):
            answer = self.act(message)
        self._doing = asyncio.get_running_loop().create_task(self._finish(answer, message))
        return self._doing

    async def _finish(self, answer: Any, message: dict[str, Any]) -> None:
        with self.refusing(message):
            if answer is not None:
                await answer

    def act(self, message: dict[str, Any]) -> Any:
        """Begin what a message asks for; the coroutine that goes on with it, if there is one."""
        wish = message.get("do")
        act = act_of(self, wish)
        if act is None:
            raise self.error(f"unknown wish {str(wish)[:40]!r}")
        self.begin()
        return act(message)

    def begin(self) -> None:
        """Forget, before each act, what was refused."""
        self.widget.update(problem=None)

    @contextmanager
    def refusing(self, message: dict[str, Any]) -> Iterator[None]:
        """Refuse on the page what goes wrong in the ``with`` block, which does a message."""
        try:
            yield
        except self.refusals as error:
            self.refuse(error, message)

    def refuse(self, error: Exception, message: Mapping[str, Any]) -> None:
        """Say on the page why nothing came of a message."""
        self.widget.update(problem=refusal_of(error, message))

    def setting(self, message: Mapping[str, Any]) -> tuple[str, Any]:
        """The name of the form's value that a message chooses, and the new value."""
        name = message.get("name")
        name = check_known(name, self.choice, "setting", self.error)
        return name, message.get("value")

    @property
    def present(self) -> Sugeno:
        """The system under design, without disabled rules."""
        fis: Sugeno = self.bench.document.design.in_force
        return fis


def refusal_of(error: Exception, message: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """A refusal for the page: under the field that the error is about (``InputError.about``), or what was chosen.

    A message that chooses no setting is refused where its wish stands; of a "column" the page is told which one.
    """
    message = message or {}
    wish, name = message.get("do"), message.get("name")
    keys = [key for key in getattr(error, "at", ()) if isinstance(key, str)]
    field = keys[0] if keys else name if wish == "choose" else wish
    return {"message": str(error), "field": field, "column": name if wish == "column" else None}
