"""Gain scheduling by rules: at each operating point the rule base is the PID of that point.

There is one rule for each point, "if flow is at_2 then u is at_2", whose consequent is linear: the PID's. The terms of
the operating variable are triangles that add up to 1, so that between two points the PIDs are blended by memberships:
the local controllers of T. A. Johansen and R. Murray-Smith, "The operating regime approach to nonlinear modelling and
control", in Multiple Model Approaches to Modelling and Control (1997), chapter 1. Where the output is a rate that the
loop integrates, u does not jump as the integral gain changes (I. Kaminer et al., "A velocity algorithm for the
implementation of gain-scheduled controllers", Automatica 31, 1995, pp. 1185-1191).
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from fuzzy.membership import LinearS, LinearZ, Triangle
from fuzzy.plugins.loop.controller import PID, LoopError, Roles, Scale, roles_of
from fuzzy.plugins.loop.plant import TransferFunction
from fuzzy.plugins.loop.response import Loop, StepResponse, respond
from fuzzy.plugins.loop.rival import tuned_pid
from fuzzy.plugins.loop.scheduledplant import Course, operating_points
from fuzzy.rule import Clause, Rule
from fuzzy.system import Linear, Sugeno

_ROOM = 1.25  # of the greatest signal in the PIDs' loops: the universe


def loop_at(loop: Loop, value: float) -> Loop:
    """The loop at one value of the operating variable."""
    return replace(loop, operating=Course.of(value))


def along_points(plant: Any, loop: Loop) -> Loop:
    """The loop as the operating variable of a plant moves: where nothing says how, by a ramp over its points."""
    points = operating_points(plant)
    if not points or loop.operating is not None:
        return loop
    return replace(loop, operating=Course.over(points, loop.duration))


def pids_of(plant: Any, sample_time: float) -> dict[float, PID]:
    """The PID at each operating point of a plant: its gains there, or those by a rule. Raises LoopError."""
    found = {}
    for value, gains in zip(operating_points(plant), plant.gains, strict=True):
        if not gains and not isinstance(plant.at(value), TransferFunction):
            raise LoopError("the rules for a PID need a transfer function: give the gains at each operating point")
        found[value] = PID(*gains) if gains else tuned_pid(plant.at(value), sample_time)
    return found


def pid_over_points(plant: Any, loop: Loop) -> PID:
    """Of the PIDs of the operating points the one that does best at all: the least sum of ISE / ISE of the own PID.

    Args:
        plant: A plant with operating points.
        loop: What happens to it.

    Returns:
        The PID.

    Raises:
        LoopError: A point without a PID, or none that holds the loop at all points.
    """
    pids = pids_of(plant, loop.period)

    def ise(pid: PID, value: float) -> float:
        found = respond(pid, plant, loop_at(loop, value)).figures.ise
        return math.inf if found is None else found

    sums = {pid: math.fsum(ise(pid, v) / max(ise(own, v), 1e-300) for v, own in pids.items()) for pid in pids.values()}
    best = min(sums, key=sums.__getitem__)
    if not math.isfinite(sums[best]):
        raise LoopError("none of the PIDs of the operating points holds the loop at all of them")
    return replace(best, rule=f"{best.rule}, best over all points".lstrip(", "))


def ruled_pid(plant: Any, loop: Loop) -> PID:
    """The PID by a published rule for a plant, of one with operating points the best for all. Raises LoopError."""
    if operating_points(plant):
        return pid_over_points(plant, loop)
    if not isinstance(plant, TransferFunction):
        raise LoopError("the rules for a PID need a transfer function: give its gains")
    return tuned_pid(plant, loop.period)


def schedule_from_pids(
    fis: Sugeno, plant: Any, loop: Loop | None = None, roles: Mapping[str, str] | None = None
) -> Sugeno:
    """The rules with which ``fis`` is, at each operating point of ``plant``, the PID of that point, by scale factors 1.

    With the input error_sum it is the PID itself, at its limits too; with the outputs u and du the integral is of du,
    which away from limits is the same and does not jump as its gain changes; with du alone the proportional part is the
    integral of the error's rate.

    Args:
        fis: Its variables are taken: an input with the role "scheduling", the error and what the gains need. Terms and
            rules are made anew, universes as wide as the PIDs' loops need them.
        plant: A ScheduledTransferFunction, or a FunctionPlant with operating points.
        loop: What happens to it.
        roles: What variables are, by their names, where those do not say it.

    Raises:
        LoopError: Variables that lack what a gain needs, fewer than two points, or a point without a PID.
    """
    loop = replace(Loop() if loop is None else loop, scale=Scale())
    known, pids = roles_of(fis, roles), pids_of(plant, loop.period)
    if "scheduling" not in known.inputs or len(pids) < 2:
        raise LoopError(
            f"{fis.name}: gains are scheduled by an input with the role scheduling, over two points or more"
        )
    gains = {value: _gains(fis, known, pid) for value, pid in pids.items()}
    runs = [respond(pid, plant, loop_at(loop, value)) for value, pid in pids.items()]
    names = [f"at_{value:g}".replace("-", "minus_").replace("+", "") for value in pids]
    points = [*pids]
    terms = [LinearZ(*points[:2]), *(map(Triangle, points, points[1:], points[2:])), LinearS(*points[-2:])]
    inputs = []
    for variable, role in zip(fis.inputs, known.inputs, strict=True):
        if role == "scheduling":
            ends = (min(variable.universe[0], points[0]), max(variable.universe[1], points[-1]))
            inputs.append(replace(variable, universe=ends, terms=dict(zip(names, terms, strict=True))))
        else:
            reach = _wide(max(_greatest(done, role) for done in runs))
            inputs.append(replace(variable, universe=(-reach, reach), terms={}))
    outputs = []
    for variable, output in zip(fis.outputs, known.outputs, strict=True):
        rows = {value: [gains[value].get((output, role), 0.0) for role in known.inputs] for value in points}
        reach = _wide(max(abs(g) * v.universe[1] for row in rows.values() for g, v in zip(row, inputs, strict=True)))
        consequents = {name: Linear(rows[value], 0.0) for name, value in zip(names, points, strict=True)}
        outputs.append(replace(variable, universe=(-reach, reach), terms=consequents))
    scheduling = inputs[known.inputs.index("scheduling")].name
    rules = [Rule((Clause(scheduling, name),), tuple((v.name, name) for v in outputs)) for name in names]
    return replace(fis, inputs=inputs, outputs=outputs, rules=rules, out_of_range="ignore", defuzzification="wtaver")


def _gains(fis: Sugeno, roles: Roles, pid: PID) -> dict[tuple[str, str], float]:
    """What each output gives of each input, by their roles."""
    has, outputs = set(roles.inputs), set(roles.outputs)
    if "u" not in outputs:
        found = {("du", "error_rate"): pid.Kp, ("du", "error"): pid.Ki}
        lacks = pid.Kd != 0
    else:
        integral = ("du", "error") if "du" in outputs else ("u", "error_sum")
        found = {("u", "error"): pid.Kp, ("u", "error_rate"): pid.Kd, integral: pid.Ki}
        lacks = False
    if lacks or any(gain and not {*pair} <= has | outputs for pair, gain in found.items()):
        raise LoopError(
            f"{fis.name} cannot act as Kp {pid.Kp:g}, Ki {pid.Ki:g}, Kd {pid.Kd:g}: that takes the input error and the "
            "output u, for Ki an output du or the input error_sum, for Kd the input error_rate"
        )
    return found


def _greatest(done: StepResponse, role: str) -> float:
    found = np.abs(getattr(done, role))
    return float(np.nanmax(found)) if np.isfinite(found).any() else 0.0


def _wide(size: float) -> float:
    """A universe's end: room beyond a size, in two digits."""
    return float(f"{_ROOM * size:.1e}") or 1.0
