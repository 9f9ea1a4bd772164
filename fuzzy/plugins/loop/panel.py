"""The designer's panel "Step response": the rule base as controller of one's own plant, beside the file's and a PID.

It follows every edit; the loops are simulated in another process. A Python file of the folder is run once it was
chosen, within a time limit.
"""

import asyncio
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from fuzzy.errors import InputError
from fuzzy.naming import check_known, expected
from fuzzy.plugins.designer.folder import check_size
from fuzzy.plugins.designer.latest import Latest
from fuzzy.plugins.designer.panel import SessionPanel
from fuzzy.plugins.designer.saving import save_text
from fuzzy.plugins.designer.session import PanelSession, refusal_of
from fuzzy.plugins.designer.views import variable_data
from fuzzy.plugins.designer.workers import WorkError
from fuzzy.plugins.loop.controller import INPUT_ROLES, OUTPUT_ROLES, PID, LoopError, Roles, Scale, role_of, roles_of
from fuzzy.plugins.loop.plant import TransferFunction
from fuzzy.plugins.loop.plantfile import PLANT_EXAMPLES, TEMPLATE, numbers_of
from fuzzy.plugins.loop.response import STEPS, TITLES, Loop
from fuzzy.plugins.loop.steptask import StepTask, read_saved, simulated
from fuzzy.shown import typeset
from fuzzy.system import Sugeno

_MODULE = Path(__file__).parent / "static" / "step.js"
_FACTORS = ("Ke", "Kde", "Kie", "Ku", "Kdu")
_TEXTS = ("numerator", "denominator")
_NUMBERS = (
    *("dead_time", "reference", "duration", "sample_time", "disturbance_time", "disturbance", "noise", "rate_filter"),
    *("low", "high"),  # None: no limit
    *_FACTORS,
    *("Kp", "Ki", "Kd"),  # None: by a rule
)
_MAY_LACK = ("low", "high", "Kp", "Ki", "Kd")
_TEMPLATE_FILE = "plant.py"


def chosen_example(name: str) -> dict[str, Any]:
    """The settings that an example makes, by their names."""
    example = PLANT_EXAMPLES[name]
    numerator, denominator = (
        " ".join(f"{c:g}" for c in row) for row in (example.plant.numerator, example.plant.denominator)
    )
    return {
        "example": name, "source": "", "numerator": numerator, "denominator": denominator,
        "dead_time": example.plant.dead_time, "duration": example.duration, "sample_time": example.duration / STEPS,
        "disturbance_time": example.disturbance[0], "disturbance": example.disturbance[1],
        "low": example.limits[0], "high": example.limits[1], **dict(zip(_FACTORS, example.scale, strict=True)),
        "Kp": None, "Ki": None, "Kd": None,
    }  # fmt: skip


class StepSession(PanelSession):
    """The step response of one page: what it has chosen, and what came of it."""

    error = LoopError
    refusals = (*PanelSession.refusals, OSError)

    def __init__(self, bench: Any) -> None:
        super().__init__(bench)
        self.before: Sugeno | None = None
        names = [v.name for v in self.present.outputs]
        direct = any(role_of(name) == "u" for name in names)
        self.choice = {
            **chosen_example("integrating" if direct and len(names) == 1 else "lag"),
            "reference": 1.0, "noise": 0.0, "rate_filter": 0.0, "rival": True, "before": True, "roles": {},
        }  # fmt: skip
        self.answer: dict[str, Any] | None = None
        self.loops = Latest(self._simulate)
        self.shown = self.present  # the system that is simulated
        self.put(
            _MODULE,
            choice=self.choice,
            examples=[[name, example.title] for name, example in PLANT_EXAMPLES.items()],
            files=self._files(),
            titles=[[name, *about] for name, about in TITLES.items()],
            accepted={"inputs": list(INPUT_ROLES), "outputs": list(OUTPUT_ROLES)},
            template=_TEMPLATE_FILE,
            system=self._system(),
            response=None,
        )
        self.opening = asyncio.get_running_loop().create_task(self._open())

    # Messages

    def begin(self) -> None:
        """Leave what was refused on the page until the loop is simulated."""

    def refuse(self, error: Exception, message: Mapping[str, Any]) -> None:
        """Say on the page why no loop is simulated."""
        told = refusal_of(error, message)
        self.widget.update(problem=told | {"message": typeset(told["message"])})

    def _do_choose(self, message: dict[str, Any]) -> None:
        name, value = self.setting(message)
        if name == "source":
            files = self._files()
            self.widget.update(files=files)
            if value != "":
                check_known(value, files, "plant", LoopError)
        elif name in _TEXTS:
            if not isinstance(value, str) or len(value) > 500:
                raise LoopError(f"{name} must be numbers with blanks between").about(name)
        elif name in _NUMBERS:
            lacks = value is None and name in _MAY_LACK
            if not lacks and (
                isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value)
            ):
                raise LoopError(f"{name} must be a number, got {value!r}").about(name)
        elif name not in ("rival", "before") or not isinstance(value, bool):
            raise LoopError(expected(name, self.choice, "setting"))
        self.choice = {**self.choice, name: value}
        self.simulate()

    def _do_example(self, message: dict[str, Any]) -> None:
        name = message.get("value")
        name = check_known(name, PLANT_EXAMPLES, "example", LoopError)
        self.choice = {**self.choice, **chosen_example(name)}
        self.simulate()

    def _do_role(self, message: dict[str, Any]) -> None:
        name, role = message.get("variable"), message.get("value")
        variables = [v.name for v in (*self.present.inputs, *self.present.outputs)]
        if name not in variables or (role != "" and role not in (*INPUT_ROLES, *OUTPUT_ROLES)):
            raise LoopError(f"{name!r} cannot be {role!r}")
        self.choice = {**self.choice, "roles": {**self.choice["roles"], name: role}}
        self.simulate()

    def _do_template(self, _: dict[str, Any]) -> None:
        """Write the file of a plant to begin with into the folder, and choose it."""
        path = self.folder.inside(_TEMPLATE_FILE, ".py")
        save_text(path, TEMPLATE, None, own=False)
        self.choice = {**self.choice, "source": _TEMPLATE_FILE}
        self.widget.update(files=self._files())
        self.simulate()

    def _do_look(self, message: dict[str, Any]) -> None:
        """Look at what the controller knew in a sample."""
        known, k = (self.answer or {}).get("known") or [], message.get("sample")
        inputs = self.present.inputs
        if not isinstance(k, int) or len(known) != len(inputs) or not 0 <= k < len(known[0]):
            return
        point = [column[k] for column in known]
        if None not in point:
            ends = [v.universe for v in inputs]
            self.bench.look_at([min(max(x, low), high) for x, (low, high) in zip(point, ends, strict=True)])

    # The loop

    def simulate(self) -> None:
        """Simulate what is chosen; what is asked for meanwhile comes after it, once."""
        self.shown = self.present
        self.widget.update(choice=self.choice, system=self._system())
        self.loops.wish()

    async def _simulate(self) -> None:
        if self.bench.closed:
            return
        try:
            task = self._task()
            if isinstance(task.plant, Path):
                self.answer = await self.bench.read(task.name, simulated, task)
            else:
                self.answer = await self.bench.background(simulated, task)
            self.widget.update(response=self.answer, problem=None)
        except (InputError, WorkError) as error:
            self.answer = None
            self.refuse(error, {})
            self.widget.update(response=None)

    def _task(self) -> StepTask:
        chosen, fis = self.choice, self.present
        roles = self._roles(fis)
        if not fis.rules:
            raise LoopError(f"{fis.name} has no rule in force: nothing is controlled")
        plant: TransferFunction | Path
        if chosen["source"]:
            plant = self.folder.inside(chosen["source"], Path(chosen["source"]).suffix)
            check_size(plant, chosen["source"])
        else:
            rows = [numbers_of(chosen[name], name) for name in _TEXTS]
            plant = TransferFunction(rows[0], rows[1], chosen["dead_time"])
        settings: dict[str, Any] = {name: float(chosen[name]) for name in _NUMBERS[:8] if name != "dead_time"}
        loop = Loop(
            **settings,
            low=-math.inf if chosen["low"] is None else chosen["low"],
            high=math.inf if chosen["high"] is None else chosen["high"],
            scale=Scale(*(float(chosen[name]) for name in _FACTORS)),
        )
        before, before_roles = self.before if chosen["before"] and self.before != fis else None, None
        if before is not None:
            try:
                before_roles = self._roles(before)
            except LoopError:
                before = None
        gains = [chosen[name] for name in ("Kp", "Ki", "Kd")]
        given = any(gain is not None for gain in gains)
        rival = PID(*(float(gain or 0.0) for gain in gains)) if given else True
        return StepTask(
            plant, chosen["source"], loop, fis, roles, before, before_roles, rival if chosen["rival"] else False
        )

    def _roles(self, fis: Sugeno) -> Roles:
        names = {v.name for v in (*fis.inputs, *fis.outputs)}
        return roles_of(fis, {name: role for name, role in self.choice["roles"].items() if name in names and role})

    # What the page sees

    async def _open(self) -> None:
        document = self.bench.document
        if document.saved:
            self.before = self.present
        else:
            self.before = await self.bench.read(document.path.name, read_saved, document.path)
        self.simulate()

    def changed(self) -> None:
        """Simulate the loop anew, unless only another point is looked at."""
        if self.bench.document.saved and self.before is not self.present:
            self.before = self.present
        elif self.shown == self.present:
            return  # only another look at it
        self.simulate()

    def close(self) -> None:
        """Simulate no more."""
        for task in (self.loops.task, self.opening):
            if task is not None:
                task.cancel()

    def _system(self) -> dict[str, Any]:
        """The variables, with what each is to the loop: by choice, by its name, or "" for nothing."""
        fis, chosen = self.present, self.choice["roles"]
        return {
            kind: [
                {**variable_data(v), "terms": [], "role": chosen.get(v.name) or role_of(v.name) or ""} for v in group
            ]
            for kind, group in (("inputs", fis.inputs), ("outputs", fis.outputs))
        }

    def _files(self) -> list[str]:
        """The plants of the folder: .py files, and .toml files that may be one."""
        return [*self.folder.files(".py"), *self.folder.files(".toml")]


panel = SessionPanel("Step response", 45, StepSession)
