"""What learning adds to a system's tables: scales, outputs by design matrix, where each sum lies."""

from typing import NamedTuple

import numpy as np

from fuzzy.compiled.jit import kernel
from fuzzy.compiled.kernel import workspace
from fuzzy.compiled.tables import Tables, Workspace

LANES = 128  # samples a chunk: the rows of a chunk stay in the cache


class Plan(NamedTuple):
    """The consequents' side of a system as arrays. A group is outputs of the same rules, terms and orders."""

    low: np.ndarray  # (inputs,): ends of the universes, in the inputs' own units
    span: np.ndarray  # (inputs,): their widths, 1 for one of a single value
    high: np.ndarray  # (inputs,): the upper ends in units of the universe: 1, or 0 for one of a single value
    clip: bool  # are inputs clipped to their universe?
    normalise: bool  # are weights normalised (wtaver), or firing strengths (wtsum)?
    place: np.ndarray  # (groups, rules) int: the term that each rule proposes, -1 for none
    everyone: np.ndarray  # (groups,) bool: does every rule have a say?
    terms: np.ndarray  # (groups,) int: how many terms
    column: np.ndarray  # (columns,) int: free columns of terms × (inputs + 1), group by group
    first_column: np.ndarray  # (groups + 1,) int: where each group's columns begin
    output: np.ndarray  # (outputs,) int: the outputs, group by group
    first_output: np.ndarray  # (groups + 1,) int
    middle: np.ndarray  # (outputs,): what stands where no rule fires
    premise: np.ndarray  # (functions, 4) int: each parameter's place among the free premises, -1 for none


class Rows(NamedTuple):
    """The rows that a chunk of samples is learnt from, beside :class:`fuzzy.compiled.tables.Workspace`."""

    share: np.ndarray  # (terms, lanes): the terms' weights
    total: np.ndarray  # (3, lanes): their sum before they are normalised again; output; error
    proposal: np.ndarray  # (terms, lanes): what a term proposes
    pull: np.ndarray  # (terms, lanes): the derivative to the terms' weights
    rule_pull: np.ndarray  # (rules, lanes): to the rules' weights, then to their firing strengths or logarithms of them
    term_pull: np.ndarray  # (membership functions, lanes): to degrees, or their logarithms
    clause: np.ndarray  # (inputs, lanes): degrees after hedge and "not"
    so_far: np.ndarray  # (inputs + 1, lanes): the firing strength after each clause
    partial: np.ndarray  # (4, lanes): derivatives to the parameters of one membership function
    scratch: np.ndarray  # (4, lanes)
    bits: np.ndarray  # the memory of scratch[1] as int64
    slope: np.ndarray  # (membership functions, 4, lanes): the sums so far, a lane apart


@kernel(nogil=True)
def rows(tables: Tables, plan: Plan) -> tuple[Workspace, Rows]:
    """Make the rows for chunks of LANES samples; one thread works in them."""
    rules, inputs = tables.clause.shape
    functions, terms = len(tables.kind), max(1, plan.terms.max())
    scratch = np.empty((4, LANES))
    return workspace(tables, LANES), Rows(
        np.empty((terms, LANES)),
        np.empty((3, LANES)),
        np.empty((terms, LANES)),
        np.empty((terms, LANES)),
        np.empty((rules, LANES)),
        np.empty((functions, LANES)),
        np.empty((inputs, LANES)),
        np.empty((inputs + 1, LANES)),
        np.empty((4, LANES)),
        scratch,
        scratch[1].view(np.int64),
        np.empty((functions, 4, LANES)),
    )
