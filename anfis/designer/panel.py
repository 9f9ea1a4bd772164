"""The designer's panel "Train": data, a system to start from, learning in another process, and the best taken.

The page sees what :class:`TrainSession` hands to the module ``training.js``, and sends it messages: a file of the
folder, an upload in pieces, which column is which, settings, start, stop, take. Nothing here waits for the learning.
"""

import asyncio
import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

import numpy as np

from anfis.designer.task import (
    STARTS,
    Ask,
    Generator,
    Task,
    TaskError,
    TrainingProcess,
    TrainOutcome,
    chosen_columns,
    guessed,
    split,
    task_of,
)
from anfis.methods.catalogue import METHODS
from fuzzy.designer.columns import Columns, columns_data
from fuzzy.designer.datapictures import Rows, data_pictures
from fuzzy.designer.folder import LARGEST_FILE
from fuzzy.designer.latest import Latest
from fuzzy.designer.tablesource import TableSource
from fuzzy.designer.wishes import Wishes, refusal_of_choice
from fuzzy.designer.workers import WorkError
from fuzzy.errors import InputError
from fuzzy.naming import expected
from fuzzy.system import Sugeno

GROUP = "fuzzyfleet.training_data"  # entry points: functions that give a sequence of Generators
MODULE = Path(__file__).parent / "static" / "training.js"
_MOST = LARGEST_FILE  # bytes of a file, characters of an upload: one limit for all that a page sends
_DRAWN = 1_000  # epochs of the curve that is sent, at most
_EVERY = 0.1  # s between looks at the learning


def generators() -> list[Generator]:
    """The generators of training data that other packages offer as entry points of GROUP."""
    return [generator for entry in entry_points(group=GROUP) for generator in entry.load()()]


class TrainPanel:
    """The panel "Train" as the designer finds it, by an entry point."""

    title = "Train"
    order = 60

    def build(self, bench: Any) -> None:
        """Put the panel on the page of ``bench``, a fuzzy.designer.panel.Workbench."""
        TrainSession(bench)


panel = TrainPanel()


class TrainSession:
    """The training of one page: what it has chosen, and the process that learns. Messages come one at a time."""

    def __init__(self, bench: Any) -> None:
        self.bench = bench
        self.table: Columns | None = None
        self.choice: dict[str, Any] = {
            "start": "present", "radius": 0.5, "mfs": 3, "method": "hybrid", "epochs": 60, "goal": 0.0, "share": 0.2,
            "seed": 0, "skip_bad": False,
        }  # fmt: skip
        self.columns: dict[str, str] = {}
        self.source = TableSource(bench, _MOST, "use anfis train for large tables")
        self.process: TrainingProcess | None = None
        self.begun = False  # from the wish to train until its process has ended
        self.closed = False
        self.watching: asyncio.Task[None] | None = None
        self.history: list[tuple[Any, ...]] = []
        self.start: Sugeno | None = None
        self.outcome: TrainOutcome | None = None
        self.best: Sugeno | None = None  # so far
        self.rows: Rows | None = None  # of the training that runs or ran last
        self.output = 0  # that is drawn
        self.pictures = Latest(self._draw)
        self.words: list[str] = []
        self.unit = ""  # of the error that is learnt
        self.state = "idle"
        self.made = {generator.name: generator for generator in generators()}
        self.asked: dict[str, Sequence[Ask]] = {}  # what generators ask for, by their names, once that is known
        self.widget = bench.widget(
            MODULE,
            sources=self._sources(),
            accepted={"start": list(STARTS), "method": methods(), "largest": _MOST},
            table=None,
            choice=self.choice,
            columns={},
            system=self._system(),
            progress=self._progress(),
            before=None,
            after=None,
            problem=None,
            pictures=None,
            points=None,
            residual=None,
            terms=None,
            about=None,
            **self._of_columns(),
        )
        self.wishes = Wishes(
            {
                "file": self._file,
                "piece": self._piece,
                "generate": self._generate,
                "column": self._column,
                "choose": self._choose,
                "train": self._train,
                "stop": self._stop,
                "take": self._take,
                "look": self._look,
                "output": self._choose_output,
            },
            self._refuse,
            TaskError,
            lambda: self.widget.update(problem=None),
        )
        self.widget.on_message(self.wishes.heard)
        bench.on_change(self._changed)
        bench.on_close(self.close)
        self.asking = asyncio.get_running_loop().create_task(self._ask())

    # Messages

    def _refuse(self, error: Exception, message: dict[str, Any]) -> None:
        self.widget.update(problem=refusal_of_choice(error, message))

    async def _file(self, message: dict[str, Any]) -> None:
        """A CSV file of the folder."""
        self._show(await self.source.file(message.get("name")))

    async def _piece(self, message: dict[str, Any]) -> None:
        """A piece of an uploaded file."""
        table = await self.source.piece(message)
        if table is not None:
            self._show(table)

    async def _generate(self, message: dict[str, Any]) -> None:
        name = message.get("name")
        if not isinstance(name, str) or name not in self.made:
            raise TaskError(expected(str(name), self.made, "generator of data"))
        generator, folder = self.made[name], Path(self.bench.document.folder)
        if generator.asks is None:
            self._show(await self.bench.background(generator.make))
            return
        given = message.get("chosen")
        if not isinstance(given, dict) or not all(isinstance(value, str) for value in given.values()):
            raise TaskError(f"{generator.title}: say what is chosen, by name")
        asks = await self._asks(generator)
        chosen = {ask.name: given.get(ask.name, ask.value) for ask in asks}
        for ask in asks:
            known = [value for value, _ in ask.options]
            if known and chosen[ask.name] not in known:
                raise TaskError(expected(chosen[ask.name], known, ask.title.lower()))
            if not known and not (chosen[ask.name].isdecimal() and int(chosen[ask.name]) >= 1):
                raise TaskError(f"{ask.title} must be a whole number >= 1, got {chosen[ask.name]!r}")
        self._show(await self.bench.background(generator.make, folder, chosen))

    def _column(self, message: dict[str, Any]) -> None:
        name, value = message.get("name"), message.get("value")
        if not isinstance(name, str) or not isinstance(value, str):
            raise TaskError("a choice of a column is a name and a column or role")
        self.columns = {**self.columns, name: value}
        self.widget.update(columns=self.columns, **self._of_columns())

    def _choose(self, message: dict[str, Any]) -> None:
        name = message.get("name")
        if not isinstance(name, str) or name not in self.choice:
            raise TaskError(expected(str(name), self.choice, "setting"))
        self.choice = {**self.choice, name: message.get("value")}
        if name == "start":
            self._guess()
        self.widget.update(choice=self.choice, **self._of_columns())

    async def _train(self, message: dict[str, Any]) -> None:
        # Another wish may come while the process is being started.
        if self.begun:
            raise TaskError("a training runs already; stop it first")
        if self.table is None:
            raise TaskError("choose data first: a CSV file, or data that are generated")
        present = self._present()
        settings = {**self.choice, "skip_bad": self.choice["skip_bad"] is True}
        task = task_of(self.table, self.columns, present, name=present.name, **settings)
        self.begun = True
        self.best, self.rows, self.output = None, self._rows(task), 0
        self.history, self.start, self.outcome, self.words, self.state = [], None, None, [], "starting"
        self.unit = self._of_columns()["unit"]
        if len(task.x) < len(self.table.values):
            self.words.append(f"{len(self.table.values) - len(task.x)} of {len(self.table.values)} rows are left out")
        self.widget.update(progress=self._progress(), before=None, after=None)
        self.pictures.wish()
        try:
            process = await asyncio.to_thread(TrainingProcess, task)
        except BaseException:
            self.begun, self.state = False, "idle"
            self.widget.update(progress=self._progress())
            raise
        if self.closed:
            process.close()
            return
        self.process = process
        if self.state == "stopping":
            process.stop()
        self.watching = asyncio.get_running_loop().create_task(self._watch(process))

    def _stop(self, message: dict[str, Any]) -> None:
        if not self.begun:
            raise TaskError("no training runs")
        if self.process is not None:
            self.process.stop()
        self.state = "stopping"
        self.widget.update(progress=self._progress())

    def _take(self, message: dict[str, Any]) -> None:
        """The best into the design, as one edit; disabled rules, which were not learnt, stay if they still fit."""
        if self.outcome is None:
            raise TaskError("there is no trained system to take yet")
        present = self._present()
        what = f"train ({self.choice['method']}, epoch {self.outcome.best})"
        self.bench.document.replace(replace(self.outcome.system, name=present.name), what, keep_disabled=True)

    def _look(self, message: dict[str, Any]) -> None:
        """Lead to the viewer, at a sample's inputs, where the design has the inputs that are learnt."""
        row = message.get("row")
        if self.rows is None or not isinstance(row, int) or not 0 <= row < len(self.rows.x) or not self._looks():
            raise TaskError("there is no such sample of the design's inputs")
        self.bench.look_at(self.rows.x[row].tolist())
        self.bench.show("Viewer")

    def _choose_output(self, message: dict[str, Any]) -> None:
        value = message.get("value")
        if self.rows is None or not isinstance(value, int) or not 0 <= value < self.rows.y.shape[1]:
            raise TaskError("there is no such output")
        self.output = value
        self.pictures.wish()

    # The learning

    def _rows(self, task: Task) -> Rows:
        """The samples of a task, with the lines of the file that they come from."""
        table = self.table
        assert table is not None
        inputs, outputs = chosen_columns(table, self.columns, self._present(), self.choice["start"])
        kept = ~table.lacking([*inputs, *outputs])
        lines = np.arange(1, len(table.values) + 1) if table.lines is None else table.lines
        checking = np.zeros(len(task.x), dtype=bool)
        checking[split(len(task.x), task.checking, task.seed)[1]] = True
        return Rows(task.x, task.y, lines[kept], checking if task.checking else None)

    async def _draw(self) -> None:
        """What the best system so far makes of the samples."""
        system, rows, output = self.best, self.rows, self.output
        if system is None or rows is None:
            self.widget.update(pictures=None, points=None, residual=None)
            return
        try:
            data = await self.bench.background(data_pictures, system, rows, output)
        except (InputError, WorkError) as error:
            self.widget.update(problem={"message": str(error)})
            return
        if rows is not self.rows:
            return  # another training has begun
        points, residual = data.pop("points"), data.pop("residual")
        about = {"outputs": [v.name for v in system.outputs], "looks": self._looks()}
        self.widget.update(pictures=data, points=points, residual=residual, terms=variables(system), about=about)

    def _looks(self) -> bool:
        """Has the design the inputs that are learnt?"""
        now = [v.name for v in self._present().inputs]
        return self.best is not None and [v.name for v in self.best.inputs] == now

    async def _watch(self, process: TrainingProcess) -> None:
        while process.alive:
            await asyncio.sleep(_EVERY)
            news = process.news()
            for what, about in news:
                self._note(what, about)
            if news and self.process is process:
                self.widget.update(progress=self._progress())
        if self.process is process:
            self.process, self.begun = None, False
            await asyncio.to_thread(process.close)

    def _note(self, what: str, about: Any) -> None:
        if what == "start":
            self.start = self.best = about
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
        elif what == "problem":
            self.state = "idle"
            self.widget.update(problem={"message": about})
        elif what == "done":
            self.outcome, self.best, self.state = about, about.system, "done"
            self.widget.update(after=variables(about.system))
            self.pictures.wish()

    def close(self) -> None:
        """End the training that runs, because its page is closed."""
        self.closed, self.begun = True, False
        process, self.process = self.process, None
        if process is not None:
            process.close()

    # What the page sees

    def _present(self) -> Sugeno:
        fis: Sugeno = self.bench.document.design.in_force
        return fis

    def _changed(self) -> None:
        system = self._system()
        self.widget.update(system=system, **self._of_columns())

    def _system(self) -> dict[str, Any]:
        fis = self._present()
        return {
            "name": fis.name,
            "inputs": [v.name for v in fis.inputs],
            "outputs": [v.name for v in fis.outputs],
            "rules": len(fis.rules),
        }

    def _sources(self) -> dict[str, Any]:
        made = [[g.name, g.title, [ask._asdict() for ask in self.asked.get(g.name, ())]] for g in self.made.values()]
        return {"files": self.source.files(), "generators": made}

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

    def _show(self, table: Columns) -> None:
        self.table = table
        self.choice = {**self.choice, "skip_bad": False}
        self._guess()
        about = columns_data(table)
        self.widget.update(
            table=about, columns=self.columns, choice=self.choice, sources=self._sources(), **self._of_columns()
        )

    def _guess(self) -> None:
        if self.table is not None:
            present = self._present() if self.choice["start"] == "present" else None
            self.columns = guessed(self.table, present)
            self.widget.update(columns=self.columns)

    def _of_columns(self) -> dict[str, str]:
        """What follows from the columns: the unit of the error, if all outputs have one, and rows without numbers."""
        present, fresh = self._present(), self.choice["start"] != "present"
        units, lack = [] if fresh else [v.unit for v in present.outputs], ""
        if self.table is not None:
            with suppress(InputError):  # said when it is tried
                inputs, outputs = chosen_columns(self.table, self.columns, present, self.choice["start"])
                columns = [self.table.unit(name) for name in outputs]
                units = columns if fresh else [a or b for a, b in zip(units, columns, strict=True)]
                lack = self.table.lack([*inputs, *outputs])
        return {"unit": units[0] if len(set(units)) == 1 else "", "lack": lack}

    def _progress(self) -> dict[str, Any]:
        rows = self.history
        every = max(1, math.ceil(len(rows) / _DRAWN))
        drawn = [row for k, row in enumerate(rows) if k % every == 0 or k == len(rows) - 1]
        checked = any(_finite(row[2]) for row in rows)
        errors = [row[2 if checked else 1] for row in rows]
        best = min(range(len(rows)), key=lambda k: errors[k] if _finite(errors[k]) else math.inf) if rows else None
        return {
            "state": self.state,
            "epochs": self.choice["epochs"],
            "epoch": [row[0] for row in drawn],
            "train": [row[1] if _finite(row[1]) else None for row in drawn],
            "check": [row[2] if _finite(row[2]) else None for row in drawn] if checked else None,
            "best": None if best is None else {"epoch": rows[best][0], "error": errors[best], "checked": checked},
            "first": rows[0][2 if checked else 1] if rows and _finite(rows[0][2 if checked else 1]) else None,
            "rules": None if self.start is None else len(self.start.rules),
            "outputs": None if self.start is None else len(self.start.outputs),
            "parameters": None if self.outcome is None else self.outcome.parameters,
            "stopped": None if self.outcome is None else self.outcome.stopped,
            "unit": self.unit,
            "words": self.words,
        }


def methods() -> list[list[str]]:
    """The methods of learning as the page lists them: [name, title] each."""
    return [[name, listed.title] for name, listed in METHODS.items()]


def variables(fis: Sugeno) -> list[dict[str, Any]]:
    """The inputs of ``fis`` with their terms, in JSON's types, as the editor of membership functions takes them."""
    return [
        {
            "name": v.name,
            "unit": v.unit,
            "low": v.universe[0],
            "high": v.universe[1],
            "terms": [
                {"name": name, "type": f.matlab, "parameters": [float(p) for p in f.parameters]}
                for name, f in v.terms.items()
            ],
        }
        for v in fis.inputs
    ]


def _finite(value: float) -> bool:
    return math.isfinite(value)
