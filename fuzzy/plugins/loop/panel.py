"""The designer's panel "Step response": the rule base as controller of one's own plant, beside the file's and a PID.

It follows every edit; the loops are simulated in another process. What is chosen belongs to the design: each choice is
an edit, kept in ``Sugeno.loop``. A Python file of the folder is run once it was chosen here, within a time limit; of
one that a design brings with it the page says so.
"""

import asyncio
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any
from weakref import WeakKeyDictionary

from fuzzy.errors import InputError
from fuzzy.naming import check_known
from fuzzy.plugins.designer.folder import check_size
from fuzzy.plugins.designer.latest import Latest
from fuzzy.plugins.designer.panel import SessionPanel, head_start
from fuzzy.plugins.designer.saving import save_text
from fuzzy.plugins.designer.session import PanelSession, refusal_of
from fuzzy.plugins.designer.views import variable_data
from fuzzy.plugins.designer.workers import WorkError
from fuzzy.plugins.loop.controller import (
    INPUT_ROLES,
    OUTPUT_ROLES,
    PID,
    LoopError,
    Roles,
    Scale,
    is_controller,
    role_of,
    roles_of,
)
from fuzzy.plugins.loop.keptloop import (
    FACTORS,
    check_setting,
    design_settings,
    example_settings,
    kept_settings,
    kept_text,
    loop_of,
    pid_of,
    transfer_of,
)
from fuzzy.plugins.loop.plant import TransferFunction
from fuzzy.plugins.loop.plantfile import PLANT_EXAMPLES, TEMPLATE
from fuzzy.plugins.loop.response import TITLES
from fuzzy.plugins.loop.scheduledplant import ScheduledTransferFunction
from fuzzy.plugins.loop.steptask import StepTask, begun, controller_zip, read_saved, simulated
from fuzzy.shown import typeset
from fuzzy.system import Sugeno

_MODULE = Path(__file__).parent / "static" / "step.js"
_TEMPLATE_FILE = "plant.py"
NEARLY = 1e-3  # of the outputs' greatest: rules that differ less from their plane are the PID


class ChosenLoop:
    """What of a panel's session knows the loop of the design: plant, roles and settings."""

    bench: Any
    folder: Any
    present: Sugeno

    def kept(self) -> dict[str, Any]:
        """The settings of the loop: those that the design keeps, else of an example. Raises LoopError."""
        return design_settings(self.present)

    def roles(self, fis: Sugeno, chosen: Mapping[str, str]) -> Roles:
        """What the variables are, by choice or by name. Raises LoopError."""
        names = {v.name for v in (*fis.inputs, *fis.outputs)}
        return roles_of(fis, {name: role for name, role in chosen.items() if name in names and role})

    def plant(self, settings: Mapping[str, Any]) -> TransferFunction | ScheduledTransferFunction | Path:
        """The plant, or its file, which may be a Python file only where it was chosen here. Raises LoopError."""
        source = settings["source"]
        if not source:
            return transfer_of(settings)
        if Path(source).suffix == ".py" and source not in chosen_here(self.bench.document):
            raise LoopError(
                f"the design brings {source} with it as its plant, a Python file: it runs when you choose it here"
            ).about("source")
        check_size(path := self.folder.inside(source, Path(source).suffix), source)
        return Path(path)


class StepSession(ChosenLoop, PanelSession):
    """The step response of one page: what it has chosen, and what came of it."""

    error = LoopError
    refusals = (*PanelSession.refusals, OSError)

    def __init__(self, bench: Any) -> None:
        super().__init__(bench)
        self.before: Sugeno | None = None
        self.view: dict[str, Any] = {"rival": True, "before": True, "shown": "time"}
        self.unread: LoopError | None = None
        self.choice = self._chosen()
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
        if name in self.view:
            if type(value) is not type(self.view[name]):
                raise LoopError(f"{name} cannot be {value!r}").about(name)
            self.view[name] = value
            self.simulate()
            return
        check_setting(name, value)
        if name == "source":
            files = self._files()
            self.widget.update(files=files)
            if value != "":
                self._trust(check_known(value, files, "plant", LoopError))
        self._keep({name: value}, f"{name.replace('_', ' ')} {value}")

    def _do_example(self, message: dict[str, Any]) -> None:
        name = check_known(message.get("value"), PLANT_EXAMPLES, "example", LoopError)
        self._keep(example_settings(name), f"example {name}")

    def _do_role(self, message: dict[str, Any]) -> None:
        name, role = message.get("variable"), message.get("value")
        variables = [v.name for v in (*self.present.inputs, *self.present.outputs)]
        if name not in variables or (role != "" and role not in (*INPUT_ROLES, *OUTPUT_ROLES)):
            raise LoopError(f"{name!r} cannot be {role!r}")
        roles = {v: r for v, r in self._chosen()["roles"].items() if v in variables}
        self._keep({"roles": {**roles, name: role}}, f"{name} is {role or 'nothing'}")

    def _do_template(self, _: dict[str, Any]) -> None:
        """Write the file of a plant to begin with into the folder, and choose it."""
        path = self.folder.inside(_TEMPLATE_FILE, ".py")
        save_text(path, TEMPLATE, None, own=False)
        self._trust(_TEMPLATE_FILE)
        self.widget.update(files=self._files())
        self._keep({"source": _TEMPLATE_FILE}, f"plant {_TEMPLATE_FILE}")

    async def _do_pid(self, _: dict[str, Any]) -> None:
        """Take the scale factors with which the rules act as the PID does."""
        factors, deviation, rules = await self._asked(begun)
        if rules is not None:
            text = kept_text({**self._chosen(), **factors})
            self.bench.document.replace(replace(rules, loop=text), "rules of the PIDs")
            return
        self._keep(factors, "scale factors of the PID")
        if deviation > NEARLY:
            said = f"the rules are not linear: they differ from the PID by up to {100 * deviation:.2g} %"
            self.bench.notify(said)
        elif "du" in self.roles(self.present, self._chosen()["roles"]).outputs:
            self.bench.notify(
                "disturbances are answered as by the PID; at the step du begins at rest, without its jump"
            )

    async def _do_code(self, _: dict[str, Any]) -> None:
        """Give the whole controller in C: the rules, and the loop round them."""
        stem = self.bench.document.path.stem
        self.bench.give(await self._asked(controller_zip, self.present.name), f"{stem}-controller-c.zip")
        self.bench.notify(f"{stem}-controller-c.zip is written; `fuzzy step --c` proves it")

    async def _asked(self, function: Any, *more: Any) -> Any:
        """What a worker's ``function`` makes of the loop."""
        task = self._task()
        if isinstance(task.plant, Path):
            return await self.bench.read(task.name, function, task, *more)
        return await self.bench.background(function, task, *more)

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

    def _chosen(self) -> dict[str, Any]:
        """What is chosen: the loop of the design, and what the page shows beside it."""
        try:
            settings, self.unread = self.kept(), None
        except LoopError as error:
            settings, self.unread = kept_settings("{}"), error
        return {**settings, **self.view}

    def _keep(self, settings: Mapping[str, Any], what: str) -> None:
        """Make a choice an edit of the design; ``what`` it is called."""
        self.widget.forget("choice")  # with an undo right behind it the loop is as it was, and the field is not
        before, text = self.present, kept_text({**self._chosen(), **settings})
        self.bench.document.apply({"edit": "loop", "text": text, "what": what[:100]})
        if self.present == before:  # no edit: what was refused before is forgotten all the same
            self.simulate()

    def _trust(self, source: str) -> None:
        """Remember that a file was chosen here, and may run."""
        chosen_here(self.bench.document).add(source)

    def simulate(self) -> None:
        """Simulate what is chosen; what is asked for meanwhile comes after it, once."""
        self.shown, self.choice = self.present, self._chosen()
        self.widget.update(choice=self.choice, system=self._system())
        self.loops.wish()

    async def _simulate(self) -> None:
        if self.bench.closed:
            return
        try:
            self.answer = await self._asked(simulated)
            self.widget.update(response=self.answer, problem=None)
        except (InputError, WorkError) as error:
            self.answer = None
            self.refuse(error, {})
            self.widget.update(response=None)

    def _task(self) -> StepTask:
        chosen, fis = self._chosen(), self.present
        roles = self.roles(fis, chosen["roles"])
        if not fis.rules:
            raise LoopError(f"{fis.name} has no rule in force: nothing is controlled")
        if self.unread:
            raise self.unread
        plant = self.plant(chosen)
        loop = loop_of(chosen)
        before: tuple[Sugeno, Roles, Scale] | None = None
        if self.before is not None and chosen["before"]:
            with suppress(LoopError):
                factors = {name: design_settings(self.before)[name] for name in FACTORS}
                scale = loop_of({**chosen, **factors}).scale
                before = self.before, self.roles(self.before, chosen["roles"]), scale
                if replace(self.before, loop=fis.loop) == fis and scale == loop.scale:
                    before = None
        rival: PID | bool = (pid_of(chosen) or True) if chosen["rival"] else False
        return StepTask(plant, chosen["source"], loop, fis, roles, before, rival, chosen["shown"])

    # What the page sees

    async def _open(self) -> None:
        document = self.bench.document
        if document.saved:
            self.before = self.present
        else:
            saved = await self.bench.read(document.path.name, read_saved, document.path)
            self.before = saved or document.begin
        self.simulate()

    def changed(self) -> Any:
        """Simulate the loop anew, unless only another point is looked at; the page waits a little for what it gives."""
        if self.bench.document.saved and self.before is not self.present:
            self.before = self.present
        elif self.shown == self.present:
            self.widget.update(choice=self.choice)
            return None  # only another look at it, or an edit that is undone again
        self.simulate()
        return head_start(self.loops.task)

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


_CHOSEN: "WeakKeyDictionary[Any, set[str]]" = WeakKeyDictionary()


def chosen_here(document: Any) -> set[str]:
    """The plants that were chosen for a document since it was opened."""
    return _CHOSEN.setdefault(document, set())


panel = SessionPanel("Step response", 45, StepSession, purpose="loop", suits=is_controller)
