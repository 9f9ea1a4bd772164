"""The designer's panel "Try it": the rule base that is edited drives a robot, anew after every edit.

The page shows what :class:`TryoutSession` hands to the module ``static/tryout.js``. Runs are made in the background,
one at a time: while one is made, only the latest wish waits. The module also generates data for the panel "Train".
"""

import asyncio
from collections.abc import Sequence
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from typing import Any

from fuzzy.designer.workers import WorkError
from fuzzy.errors import InputError
from fuzzy.files.fisfile import read_fis
from fuzzy.naming import expected
from fuzzy.system import Sugeno

_ORDER = ("course", "tried", "choices", "before", "rival")  # the first things to look at are made first
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
        self.trial = TryoutTrial()
        self.rival = "lyapunov"
        self.before, self.label = self._opened()
        self.known: dict[tuple[Any, ...], dict[str, Any]] = {}  # runs of rivals
        self.choices: dict[str, Any] | None = None
        self.wanted = set(_ORDER)
        self.seen = False  # nothing is run for a panel that nobody looks at
        self.task: asyncio.Task[None] | None = None
        self.widget = bench.widget(
            MODULE,
            choices=None,
            trial=self._trial(),
            course=None,
            tried=None,
            before=None,
            rival=None,
            busy=False,
            problem=None,
        )
        self.widget.on_message(self.heard)
        bench.on_change(self._changed)

    # Messages

    def heard(self, message: Any) -> None:
        """Do what the page asks; an error becomes a sentence on the page."""
        try:
            wish = message.get("do") if isinstance(message, dict) else None
            if wish == "see":
                self.seen = bool(message.get("on"))
            elif wish == "choose":
                self._choose(message.get("name"), message.get("value"))
            elif wish == "pin":
                self.before, self.label = self._present(), "pinned"
                self.wanted |= {"before"}
            else:
                raise _problem(expected(str(wish), ("see", "choose", "pin"), "wish"))
        except InputError as error:
            self.widget.update(problem={"message": str(error)}, trial=self._trial())
        self._go()

    def _choose(self, name: Any, value: Any) -> None:
        if name == "rival":
            known = [n for pairs in self._rivals().values() for n, _ in pairs]
            if value not in known:
                raise _problem(expected(str(value), known, "law to compare with"))
            self.rival = value
            self.wanted |= {"rival"}
        elif name in ("scenario", "law", "look_ahead", "seed"):
            self.trial = replace(self.trial, **{name: value})
            rivals = [n for n, _ in self._rivals()[self.trial.kind]]
            if self.rival not in rivals:
                self.rival = "lyapunov" if "lyapunov" in rivals else "virtual-structure"
            self.wanted |= {"course", "tried", "before", "rival"}
        else:
            raise _problem(expected(str(name), ("scenario", "law", "look_ahead", "seed", "rival"), "choice"))
        self.widget.update(trial=self._trial())

    def _changed(self) -> None:
        self.wanted |= {"tried"}
        self._go()

    # Runs

    def _go(self) -> None:
        if self.seen and self.wanted and (self.task is None or self.task.done()):
            self.task = asyncio.get_running_loop().create_task(self._run())

    async def _run(self) -> None:
        """Run what is wanted in the order of _ORDER, until nothing is left; an edit meanwhile makes it wanted again."""
        self.widget.update(busy=True)
        try:
            while self.seen and self.wanted:
                what = next(name for name in _ORDER if name in self.wanted)
                self.wanted -= {what}
                trial = self.trial
                try:
                    data = await self._made(what)
                    said = None
                except (InputError, WorkError) as error:
                    data, said = None, {"message": str(error)}
                if trial != self.trial:
                    continue  # it belongs to another scenario: what is wanted now is run
                if what == "tried":
                    self.widget.update(tried=data, problem=said)
                elif what == "rival" and said is not None:
                    self.widget.update(rival={"label": self.rival, "why": said["message"]})
                elif what == "before" and said is not None:
                    self.widget.update(before={"label": self.label, "why": said["message"]})
                else:
                    self.widget.update(**{what: data})
        finally:
            self.widget.update(busy=False)

    async def _made(self, what: str) -> dict[str, Any]:
        from robotics.designer import tryout

        trial = self.trial
        if what == "choices":
            self.choices = await self._background(tryout.choices)
            return self.choices
        if what == "course":
            return tryout.course_data(trial)
        if what == "tried":
            tryout.check_fits(self._present())
            return await self._background(tryout.design_data, self._present(), trial)
        if what == "before":
            label = self.label
            return await self._background(tryout.design_data, self.before, trial) | {"label": label}
        key = (self.rival, trial)
        if key not in self.known:
            self.known[key] = await self._background(tryout.rival_data, self.rival, trial)
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

    def _trial(self) -> dict[str, Any]:
        from robotics.designer.tryout import law_name

        return asdict(self.trial) | {"law": law_name(self.trial), "rival": self.rival, "kind": self.trial.kind}

    def _rivals(self) -> dict[str, list[list[str]]]:
        if self.choices is None:
            raise _problem("the panel is not ready yet")
        rivals: dict[str, list[list[str]]] = self.choices["rivals"]
        return rivals


def _problem(sentence: str) -> InputError:
    from robotics.designer.tryout import TryoutError

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
