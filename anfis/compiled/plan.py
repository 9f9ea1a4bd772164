"""A system as arrays for learning, and the rows that a chunk of samples is computed in."""

from typing import NamedTuple

import numpy as np

from fuzzy.compiled.jit import kernel
from fuzzy.compiled.tables import NUMBERS
from fuzzy.fitting.consequents import OutputGroup
from fuzzy.inference import logarithmic
from fuzzy.system import Sugeno

CHUNK_LANES = 64  # samples a chunk: the rows of a chunk stay in the cache


class KernelPlan(NamedTuple):
    """A system as arrays, its membership functions ("functions") numbered in one sequence over all inputs.

    A group is outputs of the same rules, terms and orders, whose consequents have one design matrix.
    """

    low: np.ndarray  # (inputs,): ends of the universes, in the inputs' own units
    span: np.ndarray  # (inputs,): their widths, 1 for one of a single value
    high: np.ndarray  # (inputs,): the upper ends in units of the universe: 1, or 0 for one of a single value
    clip: bool  # are inputs clipped to their universe?
    kind: np.ndarray  # (functions,) int: of :data:`fuzzy.compiled.tables.NUMBERS`
    input: np.ndarray  # (functions,) int
    premise: np.ndarray  # (functions, 4) int: each parameter's place among the free premises, -1 for none
    logarithmic: bool  # are firing strengths sums of logarithms?
    clause: np.ndarray  # (rules, inputs) int: the function's number, -1 where the rule leaves the input out
    power: np.ndarray  # (rules, inputs): hedges
    negated: np.ndarray  # (rules, inputs) bool
    is_or: np.ndarray  # (rules,) bool
    weight: np.ndarray  # (rules,)
    and_min: bool  # "and" is the minimum, otherwise the product
    or_max: bool  # "or" is the maximum, otherwise the probabilistic or
    normalise: bool  # are weights normalised (wtaver), or firing strengths (wtsum)?
    place: np.ndarray  # (groups, rules) int: the term that each rule proposes, -1 for none
    everyone: np.ndarray  # (groups,) bool: does every rule have a say?
    terms: np.ndarray  # (groups,) int: how many terms
    column: np.ndarray  # (columns,) int: free columns of terms × (inputs + 1), group by group
    first_column: np.ndarray  # (groups + 1,) int: where each group's columns begin
    output: np.ndarray  # (outputs,) int: the outputs, group by group
    first_output: np.ndarray  # (groups + 1,) int
    middle: np.ndarray  # (outputs,): what stands where no rule fires


def plan_of(
    fis: Sugeno, groups: tuple[OutputGroup, ...], low: np.ndarray, span: np.ndarray, high: np.ndarray
) -> KernelPlan:
    """The plan of a system whose functions all have a number; ``low``, ``span`` and ``high`` as there."""
    s, functions = fis.structure, [(i, f) for i, v in enumerate(fis.inputs) for f in v.terms.values()]
    premise, last = np.full((len(functions), 4), -1, dtype=np.int64), 0
    for kind in s.kinds:
        shape = len(kind.terms), len(kind.function.roles)
        premise[kind.terms, : shape[1]] = last + np.arange(shape[0] * shape[1]).reshape(shape)
        last += shape[0] * shape[1]
    return KernelPlan(
        low=low,
        span=span,
        high=high,
        clip=fis.out_of_range == "clip",
        kind=np.array([NUMBERS[type(f)] for _, f in functions], dtype=np.int64),
        input=np.array([i for i, _ in functions], dtype=np.int64),
        premise=premise,
        logarithmic=logarithmic(fis),
        clause=np.ascontiguousarray(np.where(s.term >= 0, s.term + s.first[:-1, None], -1).T),
        power=np.ascontiguousarray(s.power.T),
        negated=np.ascontiguousarray(s.negated.T),
        is_or=s.is_or.copy(),
        weight=s.weight.copy(),
        and_min=fis.and_method == "min",
        or_max=fis.or_method == "max",
        normalise=fis.defuzzification == "wtaver",
        place=np.array([g.place for g in groups], dtype=np.int64),
        everyone=np.array([min(g.place) >= 0 for g in groups]),
        terms=np.array([len(g.linear) for g in groups], dtype=np.int64),
        column=np.concatenate([g.columns for g in groups]).astype(np.int64),
        first_column=np.cumsum([0, *(len(g.columns) for g in groups)], dtype=np.int64),
        output=np.array([o for g in groups for o in g.outputs], dtype=np.int64),
        first_output=np.cumsum([0, *(len(g.outputs) for g in groups)], dtype=np.int64),
        middle=np.array([v.midrange for v in fis.outputs]),
    )


class ChunkRows(NamedTuple):
    """The rows of a chunk, each CHUNK_LANES long. What they hold beforehand does not matter."""

    x: np.ndarray  # (inputs, CHUNK_LANES), in units of the universes
    degree: np.ndarray  # (functions, CHUNK_LANES): degrees of membership, or their logarithms
    firing: np.ndarray  # (rules, CHUNK_LANES): firing strengths, or their logarithms
    weights: np.ndarray  # (rules, CHUNK_LANES): their shares, which sum to 1
    forward: np.ndarray  # (functions + 2 rules, CHUNK_LANES): the memory of these three
    share: np.ndarray  # (terms, CHUNK_LANES): the terms' weights
    total: np.ndarray  # (3, CHUNK_LANES): their sum before they are normalised again; output; error
    proposal: np.ndarray  # (terms, CHUNK_LANES): what a term proposes
    pull: np.ndarray  # (terms, CHUNK_LANES): the derivative to the terms' weights
    rule_pull: np.ndarray  # (rules, CHUNK_LANES): to the rules' weights, then to their strengths or logarithms
    term_pull: np.ndarray  # (functions, CHUNK_LANES): to degrees, or their logarithms
    clause: np.ndarray  # (inputs, CHUNK_LANES): degrees after hedge and "not"
    so_far: np.ndarray  # (inputs + 1, CHUNK_LANES): the firing strength after each clause
    partial: np.ndarray  # (4, CHUNK_LANES): derivatives to the parameters of one function
    row: np.ndarray  # (CHUNK_LANES,)


@kernel(nogil=True)
def rows(plan: KernelPlan) -> ChunkRows:
    """Make the rows for chunks of CHUNK_LANES samples; one thread works in them."""
    rules, inputs = plan.clause.shape
    functions, terms = len(plan.kind), max(1, plan.terms.max())
    sizes = (inputs, functions, rules, rules, terms, 3, terms, terms, rules, functions, inputs, inputs + 1, 4, 1)
    count = 0
    for size in sizes:
        count += size
    memory = np.empty(count * CHUNK_LANES + 8)
    # A vector that straddles two lines of the cache takes twice the time.
    begin = (-memory.ctypes.data // 8) % 8
    all_rows = memory[begin : begin + count * CHUNK_LANES].reshape(count, CHUNK_LANES)
    a = inputs + functions
    b = a + 2 * rules
    c = b + 3 * terms + 3
    d = c + rules + functions
    return ChunkRows(
        all_rows[:inputs],
        all_rows[inputs:a],
        all_rows[a : a + rules],
        all_rows[a + rules : b],
        all_rows[inputs:b],
        all_rows[b : b + terms],
        all_rows[b + terms : b + terms + 3],
        all_rows[b + terms + 3 : b + 2 * terms + 3],
        all_rows[b + 2 * terms + 3 : c],
        all_rows[c : c + rules],
        all_rows[c + rules : d],
        all_rows[d : d + inputs],
        all_rows[d + inputs : d + 2 * inputs + 1],
        all_rows[d + 2 * inputs + 1 : d + 2 * inputs + 5],
        all_rows[d + 2 * inputs + 5],
    )
