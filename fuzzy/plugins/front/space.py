"""Rules as genes: what a candidate of the search is, what it errs by, and how large it is."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from fuzzy.fitting.identification import Data, grid_terms
from fuzzy.fitting.selection import spread_of
from fuzzy.membershipfunction import MembershipFunction

_SPARSE = 0.5  # of a new rule's conditions so many are left out
_NONE = 1e9  # the error of a candidate that asks for nothing


class Candidate(NamedTuple):
    """What genes say."""

    order: int
    terms: tuple[int, ...]  # (inputs,) how many each input has, 0 where no rule asks for it
    inputs: tuple[int, ...]  # those of the system: those asked for, and with linear consequents others
    rules: tuple[tuple[int, ...], ...]  # (rules, inputs) places of terms, -1 for none; each once


@dataclass(frozen=True, eq=False)
class RuleSpace:
    """The samples, what genes may say of them, and what each candidate came to."""

    data: Data
    terms: tuple[int, ...]
    orders: tuple[int, ...]
    rules: int
    ridge: float
    held: list[np.ndarray]  # rows that each fold holds back
    known: dict[Candidate, tuple[float, float]] = field(default_factory=dict)  # error and operations

    @cached_property
    def functions(self) -> dict[tuple[int, int], list[MembershipFunction]]:
        """The terms of each input (its place) for each number of them."""
        inputs = range(len(self.data.inputs))
        return {
            (i, n): grid_terms("gaussmf", self.data.low[i], self.data.high[i], n) for i in inputs for n in self.terms
        }

    @cached_property
    def degrees(self) -> dict[tuple[int, int], np.ndarray]:
        """The degrees (terms, samples) of these."""
        return {
            (i, n): np.stack([f(self.data.x[:, i]) for f in functions]) for (i, n), functions in self.functions.items()
        }

    @cached_property
    def scaled(self) -> np.ndarray:
        """The inputs over their universes, in [-1, 1] (samples, inputs)."""
        low, high = (ends[: len(self.data.inputs)] for ends in (self.data.low, self.data.high))
        return 2 * (self.data.x - low) / (high - low) - 1

    @cached_property
    def y(self) -> np.ndarray:
        """The outputs (samples, outputs), each in units of its spread."""
        return self.data.y / spread_of(self.data.y)

    @property
    def upper(self) -> np.ndarray:
        """The greatest value of each gene, all begin at 0: order, each input's terms twice, the rules.

        The upper half of an input's values has it in the system also where no rule asks for it.
        """
        n = len(self.data.inputs)
        kinds = [len(self.orders) - 1, *[2 * len(self.terms) - 1] * n]
        return np.array([*kinds, *[max(self.terms)] * (n * self.rules)])

    def counts(self, genes: np.ndarray) -> np.ndarray:
        """How many terms each input has (inputs,)."""
        return np.array(self.terms)[genes[1 : len(self.data.inputs) + 1] % len(self.terms)]

    def candidate(self, genes: np.ndarray) -> Candidate:
        """What genes say; a place beyond an input's terms counts from the first again."""
        n = len(self.data.inputs)
        order, counts = self.orders[genes[0]], self.counts(genes)
        rows = genes[n + 1 :].reshape(self.rules, n)
        places = np.where(rows > 0, (rows - 1) % counts, -1)
        asked = np.any(places >= 0, axis=0)
        carried = asked | ((genes[1 : n + 1] >= len(self.terms)) & bool(order))
        distinct = {tuple(map(int, row)) for row in places[np.any(places >= 0, axis=1)]}
        used = tuple(c if a else 0 for c, a in zip(counts.tolist(), np.atleast_1d(asked), strict=True))
        return Candidate(order, used, tuple(map(int, np.flatnonzero(carried))), tuple(sorted(distinct)))

    def sprout(self, rng: np.random.Generator, genes: np.ndarray) -> np.ndarray:
        """A rule's genes (inputs,): the nearest terms of a sample, about half of them left out."""
        at = rng.integers(len(self.data.x))
        row = np.array([1 + int(np.argmax(self.degrees[i, int(c)][:, at])) for i, c in enumerate(self.counts(genes))])
        row[rng.random(len(row)) < _SPARSE] = 0
        return row

    def objectives(self, candidate: Candidate) -> tuple[float, float]:
        """Its cross-validated error, and the operations of its formula."""
        if candidate not in self.known:
            self.known[candidate] = self._error(candidate), self._operations(candidate)
        return self.known[candidate]

    def _operations(self, candidate: Candidate) -> float:
        outputs = self.y.shape[1]
        clauses = [sum(place >= 0 for place in rule) for rule in candidate.rules]
        consequent = 3 + 2 * len(candidate.inputs) * candidate.order
        return outputs + sum(2 * count - 1 + consequent * outputs for count in clauses)

    def _error(self, candidate: Candidate) -> float:
        """The cross-validated error by normal equations: fast, and near that of the fits that judge in the end."""
        if not candidate.rules:
            return _NONE
        fired = np.ones((len(candidate.rules), len(self.y)))
        for r, rule in enumerate(candidate.rules):
            for i, place in enumerate(rule):
                if place >= 0:
                    fired[r] *= self.degrees[i, candidate.terms[i]][place]
        total = fired.sum(axis=0)
        shares = (fired / np.where(total > 0, total, 1.0)).T
        design = shares
        if candidate.order:
            ones = np.column_stack([self.scaled[:, candidate.inputs], np.ones(len(self.y))])
            design = (shares[:, :, None] * ones[:, None, :]).reshape(len(self.y), -1)
        gram, moment, ones = design.T @ design, design.T @ self.y, design.sum(axis=0)[:, None]
        squares = []
        for rows in self.held:
            part, y = design[rows], self.y[rows]
            left = len(self.y) - len(rows)
            mean = (self.y.sum(axis=0) - y.sum(axis=0)) / left
            left_ones = ones - part.sum(axis=0)[:, None]
            normal = gram - part.T @ part + self.ridge * left * np.eye(len(gram))
            theta = np.linalg.solve(normal, moment - part.T @ y - left_ones * mean)
            squares.append(np.mean((part @ theta + mean - y) ** 2))
        return float(np.sqrt(np.mean(squares)))
