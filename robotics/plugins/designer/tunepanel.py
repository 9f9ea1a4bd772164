"""The designer's panel "Tune": the rule base under design, tuned through the closed loop in another process.

While it is searched, the design is the best so far: all that has been put there is one edit, so that a single undo
leads back. Whoever edits by hand meanwhile ends the search.
"""

import asyncio
import time
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from fuzzy.errors import InputError
from fuzzy.files.fisfile import format_fis, parse_fis
from fuzzy.plugins.designer.autosave import PROCESS
from fuzzy.plugins.designer.longtask import TaskSession
from fuzzy.plugins.designer.panel import SessionPanel
from fuzzy.plugins.designer.workers import WorkError
from fuzzy.system import Sugeno
from fuzzy.tuning.parameter import TuningError
from robotics.plugins.designer import tryout, tunetask
from robotics.plugins.designer.folderfiles import FolderOffers, read_text_file
from robotics.plugins.designer.tunetask import TuneTask

_MODULE = Path(__file__).parent / "static" / "tuning.js"
_BEFORE = "before tuning"
_LOOKING = "the laws and scenarios that suit this rule base are looked for …"
_HELD: set[Path] = set()  # searches that run in this process, whichever page began them


class TuneSession(TaskSession):
    """The tuning of one page: what it has chosen, and the process that searches. Messages come one at a time.

    Beside those of a TaskSession, its states are "searching" and, once it compares on other seeds, "testing".
    """

    error = TuningError
    called = "search"

    def __init__(self, bench: Any) -> None:
        super().__init__(
            bench,
            law="", move=["memberships", "consequents"], still=[], symmetric=True, scenarios=[], noise=True, terms=[],
            runs=20, evaluations=500, engine="cmaes", seed=1,
        )  # fmt: skip
        self.offers = FolderOffers(self.folder, bench.read)
        self.kind = ""  # of the scenarios for which scenarios and cost were chosen
        self.offer: dict[str, Any] = {"laws": [], "symmetric": False, "variables": [], "why": _LOOKING}
        self.packaged: list[dict[str, str]] = []  # the package's scenarios: name, title, kind
        self.own: list[str] = []  # the folder's
        self.task: TuneTask | None = None
        self.base: Sugeno | None = None  # the design when the search began
        self.preview: Sugeno | None = None  # what was put into the design last, and neither kept nor discarded
        self.putting = False
        self.gesture = ""
        self.begun = 0.0
        self.told: dict[str, Any] = {}
        self.words = ""
        self.put(
            _MODULE,
            accepted=tunetask.OFFERED_CHOICES,
            choice=self.choice,
            offer=self.offer,
            scenarios=[],
            metrics=[],
            progress=self._progress(),
            courses=[],
            before=[],
            after=[],
            left=self._left(),
        )
        self.unlisten = bench.document.listen(self._edited)
        self.asking = asyncio.get_running_loop().create_task(self._ask())

    # What there is to choose

    async def _ask(self) -> None:
        with suppress(WorkError):
            self.packaged = (await self.bench.background(tryout.choices))["scenarios"]
            self.widget.update(metrics=tunetask.metrics())
        await self.offers.look()
        self.own = self.offers.found(self.bench.document.path)["scenarios"]
        await self.changed()

    async def changed(self) -> None:
        """Look at what the present system may be tuned in."""
        if self.runs:
            return
        try:
            self.offer = await self.bench.background(tunetask.offered, self.present, self.bench.document.path.name)
        except (InputError, WorkError) as error:
            self.offer = {"laws": [], "symmetric": False, "variables": [], "why": str(error)}
        self._settle()
        self._show_form()

    def _settle(self) -> None:
        """Choose a law, and what suits it, where what is chosen does not."""
        uses = {self._key(use): use for use in self.offer["laws"]}
        if not uses:
            return
        law = self.choice["law"] if self.choice["law"] in uses else next(iter(uses))
        kind = uses[law]["kinds"][0]
        self.choice = {**self.choice, "law": law}
        if kind != self.kind:
            self.kind = kind
            self.choice |= {"scenarios": uses[law]["scenarios"][:2], "terms": tunetask.terms_of(kind)}

    def _key(self, use: dict[str, Any]) -> str:
        return f"{use['law']}/{use['task']}"

    def _show_form(self) -> None:
        offered_now = [[name, name] for name in self.own]
        offered_now += [[one["name"], one["title"]] for one in self.packaged if one["kind"] == self.kind]
        self.widget.update(offer=self.offer, choice=self.choice, scenarios=offered_now, left=self._left())

    # Messages

    def _do_choose(self, message: dict[str, Any]) -> None:
        name, value = self.setting(message)
        self.choice = {**self.choice, name: value}
        if name == "law":
            self._settle()
        self._show_form()
        tunetask.checked(self.choice)

    async def _do_start(self, _: dict[str, Any]) -> None:
        self._idle()
        tunetask.checked(self.choice)
        present = self.present
        if not present.rules:
            raise TuningError(f"{present.name} has no rule in force: there is nothing to tune")
        if not self.offer["laws"]:
            raise TuningError(self.offer.get("why", "the panel is not ready yet"))
        use = {self._key(use): use for use in self.offer["laws"]}[self.choice["law"]]
        place = self._place()
        texts: dict[str, str | None] = dict.fromkeys(self.choice["scenarios"])
        for name in [name for name in texts if name in self.own]:
            texts[name] = (await self.bench.read(name, read_text_file, self.folder, name)).text
        task = TuneTask(
            **self.choice
            | {name: tuple(self.choice[name]) for name in ("move", "still")}
            | {"law": use["law"], "task": use["task"], "scenarios": tuple(texts.items())}
            | {"terms": tuple((name, float(scale), float(weight)) for name, scale, weight in self.choice["terms"])}
            | {"system": format_fis(present), "folder": str(self.folder.path), "place": str(place)}
        )
        self._idle()
        tunetask.write_task(task)
        await self._run(task)

    async def _do_go_on(self, _: dict[str, Any]) -> None:
        self._idle()
        left = tunetask.found_at(self._place(), self.folder.path)
        if left is None:
            raise TuningError("there is no search to go on with")
        await self._run(left["task"])

    async def _run(self, task: TuneTask) -> None:
        _HELD.add(Path(task.place))
        self.task, self.told, self.words = task, {}, ""
        self.bench.document.judged = task.terms
        self.base, self.preview = self.present, None
        self.begun, self.gesture = time.monotonic(), f"tune {PROCESS} {time.monotonic_ns()}"
        self.widget.update(courses=[], before=[], after=[], left=None)
        await self.start(task, tunetask.search_best)

    def stop_soon(self) -> None:
        """Ask the search to end; what compares on other seeds goes on to its end."""
        before = self.state
        super().stop_soon()
        if before == "testing":
            self.state = before

    def _do_keep(self, _: dict[str, Any]) -> None:
        """The best is in the design already: no longer is it on trial."""
        self._idle()
        if self.preview is None:
            raise TuningError("there is no tuned system to keep")
        self._end("The best is kept in the design: Undo takes it out again, and saving writes it to the file.")

    def _do_discard(self, _: dict[str, Any]) -> None:
        """Back to what it began with: by undoing the one edit, where that is the last one."""
        self._idle()
        if self.preview is None or self.task is None:
            raise TuningError("there is no tuned system to discard")
        self.putting = True
        try:
            document = self.bench.document
            if document.can_undo == self._name():
                document.undo()
            before = replace(self.task.begun(), name=self.present.name)
            if self.present != before:  # of a search that went on, the best of earlier stood there
                self._put(before, "discard what was tuned")
        finally:
            self.putting = False
        self.widget.update(after=[])
        self._end("The design is as it was before the search.")

    def _end(self, words: str) -> None:
        """Have the best on trial no longer, and say with what end."""
        self.preview = None
        if self._compares:
            self.bench.document.compare(None)
        self._forget(words)

    def _forget(self, words: str) -> None:
        tunetask.forget(self._place())
        self.words = words
        self.tell()

    def _do_compare(self, message: dict[str, Any]) -> None:
        """Show what it began with beside the best in the editors, or no longer."""
        if self.task is None:
            raise TuningError("there is nothing yet to compare with")
        self.bench.document.compare(replace(self.task.begun(), name=_BEFORE) if message.get("value") is True else None)
        self.tell()

    @property
    def _compares(self) -> bool:
        return getattr(self.bench.document.compared, "name", "") == _BEFORE

    def _do_take(self, _: dict[str, Any]) -> None:
        """The best of a search that was stopped, as one edit."""
        self._idle()
        left = tunetask.found_at(self._place(), self.folder.path)
        if left is None or left["best"] is None:
            raise TuningError("there is no search to take the best of")
        self._put(parse_fis(left["best"]["system"]), f"tune ({left['task'].engine})")
        self._forget(f"The best of {left['best']['evaluations']} evaluations is in the design.")

    def _do_forget(self, _: dict[str, Any]) -> None:
        self._idle()
        self._forget(self.words)

    def _idle(self) -> None:
        self.check_idle()
        if self._place() in _HELD:
            raise TuningError("a search for this design runs in another tab; stop it there first")

    # The search

    def note(self, what: str, about: Any) -> None:
        """Take a piece of news of the search."""
        super().note(what, about)
        if what == "start":
            self.state = "searching" if self.state == "starting" else self.state
            self.told["parameters"] = about["parameters"]
            self.widget.update(courses=about["courses"], before=about["paths"])
        elif what == "search":
            self.told |= {name: about[name] for name in ("evaluations", "curve")}
            if "candidate" in about:
                self._show(about["candidate"])
        elif what == "testing":
            self.state = "testing" if self.state != "idle" else self.state
        elif what == "done":
            self.told |= about

    async def settle(self) -> None:
        """Look at what the design may be tuned in, once its search has ended."""
        await self.changed()

    def _show(self, candidate: dict[str, Any]) -> None:
        """Put the best so far into the design, unless somebody edits it by hand meanwhile."""
        self.widget.update(after=candidate["paths"])
        self.told["gains"] = candidate["gains"]
        if self.words or self.task is None:  # edited by hand
            return
        self._put(parse_fis(candidate["system"]), self._name(), self.gesture)
        self.preview = self.present

    def _name(self) -> str:
        return f"tune ({self.task.engine})" if self.task is not None else "tune"

    def _put(self, system: Sugeno, what: str, gesture: str | None = None) -> None:
        name, self.putting = self.present.name, True
        try:
            self.bench.document.replace(replace(system, name=name), what, keep_disabled=True, gesture=gesture)
        finally:
            self.putting = False

    def _edited(self) -> None:
        """End the search where the design was edited by hand: nobody's edit is overwritten."""
        if self.putting or self.task is None:
            return
        if self.runs and not self.words:
            if self.present == (self.base if self.preview is None else self.preview):
                return  # only another look at it
            self.words = (
                "The design was edited while the search ran: the search has stopped, and the edit stands. Undo leads "
                "back; the best that was found can still be taken."
            )
            self.preview = None
            self.stop_soon()
            self.state = "stopping"
            self.tell()
        elif self.preview is not None and self.present != self.preview:
            self.preview = None
            self.words = "The design was edited; the best that was found can still be taken."
            self.tell()

    def ended(self) -> None:
        """Note that no search runs any more, so that another one may."""
        if self.task is not None:
            _HELD.discard(Path(self.task.place))
        super().ended()

    def close(self) -> None:
        """End the search that runs, because its page is closed; what it found stays in its folder."""
        self.unlisten()
        if self.task is not None and self.runs:
            _HELD.discard(Path(self.task.place))
        super().close()
        self.state = "idle"

    # What the page sees

    def _place(self) -> Path:
        place = tunetask.place_of(self.bench.document.path)
        if not place.resolve().is_relative_to(self.folder.path):
            raise TuningError(f"{place} leads out of the opened folder: nothing can be kept there")
        return place

    def tell(self) -> None:
        """Show the page how the search goes, and what is left of an earlier one."""
        self.widget.update(progress=self._progress(), left=self._left())

    def _left(self) -> dict[str, Any] | None:
        """A search that was stopped, and is neither kept nor discarded."""
        try:
            place = self._place()
        except TuningError:
            return None
        if self.runs or self.preview is not None or place in _HELD:
            return None
        left = tunetask.found_at(place, self.folder.path)
        if left is None or left["best"] is None:
            return None
        about = {name: left["best"][name] for name in ("evaluations", "cost", "before")}
        return about | {"of": left["task"].evaluations, "scenarios": [name for name, _ in left["task"].scenarios]}

    def _progress(self) -> dict[str, Any]:
        seconds = time.monotonic() - self.begun if self.runs else self.told.get("seconds", 0.0)
        self.told["seconds"] = seconds
        budget = self.task.evaluations if self.task is not None else self.choice["evaluations"]
        told = {name: self.told.get(name) for name in ("parameters", "evaluations", "curve", "sentence", "stopped")}
        gains = self.told.get("gains") or {}
        return told | {
            "state": self.state,
            "of": budget,
            "seconds": round(seconds) if self.runs else round(seconds, 1),
            "words": self.words,
            "undecided": self.preview is not None,
            "compares": self._compares,
            "gains": ", ".join(f"{name} {value:.4g}" for name, value in gains.items()),
        }


panel = SessionPanel("Tune", 70, TuneSession, purpose="robot", improves="through the loop")
