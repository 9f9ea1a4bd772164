"""All keys of a study's file as data; see :mod:`robotics.tables.keys`."""

from dataclasses import replace
from functools import cache

from robotics.show.report.claims import RELATIONS, Condition, Statement
from robotics.show.report.plan import ConditionsByName, StudyPlan
from robotics.studies.axes import Range, StudyAxis, axis_values_key
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


@cache
def sweep_table() -> KeyTable:
    """The description of a sweep's file, whose keys beside these are a study's, too."""
    alike = ("title", "controllers", "metrics", "seeds", "first_seed", "chunk", "method", "samples", "seed")
    own = {key.name: key for key in study_table().keys}
    own["seeds"] = replace(own["seeds"], default=1)
    own["controllers"] = replace(own["controllers"], required=False, rule="the scenario's own")
    scenario = "The scenario that is varied: a name, or a .toml file's path relative to this file."
    first = Key(name="scenario", doc=scenario, holds="text", required=True, example="lyapunov-sine")
    axis = replace(axis_values_key("KEY"), doc="The values of an axis: a range, or a list of values.")
    sections = {
        "scenario_fields": "Keys of the scenario's file by their dotted names; robots.0 is the first robot, "
        '"robots.*" every one.',
        "controller_parameters": "Gains, of every controller.",
    }
    axes = [
        Key(name=name, doc=doc, holds="table", table=KeyTable(name=name, doc="Axes by name.", any_key=axis))
        for name, doc in sections.items()
    ]
    keys = (first, *(own[name] for name in alike), *axes)
    return KeyTable(
        name="sweep", doc="A sweep: every point × every controller × every seed, into one table.", keys=keys
    )


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
