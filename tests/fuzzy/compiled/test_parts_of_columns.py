"""Parts of columns: assigned as a whole, and cut of a vector, in compiled code as in Python."""

import numpy as np
import pytest

from fuzzy.compiled.columns import Columns, column, several, within
from fuzzy.compiled.jit import kernel


class Point(Columns):
    """Two numbers and two more."""

    x = column("m")
    more = several(2)
    y = column("m")


class Other(Columns):
    """As many numbers by other names."""

    x = column("m")
    more = several(2)
    z = column("m")


class Pair(Columns):
    """Two points, and what comes after them."""

    first = within(Point)
    second = within(Point)
    rest = several(0)


@kernel
def _moved(vector, table):
    pair, lane = Pair(vector), Pair(table, 1)
    pair.first = lane.second
    lane.first = pair.first
    one, spread = Point(pair.rest, 1), Point(pair.rest, 5, 3)
    one.more[1], spread.y = 7.0, 9.0


def _numbers():
    return np.arange(30.0), np.arange(100.0, 140.0).reshape(-1, 2)


@pytest.mark.parametrize("move", [_moved, getattr(_moved, "py_func", _moved)], ids=["compiled", "python"])
def test_a_part_is_assigned_as_a_whole_and_cut_of_a_vector(move):
    vector, table = _numbers()
    move(vector, table)
    expected, others = _numbers()
    expected[:4] = others[4:8, 1]
    others[:4, 1] = others[4:8, 1]
    expected[8 + 1 + 2], expected[8 + 5 + 3 * 3] = 7.0, 9.0
    np.testing.assert_array_equal(vector, expected)
    np.testing.assert_array_equal(table, others)


def test_a_part_takes_only_columns_of_its_class():
    @kernel
    def wrong(vector):
        Pair(vector).first = Other(vector)

    vector = np.zeros(20)
    with pytest.raises(Exception, match=r"Other\(x, more, z\) is assigned where Point\(x, more, y\) is wanted"):
        wrong(vector)
    with pytest.raises(AttributeError, match="first is several rows"):
        Pair(vector).first = Other(vector)
