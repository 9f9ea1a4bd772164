"""Plants with one input and one output: transfer functions and Python functions, both with a dead time.

A plant knows how to stand still at first (``initial``), what it shows (``output``), and how it moves while its input is
held (:meth:`Sampled.advance`). A dead time of n samples and a fraction f is exact: within one sample the older input
acts for f, the newer one for the rest (K. J. Åström and B. Wittenmark, "Computer-Controlled Systems", 3rd ed.,
section 2.3).
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np
from scipy.linalg import expm
from scipy.signal import tf2ss

from fuzzy.errors import InputError, quoted

MOST_ORDER = 12
NEEDS_OPERATING = "the plant needs its operating variable: give its value, or TIME,VALUE pairs"
_WHOLE = 1e-9  # a dead time closer than this share of a sample to whole samples is whole


class PlantError(InputError):
    """A description that makes no plant. The message says what is accepted."""


class Sampled(Protocol):
    """A plant at one sample time: its state is whatever it likes, its inputs are held between samples."""

    @property
    def initial(self) -> Any:
        """The state at first."""

    @property
    def dead_samples(self) -> int:
        """Whole samples of the dead time."""

    def output(self, state: Any, held: float) -> float:
        """The output, just before the actuator moves; ``held`` is the delayed input until then."""

    def advance(self, state: Any, older: float, newer: float, time: float) -> Any:
        """The state a sample after ``time`` [s], under two inputs one after the other."""


class LoopPlant(Protocol):
    """What :func:`fuzzy.plugins.loop.response.step_response` controls."""

    def sampled(self, sample_time: float) -> Sampled:
        """The plant at this sample time [s]."""


@dataclass(frozen=True)
class TransferFunction:
    """b(s) / a(s) · exp(-dead_time s), coefficients with the highest power first, as MATLAB's ``tf`` and scipy have
    them.

    Attributes:
        numerator: b, its coefficients.
        denominator: a, its coefficients; its degree is at least that of b.
        dead_time: The delay [s].

    Raises:
        PlantError: Coefficients that make no proper transfer function, and a negative dead time.
    """

    numerator: Sequence[float]
    denominator: Sequence[float]
    dead_time: float = 0.0

    def __post_init__(self) -> None:
        for name in ("numerator", "denominator"):
            object.__setattr__(self, name, _coefficients(getattr(self, name), name))
        if not any(self.denominator):
            raise PlantError("the denominator must have a coefficient other than 0").about("denominator")
        if not any(self.numerator):
            raise PlantError("the numerator must have a coefficient other than 0").about("numerator")
        if len(self.numerator) > len(self.denominator):
            raise PlantError(
                f"the transfer function must be proper: the numerator has degree {len(self.numerator) - 1}, the "
                f"denominator only {len(self.denominator) - 1}"
            ).about("numerator")
        if len(self.denominator) > MOST_ORDER + 1:
            raise PlantError(f"the denominator may have degree {MOST_ORDER} at most").about("denominator")
        object.__setattr__(self, "dead_time", _dead_time(self.dead_time))

    def __str__(self) -> str:
        top, bottom = (" ".join(f"{c:g}" for c in row) for row in (self.numerator, self.denominator))
        return f"{top};{bottom};{self.dead_time:g}"

    @property
    def poles(self) -> np.ndarray:
        """The poles (n,) [1/s], complex."""
        return np.roots(self.denominator)

    @property
    def zeros(self) -> np.ndarray:
        """The zeros (m,) [1/s], complex, without those of the dead time."""
        return np.roots(self.numerator)

    def at(self, s: complex) -> complex:
        """The value at ``s`` [1/s], the dead time included."""
        value = np.polyval(self.numerator, s) / np.polyval(self.denominator, s) * np.exp(-self.dead_time * s)
        return complex(value)

    def sampled(self, sample_time: float) -> "SampledTransferFunction":
        """The transfer function under a zero-order hold of ``sample_time`` [s], exactly."""
        return held_inputs(*state_space(self.numerator, self.denominator), self.dead_time, sample_time)


@dataclass(frozen=True, eq=False)
class SampledTransferFunction:
    """x(k+1) = transition · x + older · w(k-n-1) + newer · w(k-n)."""

    transition: np.ndarray  # (order, order)
    older: np.ndarray  # (order,)
    newer: np.ndarray  # (order,)
    seen: np.ndarray  # (order,)
    through: float
    dead_samples: int
    initial: np.ndarray  # (order,)

    def output(self, state: np.ndarray, held: float) -> float:
        """The output, just before the actuator moves."""
        return float(self.seen @ state) + self.through * held

    def advance(self, state: np.ndarray, older: float, newer: float, time: float) -> np.ndarray:
        """The state a sample later."""
        return self.transition @ state + self.older * older + self.newer * newer


def held_inputs(
    a: np.ndarray, b: np.ndarray, c: np.ndarray, d: float, dead_time: float, sample_time: float
) -> SampledTransferFunction:
    """The states dx/dt = A x + b u, y = c x + d u, sampled, with u held and ``dead_time`` [s] late."""
    whole, part = split_dead_time(dead_time, sample_time)
    moved, older = _held(a, b, part)
    rest, newer = _held(a, b, sample_time - part)
    return SampledTransferFunction(rest @ moved, rest @ older, newer, c, d, whole, np.zeros(len(a)))


@dataclass(frozen=True)
class FunctionPlant:
    """A plant of one's own: dx/dt = derivative(x, u, t), y = output(x), by default the first state.

    It is integrated by the classical Runge-Kutta method of order four with ``substeps`` a sample.

    Attributes:
        derivative: Of the state x (states,), the input u and the time t [s]: gives dx/dt (states,).
        states: How many there are.
        output: Makes y of x (states,); by default the first state.
        initial: The state at the start (states,); zeros by default.
        dead_time: The delay of the input [s].
        substeps: Steps of the integration for each sample.
        linear: Whether dx/dt = A x + B u and y = C x, which a certificate needs; it is checked there.
        name: What messages and pictures call it.
        operating: Values of the operating variable v that the responses are of; then it is derivative(x, u, t, v).
        gains: (Kp, Ki, Kd) of the PID at each of these.

    Raises:
        PlantError: A number of states that is none, and operating points that do not ascend.
    """

    derivative: Callable[..., Any]
    states: int = 1
    output: Callable[[Any], float] | None = None
    initial: Sequence[float] | None = None
    dead_time: float = 0.0
    substeps: int = 4
    linear: bool = False
    name: str = field(default="plant", compare=False)
    operating: Sequence[float] = ()
    gains: Sequence[Sequence[float]] = ()

    def __post_init__(self) -> None:
        for name, most in (("states", 100), ("substeps", 1000)):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or not 1 <= value <= most:
                raise PlantError(f"{self.name}: {name} must be a whole number from 1 to {most}, got {quoted(value)}")
        if not isinstance(self.linear, bool):
            raise PlantError(f"{self.name}: linear must be True or False, got {quoted(self.linear)}")
        start = (0.0,) * self.states if self.initial is None else _coefficients(self.initial, "initial", strip=False)
        if len(start) != self.states:
            raise PlantError(f"{self.name}: initial must have {self.states} numbers, one a state, got {len(start)}")
        object.__setattr__(self, "initial", start)
        object.__setattr__(self, "dead_time", _dead_time(self.dead_time))
        points, gains = checked_points(self.operating, self.gains, self.name)
        object.__setattr__(self, "operating", points)
        object.__setattr__(self, "gains", gains)

    def __str__(self) -> str:
        return self.name

    def at(self, value: float) -> "FunctionPlant":
        """The plant at a ``value`` of its operating variable, in the variable's unit."""
        return self.along(lambda _: value)

    def along(self, course: Callable[[float], float]) -> "FunctionPlant":
        """The plant as its operating variable follows a ``course``, a function of the time [s]."""

        def moved(x: Any, u: float, t: float) -> Any:
            return self.derivative(x, u, t, course(t))

        return replace(self, derivative=moved, operating=(), gains=())

    def sampled(self, sample_time: float) -> "SampledFunction":
        """The plant with its input held between samples, ``sample_time`` [s] apart. Raises PlantError."""
        if self.operating:
            raise PlantError(f"{self.name}: {NEEDS_OPERATING}").about("operating")
        whole, part = split_dead_time(self.dead_time, sample_time)
        return SampledFunction(self, whole, part, sample_time - part, np.array(self.initial, dtype=float))


@dataclass(frozen=True, eq=False)
class SampledFunction:
    """A :class:`FunctionPlant` at one sample time."""

    plant: FunctionPlant
    dead_samples: int
    part: float  # s: the fraction of the dead time, during which the older input acts
    rest: float  # s
    initial: np.ndarray  # (states,)

    def output(self, state: np.ndarray, held: float) -> float:
        """The output; a function sees the state alone. Raises PlantError for what is no number."""
        if self.plant.output is None:
            return float(state[0])
        try:
            return float(self.plant.output(state.copy()))
        except (TypeError, ValueError, IndexError) as error:
            raise PlantError(f"{self.plant.name}: output(x) must give a number: {error}") from None

    def advance(self, state: np.ndarray, older: float, newer: float, time: float) -> np.ndarray:
        """The state a sample later."""
        if self.part > 0:
            state = self._moved(state, older, time, self.part)
        return self._moved(state, newer, time + self.part, self.rest)

    def _moved(self, x: np.ndarray, u: float, t: float, span: float) -> np.ndarray:
        h = span / self.plant.substeps
        for k in range(self.plant.substeps):
            at = t + k * h
            k1 = self._slope(x, u, at)
            k2 = self._slope(x + h / 2 * k1, u, at + h / 2)
            k3 = self._slope(x + h / 2 * k2, u, at + h / 2)
            k4 = self._slope(x + h * k3, u, at + h)
            x = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        return x

    def _slope(self, x: np.ndarray, u: float, t: float) -> np.ndarray:
        try:
            slope = np.asarray(self.plant.derivative(x, u, t), dtype=float)
        except (TypeError, ValueError, IndexError) as error:
            raise PlantError(f"{self.plant.name}: plant(x, u, t) failed at t = {t:g} s: {error}") from None
        if slope.shape != x.shape and slope.size == x.size:
            slope = slope.reshape(x.shape)
        if slope.shape != x.shape:
            raise PlantError(
                f"{self.plant.name}: plant(x, u, t) must give {x.size} derivatives, one a state, "
                f"got shape {slope.shape}"
            )
        return slope


def _coefficients(values: Any, name: str, *, strip: bool = True) -> tuple[float, ...]:
    """Finite numbers, without zeros in front."""
    try:
        numbers = [float(v) for v in np.atleast_1d(np.asarray(values, dtype=float)).ravel()]
    except (TypeError, ValueError, OverflowError):
        raise PlantError(f"{name} must be numbers, highest power first, got {quoted(values)}").about(name) from None
    if not numbers or not all(map(math.isfinite, numbers)):
        raise PlantError(f"{name} must be finite numbers, highest power first, got {quoted(values)}").about(name)
    while strip and len(numbers) > 1 and numbers[0] == 0:
        del numbers[0]
    return tuple(numbers)


def checked_points(points: Any, gains: Any, name: str) -> tuple[tuple[float, ...], tuple[tuple[float, ...], ...]]:
    """Operating points, and the gains of the PID at each, as numbers. Raises PlantError."""
    try:
        found = tuple(float(point) for point in points)
        rows = tuple(tuple(float(gain) for gain in row) for row in gains) or ((),) * len(found)
    except (TypeError, ValueError):
        raise PlantError(
            f"{name}: operating must be numbers, and gains Kp, Ki, Kd at each, got {quoted(points)}"
        ) from None
    if list(found) != sorted(set(found)) or not all(map(math.isfinite, (*found, *sum(rows, ())))):
        raise PlantError(f"{name}: the operating points must be finite and ascending, got {quoted(points)}")
    if len(rows) != len(found) or any(len(row) > 3 for row in rows):
        raise PlantError(f"{name}: each operating point has the gains Kp, Ki, Kd of one PID, or none has")
    return found, rows


def _dead_time(value: Any) -> float:
    try:
        time = float(value)
    except (TypeError, ValueError, OverflowError):
        time = math.nan
    if not (time >= 0 and math.isfinite(time)):
        raise PlantError(f"the dead time must be a finite number of seconds >= 0, got {quoted(value)}").about(
            "dead_time"
        )
    return time


def split_dead_time(dead_time: float, sample_time: float) -> tuple[int, float]:
    """A dead time as whole samples and the rest [s]."""
    samples = dead_time / sample_time
    whole = math.floor(samples + _WHOLE)
    part = samples - whole
    return whole, part * sample_time if part > _WHOLE else 0.0


def state_space(numerator: Any, denominator: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """A (n, n), B (n,), C (n,) and D of a transfer function without dead time, in the controller canonical form."""
    if len(denominator) == 1:  # a mere gain has no state
        return np.zeros((0, 0)), np.zeros(0), np.zeros(0), numerator[0] / denominator[0]
    a, b, c, d = tf2ss(numerator, denominator)
    return a, b[:, 0], c[0], float(d[0, 0])


def _held(a: np.ndarray, b: np.ndarray, span: float) -> tuple[np.ndarray, np.ndarray]:
    """exp(A t), and the integral of exp(A s) B from 0 to t, for t = ``span`` [s]."""
    order = len(a)
    both = np.zeros((order + 1, order + 1))
    both[:order, :order], both[:order, order] = a * span, b * span
    moved = expm(both)
    return moved[:order, :order], moved[:order, order]
