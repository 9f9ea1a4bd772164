"""The closed loop of a controller and a plant with one input and one output, and the figures of its step response."""

import math
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from functools import partial
from numbers import Real
from typing import Any

import numpy as np

from fuzzy.plugins.loop.controller import PID, LoopController, LoopError, Roles, RuleController, Scale, roles_of
from fuzzy.plugins.loop.plant import LoopPlant
from fuzzy.plugins.loop.scheduledplant import Course, along
from fuzzy.quantity import check_quantities, quantity, whole
from fuzzy.system import Sugeno

MOST_STEPS = 20_000
STEPS = 500  # by default
BAND = 0.02  # of the reference's step: settled, and recovered
_GONE = 1e6  # of the reference or disturbance: the loop has run away, and is stopped


@dataclass(frozen=True)
class Loop:
    """What happens to a loop: the reference steps from 0 at t = 0, the plant's input is disturbed later.

    Raises LoopError for a setting that cannot be used.
    """

    reference: float = quantity(1.0, "1", doc="Where the output is to go, from 0.")  # in the unit of the plant's output
    duration: float = quantity(10.0, "s", above=0, doc="How long.")
    sample_time: float = quantity(0.0, "s", least=0, doc="The sample time; 0: a 500th of the duration.")
    disturbance_time: float = math.inf  # s: the first sample from then on feels it
    disturbance: float = quantity(0.0, "1", doc="Added to the plant's input, before its dead time.")
    low: float = -math.inf  # the actuator's limits
    high: float = math.inf
    noise: float = quantity(0.0, "1", least=0, doc="Standard deviation of the measurement.")
    seed: int = whole(0, least=0, doc="The seed of the noise.")
    rate_filter: float = quantity(0.0, "s", least=0, doc="Time constant of a first-order filter of the error's rate.")
    scale: Scale = field(default_factory=Scale)
    operating: Course | None = None  # the variable that a scheduled plant and rules depend on

    def __post_init__(self) -> None:
        if self.operating is not None:
            object.__setattr__(self, "operating", Course.of(self.operating))
        check_quantities(self, LoopError)
        for name in ("disturbance_time", "low", "high"):  # which may be infinite
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, Real) or math.isnan(value):
                raise LoopError(f"{name} must be a number, got {value!r}").about(name)
        checks = {
            "sample_time": (self.sample_time <= self.duration, "from 0 s to the duration"),
            "disturbance_time": (self.disturbance_time >= 0, "a number of seconds >= 0"),
            "high": (self.low < self.high, "above the lower limit"),
        }
        for name, (fine, wanted) in checks.items():
            if not fine:
                raise LoopError(f"{name} must be {wanted}, got {getattr(self, name):g}").about(name)
        if self.steps > MOST_STEPS:
            raise LoopError(
                f"a sample time of {self.period:g} s makes {self.steps} samples of {self.duration:g} s, at most "
                f"{MOST_STEPS} are simulated"
            ).about("sample_time")

    @property
    def period(self) -> float:
        """The sample time [s]."""
        return self.sample_time or self.duration / STEPS

    @property
    def steps(self) -> int:
        """How many samples the duration has, without the one at t = 0."""
        return max(1, round(self.duration / self.period))

    def operating_at(self, time: float) -> float:
        """The operating variable at a time [s]; 0 in a loop without one."""
        return 0.0 if self.operating is None else self.operating(time)

    @property
    def disturbed(self) -> int:
        """The number of the first sample that feels the disturbance; beyond the last one where there is none."""
        if self.disturbance == 0 or self.disturbance_time > self.duration:
            return self.steps + 1
        return math.ceil(self.disturbance_time / self.period - 1e-9)


def _figure(title: str, unit: str = "") -> Any:
    return field(default=None, metadata={"title": title, "unit": unit})


@dataclass(frozen=True)
class Figures:
    """What a step response is judged by. None: it did not happen, such as settling within the time.

    All but the integrals, the variation and the recovery are of the time before the disturbance; the band is 2 % of the
    reference's step around the reference. The integrals are of e = r - y over the whole time.
    """

    # Units are those of the plant where none is given.
    overshoot: float | None = _figure("Overshoot", "%")  # of the reference's step
    rise_time: float | None = _figure("Rise time, 10 to 90 %", "s")  # of the reference's step
    settling_time: float | None = _figure("Settling time, 2 %", "s")  # until it stays in the band
    steady_state_error: float | None = _figure("Steady-state error")  # r - y, the last sample before the disturbance
    iae: float | None = _figure("IAE")  # integral of |e|
    ise: float | None = _figure("ISE")  # integral of e²
    itae: float | None = _figure("ITAE")  # integral of t |e|
    variation: float | None = _figure("Total variation of u")  # the sum of the control's moves, |u(k) - u(k-1)|
    peak_deviation: float | None = _figure("Peak deviation after the disturbance")  # the greatest |y - r|
    recovery_time: float | None = _figure("Recovery after the disturbance", "s")  # until it stays in the band again


AFTER = ("peak_deviation", "recovery_time")  # of a disturbance alone
# What people call the figures, and their units, in this order
TITLES = {each.name: (each.metadata["title"], each.metadata["unit"]) for each in fields(Figures)}


@dataclass(frozen=True, eq=False)
class StepResponse:
    """A simulated loop: one number a sample in each array, and its figures.

    Attributes:
        time: (steps + 1,) [s].
        reference: (steps + 1,) r, in the output's unit.
        output: (steps + 1,) the plant's true output, just before the actuator moves.
        control: (steps + 1,) u, within the limits, held until the next sample.
        error: (steps + 1,) r - y as measured.
        error_rate: (steps + 1,) de/dt, the error's unit / s.
        error_sum: (steps + 1,) the integral of e, the error's unit · s.
        operating: (steps + 1,) the operating variable, 0 where the loop has none.
        known: (steps + 1, inputs): what the rule base was given; (steps + 1, 0) of a PID.
        figures: Rise time, settling time, overshoot, steady-state error and integrals of the error.
        clipped: (inputs,) the shares of samples in which an input of the rules lay outside its universe; () of a PID.
        limited: The share of samples in which the actuator stood at a limit.
        loop: LoopController, plant and settings: what was simulated.
        stopped: Why it ended early, in a sentence; empty: it did not. The rest of the arrays is nan.
    """

    time: np.ndarray
    reference: np.ndarray
    output: np.ndarray
    control: np.ndarray
    error: np.ndarray
    error_rate: np.ndarray
    error_sum: np.ndarray
    operating: np.ndarray
    known: np.ndarray
    figures: Figures
    clipped: tuple[float, ...]
    limited: float
    loop: Loop
    stopped: str


def step_response(
    controller: Sugeno | PID,
    plant: LoopPlant,
    *,
    roles: Mapping[str, str] | None = None,
    scale: Scale | None = None,
    disturbance: tuple[float, float] | None = None,
    limits: tuple[float, float] = (-math.inf, math.inf),
    operating: float | str | Sequence[tuple[float, float]] | Course | None = None,
    **settings: Any,
) -> StepResponse:
    """Simulate the step response of a loop, sample by sample.

    At each sample the output is measured, then the actuator moves; the error's rate is a backward difference, 0 at the
    first sample. While the actuator is at a limit, neither the error's sum nor the integrated output pushes it further.

    >>> import fuzzy
    >>> from fuzzy.plugins.designer.starts.control import rule_table
    >>> plant = fuzzy.TransferFunction([1], [1, 1, 0])
    >>> done = fuzzy.step_response(rule_table("pd", 5), plant, scale=fuzzy.Scale(Ke=1, Kde=0.7, Ku=4), duration=8)
    >>> round(done.figures.settling_time, 1)
    2.6

    Args:
        controller: A system whose names say what they are (see :func:`.controller.roles_of`), or a PID.
        plant: A TransferFunction, a FunctionPlant, or what is like them.
        roles: What variables are, by their names, where those do not say it.
        scale: The scale factors around a system; a PID has none.
        disturbance: (time [s], size) of a step at the plant's input.
        limits: Of the actuator.
        operating: The operating variable of a scheduled plant or rule base: a value, or (time [s], value) pairs with
            straight lines between; two pairs at one time are a step.
        settings: The other fields of :class:`Loop`: reference, duration, sample_time, noise, seed, rate_filter.

    Returns:
        The signals, one number a sample, and the figures of the response.

    Raises:
        LoopError: A controller or settings that make no loop.
        PlantError: A plant that cannot be sampled.
    """
    known = {each.name for each in fields(Loop)}
    for name in settings:
        if name not in known:
            raise TypeError(f"step_response() got an unexpected keyword argument {name!r}")
    when, size = disturbance if disturbance is not None else (math.inf, 0.0)
    low, high = limits
    more = {"disturbance_time": when, "disturbance": size, "low": low, "high": high}
    course = None if operating is None else Course.of(operating)
    loop = Loop(**{**more, **settings}, scale=scale or Scale(), operating=course)
    chosen = roles_of(controller, roles) if isinstance(controller, Sugeno) else None
    return respond(controller, plant, loop, chosen)


def respond(
    controller: Sugeno | LoopController, plant: LoopPlant, loop: Loop, roles: Roles | None = None
) -> StepResponse:
    """As :func:`step_response` from a Loop, with the ``roles`` of a system's variables."""
    asked: LoopController
    if isinstance(controller, Sugeno):
        asked = RuleController(controller, roles_of(controller) if roles is None else roles, loop.scale)
        if "scheduling" in asked.roles.inputs and loop.operating is None:
            name = controller.inputs[asked.roles.inputs.index("scheduling")].name
            raise LoopError(f"{name} is the operating variable: give its value, or TIME,VALUE pairs").about("operating")
    else:
        asked = controller
    samples, stopped = _simulated(asked, along(plant, loop.operating), loop)
    time = np.arange(loop.steps + 1) * loop.period
    operating = np.array([loop.operating_at(t) for t in time.tolist()])
    output, control, error, rate, total = np.full((5, loop.steps + 1), np.nan)
    if samples:
        for array, column in zip((output, control, error, rate, total), np.array(samples).T, strict=True):
            array[: len(column)] = column
    reference = np.full_like(time, loop.reference)
    known = (
        asked.known(error, rate, total, operating) if isinstance(asked, RuleController) else np.empty((len(time), 0))
    )
    figures = figures_of(time, output, control, loop)
    clipped = _clipped(controller, known[: len(samples)]) if isinstance(controller, Sugeno) else ()
    limited = float(np.mean((control <= loop.low) | (control >= loop.high)))
    return StepResponse(
        time, reference, output, control, error, rate, total, operating, known, figures, clipped, limited, loop, stopped
    )


def _clipped(fis: Sugeno, known: np.ndarray) -> tuple[float, ...]:
    """The shares (inputs,) of samples (samples, inputs) that lie outside the universes."""
    ends = np.array([v.universe for v in fis.inputs])
    room = 1e-9 * (ends[:, 1] - ends[:, 0])
    outside = (known < ends[:, 0] - room) | (known > ends[:, 1] + room)
    return tuple(map(float, outside.mean(axis=0))) if len(known) else (0.0,) * known.shape[1]


def clipping(fis: Sugeno, done: StepResponse, roles: Roles | None = None) -> list[str]:
    """Sentences on how often the rules, or the actuator, stood at the end of what they know or can do."""
    known = roles.inputs if roles is not None else ("",) * len(fis.inputs)
    found = [
        f"In {100 * share:.0f} % of the samples {v.name} lay outside its universe"
        + ("." if role == "scheduling" else ": its scale factor is large.")
        for v, share, role in zip(fis.inputs, done.clipped, known, strict=True)
        if share >= 0.01
    ]
    if done.limited >= 0.01:
        found.append(f"In {100 * done.limited:.0f} % of the samples the actuator stood at a limit.")
    return found


def _simulated(controller: LoopController, plant: LoopPlant, loop: Loop) -> tuple[list[tuple[float, ...]], str]:
    """The samples (output, control, error, its rate, its sum), and why there are not more."""
    period, first = loop.period, loop.disturbed
    moving = plant.sampled(period)
    noise = np.random.default_rng(loop.seed).normal(0.0, loop.noise, loop.steps + 1) if loop.noise else None
    held = deque([0.0] * (moving.dead_samples + 2), maxlen=moving.dead_samples + 2)  # the latest is the last
    most = _GONE * max(abs(loop.reference), abs(loop.disturbance), 1.0)
    state, asked = moving.initial, SampledController(controller, loop)
    samples: list[tuple[float, ...]] = []
    for k in range(loop.steps + 1):
        output = moving.output(state, held[1])
        if not abs(output) <= most:
            return samples, f"the output runs away: the loop is unstable, and was stopped at t = {k * period:.4g} s"
        error = loop.reference - output - (noise[k] if noise is not None else 0.0)
        control = asked(error, loop.operating_at(k * period))
        if control != control:
            return samples, f"the rules give no number at t = {k * period:.4g} s: no rule fires there"
        samples.append((output, control, asked.error, asked.rate, asked.total))
        held.append(control + (loop.disturbance if k >= first else 0.0))
        state = moving.advance(state, held[0], held[1], k * period)
    return samples, ""


class SampledController:
    """A controller from sample to sample: the error's filtered rate, its sum and the integral of du, both clamped."""

    def __init__(self, controller: LoopController, loop: Loop) -> None:
        self._controller, self._loop, self._period = controller, loop, loop.period
        self._keep = loop.rate_filter / (loop.rate_filter + loop.period)
        self._begun = False
        self.error = self.rate = self.total = self._integrated = 0.0

    def __call__(self, error: float, operating: float = 0.0) -> float:
        """The control at the next sample, whose ``error`` has been measured; not-a-number where no rule fires."""
        if self._begun:
            self.rate = self._keep * self.rate + (1 - self._keep) * (error - self.error) / self._period
        self._begun, self.error = True, error
        period, low, high = self._period, self._loop.low, self._loop.high
        asked = partial(self._controller, error, self.rate, operating=operating)
        summed = self.total + error * period
        direct, change = asked(summed)
        wanted = direct + self._integrated + change * period
        if (wanted > high or wanted < low) and summed != self.total:
            # Clamping: the sum stays if with it the actuator would be driven further into its limit.
            other = asked(self.total)
            less = other[0] + self._integrated + other[1] * period
            if (wanted > high and less <= wanted) or (wanted < low and less >= wanted):
                summed, (direct, change) = self.total, other
        moved = self._integrated + change * period
        if direct + moved > high and change > 0:
            moved = max(self._integrated, min(moved, high - direct))
        elif direct + moved < low and change < 0:
            moved = min(self._integrated, max(moved, low - direct))
        self._integrated, self.total = moved, summed
        return min(max(direct + moved, low), high)


def figures_of(time: np.ndarray, output: np.ndarray, control: np.ndarray, loop: Loop) -> Figures:
    """The figures of a response, all arrays (steps + 1,); of one that was stopped, or that is all nan, none."""
    if not np.isfinite(output).all():
        return Figures()
    error = loop.reference - output
    last = min(loop.disturbed + 1, len(time))  # the disturbed sample itself is measured before it is felt
    t, y = time[:last], output[:last]
    step = loop.reference - y[0]
    overshoot = rise = settling = None
    if step != 0:
        part = (y - y[0]) / step
        overshoot = max(0.0, float(part.max()) - 1) * 100
        ends = [_first_above(t, part, level) for level in (0.1, 0.9)]
        rise = ends[1] - ends[0] if ends[0] is not None and ends[1] is not None else None
        settling = _stays(t, np.abs(part - 1), BAND)
    peak = recovery = None
    if loop.disturbed <= loop.steps:
        after = np.abs(error[loop.disturbed :])
        peak = float(after.max())
        band = BAND * (abs(step) if step != 0 else peak)
        recovery = _stays(time[loop.disturbed :] - time[loop.disturbed], after, band)
    return Figures(
        overshoot,
        rise,
        settling,
        float(error[last - 1]),
        float(np.trapezoid(np.abs(error), time)),
        float(np.trapezoid(error**2, time)),
        float(np.trapezoid(time * np.abs(error), time)),
        float(np.abs(np.diff(control)).sum()),
        peak,
        recovery,
    )


def _first_above(t: np.ndarray, values: np.ndarray, level: float) -> float | None:
    """When ``values`` first reach ``level``, between samples on a straight line."""
    reached = np.flatnonzero(values >= level)
    if not len(reached):
        return None
    k = int(reached[0])
    if k == 0:
        return float(t[0])
    return float(np.interp(level, values[k - 1 : k + 1], t[k - 1 : k + 1]))


def _stays(t: np.ndarray, values: np.ndarray, band: float) -> float | None:
    """From when on ``values`` stay at or below ``band``; None if the last is not."""
    outside = np.flatnonzero(values > band)
    if not len(outside):
        return 0.0
    k = int(outside[-1])
    if k == len(values) - 1:
        return None
    return float(np.interp(-band, -values[k : k + 2], t[k : k + 2]))


def figure_rows(responses: Mapping[str, StepResponse]) -> list[tuple[str, list[float | None]]]:
    """The figures of responses to the same loop: a title with its unit, and the value of each; a row a figure."""
    first = next(iter(responses.values()))
    return [
        (f"{title} [{unit}]" if unit else title, [getattr(done.figures, name) for done in responses.values()])
        for name, (title, unit) in TITLES.items()
        if name not in AFTER or first.loop.disturbed <= first.loop.steps
    ]
