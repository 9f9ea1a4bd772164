"""A PID for a transfer function, by published rules: what a rule base is held against.

SIMC: S. Skogestad, "Simple analytic rules for model reduction and PID controller tuning", Journal of Process Control 13
(2003), pp. 291-309. Ultimate gain: J. G. Ziegler and N. B. Nichols, "Optimum settings for automatic controllers",
Transactions of the ASME 64 (1942), pp. 759-768.
"""

import numpy as np
from scipy.optimize import brentq

from fuzzy.plugins.loop.controller import PID, LoopError
from fuzzy.plugins.loop.plant import TransferFunction

_NEARLY = 1e-3  # of its size: an imaginary part that roots falling together have by rounding
_LAG = 0.1  # of the largest time constant: closed loops are not asked to be faster than that


def tuned_pid(plant: TransferFunction, sample_time: float) -> PID:
    """A PID for the plant, by SIMC where its poles are real and no zero helps, otherwise by the ultimate gain.

    The zero-order hold counts as half a sample of dead time. SIMC's closed-loop time constant is the dead time after
    the half rule, as Skogestad advises, but at least a sample and a tenth of the largest time constant: a plant without
    dead time would ask for any gain.

    Args:
        plant: The transfer function.
        sample_time: The period of the controller [s].

    Raises LoopError where neither rule applies, such as for an unstable plant.
    """
    poles, zeros = plant.poles, plant.zeros
    slow = _tolerance(poles)
    if (poles.real > slow).any():
        raise LoopError("neither SIMC nor Ziegler and Nichols has a rule for an unstable plant: give the PID's gains")
    real = bool((np.abs(poles.imag) <= _NEARLY * np.abs(poles)).all())
    real = real and bool(((zeros.real > 0) & (np.abs(zeros.imag) <= _NEARLY * zeros.real)).all())
    integrators = int((np.abs(poles) <= slow).sum())
    if real and integrators <= 1 and len(poles):
        return _simc(plant, poles[np.abs(poles) > slow].real, zeros.real, sample_time, bool(integrators))
    return _ultimate(plant, sample_time)


def _tolerance(poles: np.ndarray) -> float:
    """A root of this size is 0, as rounding leaves it."""
    return 1e-6 * float(np.abs(poles).max(initial=0.0)) + 1e-12


def _simc(plant: TransferFunction, poles: np.ndarray, zeros: np.ndarray, sample_time: float, integrates: bool) -> PID:
    lags = sorted((-1 / p for p in poles), reverse=True)
    # k of k / ((τ1 s + 1) ...), or k' of k' / (s ...): the denominator's lowest coefficient that is not 0
    gain = plant.numerator[-1] / plant.denominator[-2 if integrates else -1]
    dead = plant.dead_time + sample_time / 2 + float(np.sum(1 / zeros))
    if integrates:  # the integrator is the first time constant, infinitely long
        first, rest = np.inf, lags
    else:
        first, rest = lags[0], lags[1:]
    second = rest[0] if rest else 0.0
    if len(rest) > 1:  # the half rule
        second += rest[1] / 2
        dead += rest[1] / 2 + sum(rest[2:])
    wanted = max(dead, sample_time, _LAG * (second if integrates else first))
    main = (1.0 if integrates else first) / (gain * (wanted + dead))
    reset = min(first, 4 * (wanted + dead))
    # From the serial form of the rule to the parallel one
    gains = (main * (1 + second / reset), main / reset, main * second)
    return PID(*map(float, gains), rule="SIMC (Skogestad 2003)")


def _ultimate(plant: TransferFunction, sample_time: float) -> PID:
    """From the frequency at which plant and hold turn the phase by 180°."""
    corners = np.abs(np.concatenate([plant.poles, plant.zeros]))
    slowest = min(corners[corners > _tolerance(plant.poles)].min(initial=np.inf), np.pi / sample_time)
    w = np.geomspace(1e-3 * slowest, np.pi / sample_time, 4000)
    # the hold's dead time of half a sample
    values = np.array([plant.at(1j * f) * np.exp(-0.5j * f * sample_time) for f in w])
    sign = np.sign(plant.numerator[-1] / next(c for c in reversed(plant.denominator) if c)) or 1.0
    phase = np.unwrap(np.angle(values * sign))
    phase -= 2 * np.pi * np.round(phase[0] / (2 * np.pi))
    below = np.flatnonzero((phase[:-1] > -np.pi) & (phase[1:] <= -np.pi))
    if not len(below):
        raise LoopError(
            "the plant's phase never falls through -180°, so that there is no ultimate gain for Ziegler and Nichols' "
            "rule, and SIMC's does not apply: give the PID's gains"
        )
    k = int(below[0])
    at = brentq(lambda f: float(np.interp(f, w[k : k + 2], phase[k : k + 2])) + np.pi, w[k], w[k + 1])
    gain, period = 1 / abs(plant.at(1j * at)), 2 * np.pi / at
    Kp = sign * 0.6 * gain
    return PID(*map(float, (Kp, Kp / (period / 2), Kp * period / 8)), rule="ultimate gain (Ziegler and Nichols 1942)")
