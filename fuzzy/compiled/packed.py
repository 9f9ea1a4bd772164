"""A whole Sugeno system in one row of float64 numbers, and the inference of one point from it.

A compiled function that evaluates many systems of any size, such as the rule bases of a population of candidates,
takes them all as arrays of one type and is compiled once::

    system = packed(compiled)                                   # in Python, once for each system
    work = np.empty(packed_work(system))                        # once for each thread
    evaluate_packed(system, x, output, work)                    # x (inputs,), output (outputs,)

The row starts with a header of sizes, choices and places; whole numbers and yes/no are float64 as well.
"""

import warnings
from typing import Any

import numpy as np

from fuzzy.compiled.columns import Columns, column
from fuzzy.compiled.degrees import exp_nonpositive, fill_degrees, log_gaussian, minimum, sampled, trapezoid
from fuzzy.compiled.jit import compiled_only, kernel, without_refcounts
from fuzzy.compiled.tables import KIND, NUMBERS, READ_STEPS
from fuzzy.inference import InferenceWarning, logarithmic, never
from fuzzy.membershipfunction import MembershipFunction, as_number
from fuzzy.system import FuzzySystemError, Linear, Sugeno

NEVER = never(np.float64)


class PackedColumns(Columns):
    """The header of a system: sizes, choices, and then where each list begins."""

    inputs = column("1")
    outputs = column("1")
    terms = column("1")
    rules = column("1")
    segments = column("1")
    logs = column("", "1: firing strengths are sums of logarithms")
    and_min = column("", "1: 'and' is the minimum, otherwise the product")
    or_max = column("", "1: 'or' is the maximum, otherwise the probabilistic or")
    weighted_sum = column("", "1: wtsum, otherwise wtaver")
    clip = column("", "1: inputs are clipped to their universe")
    plain = column("", "1: all rules are 'and' without a hedge and without 'not'")
    every = column("", "1: a rule that does not fire counts, since it proposes what is not finite")
    lined = column("", "a bit for each rule where there are lines; otherwise 0")
    low = column("", "(inputs,): the lower ends of the universes of discourse")
    high = column("", "(inputs,): the upper ends")
    # The terms are numbered by input and kind: a segment is all terms of one input with one membership function.
    segment_input = column("", "(segments,)")
    segment_kind = column("", "(segments,): of fuzzy.compiled.tables.NUMBERS")
    segment_end = column("", "(segments,): the last term's number + 1")
    a = column("", "(terms,): the first parameter in the order of the function's class, 0 where there is none")
    b = column("", "(terms,): the second")
    c = column("", "(terms,): the third")
    d = column("", "(terms,): the fourth")
    lines = column("", "(terms, LineColumns), of use where all are triangles or trapezoids, and rules few")
    # The clauses of all rules are one sequence, those of a rule in the order of the inputs.
    rule_end = column("", "(rules,): the last clause's number + 1")
    is_or = column("", "(rules,)")
    weight = column("", "(rules,)")
    needs = column("", "(rules,): a bit for each of the first WHOLE_BITS at whose 0 the rule does not fire")
    clause_term = column("", "(clauses,)")
    clause_power = column("", "(clauses,)")
    clause_negated = column("", "(clauses,)")
    takes_part = column("", "(outputs, rules): 1: the rule has a consequent for the output")
    complete = column("", "(outputs,): 1: all rules have one")
    constant = column("", "(outputs, rules): its constant, 0 without")
    linear = column("", "(outputs,): 1: the output has a first-order consequent")
    sloped = column("", "(outputs, rules): 1: its slopes count; without clipping those of 0, too, where one counts")
    slopes = column("", "(outputs, rules, inputs)")
    default = column("", "(outputs,): the value where no rule fires")
    samples = column("", "of each term without a number READ_STEPS + 1 degrees, from place a on, between b and c")


class LineColumns(Columns):
    """A triangle or a trapezoid, and a bit for each rule of those that ask for it."""

    input = column("", "its number")
    asked = column("", "all rules")
    needed = column("", "those that do not fire where it is 0")
    denied = column("", "those that do not fire where it is 1")
    a = column("", "the left foot")
    b = column("", "the left end of the top")
    c = column("", "the right one")
    d = column("", "the right foot")


_LINE = LineColumns.size
WHOLE_BITS = np.uint64(52)  # terms, or rules, that are told by the bits of a float64
# What evaluate_packed tells, to be added
OUTSIDE = 1  # an input is outside its universe
NO_RULE = 2  # no rule fires for an output


def packed(fis: Sugeno | Any, sample: bool = False) -> np.ndarray:
    """Lay a system out as one array of float64 numbers, for :func:`evaluate_packed`.

    Parameters that are arrays (torch tensors in training, for example) are read now, and not again later.

    Args:
        fis: A system, or what :func:`fuzzy.compiled.sugeno.compile_sugeno` made of one.
        sample: Whether membership functions that the compiled inference has no branch for are read at many points,
            with a warning that says how near to them one comes.

    Raises:
        FuzzySystemError: There is such a function, and it is not to be sampled.
    """
    if not isinstance(fis, Sugeno):
        fis = fis.fis
    s = fis.structure
    lists: dict[str, Any] = {"low": [v.universe[0] for v in fis.inputs], "high": [v.universe[1] for v in fis.inputs]}
    number = _lay_out_terms(fis, lists, sample)
    asked = [[(i, s.term[i, r]) for i in range(len(fis.inputs)) if s.term[i, r] >= 0] for r in range(len(fis.rules))]
    clauses = [(i, r, number[i][t]) for r, row in enumerate(asked) for i, t in row]
    lists["rule_end"] = np.cumsum([len(row) for row in asked])
    lists |= {"is_or": s.is_or, "weight": s.weight}
    lists["needs"] = np.zeros(len(fis.rules))
    for r, row in enumerate(asked):
        needed = {number[i][t] for i, t in row if not s.is_or[r] and not s.negated[i, r] and s.power[i, r] > 0}
        lists["needs"][r] = sum(1 << t for t in needed if t < WHOLE_BITS)
    lists["clause_term"] = [t for _, _, t in clauses]
    lists["clause_power"] = [s.power[i, r] for i, r, _ in clauses]
    lists["clause_negated"] = [s.negated[i, r] for i, r, _ in clauses]
    straight = {*lists["segment_kind"]} <= {KIND.Triangle, KIND.Trapezoid}
    lined = 2 ** len(fis.rules) - 1 if straight and len(fis.rules) <= WHOLE_BITS else 0
    for i, r, t in clauses if lined else ():
        lists["lines"][t, 1] += 1 << r
        if not s.is_or[r]:
            lists["lines"][t, 3 if s.negated[i, r] else 2] += 1 << r
    lists["takes_part"] = s.consequent >= 0
    lists["complete"] = (s.consequent >= 0).all(axis=-1)
    lists["constant"], lists["slopes"] = proposed_numbers(fis)
    lists["linear"] = np.array([any(isinstance(t, Linear) for t in v.terms.values()) for v in fis.outputs])
    slopes = lists["slopes"].any(axis=-1) if fis.out_of_range == "clip" else True
    lists["sloped"] = slopes & lists["linear"][:, None] & lists["takes_part"]
    lists["default"] = [v.midrange if fis.no_rule_fires == "midrange" else np.nan for v in fis.outputs]
    rows = {name: np.asarray(lists[name], dtype=np.float64).ravel() for name in PackedColumns.columns if name in lists}
    begins = np.cumsum([PackedColumns.size, *(len(row) for row in rows.values())])
    header = {
        "inputs": len(fis.inputs),
        "outputs": len(fis.outputs),
        "terms": len(lists["a"]),
        "rules": len(fis.rules),
        "segments": len(lists["segment_kind"]),
        "logs": logarithmic(fis),
        "and_min": fis.and_method == "min",
        "or_max": fis.or_method == "max",
        "weighted_sum": fis.defuzzification == "wtsum",
        "clip": fis.out_of_range == "clip",
        "lined": lined,
        "every": not (np.isfinite(lists["constant"]).all() and np.isfinite(lists["slopes"]).all()),
        "plain": bool((s.power == 1).all()) and not (s.is_or.any() or s.negated.any()),
        **dict(zip(rows, begins, strict=False)),
    }
    return np.concatenate([np.array(PackedColumns.stacked(header), dtype=np.float64), *rows.values()])


def _lay_out_terms(fis: Sugeno, lists: dict[str, Any], sample: bool) -> list[list[int]]:
    """Add the lists of segments and terms; return the number of each input's each term."""
    functions = [list(v.terms.values()) for v in fis.inputs]
    strange = sorted({f.matlab for row in functions for f in row if type(f) not in NUMBERS})
    if strange and not sample:
        raise FuzzySystemError(
            f"{fis.name}: the compiled kernel has no branch for {', '.join(strange)}; fuzzy.infer evaluates the system"
        )
    kinds = [[NUMBERS.get(type(f), KIND.Sampled) for f in row] for row in functions]
    terms = sorted((i, kind, t) for i, row in enumerate(kinds) for t, kind in enumerate(row))
    ends = [k for k in range(1, len(terms)) if terms[k - 1][:2] != terms[k][:2]] + [len(terms)] * bool(terms)
    lists["segment_input"] = [terms[k - 1][0] for k in ends]
    lists["segment_kind"] = [terms[k - 1][1] for k in ends]
    lists["segment_end"] = ends
    parameters = np.zeros((4, len(terms)))
    number = [[0] * len(row) for row in functions]
    samples, largest = list[np.ndarray](), 0.0
    for k, (i, kind, t) in enumerate(terms):
        values = functions[i][t].numbers
        if kind == KIND.Sampled:
            values = len(samples) * (READ_STEPS + 1), *fis.inputs[i].universe
            degrees, error = _sampled(fis, i, functions[i][t])
            samples, largest = [*samples, degrees], max(largest, error)
        parameters[: len(values), k] = values
        number[i][t] = k
    lists |= dict(zip("abcd", parameters, strict=True)) | {"samples": samples}
    corners = [parameters[[0, 1, 1, 2] if kind == KIND.Triangle else ..., k] for k, (_, kind, _) in enumerate(terms)]
    lists["lines"] = np.array([[i, 0, 0, 0, *row] for (i, _, _), row in zip(terms, corners, strict=True)])
    if strange:
        warnings.warn(
            f"{fis.name}: the compiled inference has no branch for {', '.join(strange)}, and reads it in {READ_STEPS} "
            f"steps of the universe: the degrees are within {largest:.1e}. CONTRIBUTING.md names the files of a branch",
            InferenceWarning,
            stacklevel=4,
        )
    return number


def _sampled(fis: Sugeno, i: int, f: MembershipFunction) -> tuple[np.ndarray, float]:
    """The degrees in the universe of an input, or their logarithms, and by how much one between two is wrong."""
    x = np.linspace(*fis.inputs[i].universe, 2 * READ_STEPS + 1)
    degrees = np.asarray(f(x))
    error = float(np.abs((degrees[:-1:2] + degrees[2::2]) / 2 - degrees[1::2]).max())
    if logarithmic(fis) and f.log_formula is not None:
        return np.maximum(f.log_formula(x[::2], *f.numbers), NEVER), error
    return degrees[::2], error


def proposed_numbers(fis: Sugeno) -> tuple[np.ndarray, np.ndarray]:
    """The constants (outputs, rules) and the slopes (outputs, rules, inputs) of what the rules propose."""
    shape = (len(fis.outputs), len(fis.rules))
    constants, slopes = np.zeros(shape), np.zeros((*shape, len(fis.inputs)))
    for o, variable in enumerate(fis.outputs):
        consequents = [[as_number(p) for p in term.parameters] for term in variable.terms.values()]
        for r in np.flatnonzero(fis.structure.consequent[o] >= 0):
            *slope, constants[o, r] = consequents[fis.structure.consequent[o, r]]
            slopes[o, r, : len(slope)] = slope
    return constants, slopes


@kernel(nogil=True)
def packed_work(system: np.ndarray) -> int:
    """How many numbers :func:`evaluate_packed` needs to work in."""
    header = PackedColumns(system)
    return int(header.inputs) + int(header.terms) + 2 * int(header.rules)


@compiled_only(forceinline=True)
def whole(number: float) -> Any:
    """A whole number of a system, as an unsigned one: Numba then does not ask whether an index is negative."""
    return np.uint64(np.int64(number))


@compiled_only(forceinline=True)
def clipped(log: float) -> float:
    """Return a logarithm, or what stands for that of 0."""
    return NEVER if log < NEVER else log


@compiled_only
def _degree(kind: int, a: float, b: float, c: float, d: float, x: np.ndarray, degree: np.ndarray) -> None:
    """Write the degree of one term, as :func:`fill_degrees`.

    A function of its own: vector instructions for each of these would take seconds to compile.
    """
    fill_degrees(kind, a, b, c, d, x, degree, 1)


@compiled_only
def _at_trapezoid(x: float, a: float, b: float, c: float, d: float) -> float:
    """The degree of one trapezoid.

    A function of its own with jumps: few terms are slanted where the point is, and a loop of few terms is no vector.
    """
    if x < a or x > d:
        return 0.0
    if b <= x <= c:
        return 1.0
    return trapezoid(x, a, b, c, d)


@compiled_only(forceinline=True)
def _line_degrees(system: np.ndarray, work: np.ndarray, at: int) -> tuple[Any, bool]:
    """Layer 1 of triangles and trapezoids: the degrees of which a rule asks that may still fire.

    Returns a bit for each rule that fires or may do so, and whether a degree is not-a-number.
    """
    header, unknown = PackedColumns(system), False
    alive, row = whole(header.lined), whole(header.lines)
    for t in range(whole(header.terms)):
        line = LineColumns(system, row)
        if whole(line.asked) & alive:
            x, degree = work[whole(line.input)], 1.0
            if x < line.a or x > line.d:
                degree = 0.0
                alive &= ~whole(line.needed)
            elif line.b <= x <= line.c:
                alive &= ~whole(line.denied)
            else:
                degree = trapezoid(x, line.a, line.b, line.c, line.d)
                unknown |= degree != degree
            work[at + t] = degree
        row += np.uint64(_LINE)
    return alive, unknown


@compiled_only(forceinline=True)
def _degrees(
    kind: int, system: np.ndarray, lists: Any, begin: int, end: int, i: int, work: np.ndarray, at: int
) -> bool:
    """Degrees of one segment, whose input is ``work[i]``; from Gaussian on as logarithms.

    ``lists`` are where those of the parameters begin. Returns whether one is not-a-number, of straight lines only.
    """
    header = PackedColumns(system)
    (a, b, c, d), x, unknown = lists, work[i], False
    if kind == KIND.Gaussian:
        for t in range(begin, end):
            work[at + t] = clipped(log_gaussian(x, system[a + t], system[b + t]))
    elif kind in (KIND.Triangle, KIND.Trapezoid):
        c, d = (b, c) if kind == KIND.Triangle else (c, d)
        for t in range(begin, end):
            degree = _at_trapezoid(x, system[a + t], system[b + t], system[c + t], system[d + t])
            unknown |= degree != degree
            work[at + t] = degree
    elif kind == KIND.Sampled:
        for t in range(begin, end):
            values = whole(header.samples + system[a + t])
            work[at + t] = sampled(x, system[values:], system[b + t], system[c + t])
    else:
        for t in range(begin, end):
            _degree(kind, system[a + t], system[b + t], system[c + t], system[d + t], work[i:], work[at + t :])
    return unknown


@compiled_only(forceinline=True)
def _memberships(system: np.ndarray, work: np.ndarray, at: int, logs: bool) -> bool:
    """Layer 1 of the point at the beginning of ``work``; return whether a degree is not-a-number."""
    header = PackedColumns(system)
    begin, unknown = np.uint64(0), False
    inputs, kinds, ends = whole(header.segment_input), whole(header.segment_kind), whole(header.segment_end)
    lists = whole(header.a), whole(header.b), whole(header.c), whole(header.d)
    for s in range(whole(header.segments)):
        kind, end = np.int64(system[kinds + s]), whole(system[ends + s])
        unknown |= _degrees(kind, system, lists, begin, end, whole(system[inputs + s]), work, at)
        if kind >= KIND.Gaussian and not logs:
            for t in range(begin, end):
                work[at + t] = exp_nonpositive(work[at + t])
        if kind not in (KIND.Gaussian, KIND.Triangle, KIND.Trapezoid):
            for t in range(begin, end):
                degree = work[at + t]
                unknown |= degree != degree
                work[at + t] = clipped(degree)
        begin = end
    return unknown


@compiled_only(forceinline=True)
def _hedged(degree: float, power: float, negated: bool) -> float:
    """A degree after hedge and "not".

    1 − μ has few true digits where μ is close to 1, whose last one is 1e-16. Where all rules that fire do so by such a
    difference, of the sum w, the output is exact to about 1e-16 / w of its range, here as in fuzzy.inference: the two
    agree within 5e-7 of the range in 5,000 random systems.
    """
    if power == 2.0:
        degree = degree * degree
    elif power == 0.5:
        degree = np.sqrt(degree)
    elif power != 1.0:
        degree = degree**power
    return 1.0 - degree if negated else degree


@compiled_only(forceinline=True)
def _firing(
    system: np.ndarray, work: np.ndarray, degrees: int, firing: int, rules: int, every: bool, alive: Any
) -> tuple[Any, float]:
    """Layer 2 from degrees: the strengths of the rules that fire and, from ``firing + rules`` on, their numbers.

    Returns how many they are, and the sum of their strengths. With ``every`` they are all rules. Of lines ``alive``
    tells those that may.
    """
    header = PackedColumns(system)
    ends, is_or, weight = whole(header.rule_end), whole(header.is_or), whole(header.weight)
    term, power, negated = whole(header.clause_term), whole(header.clause_power), whole(header.clause_negated)
    and_min, or_max, plain = header.and_min != 0.0, header.or_max != 0.0, header.plain != 0.0
    needs, may_fire, count, total = whole(header.needs), np.uint64(0), np.uint64(0), 0.0
    if header.lined != 0.0 and not every:
        while alive != 0:
            lowest = alive & (~alive + np.uint64(1))
            work[firing + rules + may_fire] = np.float64((np.float64(lowest).view(np.int64) >> 52) - 1023)  # its number
            may_fire += np.uint64(1)
            alive ^= lowest
    else:
        nowhere = np.uint64(0)  # a bit for each term whose degree is 0: what needs one of them does not fire
        for t in range(min(whole(header.terms), WHOLE_BITS)):
            nowhere |= np.uint64(work[degrees + t] == 0.0) << t
        for r in range(rules):  # without a jump, of which the processor would guess many wrong
            work[firing + rules + may_fire] = np.float64(r)
            may_fire += np.uint64(every or not whole(system[needs + r]) & nowhere)
    for n in range(may_fire):
        r, w = whole(work[firing + rules + n]), 0.0
        begin, end = whole(system[ends + r - np.uint64(1)]) if r > 0 else np.uint64(0), whole(system[ends + r])
        if plain or system[is_or + r] == 0.0:
            w = 1.0
            for k in range(begin, end):
                degree = work[degrees + whole(system[term + k])]
                if not plain:
                    degree = _hedged(degree, system[power + k], system[negated + k] != 0.0)
                w = minimum(w, degree) if and_min else w * degree
        else:
            for k in range(begin, end):
                degree = work[degrees + whole(system[term + k])]
                degree = _hedged(degree, system[power + k], system[negated + k] != 0.0)
                if or_max:
                    w = degree if degree > w else w
                else:
                    w = w + degree - w * degree
        w *= system[weight + r]
        if w != 0.0 or every:
            work[firing + count], work[firing + rules + count] = w, np.float64(r)
            total += w
            count += np.uint64(1)
    return count, total


@compiled_only(forceinline=True)
def _log_firing(system: np.ndarray, work: np.ndarray, degrees: int, firing: int, rules: int) -> float:
    """Layer 2 from logarithms, without the rules' weights; return the greatest logarithm of those that count."""
    header = PackedColumns(system)
    ends, weight = whole(header.rule_end), whole(header.weight)
    term, power = whole(header.clause_term), whole(header.clause_power)
    begin, top = np.uint64(0), -np.inf
    for r in range(rules):
        end, log = whole(system[ends + r]), 0.0
        for k in range(begin, end):
            log += work[degrees + whole(system[term + k])] * system[power + k]
        work[firing + r] = log
        if system[weight + r] > 0.0 and log > top:
            top = log
        begin = end
    return top if top > NEVER / 1e6 else 0.0


@compiled_only(forceinline=True)
def _log_weights(system: np.ndarray, work: np.ndarray, degrees: int, firing: int, rules: int) -> None:
    """Layers 2 and 3 from logarithms: firing strengths w, and from ``firing + rules`` on w over the greatest w."""
    header = PackedColumns(system)
    weight, weights = whole(header.weight), firing + rules
    top = _log_firing(system, work, degrees, firing, rules)
    for r in range(rules):
        factor, log = system[weight + r], work[firing + r] - top
        log = 0.0 if log > 0.0 else log  # a rule without weight is no part of the greatest strength
        work[weights + r] = exp_nonpositive(log) * factor
    if header.weighted_sum != 0.0:
        for r in range(rules):
            work[firing + r] = exp_nonpositive(work[firing + r]) * system[weight + r]


@compiled_only(forceinline=True)
def _defuzzified(
    system: np.ndarray, work: np.ndarray, firing: int, o: int, rules: int, count: int, sum_: float
) -> tuple[float, bool]:
    """Layers 4 and 5 of output ``o``: its value, and whether a rule fires for it.

    ``count`` rules fire, with strengths of ``sum_`` together, as :func:`_firing` found; of logarithms all are there.
    """
    header = PackedColumns(system)
    row, inputs = o * rules, whole(header.inputs)
    takes_part, constant = whole(header.takes_part) + row, whole(header.constant) + row
    slopes, sloped = whole(header.slopes) + row * inputs, whole(header.sloped) + row
    weighted_sum, logs, clips = header.weighted_sum != 0.0, header.logs != 0.0, header.clip != 0.0
    total, output = 0.0, 0.0
    for n in range(count):
        r = n if logs else whole(work[firing + rules + n])
        if system[takes_part + r] == 0.0:
            continue
        weight = work[firing + rules + n] if logs else work[firing + n] / sum_
        share = work[firing + n] if weighted_sum else weight
        total += weight
        proposal = system[constant + r]
        if system[sloped + r] != 0.0 and (share != 0.0 or not clips):  # an input beyond its universe may be infinite
            for i in range(inputs):
                proposal += system[slopes + r * inputs + i] * work[i]
        output += share * proposal
    fires = total > 0.0
    if fires and not weighted_sum and (logs or system[whole(header.complete) + o] == 0.0):
        output /= total
    return output, fires


@without_refcounts
def evaluate_packed(system: np.ndarray, x: np.ndarray, output: np.ndarray, work: np.ndarray) -> int:
    """Evaluate one point, for calls from other compiled functions; the bits are those of a call of the system.

    Inputs outside their universe are clipped if the system says so. No warning is given of them, nor of a point where
    no rule fires.

    Args:
        system: The system, see :func:`packed`.
        x: The point (inputs,), each number in the unit of its variable.
        output: Where the outputs (outputs,) are written.
        work: ``packed_work(system)`` numbers or more, of one thread. What they hold beforehand does not matter.

    Returns:
        0, or the sum of OUTSIDE where an input is outside its universe and is not clipped, and NO_RULE where no rule
        fires for one of the outputs.
    """
    header = PackedColumns(system)
    inputs, terms, rules = whole(header.inputs), whole(header.terms), whole(header.rules)
    low, high, clip = whole(header.low), whole(header.high), header.clip != 0.0
    unknown, told, every = False, 0, header.every != 0.0
    for i in range(inputs):
        value = x[i]
        unknown |= value != value
        if value < system[low + i] or value > system[high + i]:
            if clip:
                value = system[low + i] if value < system[low + i] else system[high + i]
            else:
                told, every = OUTSIDE, every or abs(value) == np.inf
        work[i] = value
    alive, strange = np.uint64(0), False
    if header.lined != 0.0 and not every:
        alive, strange = _line_degrees(system, work, inputs)
    else:
        strange = _memberships(system, work, inputs, header.logs != 0.0)
    unknown |= strange
    firing, count, sum_ = inputs + terms, rules, 1.0
    if header.logs != 0.0:
        _log_weights(system, work, inputs, firing, rules)
    else:
        count, sum_ = _firing(system, work, inputs, firing, rules, every, alive)
        sum_ = 1.0 if sum_ == 0.0 else sum_
    default = whole(header.default)
    for o in range(whole(header.outputs)):
        value, fires = _defuzzified(system, work, firing, o, rules, count, sum_)
        if unknown:  # a minimum or "no rule fires" might have lost it
            output[o] = np.nan
        elif fires:
            output[o] = value
        else:
            output[o] = system[default + o]
            told |= NO_RULE
    return told


def one_point(system: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Make all that :func:`evaluate_one` needs, in one array: the system, a point, its outputs and memory to work in.

    Returns:
        The array, and its parts (inputs,) and (outputs,), where a point is written before and its outputs stand after.
    """
    header, x = PackedColumns(system), len(system)
    output = x + int(header.inputs)
    work = output + int(header.outputs)
    memory = np.zeros(work + packed_work(system) + 1)
    memory[:x], memory[-1] = system, x
    return memory, memory[x:output], memory[output:work]


@without_refcounts
def evaluate_one(memory: np.ndarray) -> int:
    """Evaluate the point in what :func:`one_point` made, as :func:`evaluate_packed` does, for calls from Python."""
    header, x = PackedColumns(memory), whole(memory[len(memory) - 1])
    output = x + whole(header.inputs)
    work = output + whole(header.outputs)
    return evaluate_packed(memory, memory[x:output], memory[output:work], memory[work:])
