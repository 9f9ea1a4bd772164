"""Learning of a whole tree: the gradient of its error goes through all systems, by torch.

Every number of every membership function and consequent moves, in units of the universe that it belongs to, by Adam
[Kingma and Ba 2015]. After each step vertices are put in order again, and widths keep their sign and a least size.
"""

import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fuzzy.extras import needed
from fuzzy.fitting.clustering import finite_table
from fuzzy.fitting.consequents import output_table
from fuzzy.fitting.selection import spread_of
from fuzzy.inference import InferenceWarning, forgiving
from fuzzy.membershipfunction import MembershipFunction, as_number
from fuzzy.plugins.trees.tree import Tree, TreeError
from fuzzy.system import Linear, Sugeno, Variable

_LEAST_WIDTH = 1e-3  # of the universe


@dataclass(frozen=True, eq=False)
class TrainedTree:
    """A tree that was learnt, and how.

    Attributes:
        tree: The tree of the least error, on the data to check where there are such.
        errors: The error on the data before each step and after the last one: the root mean square over the outputs,
            each in units of its standard deviation in the data.
        check_errors: Likewise on the data to check; empty without.
    """

    tree: Tree
    errors: tuple[float, ...]
    check_errors: tuple[float, ...]


def train_tree(
    tree: Tree,
    x: Any,
    y: Any,
    *,
    epochs: int = 200,
    step: float = 0.01,
    check: tuple[Any, Any] | None = None,
    progress: Callable[[int, float], Any] = lambda epoch, error: None,
) -> TrainedTree:
    """Move all numbers of a tree's systems so that it errs less at the data: only the tree's outputs need be known.

    Args:
        tree: The tree to start from.
        x: The points (samples, inputs), or values (samples,) by the inputs' names.
        y: What the tree should answer (samples,) or (samples, outputs).
        epochs: How many steps.
        step: How far a number moves in a step at most, about, as a share of its universe.
        check: Data in the form of ``x`` and ``y`` that are not learnt from, and choose the tree that comes back.
        progress: Told the number of the epoch, from 0, and the error before it.

    Returns:
        The tree of the least error, and the errors on the way.

    Raises:
        TreeError: Data that do not fit the tree.
        ClusteringError: Numbers that are not finite.
    """
    torch = needed("torch", "learning a tree")
    data = [_samples(tree, *each) for each in ((x, y), *(() if check is None else (check,)))]
    spread = spread_of(data[0][1])
    quiet = forgiving(tree, "midrange")
    moving, scale = np.array(numbers_of(tree)), np.array(list(_scales(tree)))
    free = torch.tensor(moving / scale, requires_grad=True)
    adam = torch.optim.Adam([free], lr=step)
    sets = [(torch.tensor(points), torch.tensor(wanted / spread)) for points, wanted in data]
    history: list[list[float]] = [[] for _ in sets]
    units, best = torch.tensor(spread), moving
    for epoch in range(epochs + 1):
        learning = with_numbers(quiet, (free * torch.tensor(scale)).unbind())
        with warnings.catch_warnings(action="ignore", category=InferenceWarning):
            losses = [((learning(points) / units - wanted) ** 2).mean() for points, wanted in sets]
        for row, loss in zip(history, losses, strict=True):
            row.append(float(loss.detach()) ** 0.5)
        if history[-1][-1] <= min(history[-1]):
            best = free.detach().numpy() * scale
        progress(epoch, history[0][-1])
        if epoch < epochs:
            adam.zero_grad()
            losses[0].backward()
            adam.step()
            with torch.no_grad():
                free.copy_(torch.tensor(_legal(tree, free.numpy() * scale, moving) / scale))
    return TrainedTree(with_numbers(tree, best.tolist()), tuple(history[0]), tuple(history[1]) if check else ())


def numbers_of(tree: Tree) -> list[float]:
    """All numbers of a tree's terms, system by system in its order: those of the inputs, then of the outputs."""
    return [as_number(p) for _, _, term in _terms(tree) for p in term.parameters]


def with_numbers(tree: Tree, numbers: Sequence[Any]) -> Tree:
    """The tree with other numbers, in the order of :func:`numbers_of`: floats, or tensors of which each is one."""
    rest = iter(numbers)

    def term(old: Any) -> Any:
        own = [next(rest) for _ in old.parameters]
        if isinstance(old, Linear):
            return Linear(own[:-1], own[-1])
        return type(old)(*own)

    def made(fis: Sugeno) -> Sugeno:
        ends = [
            [replace(v, terms={name: term(old) for name, old in v.terms.items()}) for v in variables]
            for variables in (fis.inputs, fis.outputs)
        ]
        return replace(fis, inputs=ends[0], outputs=ends[1])

    return tree.with_systems({name: made(tree.systems[name]) for name in tree.order})


def _terms(tree: Tree) -> Iterator[tuple[Sugeno, Variable, Any]]:
    """The terms of all systems, in the order of :func:`numbers_of`, each with its system and its variable."""
    for fis in map(tree.systems.__getitem__, tree.order):
        for variable in (*fis.inputs, *fis.outputs):
            yield from ((fis, variable, term) for term in variable.terms.values())


def _scales(tree: Tree) -> Iterator[float]:
    """By what a step of each number is measured."""
    for fis, variable, term in _terms(tree):
        span = variable.span or 1.0
        if isinstance(term, MembershipFunction):
            yield from ({"slope": 1 / span, "shape": 1.0}.get(role, span) for role in term.roles)
        else:
            yield from [span / (v.span or 1.0) for v in fis.inputs if isinstance(term, Linear)]
            yield span


def _legal(tree: Tree, numbers: np.ndarray, start: np.ndarray) -> np.ndarray:
    """The numbers, with vertices in order, and widths of the sign with which they started and not too small."""
    numbers, place = numbers.copy(), 0
    for _, variable, term in _terms(tree):
        values, first = (row[place : place + len(term.parameters)] for row in (numbers, start))
        place += len(term.parameters)
        if isinstance(term, MembershipFunction):
            for group in map(list, type(term).ascending()):
                values[group] = np.sort(values[group])
            for k in [k for k, role in enumerate(term.roles) if role == "width"]:
                least = _LEAST_WIDTH * (variable.span or 1.0)
                values[k] = np.sign(first[k]) * max(np.sign(first[k]) * values[k], least)
    return numbers


def _samples(tree: Tree, x: Any, y: Any) -> tuple[np.ndarray, np.ndarray]:
    """Points (samples, inputs) and what is wanted (samples, outputs). Raises TreeError, ClusteringError."""
    points, wanted = finite_table(tree.point(x), "x"), output_table(y)
    if wanted.shape != (len(points), len(tree.outputs)):
        raise TreeError(
            f"{tree.name}: {len(points)} points and {len(tree.outputs)} outputs need y of shape "
            f"({len(points)}, {len(tree.outputs)}), got {wanted.shape}"
        )
    return points, wanted
