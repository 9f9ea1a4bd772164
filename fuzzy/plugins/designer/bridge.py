"""An ES module on a NiceGUI page: an anywidget model (``get``, ``on``, ``send``) over the page's socket."""

import inspect
import json
from collections.abc import Callable
from typing import Any

from nicegui.client import Client
from nicegui.element import Element
from nicegui.events import GenericEventArguments
from nicegui.json import dumps

from fuzzy.errors import InputError
from fuzzy.shell.terminal import plain

_SHARED = "window.fuzzyfleetShared"  # on the page: values that several modules are given, by their names


class Shared:
    """A value for several modules of a page, encoded and sent to the page once. It stays until the next of its name."""

    def __init__(self, name: str, value: Any) -> None:
        self.name, self.text = name, _text(value)

    def send(self, client: Client) -> None:
        """Put the value where the modules of a page take it from."""
        client.run_javascript(f"({_SHARED} ??= {{}})[{json.dumps(self.name)}] = {self.text}; 0")


class Bridge(Element, component="static/bridge.js"):
    """A place on the page that a module draws on; made by :meth:`fuzzy.plugins.designer.panel.Workbench.widget`.

    ``url`` is where the page finds the module, ``traits`` are the model's first values (JSON's types, arrays; what
    is not finite becomes null). An InputError that what hears the module raises goes to ``refuse``.
    """

    def __init__(self, url: str, traits: dict[str, Any], refuse: Callable[[str], None]) -> None:
        super().__init__()
        self._refuse = refuse
        self._sent = {name: _text(value) for name, value in traits.items()}
        self._hear: Callable[[Any], Any] = lambda content: None
        self._props["module"] = url
        # As one text: Vue need not watch what is in it.
        self._props["traits"] = _object(self._sent)
        self.on("message", self._receive_message)

    def update(self, **traits: Any) -> None:
        """Give the model new values; those that it already has are not sent again.

        A :class:`Shared` value must have been sent to the page.
        """
        if not traits:
            super().update()
            return
        texts = {name: _text(value) for name, value in traits.items()}
        news = {name: text for name, text in texts.items() if self._sent.get(name) != text}
        if news and not self.is_deleted:
            self._sent |= news
            shared = {n: f"{_SHARED}[{json.dumps(v.name)}]" for n, v in traits.items() if isinstance(v, Shared)}
            self._call("receive", _object(news | {name: shared[name] for name in news if name in shared}))

    def forget(self, name: str) -> None:
        """Send a value with the next update even if it is the same: the page shows what has been typed there since."""
        self._sent.pop(name, None)

    def send(self, content: Any) -> None:
        """Send a message to the module, which hears it with ``model.on("msg:custom", ...)``."""
        if not self.is_deleted:
            self._call("receiveMessage", _text(content))

    def on_message(self, callback: Callable[[Any], Any]) -> None:
        """Call ``callback(content)``, a function or a coroutine, for each ``model.send(content)`` of the module."""
        self._hear = callback

    def _call(self, method: str, text: str) -> None:
        # The call is written here: the text is JSON, in which JavaScript reads the same value.
        self.client.run_javascript(f"getElement({self.id})?.{method}({text})")

    async def _receive_message(self, event: GenericEventArguments) -> None:
        try:
            answer = self._hear(event.args)
            if inspect.isawaitable(answer):
                await answer
        except InputError as error:
            self._refuse(str(error))


def _text(value: Any) -> str:
    if isinstance(value, Shared):
        return value.text
    try:
        return dumps(value)
    except (TypeError, ValueError):
        return json.dumps(plain(value), separators=(",", ":"))


def _object(texts: dict[str, str]) -> str:
    return "{" + ",".join(f"{json.dumps(name)}:{text}" for name, text in texts.items()) + "}"
