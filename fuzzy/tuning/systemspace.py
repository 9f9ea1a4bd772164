"""What may move of a Sugeno system, as parameters of a search; and the system that values of these make.

Memberships stay ordered and covering, for they do not move one by one: the places where terms begin, peak and end part
the universe of discourse into gaps, and a search stretches or shrinks each gap. Where two terms met or overlapped they
still do. Widths and slopes scale with the universe about them, and within WIDEN besides.

A search moves what its data weigh. A rule that hardly acts in them, or only beside a stronger one, can be given any
number; :meth:`SystemSpace.unreached` tells what parameters are of such rules, or of gaps that the data do not cross.

Consequents keep their sign, or where they are 0 stay near it, unless :attr:`SystemSpace.reach` says how far they go. A
system that answers to the left as to the right (:mod:`fuzzy.tuning.mirror`) keeps that symmetry, unless it is told not
to.
"""

import warnings
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Literal, get_args

import numpy as np

from fuzzy.inference import infer
from fuzzy.membershipfunction import MembershipFunction
from fuzzy.naming import check_known
from fuzzy.rule import Rule
from fuzzy.system import Constant, Linear, Sugeno, Variable
from fuzzy.tuning.mirror import Mirror, coefficients, mirror_of
from fuzzy.tuning.parameter import SearchParameter, TuningError

Movable = Literal["memberships", "consequents", "weights", "choices", "rules"]
MOVABLE: tuple[str, ...] = get_args(Movable)
MOVED: tuple[Movable, ...] = ("memberships", "consequents")  # by default
STRETCH = 4.0  # by which a gap may grow or shrink against the others
WIDEN = 1.5  # by which a width or a slope may change besides
_SMALLEST = 0.1  # of the greatest number alike: how far a consequent may move at least
ACTING = 0.5  # of the firing strengths of the rules for an output: more than all others together
PRESENT = 0.002  # of the data: what is there at all
_NEAR = 1e-9  # of the universe: places that are the same
_KEPT, LEFT_OUT = "kept", "left out"


@dataclass(frozen=True, eq=False)
class SystemSpace:
    """A system and what of it may move: numbers and choices in the order of :attr:`parameters`.

    Raises TuningError for an unknown part.
    """

    fis: Sugeno
    move: Collection[str] = MOVED  # of MOVABLE
    symmetric: bool = True  # whether the symmetry that it has, if any, is kept
    prefix: str = ""  # of the parameters' names
    reach: np.ndarray | None = None  # (outputs, inputs + 1): how far slopes and constants may move at least
    within: Collection[str] = ()  # outputs whose constants stay within their universe
    _parts: "tuple[_Part, ...]" = field(init=False, repr=False)

    def __post_init__(self) -> None:
        for name in self.move:
            check_known(name, MOVABLE, "part of a system that can move", TuningError)
        object.__setattr__(self, "_parts", tuple(_parts(self)))

    @cached_property
    def mirror(self) -> Mirror | None:
        """The symmetry that is kept, if any."""
        return mirror_of(self.fis) if self.symmetric else None

    @cached_property
    def parameters(self) -> tuple[SearchParameter, ...]:
        """What may move, each with its name, start and bounds."""
        return tuple(
            replace(parameter, name=self.prefix + parameter.name)
            for part in self._parts
            for parameter in part.parameters
        )

    def unreached(self, x: np.ndarray) -> tuple[str, ...]:
        """The names of the parameters of which data say too little, by the inputs ``x`` (points, inputs).

        Those are the numbers of rules of which none outweighs all others (ACTING) on a share PRESENT of the points,
        widths of terms that are not at ACTING there, and gaps with no such share beyond both ends.
        """
        with warnings.catch_warnings(action="ignore"):  # of points outside the universe
            reach = _Reach.of(self.fis, np.asarray(x, dtype=float))
        return tuple(
            self.prefix + parameter.name
            for part in self._parts
            for parameter, is_reached in zip(part.parameters, part.reached(reach), strict=True)
            if not is_reached
        )

    def made(self, values: Sequence[float] | np.ndarray) -> Sugeno:
        """The system that ``values`` (parameters,) make; those of the start make one that is equal to the start.

        Raises TuningError where these are not as many as there are parameters.
        """
        if len(values) != len(self.parameters):
            raise TuningError(f"{self.fis.name}: {len(self.parameters)} values are needed; got {len(values)}")
        draft = _Draft.of(self.fis)
        first = 0
        for part in self._parts:
            count = len(part.parameters)
            part.put(draft, [float(v) for v in values[first : first + count]])
            first += count
        return draft.system()


def search_space(
    fis: Any,
    move: Collection[str] | None = None,
    symmetric: bool = True,
    data: tuple[np.ndarray, np.ndarray] | None = None,
    prefix: str = "",
) -> Any:
    """What may move of a system of any kind: a :class:`SystemSpace`, or what its own ``search_space`` says.

    Args:
        fis: The system.
        move: What may move; None: memberships and consequents, of a type-2 system footprints too.
        symmetric: Whether a symmetry is kept; of a tree that of each of its systems.
        data: Inputs (samples, inputs) and outputs (samples, outputs), which say how far consequents may move.
        prefix: Of the parameters' names, of a type-1 system.

    Raises TuningError for an unknown part.
    """
    if not isinstance(fis, Sugeno):
        return fis.search_space(move, symmetric, data)
    reach = None if data is None else reach_of(fis, data[0], np.ptp(data[1], axis=0))
    return SystemSpace(fis, MOVED if move is None else move, symmetric, prefix, reach)


@dataclass(frozen=True)
class _Reach:
    """Where data lie, and which rules they let act."""

    fis: Sugeno
    x: np.ndarray  # (points, inputs)
    memberships: tuple[np.ndarray, ...]  # of each input (points, terms)
    rules: frozenset[int]  # that outweigh all others somewhere

    @classmethod
    def of(cls, fis: Sugeno, x: np.ndarray) -> "_Reach":
        found = infer(fis, x)
        rules = set()
        for variable in fis.outputs:
            own = [n for n, rule in enumerate(fis.rules) if variable.name in dict(rule.then)]
            firing = found.firing[:, own]
            most = firing >= ACTING * np.maximum(firing.sum(axis=1, keepdims=True), 1e-300)
            rules |= {n for n, share in zip(own, most.mean(axis=0), strict=True) if share >= PRESENT}
        return cls(fis, x, found.memberships, frozenset(rules))


@dataclass
class _Draft:
    """A system while it is made."""

    fis: Sugeno
    terms: list[dict[str, MembershipFunction]]  # of each input
    consequents: list[dict[str, Any]]  # of each output
    rules: list[Rule]
    kept: list[bool]

    @classmethod
    def of(cls, fis: Sugeno) -> "_Draft":
        inputs, outputs = ([dict(v.terms) for v in variables] for variables in (fis.inputs, fis.outputs))
        return cls(fis, inputs, outputs, list(fis.rules), [True] * len(fis.rules))

    def system(self) -> Sugeno:
        fis = self.fis
        inputs = [replace(v, terms=terms) for v, terms in zip(fis.inputs, self.terms, strict=True)]
        outputs = [replace(v, terms=terms) for v, terms in zip(fis.outputs, self.consequents, strict=True)]
        rules = [rule for rule, kept in zip(self.rules, self.kept, strict=True) if kept]
        return replace(fis, inputs=inputs, outputs=outputs, rules=rules or self.rules[:1])


@dataclass(frozen=True)
class _Part:
    """Some parameters, and how their values change a draft."""

    parameters: tuple[SearchParameter, ...]

    def put(self, draft: _Draft, values: list[float]) -> None:
        raise NotImplementedError

    def reached(self, reach: _Reach) -> list[bool]:
        """Whether data tell something of each parameter."""
        raise NotImplementedError


def _parts(space: SystemSpace) -> Iterator[_Part]:
    fis, move, mirror = space.fis, space.move, space.mirror
    if "memberships" in move:
        for k in range(len(fis.inputs)):
            yield _Memberships.of(fis, k, mirror)
    if "consequents" in move:
        for k in range(len(fis.outputs)):
            yield from _consequents(space, k)
    orbits = with_images(range(len(fis.rules)), mirror.rules if mirror else None)
    if "weights" in move:
        for orbit in orbits:
            weight = fis.rules[orbit[0]].weight
            yield _Weight((SearchParameter(name=f"rule {_numbers(orbit)}.weight", start=weight),), orbit)
    if "choices" in move:
        for k in range(len(fis.outputs)):
            yield from _choices(fis, k, orbits, mirror)
    if "rules" in move and len(orbits) > 1:
        for orbit in orbits:
            parameter = SearchParameter(name=f"rule {_numbers(orbit)}", start=0.0, choices=(_KEPT, LEFT_OUT))
            yield _OnOff((parameter,), orbit)


def _numbers(orbit: Sequence[int]) -> str:
    return "+".join(str(rule + 1) for rule in orbit)


def with_images(places: Sequence[int], image: Sequence[int] | None) -> list[tuple[int, ...]]:
    """The places, each with its mirror image if it is another one."""
    if image is None:
        return [(place,) for place in places]
    return [(place,) if image[place] == place else (place, image[place]) for place in places if place <= image[place]]


# Memberships ------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Memberships(_Part):
    """The gaps of one input's universe, and the widths of its terms."""

    place: int  # of the input
    edges: np.ndarray  # the ends of the gaps, from the universe's low end to its high end
    groups: tuple[tuple[int, ...], ...]  # gaps that stretch together; the first is the one that the others are to
    widths: tuple[tuple[str, ...], ...]  # terms whose widths change together
    flips: bool  # whether the input changes its sign in the mirror

    @classmethod
    def of(cls, fis: Sugeno, place: int, mirror: Mirror | None) -> "_Memberships":
        variable = fis.inputs[place]
        flips = mirror is not None and mirror.inputs[place] < 0
        edges = _edges(variable)
        count = len(edges) - 1
        groups = with_images(range(count), [count - 1 - k for k in range(count)] if flips else None)
        greatest = max(range(len(groups)), key=lambda k: edges[groups[k][0] + 1] - edges[groups[k][0]])
        groups = [groups[greatest], *(g for k, g in enumerate(groups) if k != greatest)]
        names = list(variable.terms)
        images = mirror.terms[place] if flips and mirror is not None else None
        wide = [k for k, term in enumerate(variable.terms.values()) if {"width", "slope"} & set(term.roles)]
        orbits = [orbit for orbit in with_images(range(len(names)), images) if orbit[0] in wide]
        widths = tuple(tuple(names[k] for k in orbit) for orbit in orbits)
        parameters = [
            SearchParameter(
                name=f"{variable.name}.gap {edges[g[0]]:.4g} to {edges[g[0] + 1]:.4g}",
                start=1.0,
                lower=1 / STRETCH,
                upper=STRETCH,
                scale="log",
            )
            for g in groups[1:]
        ]
        parameters += [
            SearchParameter(
                name=f"{variable.name}.{'+'.join(of)}.width", start=1.0, lower=1 / WIDEN, upper=WIDEN, scale="log"
            )
            for of in widths
        ]
        return cls(tuple(parameters), place, edges, tuple(groups), widths, flips)

    def put(self, draft: _Draft, values: list[float]) -> None:
        """Stretch the gaps, and what lies in them."""
        if not self.parameters or all(value == 1.0 for value in values):
            return
        sizes = np.diff(self.edges)
        for group, factor in zip(self.groups[1:], values, strict=False):
            sizes[list(group)] *= factor
        sizes *= (self.edges[-1] - self.edges[0]) / sizes.sum()
        edges = self.edges[0] + np.concatenate([[0.0], np.cumsum(sizes)])
        edges[-1] = self.edges[-1]
        if self.flips:
            edges = (edges - edges[::-1]) / 2  # symmetric to the last bit
        wider = dict.fromkeys(draft.terms[self.place], 1.0)
        for names, factor in zip(self.widths, values[len(self.groups) - 1 :], strict=True):
            wider |= dict.fromkeys(names, factor)
        terms = draft.terms[self.place]
        for name, term in terms.items():
            terms[name] = _moved(term, self.edges, edges, wider[name])

    def reached(self, reach: _Reach) -> list[bool]:
        x, terms = reach.x[:, self.place], list(reach.fis.inputs[self.place].terms)
        # At the universe's own ends a point within the gap is enough
        beyond = np.concatenate([self.edges[1:2], self.edges[1:-1], self.edges[-2:-1]])
        below, above = (np.mean(x[:, None] <= beyond, axis=0), np.mean(x[:, None] >= beyond, axis=0))
        crossed = (below[:-1] >= PRESENT) & (above[1:] >= PRESENT)
        full = dict(zip(terms, (reach.memberships[self.place] >= ACTING).mean(axis=0) >= PRESENT, strict=True))
        gaps = [any(crossed[k] for k in group) for group in self.groups[1:]]
        return gaps + [any(full[name] for name in names) for names in self.widths]


def _edges(variable: Variable) -> np.ndarray:
    """The ends of the universe of discourse, and within it the places at which terms begin, peak and end."""
    low, high = variable.universe
    span = high - low
    edges = [low]
    for place in sorted(_places(variable)):
        if place - edges[-1] > _NEAR * span and high - place > _NEAR * span:
            edges.append(place)
    return np.array([*edges, high])


def _places(variable: Variable) -> Iterator[float]:
    for term in variable.terms.values():
        for role, number in zip(term.roles, term.numbers, strict=True):
            if role == "location":
                yield number


def _moved(term: MembershipFunction, edges: np.ndarray, moved: np.ndarray, wider: float) -> MembershipFunction:
    """A term whose universe is stretched so that ``edges`` come to lie at ``moved``; beyond them nothing moves."""

    def at(x: float) -> float:
        if not edges[0] < x < edges[-1]:
            return x
        near = np.flatnonzero(np.abs(edges - x) <= _NEAR * (edges[-1] - edges[0]))
        return float(moved[near[0]]) if len(near) else float(np.interp(x, edges, moved))

    numbers = term.numbers
    centers = [n for n, role in zip(numbers, term.roles, strict=True) if role == "location"]
    changed = []
    for place, (number, role) in enumerate(zip(numbers, term.roles, strict=True)):
        if role == "location":
            changed.append(at(number))
        elif role in ("width", "slope"):
            own = next((n for n, r in zip(numbers[place:], term.roles[place:], strict=True) if r == "location"), None)
            center = own if own is not None else centers[-1]
            if number == 0:  # a slope of 0 is that of a level line, wherever it is stretched
                changed.append(number)
                continue
            span = float(edges[-1] - edges[0])
            half = min(abs(number) if role == "width" else 1 / abs(number), span)
            stretch = (at(center + half) - at(center - half)) / (2 * half) * wider
            changed.append(number * stretch if role == "width" else number / stretch)
        else:
            changed.append(number)
    return type(term)(*changed)


# Consequents ------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Consequent(_Part):
    """The numbers of one output's term, and of its mirror image."""

    output: int
    place: int  # among the numbers of the term, the slopes first
    names: tuple[str, ...]  # the term, and its mirror image
    signs: tuple[int, ...]

    def put(self, draft: _Draft, values: list[float]) -> None:
        terms = draft.consequents[self.output]
        for name, sign in zip(self.names, self.signs, strict=True):
            term = terms[name]
            numbers = [float(p) for p in term.parameters]
            numbers[self.place] = sign * values[0]
            if isinstance(term, Constant):
                terms[name] = Constant(numbers[0])
            else:
                terms[name] = replace(term, slopes=tuple(numbers[:-1]), constant=numbers[-1])

    def reached(self, reach: _Reach) -> list[bool]:
        output = reach.fis.outputs[self.output].name
        return [any(dict(reach.fis.rules[rule].then).get(output) in self.names for rule in reach.rules)]


def _consequents(space: SystemSpace, output: int) -> Iterator[_Part]:
    fis, mirror = space.fis, space.mirror
    variable = fis.outputs[output]
    inputs = len(fis.inputs)
    table = {name: coefficients(term, inputs) for name, term in variable.terms.items()}
    if not table:
        return
    greatest = np.abs(np.array(list(table.values()))).max(axis=0)
    least = _SMALLEST * greatest if space.reach is None else space.reach[output]
    images = _term_images(fis, output, mirror)
    signs = np.ones(inputs + 1, dtype=int)
    if mirror is not None:
        signs = np.array([*(mirror.outputs[output] * s for s in mirror.inputs), mirror.outputs[output]])
    names = list(table)
    for name in names:
        image = images.get(name, name)
        if names.index(image) < names.index(name):
            continue
        numbers = len(variable.terms[name].parameters)
        for place in range(numbers):
            column = inputs + 1 - numbers + place
            if image == name and signs[column] < 0 and name in images:
                continue  # its own mirror image: it stays 0
            reach = max(abs(table[name][column]), float(least[column]))
            if reach == 0:
                continue  # a slope that no rule has
            start = float(table[name][column])
            what = "" if column == inputs else f".{fis.inputs[column].name}"
            both = (name,) if image == name else (name, image)
            low, high = start - reach, start + reach
            if variable.name in space.within and numbers == 1 and variable.universe[0] <= start <= variable.universe[1]:
                low, high = max(low, variable.universe[0]), min(high, variable.universe[1])
            parameter = SearchParameter(
                name=f"{variable.name}.{'+'.join(both)}{what}", start=start, lower=low, upper=high
            )
            yield _Consequent((parameter,), output, place, both, (1, int(signs[column]))[: len(both)])


def _term_images(fis: Sugeno, output: int, mirror: Mirror | None) -> dict[str, str]:
    """The mirror image of each term that rules take; a term of which rules do not agree is left out."""
    if mirror is None:
        return {}
    name = fis.outputs[output].name
    taken = [dict(rule.then).get(name) for rule in fis.rules]
    images: dict[str, set[str]] = {}
    for rule, image in enumerate(mirror.rules):
        one, other = taken[rule], taken[image]
        if one is not None and other is not None:
            images.setdefault(one, set()).add(other)
    single = {one: next(iter(others)) for one, others in images.items() if len(others) == 1}
    return {one: other for one, other in single.items() if single.get(other) == one}


# Rules ------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _OfRules(_Part):
    """A parameter of a rule, and of its mirror image."""

    orbit: tuple[int, ...]

    def reached(self, reach: _Reach) -> list[bool]:
        return [not reach.rules.isdisjoint(self.orbit)]


@dataclass(frozen=True)
class _Weight(_OfRules):
    def put(self, draft: _Draft, values: list[float]) -> None:
        for rule in self.orbit:
            draft.rules[rule] = replace(draft.rules[rule], weight=values[0])


@dataclass(frozen=True)
class _OnOff(_OfRules):
    def put(self, draft: _Draft, values: list[float]) -> None:
        for rule in self.orbit:
            draft.kept[rule] = values[0] == 0


@dataclass(frozen=True)
class _Choice(_OfRules):
    output: str
    taken: tuple[tuple[str, ...], ...]  # a choice: the term of each rule of the orbit

    def put(self, draft: _Draft, values: list[float]) -> None:
        for rule, term in zip(self.orbit, self.taken[int(values[0])], strict=True):
            then = dict(draft.rules[rule].then) | {self.output: term}
            draft.rules[rule] = replace(draft.rules[rule], then=tuple(then.items()))


def _choices(fis: Sugeno, output: int, orbits: list[tuple[int, ...]], mirror: Mirror | None) -> Iterator[_Part]:
    variable = fis.outputs[output]
    images = _term_images(fis, output, mirror)
    for orbit in orbits:
        start = dict(fis.rules[orbit[0]].then).get(variable.name)
        if start is None:
            continue
        terms = list(variable.terms)
        if mirror is not None:
            terms = [t for t in terms if t in images and (len(orbit) > 1 or images[t] == t)]
        if len(terms) < 2 or start not in terms:
            continue
        taken = tuple((t, images[t])[: len(orbit)] if mirror is not None else (t,) for t in terms)
        parameter = SearchParameter(
            name=f"rule {_numbers(orbit)}.{variable.name}", start=float(terms.index(start)), choices=tuple(terms)
        )
        yield _Choice((parameter,), orbit, variable.name, taken)


def reach_of(fis: Sugeno, x: np.ndarray, spread: np.ndarray) -> np.ndarray:
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
