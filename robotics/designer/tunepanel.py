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

from anfis.designer.task import TrainingProcess
from fuzzy.designer.autosave import PROCESS
from fuzzy.designer.folder import open_folder
from fuzzy.designer.wishes import Wishes, refusal_at
from fuzzy.designer.workers import WorkError
from fuzzy.errors import InputError
from fuzzy.files.fisfile import format_fis, parse_fis
from fuzzy.naming import expected
from fuzzy.system import Sugeno
from fuzzy.tuning.parameter import TuningError
from robotics.designer.folderfiles import FolderOffers, read_text_file
from robotics.designer.tunetask import (
    ENGINES,
    MOST_EVALUATIONS,
    MOST_RUNS,
    TuneTask,
    checked,
    forget,
    found_at,
    metrics,
    offered,
    place_of,
    search_best,
    terms_of,
    write_task,
)
from robotics.scenario.reading import load_scenario, scenario_names
from robotics.tuning.space import PARTS

MODULE = Path(__file__).parent / "static" / "tuning.js"
_EVERY = 0.1  # s between looks at the search
_BEFORE = "before tuning"
_HELD: set[Path] = set()  # searches that run in this process, whichever page began them


class TunePanel:
    """The panel "Tune" as the designer finds it, by an entry point."""

    title = "Tune"
    order = 70

    def build(self, bench: Any) -> None:
        """Put the panel on the page of ``bench``, a fuzzy.designer.panel.Workbench."""
        TuneSession(bench)


panel = TunePanel()


class TuneSession:
    """The tuning of one page: what it has chosen, and the process that searches. Messages come one at a time."""

    def __init__(self, bench: Any) -> None:
        self.bench = bench
        self.folder = open_folder(bench.document.folder)
        self.offers = FolderOffers(self.folder, bench.read)
        self.choice: dict[str, Any] = {
            "law": "", "move": ["memberships", "consequents"], "still": [], "symmetric": True, "scenarios": [],
            "noise": True, "terms": [], "runs": 20, "evaluations": 500, "engine": "cmaes", "seed": 1,
        }  # fmt: skip
        self.kind = ""  # of the scenarios for which scenarios and cost were chosen
        self.offer: dict[str, Any] = {"laws": [], "symmetric": False, "variables": []}
        self.kinds: dict[str, list[list[str]]] = {}  # the package's scenarios: [name, title], by their kind
        self.own: list[str] = []  # the folder's
        self.state = "idle"  # "starting", "searching", "stopping", "testing", "done"
        self.process: TrainingProcess | None = None
        self.task: TuneTask | None = None
        self.base: Sugeno | None = None  # the design when the search began
        self.preview: Sugeno | None = None  # what was put into the design last, and neither kept nor discarded
        self.putting = False
        self.gesture = ""
        self.begun = 0.0
        self.told: dict[str, Any] = {}
        self.words = ""
        self.watching: asyncio.Task[None] | None = None
        self.widget = bench.widget(
            MODULE,
            accepted={"engine": list(ENGINES), "runs": MOST_RUNS, "evaluations": MOST_EVALUATIONS, "move": list(PARTS)},
            choice=self.choice,
            offer=self.offer,
            scenarios=[],
            metrics=[],
            progress=self._progress(),
            courses=[],
            before=[],
            after=[],
            left=self._left(),
            problem=None,
        )
        self.wishes = Wishes(
            {
                "choose": self._choose,
                "start": self._start,
                "go on": self._go_on,
                "stop": self._stop,
                "keep": self._keep,
                "discard": self._discard,
                "compare": self._compare,
                "take": self._take,
                "forget": self._forget,
            },
            lambda error, _: self.widget.update(problem=refusal_at(error)),
            TuningError,
            lambda: self.widget.update(problem=None),
        )
        self.widget.on_message(self.wishes.heard)
        bench.on_change(self._look)
        bench.on_close(self.close)
        self.unlisten = bench.document.listen(self._edited)
        self.asking = asyncio.get_running_loop().create_task(self._ask())

    # What there is to choose

    async def _ask(self) -> None:
        with suppress(WorkError):
            self.kinds = await self.bench.background(scenarios_by_kind)
            self.widget.update(metrics=metrics())
        await self.offers.look()
        self.own = self.offers.found(self.bench.document.path)["scenarios"]
        await self._look()

    async def _look(self) -> None:
        """Look at what the present system may be tuned in."""
        if self._runs:
            return
        try:
            self.offer = await self.bench.background(offered, self._present(), self.bench.document.path.name)
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
            self.choice |= {"scenarios": uses[law]["scenarios"][:2], "terms": terms_of(kind)}

    def _key(self, use: dict[str, Any]) -> str:
        return f"{use['law']}/{use['task']}"

    def _show_form(self) -> None:
        offered_now = [*([name, name] for name in self.own), *self.kinds.get(self.kind, [])]
        self.widget.update(offer=self.offer, choice=self.choice, scenarios=offered_now, left=self._left())

    # Messages

    def _choose(self, message: dict[str, Any]) -> None:
        name = message.get("name")
        if not isinstance(name, str) or name not in self.choice:
            raise TuningError(expected(str(name), self.choice, "setting"))
        self.choice = {**self.choice, name: message.get("value")}
        if name == "law":
            self._settle()
        self._show_form()
        checked(self.choice)

    async def _start(self, _: dict[str, Any]) -> None:
        self._idle()
        checked(self.choice)
        present = self._present()
        if not present.rules:
            raise TuningError(f"{present.name} has no rule in force: there is nothing to tune")
        if not self.offer["laws"]:
            raise TuningError(self.offer.get("why", "the panel is not ready yet"))
        use = {self._key(use): use for use in self.offer["laws"]}[self.choice["law"]]
        place = self._place()
        scenarios = []
        for name in self.choice["scenarios"]:
            text = (await self.bench.read(name, read_text_file, self.folder, name)).text if name in self.own else None
            scenarios.append((name, text))
        settings: dict[str, Any] = {name: tuple(self.choice[name]) for name in ("move", "still")}
        settings |= {
            name: self.choice[name] for name in ("symmetric", "noise", "runs", "evaluations", "engine", "seed")
        }
        task = TuneTask(
            system=format_fis(present),
            law=use["law"],
            task=use["task"],
            scenarios=tuple(scenarios),
            terms=tuple((name, float(scale), float(weight)) for name, scale, weight in self.choice["terms"]),
            folder=str(self.folder.path),
            place=str(place),
            **settings,
        )
        self._idle()
        write_task(task)
        await self._run(task)

    async def _go_on(self, _: dict[str, Any]) -> None:
        self._idle()
        left = found_at(self._place(), self.folder.path)
        if left is None:
            raise TuningError("there is no search to go on with")
        await self._run(left["task"])

    async def _run(self, task: TuneTask) -> None:
        place = Path(task.place)
        _HELD.add(place)
        self.task, self.state, self.told, self.words = task, "starting", {}, ""
        self.base, self.preview = self._present(), None
        self.begun, self.gesture = time.monotonic(), f"tune {PROCESS} {time.monotonic_ns()}"
        self.widget.update(courses=[], before=[], after=[], left=None)
        self._tell()
        try:
            process = await asyncio.to_thread(TrainingProcess, task, search_best, "search")
        except BaseException:
            self._ended("idle")
            raise
        if self.bench.closed:
            process.close()
            self._ended("idle")
            return
        self.process = process
        if self.state == "stopping":
            process.stop()
        self.watching = asyncio.get_running_loop().create_task(self._watch(process))

    def _stop(self, _: dict[str, Any]) -> None:
        if not self._runs:
            raise TuningError("no search runs")
        if self.process is not None:
            self.process.stop()
        if self.state != "testing":
            self.state = "stopping"
        self._tell()

    def _keep(self, _: dict[str, Any]) -> None:
        """The best is in the design already: no longer is it on trial."""
        self._idle()
        if self.preview is None:
            raise TuningError("there is no tuned system to keep")
        self.preview = None
        self._uncompare()
        forget(self._place())
        self.words = "The best is kept in the design: Undo takes it out again, and saving writes it to the file."
        self._tell()

    def _discard(self, _: dict[str, Any]) -> None:
        """Back to what it began with: by undoing the one edit, where that is the last one."""
        self._idle()
        if self.preview is None or self.task is None:
            raise TuningError("there is no tuned system to discard")
        self.putting = True
        try:
            document = self.bench.document
            if document.can_undo == self._name():
                document.undo()
            before = replace(self.task.begun(), name=self._present().name)
            if self._present() != before:  # of a search that went on, the best of earlier stood there
                self._put(before, "discard what was tuned")
        finally:
            self.putting = False
        self.preview = None
        self._uncompare()
        forget(self._place())
        self.words = "The design is as it was before the search."
        self.widget.update(after=[])
        self._tell()

    def _compare(self, message: dict[str, Any]) -> None:
        """Show what it began with beside the best in the editors, or no longer."""
        if self.task is None:
            raise TuningError("there is nothing yet to compare with")
        self.bench.document.compare(replace(self.task.begun(), name=_BEFORE) if message.get("value") is True else None)
        self._tell()

    def _uncompare(self) -> None:
        if self._compares:
            self.bench.document.compare(None)

    @property
    def _compares(self) -> bool:
        compared = self.bench.document.compared
        return compared is not None and compared.name == _BEFORE

    def _take(self, _: dict[str, Any]) -> None:
        """The best of a search that was stopped, as one edit."""
        self._idle()
        left = found_at(self._place(), self.folder.path)
        if left is None or left["best"] is None:
            raise TuningError("there is no search to take the best of")
        self._put(parse_fis(left["best"]["system"]), f"tune ({left['task'].engine})")
        forget(self._place())
        self.words = f"The best of {left['best']['evaluations']} evaluations is in the design."
        self._tell()

    def _forget(self, _: dict[str, Any]) -> None:
        self._idle()
        forget(self._place())
        self._tell()

    def _idle(self) -> None:
        if self._runs:
            raise TuningError("a search runs already; stop it first")
        if self._place() in _HELD:
            raise TuningError("a search for this design runs in another tab; stop it there first")

    # The search

    async def _watch(self, process: TrainingProcess) -> None:
        while process.alive:
            await asyncio.sleep(_EVERY)
            news = process.news()
            for what, about in news:
                try:
                    self._note(what, about)
                except InputError as error:
                    self.widget.update(problem={"message": str(error), "field": None})
            if self._runs and self.process is process:
                self._tell()
        if self.process is process:
            self._ended(self.state if self.state in ("done", "idle") else "idle")
            await asyncio.to_thread(process.close)
            await self._look()

    def _note(self, what: str, about: Any) -> None:
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
        elif what == "problem":
            message, field = about if isinstance(about, tuple) else (about, None)
            self.state = "idle"
            self.widget.update(problem={"message": message, "field": field})
        elif what == "done":
            self.state = "done"
            self.told |= about

    def _show(self, candidate: dict[str, Any]) -> None:
        """Put the best so far into the design, unless somebody edits it by hand meanwhile."""
        self.widget.update(after=candidate["paths"])
        self.told["gains"] = candidate["gains"]
        if self.words or self.task is None:  # edited by hand
            return
        system = parse_fis(candidate["system"])
        self._put(system, self._name(), self.gesture)
        self.preview = self._present()

    def _name(self) -> str:
        return f"tune ({self.task.engine})" if self.task is not None else "tune"

    def _put(self, system: Sugeno, what: str, gesture: str | None = None) -> None:
        name, self.putting = self._present().name, True
        try:
            self.bench.document.replace(replace(system, name=name), what, keep_disabled=True, gesture=gesture)
        finally:
            self.putting = False

    def _edited(self) -> None:
        """End the search where the design was edited by hand: nobody's edit is overwritten."""
        if self.putting or self.task is None:
            return
        if self._runs and not self.words:
            if self._present() == (self.base if self.preview is None else self.preview):
                return  # only another look at it
            self.words = (
                "The design was edited while the search ran: the search has stopped, and the edit stands. Undo leads "
                "back; the best that was found can still be taken."
            )
            self.preview = None
            if self.process is not None:
                self.process.stop()
            self.state = "stopping"
            self._tell()
        elif self.preview is not None and self._present() != self.preview:
            self.preview = None
            self.words = "The design was edited; the best that was found can still be taken."
            self._tell()

    def _ended(self, state: str) -> None:
        self.process, self.state = None, state
        if self.task is not None:
            _HELD.discard(Path(self.task.place))
        self._tell()

    def close(self) -> None:
        """End the search that runs, because its page is closed; what it found stays in its folder."""
        self.unlisten()
        process, self.process = self.process, None
        if process is not None:
            process.close()
        if self.task is not None and self._runs:
            _HELD.discard(Path(self.task.place))
        self.state = "idle"

    # What the page sees

    @property
    def _runs(self) -> bool:
        return self.state in ("starting", "searching", "stopping", "testing")

    def _place(self) -> Path:
        place = place_of(self.bench.document.path)
        if not place.resolve().is_relative_to(self.folder.path):
            raise TuningError(f"{place} leads out of the opened folder: nothing can be kept there")
        return place

    def _present(self) -> Sugeno:
        fis: Sugeno = self.bench.document.design.in_force
        return fis

    def _tell(self) -> None:
        self.widget.update(progress=self._progress(), left=self._left())

    def _left(self) -> dict[str, Any] | None:
        """A search that was stopped, and is neither kept nor discarded."""
        try:
            place = self._place()
        except TuningError:
            return None
        if self._runs or self.preview is not None or place in _HELD:
            return None
        left = found_at(place, self.folder.path)
        if left is None or left["best"] is None:
            return None
        about = {name: left["best"][name] for name in ("evaluations", "cost", "before")}
        return about | {"of": left["task"].evaluations, "scenarios": [name for name, _ in left["task"].scenarios]}

    def _progress(self) -> dict[str, Any]:
        seconds = time.monotonic() - self.begun if self._runs else self.told.get("seconds", 0.0)
        self.told["seconds"] = seconds
        budget = self.task.evaluations if self.task is not None else self.choice["evaluations"]
        told = {name: self.told.get(name) for name in ("parameters", "evaluations", "curve", "sentence", "stopped")}
        gains = self.told.get("gains") or {}
        return told | {
            "state": self.state,
            "of": budget,
            "seconds": round(seconds) if self._runs else round(seconds, 1),
            "words": self.words,
            "undecided": self.preview is not None,
            "compares": self._compares,
            "gains": ", ".join(f"{name} {value:.4g}" for name, value in gains.items()),
        }


def scenarios_by_kind() -> dict[str, list[list[str]]]:
    """The package's scenarios, [name, title] each, by their kind."""
    found: dict[str, list[list[str]]] = {}
    for name in scenario_names():
        scenario = load_scenario(name)
        found.setdefault(scenario.kind, []).append([name, scenario.title or name])
    return found
