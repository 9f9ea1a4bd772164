"""Claims as data: what a file says of them, and the one judge that makes parts with numbers of it.

A claim has parts, and a part one relation: a metric of a law is ``below`` or ``above`` a number, it is ``less`` or
``more`` than that of its rivals, or it is worse by less than ``no_worse_by``. How numbers become verdicts is in
:mod:`robotics.measures.evidence`.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any, NamedTuple, get_args, get_type_hints

import numpy as np

from fuzzy.errors import InputError
from fuzzy.quantity import described
from robotics.measures.evidence import Estimate, Form, Limit, Part, Room, compared, exact, mean_of, rate_of
from robotics.show.report.wording import bound_text
from robotics.tables.build import Builder, Keys, Special

ALL_SCENARIOS = "all"  # as the only scenario: every one of the study
HALF = 0.5  # of the runs must keep a bound, where nothing else is said
_NAMELESS = 'a claim needs a name, such as name = "Mine is more precise"'


def run_name(scenario: str, law: str) -> str:
    """The name, without an ending, of the file of a law's runs on a scenario by which claims are judged."""
    return re.sub(r"[^A-Za-z0-9.=-]+", "_", f"{scenario}--{law}")


class ClaimError(InputError):
    """A claim that cannot be judged."""


@dataclass(frozen=True, kw_only=True)
class Condition:
    """A part of a claim before anything is measured: one number, and what it must be. Raises ClaimError.

    Exactly one of below, above, less, more, no_worse_by and no_worse_by_percent is given.
    """

    metric: str = described(
        "What is measured: a metric or a quantity by its name, or file.py:function of your own.",
        "",
        example="rms_cross_track_m",
    )
    on: tuple[str, ...] = described(
        'The scenario on which it is measured, or several, or "all": each is a part.', (ALL_SCENARIOS,)
    )
    of: str = described("The controller whose number it is.", "", example="fuzzy")
    against: tuple[str, ...] = described(
        "The controllers to which it is compared, seed by seed; of several the best in each seed counts.",
        (),
        example=["lyapunov"],
    )
    below: float | None = described("The number must be below this, in the metric's unit.", None)
    above: float | None = described("The number must be above this, in the metric's unit.", None)
    share: float | None = described(
        "With below or above: the share of runs that must keep it, at least; the whole interval must. Default 0.5.",
        None,
        example=0.9,
    )
    origin: str = described(
        "With below or above: where the bound comes from, in a few words. May be left out.", "", example="a data sheet"
    )
    less: bool = described("true: it must be less than that of every controller in against.", False, example=True)
    more: bool = described("true: it must be more than that of every controller in against.", False, example=True)
    no_worse_by: float | None = described(
        "It may be worse than that of every controller in against, but by less than this (> 0, in the metric's unit).",
        None,
    )
    no_worse_by_percent: float | None = described(
        "It may be worse than that of every controller in against, but by less than this share of it (> 0, in %).", None
    )
    margin: float | None = described(
        "With less or more: by how much at least (>= 0, in the metric's unit); the whole interval must keep it.", None
    )
    margin_percent: float | None = described(
        "With less or more: by how much at least (>= 0, in % of the rival's number in each seed).", None
    )
    robot: int | None = described("The robot, from 1, whose number counts; otherwise that of the worst.", None)
    mean: bool = described("true: the mean of the robots counts, and not the worst.", False, example=True)
    says: str = described(
        "What must be true, in a sentence. By default it is made of the other keys.", "", example="it is small"
    )

    def __post_init__(self) -> None:
        if not self.metric:
            raise ClaimError('what is measured? It needs metric = NAME, such as "rms_cross_track_m"').about("metric")
        self._check_relation()
        self._check_bound()
        self._check_margin()
        if self.robot is not None and self.robot < 1:
            raise ClaimError(f"robot must be a whole number >= 1; got {self.robot}").about("robot")
        if self.robot is not None and self.mean:
            raise ClaimError("give robot or mean, not both").about("mean")
        if not self.on:
            raise ClaimError('on must name a scenario, or be "all"; got none').about("on")

    @property
    def relation(self) -> str:
        """The one of RELATIONS that is given."""
        return self._relations()[0]

    @property
    def robots(self) -> str:
        """Whose number it is, as :func:`robotics.measures.quantities.measured` calls it."""
        return "mean" if self.mean else "worst" if self.robot is None else str(self.robot)

    @property
    def named(self) -> list[tuple[str, str]]:
        """The controllers that it names, each with its key."""
        return [("of", self.of), *(("against", name) for name in self.against)]

    @property
    def rivals(self) -> bool:
        """Whether it is compared to other controllers."""
        return self.relation not in ("below", "above")

    def room(self) -> Room:
        """By how much it must be beyond its rivals, or may be behind."""
        if self.relation == "no_worse_by":
            return Room(margin=-(self.no_worse_by or 0.0))
        if self.relation == "no_worse_by_percent":
            return Room(share=-(self.no_worse_by_percent or 0.0) / 100)
        return Room(self.margin or 0.0, (self.margin_percent or 0.0) / 100)

    def limit(self) -> Limit | None:
        """The bound that the number must keep, if it is not compared to rivals."""
        if self.below is not None:
            return Limit("below", self.below)
        return None if self.above is None else Limit("above", self.above)

    def _relations(self) -> list[str]:
        return [n for n in RELATIONS if getattr(self, n) is not None and getattr(self, n) is not False]

    def _check_relation(self) -> None:
        given = self._relations()
        if len(given) != 1:
            what = f"got {' and '.join(given)}" if given else "got none"
            problem = ClaimError(f"a claim's part has one relation: {', '.join(RELATIONS)}; {what}")
            raise problem.about(given[1]) if given else problem
        (relation,) = given
        if not self.rivals and self.against:
            raise ClaimError(
                f"{relation} compares to a number, and against names controllers; "
                "use less, more or no_worse_by, or leave against out"
            ).about("against")
        for name in ("no_worse_by", "no_worse_by_percent"):
            value = getattr(self, name)
            if value is not None and value <= 0:
                raise ClaimError(f"{name} must be > 0, how much worse is allowed; got {value:g}").about(name)

    def _check_bound(self) -> None:
        for name in ("share", "origin"):
            if getattr(self, name) not in (None, "") and self.rivals:
                raise ClaimError(f"{name} belongs to below or above; the relation is {self.relation}").about(name)
        if self.share is not None and not 0 < self.share < 1:
            raise ClaimError(f"share must be > 0 and < 1, a share of the runs; got {self.share:g}").about("share")

    def _check_margin(self) -> None:
        for name in ("margin", "margin_percent"):
            value = getattr(self, name)
            if value is None:
                continue
            if self.relation not in ("less", "more"):
                raise ClaimError(
                    f"{name} belongs to less = true or more = true; the relation is {self.relation}"
                ).about(name)
            if value < 0:
                raise ClaimError(
                    f"{name} must be >= 0; got {value:g}; for a claim that it is not much worse write "
                    f"no_worse_by{name.removeprefix('margin')} = {-value:g}, and no {self.relation}"
                ).about(name)
        if self.margin is not None and self.margin_percent is not None:
            raise ClaimError("give margin or margin_percent, not both").about("margin_percent")
        if self.relation == "less" and (self.margin_percent or 0.0) >= 100:
            raise ClaimError(f"margin_percent must be < 100 with less; got {self.margin_percent:g}").about(
                "margin_percent"
            )


RELATIONS = ("below", "above", "less", "more", "no_worse_by", "no_worse_by_percent")


@dataclass(frozen=True, kw_only=True)
class Statement:
    """A claim before anything is measured. Raises ClaimError."""

    name: str = described("What the claim is called.", example="Mine is better", missing=_NAMELESS)
    says: str = described("What is claimed, in a sentence. Default: its name.", "", example="It is better.")
    source: str = described("Where the claim is made, such as a paper. May be left out.", "", example="A paper")
    untested: str = described("What of it is not tested here. May be left out.", "", example="A paper")
    parts: tuple[Condition, ...] = described(
        "Its parts, tables [[claims.parts]]; of a claim with one part its keys may stand in the claim itself.", ()
    )
    direct: bool = field(default=False, compare=False)  # whether the keys of its one part stand in the claim itself

    def __post_init__(self) -> None:
        if not self.name:
            raise ClaimError(_NAMELESS)
        if not self.parts:
            raise ClaimError(
                f"the claim {self.name!r} has no part: give metric, of and a relation, or [[claims.parts]]"
            )

    @property
    def texts(self) -> dict[str, str]:
        """The texts of a :class:`robotics.show.report.chapter.Claim`, by its fields."""
        found = {name: getattr(self, name) for name in ("name", "says", "source", "untested")}
        return found | {"says": self.says or self.name}


def names_of(value: Any, keys: Keys) -> tuple[str, ...]:
    """One text, or several in a list. Raises ClaimError."""
    listed = [value] if isinstance(value, str) else value
    if not (isinstance(listed, list) and listed and all(isinstance(v, str) and v for v in listed)):
        raise ClaimError(f"{keys[-1]} must be a name in quotes, or a list of names; got {value!r}").about(*keys)
    return tuple(listed)


NAME_LISTS: Mapping[Any, Special] = {tuple[str, ...]: names_of}  # how lists of names are read


def statements(
    value: Any, keys: Keys, fault: type[InputError] = ClaimError, kind: type[Statement] = Statement
) -> tuple[Any, ...]:
    """The claims in the tables [[claims]] of a file, each of ``kind``. Raises ``fault`` about what is wrong."""
    builder = Builder(fault, NAME_LISTS)
    return tuple(_statement(row, (*keys, i), builder, kind) for i, row in enumerate(builder.tables(value, keys)))


def _statement(row: dict[str, Any], keys: Keys, builder: Builder, kind: type[Statement]) -> Any:
    condition = get_args(get_type_hints(kind)["parts"])[0]
    parts = tuple(f.name for f in fields(condition))
    direct = {key: value for key, value in row.items() if key in parts and key != "says"}
    if direct and "parts" in row:
        first = next(iter(direct))
        what = f"{first} stands in the claim itself, which has parts: write it into one of them"
        raise builder.fault(what).about(*keys, first)
    rest = {key: value for key, value in row.items() if key not in direct}
    given: dict[str, Any] = {"parts": (builder.build(condition, direct, keys),)} if direct else {}
    return builder.build(kind, rest, keys, also=parts, direct=bool(direct), **given)


# Judging ----------------------------------------------------------------------------------------------------------


class Measure(NamedTuple):
    """What a part of a claim measures, as far as its words and its direction need it."""

    title: str
    unit: str
    larger: bool = False  # larger is better


def decided(
    condition: Condition,
    measure: Measure,
    values: Callable[[str], np.ndarray],
    *,
    on: str,
    of: str,
    against: Sequence[str] = (),
    form: Form = "",
    fewest: int = 1,
    note: str = "",
) -> Part:
    """A part of a claim with the numbers that decide it.

    Args:
        condition: The part before anything is measured.
        measure: Of what is measured.
        values: Gives the numbers (seeds,) of a law, in the measure's unit; bool where something happens or not.
        on: The scenario or experiment.
        of: The law that is judged.
        against: The laws to which it is compared.
        form: The form of the laws.
        fewest: Runs without which nothing is told.
        note: What a reader must know of the runs.
    """
    ours, *others = (values(law) for law in (of, *against))
    room, limit = condition.room(), condition.limit()
    sides: tuple[Estimate, ...] = ()
    scale, each = 1.0, None
    if limit is None:
        upwards = condition.relation == "more" or (min(room) < 0 and measure.larger)
        estimate, bound, sense, kept = compared(ours, others, upwards, room)
        sides = tuple(map(_estimate, (ours, *others)))
        scale = 1 + (room.share if upwards else -room.share)
    else:
        estimate, (sense, bound) = _estimate(ours), limit
        kept = int((ours == (sense == "above")).sum() if ours.dtype == bool else limit.keeps(ours).sum())
        if estimate.kind == "mean" and not np.isnan(ours).any():
            sides, each = (estimate,), limit
            estimate, bound, sense = rate_of(limit.keeps(ours)), condition.share or HALF, "above"
    return Part(
        says=condition.says or _words(condition, measure, of, against),
        form=form,
        estimate=estimate,
        bound=bound,
        sense=sense,
        unit=measure.unit,
        quantity=condition.metric,
        on=on,
        robots=condition.robots,
        of=of,
        against=tuple(against),
        sides=sides,
        scale=scale,
        fewest=fewest,
        note=note,
        kept=kept,
        limit=each,
        origin=condition.origin,
    )


def _estimate(values: np.ndarray) -> Estimate:
    if len(values) == 1:
        return exact(values[0])
    return rate_of(values) if values.dtype == bool else mean_of(values)


def _words(condition: Condition, measure: Measure, of: str, against: Sequence[str]) -> str:
    """A part's sentence, made of its keys."""
    whose = {"worst": "", "mean": ", mean of the robots"}.get(condition.robots, f", robot {condition.robots}")
    what, rivals = f"{measure.title.partition(':')[0]} of {of}{whose}", " and of ".join(against)
    relation, room = condition.relation, condition.room()
    if not condition.rivals:
        return f"{what} {relation} {bound_text(getattr(condition, relation), measure.unit)}"
    apart = f"{100 * abs(room.share):g} %" if room.share else bound_text(abs(room.margin), measure.unit)
    if relation.startswith("no_worse_by"):
        return f"{what} less than {apart} worse than that of {rivals}"
    beyond = f" by at least {apart}" if any(room) else ""
    return f"{what} {relation} than that of {rivals}{beyond}"
