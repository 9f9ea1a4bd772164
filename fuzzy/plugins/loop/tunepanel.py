"""The designer's panel "Tune the loop": rule base and scale factors, tuned in their loop in another process."""

import time
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from fuzzy.files.fisfile import format_fis, parse_fis
from fuzzy.naming import check_known
from fuzzy.plugins.designer.longtask import Report, TaskSession
from fuzzy.plugins.designer.panel import SessionPanel
from fuzzy.plugins.loop.controller import Roles, is_controller
from fuzzy.plugins.loop.keptloop import kept_text, loop_of
from fuzzy.plugins.loop.panel import ChosenLoop
from fuzzy.plugins.loop.plant import TransferFunction
from fuzzy.plugins.loop.plantfile import read_plant
from fuzzy.plugins.loop.response import Loop
from fuzzy.plugins.loop.scheduledplant import ScheduledTransferFunction
from fuzzy.plugins.loop.tuning import DEFAULT_MOVE, LOOP_PARTS, WEIGHTS, tune_loop
from fuzzy.tuning.parameter import TuningError
from fuzzy.tuning.search import Evaluations

_MODULE = Path(__file__).parent / "static" / "tuneloop.js"
_MOST = 10_000  # evaluations
_EDIT = "tune the loop"


@dataclass(frozen=True, kw_only=True)
class LoopTask:
    """What is tuned, in which loop, and at what cost."""

    system: str  # the text of a .fis file
    plant: TransferFunction | ScheduledTransferFunction | Path
    loop: Loop
    roles: Roles
    move: tuple[str, ...]
    weights: dict[str, float]
    spread: float
    evaluations: int
    seed: int


def search_loop(task: LoopTask, report: Report) -> dict[str, Any]:
    """Tune, and tell of it as ("search", {...}); what comes of it, in JSON's types."""
    fis = parse_fis(task.system)
    plant = read_plant(task.plant, task.plant.name) if isinstance(task.plant, Path) else task.plant
    names = [v.name for v in (*fis.inputs, *fis.outputs)]

    def tell(found: Evaluations) -> bool:
        best = np.minimum.accumulate(found.costs)
        return not report("search", {"evaluations": len(found), "curve": best.tolist()})

    tuned = tune_loop(
        fis,
        plant,
        task.loop,
        roles=dict(zip(names, (*task.roles.inputs, *task.roles.outputs), strict=True)),
        move=task.move,
        weights=task.weights,
        spread=task.spread,
        evaluations=task.evaluations,
        seed=task.seed,
        progress=tell,
    )
    figures = {"before": asdict(tuned.before), "after": asdict(tuned.after)}
    return {"system": format_fis(tuned.fis), "scale": asdict(tuned.scale), **figures}


class TuneLoopSession(ChosenLoop, TaskSession):
    """The tuning of one page. Beside those of a TaskSession, its state is "searching"."""

    error = TuningError
    called = "search"

    def __init__(self, bench: Any) -> None:
        super().__init__(bench, move=[*DEFAULT_MOVE], **WEIGHTS, spread=25.0, evaluations=200, seed=1)
        self.told: dict[str, Any] = {}
        self.begun = 0.0
        self.words = ""
        self.put(_MODULE, parts=[*LOOP_PARTS], choice=self.choice, progress=self._progress())

    def _do_choose(self, message: dict[str, Any]) -> None:
        name, value = self.setting(message)
        if name == "move":
            if not isinstance(value, list) or not value:
                raise TuningError("choose what may move").about("move")
            for part in value:
                check_known(part, LOOP_PARTS, "part of a loop that can move", TuningError)
        else:
            whole = name in ("evaluations", "seed")
            most = {"evaluations": _MOST, "spread": 300, "seed": 2**31}.get(name, 1e6)
            fine = isinstance(value, (int, float)) and not isinstance(value, bool) and 0 <= value <= most
            if not fine or (whole and value != int(value)):
                raise TuningError(f"{name} must be a number from 0 to {most:g}; got {value!r}").about(name)
        self.choice = {**self.choice, name: value}
        self.widget.update(choice=self.choice)

    async def _do_start(self, _: dict[str, Any]) -> None:
        self.check_idle()
        if not self.present.rules:
            raise TuningError(f"{self.present.name} has no rule in force: there is nothing to tune")
        settings, chosen = self.kept(), self.choice
        task = LoopTask(
            system=format_fis(self.present),
            plant=self.plant(settings),
            loop=loop_of(settings),
            roles=self.roles(self.present, settings["roles"]),
            move=tuple(chosen["move"]),
            weights={name: float(chosen[name]) for name in WEIGHTS},
            spread=chosen["spread"] / 100,
            evaluations=max(1, int(chosen["evaluations"])),
            seed=int(chosen["seed"]),
        )
        self.told, self.words, self.begun = {}, "", time.monotonic()
        self.before = self.present
        await self.start(task, search_loop)

    def note(self, what: str, about: Any) -> None:
        """Take a piece of news of the search; what it found becomes one edit, unless the design is another by now."""
        super().note(what, about)
        if what == "search":
            self.state = "searching" if self.state == "starting" else self.state
            self.told |= about
        elif what == "done":
            self.told |= {"before": about["before"], "after": about["after"]}
            if self.present != self.before:
                self.words = "The design was edited meanwhile: it stays, and what was found is left."
                return
            text = kept_text({**self.kept(), **about["scale"]})
            found = replace(parse_fis(about["system"]), name=self.present.name, loop=text)
            self.bench.document.replace(found, _EDIT, keep_disabled=True)
            self.words = "It is in the design, beside the one before in the step response. Undo takes it out again."

    def _do_discard(self, _: dict[str, Any]) -> None:
        """Take out again what was found."""
        if self.bench.document.can_undo != _EDIT:
            raise TuningError("the last edit is another one: use Undo, or History")
        self.bench.document.undo()
        self.words = "The design is as it was before."
        self.tell()

    def changed(self) -> None:
        """Follow a change: whether there is something to discard."""
        self.tell()

    def _progress(self) -> dict[str, Any]:
        told = {name: self.told.get(name) for name in ("evaluations", "curve", "before", "after")}
        undecided = self.state == "done" and self.bench.document.can_undo == _EDIT
        seconds = round(time.monotonic() - self.begun) if self.runs else None
        return told | {
            "state": self.state,
            "of": self.choice["evaluations"],
            "seconds": seconds,
            "words": self.words,
            "undecided": undecided,
        }


panel = SessionPanel(
    "Tune the loop", 46, TuneLoopSession, purpose="loop", improves="through the loop", suits=is_controller
)
