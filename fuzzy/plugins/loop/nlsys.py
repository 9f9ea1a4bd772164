"""A rule base in python-control: as a static nonlinearity, and as a controller with its states, sampled.

The package ``control`` is optional and imported only by the functions here.
"""

from collections.abc import Mapping
from math import inf
from numbers import Real
from typing import Any

import numpy as np

from fuzzy.extras import install_command
from fuzzy.plugins.loop.controller import LoopError, RuleController, Scale, roles_of
from fuzzy.system import Sugeno

_STEP = 1e-6  # of central differences, a share of an input's range


def _control() -> Any:
    try:
        import control
    except ModuleNotFoundError:
        raise LoopError(f"a control.nlsys needs python-control; install it: {install_command('control')}") from None
    return control


def _check_period(sample_time: Any) -> None:
    if isinstance(sample_time, bool) or not isinstance(sample_time, Real) or not 0 < float(sample_time) < inf:
        raise LoopError(f"the sample time must be a number > 0 in s, got {sample_time!r}")


def to_nlsys(
    fis: Sugeno,
    sample_time: float | None = None,
    *,
    roles: Mapping[str, str] | None = None,
    scale: Scale | None = None,
) -> Any:
    """A rule base as a ``control.NonlinearIOSystem``.

    Without ``sample_time`` it is the static nonlinearity y = fis(u), with inputs and outputs named as those of ``fis``;
    ``control.describing_function`` takes it too if it has one of each. With it, it is the whole sampled controller of
    :func:`fuzzy.plugins.loop.response.step_response`: from the error to the control, its states the error before,
    whether there was one, the error's sum and the integral of du. Of that loop it has neither limits nor the rate's
    filter. Its first sample has no error before it, so ``linearize`` at its initial state sees no rate: use
    :func:`linear_controller`.

    Args:
        fis: The rule base. Units are those of its variables; out of range, and where no rule fires, it answers as ever.
        sample_time: The period of the controller [s].
        roles: What variables are, by their names, where those do not say it (see ``roles_of``).
        scale: The scale factors around the rules.

    Raises:
        LoopError: Python-control is not installed, or the variables make no controller.
    """
    control = _control()
    if sample_time is None:
        if roles is not None or scale is not None:
            raise LoopError("roles and scale belong to a controller: give its sample_time too")

        def output(t: float, x: Any, u: Any, params: Any) -> np.ndarray:
            return np.asarray(fis(np.atleast_1d(np.asarray(u, dtype=float))))

        inputs, outputs = [v.name for v in fis.inputs], [v.name for v in fis.outputs]
        return control.nlsys(None, output, inputs=inputs, outputs=outputs, name=fis.name)
    _check_period(sample_time)
    rules = RuleController(fis, chosen := roles_of(fis, roles), scale or Scale())
    if "scheduling" in chosen.inputs:
        raise LoopError(f"{fis.name} is scheduled: linear_controller takes it at one value of its operating variable")

    def asked(x: Any, u: Any) -> tuple[float, float, float, float]:
        """The error, the sum with it, the direct control and the integral of du."""
        error = float(np.ravel(u)[0])
        rate = (error - x[0]) / sample_time if x[1] > 0 else 0.0
        summed = x[2] + error * sample_time
        direct, change = rules(error, rate, summed)
        return error, summed, direct, x[3] + change * sample_time

    def update(t: float, x: Any, u: Any, params: Any) -> np.ndarray:
        error, summed, _, integrated = asked(x, u)
        return np.array([error, 1.0, summed, integrated])

    def command(t: float, x: Any, u: Any, params: Any) -> np.ndarray:
        _, _, direct, integrated = asked(x, u)
        return np.array([direct + integrated])

    states = ["before", "begun", "sum", "integral"]
    return control.nlsys(update, command, inputs=["error"], outputs=["u"], states=states, dt=sample_time, name=fis.name)


def describing_function(fis: Sugeno, amplitudes: Any, points: int = 4096) -> np.ndarray:
    """The describing function of a rule base of one input and one output: its gain to the first harmonic.

    N(A) = 2 / (A T) ∫ f(A sin θ) (sin θ + i cos θ) dθ over a period: real for a function that has no memory.

    Args:
        fis: The rule base.
        amplitudes: (...,) of the sine at its input, > 0, in the input's unit.
        points: How many a period has.

    Returns:
        N (...,), complex, in the output's unit over the input's.

    Raises:
        LoopError: Several inputs or outputs, and amplitudes that are not > 0.
    """
    if len(fis.inputs) != 1 or len(fis.outputs) != 1:
        raise LoopError(f"{fis.name}: a describing function is of one input and one output")
    a = np.asarray(amplitudes, dtype=float)
    if not (np.isfinite(a) & (a > 0)).all():
        raise LoopError("amplitudes must be finite and > 0")
    angle = (np.arange(points) + 0.5) * (2 * np.pi / points)
    said = np.asarray(fis((a[..., None] * np.sin(angle))[..., None]))[..., 0]
    return np.asarray(2 * (said * (np.sin(angle) + 1j * np.cos(angle))).mean(axis=-1) / a)


def linearised(fis: Sugeno, at: Any) -> np.ndarray:
    """The gains (outputs, inputs) of a rule base around a point, by central differences.

    Units are the outputs' over the inputs'. At a vertex of a membership function the two sides differ; the mean stands.

    Args:
        fis: The rule base.
        at: The point (inputs,), in the inputs' units.

    Raises:
        LoopError: A point of another shape.
    """
    x = np.asarray(at, dtype=float)
    if x.shape != (len(fis.inputs),):
        raise LoopError(f"{fis.name}: the point has {len(fis.inputs)} numbers, got the shape {x.shape}")
    steps = np.array([_STEP * max(v.span, 1e-12) for v in fis.inputs])
    above, below = (np.asarray(fis(x + sign * np.diag(steps))) for sign in (1.0, -1.0))
    return np.asarray(((above - below) / (2 * steps[:, None])).T)


def linear_controller(
    fis: Sugeno,
    sample_time: float,
    *,
    at: Any = None,
    roles: Mapping[str, str] | None = None,
    scale: Scale | None = None,
) -> Any:
    """The sampled controller of :func:`to_nlsys` around a point: a ``control.TransferFunction`` from error to control.

    Args:
        fis: The rule base.
        sample_time: The period [s].
        at: The point (inputs,) of the rules, in their units; by default where all are 0. A scheduling variable stays
            there.
        roles: As of :func:`to_nlsys`.
        scale: As of :func:`to_nlsys`.

    Raises:
        LoopError: As :func:`to_nlsys`.
    """
    control, scale = _control(), scale or Scale()
    _check_period(sample_time)
    chosen = roles_of(fis, roles)
    gains = linearised(fis, np.zeros(len(fis.inputs)) if at is None else at)
    z = control.tf([1, 0], [1], sample_time)
    one = control.tf([1], [1], sample_time)
    # The backward difference and the backward sum of the loop
    of_input = {
        "error": scale.Ke * one,
        "error_rate": scale.Kde * (z - 1) / (z * sample_time),
        "error_sum": scale.Kie * sample_time * z / (z - 1),
    }
    of_output = {"u": scale.Ku * one, "du": scale.Kdu * sample_time * z / (z - 1)}
    total = 0 * one
    for row, output in zip(gains, chosen.outputs, strict=True):
        for gain, given in zip(row, chosen.inputs, strict=True):
            if given in of_input:
                total = total + of_output[output] * float(gain) * of_input[given]
    return control.minreal(total, verbose=False)
