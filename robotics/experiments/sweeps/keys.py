"""All keys of a sweep's file as data; see :mod:`robotics.tables.keys`."""

from collections.abc import Mapping
from functools import cache

from robotics.experiments.sweeps.reading import AxisRange, SweepFile
from robotics.tables.keys import Key, KeyTable, first_line, keys_of, table_of


@cache
def sweep_table() -> KeyTable:
    """The description of a sweep's file."""
    keys = keys_of(SweepFile, {Mapping[str, AxisRange] | None: lambda name: _axes(name)})
    return KeyTable(name="sweep", doc=first_line(SweepFile), keys=keys)


def _axes(name: str) -> Key:
    doc = "The values of an axis: a range, or a list of values."
    axis = Key(name="KEY", doc=doc, holds="table", table=table_of(AxisRange, "range"), or_list=True)
    return Key(name=name, doc="", holds="table", table=KeyTable(name=name, doc="Axes by name.", any_key=axis))
