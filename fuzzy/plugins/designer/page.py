"""The designer's page: one for each browser tab, over the document that the tabs share."""

import asyncio
import itertools
import re
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any
from weakref import WeakKeyDictionary

from nicegui import background_tasks, ui
from nicegui.elements.mixins.text_element import TextElement

from fuzzy.entrypoints import entry_points
from fuzzy.errors import InputError
from fuzzy.figures.palette import stylesheet
from fuzzy.files.examples import is_example
from fuzzy.files.fisfile import FisFileError, beyond_matlab
from fuzzy.naming import check_known
from fuzzy.plugins.designer.bridge import Bridge, Shared
from fuzzy.plugins.designer.design import Design
from fuzzy.plugins.designer.document import Document
from fuzzy.plugins.designer.figures import ALL_FIGURES, all_figures, check_figure, figure_bytes
from fuzzy.plugins.designer.folder import LARGEST_FILE
from fuzzy.plugins.designer.historytab import HistoryTab
from fuzzy.plugins.designer.keys import SHORTCUTS
from fuzzy.plugins.designer.latest import Latest, Postponed
from fuzzy.plugins.designer.mending import offer_forms, offer_mending
from fuzzy.plugins.designer.modules import Modules
from fuzzy.plugins.designer.open_documents import MamdaniFileError, OpenDocuments
from fuzzy.plugins.designer.panel import FUNCTION, PagePart, Panel, Workbench, find_panels, purpose_of, purposes_of
from fuzzy.plugins.designer.saving import OverwriteError, digest_of
from fuzzy.plugins.designer.session import act_of
from fuzzy.plugins.designer.sideeffects import broken
from fuzzy.plugins.designer.starting import Starting
from fuzzy.plugins.designer.tabs import Tab, TabGroup
from fuzzy.plugins.designer.views import (
    SMALL_POINTS,
    compared_data,
    document_data,
    findings_data,
    functions_data,
    or_none,
    refusal_data,
    several_data,
    surface_data,
    viewer_data,
)
from fuzzy.plugins.designer.workers import WorkError
from fuzzy.plugins.type2.system import Type2Sugeno
from fuzzy.system import Sugeno

# What makes a zip of a design: (system, name, type of numbers, points of a table) -> bytes
_C_WRITER = next(iter(entry_points(group="fuzzyfleet.exports", name="c")), None)
_TYPE_2 = "this is a type-2 system; what tries, trains and tunes a rule base here is for type-1 systems"
COARSE, FINE = 13, 0.2  # points of a small surface along each axis while one drags, and s until they are fine again
REST = 0.8  # s after the last edit before the rules are checked: a hand that hesitates goes on before
_FEW = 50  # rules up to which that takes some hundredths of a second
DRAWN_WITHIN = 2.0  # s that drawing may take before the next state is sent all the same
# A page in the background draws nothing until it is looked at.
_DRAWN = """new Promise((done) => {
  setTimeout(done, 100);
  if (!document.hidden) requestAnimationFrame(() => setTimeout(done));
})"""
_ENCODED: WeakKeyDictionary[Document, tuple[int, Shared]] = WeakKeyDictionary()  # with the revision
_STATIC = Path(__file__).parent / "static"


async def build_page(opened: OpenDocuments, modules: Modules, name: str, mamdani: str = "", fit: str = "") -> None:
    """Fill the page of a new browser tab with the designer of a file, or with what is wrong with the file.

    Args:
        opened: The open documents.
        modules: The modules that pages may load.
        name: The file's name in the folder.
        mamdani: The file with the Mamdani system with which a new file begins.
        fit: What that system's sets become.
    """
    ui.add_head_html(f"<style>{stylesheet()}</style>")
    for sheet in ("designer.css", "page.css"):
        ui.add_head_html(f'<link rel="stylesheet" href="{modules.url(_STATIC / sheet)}">')
    # NiceGUI's own page is a main landmark round the whole of this one, header and all.
    around = ui.context.client.content.parent_slot
    if around is not None:
        around.parent.tag = "div"
    try:
        # A worker reads the file while the panels are looked for here.
        document, panels = await asyncio.gather(opened.opened(name, mamdani, fit), asyncio.to_thread(find_panels))
    except MamdaniFileError as error:
        offer_forms(error)
        return
    except (InputError, OSError, WorkError) as error:
        if isinstance(error, FisFileError) and error.line is not None:
            offer_mending(opened, modules, name, error)
            return
        with ui.element("main").classes("shell shell-nothing"):
            TextElement(tag="h1", text="This file cannot be opened")
            TextElement(tag="p", text=str(error)).props('role="alert"')
            TextElement(tag="a", text="Back to the designer").props('href="/"')
        return
    _Page(opened, modules, document, panels)


class _Page:
    """What one browser tab shows, and what it asks for."""

    def __init__(
        self, opened: OpenDocuments, modules: Modules, document: Document, panels: tuple[list[Panel], list[str]]
    ) -> None:
        self.opened, self.document = opened, document
        self.client = ui.context.client
        self.bench = Workbench(
            document,
            opened.workers,
            modules.url,
            self._say,
            opened.reading,
            self._open_rule,
            self._show_shared,
            self.client.download,
        )
        first = document.design.system.inputs[0].name
        self.selected: dict[str, Any] = {"kind": "input", "variable": first, "term": None}
        self.axes: list[int] | None = None
        self.output = 0
        self.several = "one"  # which small surfaces stand beside the large one
        self._fine = Postponed(FINE, self._show_several)  # until they are fine again
        self.compared: str | None = None
        self.sought: dict[str, Any] | None = None  # the rule that a link leads to
        self.findings: list[dict[str, Any]] | None = None
        self._check: Bridge | None = None
        self._checked: Any = None  # what the findings are of
        # Defects of the rules are looked for once the edits rest
        self._checking = Postponed(REST, Latest(self._find_defects).wish)
        self._numbers = itertools.count(1)  # of refusals and of what a link leads to
        # While the page draws one state, those that follow are dropped but for the latest
        self._showing = Latest(self._show_apart)
        self._rested = False  # a change while no browser was connected
        self._sent: Shared | None = None  # the design that stands on the page
        self._name = opened.folder.name(document.path)
        self._everywhere: list[Bridge] = []
        self._exporting = False  # all pictures
        self._sizes: dict[str, Any] = {}  # the buttons that fold and enlarge the pane that says why
        self._size = ""  # which of them is pressed
        found, missing = panels
        self._type_2 = document.design.footprint is not None
        if self._type_2:
            found, missing = [], [_TYPE_2]
        belongs = [getattr(panel, "belongs", None) for panel in found]
        kept = [p for p, suits in zip(found, belongs, strict=True) if suits is None or suits(document.path)]
        self.panels = panels = kept, missing
        self.purpose = document.purpose or purpose_of(document.design.system, panels[0])
        self.history = HistoryTab(self.bench, self._compare_with, self._give)
        self._shown: dict[str, Any] = {}  # the traits as of the last change
        self.bench.on_change(self._renew, later=True)
        self._build()
        self._unlisten = document.listen(self._showing.wish)
        opened.arrive(document, self._show_shell)
        self.client.on_connect(self._connected)
        self.client.on_delete(self._gone)

    # What stands where ----------------------------------------------------------------------------------------

    def _build(self) -> None:
        shown = self._now()
        editor = shown | {"functions": functions_data(), "histograms": None}
        panels, missing = self.panels
        with ui.element("div").classes("shell"):
            for name, text in (("shell-edit", "Skip to the editors"), ("shell-look", "Skip to the views")):
                TextElement(tag="a", text=text).classes("shell-skip").props(f'href="#{name}"')
            with ui.element("header"):
                self.header = self.bench.widget(
                    _STATIC / "header.js", design=shown["design"], shell=self._shell(), keys=SHORTCUTS
                )
                self.header.on_message(self._asked)
                self._module(_STATIC / "tour.js", shown | {"example": is_example(self.document.path)})
                self.starting = Starting(self.opened, self._tell_header)
                self.bench.on_close(self.starting.stop)
            with ui.element("aside").classes("shell-tree").props('aria-label="System" id="shell-tree"'):
                self._module(_STATIC / "tree.js", shown)
            with ui.element("main"):
                self.surface: Bridge | None = None
                self.surface_place = PagePart(shown=False)
                improving = [panel for panel in panels if getattr(panel, "improves", "")]
                left = [
                    Tab("Memberships", lambda: self._build_terms(editor)),
                    Tab("Rules", self._build_rules),
                    Tab("Check", self._build_check, drawer=True),
                    Tab("History", self.history.build, drawer=True),
                    *(Tab(panel.title, partial(self._build_panel, panel), drawer=True) for panel in improving),
                ]
                views = [
                    Tab(panel.title, partial(self._build_panel, panel), purpose=getattr(panel, "purpose", ""))
                    for panel in panels
                    if panel not in improving
                ]
                # A function is its surface; of a loop or a robot what it does stands first.
                first = [tab for tab in views if tab.purpose not in ("", FUNCTION)]
                surface = Tab("Surface", lambda: self._build_surface(_STATIC / "surface.js"), self.surface_place)
                right = [*first, surface, *(tab for tab in views if tab not in first)]
                self.editors = TabGroup("Edit the design", left, self.bench, "shell-edit")
                with self.editors.after:
                    self._badge = TextElement(tag="button", text="Check").props('type="button"').classes("shell-badge")
                    self._badge.on(
                        "click", lambda: self._open("Check", partial(self._badge.run_method, "focus")), args=[]
                    )
                with ui.element("div").classes("shell-glance"):
                    self.bench.widget(_STATIC / "glance.js")
                self.views = TabGroup("Look and try", right, self.bench, "shell-look", self.purpose)
                self._build_canvas(improving)
                for tabs, group in ((left, self.editors), (right, self.views)):
                    self.bench.lead([tab.title for tab in tabs], group.show)
        self.bench.lead(["Viewer"], lambda _: self._size_why(self._size) if self._size == "hidden" else None)
        self.bench.on_change(self._checking.begin)
        self._checking.begin()
        for sentence in (*self.document.notes, *missing):
            self.bench.notify(sentence)
        if (
            faulty := next((line.key for line in self.document.design.lines if line.source is not None), None)
        ) is not None:
            self._open_rule(faulty)

    def _build_canvas(self, improving: Sequence[Any]) -> None:
        """What stands round the views: what the rule base is for, why it answers as it does, and what improves it."""
        known = purposes_of(self.panels[0])
        with self.views.before:
            self._purposes = self.bench.widget(_STATIC / "purpose.js", purposes=known, purpose=self.purpose)
            self._purposes.on_message(self._chosen)
        with self.views.below:
            with ui.element("section").classes("shell-why").props('aria-label="Why"') as self._why:
                with ui.element("div").classes("shell-why-bar"):
                    TextElement(tag="h2", text="Why")
                    for text, size, label in (("–", "hidden", "Fold why"), ("⤢", "large", "Enlarge why")):
                        button = TextElement(tag="button", text=text).props(f'type="button" aria-label="{label}"')
                        button.props(f'title="{label}" aria-pressed="false"')
                        button.on("click", partial(self._size_why, size), args=[])
                        self._sizes[size] = button
                self._module(_STATIC / "viewer.js", self._now() | {"short": True})
            self._improving = improving
            with ui.element("div").classes("shell-acts"):
                self._improve = self.bench.widget(_STATIC / "improve.js", ways=self._ways())
                self._improve.on_message(self._improved)
                self.bench.widget(_STATIC / "pictures.js", stem=self.document.path.stem)

    def _ways(self) -> list[list[str]]:
        """What improves a rule base of this purpose: the title of a drawer, and by what."""
        suiting = [p for p in self._improving if getattr(p, "purpose", "") in ("", self.purpose)]
        return [[panel.title, panel.improves] for panel in suiting]

    def _size_why(self, size: str) -> None:
        """Fold or enlarge the pane that says why, or give it its usual size again."""
        self._size = "" if self._size == size else size
        for name, button in self._sizes.items():
            button.props["aria-pressed"] = "true" if self._size == name else "false"
            button.update()
        self._why.props["data-size"] = self._size
        self._why.update()

    def _chosen(self, content: Mapping[str, Any]) -> None:
        """Take another purpose; it is remembered as long as the document is open."""
        self.purpose = check_known(content.get("purpose"), purposes_of(self.panels[0]), "purpose", InputError)
        self.document.purpose = self.purpose
        self._purposes.update(purpose=self.purpose)
        self._improve.update(ways=self._ways())
        self.views.fit(self.purpose)

    def _improved(self, content: Mapping[str, Any]) -> None:
        """Open what improves the rule base."""
        self._open(content.get("open"), partial(self._improve.send, {"focus": True}))

    def _open(self, title: Any, closed: Callable[[], Any]) -> None:
        """Open a drawer over the editors, or close it; ``closed`` gives the focus back to what opened it."""
        self.editors.open(check_known(title, self.editors.drawers, "drawer", InputError), closed)

    def _module(self, path: Path, traits: dict[str, Any], more: Callable[[], dict[str, Any]] = dict) -> Bridge:
        bridge = self.bench.widget(path, **traits)
        bridge.on_message(partial(self._heard, bridge))
        self._everywhere.append(bridge)
        # In a hidden tab it is told once, when it is shown again; all in one message, which is drawn once.
        self.bench.on_change(lambda: bridge.update(**self._shown, **more()), later=True)
        return bridge

    def _build_terms(self, traits: dict[str, Any]) -> None:
        self._terms = self._module(_STATIC / "terms.js", traits)

    def _build_rules(self) -> None:
        self._module(_STATIC / "rules.js", self._now() | {"sought": self.sought}, lambda: {"sought": self.sought})

    def _build_check(self) -> None:
        self._check = self._module(_STATIC / "check.js", {"findings": self.findings})

    def _build_surface(self, path: Path) -> None:
        traits = self._now() | {"surface": self._surface(), "several": self._several()}
        self.surface = self._module(path, traits, self._surfaces)

    def _build_panel(self, panel: Any) -> None:
        try:
            panel.build(self.bench)
        except ImportError as error:  # an extra that only the panel needs
            TextElement(tag="p", text=f"{panel.title} cannot be used: {error}")

    # What is shown --------------------------------------------------------------------------------------------

    def _traits(self) -> dict[str, Any]:
        return {
            "design": self._design(),
            "point": list(self.document.design.point),
            "selected": self.selected,
            "compared": self._compared(),
            "viewer": or_none(viewer_data, self.document.design),
        }

    def _design(self) -> Shared:
        """The document as the modules take it, encoded once a revision for all of them and for all tabs."""
        revision, shared = _ENCODED.get(self.document, (None, None))
        if shared is None or revision != self.document.revision:
            shared = Shared("design", document_data(self.document))
            _ENCODED[self.document] = self.document.revision, shared
        return shared

    def _now(self) -> dict[str, Any]:
        return self._traits() | {"problem": None}

    def _known_axes(self) -> tuple[list[int] | None, int]:
        """The surface's axes, as far as the system has them still."""
        system = self.document.design.system
        if self.axes is not None and any(i >= len(system.inputs) for i in self.axes):
            self.axes = None
        if self.output >= len(system.outputs):
            self.output = 0
        return self.axes, self.output

    def _surface(self) -> dict[str, Any] | None:
        return or_none(surface_data, self.document.design, *self._known_axes())

    def _surfaces(self) -> dict[str, Any]:
        """The surface and, coarse until the edits rest, the small ones."""
        points = SMALL_POINTS
        if self.several != "one":
            points = COARSE
            self._fine.begin()
        return {"surface": self._surface(), "several": self._several(points)}

    def _several(self, points: int = SMALL_POINTS) -> dict[str, Any]:
        try:
            return several_data(self.document.design, self.several, *self._known_axes(), points)
        except InputError:
            return {"mode": self.several, "pictures": [], "left_out": 0}

    def _show_several(self) -> None:
        if self.surface is not None and not self.bench.closed:
            self.surface.update(several=self._several())

    def _compared(self) -> dict[str, Any] | None:
        if self.document.compared is None:
            return None
        return compared_data(
            self.document.compared,
            self.compared or self.document.compared.name,
            *self._known_axes(),
            self.document.design.point,
        )

    def _shell(self) -> dict[str, Any]:
        restored, files = self.document.restored, self.opened.folder.files()
        return {
            "file": self.opened.folder.name(self.document.path),
            "files": files,
            "unsaved": self.opened.folder.unsaved(files),
            "compared": self.compared if self.document.compared is not None else None,
            "largest": LARGEST_FILE,
            "writesC": _C_WRITER is not None,
            "unkept": self.document.unkept,
            "unnamed": self._unnamed(),
            "aside": [f"{work.when:%Y-%m-%d %H:%M:%S}" for work in self.document.aside],
            "restored": f"{restored:%Y-%m-%d %H:%M}" if restored is not None else None,
        }

    def _unnamed(self) -> str | None:
        """The name that a new design which nobody has named is offered where it is saved; None: it has one."""
        path, name = self.document.path, self.document.design.system.name
        if path.exists() or re.fullmatch(r"untitled(-\d+)?\.fis", path.name) is None:
            return None
        return f"{name}.fis" if re.fullmatch(r"\w[\w -]{0,60}", name) and name != "untitled" else path.name

    def _show_shell(self) -> None:
        self.header.update(shell=self._shell())

    async def _show_apart(self) -> None:
        """Show it in a task whose errors NiceGUI tells: what comes after them is shown all the same."""
        await asyncio.wait([background_tasks.create(self._show())])

    async def _show(self) -> None:
        """Show what the edits in hand lead to, and wait until the page has drawn it."""
        if self.bench.closed:
            return
        if not self.client.has_socket_connection:
            self._rested = True
            return
        with suppress(TimeoutError):  # the connection was lost, or the page is very slow
            await self.bench.changed()
            if not self.bench.closed:
                await self.client.run_javascript(_DRAWN, timeout=DRAWN_WITHIN)

    def _renew(self) -> None:
        """Take anew what the page's modules are told of the design, and tell the header.

        The panels are those of a system's type: of another one, such as the file now holds, the page is loaded anew.
        """
        if (self.document.design.footprint is not None) != self._type_2:
            self.client.run_javascript("location.reload()")
            return
        self._shown = self._traits()
        if self._sent is not self._shown["design"]:
            self._sent = self._shown["design"]
            self._sent.send(self.client)
        self.header.update(design=self._sent)
        name = self.opened.folder.name(self.document.path)
        if name != self._name:
            self._name = name
            self.header.update(shell=self._shell())
            self.header.send({"moved": name})

    async def _find_defects(self) -> None:
        design = self.document.design
        of = (design.system, design.lines)
        if self.bench.closed or of == self._checked:
            return
        self._checked = of
        try:
            # Not here, where whoever drags would wait for it; a few in the process that reads files, which is there.
            if len(design.lines) <= _FEW:
                findings = await self.bench.read(self._name, findings_data, design)
            else:
                findings = await self.bench.background(findings_data, design)
        except (InputError, WorkError) as error:
            findings = [{"severity": "error", "sentence": f"The rules could not be checked: {error}", "places": []}]
        if self.bench.closed or of != (self.document.design.system, self.document.design.lines):
            return  # another design is checked once the edits rest
        self.findings = findings
        wrong = sum(finding["severity"] != "note" for finding in findings)
        self._badge.set_text(f"Check {wrong}" if wrong else "Check ✓")
        if self._check is not None:
            self._check.update(findings=findings)

    def _show_shared(self) -> None:
        self._terms.update(histograms=self.bench.shared.get("histograms"))

    def _show_surface(self) -> None:
        if self.surface is not None:
            self.surface.update(surface=self._surface(), several=self._several())

    def _connected(self) -> None:
        if self._rested:
            self._rested = False
            self._showing.wish()

    async def _gone(self) -> None:
        self._unlisten()
        self.opened.leave(self.document, self._show_shell)
        await self.bench.close()

    def _say(self, sentence: str, problem: bool) -> None:
        self.header.send({"say": sentence, "problem": problem})

    def _tell_header(self, content: dict[str, Any]) -> None:
        if not self.bench.closed:
            self.header.send(content)

    # What the modules send ------------------------------------------------------------------------------------

    def _heard(self, bridge: Bridge, content: Any) -> None:
        """An edit or a look; what is wrong with it becomes a sentence beside the module that sent it."""
        try:
            look = act_of(self, content.get("look") if isinstance(content, Mapping) else None, "_look_")
            if look is not None:
                look(content)
            else:
                before = self.document.design
                self.document.apply(content)
                if (sentence := broken(before, self.document.design, content)) is not None:
                    self.header.send({"say": sentence, "undo": self.document.can_undo})
        except InputError as error:
            bridge.update(problem=refusal_data(error, content, next(self._numbers)))
        else:
            bridge.update(problem=None)

    def _look_rule(self, content: Mapping[str, Any]) -> None:
        self._open_rule(content.get("key"))

    def _open_rule(self, key: Any) -> None:
        self.sought = {"key": key, "number": next(self._numbers)}
        self.editors.show("Rules")
        self._showing.wish()

    def _look_surface(self, content: Mapping[str, Any]) -> None:
        system = self.document.design.system
        inputs, output = content.get("inputs"), content.get("output")
        if not isinstance(inputs, list) or not isinstance(output, int) or any(type(i) is not int for i in inputs):
            raise InputError("a surface has one or two inputs and one output, each by its number")
        if not 0 < len(set(inputs)) == len(inputs) <= 2:
            raise InputError("a surface has one input or two different ones")
        if not all(0 <= i < len(system.inputs) for i in inputs) or not 0 <= output < len(system.outputs):
            raise InputError("the surface's inputs and output must be among the system's")
        self.axes, self.output = inputs, output
        self._show_surface()
        if self.document.compared is not None:
            self._showing.wish()

    def _look_several(self, content: Mapping[str, Any]) -> None:
        mode = content.get("mode")
        if mode not in ("one", "outputs", "pairs"):
            raise InputError("the surfaces shown are 'one', of all 'outputs', or of all 'pairs' of inputs")
        self.several = mode
        self._show_several()

    def _look_select(self, content: Mapping[str, Any]) -> None:
        kind, variable, term = (content.get(name) for name in ("kind", "variable", "term"))
        if kind not in ("input", "output") or not isinstance(variable, str) or not isinstance(term, (str, type(None))):
            raise InputError("a selection names its kind, 'input' or 'output', and its variable")
        self.selected = {"kind": kind, "variable": variable, "term": term}
        if content.get("show") is True:  # and the focus goes to its name
            self.selected["show"] = next(self._numbers)
            self.editors.show("Memberships")
        self._shown = self._shown | {"selected": self.selected}  # what hidden tabs are told when they are shown
        for bridge in self._everywhere:
            bridge.update(selected=self.selected)

    # What the header asks for ---------------------------------------------------------------------------------

    async def _asked(self, content: Any) -> None:
        what = content.get("do") if isinstance(content, Mapping) else None
        act = act_of(self, what) or act_of(self.starting, what)
        if act is None:
            raise InputError(f"the page asked for {str(what)[:40]!r}")
        try:
            result = act(content)
            if result is not None:
                await result
        except InputError as error:
            if what != "save_as":
                raise
            self.header.send({"refused": str(error)})
        except OSError as error:
            if what == "save_as":
                self.header.send({"refused": f"The file cannot be written: {error.strerror or error}."})
                return
            raise InputError(f"{what}: {error.strerror or error}") from None
        except WorkError as error:
            raise InputError(f"{what}: {error}") from None

    def _do_undo(self, content: Mapping[str, Any]) -> None:
        self.document.apply({"do": content["do"]})

    _do_redo = _do_undo

    def _do_save(self, content: Mapping[str, Any]) -> None:
        name = content.get("name")
        if name is not None and not isinstance(name, str):
            raise InputError("save as: the name must be a text")
        try:
            self.opened.save(self.document, name, overwrite=content.get("overwrite") is True)
        except OverwriteError as error:
            again = {"do": content["do"], "name": name, "overwrite": True}
            self.header.send({"ask": f"{error}.", "accept": "Overwrite", "then": again})
            return
        self.header.update(shell=self._shell())
        self.header.send({"saved": True})
        self.bench.notify(f"the design is saved in {self.document.path.name}")
        if lacks := beyond_matlab(self.document.design.written):
            self.bench.notify(lacks)

    _do_save_as = _do_save

    def _do_download(self, content: Mapping[str, Any]) -> None:
        self._give(self.document.text(), self.document.path.name)

    def _give(self, text: str, name: str) -> None:
        self.client.download(text.encode(), name, "text/plain")

    def _do_snapshot(self, content: Mapping[str, Any]) -> None:
        self.bench.notify(f"the snapshot “{self.history.take()}” is kept; History lists all")

    def _do_history(self, content: Mapping[str, Any]) -> None:
        self._open("History", partial(self.header.send, {"focus": "history"}))

    async def _do_export(self, content: Mapping[str, Any]) -> None:
        kind, ending = check_figure(content.get("kind"), content.get("format"))
        design = self.document.design
        if kind == ALL_FIGURES:
            await self._export_all(design, ending)
            return
        axes, output = self._known_axes()
        axes = list(range(min(2, len(design.system.inputs)))) if axes is None else axes
        data = await self.bench.background(figure_bytes, design.shown, kind, ending, design.point, axes, output)
        if not self.bench.closed:
            name = f"{self.document.path.stem}-{kind}.{ending}"
            self.client.download(data, name)
            self.bench.notify(f"{name} is drawn")

    async def _do_c_code(self, content: Mapping[str, Any]) -> None:
        """The design in force as a header and a source of C, in a zip."""
        number, table = content.get("number"), content.get("table")
        if not isinstance(number, str) or not (table is None or (isinstance(table, int) and 2 <= table <= 256)):
            raise InputError("C code: a type of numbers, and 2 to 256 points an input or none")
        system, stem = self.document.design.shown, self.document.path.stem
        if not isinstance(system, Sugeno):
            raise InputError(f"`fuzzy export c {self.document.path.name}` writes a type-2 system, once it is saved")
        if _C_WRITER is None:
            raise InputError("C code needs a plug-in that writes it, fuzzy.plugins.ccode, which is not installed")
        data = await self.bench.background(_C_WRITER.load(), system, stem, number, table)
        if not self.bench.closed:
            self.client.download(data, f"{stem}-c.zip")
            self.bench.notify(f"{stem}-c.zip is written; `fuzzy export c {self.document.path.name} --verify` proves it")

    async def _export_all(self, design: Design, ending: str) -> None:
        """All pictures as one zip; the page tells how far it is, at most once a second, and can stop it."""
        if design.footprint is not None:
            raise InputError("of a type-2 system pictures are drawn one by one: its memberships and its surface")
        if self._exporting:
            raise InputError("all pictures are being drawn already; wait for them, or stop that")
        name, last = f"{self.document.path.stem}-figures.zip", 0.0

        def told(done: int, total: int) -> bool:
            nonlocal last
            if time.monotonic() - last > 1.0 and self._exporting:
                last = time.monotonic()
                self.header.send({"say": f"{done} of {total} pictures are drawn …", "stop": True})
            return self._exporting and not self.bench.closed

        self._exporting = True
        try:
            chosen = {"file": self.document.path.stem, **self.bench.pictured}
            data = await all_figures(self.bench.background, design.in_force, ending, design.point, told, chosen)
        finally:
            self._exporting = False
        if data is None:
            self.bench.notify("no more pictures are drawn")
        elif not self.bench.closed:
            self.client.download(data, name)
            self.bench.notify(f"{name} is drawn; README.txt in it says which picture shows what")

    def _do_stop(self, content: Mapping[str, Any]) -> None:
        self._exporting = False

    async def _do_compare(self, content: Mapping[str, Any]) -> None:
        name = content.get("name")
        if name is None:
            self._compare_with(None, None)
            return
        read = await self.opened.read(name if isinstance(name, str) else "")
        if self.bench.closed:
            return
        self._compare_with(name, read.system)
        if read.changes:
            self.bench.notify(f"{name} is a Mamdani system; compared is the Sugeno system that comes near it")

    def _compare_with(self, name: str | None, system: Sugeno | Type2Sugeno | None) -> None:
        self.compared = name
        self.document.compare(system)
        self.header.update(shell=self._shell())

    def _do_choose(self, content: Mapping[str, Any]) -> None:
        """Choose between the file and unsaved work that is older than it, or look at both."""
        if content.get("which") == "compare" and self.document.aside:
            work = self.document.aside[0]
            self._compare_with(f"unsaved work of {work.when:%Y-%m-%d %H:%M:%S}", work.design.shown)
            return
        self.document.choose(content.get("which"))
        self._show_shell()

    async def _do_discard(self, content: Mapping[str, Any]) -> None:
        document = self.document
        read = await self.opened.content(document.path, document.path.name)
        if read.digest != digest_of(document.path):  # it was saved meanwhile
            read = await self.opened.content(document.path, document.path.name)
        if read.text is not None and read.text.changes:
            raise InputError(f"{document.path.name} holds a Mamdani system now; open it from the menu")
        document.discard(read)
        self.header.update(shell=self._shell())
        self.bench.notify("the saved file is shown again; undo brings the changes back")
