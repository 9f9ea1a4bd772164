"""All keys of a study's file as data; see :mod:`robotics.tables.keys`."""

from dataclasses import replace
from functools import cache

from robotics.show.report.claims import RELATIONS, Condition, Statement
from robotics.show.report.plan import ConditionsByName, StudyPlan
from robotics.studies.sweeps.reading import Range, StudyAxis, axis_values_key
from robotics.tables.keys import Key, KeyTable, first_line, keys_of


@cache
def study_table() -> KeyTable:
    """The description of a study's file."""
    claims = Key(name="claims", doc="A claim.", holds="tables", table=_claim())
    keys = keys_of(StudyPlan, {ConditionsByName: _conditions, Range: axis_values_key}, without=("claims", "axes"))
    axis = keys_of(StudyAxis, {Range: axis_values_key})
    axes = Key(
        name="axes",
        doc=first_line(StudyAxis),
        holds="tables",
        table=KeyTable(name="axis", doc=first_line(StudyAxis), keys=axis, one_of=(("key", "gain"),)),
    )
    return KeyTable(name="study", doc=first_line(StudyPlan), keys=(*keys, axes, claims))


def _conditions(name: str) -> Key:
    doc = "Keys of the scenarios' files by their dotted names."
    change = Key(name="KEY", doc="Its value under the condition.", holds="any")
    under = KeyTable(name="condition", doc=doc, any_key=change)
    condition = Key(name="NAME", doc=doc, holds="table", table=under, example={"sensing.position_noise": 0.01})
    return Key(
        name=name, doc="", holds="table", table=KeyTable(name=name, doc="Conditions by name.", any_key=condition)
    )


def _claim() -> KeyTable:
    part = keys_of(Condition)
    conditions = KeyTable(name="part", doc=first_line(Condition), keys=part, one_of=(RELATIONS,))
    parts = Key(
        name="parts",
        doc="The parts of a claim that has several; each has the keys metric to robot of the claim itself.",
        holds="tables",
        table=conditions,
    )
    own = keys_of(Statement, without=("parts",))
    direct = tuple(replace(key, required=False) for key in part if key.name != "says")
    return KeyTable(name="claim", doc=first_line(Statement), keys=(*own, *direct, parts), one_of=(RELATIONS,))
