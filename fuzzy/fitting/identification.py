"""A Sugeno system from data: its antecedents come from a grid, subtractive clustering or fuzzy c-means.

The consequents follow by least squares (:mod:`fuzzy.fitting.consequents`). Names, formulas and the order of the rules
are those of MATLAB's ``genfis``.
"""

import math
import warnings
from collections.abc import Callable, Sequence
from inspect import signature
from itertools import product
from typing import Any, Literal, NamedTuple

import numpy as np

from fuzzy.errors import shortened
from fuzzy.extras import needed
from fuzzy.fitting.clustering import (
    ClusteringOptions,
    DataWarning,
    column_ranges,
    finite_table,
    subtractive_clusters,
)
from fuzzy.fitting.consequents import IdentificationError, fit_consequents, output_table
from fuzzy.membership import Gaussian, membership_function
from fuzzy.membershipfunction import MATLAB_NAMES, MembershipFunction
from fuzzy.naming import check_known
from fuzzy.rule import Clause, Rule
from fuzzy.system import Constant, Linear, Sugeno, Variable

__all__ = ["Data", "IdentificationError", "Partition", "cluster_partition", "fit_consequents", "identify"]

_MANY_RULES = 5_000  # more would take minutes to fit, and nobody could read them


class Data(NamedTuple):
    """Samples that have been checked, with the names of their columns."""

    x: np.ndarray  # (samples, inputs)
    y: np.ndarray  # (samples, outputs)
    low: np.ndarray  # (inputs + outputs,) lowest values, in the data's units
    high: np.ndarray  # (inputs + outputs,) highest values, above the lowest ones
    inputs: Sequence[tuple[str, str]]  # name and unit
    outputs: Sequence[tuple[str, str]]

    @property
    def ranges(self) -> np.ndarray:
        """The lowest and highest values (2, inputs + outputs), for :func:`fuzzy.fitting.clustering.densities`."""
        return np.stack([self.low, self.high])


class Partition(NamedTuple):
    """The antecedents of a system: the terms of each input, and which of them each rule joins."""

    terms: Sequence[Sequence[MembershipFunction]]  # one sequence an input
    rules: Sequence[tuple[int, ...]]  # (rules, inputs) places of terms; -1 where the rule does not ask for the input
    word: str  # of which the terms' names are made: in1mf1, in1cluster1


def identify(
    x: Any,
    y: Any,
    method: Literal["grid", "subtractive", "fcm"] = "grid",
    *,
    input_names: Sequence[str] | None = None,
    output_names: Sequence[str] | None = None,
    input_units: Sequence[str] | None = None,
    output_units: Sequence[str] | None = None,
    name: str = "identified",
    order: Literal[0, 1] = 1,
    fit: bool = True,
    ridge: float = 0.0,
    **settings: Any,
) -> Sugeno:
    """Make a Sugeno system that gives ``y`` at ``x``.

    The universes are the ranges of the data; that of a constant column is a little wider, with a DataWarning. The
    methods and their settings are:

    - "grid" makes one rule for each combination of terms, the last input varying fastest (see :func:`grid_terms`).
      ``mfs`` is the number of terms (2) and ``kind`` the membership function by MATLAB's name ("gbellmf"), each one
      value or one for each input.
    - "subtractive" makes one rule, and one Gaussian per input, for each cluster of [x y]. ``radius`` (0.5) and
      ``options`` (:class:`fuzzy.fitting.clustering.ClusteringOptions`) are those of the clustering.
    - "fcm" does so for clusters of fuzzy c-means: ``clusters`` ("auto" for as many as
      subtractive clustering finds), ``exponent`` (2), ``iterations`` (100), ``improvement`` (1e-5) and ``seed`` (0; an
      int or a numpy Generator).

    Args:
        x: The inputs (samples, inputs), in any units.
        y: The outputs (samples,) or (samples, outputs), in any units.
        method: "grid", "subtractive" or "fcm".
        input_names: The names of the inputs; input1, input2 and so on by default.
        output_names: The names of the outputs; output1, output2 and so on by default.
        input_units: The units of the inputs, which are labels.
        output_units: The units of the outputs, which are labels.
        name: The name of the system.
        order: 1 for linear consequents, 0 for constants.
        fit: Whether the consequents are fitted by least squares; otherwise they are 0, as in MATLAB's grid.
        ridge: See :func:`fuzzy.fitting.consequents.fit_consequents`.
        settings: The settings of the method.

    Returns:
        The system.

    Raises:
        ClusteringError: Data or settings that clustering cannot use.
        IdentificationError: Shapes that do not fit, or settings that the method does not have.
    """
    data = checked(x, y, input_names, output_names, input_units, output_units)
    check_known(method, _METHODS, "method", IdentificationError)
    known = list(signature(_METHODS[method]).parameters)[1:]
    for setting in settings:
        check_known(setting, known, "setting", IdentificationError, where=method)
    fis = system_of(_METHODS[method](data, **settings), data, name, order)
    return fit_consequents(fis, data.x, data.y, ridge) if fit else fis


def checked(
    x: Any,
    y: Any,
    input_names: Sequence[str] | None = None,
    output_names: Sequence[str] | None = None,
    input_units: Sequence[str] | None = None,
    output_units: Sequence[str] | None = None,
) -> Data:
    """Check samples, names and units as :func:`identify` takes them. Warns (DataWarning) of constant columns."""
    x = finite_table(x, "x", input_names if input_names and np.shape(x)[1:] == (len(input_names),) else None)
    y = output_table(y, output_names)
    if len(x) != len(y):
        raise IdentificationError(f"x has {len(x)} samples, y {len(y)}")
    inputs = _named(x.shape[1], input_names, input_units, "input")
    outputs = _named(y.shape[1], output_names, output_units, "output")
    low, high = column_ranges(np.concatenate([x, y], axis=1), [label for label, _ in (*inputs, *outputs)])
    return Data(x, y, low, high, inputs, outputs)


def _named(
    count: int, names: Sequence[str] | None, units: Sequence[str] | None, what: str
) -> Sequence[tuple[str, str]]:
    names = [f"{what}{i + 1}" for i in range(count)] if names is None else list(names)
    units = [""] * count if units is None else list(units)
    for given, kind in ((names, "names"), (units, "units")):
        if len(given) != count:
            raise IdentificationError(f"{len(given)} {kind} for {count} {what}s: {', '.join(map(str, given))}")
    return list(zip(names, units, strict=True))


def system_of(partition: Partition, data: Data, name: str = "identified", order: int = 1) -> Sugeno:
    """Make a system of these antecedents. Each rule has its own consequent for every output, and all of them are 0."""
    if order not in (0, 1):
        raise IdentificationError(f"order must be 0 (constants) or 1 (linear), got {order!r}")
    inputs = [
        Variable(label, (low, high), {f"in{i}{partition.word}{k}": f for k, f in enumerate(terms, 1)}, unit)
        for i, ((label, unit), low, high, terms) in enumerate(
            zip(data.inputs, data.low, data.high, partition.terms, strict=False), 1
        )
    ]
    zero: Any = Linear((0.0,) * len(inputs), 0.0) if order else Constant(0.0)
    count = len(partition.rules)
    first = len(inputs)
    outputs = [
        Variable(label, (low, high), {f"out{j}{partition.word}{k}": zero for k in range(1, count + 1)}, unit)
        for j, ((label, unit), low, high) in enumerate(
            zip(data.outputs, data.low[first:], data.high[first:], strict=True), 1
        )
    ]
    asked, proposed = ([(v.name, list(v.terms)) for v in variables] for variables in (inputs, outputs))
    rules = [
        Rule(
            tuple(Clause(name, terms[t]) for (name, terms), t in zip(asked, rule, strict=True) if t >= 0),
            tuple((name, terms[k]) for name, terms in proposed),
        )
        for k, rule in enumerate(partition.rules)
    ]
    return Sugeno(inputs, outputs, rules, name)


# The grid ------------------------------------------------------------------------------------------------------


def grid_terms(kind: str, low: float, high: float, count: int) -> list[MembershipFunction]:
    """Make ``count`` terms of a grid, whose centers are spread evenly from ``low`` to ``high``   [MATLAB genfis].

    The class of a membership function states its parameters (``grid``) from the center c, the half distance h of the
    centers and the slope 10 count/(high − low). Neighbours cross at 0.5 (dsigmf, psigmf: within 5e-5).

    Args:
        kind: The membership function by MATLAB's name, one that states a ``grid``.
        low: The lowest center, in the unit of the input.
        high: The highest center, above ``low``.
        count: The number of terms, at least 2.
    """
    known = {name: function.grid for name, function in MATLAB_NAMES.items() if function.grid is not None}
    check_known(kind, known, "kind of membership function for a grid", IdentificationError)
    h = (high - low) / (2 * (count - 1))
    slope = 10 * count / (high - low)
    return [membership_function(kind, known[kind](float(c), h, slope)) for c in np.linspace(low, high, count)]


def _grid(data: Data, mfs: int | Sequence[int] = 2, kind: str | Sequence[str] = "gbellmf") -> Partition:
    counts = _each(mfs, len(data.inputs), "mfs")
    kinds = _each(kind, len(data.inputs), "kind")
    for (label, _), count in zip(data.inputs, counts, strict=True):
        if isinstance(count, bool) or not isinstance(count, (int, np.integer)) or count < 2:
            raise IdentificationError(f"mfs of {label} must be a whole number >= 2, got {count!r}")
    total = math.prod(int(count) for count in counts)
    if total > _MANY_RULES:
        told = str(total) if total < 10**9 else f"about 10^{math.log10(total):.0f}"
        raise IdentificationError(
            f"a grid of {shortened(' × '.join(map(str, counts)))} has {told} rules, more than {_MANY_RULES}; "
            "take fewer mfs, fewer inputs, or method 'subtractive'"
        )
    terms = [grid_terms(*each) for each in zip(kinds, data.low, data.high, counts, strict=False)]
    return Partition(terms, list(product(*(range(count) for count in counts))), "mf")


def _each(value: Any, count: int, what: str) -> list[Any]:
    values = [value] * count if isinstance(value, str) or np.ndim(value) == 0 else list(value)
    if len(values) != count:
        raise IdentificationError(f"{what} must be one value or one for each of {count} inputs, got {len(values)}")
    return values


# The clusters --------------------------------------------------------------------------------------------------


def cluster_partition(centers: np.ndarray, sigma: np.ndarray, inputs: int) -> Partition:
    """Make one rule, and one Gaussian per input, for each cluster.

    Args:
        centers: The centers (clusters, columns), with the columns of the inputs first, in the units of the data.
        sigma: The widths (columns,), or (clusters, columns) if every cluster has its own.
        inputs: The number of columns that are inputs.
    """
    widths = np.broadcast_to(sigma, centers.shape)
    terms = [
        [Gaussian(float(s), float(c)) for s, c in zip(widths[:, i], centers[:, i], strict=True)] for i in range(inputs)
    ]
    return Partition(terms, [(k,) * inputs for k in range(len(centers))], "cluster")


def _subtractive(
    data: Data, radius: float | Sequence[float] = 0.5, options: ClusteringOptions | None = None
) -> Partition:
    both = np.concatenate([data.x, data.y], axis=1)
    found = subtractive_clusters(both, radius, options=options, ranges=data.ranges)
    return cluster_partition(found.centers, found.sigma, len(data.inputs))


def _fcm(
    data: Data,
    clusters: int | Literal["auto"] = "auto",
    exponent: float = 2.0,
    iterations: int = 100,
    improvement: float = 1e-5,
    seed: int | np.random.Generator = 0,
) -> Partition:
    """Cluster [x y] by fuzzy c-means, scaled into [0, 1] by the ranges so that units do not matter.

    (MATLAB does not scale.) The center of a cluster is the mean of the samples, weighted by their memberships in the
    cluster to the power of ``exponent``. The width of its Gaussian is their standard deviation with the same weights,
    and at least a thousandth of the range. (MATLAB's formula is not documented.)
    """
    samples = len(data.x)
    count = len(_subtractive(data).rules) if clusters == "auto" else clusters
    if isinstance(count, bool) or not isinstance(count, (int, np.integer)) or count < 1:
        raise IdentificationError(f"clusters must be 'auto' or a whole number >= 1, got {clusters!r}")
    if count > samples:
        raise IdentificationError(f"{count} clusters, but only {samples} samples")
    for label, value, least in (
        ("exponent", exponent, 1),
        ("iterations", iterations, 0),
        ("improvement", improvement, 0),
    ):
        if not (isinstance(value, (int, float)) and math.isfinite(value) and value > least):
            raise IdentificationError(f"{label} must be a finite number > {least}, got {value!r}")
    cmeans = needed("skfuzzy.cluster", "fuzzy c-means", "scikit-fuzzy").cmeans  # here: it brings networkx and scipy
    span = data.high - data.low
    unit = (np.concatenate([data.x, data.y], axis=1) - data.low) / span
    start = np.random.default_rng(seed).random((count, samples))
    start /= start.sum(axis=0)
    centers, membership, *_ = cmeans(unit.T, count, exponent, improvement, iterations, init=start)
    share = membership**exponent
    share /= share.sum(axis=1, keepdims=True)
    deviation = np.stack([s @ (unit - c) ** 2 for s, c in zip(share, centers, strict=True)])
    sigma = np.maximum(np.sqrt(deviation), 1e-3) * span
    if len(np.unique(np.round(centers, 9), axis=0)) < count:
        warnings.warn(f"some of the {count} clusters coincide: fewer would do", DataWarning, stacklevel=3)
    return cluster_partition(data.low + centers * span, sigma, len(data.inputs))


_METHODS: dict[str, Callable[..., Partition]] = {"grid": _grid, "subtractive": _subtractive, "fcm": _fcm}
