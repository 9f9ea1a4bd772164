"""All keys of a study's file as data; see :mod:`robotics.tables.keys`."""

from dataclasses import replace
from functools import cache

from robotics.show.report.claims import RELATIONS, Condition, Statement
from robotics.show.report.plan import StudyPlan
from robotics.tables.keys import Key, KeyTable, first_line, keys_of


@cache
def study_table() -> KeyTable:
    """The description of a study's file."""
    claims = Key(name="claims", doc="A claim.", holds="tables", table=_claim())
    keys = keys_of(StudyPlan, without=("claims",))
    return KeyTable(name="study", doc=first_line(StudyPlan), keys=(*keys, claims))


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
