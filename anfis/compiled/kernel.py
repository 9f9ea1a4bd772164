"""The sums over samples that learning needs, as loops that Numba compiles: forward, design matrix, gradients.

The numbers are those of :mod:`fuzzy.inference`. Samples are taken in chunks of :data:`anfis.compiled.plan.CHUNK_LANES`,
and loops over the lanes have no branches, so that the compiler makes vector instructions of them. The last chunk is
filled up with its last sample, whose copies count for nothing.
"""

import math

import numpy as np

from anfis.compiled.derivatives import fill_derivatives, fill_terms
from anfis.compiled.plan import CHUNK_LANES, ChunkRows, KernelPlan, rows
from fuzzy.compiled.degrees import exp_nonpositive
from fuzzy.compiled.jit import kernel
from fuzzy.compiled.tables import KIND
from fuzzy.inference import never

# What a sweep over samples is for: a sum of these.
DESIGN = 1  # the groups' design matrices
ERRORS = 2
GRADIENT = 4  # of the squared errors
JACOBIAN = 8  # the outputs' derivatives, and the residuals
KEEP = 16  # degrees and weights are kept for the next sweep
KEPT = 32  # those of the last one are taken

_NEVER = never(np.float64)

# Each is called from one place, and becomes part of it: compiled alone, with all these arrays for arguments, they
# would take longer than the whole.
part = kernel(inline="always")

# Forward ----------------------------------------------------------------------------------------------------------


@part
def _load(plan: KernelPlan, x: np.ndarray, start: int, count: int, own: ChunkRows) -> None:
    """``own.x`` ← the chunk's inputs in units of their universes."""
    for i in range(x.shape[1]):
        low, span, high, row = plan.low[i], plan.span[i], plan.high[i], own.x[i]
        for p in range(CHUNK_LANES):
            row[p] = x[start + min(p, count - 1), i]
        for p in range(CHUNK_LANES):
            row[p] = (row[p] - low) / span
        if plan.clip:
            for p in range(CHUNK_LANES):
                row[p] = 0.0 if row[p] < 0.0 else (high if row[p] > high else row[p])


@part
def _memberships(plan: KernelPlan, parameters: np.ndarray, own: ChunkRows) -> None:
    """Layer 1: degrees of membership, or their logarithms, which are not below ``_NEVER``."""
    for t in range(len(plan.kind)):
        degree = own.degree[t]
        fill_terms(plan.kind[t], parameters[t], own.x[plan.input[t]], degree, own.row)
        if plan.logarithmic:
            for p in range(CHUNK_LANES):
                degree[p] = _NEVER if degree[p] < _NEVER else degree[p]
        elif plan.kind[t] >= KIND.Gaussian:
            for p in range(CHUNK_LANES):
                degree[p] = exp_nonpositive(degree[p])


@part
def _log_firing(plan: KernelPlan, own: ChunkRows) -> None:
    """Layer 2 from logarithms; ``own.weights`` ← the strengths over the greatest one, as a softmax has them."""
    firing, weights, top = own.firing, own.weights, own.row
    for p in range(CHUNK_LANES):
        top[p] = -math.inf
    for r in range(len(firing)):
        row = firing[r]
        for p in range(CHUNK_LANES):
            row[p] = 0.0
        for i in range(plan.clause.shape[1]):
            t, power = plan.clause[r, i], plan.power[r, i]
            if t >= 0:
                degree = own.degree[t]
                for p in range(CHUNK_LANES):
                    row[p] += degree[p] * power
        if plan.weight[r] > 0.0:
            for p in range(CHUNK_LANES):
                top[p] = row[p] if row[p] > top[p] else top[p]
    for p in range(CHUNK_LANES):
        top[p] = top[p] if top[p] > _NEVER / 1e6 else 0.0
    for r in range(len(firing)):
        row, own_weights, factor = firing[r], weights[r], plan.weight[r]
        for p in range(CHUNK_LANES):
            log = row[p] - top[p]
            # A rule without weight is no part of the greatest strength, and might overflow over it.
            own_weights[p] = exp_nonpositive(0.0 if log > 0.0 else log) * factor
        if not plan.normalise:
            for p in range(CHUNK_LANES):
                row[p] = exp_nonpositive(row[p]) * factor


@part
def _hedge(plan: KernelPlan, r: int, i: int, own: ChunkRows) -> None:
    """Row ``i`` of ``own.clause``: the degree after hedge and "not"; the neutral one where the rule leaves it out."""
    t, power, clause = plan.clause[r, i], plan.power[r, i], own.clause[i]
    if t < 0:
        for p in range(CHUNK_LANES):
            clause[p] = 0.0 if plan.is_or[r] else 1.0
    else:
        degree = own.degree[t]
        if power == 1.0:
            for p in range(CHUNK_LANES):
                clause[p] = degree[p]
        elif power == 2.0:
            for p in range(CHUNK_LANES):
                clause[p] = degree[p] * degree[p]
        else:
            for p in range(CHUNK_LANES):
                clause[p] = degree[p] ** power if degree[p] > 0.0 else degree[p]
        if plan.negated[r, i]:
            for p in range(CHUNK_LANES):
                clause[p] = 1.0 - clause[p]


@kernel(nogil=True, _nrt=False)
def _combine(plan: KernelPlan, r: int, own: ChunkRows) -> None:
    """``own.so_far``: the firing strength of rule ``r`` after each clause, from degrees."""
    is_or, so_far, clause = plan.is_or[r], own.so_far, own.clause
    for p in range(CHUNK_LANES):
        so_far[0, p] = 0.0 if is_or else 1.0
    for i in range(len(clause)):
        _hedge(plan, r, i, own)
        for p in range(CHUNK_LANES):
            a, b = so_far[i, p], clause[i, p]
            if is_or:
                so_far[i + 1, p] = (a if a > b else b) if plan.or_max else a + b - a * b
            else:
                so_far[i + 1, p] = (a if a < b else b) if plan.and_min else a * b


@part
def _linear_firing(plan: KernelPlan, own: ChunkRows) -> None:
    """Layer 2 from degrees."""
    inputs = len(own.clause)
    for r in range(len(own.firing)):
        _combine(plan, r, own)
        for p in range(CHUNK_LANES):
            own.firing[r, p] = own.so_far[inputs, p] * plan.weight[r]
            own.weights[r, p] = own.firing[r, p]


@part
def _normalise(own: ChunkRows) -> None:
    """Layer 3: w / Σ w; 0 where nothing fires."""
    weights, total = own.weights, own.row
    for p in range(CHUNK_LANES):
        total[p] = 0.0
    for r in range(len(weights)):
        for p in range(CHUNK_LANES):
            total[p] += weights[r, p]
    for p in range(CHUNK_LANES):
        total[p] = 1.0 if total[p] == 0.0 else total[p]
    for r in range(len(weights)):
        for p in range(CHUNK_LANES):
            weights[r, p] /= total[p]


@part
def _share(plan: KernelPlan, g: int, own: ChunkRows) -> None:
    """The weights of the terms of group ``g``; ``own.total[0]`` ← their sum before they are normalised again."""
    weights = own.weights if plan.normalise else own.firing
    share, total = own.share, own.total[0]
    for t in range(plan.terms[g]):
        for p in range(CHUNK_LANES):
            share[t, p] = 0.0
    for r in range(len(weights)):
        t = plan.place[g, r]
        if t >= 0:
            for p in range(CHUNK_LANES):
                share[t, p] += weights[r, p]
    for p in range(CHUNK_LANES):
        total[p] = 0.0
    for t in range(plan.terms[g]):
        for p in range(CHUNK_LANES):
            total[p] += share[t, p]
    if plan.normalise and not plan.everyone[g]:
        for t in range(plan.terms[g]):
            for p in range(CHUNK_LANES):
                share[t, p] /= total[p] if total[p] > 0.0 else 1.0


@part
def _output(plan: KernelPlan, g: int, proposals: np.ndarray, o: int, own: ChunkRows) -> None:
    """``own.total[1]`` ← output ``o``, and ``own.proposal`` ← what each term proposes."""
    output, proposal, share, total = own.total[1], own.proposal, own.share, own.total[0]
    x, inputs = own.x, len(own.x)
    for p in range(CHUNK_LANES):
        output[p] = 0.0
    for t in range(plan.terms[g]):
        for p in range(CHUNK_LANES):
            proposal[t, p] = proposals[o, t, inputs]
        for i in range(inputs):
            slope = proposals[o, t, i]
            for p in range(CHUNK_LANES):
                proposal[t, p] += slope * x[i, p]
        for p in range(CHUNK_LANES):
            output[p] += share[t, p] * proposal[t, p]
    middle = plan.middle[o]
    for p in range(CHUNK_LANES):
        output[p] += 0.0 if total[p] > 0.0 else middle


# Backward ---------------------------------------------------------------------------------------------------------


@part
def _pull_terms(plan: KernelPlan, g: int, own: ChunkRows) -> None:
    """Add to ``own.pull`` what ``own.total[2]``, the derivative to the output, means for the terms' weights."""
    factor, proposal, pull = own.total[2], own.proposal, own.pull
    for t in range(plan.terms[g]):
        for p in range(CHUNK_LANES):
            pull[t, p] += factor[p] * proposal[t, p]


@part
def _pull_rules(plan: KernelPlan, g: int, own: ChunkRows) -> None:
    """Add to ``own.rule_pull`` what ``own.pull`` means for the rules' weights."""
    pull, share, total, lost = own.pull, own.share, own.total[0], own.total[1]
    again = plan.normalise and not plan.everyone[g]
    for p in range(CHUNK_LANES):
        lost[p] = 0.0
    if again:
        for t in range(plan.terms[g]):
            for p in range(CHUNK_LANES):
                lost[p] += share[t, p] * pull[t, p]
    for r in range(len(own.rule_pull)):
        t = plan.place[g, r]
        if t >= 0:
            for p in range(CHUNK_LANES):
                scale = total[p] if again and total[p] > 0.0 else 1.0
                own.rule_pull[r, p] += (pull[t, p] - lost[p]) / scale


@part
def _pull_firing(plan: KernelPlan, own: ChunkRows) -> None:
    """``own.rule_pull``: from weights back to the logarithms of firing strengths, or to the strengths themselves."""
    weights, firing, pull = own.weights, own.firing, own.rule_pull
    lost, total = own.total[1], own.total[2]
    for p in range(CHUNK_LANES):
        lost[p] = 0.0
        total[p] = 0.0
    if plan.normalise:
        for r in range(len(pull)):
            for p in range(CHUNK_LANES):
                lost[p] += weights[r, p] * pull[r, p]
                total[p] += firing[r, p]
    if plan.logarithmic:
        for r in range(len(pull)):
            for p in range(CHUNK_LANES):
                pull[r, p] = (weights[r, p] if plan.normalise else firing[r, p]) * (pull[r, p] - lost[p])
    elif plan.normalise:
        for r in range(len(pull)):
            for p in range(CHUNK_LANES):
                pull[r, p] = (pull[r, p] - lost[p]) / (1.0 if total[p] == 0.0 else total[p])


@part
def _pull_clause(plan: KernelPlan, r: int, i: int, slope: np.ndarray, own: ChunkRows) -> None:
    """Add ``slope``, the derivative to a clause, to its term's row of ``own.term_pull``."""
    t, power = plan.clause[r, i], plan.power[r, i]
    if t < 0:
        return
    sign = -1.0 if plan.negated[r, i] else 1.0
    degree, pull = own.degree[t], own.term_pull[t]
    if power == 1.0:
        for p in range(CHUNK_LANES):
            pull[p] += sign * slope[p]
    else:
        for p in range(CHUNK_LANES):
            pull[p] += sign * slope[p] * (power * degree[p] ** (power - 1.0) if degree[p] > 0.0 else 1.0)


@part
def _pull_degrees(plan: KernelPlan, r: int, own: ChunkRows) -> None:
    """Add to ``own.term_pull`` what rule ``r`` makes of ``own.rule_pull``: back through "and" or "or"."""
    inputs = len(own.clause)
    is_or, weight = plan.is_or[r], plan.weight[r]
    so_far, clause, pull, slope = own.so_far, own.clause, own.rule_pull[r], own.row
    _combine(plan, r, own)
    for p in range(CHUNK_LANES):
        pull[p] *= weight
    for i in range(inputs - 1, -1, -1):
        for p in range(CHUNK_LANES):
            a, b = so_far[i, p], clause[i, p]
            if is_or and plan.or_max:
                to_b = 1.0 if b > a else (0.5 if a == b else 0.0)
                to_a = 1.0 - to_b
            elif is_or:
                to_b, to_a = 1.0 - a, 1.0 - b
            elif plan.and_min:
                to_b = 1.0 if b < a else (0.5 if a == b else 0.0)
                to_a = 1.0 - to_b
            else:
                to_b, to_a = a, b
            # The first clause has none before it: it is not compared with what is neutral.
            to_b = 1.0 if i == 0 else to_b
            slope[p] = pull[p] * to_b
            pull[p] = pull[p] * to_a
        _pull_clause(plan, r, i, slope, own)


@part
def _pull_memberships(plan: KernelPlan, own: ChunkRows) -> None:
    """``own.term_pull``: the derivatives to the degrees, or to their logarithms, from ``own.rule_pull``."""
    for t in range(len(own.term_pull)):
        for p in range(CHUNK_LANES):
            own.term_pull[t, p] = 0.0
    for r in range(len(own.rule_pull)):
        if not plan.logarithmic:
            _pull_degrees(plan, r, own)
            continue
        for i in range(plan.clause.shape[1]):
            t, power = plan.clause[r, i], plan.power[r, i]
            if t >= 0:
                for p in range(CHUNK_LANES):
                    own.term_pull[t, p] += power * own.rule_pull[r, p]


# Whole blocks -----------------------------------------------------------------------------------------------------


@part
def _fill_design(
    plan: KernelPlan, g: int, first: int, start: int, count: int, own: ChunkRows, made: np.ndarray
) -> None:
    """Write the columns of group ``g`` as rows of ``made`` from ``first`` on."""
    inputs = len(own.x)
    for k in range(plan.first_column[g], plan.first_column[g + 1]):
        t, i = plan.column[k] // (inputs + 1), plan.column[k] % (inputs + 1)
        share, row = own.share[t], made[first + k - plan.first_column[g], start:]
        if i == inputs:
            for p in range(count):
                row[p] = share[p]
        else:
            value = own.x[i]
            for p in range(count):
                row[p] = share[p] * value[p]


@part
def _add_slopes(
    plan: KernelPlan,
    parameters: np.ndarray,
    task: int,
    factor: np.ndarray,
    first: int,
    start: int,
    count: int,
    own: ChunkRows,
    made: np.ndarray,
    slopes: np.ndarray,
) -> None:
    """From ``own.term_pull`` to the parameters: added to ``slopes``, or as rows of ``made`` from ``first`` on."""
    for t in range(len(plan.kind)):
        pull = own.term_pull[t]
        x, degree = own.x[plan.input[t]], own.degree[t]
        fill_derivatives(plan.kind[t], parameters[t], x, degree, plan.logarithmic, own.partial)
        for k in range(4):
            slope, partial, place = slopes[t, k], own.partial[k], plan.premise[t, k]
            if place >= 0 and task & JACOBIAN:
                row, scale = made[first + place, start:], factor[t, k]
                for p in range(count):
                    row[p] = pull[p] * partial[p] * scale
            elif place >= 0:
                for p in range(CHUNK_LANES):
                    slope[p] += pull[p] * partial[p]


@kernel(nogil=True)
def sweep(
    plan: KernelPlan,
    parameters: np.ndarray,
    proposals: np.ndarray,
    x: np.ndarray,
    y: np.ndarray,
    task: int,
    made: np.ndarray,
    place: np.ndarray,
    factor: np.ndarray,
    fires: np.ndarray,
    gradient: np.ndarray,
    kept: np.ndarray,
) -> tuple[float, int]:
    """Sweep over a block; return its squared errors, and the number of samples where no rule fires for some output.

    One function for all tasks: it compiles for some seconds, and most of it serves them all.

    Args:
        plan: The system.
        parameters: Its membership functions' parameters, in units of the universes, filled up (functions, 4).
        proposals: The consequents (outputs, terms, inputs + 1), for inputs in units of the universes.
        x: The samples' inputs (samples, inputs), in their own units.
        y: Their outputs (samples, outputs).
        task: A sum of DESIGN, the groups' design matrices; ERRORS; with these GRADIENT, that of the squared errors; or
            JACOBIAN, the outputs' derivatives to the free premises and the residuals, y minus the output; KEEP or KEPT.
        made: Where matrices are written, transposed: (rows, samples).
        place: Where in it (3, groups or outputs) int: the first rows of the groups' designs, and of the outputs'
            Jacobians; the outputs' residuals.
        factor: The derivatives of the functions' parameters to the free premises (functions, 4).
        fires: (groups,), to which is added at how many samples a rule of the group fires.
        gradient: Where the derivatives of the squared errors to the functions' parameters are written (functions, 4).
        kept: What KEEP writes and KEPT reads, (functions + 2 rules, samples or more: a whole number of chunks).
    """
    own = rows(plan)
    squares, silent = np.zeros(CHUNK_LANES), 0
    missing = np.zeros(CHUNK_LANES, dtype=np.bool_)
    slopes = np.zeros((len(plan.kind), 4, CHUNK_LANES))
    for start in range(0, len(x), CHUNK_LANES):
        count = min(CHUNK_LANES, len(x) - start)
        _load(plan, x, start, count, own)
        if task & KEPT:
            for k in range(len(kept)):
                row, source = own.forward[k], kept[k, start:]
                for p in range(CHUNK_LANES):
                    row[p] = source[p]
        else:
            _memberships(plan, parameters, own)
            if plan.logarithmic:
                _log_firing(plan, own)
            else:
                _linear_firing(plan, own)
            _normalise(own)
            if task & KEEP:
                for k in range(len(kept)):
                    row, source = kept[k, start:], own.forward[k]
                    for p in range(CHUNK_LANES):
                        row[p] = source[p]
        for p in range(CHUNK_LANES):
            missing[p] = False
        # Backward all outputs go together, but for the Jacobian each alone.
        for turn in range(len(plan.output) if task & JACOBIAN else 1):
            for r in range(len(own.rule_pull)):
                for p in range(CHUNK_LANES):
                    own.rule_pull[r, p] = 0.0
            for g in range(len(plan.terms)):
                _share(plan, g, own)
                if turn == 0:
                    for p in range(count):
                        fires[g] += own.total[0, p] != 0.0
                    if task & DESIGN:
                        _fill_design(plan, g, place[0, g], start, count, own, made)
                if not task & (ERRORS | JACOBIAN):
                    continue
                for t in range(plan.terms[g]):
                    for p in range(CHUNK_LANES):
                        own.pull[t, p] = 0.0
                for k in range(plan.first_output[g], plan.first_output[g + 1]):
                    o = plan.output[k]
                    if task & JACOBIAN and k != turn:
                        continue
                    _output(plan, g, proposals, o, own)
                    output, error = own.total[1], own.total[2]
                    for p in range(count):
                        error[p] = output[p] - y[start + p, o]
                        squares[p] += error[p] * error[p]
                        missing[p] |= not own.total[0, p] > 0.0
                    if task & JACOBIAN:
                        row = made[place[2, o], start:]
                        for p in range(count):
                            row[p] = -error[p]
                    for p in range(CHUNK_LANES):
                        error[p] = 1.0 if task & JACOBIAN else (2.0 * error[p] if p < count else 0.0)
                    if task & (GRADIENT | JACOBIAN):
                        _pull_terms(plan, g, own)
                if task & (GRADIENT | JACOBIAN):
                    _pull_rules(plan, g, own)
            if task & (GRADIENT | JACOBIAN):
                _pull_firing(plan, own)
                _pull_memberships(plan, own)
                first = place[1, plan.output[turn]]
                _add_slopes(plan, parameters, task, factor, first, start, count, own, made, slopes)
        for p in range(count):
            silent += missing[p]
    for t in range(len(plan.kind)):
        for k in range(4):
            gradient[t, k] = slopes[t, k].sum()
    return squares.sum(), silent
