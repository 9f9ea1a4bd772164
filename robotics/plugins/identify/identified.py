"""What a drive tells of a robot: each number with its interval, what it cannot tell, and what to drive for that."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from fuzzy.shown import shown
from robotics.plugins.identify.calibration import calibrated
from robotics.plugins.identify.fit import Ends, MotionFit, fit_motion
from robotics.plugins.identify.model import COORDINATE_NAMES, COORDINATES
from robotics.plugins.identify.noise import Whiteness, counts_per_turn, deviation, whiteness
from robotics.plugins.identify.signals import Signals
from robotics.plugins.identify.soundness import sound
from robotics.simulation.scenario.robots import RobotModel

_WIDE = 3.0  # times from end to end: a number between them is not known
_AHEAD = 5.0  # s: of a prediction that is judged
_SURELY = 0.01  # of the test for whiteness
# Numbers beside those of the motion: unit and title
_OTHERS = {
    "scale": ("1", "true way over odometry's"),
    "wheel_ratio": ("1", "radius of the right wheel over that of the left"),
    "axle_ratio": ("1", "true axle over the assumed one"),
    "turn_scale": ("1", "true turn over odometry's"),
    "counts_per_turn": ("counts", "encoder counts in a turn of the wheel"),
    "v_noise": ("m/s", "noise of the measured speed"),
    "w_noise": ("rad/s", "noise of the measured turn rate"),
    "position_noise": ("m", "noise of the measured position"),
    "heading_noise": ("rad", "noise of the measured heading"),
    "yaw_noise": ("rad/s", "noise of the gyroscope"),
}
_ADVICE = {
    "v_max": "Command straight drives faster than {v_asked} m/s, as far as there is room.",
    "w_max": "Command turns on the spot faster than {w_asked} rad/s.",
    "wheel_max": "Drive and turn at the same time, both fast: one wheel then runs at its limit.",
    "v_rate_max": "Command large steps of the speed, from full speed back to full speed forward.",
    "w_rate_max": "Command large steps of the turn rate, from full left to full right.",
    "force_limit": "Command the largest steps of speed that are safe: only these reach the motors' limit.",
    "dead_band": "Command slow ramps through 0, forward, back and turning, a minute in all.",
    "friction": "Start and turn round slowly, several times: friction shows where a wheel changes its direction.",
    "gyration": "Command steps of the turn rate on the spot.",
    "lag": "Command steps of medium size, each held for half a second.",
    "rise_time": "Command steps of medium size, each held for half a second, and log at 50 Hz or more.",
    "motor_time": "Command steps of medium size and let each settle for a second.",
    "latency": "Log at 50 Hz or more, with the times of the robot's own clock.",
}


class Number(NamedTuple):
    """One number of the robot."""

    name: str
    title: str
    unit: str
    value: float
    ends: Ends
    known: str  # "yes", "above" (only that it is above the interval's low end), "below", "no"
    field: str = ""  # of Robot that follows from it

    @property
    def interval(self) -> str:
        """The interval as people read it."""
        low, high = (shown(each, digits=_digits(self)) for each in self.ends)
        return {"above": f"above {low}", "below": f"below {high}"}.get(self.known, f"{low} to {high}")

    def row(self) -> dict[str, Any]:
        """The same for JSON; an end that is not known is None."""
        low, high = (float(each) if np.isfinite(each) else None for each in self.ends)
        return {
            "name": self.name, "title": self.title, "unit": self.unit, "value": self.value, "low": low, "high": high,
            "known": self.known, "field": self.field or None,
        }  # fmt: skip


def _digits(number: Number) -> int:
    """So many digits that the ends of an interval differ, three at least."""
    low, high = number.ends
    if not (np.isfinite(high) and high > low > 0):
        return 3
    return int(np.clip(np.ceil(-np.log10((high - low) / high)) + 1, 3, 7))


@dataclass(frozen=True, eq=False)
class Identified:
    """All that was found.

    Attributes:
        model: The robot by its data sheet.
        signals: What was read of the log.
        motion: The fit.
        numbers: All numbers, in the order in which they are shown.
        whiteness: Of the residuals of v and of ω.
        prediction: RMS errors of 5 s predicted by commands alone: "v" [m/s], "w" [rad/s], "way" [m].
        sentences: What was left out, what the log cannot tell, and what residuals are like.
        advice: What to drive to learn more.
    """

    model: RobotModel
    signals: Signals
    motion: MotionFit
    numbers: tuple[Number, ...]
    whiteness: tuple[Whiteness, Whiteness]
    prediction: dict[str, float]
    sentences: tuple[str, ...]
    advice: tuple[str, ...]

    def number(self, name: str) -> Number | None:
        """The number of that name, if it is there."""
        return next((each for each in self.numbers if each.name == name), None)


def identify(signals: Signals, model: RobotModel, seed: int = 0) -> Identified:
    """Identify a robot from a drive.

    Args:
        signals: The drive.
        model: The robot by its data sheet: its mass, its size and its motors' volts are taken from there.
        seed: Of the starts of the fit.

    Raises:
        IdentifyError: A log that tells nothing; the message says why.
    """
    base, found = model.robot, sound(signals)
    signals = found.signals
    counts = counts_per_turn(signals.velocities, base)
    motion = fit_motion(base, found, seed, None if counts is None else counts[0])
    calibration, why = calibrated(signals, base, motion.averaged)
    numbers = [_number(name, motion, signals) for name in COORDINATE_NAMES]
    rows: list[tuple[str, float, Ends]] = []
    if calibration is not None:
        rows += [(name, calibration.values[name], ends) for name, ends in calibration.intervals.items()]
    if counts is not None:
        rows.append(("counts_per_turn", *counts))
    rows += [(name, *deviation(each)) for name, each in zip(("v_noise", "w_noise"), motion.residuals, strict=True)]
    if calibration is not None:
        size = 1.96 / np.sqrt(2 * calibration.samples)
        rows += [(n, x, Ends(x * (1 - size), x * (1 + size))) for n, x in calibration.noise.items()]
    fields = {"counts_per_turn": "counts_per_turn", "scale": "wheel_radius", "axle_ratio": "half_axle"}
    numbers += [Number(n, _OTHERS[n][1], _OTHERS[n][0], x, ends, "yes", fields.get(n, "")) for n, x, ends in rows]
    period = float(np.median(np.diff(motion.time)))
    tests = whiteness(motion.residuals[0], period), whiteness(motion.residuals[1], period)
    sentences = [*found.remarks, *_cannot_tell(numbers, signals), *([why] if why else [])]
    if counts is None:
        sentences.append("The speeds are on no grid: the encoders' resolution is hidden by noise or by a filter.")
    rounding = 0.0 if counts is None else np.pi * base.wheel_radius / counts[0] / period
    for k, name in enumerate(("speed", "turn rate")):
        rounded = float(np.std(motion.residuals[k])) < rounding * (1 if k == 0 else 2 / base.half_axle)
        sentences.append(_said_of(tests[k], name, rounded))
    advice = _advice(numbers, signals, calibration is None)
    return Identified(model, signals, motion, tuple(numbers), tests, _predicted(motion), tuple(sentences), advice)


def _number(name: str, motion: MotionFit, signals: Signals) -> Number:
    about, value, ends = COORDINATES[name], motion.value(name), motion.intervals[name]
    known = "yes"
    if about.limit and not np.isfinite(ends.high):
        known = "above"
    elif name == "dead_band":
        known = "below" if ends.low == 0 and np.isfinite(ends.high) else "yes" if np.isfinite(ends.high) else "no"
    elif not np.isfinite(ends.high) or (about.logarithmic and ends.high > _WIDE * max(ends.low, 1e-12)):
        known = "no"
    elif name == "friction" and ends.low == 0:
        known = "below"
    return Number(name, about.title, about.unit, value, ends, known, about.field)


def _cannot_tell(numbers: list[Number], signals: Signals) -> list[str]:
    given, seen = signals.commands, signals.velocities
    v, w = shown(float(np.abs(seen.v).max()), digits=2), shown(float(np.abs(seen.w).max()), digits=2)
    why = {
        "v_max": f"No command was cut off up to {shown(np.abs(given.v).max(), digits=2)} m/s (fastest: {v} m/s)",
        "w_max": f"No turn was cut off up to {shown(np.abs(given.w).max(), digits=2)} rad/s (fastest: {w} rad/s)",
        "wheel_max": "No wheel came to its highest speed",
        "v_rate_max": "The robot followed every step of the speed as its wheels could",
        "w_rate_max": "The robot followed every step of the turn rate as its wheels could",
        "force_limit": "The wheels never needed all of their torque",
    }
    said = []
    for each in numbers:
        if each.known == "above":
            low = shown(each.ends.low, digits=2)
            said.append(f"{why[each.name]}: {each.title} is only known to be above {low} {each.unit}.")
        elif each.known == "no":
            said.append(f"The log hardly tells the {each.title}: anything {each.interval} {each.unit} fits.")
    return said


def _said_of(test: Whiteness, what: str, rounded: bool) -> str:
    """What residuals are like; ``rounded``: they are as small as the rounding of encoders."""
    if test.p_value > _SURELY:
        return f"Residuals of the {what} are white (Ljung-Box, p = {shown(test.p_value, digits=2)}): nothing is left."
    if rounded or test.first < -0.2:
        return (
            f"Residuals of the {what} are no white noise (neighbours correlate by {test.first:.2f}): they are what the "
            "rounding of encoders makes; intervals take that into account."
        )
    return (
        f"Residuals of the {what} are not white (Ljung-Box, p = {shown(test.p_value, digits=2)}; neighbours correlate "
        f"by {test.first:.2f}, up to {shown(test.reach, digits=2)} s): the model misses something, or the noise is "
        "filtered; intervals are wider for it."
    )


def _advice(numbers: list[Number], signals: Signals, uncalibrated: bool) -> tuple[str, ...]:
    asked = {
        "v_asked": shown(float(np.abs(signals.commands.v).max()), digits=2),
        "w_asked": shown(float(np.abs(signals.commands.w).max()), digits=2),
    }
    found = [_ADVICE[each.name].format(**asked) for each in numbers if each.known in ("above", "no")]
    if uncalibrated:
        found.append(
            "Log a pose that does not come from the wheels, such as of a camera or a lidar: it tells radii and axle."
        )
    if found:
        found.append("robotics excite writes a minute of commands that tells most within a square.")
    return tuple(dict.fromkeys(found))


def _predicted(motion: MotionFit) -> dict[str, float]:
    """RMS errors over 5 s ahead: of the velocities, and of the way (m) between the ends of both tracks."""
    period = float(np.median(np.diff(motion.time)))
    steps = max(1, round(_AHEAD / period))
    wrong = [
        _end(motion.modelled[:, k : k + steps], period) - _end(motion.measured[:, k : k + steps], period)
        for k in range(0, len(motion.time) - steps, max(1, steps // 2))
        if motion.time[k + steps] - motion.time[k] < 1.2 * _AHEAD
    ]
    rms = np.sqrt((motion.residuals**2).mean(axis=1))
    way = float(np.sqrt((np.abs(np.array(wrong)) ** 2).mean())) if wrong else float("nan")
    return {"v": float(rms[0]), "w": float(rms[1]), "way": way}


def _end(velocities: np.ndarray, period: float) -> complex:
    """Where velocities (2, n) lead from the origin, as x + i y [m]."""
    heading = np.cumsum(velocities[1]) * period - velocities[1] * period / 2
    return complex((velocities[0] * period * np.exp(1j * heading)).sum())
