"""What is offered for a file that cannot be opened as it is: a wrong line to mend, a Mamdani system in other forms."""

import itertools
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

from nicegui import ui
from nicegui.elements.mixins.text_element import TextElement

from fuzzy.errors import InputError
from fuzzy.files.fisfile import FisFileError, decoded
from fuzzy.plugins.designer.bridge import Bridge
from fuzzy.plugins.designer.mamdanifile import SugenoForm
from fuzzy.plugins.designer.modules import Modules
from fuzzy.plugins.designer.open_documents import MamdaniFileError, OpenDocuments
from fuzzy.plugins.designer.workers import WorkError
from fuzzy.shown import shown, typeset

_CHANGES = 50  # of a Mamdani system that are listed
_FORMS = {
    "": "constants at the centroids",
    "constants": "constants fitted to its outputs",
    "planes": "planes over the inputs, fitted",
}
_MODULE = Path(__file__).parent / "static" / "mending.js"


def offer_mending(opened: OpenDocuments, modules: Modules, name: str, error: FisFileError) -> None:
    """Show the line of the file ``name`` that cannot be read, and open what the lines are once they can be.

    A text with another wrong line comes back with that one.
    """

    async def hear(content: Any) -> None:
        text = content.get("text") if isinstance(content, Mapping) else None
        if not isinstance(text, str):
            raise InputError("the page sends the text of the file")
        try:
            found = await opened.mended(name, text)
        except FisFileError as another:
            if another.line is None:
                place.send({"problem": str(another)})
            else:
                place.update(fault=_fault(another, next(numbers)))
        except (InputError, OSError, WorkError) as another:
            place.send({"problem": str(another)})
        else:
            ui.navigate.to(f"/?{urlencode({'file': found})}")

    numbers = itertools.count(1)
    text, _ = decoded(opened.folder.inside(name).read_bytes(), name)
    with ui.element("main").classes("shell shell-nothing"):
        place = Bridge(modules.url(_MODULE), {"file": name, "text": text, "fault": _fault(error, 0)}, lambda _: None)
        place.on_message(hear)


def _fault(error: FisFileError, number: int) -> dict[str, Any]:
    """The line, from 0, and what is wrong with it, without the line itself; the ``number`` tells one from the next."""
    assert error.line is not None
    return {"line": error.line - 1, "reason": typeset(error.reason.partition("\n")[0]), "number": number}


def offer_forms(error: MamdaniFileError) -> None:
    """Offer to open a Mamdani system as a Sugeno system, in each of its forms, and say how far the outputs are off."""

    def link(text: str, fit: str = "") -> None:
        to = urlencode({"file": error.free, "mamdani": error.name} | ({"fit": fit} if fit else {}))
        TextElement(tag="a", text=text).props(f'href="/?{to}"')

    with ui.element("main").classes("shell shell-nothing"):
        TextElement(tag="h1", text=f"{error.name} is a Mamdani system")
        words = (
            "The designer works with Sugeno systems. It can open this one as such, and saves it as "
            f"{error.free}; {error.name} stays as it is. Inputs and rules stay. The sets of the outputs become "
            "constants or planes, and the outputs differ from the Mamdani system's:"
        )
        TextElement(tag="p", text=words)
        if isinstance(error.forms, str):
            TextElement(tag="p", text=f"How far they differ is not measured: {error.forms}")
            with ui.element("p"):
                link(f"Open as {error.free}")
        else:
            _forms_table(error.forms, link)
        TextElement(tag="p", text="With constants at the centroids this changes:")
        with ui.element("ul"):
            for change in error.changes[:_CHANGES]:
                TextElement(tag="li", text=typeset(change))
            if len(error.changes) > _CHANGES:
                TextElement(tag="li", text=f"and {len(error.changes) - _CHANGES} more, alike")
        with ui.element("p"):
            TextElement(tag="a", text="Back to the designer").props('href="/"')


def _forms_table(forms: list[SugenoForm], link: Callable[[str, str], None]) -> None:
    """The differences of each form, by outputs, in their units and in shares of their ranges."""
    nearest = min(forms, key=lambda form: sum(off.root_mean_square for off in form.offs))
    with ui.element("div").classes("shell-forms"), ui.element("table"):
        TextElement(tag="caption", text=f"Differences on {forms[0].offs[0].points} points over the inputs")
        with ui.element("thead"), ui.element("tr"):
            for heading in ("sets become", "output", "worst", "root mean square"):
                TextElement(tag="th", text=heading).props('scope="col"')
        with ui.element("tbody"):
            for form in forms:
                for place, off in enumerate(form.offs):
                    with ui.element("tr"):
                        if place == 0:
                            with ui.element("td").props(f'rowspan="{len(form.offs)}"'):
                                link(f"Open with {_FORMS[form.fit]}", form.fit)
                                if form is nearest:
                                    TextElement(tag="span", text=" (nearest)")
                        TextElement(tag="td", text=off.output)
                        for share in (off.greatest, off.root_mean_square):
                            words = f"{shown(share * off.span, digits=3)} {off.unit}".rstrip()
                            TextElement(tag="td", text=typeset(f"{words} ({share:.1%})"))
