"""What may move of a tree of systems and of an interval type-2 one: that of their type-1 systems, and the footprint."""

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass, replace
from hashlib import sha256
from itertools import chain
from typing import Any, TypeVar

import numpy as np

from fuzzy.compiled.sugeno import compile_sugeno
from fuzzy.inference import forgiving
from fuzzy.membershipfunction import as_number
from fuzzy.plugins.trees.compiled import compile_tree
from fuzzy.plugins.trees.tree import Tree
from fuzzy.plugins.type2.compiled import compile_type2
from fuzzy.plugins.type2.files import format_either
from fuzzy.plugins.type2.system import Lower, Type2Sugeno
from fuzzy.system import FuzzySystemError, Linear, Sugeno
from fuzzy.tuning.mirror import Mirror
from fuzzy.tuning.parameter import SearchParameter
from fuzzy.tuning.systemspace import MOVED, SystemSpace, with_images

FOOTPRINTS = "footprints"  # what may move besides of a type-2 system
_LEAST_SCALE, _MOST_LAG = 0.05, 0.95  # of a lower membership function, unless it starts beyond
System = TypeVar("System", bound=Sugeno | Tree | Type2Sugeno)


@dataclass(frozen=True, eq=False)
class TreeSpace:
    """A tree and what may move of each of its systems, in the tree's order; universes and connections stay."""

    fis: Tree
    move: Collection[str]
    spaces: tuple[SystemSpace, ...]

    @property
    def parameters(self) -> tuple[SearchParameter, ...]:
        """What may move, called "system/parameter"."""
        return tuple(chain.from_iterable(space.parameters for space in self.spaces))

    def made(self, values: np.ndarray) -> Tree:
        """The tree that ``values`` (parameters,) make."""
        ends = np.cumsum([len(space.parameters) for space in self.spaces])
        rows = np.split(np.asarray(values), ends[:-1])
        made = [space.made(row) for space, row in zip(self.spaces, rows, strict=True)]
        return self.fis.with_systems(dict(zip(self.fis.order, made, strict=True)))


@dataclass(frozen=True, eq=False)
class Type2Space:
    """A type-2 system and what may move of its upper one, and then scales and lags of its lower functions."""

    fis: Type2Sugeno
    move: Collection[str]
    upper: SystemSpace
    footprints: "tuple[_Footprint, ...]"

    @property
    def parameters(self) -> tuple[SearchParameter, ...]:
        """What may move."""
        return (*self.upper.parameters, *chain.from_iterable(each.parameters for each in self.footprints))

    def made(self, values: np.ndarray) -> Type2Sugeno:
        """The system that ``values`` (parameters,) make. Raises FuzzySystemError as the system does."""
        first = len(self.upper.parameters)
        lower = {name: dict(terms) for name, terms in self.fis.lower.items()}
        rest = iter(values[first:])
        for each in self.footprints:
            scale, *lags = (float(next(rest)) for _ in each.parameters)
            pair = (lags[0], lags[-1])
            for term, turned in zip(each.terms, (pair, pair[::-1]), strict=False):
                lower[each.input][term] = Lower(scale, turned)
        return replace(self.fis, upper=self.upper.made(values[:first]), lower=lower)


@dataclass(frozen=True)
class _Footprint:
    """The scale of a term, and one lag or a left and a right one; of its mirror image the same, turned round."""

    parameters: tuple[SearchParameter, ...]
    input: str
    terms: tuple[str, ...]


def space_of(
    fis: Any, move: Collection[str] | None, symmetric: bool, x: np.ndarray, y: np.ndarray
) -> SystemSpace | TreeSpace | Type2Space:
    """What may move of a system of any kind, about as far as data reach.

    Args:
        fis: The system.
        move: What may move; None: memberships and consequents, of a type-2 system footprints too.
        symmetric: Whether a symmetry is kept; of a tree that of each of its systems.
        x: The inputs (samples, inputs).
        y: The outputs (samples, outputs).

    Raises TuningError for an unknown part.
    """
    spread = np.ptp(y, axis=0)
    if isinstance(fis, Tree):
        spaces, values = [], fis.values(x)
        known = dict(zip(fis.answers or (), spread, strict=True))
        for name, wires in zip(fis.order, fis.wires, strict=True):
            part = fis.systems[name]
            spans = [known.get(f"{name}/{v.name}", v.universe[1] - v.universe[0]) for v in part.outputs]
            reach = _reach(part, np.stack([values[k] for k in wires], axis=-1), np.array(spans))
            taken = [v.name for v in part.outputs if f"{name}/{v.name}" not in known]  # by other systems' universes
            spaces.append(SystemSpace(part, move or MOVED, symmetric, f"{name}/", reach, taken))
        return TreeSpace(fis, move or MOVED, tuple(spaces))
    if isinstance(fis, Type2Sugeno):
        move = (*MOVED, FOOTPRINTS) if move is None else tuple(move)
        rest = [part for part in move if part != FOOTPRINTS]
        upper = SystemSpace(fis.upper, rest, symmetric, reach=_reach(fis.upper, x, spread))
        if upper.mirror is not None and not _is_mirrored(fis, upper.mirror):
            upper = replace(upper, symmetric=False)
        return Type2Space(fis, move, upper, tuple(_footprints(fis, upper.mirror)) if FOOTPRINTS in move else ())
    return SystemSpace(fis, move or MOVED, symmetric, reach=_reach(fis, x, spread))


def _footprints(fis: Type2Sugeno, mirror: Mirror | None) -> Iterator[_Footprint]:
    for place, variable in enumerate(fis.inputs):
        names = list(variable.terms)
        flips = mirror is not None and mirror.inputs[place] < 0
        for orbit in with_images(range(len(names)), mirror.terms[place] if flips and mirror is not None else None):
            terms = tuple(names[k] for k in orbit)
            own, label = fis.lower[variable.name][terms[0]], f"{variable.name}.{'+'.join(terms)}"
            scale, left, right = map(as_number, (own.scale, *own.lag))
            lags = {"lag": left} if left == right else {"left lag": left, "right lag": right}
            parameters = [SearchParameter(name=f"{label}.scale", start=scale, lower=min(_LEAST_SCALE, scale / 2))]
            parameters += [
                SearchParameter(name=f"{label}.{what}", start=lag, upper=max(_MOST_LAG, lag))
                for what, lag in lags.items()
            ]
            yield _Footprint(tuple(parameters), variable.name, terms)


def _is_mirrored(fis: Type2Sugeno, mirror: Mirror) -> bool:
    """Whether the lower functions have the symmetry of the upper system."""
    return all(
        own[image] == Lower(own[k].scale, own[k].lag[:: mirror.inputs[place]])
        for place, terms in enumerate(mirror.terms)
        for own in [list(fis.lower[fis.inputs[place].name].values())]
        for k, image in enumerate(terms)
    )


def _reach(fis: Sugeno, x: np.ndarray, spread: np.ndarray) -> np.ndarray:
    """How far slopes and constants (outputs, inputs + 1) may move at least, by the ranges of the data."""
    across = np.ptp(x, axis=0)
    across[across == 0] = np.inf
    # A plane through the data has a constant that grows with their distance from 0.
    distance = 1 + float((np.abs(x).max(axis=0) / across).sum())
    rows = []
    for variable, wide in zip(fis.outputs, spread.tolist(), strict=True):
        linear = any(isinstance(term, Linear) for term in variable.terms.values())
        rows.append([*(wide / across), wide * (distance if linear else 1.0)])
    return np.array(rows)


def systems_of(fis: Any) -> list[Sugeno]:
    """The type-1 systems of a system of any kind."""
    if isinstance(fis, Tree):
        return [fis.systems[name] for name in fis.order]
    return [fis.upper if isinstance(fis, Type2Sugeno) else fis]


def changed(fis: System, change: Callable[[Sugeno], Sugeno]) -> System:
    """The system, with each of its type-1 systems changed."""
    made: Any
    if isinstance(fis, Tree):
        made = fis.with_systems({name: change(each) for name, each in fis.systems.items()})
    elif isinstance(fis, Type2Sugeno):
        made = replace(fis, upper=change(fis.upper))
    else:
        made = change(fis)
    return made


def digest(fis: Any) -> str:
    """What tells a system from others."""
    text = "".join(map(format_either, [fis] if isinstance(fis, Type2Sugeno) else systems_of(fis)))
    wired = repr((fis.order, fis.connections, fis.answers)) if isinstance(fis, Tree) else ""
    return sha256((text + wired).encode()).hexdigest()


def answers_of(fis: Any, x: np.ndarray) -> np.ndarray:
    """The outputs (samples, outputs) at ``x`` (samples, inputs), the middle of a range where no rule fires.

    In compiled code, where it knows all functions.
    """
    fis = changed(fis, lambda each: forgiving(each, "midrange"))
    compiled: Any = {Tree: compile_tree, Type2Sugeno: compile_type2}.get(type(fis), compile_sugeno)
    try:
        return np.asarray(compiled(fis)(x))
    except FuzzySystemError:  # a membership function of somebody's own
        return np.asarray(fis(x))
