"""The designer's panel "Train": data, a system to start from, learning in another process, and the best taken.

The page sees what :class:`TrainSession` hands to the module ``training.js``, and sends it messages: a file of the
folder, an upload in pieces, which column is which, settings, start, stop, take. Nothing here waits for the learning.
"""

import asyncio
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from math import ceil, inf, isfinite
from pathlib import Path
from typing import Any

import numpy as np

from anfis.methods.catalogue import METHODS
from anfis.plugins.designer.task import (
    STARTS,
    Ask,
    Generator,
    TrainingTask,
    TrainingTaskError,
    TrainOutcome,
    chosen_columns,
    guessed,
    in_words,
    split,
    task_of,
    train_task,
)
from fuzzy.entrypoints import entry_points
from fuzzy.errors import InputError
from fuzzy.naming import check_known
from fuzzy.plugins.designer.columns import LoadedTable, columns_data
from fuzzy.plugins.designer.datapictures import Rows
from fuzzy.plugins.designer.folder import LARGEST_FILE
from fuzzy.plugins.designer.latest import Latest
from fuzzy.plugins.designer.longtask import TaskSession
from fuzzy.plugins.designer.panel import SessionPanel
from fuzzy.plugins.designer.tablesource import TableSession
from fuzzy.plugins.designer.views import variable_data
from fuzzy.plugins.designer.workers import WorkError
from fuzzy.system import Sugeno

_GROUP = "fuzzyfleet.training_data"  # entry points: functions that give a sequence of Generators
_MODULE = Path(__file__).parent / "static" / "training.js"
_DRAWN = 1_000  # epochs of the curve that is sent, at most


def generators() -> list[Generator]:
    """The generators of training data that other packages offer as entry points of _GROUP."""
    return [generator for entry in entry_points(group=_GROUP) for generator in entry.load()()]


class TrainSession(TableSession, TaskSession):
    """The training of one page: what it has chosen, and the process that learns. Messages come one at a time."""

    error = TrainingTaskError
    called = "training"
    larger = "use anfis train for large tables"

    def __init__(self, bench: Any) -> None:
        super().__init__(
            bench,
            start="present", radius=0.5, mfs=3, method="hybrid", epochs=60, goal=0.0, share=0.2, seed=0, skip_bad=False,
        )  # fmt: skip
        self.history: list[tuple[Any, ...]] = []
        self.started: Sugeno | None = None  # what the learning began with
        self.outcome: TrainOutcome | None = None
        self.best: Sugeno | None = None  # so far
        self.output = 0  # that is drawn
        self.pictures = Latest(self._draw)
        self.words: list[str] = []
        self.samples = 0  # from which it learns
        self.unit = ""  # of the error that is learnt
        self.made = {generator.name: generator for generator in generators()}
        self.asked: dict[str, Sequence[Ask]] = {}  # what generators ask for, by their names, once that is known
        self.put(
            _MODULE,
            sources=self._sources(),
            accepted={"start": list(STARTS), "method": methods(), "largest": LARGEST_FILE},
            choice=self.choice,
            columns={},
            system=self._system(),
            progress=self._progress(),
            **dict.fromkeys(("table", "before", "after", "pictures", "points", "residual", "terms", "about")),
            **self._of_columns(),
        )
        self.asking = asyncio.get_running_loop().create_task(self._ask())
        self.open_table()

    # Messages

    async def _do_generate(self, message: dict[str, Any]) -> None:
        name = message.get("name")
        name = check_known(name, self.made, "generator of data", TrainingTaskError)
        generator, folder = self.made[name], Path(self.bench.document.folder)
        if generator.asks is None:
            self.show_table(await self.bench.background(generator.make))
            return
        given = message.get("chosen")
        if not isinstance(given, dict) or not all(isinstance(value, str) for value in given.values()):
            raise TrainingTaskError(f"{generator.title}: say what is chosen, by name")
        asks = await self._asks(generator)
        chosen = {ask.name: given.get(ask.name, ask.value) for ask in asks}
        for ask in asks:
            known = [value for value, _ in ask.options]
            if known:
                check_known(chosen[ask.name], known, ask.title.lower(), TrainingTaskError)
            elif not (chosen[ask.name].isdecimal() and int(chosen[ask.name]) >= 1):
                raise TrainingTaskError(f"{ask.title} must be a whole number >= 1, got {chosen[ask.name]!r}")
        self.show_table(await self.bench.background(generator.make, folder, chosen))

    def _do_column(self, message: dict[str, Any]) -> None:
        name, value = message.get("name"), message.get("value")
        if not isinstance(name, str) or not isinstance(value, str):
            raise TrainingTaskError("a choice of a column is a name and a column or role")
        self.columns = {**self.columns, name: value}
        self.widget.update(columns=self.columns, **self._of_columns())

    def _do_choose(self, message: dict[str, Any]) -> None:
        name, value = self.setting(message)
        self.choice = {**self.choice, name: value}
        if name == "start":
            self._guess()
        self.widget.update(choice=self.choice, **self._of_columns())

    async def _do_train(self, message: dict[str, Any]) -> None:
        self.check_idle()
        if self.table is None:
            raise TrainingTaskError("choose data first: a CSV file, or data that are generated")
        present = self.present
        settings = {**self.choice, "skip_bad": self.choice["skip_bad"] is True}
        task = task_of(self.table, self.columns, present, name=present.name, **settings)
        self.best, self.rows, self.output = None, self._rows(task), 0
        self.history, self.started, self.outcome, self.words = [], None, None, []
        self.unit = self._of_columns()["unit"]
        self.samples = len(task.x) - task.checking
        if len(task.x) < len(self.table.values):
            self.words.append(f"{len(self.table.values) - len(task.x)} of {len(self.table.values)} rows are left out")
        self.widget.update(before=None, after=None)
        self.pictures.wish()
        await self.start(task, train_task)

    def _do_take(self, message: dict[str, Any]) -> None:
        """The best into the design, as one edit; disabled rules, which were not learnt, stay if they still fit."""
        if self.outcome is None:
            raise TrainingTaskError("there is no trained system to take yet")
        present = self.present
        what = f"train ({self.choice['method']}, epoch {self.outcome.best})"
        self.bench.document.replace(replace(self.outcome.system, name=present.name), what, keep_disabled=True)

    def _do_look(self, message: dict[str, Any]) -> None:
        """Lead to the viewer, at a sample's inputs, where the design has the inputs that are learnt."""
        row = message.get("row")
        if self.rows is None or not isinstance(row, int) or not 0 <= row < len(self.rows.x) or not self._looks():
            raise TrainingTaskError("there is no such sample of the design's inputs")
        self.bench.look_at(self.rows.x[row].tolist())
        self.bench.show("Viewer")

    def _do_output(self, message: dict[str, Any]) -> None:
        value = message.get("value")
        if self.rows is None or not isinstance(value, int) or not 0 <= value < self.rows.y.shape[1]:
            raise TrainingTaskError("there is no such output")
        self.output = value
        self.pictures.wish()

    # The learning

    def _rows(self, task: TrainingTask) -> Rows:
        """The samples of a task, with the lines of the file that they come from."""
        table = self.table
        assert table is not None
        inputs, outputs = chosen_columns(table, self.columns, self.present, self.choice["start"])
        kept = ~table.lacking([*inputs, *outputs])
        checking = np.zeros(len(task.x), dtype=bool)
        checking[split(len(task.x), task.checking, task.seed)[1]] = True
        return Rows(task.x, task.y, table.begins[kept], checking if task.checking else None)

    async def _draw(self) -> None:
        """What the best system so far makes of the samples."""
        system = self.best
        try:
            traits = await self.drawn_rows(system, self.output)
        except (InputError, WorkError) as error:
            traits = {"problem": {"message": str(error)}}
        if traits is not None:  # otherwise another training has begun
            if system is not None and traits.get("pictures"):
                traits["about"] = {"outputs": [v.name for v in system.outputs], "looks": self._looks()}
            self.widget.update(**traits)

    def _looks(self) -> bool:
        """Has the design the inputs that are learnt?"""
        now = [v.name for v in self.present.inputs]
        return self.best is not None and [v.name for v in self.best.inputs] == now

    def note(self, what: str, about: Any) -> None:
        """Take a piece of news of the learning."""
        super().note(what, about)
        if what == "start":
            self.started = self.best = about
            self.widget.update(before=variables(about))
            self.pictures.wish()
        elif what == "best":
            self.best = about
            self.pictures.wish()
        elif what == "warning":
            if about not in self.words:
                self.words.append(about)
        elif what == "epoch":
            self.history.append(about)
            self.state = "learning" if self.state == "starting" else self.state
        elif what == "done":
            self.outcome, self.best = about, about.system
            self.widget.update(after=variables(about.system))
            self.pictures.wish()

    # What the page sees

    def changed(self) -> None:
        """Show the system under design."""
        self.widget.update(system=self._system(), **self._of_columns())

    def _system(self) -> dict[str, Any]:
        fis = self.present
        return {
            "name": fis.name,
            "inputs": [v.name for v in fis.inputs],
            "outputs": [v.name for v in fis.outputs],
            "rules": len(fis.rules),
        }

    def _sources(self) -> dict[str, Any]:
        made = [[g.name, g.title, [ask._asdict() for ask in self.asked.get(g.name, ())]] for g in self.made.values()]
        return {"files": self.table_files(), "generators": made}

    async def _asks(self, generator: Generator) -> Sequence[Ask]:
        """What a generator asks for: that depends on the folder's files, which another process looks at."""
        assert generator.asks is not None
        asks: Sequence[Ask] = await self.bench.read("the folder", generator.asks, Path(self.bench.document.folder))
        self.asked[generator.name] = asks
        return asks

    async def _ask(self) -> None:
        with suppress(InputError, WorkError):  # said when the generator is chosen
            for generator in self.made.values():
                if generator.asks is not None:
                    await self._asks(generator)
        self.widget.update(sources=self._sources())

    def show_table(self, table: LoadedTable) -> None:
        """Take a table, and guess which column is which."""
        self.table = table
        self.choice = {**self.choice, "skip_bad": False}
        self._guess()
        about = columns_data(table)
        self.widget.update(
            table=about, columns=self.columns, choice=self.choice, sources=self._sources(), **self._of_columns()
        )

    def _guess(self) -> None:
        if self.table is not None:
            present = self.present if self.choice["start"] == "present" else None
            self.columns = guessed(self.table, present)
            self.widget.update(columns=self.columns)

    def _of_columns(self) -> dict[str, str]:
        """What follows from the columns: the unit of the error, if all outputs have one, and rows without numbers."""
        present, fresh = self.present, self.choice["start"] != "present"
        units, lack = [] if fresh else [v.unit for v in present.outputs], ""
        if self.table is not None:
            with suppress(InputError):  # said when it is tried
                inputs, outputs = chosen_columns(self.table, self.columns, present, self.choice["start"])
                columns = [self.table.unit(name) for name in outputs]
                units = columns if fresh else [a or b for a, b in zip(units, columns, strict=True)]
                lack = self.table.lack([*inputs, *outputs])
        return {"unit": units[0] if len(set(units)) == 1 else "", "lack": lack}

    def _verdict(self) -> list[str]:
        """What a training that has ended means."""
        if self.outcome is None:
            return []
        return in_words(self.history, self.outcome.parameters, self.samples)

    def _progress(self) -> dict[str, Any]:
        rows = self.history
        every = max(1, ceil(len(rows) / _DRAWN))
        drawn = [row for k, row in enumerate(rows) if k % every == 0 or k == len(rows) - 1]
        checked = any(isfinite(row[2]) for row in rows)
        errors = [row[2 if checked else 1] for row in rows]
        best = min(range(len(rows)), key=lambda k: errors[k] if isfinite(errors[k]) else inf) if rows else None
        return {
            "state": self.state,
            "epochs": self.choice["epochs"],
            "epoch": [row[0] for row in drawn],
            "train": [row[1] if isfinite(row[1]) else None for row in drawn],
            "check": [row[2] if isfinite(row[2]) else None for row in drawn] if checked else None,
            "best": None if best is None else {"epoch": rows[best][0], "error": errors[best], "checked": checked},
            "first": rows[0][2 if checked else 1] if rows and isfinite(rows[0][2 if checked else 1]) else None,
            "rules": None if self.started is None else len(self.started.rules),
            "outputs": None if self.started is None else len(self.started.outputs),
            "parameters": None if self.outcome is None else self.outcome.parameters,
            "stopped": None if self.outcome is None else self.outcome.stopped,
            "unit": self.unit,
            "words": [*self.words, *self._verdict()],
        }


panel = SessionPanel("Train", 60, TrainSession, improves="from data")


def methods() -> list[list[str]]:
    """The methods of learning as the page lists them: [name, title] each."""
    return [[name, listed.title] for name, listed in METHODS.items()]


def variables(fis: Sugeno) -> list[dict[str, Any]]:
    """The inputs of ``fis`` with their terms, as the editor of membership functions takes them."""
    return [variable_data(v) for v in fis.inputs]
