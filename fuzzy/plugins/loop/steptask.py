"""What the panel "Step response" asks a worker: a plant, a loop and some controllers; the answer is JSON's types."""

from dataclasses import asdict, dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from fuzzy.errors import InputError
from fuzzy.plugins.designer.views import numbers
from fuzzy.plugins.loop.controller import PID, LoopError, Roles
from fuzzy.plugins.loop.plant import FunctionPlant, TransferFunction
from fuzzy.plugins.loop.plantfile import read_plant
from fuzzy.plugins.loop.response import Loop, StepResponse, respond
from fuzzy.plugins.loop.rival import tuned_pid
from fuzzy.shown import typeset
from fuzzy.system import Sugeno

_DRAWN = 1000  # samples that are sent, at most


@dataclass(frozen=True)
class StepTask:
    """A loop for the design, the design of the file (None: none) and a rival, where one is wished for."""

    plant: TransferFunction | Path  # a file is read, and a Python file run
    name: str  # of the file, for messages
    loop: Loop
    design: Sugeno
    roles: Roles
    before: Sugeno | None
    before_roles: Roles | None
    rival: PID | bool  # True: by a rule from the transfer function; False: none


def simulated(task: StepTask) -> dict[str, Any]:
    """Simulate the loops of a task.

    Returns: ``time`` and ``reference``, and of each controller in ``rows`` its name, arrays, figures and, where it was
    stopped, why; ``rival``, the PID's gains, ``words`` on a rival that is missing.

    Raises PlantError, LoopError for what makes no loop.
    """
    plant = read_plant(task.plant, task.name) if isinstance(task.plant, Path) else task.plant
    now = respond(task.design, plant, task.loop, task.roles)
    rows = [("design", now)]
    if task.before is not None:
        rows.append(("file", respond(task.before, plant, task.loop, task.before_roles)))
    words, rival = "", None
    try:
        rival = _rival(task, plant)
        if rival is not None:
            same = isinstance(plant, TransferFunction)  # a drag changes neither: a function may be another one
            rows.append(("pid", (_pid_response if same else respond)(rival, plant, task.loop)))
    except LoopError as error:
        words = typeset(f"No PID is drawn: {error}.")
    every = -(-len(now.time) // _DRAWN)
    return {
        "time": now.time[::every].tolist(),
        "reference": task.loop.reference,
        "disturbed": task.loop.disturbed * task.loop.period if task.loop.disturbed <= task.loop.steps else None,
        "rows": [_row(name, done, every) for name, done in rows],
        "known": numbers(now.known[::every].T),
        "rival": None if rival is None else asdict(rival),
        "words": words,
    }


_tuned, _pid_response = lru_cache(maxsize=4)(tuned_pid), lru_cache(maxsize=4)(respond)


def _rival(task: StepTask, plant: TransferFunction | FunctionPlant) -> PID | None:
    if task.rival is not True:
        return task.rival or None
    if not isinstance(plant, TransferFunction):
        raise LoopError("the rules for a PID need a transfer function: give its gains")
    return _tuned(plant, task.loop.period)


def _row(name: str, done: StepResponse, every: int) -> dict[str, Any]:
    return {
        "name": name,
        "output": numbers(done.output[::every]),
        "control": numbers(done.control[::every]),
        "figures": asdict(done.figures),
        "stopped": typeset(done.stopped),
    }


def read_saved(path: Path) -> Sugeno | None:
    """The system in a file, None where it holds none that can be compared with."""
    from fuzzy.files.fisfile import read_fis

    try:
        return read_fis(path)
    except (InputError, OSError):
        return None
