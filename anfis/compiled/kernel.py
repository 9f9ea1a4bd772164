"""The sums over samples that learning needs, as loops that Numba compiles: forward, design matrix, gradients.

Samples are taken in blocks of a constant number, and a block in chunks of :data:`anfis.compiled.plan.LANES`. A block's
sums do not depend on other blocks, so that blocks may be shared out over threads; who calls adds them in their order.
The last chunk of a block is filled up with its last sample, whose copies count for nothing.
"""

import numpy as np

from anfis.compiled.derivatives import derivatives
from anfis.compiled.plan import LANES, Plan, Rows, rows
from fuzzy.compiled.jit import kernel
from fuzzy.compiled.kernel import evaluate_rules, uncounted
from fuzzy.compiled.tables import Tables, Workspace

# Forward ----------------------------------------------------------------------------------------------------------


@uncounted
def _load(plan: Plan, x: np.ndarray, start: int, count: int, work: Workspace) -> None:
    """``work.x`` ← the chunk's inputs in units of their universes."""
    for i in range(x.shape[1]):
        low, span, high, row = plan.low[i], plan.span[i], plan.high[i], work.x[i]
        for p in range(LANES):
            row[p] = x[start + min(p, count - 1), i]
        for p in range(LANES):
            row[p] = (row[p] - low) / span
        if plan.clip:
            for p in range(LANES):
                row[p] = 0.0 if row[p] < 0.0 else (high if row[p] > high else row[p])


@uncounted
def _share(tables: Tables, plan: Plan, g: int, work: Workspace, own: Rows) -> None:
    """The weights of the terms of group ``g``; ``own.total[0]`` ← their sum before they are normalised again."""
    weights = work.weights if plan.normalise else work.firing
    share, total = own.share, own.total[0]
    for t in range(plan.terms[g]):
        for p in range(LANES):
            share[t, p] = 0.0
    for r in range(len(weights)):
        t = plan.place[g, r]
        if t >= 0:
            for p in range(LANES):
                share[t, p] += weights[r, p]
    for p in range(LANES):
        total[p] = 0.0
    for t in range(plan.terms[g]):
        for p in range(LANES):
            total[p] += share[t, p]
    if plan.normalise and not plan.everyone[g]:
        for t in range(plan.terms[g]):
            for p in range(LANES):
                share[t, p] /= total[p] if total[p] > 0.0 else 1.0


@uncounted
def _output(plan: Plan, g: int, proposals: np.ndarray, o: int, work: Workspace, own: Rows) -> None:
    """``own.total[1]`` ← output ``o``, and ``own.proposal`` ← what each term proposes."""
    output, proposal, share, total = own.total[1], own.proposal, own.share, own.total[0]
    x, inputs = work.x, len(work.x)
    for p in range(LANES):
        output[p] = 0.0
    for t in range(plan.terms[g]):
        for p in range(LANES):
            proposal[t, p] = proposals[o, t, inputs]
        for i in range(inputs):
            slope = proposals[o, t, i]
            for p in range(LANES):
                proposal[t, p] += slope * x[i, p]
        for p in range(LANES):
            output[p] += share[t, p] * proposal[t, p]
    middle = plan.middle[o]
    for p in range(LANES):
        output[p] += 0.0 if total[p] > 0.0 else middle


# Backward ---------------------------------------------------------------------------------------------------------


@uncounted
def _pull_terms(plan: Plan, g: int, begin: bool, work: Workspace, own: Rows) -> None:
    """Add to ``own.pull`` what ``own.total[2]``, the derivative to the output, means for the terms' weights."""
    factor, proposal, pull = own.total[2], own.proposal, own.pull
    for t in range(plan.terms[g]):
        for p in range(LANES):
            pull[t, p] = (0.0 if begin else pull[t, p]) + factor[p] * proposal[t, p]


@uncounted
def _pull_rules(plan: Plan, g: int, work: Workspace, own: Rows) -> None:
    """Add to ``own.rule_pull`` what ``own.pull`` means for the rules' weights."""
    pull, share, total, lost = own.pull, own.share, own.total[0], own.total[1]
    again = plan.normalise and not plan.everyone[g]
    for p in range(LANES):
        lost[p] = 0.0
    if again:
        for t in range(plan.terms[g]):
            for p in range(LANES):
                lost[p] += share[t, p] * pull[t, p]
    for r in range(len(own.rule_pull)):
        t = plan.place[g, r]
        if t >= 0:
            for p in range(LANES):
                scale = total[p] if again and total[p] > 0.0 else 1.0
                own.rule_pull[r, p] += (pull[t, p] - lost[p]) / scale


@uncounted
def _pull_firing(tables: Tables, plan: Plan, work: Workspace, own: Rows) -> None:
    """``own.rule_pull``: from weights back to the logarithms of firing strengths, or to the strengths themselves."""
    weights, firing, pull = work.weights, work.firing, own.rule_pull
    lost, total = own.total[1], own.total[2]
    for p in range(LANES):
        lost[p] = 0.0
        total[p] = 0.0
    if plan.normalise:
        for r in range(len(pull)):
            for p in range(LANES):
                lost[p] += weights[r, p] * pull[r, p]
                total[p] += firing[r, p]
    if tables.logarithmic:
        for r in range(len(pull)):
            for p in range(LANES):
                pull[r, p] = (weights[r, p] if plan.normalise else firing[r, p]) * (pull[r, p] - lost[p])
    elif plan.normalise:
        for r in range(len(pull)):
            for p in range(LANES):
                pull[r, p] = (pull[r, p] - lost[p]) / (1.0 if total[p] == 0.0 else total[p])


@uncounted
def _hedge(tables: Tables, r: int, i: int, work: Workspace, own: Rows) -> None:
    """Row ``i`` of ``own.clause``: the degree after hedge and "not"; the neutral one where the rule leaves it out."""
    t, power = tables.clause[r, i], tables.power[r, i]
    clause = own.clause
    if t < 0:
        for p in range(LANES):
            clause[i, p] = 0.0 if tables.is_or[r] else 1.0
        return
    degree = work.degree[t]
    if power == 1.0:
        for p in range(LANES):
            clause[i, p] = degree[p]
    else:
        for p in range(LANES):
            clause[i, p] = degree[p] ** power if degree[p] > 0.0 else degree[p]
    if tables.negated[r, i]:
        for p in range(LANES):
            clause[i, p] = 1.0 - clause[i, p]


@uncounted
def _pull_clause(tables: Tables, r: int, i: int, slope: np.ndarray, work: Workspace, own: Rows) -> None:
    """Add ``slope``, the derivative to a clause, to its term's row of ``own.term_pull``."""
    t, power = tables.clause[r, i], tables.power[r, i]
    if t < 0:
        return
    sign = -1.0 if tables.negated[r, i] else 1.0
    degree, pull = work.degree[t], own.term_pull[t]
    if power == 1.0:
        for p in range(LANES):
            pull[p] += sign * slope[p]
    else:
        for p in range(LANES):
            pull[p] += sign * slope[p] * (power * degree[p] ** (power - 1.0) if degree[p] > 0.0 else 1.0)


@uncounted
def _pull_degrees(tables: Tables, r: int, work: Workspace, own: Rows) -> None:
    """Add to ``own.term_pull`` what rule ``r`` makes of ``own.rule_pull``: back through "and" or "or"."""
    inputs = len(own.clause)
    is_or, weight = tables.is_or[r], tables.weight[r]
    so_far, clause, pull, slope = own.so_far, own.clause, own.rule_pull[r], own.scratch[0]
    for p in range(LANES):
        so_far[0, p] = 0.0 if is_or else 1.0
    for i in range(inputs):
        _hedge(tables, r, i, work, own)
        for p in range(LANES):
            a, b = so_far[i, p], clause[i, p]
            if is_or:
                so_far[i + 1, p] = (a if a > b else b) if tables.or_max else a + b - a * b
            else:
                so_far[i + 1, p] = (a if a < b else b) if tables.and_min else a * b
    for p in range(LANES):
        pull[p] *= weight
    for i in range(inputs - 1, -1, -1):
        for p in range(LANES):
            a, b = so_far[i, p], clause[i, p]
            if is_or and tables.or_max:
                to_b = 1.0 if b > a else (0.5 if a == b else 0.0)
                to_a = 1.0 - to_b
            elif is_or:
                to_b, to_a = 1.0 - a, 1.0 - b
            elif tables.and_min:
                to_b = 1.0 if b < a else (0.5 if a == b else 0.0)
                to_a = 1.0 - to_b
            else:
                to_b, to_a = a, b
            # The first clause has none before it: it is not compared with what is neutral.
            to_b = 1.0 if i == 0 else to_b
            slope[p] = pull[p] * to_b
            pull[p] = pull[p] * to_a
        _pull_clause(tables, r, i, slope, work, own)


@uncounted
def _pull_memberships(tables: Tables, work: Workspace, own: Rows) -> None:
    """``own.term_pull``: the derivatives to the degrees, or to their logarithms, from ``own.rule_pull``."""
    for t in range(len(own.term_pull)):
        for p in range(LANES):
            own.term_pull[t, p] = 0.0
    for r in range(len(own.rule_pull)):
        if not tables.logarithmic:
            _pull_degrees(tables, r, work, own)
            continue
        for i in range(tables.clause.shape[1]):
            t, power = tables.clause[r, i], tables.power[r, i]
            if t >= 0:
                for p in range(LANES):
                    own.term_pull[t, p] += power * own.rule_pull[r, p]


# Whole blocks -----------------------------------------------------------------------------------------------------


@kernel(nogil=True)
def fill_design(tables: Tables, plan: Plan, x: np.ndarray, g: int, design: np.ndarray, fires: np.ndarray) -> None:
    """Write the design matrix of group ``g``, transposed.

    Args:
        tables: The system, its parameters in units of the universes.
        plan: Its consequents' side.
        x: The samples' inputs (samples, inputs), in their own units.
        g: The group.
        design: Where it is written, (parameters, samples) or more rows.
        fires: (1,), to which the number of samples is added where a rule of the group fires.
    """
    work, own = rows(tables, plan)
    width = x.shape[1] + 1
    columns = plan.column[plan.first_column[g] : plan.first_column[g + 1]]
    for start in range(0, len(x), LANES):
        count = min(LANES, len(x) - start)
        _load(plan, x, start, count, work)
        evaluate_rules(tables, work, LANES)
        _share(tables, plan, g, work, own)
        for k in range(len(columns)):
            t, i = columns[k] // width, columns[k] % width
            share, row = own.share[t], design[k, start:]
            if i == width - 1:
                for p in range(count):
                    row[p] = share[p]
            else:
                value = work.x[i]
                for p in range(count):
                    row[p] = share[p] * value[p]
        for p in range(count):
            fires[0] += own.total[0, p] != 0.0


@kernel(nogil=True)
def add_errors(
    tables: Tables,
    plan: Plan,
    proposals: np.ndarray,
    x: np.ndarray,
    y: np.ndarray,
    gradient: np.ndarray,
    wanted: bool,
) -> tuple[float, int]:
    """Sum the squared errors of a block; return them, and the number of samples where no rule fires for some output.

    Args:
        tables: The system, its parameters in units of the universes.
        plan: Its consequents' side.
        proposals: The consequents (outputs, terms, inputs + 1), for inputs in units of the universes.
        x: The samples' inputs (samples, inputs), in their own units.
        y: Their outputs (samples, outputs).
        gradient: Where the derivatives of the sum to the membership functions' parameters are written (functions, 4).
        wanted: Are these wanted?
    """
    work, own = rows(tables, plan)
    squares, silent = np.zeros(LANES), 0
    missing = np.zeros(LANES, dtype=np.bool_)
    own.slope[:] = 0.0
    for start in range(0, len(x), LANES):
        count = min(LANES, len(x) - start)
        _load(plan, x, start, count, work)
        evaluate_rules(tables, work, LANES)
        missing[:] = False
        own.rule_pull[:] = 0.0
        for g in range(len(plan.terms)):
            _share(tables, plan, g, work, own)
            for k in range(plan.first_output[g], plan.first_output[g + 1]):
                o = plan.output[k]
                _output(plan, g, proposals, o, work, own)
                output, error = own.total[1], own.total[2]
                for p in range(count):
                    error[p] = output[p] - y[start + p, o]
                    squares[p] += error[p] * error[p]
                    missing[p] |= not own.total[0, p] > 0.0
                if wanted:
                    for p in range(count):
                        error[p] = 2.0 * error[p]
                    for p in range(count, LANES):
                        error[p] = 0.0
                    _pull_terms(plan, g, k == plan.first_output[g], work, own)
            if wanted and plan.first_output[g + 1] > plan.first_output[g]:
                _pull_rules(plan, g, work, own)
        for p in range(count):
            silent += missing[p]
        if wanted:
            _pull_firing(tables, plan, work, own)
            _pull_memberships(tables, work, own)
            for t in range(len(tables.kind)):
                _derivatives_of(tables, t, work, own)
                pull = own.term_pull[t]
                for k in range(4):
                    slope, partial = own.slope[t, k], own.partial[k]
                    for p in range(LANES):
                        slope[p] += pull[p] * partial[p]
    for t in range(len(tables.kind)):
        for k in range(4):
            gradient[t, k] = own.slope[t, k].sum()
    return squares.sum(), silent


@uncounted
def _derivatives_of(tables: Tables, t: int, work: Workspace, own: Rows) -> None:
    """``own.partial`` ← the derivatives of the degrees of function ``t``, 0 for parameters that it has not."""
    for k in range(4):
        for p in range(LANES):
            own.partial[k, p] = 0.0
    x = work.x[tables.place[t]]
    derivatives(
        tables.kind[t],
        tables.parameters[t],
        x,
        work.degree[t],
        tables.logarithmic,
        own.partial,
        own.scratch,
        own.bits,
    )


@kernel(nogil=True)
def fill_jacobian(
    tables: Tables,
    plan: Plan,
    proposals: np.ndarray,
    x: np.ndarray,
    y: np.ndarray,
    o: int,
    factor: np.ndarray,
    jacobian: np.ndarray,
    residual: np.ndarray,
) -> None:
    """Write the derivatives of output ``o`` to the free premises, sample by sample, transposed.

    Args:
        tables: The system, its parameters in units of the universes.
        plan: Its consequents' side.
        proposals: The consequents (outputs, terms, inputs + 1), for inputs in units of the universes.
        x: The samples' inputs (samples, inputs), in their own units.
        y: Their outputs (samples, outputs).
        o: The output.
        factor: The derivatives of the functions' parameters to the free premises (functions, 4).
        jacobian: Where the derivatives are written (premises, samples).
        residual: Where y minus the output is written (samples,).
    """
    work, own = rows(tables, plan)
    g = 0
    while not (plan.output[plan.first_output[g] : plan.first_output[g + 1]] == o).any():
        g += 1
    for start in range(0, len(x), LANES):
        count = min(LANES, len(x) - start)
        _load(plan, x, start, count, work)
        evaluate_rules(tables, work, LANES)
        _share(tables, plan, g, work, own)
        _output(plan, g, proposals, o, work, own)
        for p in range(count):
            residual[start + p] = y[start + p, o] - own.total[1, p]
        own.total[2] = 1.0
        own.rule_pull[:] = 0.0
        _pull_terms(plan, g, True, work, own)
        _pull_rules(plan, g, work, own)
        _pull_firing(tables, plan, work, own)
        _pull_memberships(tables, work, own)
        for t in range(len(tables.kind)):
            _derivatives_of(tables, t, work, own)
            pull = own.term_pull[t]
            for k in range(4):
                if plan.premise[t, k] >= 0:
                    row, partial, scale = jacobian[plan.premise[t, k], start:], own.partial[k], factor[t, k]
                    for p in range(count):
                        row[p] = pull[p] * partial[p] * scale
