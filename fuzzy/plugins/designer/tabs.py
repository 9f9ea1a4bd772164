"""Groups of tabs on the page; the content of a tab is built when it is first looked at."""

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


@dataclass
class Tab:
    """A title, and the function that builds the tab's content, once."""

    title: str
    build: Callable[[], Any]
    place: PagePart = field(default_factory=lambda: PagePart(shown=False))
    built: bool = False


@dataclass(frozen=True)
class TabGroup:
    """A group of tabs on the page, by their titles."""

    show: Callable[[str], None]  # the tab with this title
    count: Callable[[str, int], None]  # writes a number behind the tab's title; 0 writes none


def tab_group(label: str, tabs: Sequence[Tab], bench: Workbench, name: str) -> TabGroup:
    """Build a group of tabs, of which the first is shown; pointer, arrow keys, Home and End choose another.

    Args:
        label: The name of the group.
        tabs: The tabs.
        bench: The workbench of the page.
        name: The group's id on the page, for links.
    """
    section = ui.element("section").classes("shell-group").props(f'aria-label="{label}" id="{name}" tabindex="-1"')
    with section:
        with ui.element("div").classes("shell-tabs").props(f'role="tablist" aria-label="{label}"'):
            buttons = [TextElement(tag="button", text=tab.title).props('type="button" role="tab"') for tab in tabs]
        panels = [ui.element("div").classes("shell-view").props('role="tabpanel"') for _ in tabs]

    def choose(chosen: int, focus: bool = False) -> None:
        for number, (tab, button, panel) in enumerate(zip(tabs, buttons, panels, strict=True)):
            tab.place.shown = number == chosen
            button.props["aria-selected"] = "true" if tab.place.shown else "false"
            button.props["tabindex"] = "0" if tab.place.shown else "-1"
            panel.classes(add="shell-shown") if tab.place.shown else panel.classes(remove="shell-shown")
            button.update()
        tab = tabs[chosen]
        if not tab.built:
            tab.built = True
            with panels[chosen], bench.building(tab.place):
                tab.build()
        elif tab.place.missed:
            tab.place.missed = False
            background_tasks.create(bench.changed(tab.place))
        if focus:
            buttons[chosen].run_method("focus")

    def key(number: int, event: GenericEventArguments) -> None:
        to = {"ArrowLeft": number - 1, "ArrowRight": number + 1, "Home": 0, "End": -1}.get(str(event.args), number)
        choose(to % len(tabs), focus=True)

    for number, (button, panel) in enumerate(zip(buttons, panels, strict=True)):
        button.props["aria-controls"] = panel.html_id
        panel.props["aria-labelledby"] = button.html_id
        button.on("click", lambda number=number: choose(number), args=[])
        button.on("keydown", lambda event, number=number: key(number, event), js_handler=_KEYS)
    choose(0)
    places = {tab.title: number for number, tab in enumerate(tabs)}

    def count(title: str, number: int) -> None:
        text = f"{title} {number}" if number else title
        if buttons[places[title]].text != text:
            buttons[places[title]].set_text(text)

    return TabGroup(lambda title: choose(places[title]), count)
