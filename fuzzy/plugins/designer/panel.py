"""The interface between the designer and the panels beside the rule base, and how panels are found.

``fuzzy`` knows no other package: an entry point of the group "fuzzyfleet.designer" names a :class:`Panel`, or the class
or function that makes one.
"""

import asyncio
import inspect
from collections.abc import Awaitable, Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

from fuzzy.errors import InputError
from fuzzy.plugins.designer.folder import Folder
from fuzzy.plugins.designer.workers import DesignerWorkers
from fuzzy.system import Sugeno

if TYPE_CHECKING:
    from fuzzy.plugins.designer.bridge import Bridge
    from fuzzy.plugins.designer.document import Document

T = TypeVar("T")
HEAD_START = 0.1  # s that what follows the hand may take before the rest of the page is told
SENT = 0.003  # s that it then has to leave
PANEL_ENTRY_POINTS = "fuzzyfleet.designer"


FUNCTION = "function"  # the purpose of a rule base of which nothing else is found


class Panel(Protocol):
    """A tab of the designer. It may have the further attributes of :class:`SessionPanel`."""

    @property
    def title(self) -> str:
        """The text of the tab."""

    @property
    def order(self) -> int:
        """The place of the tab: tabs with lower numbers stand further left."""

    def build(self, bench: "Workbench") -> None:
        """Put the panel on the page, once a browser tab, when it is first looked at."""


@dataclass(frozen=True)
class SessionPanel:
    """A panel that begins a session for each page that shows it: ``session(bench)``.

    Attributes:
        purpose: For which rule bases it is: "function", "loop", "robot" or another word; empty: for all.
        improves: By what it improves the rule base: it is opened by the button Improve, over the editors.
        suits: Whether a system, by the names of its variables, is for this purpose.
        belongs: Whether it is there for the file of this path; None: for every file.
    """

    title: str
    order: int
    session: Callable[[Any], Any]
    purpose: str = ""
    improves: str = ""
    suits: Callable[[Sugeno], bool] | None = None
    belongs: Callable[[Path], bool] | None = None

    def build(self, bench: Any) -> None:
        """Put the panel on the page of ``bench``, a :class:`Workbench`."""
        self.session(bench)


@dataclass
class PagePart:
    """A part of the page that is shown or hidden; callbacks that depend on the design rest while it is hidden."""

    shown: bool = True
    missed: bool = False  # a change while it was hidden


class Workbench:
    """One browser tab's view of a document, as panels see it.

    Args:
        document: The document.
        workers: What works in the background.
        module_url: Where the page finds a file.
        say: Shows a sentence, which is that of a problem or not.
        reading: Runs a function that reads the file of a name within a time limit; by default a worker reads it.
        open_rule: Leads to a rule, by its key.
        tell_shared: Gives the page's views the values in ``shared``.
        give: Hands a file to whoever sits at the page, by its bytes and its name.
    """

    def __init__(
        self,
        document: "Document",
        workers: DesignerWorkers,
        module_url: Callable[[Path], str],
        say: Callable[[str, bool], None],
        reading: Callable[..., Awaitable[Any]] | None = None,
        open_rule: Callable[[int], None] = lambda key: None,
        tell_shared: Callable[[], None] = lambda: None,
        give: Callable[[bytes, str], None] = lambda data, name: None,
    ) -> None:
        self.document = document
        self.closed = False
        self._workers, self._module_url, self._say = workers, module_url, say
        self._reading, self._open_rule, self._tell_shared, self._give = reading, open_rule, tell_shared, give
        self._change_callbacks: list[tuple[PagePart, Callable[[], Any], bool]] = []
        self._close_callbacks: list[Callable[[], Any]] = []
        self._here = PagePart()
        self._groups: dict[str, Callable[[str], None]] = {}
        self.shared: dict[str, Any] = {}
        self.pictured: dict[str, Any] = {}  # what the panels have chosen, for the pictures of a set

    def widget(self, module: Path, **traits: Any) -> "Bridge":
        """Show the ES module in the file ``module``, a part of an installed package, with its model's first values."""
        from fuzzy.plugins.designer.bridge import Bridge

        return Bridge(self._module_url(module), traits, lambda sentence: self.notify(sentence, problem=True))

    def on_change(self, callback: Callable[[], Any], hidden: bool = False, later: bool = False) -> None:
        """Call ``callback()``, a function or a coroutine, after the edits in hand, until the tab closes.

        While the panel that is being built now is hidden, its callbacks rest; they are called once when it is
        shown again. With ``hidden`` this one never rests. With ``later`` it waits for what the others begin, HEAD_START
        seconds at most: what a drag leads to is seen before what is said of it.
        """
        self._change_callbacks.append((PagePart() if hidden else self._here, callback, later))

    def on_close(self, callback: Callable[[], Any]) -> None:
        """Call ``callback()`` when the browser tab has been closed for good, or shows another file."""
        self._close_callbacks.append(callback)

    async def background(self, function: Callable[..., T], *args: Any) -> T:
        """Run ``function(*args)`` in a worker process; both must be picklable.

        Raises InputError where the function did, :class:`fuzzy.plugins.designer.workers.WorkError` for other failures.
        """
        return await self._workers.run(function, *args)

    async def read(self, name: str, function: Callable[..., T], *args: Any) -> T:
        """Run ``function(*args)``, which reads the file called ``name``, in another process, within a time limit.

        For what somebody else's file may make slow. Raises as :meth:`background` does, and InputError where it is late.
        """
        if self._reading is None:
            return await self.background(function, *args)
        found: T = await self._reading(name, function, *args)
        return found

    def show(self, title: str) -> None:
        """Bring the tab with this title to the front, in its own group."""
        if not self.closed and title in self._groups:
            self._groups[title](title)

    def look_at(self, point: Sequence[float]) -> None:
        """Look at another point (inputs,), in the units of the inputs: the viewer, the surface and the editors follow.

        It is no edit: nothing is there to be undone, and the file is not changed. Raises EditError for a point that is
        not one number an input.
        """
        self.document.apply({"look": "point", "point": [float(value) for value in point]})

    def open_rule(self, key: int) -> None:
        """Lead to the rule with this key (``RuleLine.key``) in the tab Rules. Unknown keys lead nowhere."""
        if not self.closed:
            self._open_rule(key)

    def share(self, **traits: Any) -> None:
        """Give the page's own views traits beside the design's, of which they know:

        ``histograms`` of measured rows, as :func:`fuzzy.plugins.designer.datapictures.histograms` makes them, or None:
        the tab Memberships draws them below its curves.
        """
        self.shared |= traits
        if not self.closed:
            self._tell_shared()

    def give(self, data: bytes, name: str) -> None:
        """Hand a file to whoever sits at the page: the browser downloads it under this name."""
        if not self.closed:
            self._give(data, name)

    def notify(self, sentence: str, problem: bool = False) -> None:
        """Show a sentence for some seconds; a problem stays until the next one or until it is put away."""
        if not self.closed:
            self._say(Folder(self.document.folder).without_place(sentence), problem)

    # For the page --------------------------------------------------------------------------------------------

    def lead(self, titles: Iterable[str], show: Callable[[str], None]) -> None:
        """Note what brings the tabs with these titles to the front."""
        self._groups |= dict.fromkeys(titles, show)

    @contextmanager
    def building(self, place: PagePart) -> Iterator[None]:
        """Note that what is built in the ``with`` block stands in ``place``."""
        before, self._here = self._here, place
        try:
            yield
        finally:
            self._here = before

    async def changed(self, place: PagePart | None = None) -> None:
        """Tell all that is shown, or all in ``place``, that the document changed."""
        waiting: list[asyncio.Future[Any]] = []
        for turn in (False, True):
            if turn and waiting:
                await asyncio.wait(waiting, timeout=HEAD_START)
                await asyncio.sleep(SENT)
            for where, callback, later in list(self._change_callbacks):
                if self.closed or later != turn or (place is not None and where is not place):
                    continue
                if not where.shown:
                    where.missed = True
                    continue
                waiting += map(asyncio.ensure_future, self._called(callback))
        for outcome in await asyncio.gather(*waiting, return_exceptions=True):
            if isinstance(outcome, InputError):
                self.notify(str(outcome), problem=True)
            elif isinstance(outcome, BaseException):
                raise outcome

    async def close(self) -> None:
        """Note that the tab is gone, and call what waits for that."""
        if not self.closed:
            self.closed = True
            for callback in self._close_callbacks:
                for result in self._called(callback):
                    await result

    def _called(self, callback: Callable[[], Any]) -> list[Any]:
        try:
            result = callback()
        except InputError as error:
            self.notify(str(error), problem=True)
            return []
        return [result] if inspect.isawaitable(result) else []


def head_start(task: asyncio.Task[Any] | None) -> asyncio.Future[Any] | None:
    """What a panel gives back of a change that began ``task``: the page waits for it, HEAD_START seconds at most."""
    return task and asyncio.ensure_future(asyncio.wait([task], timeout=HEAD_START))


def purposes_of(panels: Iterable[Panel]) -> list[str]:
    """What rule bases are for, as the panels say: a function first, then in the order of the panels."""
    named = [getattr(panel, "purpose", "") for panel in panels]
    return list(dict.fromkeys([FUNCTION, *filter(None, named)]))


def purpose_of(system: Sugeno, panels: Iterable[Panel]) -> str:
    """What ``system`` is for, by the names of its variables."""
    for panel in panels:
        suits = getattr(panel, "suits", None)
        if suits is not None and suits(system):
            return str(getattr(panel, "purpose", FUNCTION))
    return FUNCTION


def find_panels() -> tuple[list[Panel], list[str]]:
    """The installed panels in their order, and a sentence for each that cannot be used."""
    panels: list[Panel] = []
    sentences = []
    for point in sorted(metadata.entry_points(group=PANEL_ENTRY_POINTS), key=lambda point: point.name):
        try:
            found = point.load()
            panels.append(found() if callable(found) else found)
        except (ImportError, AttributeError) as error:
            sentences.append(f"the panel {point.name!r} cannot be used: {error}")
    return sorted(panels, key=lambda panel: (panel.order, panel.title)), sentences
