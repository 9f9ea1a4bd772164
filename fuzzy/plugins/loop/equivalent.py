"""A rule base that begins where a PID stands: scale factors with which it acts as the PID does.

About the middle of its universes a rule base is linear, u = Ku (a Ke e + b Kde de/dt + c Kie ∫e), and likewise the
rate du. The slopes a, b, c are those of the rules; the factors follow from the PID's gains (J. Jantzen, "Foundations of
Fuzzy Control", 2nd ed., Wiley 2013, chapter 4: a fuzzy controller replaces a PID first, and is made nonlinear then).

What du gives is integrated from rest, so its proportional part answers to changes and not to the jump of the reference
at t = 0: there it acts as a PID whose proportional part sees the output alone. Disturbances are answered alike.
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from fuzzy.inference import infer
from fuzzy.plugins.loop.controller import FACTOR_OF, INPUT_ROLES, PID, LoopError, Roles, Scale, roles_of
from fuzzy.plugins.loop.plant import LoopPlant
from fuzzy.plugins.loop.response import Loop, respond
from fuzzy.system import Sugeno, Variable

_STEP = 1e-3  # of a universe's half: how far from its middle slopes are taken
_NEAR = 0.98  # of a universe: the PID's own signals stay within
_ALIKE = (1e-9, 0.02)  # of the outputs' greatest: rules that differ less from their plane are linear there, or nearly
_SIZES = tuple(0.92**k for k in range(60))  # of the largest factors that keep the inputs within their universes


class Equivalent(NamedTuple):
    """Scale factors with which a rule base acts as a PID."""

    scale: Scale
    deviation: float  # of the rules from their plane in the PID's loop, as a share of the outputs' greatest


def scale_from_pid(
    fis: Sugeno, pid: PID, plant: LoopPlant, loop: Loop | None = None, roles: Mapping[str, str] | None = None
) -> Equivalent:
    """The scale factors with which ``fis`` acts as ``pid`` does.

    The rules are used as far as they are linear, and no input leaves its universe in that loop: both loops are then the
    same. Rules that are linear nowhere are used where they differ from their plane by 2 % at most.

    >>> import fuzzy
    >>> from fuzzy.plugins.designer.starts.control import rule_table
    >>> plant = fuzzy.TransferFunction([1], [1, 1], 0.2)
    >>> found = fuzzy.scale_from_pid(rule_table("pi", 5), fuzzy.PID(2.0, 1.5), plant)
    >>> round(found.deviation, 6)
    0.0

    Args:
        fis: A system with the error and its rate, or its sum, as inputs, and u, du or both as outputs.
        pid: The PID.
        plant: The plant of the loop.
        loop: What happens to it; its scale factors do not count.
        roles: What variables are, by their names, where those do not say it.

    Returns:
        The factors, and how far the rules are from their plane.

    Raises:
        LoopError: A rule base that cannot act as the PID does: an input or output is missing, or the slope is 0.
    """
    loop = Loop() if loop is None else loop
    known = roles_of(fis, roles)
    if "scheduling" in known.inputs:
        raise LoopError(
            f"{fis.name} is scheduled: schedule_from_pids makes its rules of a PID for each operating point"
        )
    slopes = _slopes(fis, known)
    ratios = _ratios(fis, known, slopes, pid)
    factors = _multipliers(known, slopes, ratios, pid)
    gains = {(o, r): factors[o] * slopes[o, r] * ratios[r] for o in known.outputs for r in known.inputs}
    done = respond(_Plane(gains), plant, loop)
    if done.stopped:
        raise LoopError(f"the PID's own loop cannot be taken as a start: {done.stopped}")
    signals = {"error": done.error, "error_rate": done.error_rate, "error_sum": done.error_sum}
    x = np.stack([signals[role] * ratios[role] for role in known.inputs], axis=-1)
    most = min(map(_reach, fis.inputs, x.T))
    tried = [(size := most * share, _deviation(fis, x * size, slopes)) for share in _SIZES]
    alike = [[pair for pair in tried if pair[1] < limit] for limit in _ALIKE]
    size, deviation = next((found[0] for found in alike if found), tried[-1])
    scales = {FACTOR_OF[role]: size * ratio for role, ratio in ratios.items()}
    scales |= {FACTOR_OF[output]: factor / size for output, factor in factors.items()}
    return Equivalent(replace(Scale(), **scales), deviation)


class _Plane:
    """The controller that both are: what each output of the rules gives of each input, as gains."""

    def __init__(self, gains: Mapping[tuple[str, str], float]) -> None:
        self._of = {o: [gains.get((o, role), 0.0) for role in INPUT_ROLES] for o in ("u", "du")}

    def __call__(self, error: float, rate: float, total: float, operating: float = 0.0) -> tuple[float, float]:
        known = (error, rate, total, operating)
        u, du = (sum(gain * value for gain, value in zip(self._of[o], known, strict=True)) for o in ("u", "du"))
        return u, du


def _slopes(fis: Sugeno, roles: Roles) -> dict[tuple[str, str], float]:
    """What an output grows by with an input, about the middle, by their roles."""
    middle = np.array([(low + high) / 2 for low, high in (v.universe for v in fis.inputs)])
    found = {}
    for i, role in enumerate(roles.inputs):
        step = np.zeros(len(middle))
        low, high = fis.inputs[i].universe
        step[i] = _STEP * (high - low) / 2
        up, down = (infer(fis, middle + side * step).output for side in (1, -1))
        for o, output in enumerate(roles.outputs):
            found[output, role] = float((up[o] - down[o]) / (2 * step[i]))
    return found


def _ratios(fis: Sugeno, roles: Roles, slopes: Mapping[tuple[str, str], float], pid: PID) -> dict[str, float]:
    """The factors of the inputs, of which that of the error is 1."""

    def slope(output: str, role: str) -> float:
        value = slopes.get((output, role), 0.0)
        if not math.isfinite(value) or value == 0:
            raise LoopError(f"{fis.name} does not answer to {role} with {output} about the middle of its universes")
        return value

    has, outputs = set(roles.inputs), set(roles.outputs)
    if "error" not in has:
        raise LoopError(f"{fis.name} has no error among its inputs: it cannot act as a PID does")
    ratios = {"error": 1.0}
    if outputs == {"u"}:
        _check(fis, pid.Ki == 0 or "error_sum" in has, "an integral gain", "an output du, or the input error_sum")
        _check(fis, pid.Kd == 0 or "error_rate" in has, "a derivative gain", "the input error_rate")
        _check(fis, pid.Kp != 0, "no proportional gain", "one")
        for role, gain in (("error_rate", pid.Kd), ("error_sum", pid.Ki)):
            if role in has:
                ratios[role] = gain / pid.Kp * slope("u", "error") / slope("u", role)
        return ratios
    _check(fis, "error_rate" in has, "a proportional gain", "the input error_rate")
    _check(fis, pid.Ki != 0, "no integral gain, and the rules give du,", "one")
    _check(fis, pid.Kd == 0 or "u" in outputs, "a derivative gain", "an output u")
    part = slope("du", "error") / slope("du", "error_rate")
    if pid.Kd == 0:
        return ratios | {"error_rate": pid.Kp / pid.Ki * part}
    # With r = Kde / Ke: the rate's part of du and the error's part of u make up Kp.
    other = slope("u", "error") / slope("u", "error_rate")
    inside = pid.Kp**2 - 4 * pid.Ki * pid.Kd * other / part
    _check(fis, inside >= 0, f"gains with Kp² < {4 * other / part:.3g} Ki Kd", "a larger Kp, or less Kd")
    return ratios | {"error_rate": (pid.Kp + math.sqrt(inside)) / (2 * pid.Ki) * part}


def _check(fis: Sugeno, fine: bool, has: str, needs: str) -> None:
    if not fine:
        raise LoopError(f"{fis.name} cannot act as this PID: it has {has}, which needs {needs}")


def _multipliers(
    roles: Roles, slopes: Mapping[tuple[str, str], float], ratios: Mapping[str, float], pid: PID
) -> dict[str, float]:
    """The factor of each output, for inputs with the factors ``ratios``."""
    decides = {"u": ("error", pid.Kp), "du": ("error", pid.Ki)}
    if "du" in roles.outputs:
        decides["u"] = ("error_rate", pid.Kd)
    return {o: decides[o][1] / (slopes[o, decides[o][0]] * ratios[decides[o][0]]) for o in roles.outputs}


def _reach(variable: Variable, signal: np.ndarray) -> float:
    """The greatest factor with which a signal (samples,) stays within the universe of a variable."""
    low, high = variable.universe
    if not low < 0 < high:
        raise LoopError(f"the universe of {variable.name} must have 0 inside")
    sides = [_NEAR * end / far for end, far in ((high, signal.max()), (low, signal.min())) if end * far > 0]
    return float(min(sides, default=math.inf))


def _deviation(fis: Sugeno, x: np.ndarray, slopes: Mapping[tuple[str, str], float]) -> float:
    """How far the rules are from their plane at ``x`` (samples, inputs), as a share of the outputs' greatest."""
    middle = np.array([sum(v.universe) / 2 for v in fis.inputs])
    y, rest = infer(fis, x).output, infer(fis, middle).output
    plane = np.reshape(list(slopes.values()), (len(middle), len(rest)))
    gap, most = np.abs(y - rest - (x - middle) @ plane), np.abs(y - rest)
    return float((gap.max(axis=0) / np.maximum(most.max(axis=0), 1e-300)).max())
