"""Rows by name: the same numbers as by plain indices, compiled and not; misspelt names; the cache on disk."""

import os
import subprocess
import sys
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
import pytest
from numba.core.errors import TypingError

from fuzzy.compiled.columns import (
    ColumnError,
    Columns,
    Floats2,
    Ints1,
    check,
    check_names,
    codes,
    column,
    compiled_type,
    several,
    within,
)
from fuzzy.compiled.jit import fingerprint, kernel

ROOT = Path(__file__).parents[3]


class Axis(Columns):
    """Of one axis."""

    place = column("m", "where it is")
    speed = column("m/s")


class Robot(Columns):
    """Of one robot: two axes, three numbers, one more, and the rest."""

    x = within(Axis)
    y = within(Axis)
    gains = several(3)
    count = column("1", "of periods")
    rest = several(0)


ROWS = 8 + 2  # the last two are the rest


def table(*shape, kind=float):
    """An array of numbers that are all different."""
    return np.arange(1, np.prod(shape) + 1).reshape(shape).astype(kind)


def by_name(one, other):
    """Read and write every column of ``one``, by what is in ``other``."""
    one.x.place = other.y.speed * 2
    one.x.speed += other.x.place
    y = one.y
    y.place, y.speed = other.gains[2], other.count
    one.gains[1] = other.rest[1] - other.gains[0]
    for n in range(len(one.rest)):
        one.rest[n] = one.rest[n] + 10 * n
    one.count = len(other.gains) + len(other.rest)
    return one.x.speed


def by_number(one, other):
    """The same by the numbers of the rows."""
    one[0] = other[3] * 2
    one[1] += other[0]
    one[2], one[3] = other[6], other[7]
    one[5] = other[9] - other[4]
    for n in range(2):
        one[8 + n] = one[8 + n] + 10 * n
    one[7] = 3 + 2
    return one[1]


compiled_by_name = kernel(by_name)


@kernel
def of_vectors(a, b):
    """Of whole vectors."""
    return compiled_by_name(Robot(a), Robot(b))


@kernel
def of_parts(a, b, first, stride):
    """Of every ``stride``-th number of vectors, from the ``first`` on."""
    return compiled_by_name(Robot(a, first, stride), Robot(b, first, stride))


@kernel
def of_lanes(a, b, i):
    """Of a lane of arrays (rows, lanes)."""
    return compiled_by_name(Robot(a, i), Robot(b, i))


@kernel
def of_pairs(a, b, i, j):
    """Of a lane and one more index of arrays (rows, lanes, others)."""
    return compiled_by_name(Robot(a, i, j), Robot(b, i, j))


CASES = [
    (of_vectors, (ROWS,), (), (slice(None),)),
    (of_parts, (ROWS * 3,), (1, 3), (slice(1, None, 3),)),
    (of_lanes, (ROWS, 4), (2,), (slice(None), 2)),
    (of_pairs, (ROWS, 4, 5), (3, 1), (slice(None), 3, 1)),
]


@pytest.mark.parametrize(("function", "shape", "at", "part"), CASES)
@pytest.mark.parametrize("kind", [float, np.int64])
@pytest.mark.parametrize("compiles", [True, False])
def test_rows_by_name_are_rows_by_number(function, shape, at, part, kind, compiles):
    a, b = table(*shape, kind=kind), 3 * table(*shape, kind=kind)
    wanted, other = a.copy(), b.copy()
    told = by_number(wanted[part], other[part])
    found = function(a, b, *at) if compiles else by_name(Robot(a, *at), Robot(b, *at))
    assert found == told
    np.testing.assert_array_equal(a, wanted)
    np.testing.assert_array_equal(b, other)


def test_parts_of_larger_arrays_are_read_in_place():
    a, b = table(ROWS, 8), 2 * table(ROWS, 8)
    wanted = a.copy()
    told = by_number(wanted[:, ::2][:, 1], b[:, ::2][:, 1])
    assert of_lanes(a[:, ::2], b[:, ::2], 1) == told
    np.testing.assert_array_equal(a, wanted)


def test_in_python_a_name_is_a_whole_row_and_a_class_knows_its_rows():
    robots = Robot.zeros(4)
    robots.count = np.arange(4)
    robots.x.speed = 2.0
    assert robots.array.shape == (8, 4)
    np.testing.assert_array_equal(robots.array[7], np.arange(4))
    np.testing.assert_array_equal(robots.array[1], 2.0)
    assert Robot.size == 8
    assert Robot.leaves() == ("place", "speed", "place", "speed", "gains", "count", "rest")
    assert (Robot.columns["count"].row, Robot.columns["count"].unit) == (7, "1")
    assert Robot.columns["count"].meaning == "of periods"


def test_values_by_name_are_stacked_in_the_rows_order():
    values = {"count": 9, "gains": (5, 6, 7), "y": {"speed": 4, "place": 3}, "x": (1, 2), "rest": (10, 11)}
    assert Robot.stacked(values) == [1, 2, 3, 4, 5, 6, 7, 9, 10, 11]
    for change, says in [
        ({"cuont": 1}, r"Robot: unknown column 'cuont'; did you mean 'count'\?"),
        ({"gains": (1, 2)}, r"Robot\.gains is 3 rows; got 2"),
        ({"x": {"place": 1}}, "Axis needs a value for speed"),
    ]:
        with pytest.raises(ColumnError, match=says):
            Robot.stacked({**values, **change})  # type: ignore[dict-item]


# Misspelt names -------------------------------------------------------------------------------------------------


def test_a_misspelt_column_is_an_error_where_a_function_is_defined():
    def reads(one: Robot, two):
        return one.count + two.cuont  # nobody knows what two is

    kernel(reads)

    def misreads(one: Robot):
        return one.cuont

    def miswrites(one: Robot):
        one.x.palce = 1.0

    for function, of, says in [
        (misreads, "Robot", "'cuont'; did you mean 'count'"),
        (miswrites, "Axis", "'palce'; did you mean 'place'"),
    ]:
        line = function.__code__.co_firstlineno + 1
        with pytest.raises(ColumnError, match=rf"test_columns\.py:{line}: {of}: unknown column {says}"):
            kernel(function)
        with pytest.raises(ColumnError, match=rf":{line}: {of}: unknown column"):
            check_names(function, {"one": Robot})


def test_a_misspelt_column_of_an_argument_without_a_class_does_not_compile():
    @kernel
    def cuont(a):
        return Robot(a).cuont

    if not hasattr(cuont, "py_func"):
        pytest.skip("not compiled")
    with pytest.raises(TypingError, match=r"Unknown attribute 'cuont' of type Robot\(x, y, gains, count, rest\)"):
        cuont(table(ROWS))


def test_in_python_a_misspelt_column_is_no_new_attribute():
    robot = Robot(table(ROWS))
    with pytest.raises(AttributeError, match=r"Robot: unknown column 'cuont'; did you mean 'count'\?"):
        robot.cuont  # noqa: B018
    with pytest.raises(ColumnError, match=r"Robot: unknown column 'cuont'; did you mean 'count'\?"):
        robot.cuont = 1.0
    with pytest.raises(AttributeError, match="gains is several rows: assign to its parts"):
        robot.gains = 1.0


# Tuples of arrays, and words --------------------------------------------------------------------------------------


class Body(NamedTuple):
    """What a compiled function takes."""

    rows: Floats2
    place: Ints1
    period: float


@kernel
def moved(body):
    """The first robot's speed, times the period."""
    return Axis(body.rows, body.place[0]).speed * body.period


def test_a_tuple_of_arrays_is_what_its_class_declares():
    body = Body(table(2, 3), np.array([1]), 0.5)
    check(body)
    assert moved(body) == body.rows[1, 1] * 0.5
    assert compiled_type(Body).fields == ("rows", "place", "period")
    for change in ({"rows": table(3)}, {"rows": table(2, 3)[:, ::2]}, {"place": table(1)}, {"period": 1}):
        with pytest.raises(TypeError, match=f"{next(iter(change))} must be "):
            check(body._replace(**change))


def test_words_are_numbers_in_their_order():
    form = codes(Literal["2.31", "own-pose", "none"])
    assert (form.form_2_31, form.own_pose, form.none) == (0, 1, 2)

    @kernel
    def is_none(value):
        return value == form.none

    assert is_none(2.0)
    assert not is_none(1.0)


# Machine code on disk ---------------------------------------------------------------------------------------------

TOY = """
from fuzzy.compiled.columns import Columns, column
from fuzzy.compiled.jit import kernel

class Toy(Columns):
    {}

@kernel
def ratio(rows):
    toy = Toy(rows)
    return toy.first / toy.second
"""
RUN = "import toy, numpy, fuzzy.compiled.jit as j; print(toy.ratio(numpy.array([1.0, 4.0])), j.fingerprint(toy.ratio))"


@pytest.mark.long
def test_columns_in_another_order_are_another_machine_code(tmp_path):
    first, second = 'first = column("m")', 'second = column("m")'
    told = []
    environment = os.environ | {"PYTHONPATH": f"{tmp_path}{os.pathsep}{ROOT}"}
    environment["NUMBA_CACHE_DIR"] = str(tmp_path / "kept")
    environment.pop("NUMBA_DISABLE_JIT", None)
    for lines in ((first, second), (second, first), (first, second)):
        (tmp_path / "toy.py").write_text(TOY.format("\n    ".join(lines)), encoding="utf-8")
        done = subprocess.run(
            [sys.executable, "-B", "-c", RUN], env=environment, cwd=tmp_path, capture_output=True, text=True, check=True
        )
        told.append(done.stdout.split())
    assert [value for value, _ in told] == ["0.25", "4.0", "0.25"]
    assert told[0] == told[2]
    assert told[0][1] != told[1][1]


def test_a_unit_changes_no_machine_code():
    class Metres(Columns):
        x = column("m")

    class Feet(Columns):
        x = column("ft", "where it is")

    def made(of):
        def x(rows):
            return of(rows).x

        return kernel(x)

    if not hasattr(made(Metres), "py_func"):
        pytest.skip("not compiled")
    Feet.layout = (Metres.layout[0], Feet.layout[1])
    assert fingerprint(made(Metres)) == fingerprint(made(Feet))
