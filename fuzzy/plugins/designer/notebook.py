"""The designer in a notebook: the page's modules as one anywidget."""

import asyncio
import itertools
from collections.abc import Mapping
from functools import partial
from io import BytesIO
from pathlib import Path
from typing import Any

from fuzzy.errors import InputError
from fuzzy.esmodule import composed, widget_library, with_still
from fuzzy.figures.palette import stylesheet
from fuzzy.plugins.designer.design import Design, design_of
from fuzzy.plugins.designer.document import DEPTH
from fuzzy.plugins.designer.edits import edited
from fuzzy.plugins.designer.views import design_data, functions_data, or_none, refusal_data, surface_data, viewer_data
from fuzzy.plugins.type2.system import Type2Sugeno
from fuzzy.system import Sugeno, sizes
from fuzzy.words import counted

_SOON = 0.004  # s that edits in hand may take to arrive before they are shown together
_KEPT: dict[str, "NotebookSession"] = {}  # of this kernel, the last of each name
_STILL = 96  # dots per inch of the picture that stays in a saved notebook


class NotebookSession:
    """A design with its history, the point that is looked at, and the traits that show it; there is no file.

    Where an ``earlier`` session has edits, they are not lost: of the same system it goes on with them; of another one
    they are a step back.
    """

    def __init__(self, fis: Sugeno | Type2Sugeno, earlier: "NotebookSession | None" = None) -> None:
        self._start = self.design = design_of(fis)
        self._undo: list[tuple[str, Design]] = []
        self._redo: list[tuple[str, Design]] = []
        self._notice: dict[str, Any] | None = None
        self._gesture: Any = None
        self._axes: list[int] | None = None
        self._output = 0
        self._selected: dict[str, Any] = {"kind": "input", "variable": self.design.system.inputs[0].name, "term": None}
        self._problem: dict[str, Any] | None = None
        self._problems = itertools.count(1)
        self._revision = 0
        if earlier is not None and earlier._undo:
            self._go_on(earlier)

    def hear(self, content: Any) -> None:
        """Do what a module's message asks; an error becomes the trait ``problem`` and is not raised."""
        try:
            self._take(content if isinstance(content, Mapping) else {})
            self._problem = None
        except InputError as error:
            self._problem = refusal_data(error, content, next(self._problems))

    def traits(self) -> dict[str, Any]:
        """What the modules show now."""
        design = self.design
        names = [entries[-1][0] if entries else None for entries in (self._undo, self._redo)]
        return {
            "design": design_data(design, revision=self._revision, undo=names[0], redo=names[1]),
            "functions": functions_data(),
            "point": list(design.point),
            "selected": self._selected,
            "problem": self._problem,
            "viewer": or_none(viewer_data, design),
            "surface": or_none(surface_data, design, *self._known_axes()),
            "compared": None,
            "notice": self._notice,
        }

    def _take(self, content: Mapping[str, Any]) -> None:
        look = content.get("look")
        if look == "select":
            self._selected = {name: content.get(name) for name in ("kind", "variable", "term")}
            if content.get("show") is True:
                self._selected["show"] = next(self._problems)
        elif look == "surface":
            before = self._axes, self._output
            self._axes, self._output = content.get("inputs"), content.get("output")  # type: ignore[assignment]
            if self._known_axes() != (self._axes, self._output):
                self._axes, self._output = before
                raise InputError("a surface has one or two of the inputs and one output, each by its number")
        elif content.get("do") == "anew":
            self._begin_anew()
        elif content.get("do") in ("undo", "redo"):
            self._step(*((self._undo, self._redo) if content["do"] == "undo" else (self._redo, self._undo)))
        else:
            self._edit(content)

    def _edit(self, content: Mapping[str, Any]) -> None:
        new, name = edited(self.design, content)
        if "edit" in content and new != self.design:
            gesture = content.get("gesture")
            if not (isinstance(gesture, (str, int)) and gesture == self._gesture and self._undo):
                self._undo = [*self._undo, (name, self.design)][-DEPTH:]
            self._gesture = gesture
            self._redo = []
            self._revision += 1
        self.design = new

    def _go_on(self, earlier: "NotebookSession") -> None:
        self.design, self._undo, self._redo = earlier.design, [*earlier._undo], [*earlier._redo]
        edits = counted(len(self._undo), "edit") if earlier.design.shown != earlier._start.shown else ""
        if earlier._start.shown == self._start.shown:
            kept = {"says": f"Kept from before: {edits}.", "anew": True}
            self._notice = kept if edits else earlier._notice
        else:
            self._begin_anew()
            apart = {"says": f"The cell gives another system. Undo brings back {edits}.", "anew": False}
            self._notice = apart if edits else None

    def _begin_anew(self) -> None:
        """Show the system that the cell gives; what was edited is a step back."""
        self._undo = [*self._undo, ("the system of the cell", self.design)][-DEPTH:]
        self._redo, self._gesture, self._notice, self.design = [], None, None, self._start
        self._revision += 1

    def _step(self, back: list[tuple[str, Design]], forth: list[tuple[str, Design]]) -> None:
        if back:
            name, design = back.pop()
            forth.append((name, self.design))
            self.design, self._gesture = design, None
            self._revision += 1

    def _known_axes(self) -> tuple[list[int] | None, int]:
        inputs, outputs = len(self.design.system.inputs), len(self.design.system.outputs)
        axes, output = self._axes, self._output
        known = isinstance(axes, list) and all(type(i) is int and 0 <= i < inputs for i in axes)
        if not (known and axes is not None and 0 < len(set(axes)) == len(axes) <= 2):
            axes = None
        return axes, output if type(output) is int and 0 <= output < outputs else 0


def editor(fis: Sugeno | Type2Sugeno, key: str | None = None) -> Any:
    """Make the designer of ``fis`` as a widget for Jupyter, marimo and other notebooks that show anywidgets.

    A cell that is run again goes on with the edits that were made in the editor of the same name, and says so; a button
    starts from ``fis``. If the cell gives another system than before, that is shown, and undo brings the edits back.

    Args:
        fis: The system, of type 1 or an interval type-2 one, which stays as it is.
        key: The name by which edits are found again in this kernel, by default the system's.

    Returns:
        The widget; its ``fis`` is the system as edited so far.

    Raises:
        ModuleError: The extra ``notebook`` is not installed.
    """
    anywidget, traitlets = widget_library()
    folder = Path(__file__).parent / "static"
    name = fis.name if key is None else key
    session = _KEPT[name] = NotebookSession(fis, _KEPT.get(name))
    traits = session.traits()

    class Editor(anywidget.AnyWidget):  # type: ignore[name-defined]
        """The designer; ``fis`` is the system as edited so far."""

        _esm = composed(folder / "notebook.js")
        _css = stylesheet() + "".join(
            (folder / f"{sheet}.css").read_text("utf-8") for sheet in ("designer", "notebook")
        )
        seen = traitlets.Int(0).tag(sync=True)  # the revision that the notebook shows, which it says itself
        locals().update({name: traitlets.Any(value).tag(sync=True) for name, value in traits.items()})

        def __init__(self) -> None:
            super().__init__()
            self._waiting = False
            self.on_msg(self._heard)

        def _repr_mimebundle_(self, **kwargs: Any) -> tuple[dict[str, Any], dict[str, Any]] | None:
            system = session.design.in_force
            return with_still(
                super()._repr_mimebundle_(**kwargs),
                f"Editor of {system.name}: {sizes(system)}",
                partial(_still, system),
            )

        @property
        def fis(self) -> Sugeno | Type2Sugeno:
            return session.design.shown

        def _heard(self, widget: Any, content: Any, buffers: Any) -> None:
            session.hear(content)
            try:
                loop = asyncio.get_running_loop()
            except RuntimeError:
                self._show()
                return
            # As on the page: what arrives together is shown once.
            if not self._waiting:
                self._waiting = True
                loop.call_later(_SOON, self._show)

        def _show(self) -> None:
            self._waiting = False
            with self.hold_sync():
                for name, value in session.traits().items():
                    setattr(self, name, value)

    return Editor()


def _still(fis: Sugeno) -> bytes:
    from fuzzy.figures.plot import plot_memberships

    picture = BytesIO()
    plot_memberships(fis).savefig(picture, format="png", dpi=_STILL)
    return picture.getvalue()
