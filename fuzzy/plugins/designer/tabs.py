"""Groups of tabs on the page, and drawers over them; the content of each is built when it is first looked at."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from nicegui import background_tasks, ui
from nicegui.elements.mixins.text_element import TextElement
from nicegui.events import GenericEventArguments

from fuzzy.plugins.designer.panel import PagePart, Workbench

_KEYS = """(event) => {
  if (!["ArrowLeft", "ArrowRight", "Home", "End"].includes(event.key)) return;
  event.preventDefault();
  emit(event.key);
}"""
# Where the panes of a group are swiped, the view that is chosen is the first of them.
_CLICK = """(event) => {
  event.currentTarget.closest(".shell-group").scrollLeft = 0;
  emit();
}"""
_ESCAPE = """(event) => {
  if (event.key === "Escape" && !event.defaultPrevented && !event.target.closest("dialog, details[open]")) emit();
}"""


@dataclass
class Tab:
    """A title, and the function that builds the tab's content, once."""

    title: str
    build: Callable[[], Any]
    place: PagePart = field(default_factory=lambda: PagePart(shown=False))
    purpose: str = ""  # of the rule base; a tab without one suits all
    drawer: bool = False  # opened by a button elsewhere, over the tabs, which it gives back when it is closed
    built: bool = False


class TabGroup:
    """A group of tabs, of which one is shown; pointer, arrow keys, Home and End choose another.

    Args:
        label: The name of the group.
        tabs: The tabs, and the drawers over them.
        bench: The workbench of the page.
        name: The group's id on the page, for links.
        purpose: Of the rule base; without one all tabs suit.
    """

    def __init__(self, label: str, tabs: Sequence[Tab], bench: Workbench, name: str, purpose: str = "") -> None:
        self._bench, self._tabs = bench, {tab.title: tab for tab in tabs}
        self._closed: Callable[[], Any] | None = None  # gives the focus back to what opened the drawer
        with ui.element("section").classes("shell-group").props(f'aria-label="{label}" id="{name}" tabindex="-1"'):
            with ui.element("div").classes("shell-row"):
                self.before = ui.element("div").classes("shell-before")
                with ui.element("div").classes("shell-tabs").props(f'role="tablist" aria-label="{label}"'):
                    self._buttons = {tab.title: self._button(tab) for tab in tabs if not tab.drawer}
                self.after = ui.element("div").classes("shell-after")
            with ui.element("div").classes("shell-views"):
                self._panels = {tab.title: self._panel(tab) for tab in tabs}
            self.below = ui.element("div").classes("shell-below")
        self._front = next(iter(self._buttons))  # the tab that is shown, or stands under a drawer
        self._shown = ""
        self.fit(purpose)

    def _button(self, tab: Tab) -> TextElement:
        button = TextElement(tag="button", text=tab.title).props('type="button" role="tab"')
        button.on("click", lambda: self.show(tab.title), js_handler=_CLICK)
        button.on("keydown", lambda event: self._key(tab.title, event), js_handler=_KEYS)
        return button

    def _panel(self, tab: Tab) -> Any:
        panel = ui.element("div").classes("shell-view")
        if not tab.drawer:
            panel.props('role="tabpanel"').props["aria-labelledby"] = self._buttons[tab.title].html_id
            self._buttons[tab.title].props["aria-controls"] = panel.html_id
            return panel
        panel.classes("shell-drawer").props(f'role="region" aria-label="{tab.title}"')
        panel.on("keydown", lambda: self.close(), js_handler=_ESCAPE)
        with panel, ui.element("div").classes("shell-drawer-head"):
            TextElement(tag="h2", text=tab.title)
            close = TextElement(tag="button", text="×").props(f'type="button" aria-label="Close {tab.title}"')
            close.on("click", lambda: self.close(), args=[])
            panel.close_button = close  # type: ignore[attr-defined]
        return panel

    def _key(self, title: str, event: GenericEventArguments) -> None:
        known = [name for name, button in self._buttons.items() if "shell-unfit" not in button.classes]
        at = known.index(title)
        to = {"ArrowLeft": at - 1, "ArrowRight": at + 1, "Home": 0, "End": -1}.get(str(event.args), at)
        self.show(known[to % len(known)])
        self._buttons[self._shown].run_method("focus")

    @property
    def drawers(self) -> list[str]:
        """The titles of the drawers."""
        return [tab.title for tab in self._tabs.values() if tab.drawer]

    def show(self, title: str) -> None:
        """Show the tab or drawer with this title."""
        if title == self._shown:
            return
        tab = self._tabs[title]
        self._shown = title
        if not tab.drawer:
            self._front, self._closed = title, None
        for name, panel in self._panels.items():
            on = name == title
            self._tabs[name].place.shown = on
            panel.classes(add="shell-shown") if on else panel.classes(remove="shell-shown")
        for name, button in self._buttons.items():
            on = name == self._front
            button.props["aria-selected"] = "true" if on else "false"
            button.props["tabindex"] = "0" if on else "-1"
            button.update()
        if not tab.built:
            tab.built = True
            with self._panels[title], self._bench.building(tab.place):
                tab.build()
        elif tab.place.missed:
            tab.place.missed = False
            background_tasks.create(self._bench.changed(tab.place))

    def open(self, title: str, closed: Callable[[], Any] | None = None) -> None:
        """Open a drawer, or close it where it is open; ``closed`` is called when it has been closed."""
        if self._shown == title:
            self.close()
            return
        self.show(title)
        self._closed = closed
        self._panels[title].close_button.run_method("focus")

    def close(self) -> None:
        """Close the drawer that is open: the tab under it is shown again."""
        if self._shown != self._front:
            closed = self._closed
            self.show(self._front)
            if closed is not None:
                closed()

    def fit(self, purpose: str) -> None:
        """Offer only the tabs that suit a purpose, and show the first of them."""
        for name, button in self._buttons.items():
            suits = self._suits(name, purpose)
            button.classes(remove="shell-unfit") if suits else button.classes(add="shell-unfit")
        self.show(next(name for name in self._buttons if self._suits(name, purpose)))

    def _suits(self, name: str, purpose: str) -> bool:
        return not purpose or self._tabs[name].purpose in ("", purpose)
