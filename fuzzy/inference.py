"""The one inference: a Sugeno system at one point or a batch of points, with every layer in between.

The same code serves design, plots, simulation and learning, with numpy or torch arrays.
"""

import itertools
import sys
import warnings
from collections.abc import Sequence
from dataclasses import fields, replace
from typing import Any, NamedTuple

import numpy as np
from array_api_compat import array_namespace, device, is_array_api_obj

from fuzzy.membershipfunction import Array, as_float, like
from fuzzy.system import AnySystem, Constant, FuzzySystemError, Linear, NoRuleFires, OutOfRange, Structure, Sugeno

_DENSE = 20_000_000  # terms × rules, above which no matrix of them is made (160 MB)


class InferenceWarning(UserWarning):
    """The warning of an input outside its universe of discourse, or of a point where no rule fires."""


class Inference(NamedTuple):
    """Every layer from the inputs to the output, in the notation of [Jang 1993].

    Attributes:
        memberships: Layer 1: per input (..., terms), μ in [0, 1].
        firing: Layer 2: (..., rules), w, with the rule's weight.
        weights: Layer 3: (..., rules), w̄ = w / Σ w, sums to 1; 0 where no rule fires.
        rule_outputs: Layer 4: (..., rules, outputs), f; 0 where the rule leaves an output out.
        output: Layer 5: (..., outputs), Σ w̄ f, in the outputs' units.
        fired: (..., outputs) bool: does any rule for that output fire?
    """

    memberships: tuple[Array, ...]
    firing: Array
    weights: Array
    rule_outputs: Array
    output: Array
    fired: Array


def infer(fis: Sugeno, x: Any) -> Inference:
    """Evaluate a system at a point or a batch of any shape, numpy or torch, and give every layer.

    A point with an input or a degree of membership that is not-a-number has outputs that are not-a-number. Each call
    warns at most once (InferenceWarning) of inputs outside their universe, and at most once of points where no rule
    fires.

    Args:
        fis: The system.
        x: The points (..., inputs), in the inputs' units.

    Returns:
        Degrees, firing strengths, weights, proposals and outputs; arrays are of the library of ``x``.

    Raises:
        FuzzySystemError: A wrong number of inputs; also in place of a warning, if the system says so.
    """
    x = as_float(x)
    check_points(fis, x)
    x = within_universe(fis, x)
    degrees, firing, weights = _fired(fis, x)
    if logarithmic(fis):
        with np.errstate(under="ignore"):
            degrees = array_namespace(x).exp(degrees)
    memberships = tuple(degrees[..., a:b] for a, b in columns_of(fis))
    with np.errstate(over="ignore", invalid="ignore"):  # beyond the largest number outputs are infinite, as they tell
        outputs = rule_outputs(fis, x)
        output, fired = _defuzzified(fis, x, degrees, firing, weights, outputs)
    return Inference(memberships, firing, weights, outputs, output, fired)


def _fired(fis: Sugeno, x: Array) -> tuple[Array, Array, Array]:
    """Layers 1 to 3 at points: degrees, or their logarithms where the system is evaluated so, strengths and weights."""
    logs = logarithmic(fis)
    degrees = degrees_of(fis, x, premise_parameters(fis, x), logs)
    return degrees, *(_log_firing(fis, degrees) if logs else _linear_firing(fis, degrees))


def firing_at(fis: Sugeno, x: Any) -> Array:
    """The firing strengths (..., rules) of :func:`infer` at points (..., inputs), and nothing beyond layer 3.

    Nothing is said of inputs outside their universes.
    """
    x = as_float(x)
    check_points(fis, x)
    return _fired(fis, within_universe(fis, x) if fis.out_of_range == "clip" else x)[1]


def forgiving(fis: AnySystem, no_rule_fires: NoRuleFires | None = None) -> AnySystem:
    """The system that raises nothing and says nothing of inputs outside their universes, which it clips or evaluates.

    Of an interval type-2 system that is said of its upper one.

    Where no rule fires stands what ``no_rule_fires`` says; by default what the system says, not-a-number for an error.
    """

    def forgave(own: Sugeno) -> Sugeno:
        usual: NoRuleFires = "nan" if own.no_rule_fires == "error" else own.no_rule_fires
        outside: OutOfRange = "clip" if own.out_of_range == "clip" else "ignore"
        return replace(own, no_rule_fires=no_rule_fires or usual, out_of_range=outside)

    made: AnySystem = fis.mapped(forgave)  # type: ignore[attr-defined]
    return made


def infer_quietly(fis: Sugeno, x: Any) -> Inference:
    """Evaluate as :func:`infer` does, without a warning; not-a-number for the error that no rule fires."""
    if fis.no_rule_fires == "error":
        fis = replace(fis, no_rule_fires="nan")
    with warnings.catch_warnings(action="ignore", category=InferenceWarning):
        return infer(fis, x)


def check_points(fis: Any, x: Array) -> None:
    """Raise FuzzySystemError unless ``x`` is (..., inputs) of a system that has ``inputs`` and a ``name``."""
    if x.ndim == 0 or x.shape[-1] != len(fis.inputs):
        raise FuzzySystemError(
            f"{fis.name}: the last axis of the input must hold {len(fis.inputs)} values "
            f"({', '.join(v.name for v in fis.inputs)}), got shape {tuple(x.shape)}"
        )


def within_universe(fis: Sugeno, x: Array) -> Array:
    """The points (..., inputs), clipped if the system says so; warns or raises as it says where any is outside."""
    if fis.out_of_range == "ignore":
        return x
    xp = array_namespace(x)
    low = like(x, [v.universe[0] for v in fis.inputs])
    high = like(x, [v.universe[1] for v in fis.inputs])
    if fis.out_of_range == "clip":
        return xp.clip(x, low, high)
    outside = (x < low) | (x > high)
    if bool(xp.any(outside)):
        say_out_of_range(fis, xp.any(xp.reshape(outside, (-1, len(fis.inputs))), axis=0))
    return x


def say_out_of_range(fis: Sugeno, outside: Any) -> None:
    """Warn that the inputs marked in ``outside`` (inputs,) left their universe, or raise if the system says so."""
    names = [
        f"{v.name} outside [{v.universe[0]:g} {v.universe[1]:g}]"
        for v, out in zip(fis.inputs, outside, strict=True)
        if bool(out)
    ]
    if fis.out_of_range == "error":
        raise FuzzySystemError(f"{fis.name}: input {', '.join(names)}")
    warnings.warn(
        f"{fis.name}: input {', '.join(names)}; evaluated without clipping, as in MATLAB "
        "(out_of_range = 'ignore', 'clip' or 'error' chooses otherwise)",
        InferenceWarning,
        stacklevel=_outside_this_package(),
    )


def say_no_rule_fires(fis: Sugeno, missing: Any) -> None:
    """Warn that no rule fired for the outputs marked in ``missing`` (outputs,), or raise if the system says so."""
    outputs = [v for v, none in zip(fis.outputs, missing, strict=True) if bool(none)]
    names = ", ".join(v.name for v in outputs)
    if fis.no_rule_fires == "error":
        raise FuzzySystemError(f"{fis.name}: no rule fires for output {names}")
    values = ", ".join(f"{v.midrange:g}" for v in outputs)
    value = f"the middle of its range, {values}," if fis.no_rule_fires == "midrange" else "not-a-number"
    warnings.warn(
        f"{fis.name}: no rule fires for output {names} at some inputs; {value} stands there "
        "(no_rule_fires = 'nan' or 'error' chooses otherwise; `fuzzy check` shows where)",
        InferenceWarning,
        stacklevel=_outside_this_package(),
    )


def _outside_this_package() -> int:
    """The stack level of the caller's own line, so that Python's once-a-line rule counts by that line."""
    level, frame = 1, sys._getframe(1)
    while frame is not None and frame.f_globals.get("__name__", "").partition(".")[0] == "fuzzy":
        level, frame = level + 1, frame.f_back  # type: ignore[assignment]
    return level


def logarithmic(fis: Sugeno) -> bool:
    """Say whether firing strengths may be sums of logarithms: every degree is positive and is only multiplied."""
    s = fis.structure
    return (
        fis.and_method == "prod"
        and len(fis.rules) > 0
        and not s.is_or.any()
        and not s.negated.any()
        and all(f.log_formula is not None for v in fis.inputs for f in v.terms.values())
    )


def premise_parameters(fis: Sugeno, x: Array) -> tuple[Array, ...]:
    """The parameters of the membership functions: one array (terms, parameters) for each of ``fis.structure.kinds``.

    The arrays have the library, type and device of ``x``. Gradients reach the parameters of ``fis``.
    """
    xp = array_namespace(x)
    functions = [f for v in fis.inputs for f in v.terms.values()]
    return tuple(
        xp.stack(
            [stacked(x, [getattr(functions[t], f.name) for t in kind.terms]) for f in fields(kind.function)], axis=1
        )
        for kind in fis.structure.kinds
    )


def degrees_of(fis: Sugeno, x: Array, premises: Sequence[Array], logs: bool) -> Array:
    """Layer 1: degrees (..., terms) of all inputs' terms, or their logarithms if ``logs``, with one call per kind."""
    xp = array_namespace(x)
    columns = []
    for kind, parameters in zip(fis.structure.kinds, premises, strict=True):
        formula = kind.function.log_formula if logs else kind.function.formula
        assert formula is not None
        columns.append(
            formula(
                xp.take(x, like_index(x, kind.inputs), axis=-1),
                *(parameters[..., k] for k in range(parameters.shape[-1])),
            )
        )
    if not columns:
        return xp.zeros((*x.shape[:-1], 0), dtype=x.dtype, device=device(x))
    if len(columns) == 1:
        return columns[0]
    order = np.argsort(np.concatenate([kind.terms for kind in fis.structure.kinds]))
    return xp.take(xp.concat(columns, axis=-1), like_index(x, order), axis=-1)


def rule_weights(fis: Sugeno, x: Array, premises: Sequence[Array]) -> tuple[Array, Array]:
    """The firing strengths and the weights, each (..., rules), for other parameters than the system's own.

    This is what learning differentiates. It checks nothing, clips nothing and warns of nothing.

    Args:
        fis: The system, for its rules and kinds of membership functions.
        x: The points (..., inputs).
        premises: The parameters, as :func:`premise_parameters` gives them, or arrays (..., terms, parameters) that
            broadcast over the samples.
    """
    logs = logarithmic(fis)
    memberships = degrees_of(fis, x, premises, logs)
    return _log_firing(fis, memberships) if logs else _linear_firing(fis, memberships)


def stacked(x: Array, values: Sequence[Any]) -> Array:
    """Numbers or array scalars as one array (len(values),) of ``x``'s kind, through which gradients go."""
    if any(is_array_api_obj(v) for v in values):
        return array_namespace(x).stack([like(x, v) for v in values])
    return like(x, values)


def like_index(x: Array, index: np.ndarray) -> Array:
    """An index array on the device of ``x``."""
    xp = array_namespace(x)
    return xp.asarray(index, device=device(x)) if xp is not np else index


def _degrees(fis: Sugeno, i: int, membership: Array, neutral: float) -> Array:
    """Degrees (..., rules) to which input ``i`` meets each rule's clause; ``neutral`` where it has none."""
    xp = array_namespace(membership)
    filler = xp.full((*membership.shape[:-1], 1), neutral, dtype=membership.dtype, device=device(membership))
    # The place -1, "left out", is the last column.
    padded = xp.concat([membership, filler], axis=-1)
    places = fis.structure.term[i] % padded.shape[-1]
    return xp.take(padded, like_index(membership, places), axis=-1)


def _log_firing(fis: Sugeno, logs: Array) -> tuple[Array, Array]:
    """Layers 2 and 3 from logarithms (..., terms): the weights are a softmax, which does not underflow."""
    s = fis.structure
    xp = array_namespace(logs)
    # A rule's logarithm is the sum over its clauses of power · log μ.
    least = never(logs.dtype, xp)
    log_firing = _asked(s, xp.clip(logs, least, 0.0))
    weight = like(logs, s.weight)
    with np.errstate(under="ignore"):
        firing = xp.exp(log_firing) * weight
        usable = xp.where(weight > 0, log_firing, -xp.inf)
        top = xp.max(usable, axis=-1, keepdims=True)
        top = xp.where(top > least / 1e6, top, xp.zeros_like(top))
        return firing, _normalised(xp.exp(usable - top) * weight)


def never(kind: Any, xp: Any = np) -> float:
    """What stands for the logarithm of 0, where infinity would make 0 · ∞, in arrays of the type ``kind``.

    It is so large that no sum of others comes near it, and so small that sums of it do not overflow.
    """
    return -float(xp.finfo(kind).max) / 1e8


def _asked(s: Structure, logs: Array) -> Array:
    """Sums (..., rules) of what the rules ask for: power · log μ of each clause, from logarithms (..., terms)."""
    if s.first[-1] * s.term.shape[1] <= _DENSE:
        return logs @ like(logs, s.incidence)
    xp = array_namespace(logs)
    total = None
    for i, (low, high) in enumerate(itertools.pairwise(s.first.tolist())):
        zero = xp.zeros((*logs.shape[:-1], 1), dtype=logs.dtype, device=device(logs))
        known = xp.concat([logs[..., low:high], zero], axis=-1)
        # The place -1, "left out", is the last column.
        term = xp.take(known, like_index(logs, s.term[i] % known.shape[-1]), axis=-1) * like(logs, s.power[i])
        total = term if total is None else total + term
    return total


def _linear_firing(fis: Sugeno, degrees: Array) -> tuple[Array, Array]:
    """Layers 2 and 3 from degrees (..., terms)."""
    firing = firing_strengths(fis, [degrees[..., a:b] for a, b in columns_of(fis)])
    return firing, _normalised(firing)


def columns_of(fis: Sugeno) -> list[tuple[int, int]]:
    """Where each input's terms stand among all terms."""
    ends = np.cumsum([len(v.terms) for v in fis.inputs]).tolist()
    return list(zip([0, *ends[:-1]], ends, strict=True))


def firing_strengths(fis: Sugeno, memberships: Sequence[Array]) -> Array:
    """Layer 2: firing strengths (..., rules), from the degrees (..., terms) of each input's terms."""
    s = fis.structure
    x = memberships[0]
    xp = array_namespace(x)
    shape = (*x.shape[:-1], len(fis.rules))
    all_of = any_of = None
    for i, membership in enumerate(memberships):
        for neutral in {1.0} if not s.is_or.any() else {1.0, 0.0}:
            degree = _hedged(_degrees(fis, i, membership, neutral), s, i, neutral)
            if neutral == 1.0:
                if all_of is None:
                    all_of = degree
                else:
                    all_of = all_of * degree if fis.and_method == "prod" else xp.minimum(all_of, degree)
            elif any_of is None:
                any_of = degree
            elif fis.or_method == "probor":
                any_of = any_of + degree - any_of * degree
            else:
                any_of = xp.maximum(any_of, degree)
    firing = all_of
    if any_of is not None:
        firing = xp.where(like_index(x, s.is_or), any_of, firing)
    with np.errstate(under="ignore"):
        return xp.broadcast_to(firing * like(x, s.weight), shape)


def _hedged(degree: Array, s: Structure, i: int, neutral: float) -> Array:
    xp = array_namespace(degree)
    present = s.term[i] >= 0
    if (s.power[i] != 1).any():
        # A root has an infinite slope at 0: the degree 0 stays 0 with the gradient 0.
        positive = degree > 0
        root = xp.where(positive, degree, xp.ones_like(degree)) ** like(degree, s.power[i])
        degree = xp.where(like_index(degree, s.power[i] != 1), xp.where(positive, root, degree), degree)
    if s.negated[i].any():
        degree = xp.where(like_index(degree, s.negated[i] & present), 1 - degree, degree)
    return degree


def _normalised(firing: Array) -> Array:
    """Layer 3: w / Σ w; 0 where nothing fires."""
    xp = array_namespace(firing)
    total = xp.sum(firing, axis=-1, keepdims=True)
    return firing / xp.where(total == 0, xp.ones_like(total), total)


def rule_outputs(fis: Sugeno, x: Array) -> Array:
    """Layer 4: what each rule proposes (..., rules, outputs) at ``x`` (..., inputs); 0 for an output left out."""
    xp = array_namespace(x)
    columns = []
    for output, consequent in zip(fis.outputs, fis.structure.consequent, strict=True):
        terms = list(output.terms.values())
        if not terms:
            columns.append(xp.zeros((*x.shape[:-1], len(fis.rules)), dtype=x.dtype, device=device(x)))
            continue
        constants = stacked(x, [t.value if isinstance(t, Constant) else t.constant for t in terms])
        values = xp.broadcast_to(constants, (*x.shape[:-1], len(terms)))
        if any(isinstance(t, Linear) for t in terms):
            none = (0.0,) * len(fis.inputs)
            rows = [t.slopes if isinstance(t, Linear) else none for t in terms]
            slopes = xp.stack([like(x, row) if is_array_api_obj(row) else stacked(x, row) for row in rows])
            values = values + x @ slopes.T
        if (consequent < 0).any():
            values = xp.concat([values, xp.zeros_like(values[..., :1])], axis=-1)
            consequent = consequent % values.shape[-1]
        columns.append(xp.take(values, like_index(x, consequent), axis=-1))
    return xp.stack(columns, axis=-1)


def _defuzzified(
    fis: Sugeno, x: Array, degrees: Array, firing: Array, weights: Array, outputs: Array
) -> tuple[Array, Array]:
    """Layer 5 (..., outputs), and where any rule fired."""
    xp = array_namespace(x)
    takes_part = fis.structure.consequent.T >= 0  # (rules, outputs)
    share = weights[..., None]
    if not takes_part.all():
        # A rule without a consequent for an output has no say in it.
        share = share * like(x, takes_part.astype(float))
    total = xp.sum(share, axis=-2)  # (..., 1 or outputs)
    shape = (*x.shape[:-1], len(fis.outputs))
    fired = xp.broadcast_to(total > 0, shape)
    if fis.defuzzification == "wtsum":
        output = xp.sum(firing[..., None] * outputs, axis=-2)
    else:
        output = xp.sum(share * outputs, axis=-2)
        if not takes_part.all():
            output = output / xp.where(fired, xp.broadcast_to(total, shape), xp.ones_like(output))
    return settled(fis, x, degrees, output, fired), fired


def settled(fis: Sugeno, x: Array, degrees: Array, output: Array, fired: Array) -> Array:
    """The outputs (..., outputs): where no rule ``fired`` what the system says, at unknown points not-a-number.

    Warns, or raises, as :func:`infer` does.
    """
    xp = array_namespace(x)
    # Of a degree that is not-a-number (0 · ∞ in a formula) neither that a rule fires can be said, nor that none does.
    sums = xp.sum(xp.where(xp.isnan(x), x, xp.zeros_like(x)), axis=-1) + xp.sum(degrees, axis=-1)
    known = xp.broadcast_to(~xp.isnan(sums)[..., None], fired.shape)
    missing = known & ~fired
    if bool(xp.any(missing)):
        say_no_rule_fires(fis, xp.any(xp.reshape(missing, (-1, len(fis.outputs))), axis=0))
        default = [v.midrange if fis.no_rule_fires == "midrange" else float("nan") for v in fis.outputs]
        output = xp.where(missing, like(x, default), output)
    return xp.where(known, output, xp.nan)
