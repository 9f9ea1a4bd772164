"""A rule base from samples of a teacher: clusters, least squares, hybrid learning; thesis 5.2.2.

A rule base of pairs says one number of each other robot, of which the least holds; the teacher shows only that one
number. Who of the others it was for is found as in learning from sets of instances [Dietterich et al. 1997]: it is the
one for whom the present rule base says least, and of the rest the rule base must only say no less.

T. G. Dietterich, R. H. Lathrop, T. Lozano-Pérez, "Solving the multiple instance problem with axis-parallel
rectangles", Artificial Intelligence 89 (1997).
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

import anfis
from fuzzy.compiled.sugeno import compile_sugeno
from fuzzy.fitting.clustering import ClusteringOptions as Clustering
from fuzzy.fitting.clustering import densities, select_centers
from fuzzy.fitting.consequents import least_squares
from fuzzy.fitting.identification import Data, cluster_partition, system_of
from fuzzy.fitting.termnames import with_telling_names
from fuzzy.system import Linear, Sugeno
from robotics.laws.rules.quantities import quantity_of
from robotics.laws.rules.situation import NOTHING_NEAR
from robotics.plugins.learning.demonstrations import Demonstrations
from robotics.plugins.learning.lesson import COMMAND_UNITS, ImitationPlan

RULE_RADII = (0.2, 0.35, 0.6, 0.9)  # of the clusters, as shares of each column's range: all are tried
_LARGEST = 6000  # samples that are learnt from; more would be slow, and say little more
RARE = 0.002  # the share of samples below a universe, and of those above it
FREE = 0.6  # m/s: what is said of another robot that does not matter; thrice what timings ask for
GUESSES = 4  # times that the robot for which the teacher's number was is guessed anew


class Fitted(NamedTuple):
    """A rule base that was fitted, and how well."""

    system: Sugeno
    samples: int  # that were learnt from
    radius: float  # of the clusters
    train: np.ndarray  # (outputs,) RMSE, in each output's unit
    check: np.ndarray  # (outputs,) RMSE on the checking seeds' samples


def fitted(lesson: ImitationPlan, samples: Demonstrations, radius: float, step: Callable[[], None]) -> Fitted:
    """Fit a rule base to samples.

    Args:
        lesson: What is learnt, and how; its checking seeds' samples are not learnt from.
        samples: The samples.
        radius: That of the clusters, as a share of each column's range.
        step: Called after every epoch.
    """
    checking = np.isin(samples.seed, lesson.checking)
    of_pairs = lesson.of_pairs
    train = _some(samples.where(~checking), _LARGEST, of_pairs)
    check = _some(samples.where(checking), _LARGEST // 2, of_pairs)
    if of_pairs:
        system = _guessed(lesson, train, radius)
        said, shown = _wanted(system, train), _wanted(system, check)
    else:
        said, shown = train.said, check.said
        system = _clustered(lesson, _data(lesson, train.known, said), radius)
    data = _data(lesson, train.known, said)
    system = _trained(lesson, system, data, (np.clip(check.known, *_limits(data)), shown), step)
    return Fitted(system, len(train.known), radius, rmse(system, train, of_pairs), rmse(system, check, of_pairs))


def _some(samples: Demonstrations, most: int, of_pairs: bool) -> Demonstrations:
    """About ``most`` of the samples, whole moments drawn at random, the same ones for the same samples.

    Of pairs, moments in which a teacher holds a robot back are few, and they are what there is to learn: up to half of
    the samples are theirs.
    """
    if len(samples.known) <= most:
        return samples
    rng = np.random.default_rng(len(samples.said))
    count = max(1, most * len(samples.said) // len(samples.known))
    order = rng.permutation(len(samples.said))
    if of_pairs:
        held_back = order[samples.held_back[order]][: count // 2]
        free = order[~samples.held_back[order]]
        order = np.concatenate([held_back, free])
    chosen = np.zeros(len(samples.said), dtype=bool)
    chosen[order[:count]] = True
    return samples.where(chosen)


def _data(lesson: ImitationPlan, known: np.ndarray, said: np.ndarray) -> Data:
    """The samples, with universes that hold all but the rarest of them; others are clipped, as when it drives."""
    names = [(name, quantity_of(name, "inputs").unit) for name in lesson.inputs]
    outputs = [(name, COMMAND_UNITS[name]) for name in lesson.outputs]
    low, high = np.transpose([_universe(column) for column in np.concatenate([known, said], axis=1).T])
    count = known.shape[1]
    clipped = np.clip(known, low[:count], high[:count]), np.clip(said, low[count:], high[count:])
    return Data(*clipped, low, high, names, outputs)


def _limits(data: Data) -> tuple[np.ndarray, np.ndarray]:
    count = data.x.shape[1]
    return data.low[:count], data.high[:count]


def _universe(values: np.ndarray) -> tuple[float, float]:
    """The lowest and the highest of ``values`` (samples,) but for the rarest, in round numbers.

    NOTHING_NEAR is what is told where there is nothing to tell: it has no place of its own beyond the others.
    """
    told = values[np.abs(values) < NOTHING_NEAR]
    low, high = np.quantile(told if len(told) else values, [RARE, 1 - RARE]).tolist()
    if high - low < 1e-9:
        low, high = low - 0.5, high + 0.5
    unit = 10.0 ** np.floor(np.log10(high - low) - 1)
    return round(float(np.floor(low / unit) * unit), 9), round(float(np.ceil(high / unit) * unit), 9)


def _clustered(lesson: ImitationPlan, data: Data, radius: float) -> Sugeno:
    """A system of the wanted number of rules from clusters of that radius, its consequents by least squares.

    Of wide clusters there may be fewer.
    """
    both = np.concatenate([data.x, data.y], axis=1)
    found = select_centers(
        densities(both, radius, ranges=data.ranges), Clustering(accept=0.0, reject=0.0), most=lesson.rules
    )
    partition = cluster_partition(found.centers, found.sigma, data.x.shape[1])
    system = system_of(partition, data, lesson.name)
    return least_squares(system, data.x, data.y, lesson.options.ridge).fis


def _trained(
    lesson: ImitationPlan,
    system: Sugeno,
    data: Data,
    held: tuple[np.ndarray, np.ndarray],
    step: Callable[[], None],
) -> Sugeno:
    """The system after hybrid learning, each output counted in its range; named, and fit to drive by."""
    spans = (data.high - data.low)[data.x.shape[1] :]
    training = anfis.train(
        _scaled(system, 1 / spans),
        data.x,
        data.y / spans,
        lesson.options,
        check=(held[0], held[1] / spans),
        callback=lambda _: step(),
    )
    return with_telling_names(replace(_scaled(training.system, spans), out_of_range="clip"))


def _scaled(system: Sugeno, factors: np.ndarray) -> Sugeno:
    """The system with each output multiplied by a factor > 0."""
    outputs = []
    for variable, factor in zip(system.outputs, factors.tolist(), strict=True):
        terms: dict[str, Any] = {
            name: Linear(tuple(slope * factor for slope in term.slopes), term.constant * factor)
            for name, term in variable.terms.items()
            if isinstance(term, Linear)
        }
        low, high = variable.universe
        outputs.append(replace(variable, terms=terms, universe=(low * factor, high * factor)))
    return replace(system, outputs=outputs)


def _said(system: Sugeno, x: np.ndarray) -> np.ndarray:
    """What the system says at ``x`` (samples, inputs), outside its universes as when it drives."""
    return np.asarray(compile_sugeno(replace(system, out_of_range="clip"))(np.ascontiguousarray(x)))


def rmse(system: Sugeno, samples: Demonstrations, of_pairs: bool) -> np.ndarray:
    """The RMSE (outputs,) of ``system`` over the moments of ``samples``, in each output's unit.

    Of pairs it is that of the least that is said; where the teacher does not hold a robot back, no more is no error.
    """
    said = _said(system, samples.known)
    if not of_pairs:
        return np.sqrt(np.mean((said - samples.said[samples.moment]) ** 2, axis=0))
    off = _least(said[:, 0], samples) - samples.said[:, 0]
    # Where the teacher holds a robot back for nobody, any speed that is no less will do
    off = np.where(samples.held_back, off, np.minimum(off, 0.0))
    return np.sqrt(np.mean(off**2, keepdims=True))


def _guessed(lesson: ImitationPlan, train: Demonstrations, radius: float) -> Sugeno:
    """A system from clusters, after guessing some times for whom of the others the teacher's speed was."""
    wanted = np.where(train.held_back[train.moment, None], train.said[train.moment], FREE)
    system = _clustered(lesson, _data(lesson, train.known, wanted), radius)
    for _ in range(GUESSES):
        system = _clustered(lesson, _data(lesson, train.known, _wanted(system, train)), radius)
    return system


def _wanted(system: Sugeno, samples: Demonstrations) -> np.ndarray:
    """What should be said of each other robot (samples, 1) [m/s].

    Where the teacher holds the robot back: the teacher's speed for the one of whom the least is said, and of the others
    no less. Where it does not: FREE.
    """
    said = _said(system, samples.known)[:, 0]
    shown, held_back = samples.said[samples.moment, 0], samples.held_back[samples.moment]
    least = said <= _least(said, samples)[samples.moment]
    wanted = np.where(least, shown, np.clip(said, shown, FREE))
    return np.where(held_back, wanted, FREE)[:, None]


def _least(said: np.ndarray, samples: Demonstrations) -> np.ndarray:
    """The least of what is ``said`` (samples,) of the other robots in each moment (moments,)."""
    least = np.full(len(samples.said), np.inf)
    np.minimum.at(least, samples.moment, said)
    return least
