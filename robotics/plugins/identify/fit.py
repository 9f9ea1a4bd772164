"""The fit of the model to a drive by output error, and 95 % intervals by profile likelihood.

The model follows the commands of the whole log from rest, and its velocities are held against the measured ones; no
measured value enters the model. Residuals are correlated (encoders round, models err), so that a fit is done twice: on
the residuals as they are, then on what an autoregression leaves of them. The interval of a coordinate is where the sum
of squares, minimised over all other coordinates, stays within the quantile of an F distribution; the quantile is
widened by the long-run variance of the scores where the autoregression did not make them white. All lanes of a pass
(starts, derivatives, ends of intervals) are driven together.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import least_squares
from scipy.signal import lfilter
from scipy.stats import f as f_distribution

from robotics.plugins.identify.model import (
    COORDINATE_NAMES,
    COORDINATES,
    DEAD,
    LIMIT_NAMES,
    Stimulus,
    drive,
    from_fit,
    least_gyration,
    sampled,
    to_fit,
    values_of,
)
from robotics.plugins.identify.signals import LOG_GAP
from robotics.plugins.identify.soundness import SoundSignals
from robotics.world.vehicle.robot import Robot

CONFIDENCE = 0.95
_STARTS, _REFINED = 160, 2  # drawn starts, and how many of them are refined
_ORDER = 8  # of the autoregression at most
# What a data sheet is worth: standard deviations of logarithms around its values. A drive that tells more overrides it.
_WORTH = {"motor_time": 0.5, "wheel_max": 0.3, "rise_time": 1.5, "gyration": 0.5, "lag": 2.0}
_STEP = 2e-3  # of a derivative: of a logarithm, or of an SI unit
_ROUNDS = 8  # of the search for the ends of an interval
_FAR = 3.0  # a logarithm that can be moved so far without a loss is not known on that side
_DEAD_LEVELS = 48
_AT_ONCE = 0.03  # s: a limit by which full speed is commanded within three steps of the plant is none
_IMITATIONS = 16  # models with the robot's own encoders, by which the bias of the fit is known
_LONG_RUN = 60  # samples over which scores are taken to be correlated
_SWEEPS = 3
_ATTEMPTS, _SUSPICIOUS = 3, 0.3  # searches, and the correlation of neighbouring residuals from which on another is made
_BEYOND = 3.0  # times what was commanded: a limit there is none
# By how much a sweep moves one coordinate: logarithms, those of limits, and SI units
_LOG_MOVES = np.array([-0.7, -0.35, -0.15, -0.06, 0.06, 0.15, 0.35, 0.7])
_LIMIT_MOVES = np.concatenate([np.linspace(-3.0, -0.25, 12), [-0.1, -0.04, 0.04, 0.1, 0.3, 0.7, 1.5, 3.0]])
_MOVES = np.array([-0.1, -0.03, 0.03, 0.1])
_EVIDENCE = 6.0  # of twice the log-likelihood: below it, two models are told apart by no means
_SURE = 0.998  # of a dead band: it is the best of many levels, of which chance alone prefers one
_BEST = 1e-3  # of what was driven: no model errs by less, nor are encoders and clocks better


class Ends(NamedTuple):
    """An interval; infinite (or 0, below) on a side on which the drive does not tell."""

    low: float
    high: float


@dataclass(frozen=True, eq=False)
class MotionFit:
    """What a drive tells of how its robot answers commands.

    Attributes:
        values: The coordinates of the model (coordinates,).
        intervals: The 95 % interval of each that was fitted, by name.
        averaged: Whether each velocity is a mean since the one before, as of encoders; else it is of its moment.
        measured: v [m/s] and ω [rad/s] (2, samples) that were used, at ``time``.
        modelled: Likewise, of the model.
    """

    values: np.ndarray
    intervals: dict[str, Ends]
    averaged: bool
    time: np.ndarray
    measured: np.ndarray
    modelled: np.ndarray

    @property
    def residuals(self) -> np.ndarray:
        """Measured minus modelled (2, samples)."""
        return self.measured - self.modelled

    def value(self, name: str) -> float:
        """A coordinate."""
        return float(self.values[COORDINATE_NAMES.index(name)])


@dataclass(frozen=True, eq=False)
class _Problem:
    """Residuals as a function of fitted coordinates (fitted, lanes)."""

    base: Robot
    stimulus: Stimulus
    time: np.ndarray  # (n,)
    window: np.ndarray  # (n,)
    measured: np.ndarray  # (2, n)
    usable: np.ndarray  # (n,) bool
    fixed: np.ndarray  # (coordinates,) values
    names: tuple[str, ...]
    scale: np.ndarray  # (2,)
    filters: tuple[np.ndarray, np.ndarray]
    prior: np.ndarray  # (coordinates,) fitted: the data sheet's
    asked: Mapping[str, float]  # of each limit of a speed: what was commanded at most

    @property
    def places(self) -> list[int]:
        return [COORDINATE_NAMES.index(name) for name in self.names]

    def start(self) -> np.ndarray:
        """The fixed values of what is fitted."""
        return to_fit(self.fixed)[self.places]

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Between which the coordinates stay."""
        least = np.array([COORDINATES[name].least for name in COORDINATE_NAMES])
        most = np.array([COORDINATES[name].most for name in COORDINATE_NAMES])
        least[COORDINATE_NAMES.index("gyration")] = least_gyration(self.base)
        for name, value in self.asked.items():
            most[COORDINATE_NAMES.index(name)] = _BEYOND * value
        least, most = to_fit(least), to_fit(most)
        return least[self.places], most[self.places]

    def lanes(self, fitted: np.ndarray) -> np.ndarray:
        """All values (coordinates, lanes) by those that are fitted (fitted, lanes)."""
        low, high = self.bounds()
        values = np.repeat(to_fit(self.fixed)[:, None], fitted.shape[1], axis=1)
        values[self.places] = np.clip(fitted, low[:, None], high[:, None])
        return from_fit(values)

    def outputs(self, lanes: np.ndarray) -> np.ndarray:
        """The model's velocities (2, n, lanes) at all samples."""
        return sampled(drive(self.base, lanes, self.stimulus), self.time, self.window)

    def rows(self, outputs: np.ndarray) -> np.ndarray:
        """Weighed residuals (2 n, lanes) of ``outputs``; those of samples that are not used are 0."""
        wrong = (outputs - self.measured[..., None]) * self.usable[None, :, None]
        parts = [
            lfilter(h, [1.0], each, axis=0) / s for h, each, s in zip(self.filters, wrong, self.scale, strict=True)
        ]
        return np.concatenate(parts)

    def residuals(self, fitted: np.ndarray) -> np.ndarray:
        """All rows (rows, lanes), those of the data sheet last."""
        rows = self.rows(self.outputs(self.lanes(fitted)))
        worth = [
            (fitted[self.names.index(name)] - self.prior[COORDINATE_NAMES.index(name)]) / spread
            for name, spread in _WORTH.items()
            if name in self.names
        ]
        return np.concatenate([rows, np.array(worth).reshape(-1, rows.shape[1])])

    def slopes(self, fitted: np.ndarray) -> np.ndarray:
        """The derivatives of the rows (rows, fitted) by central differences."""
        low, high = self.bounds()
        n, step = len(fitted), np.full(len(fitted), _STEP)
        either = np.concatenate([fitted[:, None] + np.diag(step), fitted[:, None] - np.diag(step)], axis=1)
        either = np.clip(either, low[:, None], high[:, None])
        rows = self.residuals(either)
        width = np.array([either[i, i] - either[i, n + i] for i in range(n)])
        return (rows[:, :n] - rows[:, n:]) / width

    def solved(self, start: np.ndarray, evaluations: int) -> tuple[np.ndarray, float]:
        """The best coordinates from ``start`` on, and their sum of squares."""
        low, high = self.bounds()
        inside = np.clip(start, low + 1e-9, high - 1e-9)
        found: Any = least_squares(
            lambda x: self.residuals(x[:, None])[:, 0],
            inside,
            self.slopes,
            bounds=(low, high),
            x_scale="jac",
            max_nfev=evaluations,
            ftol=1e-6,
            xtol=1e-6,
        )
        return found.x, 2 * float(found.cost)


def fit_motion(base: Robot, found: SoundSignals, seed: int = 0, counts: float | None = None) -> MotionFit:
    """Fit the model of a robot with the mass and size of ``base`` to a drive.

    Args:
        base: The robot by its data sheet.
        found: The drive.
        seed: Of the starts that are drawn.
        counts: What an encoder counts in a turn, if that is known: velocities are then means since the last ones.
    """
    means = _problem(base, found, True)
    tried = []
    for attempt in range(_ATTEMPTS):
        starts = _starts(means, found, np.random.default_rng([seed, attempt]))
        tried.append(_searched(means, starts))
        if not _errs(tried[-1]):
            break
    means = min(tried, key=_cost)
    problem, other, gain = means, means, np.inf
    if counts is None:
        later = float(np.median(means.window)) / 2
        moments = _settled(_later(replace(means, window=0.0 * means.window), later))
        again = _settled(_later(replace(moments, window=means.window), -later))  # if that is another valley
        means = min(means, again, key=_cost)
        gain = np.count_nonzero(found.usable) * 2 * np.log(_cost(moments) / _cost(means))  # twice the log-likelihood
        problem, other = (means, moments) if gain > -_EVIDENCE else (moments, means)
    averaged = problem is means
    problem = _with_dead_band(problem)
    for _ in range(2):
        problem = _swept(_whitened(problem))
        problem = _at(problem, problem.solved(problem.start(), 12)[0])
    problem = _with_dead_band(problem)
    intervals, problem = _profiled(problem)
    if counts is not None:
        intervals, problem = _unbiased(problem, intervals, counts, np.random.default_rng([seed, 1]))
    intervals["dead_band"] = _dead_band(problem)[1]
    if abs(gain) < _EVIDENCE:  # of the mean or of the moment: the latency is that much less certain
        low, high = intervals["latency"]
        rival = float(other.fixed[COORDINATE_NAMES.index("latency")])
        intervals["latency"] = Ends(min(low, rival), max(high, rival))
    outputs = problem.outputs(problem.fixed[:, None])[:, :, 0]
    used = problem.usable
    return MotionFit(
        problem.fixed,
        intervals,
        averaged,
        problem.time[used],
        problem.measured[:, used],
        outputs[:, used],
    )


def information(
    base: Robot, values: np.ndarray, stimulus: Stimulus, time: np.ndarray, period: float, noise: np.ndarray
) -> np.ndarray:
    """The information matrix (fitted, fitted) of a robot's drive: of all coordinates but the dead band.

    Args:
        base: The robot by its data sheet.
        values: The coordinates of the robot that drives (coordinates,).
        stimulus: The commands.
        time: When velocities are measured (n,) [s].
        period: Over which each is a mean [s].
        noise: The standard deviation of v [m/s] and of ω [rad/s] (2,).
    """
    names = tuple(name for name in COORDINATE_NAMES if name != "dead_band")
    n = len(time)
    problem = _Problem(
        base, stimulus, time, np.full(n, period), np.zeros((2, n)), np.ones(n, dtype=bool), values, names, noise,
        (np.ones(1), np.ones(1)), to_fit(values), {},
    )  # fmt: skip
    slopes = problem.slopes(problem.start())[: 2 * n]
    return np.asarray(slopes.T @ slopes)


def _searched(problem: _Problem, starts: np.ndarray) -> _Problem:
    """The problem around its best coordinates, from the best of ``starts``."""
    costs = (problem.rows(problem.outputs(starts)) ** 2).sum(axis=0)
    found = []
    for place in np.argsort(costs)[:_REFINED]:
        begun = _swept(replace(problem, fixed=starts[:, place]))
        x, cost = begun.solved(begun.start(), 8)
        found.append((cost, _at(begun, x)))
    return _settled(min(found, key=lambda each: each[0])[1])


def _cost(problem: _Problem) -> float:
    """The sum of squares."""
    return float((problem.rows(problem.outputs(problem.fixed[:, None])) ** 2).sum())


def _errs(problem: _Problem) -> bool:
    """Whether residuals go on and on to the same side, as they do where the valley is a wrong one."""
    wrong = (problem.outputs(problem.fixed[:, None])[:, :, 0] - problem.measured)[:, problem.usable]
    neighbours = [float(np.corrcoef(each[1:], each[:-1])[0, 1]) for each in wrong]
    return max(neighbours) > _SUSPICIOUS


def _later(problem: _Problem, by: float) -> _Problem:
    """The same with ``by`` [s] more of latency."""
    values = problem.fixed.copy()
    values[COORDINATE_NAMES.index("latency")] = max(values[COORDINATE_NAMES.index("latency")] + by, 0.0)
    return replace(problem, fixed=values)


def _settled(problem: _Problem) -> _Problem:
    """The problem around the bottom of its valley, or of the next one if that is deeper."""
    cost = np.inf
    for _ in range(_SWEEPS):
        before, problem = cost, _swept(problem)
        x, cost = problem.solved(problem.start(), 15)
        problem = _at(problem, x)
        if cost > 0.995 * before:
            break
    return problem


def _swept(problem: _Problem) -> _Problem:
    """The problem around the best of coordinates of which one is moved far: out of the valley of a wrong limit."""
    fitted = to_fit(problem.fixed)[:, None]
    moves = []
    for place, (name, each) in enumerate(COORDINATES.items()):
        if name in problem.names:
            reach = (_LIMIT_MOVES if each.limit else _LOG_MOVES) if each.logarithmic else _MOVES
            moves.append(fitted + np.eye(len(COORDINATE_NAMES))[:, place : place + 1] * reach)
    shift = np.array([-0.03, -0.02, -0.01, 0.01, 0.02, 0.03])  # s from the lag into the latency, or back
    pair = np.repeat(fitted, len(shift), axis=1)
    pair[COORDINATE_NAMES.index("latency")] += shift
    lag = np.maximum(np.exp(fitted[COORDINATE_NAMES.index("lag")]) - shift, 4e-3)
    for name in ("lag", "rise_time"):
        pair[COORDINATE_NAMES.index(name)] += np.log(lag) - fitted[COORDINATE_NAMES.index("lag")]
    tried = problem.lanes(np.concatenate([fitted, *moves, pair], axis=1)[problem.places])
    costs = (problem.rows(problem.outputs(tried)) ** 2).sum(axis=0)
    return replace(problem, fixed=tried[:, int(np.argmin(costs))])


def _problem(base: Robot, found: SoundSignals, averaged: bool) -> _Problem:
    signals = found.signals
    seen, given = signals.velocities, signals.commands
    start, end = min(seen.time[0], given.time[0]) - 0.1, seen.time[-1]
    stimulus = Stimulus.of(given.time, given.v, given.w, start, end)
    since = np.diff(seen.time, prepend=seen.time[0] - np.median(np.diff(seen.time)))
    window = np.where(averaged & (since <= LOG_GAP), since, 0.0)
    measured = np.stack([seen.v, seen.w])
    sheet = values_of(base)
    names = tuple(name for name in COORDINATE_NAMES if name != "dead_band")
    spread = np.array([max(float(np.std(each[found.usable])), 1e-4) for each in measured])
    plain = np.ones(1), np.ones(1)
    # The first weights: a tenth of what was driven, so that the worth of a data sheet is little from the start on
    rim = float((np.abs(given.v) + base.half_axle * np.abs(given.w)).max())
    asked = {"v_max": max(float(np.abs(given.v).max()), 0.05), "w_max": max(float(np.abs(given.w).max()), 0.2)}
    asked["wheel_max"] = max(rim, sheet[COORDINATE_NAMES.index("wheel_max")])
    return _Problem(
        base, stimulus, seen.time, window, measured, found.usable, sheet, names, 0.1 * spread, plain, to_fit(sheet),
        asked,
    )  # fmt: skip


def _at(problem: _Problem, fitted: np.ndarray) -> _Problem:
    """The same around other coordinates."""
    return replace(problem, fixed=problem.lanes(fitted[:, None])[:, 0])


def _starts(problem: _Problem, found: SoundSignals, generator: np.random.Generator) -> np.ndarray:
    """Values (coordinates, lanes) to begin with: around the data sheet, with the delay that correlation tells."""
    base, n = problem.base, _STARTS
    sheet = dict(zip(COORDINATE_NAMES, problem.fixed, strict=True))
    period = float(np.median(np.diff(problem.time)))
    delay = max(found.delay - period / 2, 0.02)
    given, (v, w) = found.signals.commands, problem.measured[:, found.usable]
    rim = np.abs(v) + base.half_axle * np.abs(w)

    def spread(by: float) -> np.ndarray:
        return np.exp(by * generator.standard_normal(n))

    def seldom(low: float, high: float, other: float) -> np.ndarray:
        drawn = np.exp(generator.uniform(np.log(low), np.log(high), n))
        return np.where(generator.uniform(size=n) < 0.5, drawn, other)

    def plateau(measured: np.ndarray, commanded: np.ndarray, other: float) -> np.ndarray:
        """Where commands exceed what was reached, that is a limit in every other start."""
        reached, asked = float(np.quantile(np.abs(measured), 0.995)), float(np.abs(commanded).max())
        limits = reached * (1 + 0.02 * generator.standard_normal(n))
        free = np.clip(other, 1.2 * asked, 2 * asked)
        return np.where((generator.uniform(size=n) < 0.7) & (asked > 1.02 * reached), limits, free)

    lag = delay * generator.uniform(0.05, 1.0, n)
    values = {
        "latency": np.clip(delay - lag, 0.0, 0.9),
        "lag": np.clip(lag, 3e-3, 1.5),
        "rise_time": np.clip(lag * spread(0.4), 0.02, 1.5),
        "motor_time": sheet["motor_time"] * spread(0.4),
        "gyration": np.maximum(sheet["gyration"] * spread(0.2), 1.01 * least_gyration(base)),
        "friction": np.minimum(sheet["friction"] * spread(0.5), 2.9),
        "v_max": plateau(v, given.v, sheet["v_max"]),
        "w_max": plateau(w, given.w, sheet["w_max"]),
        "wheel_max": plateau(rim, np.abs(given.v) + base.half_axle * np.abs(given.w), sheet["wheel_max"]),
        "v_rate_max": seldom(0.15, 10.0, sheet["v_rate_max"]),
        "w_rate_max": seldom(0.5, 60.0, sheet["w_rate_max"]),
        "force_limit": sheet["force_limit"] * spread(0.4),
    }
    return np.stack([values.get(name, np.full(n, sheet[name])) * np.ones(n) for name in COORDINATE_NAMES])


def _whitened(problem: _Problem) -> _Problem:
    """The same with its residuals' autoregression and scale."""
    outputs = problem.outputs(problem.fixed[:, None])[:, :, 0]
    wrong = (outputs - problem.measured)[:, problem.usable]
    filters, scales = [], []
    for each, size in zip(wrong, problem.measured, strict=True):
        coefficients, left = autoregression(each)
        filters.append(np.concatenate([[1.0], -coefficients]))
        scales.append(max(left, _BEST * float(np.std(size)), 1e-9))
    return replace(problem, filters=(filters[0], filters[1]), scale=np.array(scales))


def autoregression(series: np.ndarray) -> tuple[np.ndarray, float]:
    """The coefficients by which a series (n,) follows from what was before, and the deviation of what it leaves.

    The order is Akaike's choice. Burg's and other methods differ little at such lengths; this one is least squares.
    """
    best: tuple[float, np.ndarray, float] = (np.inf, np.zeros(0), float(np.std(series)))
    most = min(_ORDER, len(series) // 20)
    late = series[most:]
    columns = np.stack([series[most - k : len(series) - k] for k in range(1, most + 1)], axis=1)
    for order in range(most + 1):
        coefficients = np.linalg.lstsq(columns[:, :order], late, rcond=None)[0] if order else np.zeros(0)
        left = late - columns[:, :order] @ coefficients
        variance = float((left**2).mean())
        score = len(late) * np.log(max(variance, 1e-300)) + 2 * order
        if score < best[0]:
            best = score, coefficients, float(np.sqrt(variance))
    return best[1], best[2]


# The dead band ----------------------------------------------------------------------------------------------------


def _dead_band(problem: _Problem) -> tuple[float, Ends]:
    """The dead band of least squares with all else held, and its interval: it has no derivative."""
    held = problem.stimulus.held()
    rims = np.abs(
        np.concatenate([held[0] + problem.base.half_axle * held[1], held[0] - problem.base.half_axle * held[1]])
    )
    levels = np.unique(np.round(rims[(rims > 1e-4) & (rims < 0.5 * rims.max())], 5))
    if not len(levels):
        return 0.0, Ends(0.0, float(rims[rims > 1e-4].min(initial=np.inf)))
    if len(levels) > _DEAD_LEVELS:
        levels = levels[np.unique(np.geomspace(1, len(levels), _DEAD_LEVELS).astype(int) - 1)]
    tried = np.concatenate([[0.0], (levels[:-1] + levels[1:]) / 2, [1.01 * levels[-1]]])
    lanes = np.repeat(problem.fixed[:, None], len(tried), axis=1)
    lanes[DEAD] = tried
    data = 2 * len(problem.time)
    solver = _inverse(problem.slopes(problem.start()))[:, :data]
    costs = np.full(len(tried), np.inf)
    for _ in range(3):  # the others follow
        left = problem.rows(problem.outputs(lanes))
        costs = np.minimum(costs, (left**2).sum(axis=0))
        fitted = to_fit(lanes)
        fitted[problem.places] -= np.clip(solver @ left, -0.2, 0.2)
        lanes = problem.lanes(fitted[problem.places])
        lanes[DEAD] = tried
    count = np.count_nonzero(problem.usable) * 2 - len(problem.names)
    levels_of = np.array([_SURE, *(CONFIDENCE,) * (len(tried) - 1)])
    near = costs <= costs.min() + f_distribution.ppf(levels_of, 1, count) * max(costs.min() / count, 1.0)
    inside = np.flatnonzero(near)
    edges = np.concatenate([[0.0], levels])
    high = float(levels[inside[-1]]) if inside[-1] < len(levels) else np.inf
    ends = Ends(float(edges[inside[0]]), high)
    return (0.0 if inside[0] == 0 else float(tried[int(np.argmin(costs))])), ends


def _with_dead_band(problem: _Problem) -> _Problem:
    """The same with its best dead band, fitted again if there is one."""
    band, _ = _dead_band(problem)
    if band == problem.fixed[DEAD]:
        return problem
    values = problem.fixed.copy()
    values[DEAD] = band
    problem = replace(problem, fixed=values)
    return _at(problem, problem.solved(problem.start(), 10)[0])


# Profiles ---------------------------------------------------------------------------------------------------------


def _profiled(problem: _Problem) -> tuple[dict[str, Ends], _Problem]:
    """The interval of each fitted coordinate; and the problem around the best that was met on the way."""
    x = _bound(problem).start()
    for attempt in range(2):
        slopes, rows = problem.slopes(x), problem.residuals(x[:, None])[:, 0]
        thresholds = _thresholds(problem, slopes, rows)
        distances, least = _ends(problem, x, slopes, rows, thresholds)
        if attempt or least is None:
            break
        x = problem.solved(least, 8)[0]
        problem = _at(problem, x)
    low, high = (from_fit(_all(problem, x + side)) for side in distances)
    found = {}
    for j, name in enumerate(problem.names):
        place = COORDINATE_NAMES.index(name)
        ends = [float(low[place]), float(high[place])]
        if not np.isfinite(distances[0][j]):
            ends[0] = 0.0
        asked = {"v_rate_max": "v_max", "w_rate_max": "w_max"}.get(name)
        at_once = asked is not None and ends[0] * _AT_ONCE > problem.asked[asked]
        if not np.isfinite(distances[1][j]) or at_once:
            ends[1] = np.inf
        found[name] = Ends(*ends)
    return found, problem


def _unbiased(
    problem: _Problem, intervals: dict[str, Ends], counts: float, generator: np.random.Generator
) -> tuple[dict[str, Ends], _Problem]:
    """Take off what coarse encoders in the wheel loops do to the fit of a model whose encoders are fine.

    Models with the robot's own encoders, with coordinates drawn from the intervals, are fitted by one step of Gauss and
    Newton: the mean of by how much they err is taken off, and the intervals are wider by its spread.
    """
    x, n = problem.start(), len(problem.names)
    places = problem.places
    ends = np.array([[*intervals[name]] for name in problem.names])
    low, high = (np.where(np.isfinite(each) & (each > 0), each, problem.fixed[places]) for each in ends.T)
    whole = np.repeat(problem.fixed[:, None], 2, axis=1)
    whole[places] = np.stack([low, high], axis=1)
    width = np.abs(np.diff(to_fit(whole)[places], axis=1)) / 4
    lanes = problem.lanes(x[:, None] + np.minimum(width, 0.05) * generator.standard_normal((n, _IMITATIONS)))
    coarse = sampled(drive(problem.base, lanes, problem.stimulus, counts), problem.time, problem.window)
    wrong = _inverse(problem.slopes(x))[:, : 2 * len(problem.time)] @ (
        problem.rows(coarse) - problem.rows(problem.outputs(lanes))
    )
    bias, spread = wrong.mean(axis=1), 2 * wrong.std(axis=1)
    moved = {}
    for j, name in enumerate(problem.names):
        sides = []
        for end, side in zip(intervals[name], (-1.0, 1.0), strict=True):
            if np.isfinite(end) and end > 0 and not (name in LIMIT_NAMES and not np.isfinite(intervals[name].high)):
                log = COORDINATES[name].logarithmic
                at = (np.log(end) if log else end) - x[j]
                to = x[j] - bias[j] + side * float(np.hypot(at, spread[j]))
                end = float(np.exp(to) if log else max(to, 0.0))
            sides.append(end)
        moved[name] = Ends(*sides)
    fixed = np.array([name in LIMIT_NAMES and not np.isfinite(intervals[name].high) for name in problem.names])
    return moved, _at(problem, x - np.where(fixed, 0.0, bias))


def _bound(problem: _Problem) -> _Problem:
    """The problem with each limit that does not act as low as it can be without acting."""
    values = problem.fixed.copy()
    for name in LIMIT_NAMES:
        if name not in problem.names:
            continue
        place = COORDINATE_NAMES.index(name)
        lanes = np.repeat(values[:, None], 33, axis=1)
        lanes[place] = values[place] * np.append(np.exp(-np.linspace(0.0, 7.0, 32)), 1.01)
        costs = (problem.rows(problem.outputs(lanes)) ** 2).sum(axis=0)
        if abs(costs[-1] - costs[0]) < 1e-3:
            same = np.abs(costs[:-1] - costs[0]) < 1e-2
            values[place] = lanes[place, int(np.argmin(same)) - 1 if not same.all() else -2]
    return replace(problem, fixed=values)


def _all(problem: _Problem, fitted: np.ndarray) -> np.ndarray:
    values = to_fit(problem.fixed)
    values[problem.places] = np.where(np.isfinite(fitted), fitted, 0.0)
    return values


def _thresholds(problem: _Problem, slopes: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """By how much the sum of squares may rise at the ends of each interval (fitted,)."""
    count = 2 * np.count_nonzero(problem.usable) - len(problem.names)
    data = slice(0, 2 * len(problem.time))
    variance = max(float((rows[data] ** 2).sum()) / count, 1.0)
    inverse = np.linalg.pinv(slopes.T @ slopes, rcond=1e-11, hermitian=True)
    part = slopes[data].reshape(2, -1, slopes.shape[1])
    robust = np.diag(long_run(part, rows[data].reshape(2, -1), inverse))
    wider = np.maximum(robust / np.maximum(variance * np.diag(inverse), 1e-300), 1.0)
    return np.asarray(f_distribution.ppf(CONFIDENCE, 1, count) * variance * wider)


def _inverse(slopes: np.ndarray) -> np.ndarray:
    """The pseudo-inverse (fitted, rows) of slopes, by the normal equations; directions without effect stay."""
    return np.linalg.pinv(slopes.T @ slopes, rcond=1e-11, hermitian=True) @ slopes.T


def long_run(slopes: np.ndarray, rows: np.ndarray, inverse: np.ndarray | None = None) -> np.ndarray:
    """The covariance (fitted, fitted) of least squares whose residuals may be correlated, by Newey and West.

    Args:
        slopes: The derivatives of each channel (channels, n, fitted).
        rows: The residuals (channels, n).
        inverse: Of the sum of the products of all slopes, where there are others besides.
    """
    if inverse is None:
        inverse = np.linalg.pinv(np.einsum("cni,cnj->ij", slopes, slopes), hermitian=True)
    total = np.zeros_like(inverse)
    for score in slopes * rows[..., None]:
        total += score.T @ score
        for late in range(1, _LONG_RUN + 1):
            cross = score[late:].T @ score[:-late]
            total += (1 - late / (_LONG_RUN + 1)) * (cross + cross.T)
    return np.asarray(inverse @ total @ inverse)


def _ends(
    problem: _Problem, x: np.ndarray, slopes: np.ndarray, rows: np.ndarray, thresholds: np.ndarray
) -> tuple[list[np.ndarray], np.ndarray | None]:
    """How far each coordinate can be moved down and up (fitted,), and coordinates that are better than ``x``, if met.

    The others follow by steps of Gauss and Newton with the slopes at ``x``.
    """
    n, low, high = len(x), *problem.bounds()
    base = float(rows @ rows)
    solvers, ways = [], np.zeros((n, n))  # ways[:, j]: how the others follow coordinate j
    for j in range(n):
        others = [k for k in range(n) if k != j]
        solver = np.zeros((n, len(rows)))
        solver[others] = _inverse(slopes[:, others])
        solvers.append(solver)
        ways[:, j] = -solver @ slopes[:, j]
        ways[j, j] = 1.0
    lanes = [(j, side) for side in (-1.0, 1.0) for j in range(n)]
    of, sign = np.array([j for j, _ in lanes]), np.array([side for _, side in lanes])
    curve = np.array([float(np.sum((slopes @ ways[:, j]) ** 2)) for j in range(n)])
    distance = np.minimum(np.sqrt(thresholds / np.maximum(curve, 1e-12)), 0.5)[of]
    room = np.where(sign < 0, x[of] - low[of], high[of] - x[of])
    limit = np.array([COORDINATE_NAMES[p] in LIMIT_NAMES for p in problem.places])[of]
    room = np.minimum(room, np.where(limit & (sign > 0), _FAR, np.where(limit, 12.0, 4.0)))
    inner, outer = np.zeros(len(lanes)), np.full(len(lanes), np.inf)
    rise_in, rise_out = np.zeros(len(lanes)), np.full(len(lanes), np.inf)
    follow = ways[:, of] * sign  # (n, lanes): a unit of distance moves the coordinates so
    least: tuple[float, np.ndarray] | None = None
    for _ in range(_ROUNDS):
        distance = np.minimum(distance, room)
        at = x[:, None] + follow * distance
        left = problem.residuals(at)
        step = np.stack([solvers[j] @ left[:, k] for k, j in enumerate(of)], axis=1)
        nearer = at - np.clip(step, -0.3, 0.3)
        costs, again = ((each**2).sum(axis=0) for each in (left, problem.residuals(nearer)))
        at, costs = np.where(again < costs, nearer, at), np.minimum(again, costs)
        if costs.min() < base - 0.25 * thresholds.min() and (least is None or costs.min() < least[0]):
            least = float(costs.min()), at[:, int(np.argmin(costs))]
        follow = (at - x[:, None]) / np.maximum(distance, 1e-9)
        rise = costs - base
        above = rise > thresholds[of]
        outer, rise_out = np.where(above, distance, outer), np.where(above, rise, rise_out)
        inner, rise_in = np.where(above, inner, distance), np.where(above, rise_in, np.maximum(rise, 0.0))
        root = np.sqrt(thresholds[of])
        growth = np.clip(root / np.sqrt(np.maximum(rise, 1e-12)), 0.3, 4.0)
        a, b = np.sqrt(rise_in), np.sqrt(np.where(np.isfinite(rise_out), rise_out, 0.0))
        share = np.clip((root - a) / np.maximum(b - a, 1e-12), 0.1, 0.9)
        bracketed = np.isfinite(outer)
        span = np.where(bracketed, outer, 0.0) - inner
        distance = np.where(bracketed, inner + share * span, np.maximum(inner, 1e-9) * np.maximum(growth, 1.3))
    ends = np.where(np.isfinite(outer), distance, np.inf)
    ends = np.where(~np.isfinite(outer) & ~limit, room, ends)  # the edge of what is possible
    return [-ends[:n], ends[n:]], least and least[1]
