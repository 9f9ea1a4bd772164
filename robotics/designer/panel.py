"""The designer's panel "Try it": the rule base that is edited drives a robot, anew after every edit.

The page shows what :class:`TryoutSession` hands to the module ``static/tryout.js``. Runs are made in the background,
one at a time: while one is made, only the latest wish waits. The module also generates data for the panel "Train".
"""

import asyncio
from collections.abc import Sequence
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from time import monotonic
from typing import Any

from fuzzy.designer.folder import open_folder
from fuzzy.designer.workers import WorkError
from fuzzy.errors import InputError
from fuzzy.files.fisfile import read_fis
from fuzzy.naming import expected
from fuzzy.system import Sugeno

_ORDER = ("course", "tried", "choices", "before", "rival")  # the first things to look at are made first
_RUNS = {"tried", "before", "rival"}
_LOOK = 1.0  # s between two looks at the scenario's file
MODULE = Path(__file__).parent / "static" / "tryout.js"


class TryItPanel:
    """The panel "Try it", as the designer finds it."""

    title = "Try it"
    order = 50

    def build(self, bench: Any) -> None:
        """Put the panel on the page of ``bench``, a fuzzy.designer.panel.Workbench."""
        TryoutSession(bench)


panel = TryItPanel()


class TryoutSession:
    """The trials of one page: the choices, the runs that are known, and those that are still to be made."""

    def __init__(self, bench: Any) -> None:
        from robotics.designer.tryout import TryoutTrial

        self.bench = bench
        self.folder = open_folder(bench.document.folder)
        self.wish = TryoutTrial()  # what was chosen; what is empty is chosen to suit the system
        self.trial: TryoutTrial | None = None  # what follows from it; none: the system or the scenario is no good
        self.rival = ""  # empty: what suits the system
        self.before, self.label = self._opened()
        self.place: dict[str, Any] = {}
        self.variables: Any = None  # those of the system that found this place
        self.last: tuple[Any, ...] = ()  # the latest run: its trial, its system, and what is shown of it
        self.known: dict[tuple[Any, ...], dict[str, Any]] = {}  # runs of rivals
        self.took: dict[str, float] = {}  # s that making each thing took last
        self.choices: dict[str, Any] | None = None
        self.watched: tuple[str, Any] | None = None  # a scenario's file in the folder, and its state when it was read
        self.watch: asyncio.TimerHandle | None = None
        self.wanted = set(_ORDER)
        self.seen = False  # nothing is run for a panel that nobody looks at
        self.task: asyncio.Task[None] | None = None
        nothing = dict.fromkeys(("choices", "course", "tried", "before", "rival", "busy", "problem"))
        self.widget = bench.widget(MODULE, files=[], trial=self._trial(), **nothing)
        self.widget.on_message(self.heard)
        bench.on_change(self._changed)
        bench.on_close(self._closed)

    # Messages

    def heard(self, message: Any) -> None:
        """Do what the page asks; an error becomes a sentence on the page."""
        content = message if isinstance(message, dict) else {}
        tasks = {"see": self._see, "list": self._list, "choose": self._choose, "file": self._take, "pin": self._pin}
        try:
            wish = content.get("do")
            if not isinstance(wish, str) or wish not in tasks:
                raise _problem(expected(str(wish), tasks, "wish"))
            tasks[wish](content)
        except InputError as error:
            self.widget.update(problem={"message": str(error)}, trial=self._trial())
        self._go()

    def _see(self, content: dict[str, Any]) -> None:
        self.seen = bool(content.get("on"))
        if self.seen:
            self._list(content)
            self._look()

    def _list(self, _: dict[str, Any]) -> None:
        from robotics.designer.scenariofiles import scenario_files

        self.widget.update(files=scenario_files(self.folder))

    def _pin(self, _: dict[str, Any]) -> None:
        self.before, self.label = self._present(), "pinned"
        self.wanted |= {"before"}

    def _choose(self, content: dict[str, Any]) -> None:
        name, value = content.get("name"), content.get("value")
        if name == "rival":
            known = [n for pairs in self._rivals().values() for n, _ in pairs]
            if value not in known:
                raise _problem(expected(str(value), known, "law to compare with"))
            self.rival = value
            self.wanted |= {"rival"}
            self.widget.update(trial=self._trial())
        elif name == "scenario":
            self._choose_scenario(str(value))
        elif name == "law":
            self._choose_law(value)
        elif name in ("look_ahead", "seed"):
            change: dict[str, Any] = {name: value}
            self._want(replace(self.wish, **change))
        else:
            raise _problem(expected(str(name), ("scenario", "law", "look_ahead", "seed", "rival"), "choice"))

    def _choose_scenario(self, name: str) -> None:
        from robotics.designer.scenariofiles import changed_at, read_scenario_file

        if not name.endswith(".toml"):
            self.watched = None
            self._want(replace(self.wish, scenario=name, text=None))
            return
        state = changed_at(self.folder, name)
        text = read_scenario_file(self.folder, name)
        self._want(replace(self.wish, scenario=name, text=text, folder=str((self.folder.path / name).parent)))
        self.watched = name, state

    def _choose_law(self, value: Any) -> None:
        """Take another of the laws that the system fits; a scenario that it does not drive gives way."""
        laws = {f"{law}/{task}": (law, task, kinds) for law, task, _, kinds in self._course().get("laws", [])}
        if value not in laws:
            raise _problem(expected(str(value), laws, "law"))
        law, task, kinds = laws[value]
        wish = replace(self.wish, law=law, task=task)
        if self._course()["kind"] not in kinds:
            self.watched = None
            wish = replace(wish, scenario="", text=None)
        self._want(wish)

    def _take(self, content: dict[str, Any]) -> None:
        """Take the scenario file that was chosen on the page, from anywhere."""
        from robotics.designer.scenariofiles import checked_text

        name, text = content.get("name"), content.get("text")
        if not isinstance(name, str) or not name.lower().endswith(".toml") or not isinstance(text, str):
            raise _problem("a scenario is a .toml file")
        name = name.replace("\\", "/").rpartition("/")[2][-100:]
        text = checked_text(name, text.encode("utf-8", "replace"))
        self.watched = None
        self._want(replace(self.wish, scenario=name, text=text))

    def _want(self, wish: Any) -> None:
        self.wish = wish
        self.wanted |= {"course", "tried"}

    def _changed(self) -> None:
        if self.trial is None or _variables(self._present()) != self.variables:
            self.wanted |= {"course"}
        self.wanted |= {"tried"}
        self._go()

    def _look(self) -> None:
        """Read the scenario's file anew if it has changed, and look again in a second while the panel is seen."""
        from robotics.designer.scenariofiles import changed_at, read_scenario_file

        if self.watch is not None:
            self.watch.cancel()
        self.watch = asyncio.get_running_loop().call_later(_LOOK, self._look) if self.seen else None
        if self.watched is None or not self.seen:
            return
        name, before = self.watched
        state = changed_at(self.folder, name)
        if state == before:
            return
        self.watched = name, state
        try:
            self._want(replace(self.wish, text=read_scenario_file(self.folder, name)))
        except InputError as error:
            self.widget.update(problem={"message": str(error)})
        self._go()

    def _closed(self) -> None:
        self.seen = False
        if self.watch is not None:
            self.watch.cancel()

    # Runs

    def _go(self) -> None:
        if self.seen and self.wanted and (self.task is None or self.task.done()):
            self.task = asyncio.get_running_loop().create_task(self._run())

    async def _run(self) -> None:
        """Run what is wanted in the order of _ORDER, until nothing is left; an edit meanwhile makes it wanted again."""
        try:
            while self.seen and self.wanted:
                what = next(name for name in _ORDER if name in self.wanted)
                self.wanted -= {what}
                self.widget.update(busy={"what": what, "took": self.took.get(what)})
                asked, began = (self.wish, self.trial), monotonic()
                try:
                    data = await self._made(what)
                    said = None
                except (InputError, WorkError) as error:
                    data, said = None, {"message": str(error)}
                if asked != (self.wish, self.trial):
                    continue  # it belongs to another scenario: what is wanted now is run
                self.took[what] = monotonic() - began
                self._show(what, data, said)
        finally:
            self.widget.update(busy=None)

    def _show(self, what: str, data: dict[str, Any] | None, said: dict[str, str] | None) -> None:
        if what == "course":
            self._settle(data, said)
        elif what == "tried":
            self.widget.update(tried=data, problem=said)
        elif said is None:
            self.widget.update(**{what: data})
        elif what == "rival":
            self.widget.update(rival={"label": self._rival(), "why": said["message"]})
        else:
            self.widget.update(before={"label": self.label, "why": said["message"]})

    def _settle(self, place: dict[str, Any] | None, said: dict[str, str] | None) -> None:
        """Go on with the place that the system has found, or say why there is none."""
        from robotics.designer.tryout import TryoutTrial

        if place is None:
            self.trial, self.place = None, {}
            self.wanted -= _RUNS
            self.widget.update(trial=self._trial(), problem=said, **dict.fromkeys(("course", *_RUNS)))
            return
        trial = TryoutTrial(**place["trial"])
        if trial != self.trial:
            self.wanted |= _RUNS
        self.trial, self.place = trial, place
        self.widget.update(trial=self._trial(), course=place["course"])

    async def _made(self, what: str) -> dict[str, Any]:
        from robotics.designer import tryout

        fis, trial = self._present(), self.trial
        if what == "choices":
            self.choices = await self._background(tryout.choices)
            return self.choices
        if what == "course":
            self.variables = _variables(fis)
            return await self._background(tryout.place_data, fis, self.wish, self.bench.document.path.stem)
        if what == "tried":
            made = await self._background(tryout.design_data, fis, trial)
            self.last = trial, fis, made
            return made
        if what == "before":
            label = {"label": self.label}
            if self.last[:2] == (trial, self.before):  # nothing has been edited yet
                return _beside(self.last[2]) | label
            return _beside(await self._background(tryout.design_data, self.before, trial)) | label
        rival = self._rival()
        key = (rival, trial.scenario, trial.text, trial.seed) if trial is not None else ()
        if key not in self.known:
            self.known[key] = _beside(await self._background(tryout.rival_data, rival, trial))
        return self.known[key]

    async def _background(self, function: Any, *args: Any) -> dict[str, Any]:
        made: dict[str, Any] = await self.bench.background(function, *args)
        return made

    # What the page sees

    def _opened(self) -> tuple[Sugeno, str]:
        """The system to compare with until another is chosen: the file's, from which the present one may differ."""
        try:
            return read_fis(self.bench.document.path), "in the file"
        except InputError:  # a new system, or a file that has been spoilt meanwhile
            return self._present(), "as opened"

    def _present(self) -> Sugeno:
        fis: Sugeno = self.bench.document.design.in_force
        return fis

    def _course(self) -> dict[str, Any]:
        course: dict[str, Any] = self.place.get("course", {})
        return course

    def _trial(self) -> dict[str, Any]:
        """The choices as the page shows them, without the text of a file and where it is."""
        shown = asdict(self.trial or self.wish) | {"rival": self._rival(), "kind": self._course().get("kind", "")}
        return {name: value for name, value in shown.items() if name not in ("text", "folder")}

    def _rival(self) -> str:
        """The law to compare with: the one that was chosen, if it drives such scenarios."""
        kind = self._course().get("kind", "")
        if self.rival and self.rival in [name for name, _ in (self.choices or {"rivals": {}})["rivals"].get(kind, [])]:
            return self.rival
        found: str = self._course().get("rival", "")
        return found

    def _rivals(self) -> dict[str, list[list[str]]]:
        if self.choices is None:
            raise _problem("the panel is not ready yet")
        rivals: dict[str, list[list[str]]] = self.choices["rivals"]
        return rivals


def _beside(made: dict[str, Any]) -> dict[str, Any]:
    """What is shown of a run beside that of the design, which alone is played; the player's data may be a megabyte."""
    return {name: value for name, value in made.items() if name != "player"}


def _variables(fis: Sugeno) -> tuple[Any, ...]:
    """What a system's place depends on."""
    return fis.name, [v.name for v in fis.inputs], [v.name for v in fis.outputs]


def _problem(sentence: str) -> InputError:
    from robotics.designer.uses import TryoutError

    return TryoutError(sentence)


# Data for the panel "Train" -------------------------------------------------------------------------------------


def formation_data() -> Sequence[Any]:
    """The formation data of thesis 5.2.1 as anfis.designer.task.Generator; an entry point of the panel "Train"."""
    from anfis.designer.task import Generator

    return [
        Generator("formation-literal", "Formation data, as the thesis describes them", partial(_formation, "literal")),
        Generator("formation-well-posed", "Formation data, well-posed", partial(_formation, "well-posed")),
    ]


def _formation(kind: str) -> Any:
    from anfis.designer.task import Columns
    from robotics.experiments.learning.formationdata import FILES
    from robotics.experiments.learning.formationdata import formation_data as made

    table = made(FILES[f"formation-{kind}.csv"])
    return Columns(f"formation data, {kind}", table.names, table.values, table.inputs)
