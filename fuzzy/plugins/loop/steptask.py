"""What the panel "Step response" asks a worker: a plant, a loop and some controllers; the answer is JSON's types."""

from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from fuzzy.errors import InputError
from fuzzy.plugins.designer.views import numbers
from fuzzy.plugins.loop.controller import PID, LoopError, Roles, Scale
from fuzzy.plugins.loop.plant import FunctionPlant, TransferFunction
from fuzzy.plugins.loop.plantfile import Plant, read_plant
from fuzzy.plugins.loop.response import Loop, StepResponse, clipping, respond
from fuzzy.plugins.loop.rival import tuned_pid
from fuzzy.plugins.loop.scheduledplant import ScheduledTransferFunction, operating_points
from fuzzy.plugins.loop.scheduledrules import along_points, loop_at, pid_over_points, pids_of, schedule_from_pids
from fuzzy.shown import typeset
from fuzzy.system import Sugeno

_DRAWN = 1000  # samples that are sent, at most


@dataclass(frozen=True)
class StepTask:
    """A loop for the design, the design of the file (None: none) and a rival, where one is wished for."""

    plant: TransferFunction | ScheduledTransferFunction | Path  # a file is read, and a Python file run
    name: str  # of the file, for messages
    loop: Loop
    design: Sugeno
    roles: Roles
    before: tuple[Sugeno, Roles, Scale] | None  # another design, by its own scale factors
    rival: PID | bool  # True: by a rule from the transfer function; False: none
    shown: str = "time"  # of operating points: the way of their variable, all "points", or the value of one


def simulated(task: StepTask) -> dict[str, Any]:
    """Simulate the loops of a task.

    Returns: ``time`` and ``reference``, and of each controller in ``rows`` its name, arrays, figures and, where it was
    stopped, why; ``rival``, the PID's gains, ``words`` on a rival that is missing.

    Raises PlantError, LoopError for what makes no loop.
    """
    plant = read_plant(task.plant, task.name) if isinstance(task.plant, Path) else task.plant
    points, task = operating_points(plant), _placed(task, plant)
    if points and task.shown == "points":
        rows = [(f"at {v:g}", respond(task.design, plant, loop_at(task.loop, v), task.roles)) for v in points]
        task = replace(task, before=None, rival=False)
    else:
        rows = [("design", respond(task.design, plant, task.loop, task.roles))]
    now = rows[0][1]
    # A drag changes neither the file's design nor the PID; of a function the plant may be another one.
    same = respond if isinstance(plant, FunctionPlant) else _unchanged
    if task.before is not None:
        fis, roles, scale = task.before
        rows.append(("file", same(fis, plant, replace(task.loop, scale=scale), roles)))
    words, rival = " ".join(map(typeset, clipping(task.design, now, task.roles))), None
    try:
        rival = _rival(task, plant)
        if rival is not None:
            rows.append(("pid", same(rival, plant, task.loop)))
    except LoopError as error:
        words += typeset(f" No PID is drawn: {error}.")
    every = -(-len(now.time) // _DRAWN)
    return {
        "time": now.time[::every].tolist(),
        "reference": task.loop.reference,
        "disturbed": task.loop.disturbed * task.loop.period if task.loop.disturbed <= task.loop.steps else None,
        "points": [f"{value:g}" for value in points],
        "operating": numbers(now.operating[::every]) if points and task.shown != "points" else None,
        "rows": [_row(name, done, every) for name, done in rows],
        "known": [_drawn(column) for column in now.known[::every].T],
        "rival": None if rival is None else asdict(rival),
        "words": words.strip(),
    }


def _placed(task: StepTask, plant: Plant) -> StepTask:
    """The task at the operating point that is shown, or as the operating variable moves: by default over all points."""
    points, loop = operating_points(plant), task.loop
    there = next((value for value in points if f"{value:g}" == task.shown), None)
    if there is not None:
        loop = loop_at(loop, there)
    return replace(task, loop=along_points(plant, loop))


def begun(task: StepTask) -> tuple[dict[str, float], float, Sugeno | None]:
    """The scale factors with which the design of a task acts as its PID does, how far its rules are from it, and the
    rules of a scheduled one, which are the PID of each operating point.

    Raises PlantError, LoopError.
    """
    from fuzzy.plugins.loop.equivalent import scale_from_pid

    plant = read_plant(task.plant, task.name) if isinstance(task.plant, Path) else task.plant
    task = _placed(replace(task, rival=task.rival or True, shown="time"), plant)
    roles = {v.name: r for v, r in zip(task.design.inputs, task.roles.inputs, strict=True)}
    roles |= {v.name: r for v, r in zip(task.design.outputs, task.roles.outputs, strict=True)}
    if "scheduling" in task.roles.inputs:
        return asdict(Scale()), 0.0, schedule_from_pids(task.design, plant, task.loop, roles)
    pid = _rival(task, plant)
    assert pid is not None
    scale, deviation = scale_from_pid(task.design, pid, plant, task.loop, roles)
    return asdict(scale), deviation, None


def controller_zip(task: StepTask, name: str) -> bytes:
    """The design of a task, with the loop round it, as C in a zip. Raises ExportError, LoopError."""
    from fuzzy.plugins.ccode.writing import zipped
    from fuzzy.plugins.loop.controllercode import controller_code

    return zipped(controller_code(task.design, task.loop, task.roles, name).texts)


_tuned, _unchanged = lru_cache(maxsize=4)(tuned_pid), lru_cache(maxsize=4)(respond)
_best = lru_cache(maxsize=4)(pid_over_points)


def _rival(task: StepTask, plant: Plant) -> PID | None:
    if task.rival is not True:
        return task.rival or None
    if points := operating_points(plant):
        if task.loop.operating is not None and task.shown in [f"{value:g}" for value in points]:
            return pids_of(plant, task.loop.period)[task.loop.operating(0.0)]
        if isinstance(plant, FunctionPlant):
            raise LoopError("of a Python plant no PID for all operating points is looked for: give its gains")
        return _best(plant, task.loop)
    if not isinstance(plant, TransferFunction):
        raise LoopError("the rules for a PID need a transfer function: give its gains")
    return _tuned(plant, task.loop.period)


def _drawn(values: np.ndarray) -> list[Any]:
    """Seven digits of each number: these are copied, too, and not only drawn."""
    size = np.where(np.isfinite(values) & (values != 0), np.abs(values), 1.0)
    scale = 10.0 ** (6 - np.floor(np.log10(size)))
    return numbers(np.round(values * scale) / scale)


def _row(name: str, done: StepResponse, every: int) -> dict[str, Any]:
    return {
        "name": name,
        "output": _drawn(done.output[::every]),
        "control": _drawn(done.control[::every]),
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
