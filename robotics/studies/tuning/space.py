"""What may move of a law: its gains, and its rule bases (:mod:`fuzzy.tuning.systemspace`).

One rule makes the bounds for all laws, so that none of them has an easier search: a gain moves from a tenth to ten
times its start, by its logarithm, as far as the law accepts it [Bergstra and Bengio 2012 for the scale]. A gain that is
0 moves only where the user says from where to where.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import MISSING, dataclass, field, replace
from functools import cached_property
from math import inf
from typing import Any, Literal

import numpy as np

from fuzzy.naming import check_known
from fuzzy.quantity import SMALLEST, check_quantities, described, quantity
from fuzzy.tuning.parameter import Scale, SearchParameter, TuningError
from fuzzy.tuning.systemspace import MOVABLE, MOVED, search_space
from robotics.laws.catalogue import gain_fields, gains_of, with_gains
from robotics.laws.law import Law

TENFOLD = 10.0  # by which a gain may change, up and down
PARTS: tuple[str, ...] = ("gains", *MOVABLE)
PARTS_MOVED: tuple[str, ...] = ("gains", *MOVED)  # by default
Unreached = Literal["hold", "move"]
FORMATION = "formation"  # the task of several systems together


class NothingMovesError(TuningError):
    """A law without anything that may move."""


@dataclass(frozen=True, kw_only=True)
class Bound:
    """From where to where a parameter may move, instead of what the rule says.

    Raises:
        TuningError: An end that is no number, a low end above the high one, and a logarithm of what is not > 0.
    """

    low: float = quantity(MISSING, "1", doc="The least value.", example=0.2)
    high: float = quantity(MISSING, "1", doc="The greatest value, above low.", example=1.0)
    scale: Scale = described("Whether it moves evenly, or by its logarithm.", "linear")

    def __post_init__(self) -> None:
        check_quantities(self, TuningError)
        if not self.low < self.high:
            raise TuningError(f"low must be less than high; got {self.low:g} and {self.high:g}").about("low")
        if self.scale == "log" and not self.low > 0:
            raise TuningError(f'on the scale "log" low must be > 0; got {self.low:g}').about("low")


@dataclass(frozen=True, eq=False)
class LawSpace:
    """A law and what of it may move; its :attr:`parameters` are searched, and :meth:`made` makes the law of values.

    Attributes:
        law: The law as it is.
        move: What may move: of "gains", "memberships", "consequents", "weights", "choices" and "rules".
        gains: The gains that may move; None: all that the rule makes bounds for.
        tasks: The tasks of the rule bases that may move; None: all.
        bounds: By parameter.
        fixed: Parameters that do not move.
        symmetric: Whether a rule base that answers to both sides alike keeps doing so.
        unreached: Whether a search holds ("hold") or moves ("move") what the runs that it tunes on say nothing of.
        held: What it holds for that reason.

    Raises:
        TuningError: A part, a gain or a rule base that the law does not have.
        NothingMovesError: Nothing may move.
    """

    law: Law[Any]
    move: Collection[str] = PARTS_MOVED
    gains: Collection[str] | None = None
    tasks: Collection[str] | None = None
    bounds: Mapping[str, Bound] = field(default_factory=dict)
    fixed: Collection[str] = ()
    symmetric: bool = True
    unreached: Unreached = "hold"
    held: Collection[str] = ()

    def __post_init__(self) -> None:
        for part in self.move:
            check_known(part, PARTS, "part that can move", TuningError)
        known = set(self._movable_gains)
        for gain in [*(self.gains or ()), *(b for b in self.bounds if b in known)]:
            check_known(gain, sorted(known), f"gain of {type(self.law).__name__} that can move", TuningError)
        systems = [name for name in self.law.fuzzy_systems if task_of(self.law, name)]
        for task in self.tasks or ():
            check_known(task, systems, f"rule base of {type(self.law).__name__} that can move", TuningError)
        names = [p.name for p in self._unfixed]
        for name in [*self.bounds, *self.fixed]:
            check_known(name, names, "parameter that moves", TuningError)
        if not self.parameters:
            raise NothingMovesError(f"{type(self.law).__name__} has nothing that moves, of {', '.join(self.move)}")

    @cached_property
    def parameters(self) -> tuple[SearchParameter, ...]:
        """What may move, each with its name, start and bounds: the gains first."""
        return tuple(self._bounded(p) for p in self._unfixed if p.name not in self.fixed and p.name not in self.held)

    def holding_unreached(self, asked: Mapping[str, np.ndarray]) -> "LawSpace":
        """The same, with what the runs of a search say nothing of held: see :meth:`SystemSpace.unreached`.

        Args:
            asked: The inputs (points, inputs) that the rule bases had in these runs, by their names.
        """
        held = [name for task, space in self._systems.items() for name in space.unreached(asked[task])]
        return replace(self, unreached="move", held=[name for name in held if name not in self.bounds])

    @cached_property
    def systems(self) -> tuple[str, ...]:
        """The names of the rule bases that may move."""
        return tuple(self._systems)

    @cached_property
    def _unfixed(self) -> tuple[SearchParameter, ...]:
        return (*self._gains, *(p for space in self._systems.values() for p in space.parameters))

    def _bounded(self, parameter: SearchParameter) -> SearchParameter:
        bound = self.bounds.get(parameter.name)
        if bound is None:
            return parameter
        if parameter.choices:
            raise TuningError(f"{parameter.name} is a choice of {', '.join(parameter.choices)}; it has no bounds")
        start = min(max(parameter.start, bound.low), bound.high)
        return replace(parameter, start=start, lower=bound.low, upper=bound.high, scale=bound.scale)

    @cached_property
    def _movable_gains(self) -> dict[str, Any]:
        """The fields of the gains that are numbers with a unit and have an effect, by name."""
        known = gain_fields(type(self.law))
        return {name: known[name] for name in gains_of(self.law) if "unit" in known[name].metadata}

    @cached_property
    def _gains(self) -> tuple[SearchParameter, ...]:
        values, found = gains_of(self.law), []
        for name, about in self._movable_gains.items() if "gains" in self.move else ():
            if self.gains is not None and name not in self.gains:
                continue
            parameter = _by_rule(name, values[name], about.metadata)
            if parameter is None and name in self.bounds:
                bound = self.bounds[name]
                start = min(max(values[name], bound.low), bound.high)
                parameter = SearchParameter(
                    name=name, start=start, lower=bound.low, upper=bound.high, unit=about.metadata["unit"]
                )
            if parameter is not None:
                found.append(parameter)
        return tuple(found)

    @cached_property
    def _systems(self) -> dict[str, Any]:
        parts = [part for part in self.move if part in MOVABLE]
        if not parts:
            return {}
        systems = {name: fis for name, fis in self.law.fuzzy_systems.items() if task_of(self.law, name)}
        prefix = len(systems) > 1
        # What moves by default is of a type-2 system its footprint, too.
        wished = None if set(parts) == set(MOVED) else parts
        return {
            task: search_space(
                self.law.composites.get(task, fis), wished, self.symmetric, prefix=f"{task}." if prefix else ""
            )
            for task, fis in systems.items()
            if self.tasks is None or task in self.tasks
        }

    def made(self, values: Sequence[float] | np.ndarray) -> Law[Any]:
        """The law that ``values`` (parameters,), in the order of :attr:`parameters`, make.

        Raises:
            InputError: The law does not accept them.
        """
        gains = self.gains_at(values)
        law = with_gains(self.law, gains) if gains else self.law
        for name, fis in self.systems_of(values).items():
            law = law.with_fuzzy_system(task_of(law, name), fis)
        return law

    def systems_of(self, values: Sequence[float] | np.ndarray) -> dict[str, Any]:
        """The rule bases that ``values`` (parameters,) make, by what the law calls them (``Law.fuzzy_systems``)."""
        told = dict(zip([p.name for p in self.parameters], map(float, values), strict=True))
        return {
            task: space.made([told.get(p.name, p.start) for p in space.parameters])
            for task, space in self._systems.items()
        }

    def gains_at(self, values: Sequence[float] | np.ndarray) -> dict[str, float]:
        """The gains that ``values`` (parameters,) say, by name."""
        own = {p.name for p in self._gains}
        return {p.name: float(v) for p, v in zip(self.parameters, values, strict=True) if p.name in own}


def task_of(law: Law[Any], system: str) -> str:
    """The task in which one of a law's ``fuzzy_systems`` can be replaced; "" if it cannot be.

    The networks of a formation are one task, and each is known by its outputs.
    """
    return system if system in law.tasks else FORMATION if FORMATION in law.tasks else ""


def _by_rule(name: str, value: Any, metadata: Mapping[str, Any]) -> SearchParameter | None:
    """A gain's bounds by the one rule; None where it makes none."""
    if not isinstance(value, float) or value <= 0:
        return None
    least = max(metadata["least"], metadata["above"], SMALLEST)
    low, high = max(value / TENFOLD, least), min(value * TENFOLD, metadata["most"])
    if metadata["above"] > -inf and low <= metadata["above"]:
        low = metadata["above"] + min(value - metadata["above"], 1.0) / TENFOLD
    if not low < high:
        return None
    return SearchParameter(name=name, start=value, lower=low, upper=high, scale="log", unit=metadata["unit"])
