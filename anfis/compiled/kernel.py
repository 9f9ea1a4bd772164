"""The sums over samples that learning needs, as loops that Numba compiles: forward, design matrix, gradients.

Samples are taken in blocks of a constant number, and a block in chunks of :data:`anfis.compiled.plan.LANES`. A block's
sums do not depend on other blocks, so that blocks may be shared out over threads; who calls adds them in their order.
The last chunk of a block is filled up with its last sample, whose copies count for nothing.
"""

import numpy as np

from anfis.compiled.derivatives import derivatives
from anfis.compiled.plan import LANES, Plan, Rows, rows
from fuzzy.compiled.jit import kernel
from fuzzy.compiled.kernel import evaluate_rules
from fuzzy.compiled.tables import Tables, Workspace

# What a sweep over samples is for: a sum of these.
DESIGN, ERRORS, GRADIENT, JACOBIAN = 1, 2, 4, 8

# Each is called from one place, and becomes part of it: compiled alone, with all these arrays for arguments, they
# would take longer than the whole.
part = kernel(inline="always")

# Forward ----------------------------------------------------------------------------------------------------------


@part
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


@part
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


@part
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


@part
def _pull_terms(plan: Plan, g: int, work: Workspace, own: Rows) -> None:
    """Add to ``own.pull`` what ``own.total[2]``, the derivative to the output, means for the terms' weights."""
    factor, proposal, pull = own.total[2], own.proposal, own.pull
    for t in range(plan.terms[g]):
        for p in range(LANES):
            pull[t, p] += factor[p] * proposal[t, p]


@part
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


@part
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


@part
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


@part
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


@part
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


@part
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


@part
def _fill_design(plan: Plan, g: int, first: int, start: int, count: int, work: Workspace, own: Rows, made: np.ndarray):  # type: ignore[no-untyped-def]
    """Write the columns of group ``g`` as rows of ``made`` from ``first`` on."""
    inputs = len(work.x)
    for k in range(plan.first_column[g], plan.first_column[g + 1]):
        t, i = plan.column[k] // (inputs + 1), plan.column[k] % (inputs + 1)
        share, row = own.share[t], made[first + k - plan.first_column[g], start:]
        if i == inputs:
            for p in range(count):
                row[p] = share[p]
        else:
            value = work.x[i]
            for p in range(count):
                row[p] = share[p] * value[p]


@part
def _add_slopes(
    tables: Tables,
    plan: Plan,
    task: int,
    factor: np.ndarray,
    first: int,
    start: int,
    count: int,
    work: Workspace,
    own: Rows,
    made: np.ndarray,
):  # type: ignore[no-untyped-def]
    """From ``own.term_pull`` to the parameters: added to ``own.slope``, or as rows of ``made`` from ``first`` on."""
    for t in range(len(tables.kind)):
        pull, x = own.term_pull[t], work.x[tables.place[t]]
        own.partial[:] = 0.0
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
        for k in range(4):
            slope, partial, place = own.slope[t, k], own.partial[k], plan.premise[t, k]
            if not task & JACOBIAN:
                for p in range(LANES):
                    slope[p] += pull[p] * partial[p]
            elif place >= 0:
                row, scale = made[first + place, start:], factor[t, k]
                for p in range(count):
                    row[p] = pull[p] * partial[p] * scale


@kernel(nogil=True)
def sweep(
    tables: Tables,
    plan: Plan,
    proposals: np.ndarray,
    x: np.ndarray,
    y: np.ndarray,
    task: int,
    made: np.ndarray,
    place: np.ndarray,
    factor: np.ndarray,
    fires: np.ndarray,
    gradient: np.ndarray,
) -> tuple[float, int]:
    """Sweep over a block; return its squared errors, and the number of samples where no rule fires for some output.

    One function for all tasks: it compiles for some seconds, and most of it serves them all.

    Args:
        tables: The system, its parameters in units of the universes.
        plan: Its consequents' side.
        proposals: The consequents (outputs, terms, inputs + 1), for inputs in units of the universes.
        x: The samples' inputs (samples, inputs), in their own units.
        y: Their outputs (samples, outputs).
        task: A sum of DESIGN, the groups' design matrices; ERRORS; with these GRADIENT, that of the squared errors; or
            JACOBIAN, the outputs' derivatives to the free premises and the residuals, y minus the output.
        made: Where matrices are written, transposed: (rows, samples).
        place: Where in it (3, groups or outputs) int: the first rows of the groups' designs, and of the outputs'
            Jacobians; the outputs' residuals.
        factor: The derivatives of the functions' parameters to the free premises (functions, 4).
        fires: (groups,), to which is added at how many samples a rule of the group fires.
        gradient: Where the derivatives of the squared errors to the functions' parameters are written (functions, 4).
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
        # Backward all outputs go together, but for the Jacobian each alone.
        for turn in range(len(plan.output) if task & JACOBIAN else 1):
            own.rule_pull[:] = 0.0
            for g in range(len(plan.terms)):
                _share(tables, plan, g, work, own)
                if turn == 0:
                    for p in range(count):
                        fires[g] += own.total[0, p] != 0.0
                    if task & DESIGN:
                        _fill_design(plan, g, place[0, g], start, count, work, own, made)
                if not task & (ERRORS | JACOBIAN):
                    continue
                own.pull[:] = 0.0
                for k in range(plan.first_output[g], plan.first_output[g + 1]):
                    o = plan.output[k]
                    if task & JACOBIAN and k != turn:
                        continue
                    _output(plan, g, proposals, o, work, own)
                    output, error = own.total[1], own.total[2]
                    for p in range(count):
                        error[p] = output[p] - y[start + p, o]
                        squares[p] += error[p] * error[p]
                        missing[p] |= not own.total[0, p] > 0.0
                    if task & JACOBIAN:
                        row = made[place[2, o], start:]
                        for p in range(count):
                            row[p] = -error[p]
                    for p in range(LANES):
                        error[p] = 1.0 if task & JACOBIAN else (2.0 * error[p] if p < count else 0.0)
                    if task & (GRADIENT | JACOBIAN):
                        _pull_terms(plan, g, work, own)
                if task & (GRADIENT | JACOBIAN):
                    _pull_rules(plan, g, work, own)
            if task & (GRADIENT | JACOBIAN):
                _pull_firing(tables, plan, work, own)
                _pull_memberships(tables, work, own)
                first = place[1, plan.output[turn]]
                _add_slopes(tables, plan, task, factor, first, start, count, work, own, made)
        for p in range(count):
            silent += missing[p]
    for t in range(len(tables.kind)):
        for k in range(4):
            gradient[t, k] = own.slope[t, k].sum()
    return squares.sum(), silent
