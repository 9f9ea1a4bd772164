"""Numbers of compiled code by name: rows of an array, and tuples of arrays, each declared once.

A class of columns names the rows of an array, with the unit and the meaning of each:

    class Robot(Columns):
        x = column("m", "measured")
        y = column("m", "measured")

``Robot(seen, i)`` is then one lane of the array ``seen`` (rows, lanes): its ``x`` reads and writes ``seen[0, i]``, in
compiled code and in Python alike, at the price of the plain index. ``Robot(seen).x`` is the whole row. The
class tells the compiler, the translation to C and whoever checks a law what the rows are: a row has its number nowhere
else.

A tuple of arrays is a NamedTuple whose fields are annotated by the kinds of arrays below (``Floats2``: two axes of
floats, contiguous); :func:`compiled_type` and :func:`check` read these.
"""

import dis
import re
from collections import namedtuple
from collections.abc import Callable, Mapping
from functools import cache
from typing import Annotated, Any, ClassVar, cast, get_args, get_type_hints

import numpy as np
from numba.core import cgutils, types
from numba.core.imputils import lower_cast
from numba.core.typing.templates import AbstractTemplate, AttributeTemplate, infer_getattr, infer_global, signature
from numba.extending import lower_builtin, lower_getattr_generic, lower_setattr_generic, models, register_model
from numba.np.arrayobj import make_array, populate_array
from numba.np.numpy_support import as_dtype

from fuzzy.errors import InputError
from fuzzy.naming import expected


class ColumnError(InputError):
    """A column that is not declared."""


# Rows by name -----------------------------------------------------------------------------------------------------


class Column:
    """A row of an array, or several: what it is called, its unit and its meaning.

    Read of the class it is itself; of one lane of an array it is the number, or the rows that it names.
    """

    def __init__(self, unit: str = "", meaning: str = "", width: int | None = None, of: Any = None) -> None:
        self.unit, self.meaning, self.width, self.of = unit, meaning, width, of
        self.name, self.row = "", 0

    @property
    def rows(self) -> int:
        """How many rows it is; 0 for the rest of an array."""
        return self.of.size if self.of is not None else 1 if self.width is None else self.width

    @property
    def open(self) -> bool:
        """Whether it, or a column of its part, which then is the last, is the rest of an array."""
        return self.width == 0 if self.of is None else any(column.open for column in self.of.columns.values())

    def placed(self, row: int) -> "Column":
        """The same from another row on."""
        found = Column(self.unit, self.meaning, self.width, self.of)
        found.name, found.row = self.name, row
        return found

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    def __get__(self, lane: "Columns | None", owner: type) -> Any:
        if lane is None:
            return self
        if self.of is None and self.width is None:
            return lane.array[self.row]
        here = lane.array[self.row :] if self.open else lane.array[self.row : self.row + self.rows]
        return here if self.of is None else self.of(here)

    def __set__(self, lane: "Columns", value: Any) -> None:
        if self.of is not None and isinstance(value, self.of):
            lane.array[self.row : self.row + self.rows] = value.array[: self.rows]
        elif self.of is not None or self.width is not None:
            raise AttributeError(f"{self.name} is several rows: assign to its parts")
        else:
            lane.array[self.row] = value


def column(unit: str, meaning: str = "") -> Any:
    """Declare a row of numbers of a ``unit``."""
    return Column(unit, meaning)


def several(width: int, unit: str = "1", meaning: str = "") -> Any:
    """Declare ``width`` rows under one name, read by index; 0: those up to the array's end."""
    return Column(unit, meaning, width=width)


def within(of: "type[Columns]") -> Any:
    """Declare the rows of another class of columns, one after the other, under one name."""
    return Column(of=of)


class Columns:
    """The base of every class of columns; see the module."""

    columns: ClassVar[Mapping[str, Column]] = {}
    size: ClassVar[int] = 0  # rows
    layout: ClassVar[tuple[Any, ...]] = ("Columns", ())  # what a compiler needs to know, as plain values

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        found, row = {}, 0
        for name, declared in {**cls.columns, **vars(cls)}.items():
            if isinstance(declared, Column):
                found[name] = declared.placed(row)
                setattr(cls, name, found[name])
                row += declared.rows
        cls.columns, cls.size = found, row
        cls.layout = (cls.__qualname__, tuple((n, c.row, c.width, c.of and c.of.layout) for n, c in found.items()))
        _make_callable(cls)

    def __init__(self, array: Any, *at: int) -> None:
        """One lane of an ``array``: of (rows, lanes) the lane, of (rows, lanes, others) the lane and which other.

        Of a vector it is all of it, or what comes from the first on, or every so many numbers of that: two more
        arguments. Without a lane: all lanes, whose columns are whole rows.
        """
        if array.ndim == 1 and at:
            first, *stride = at
            array = array[first :: stride[0] if stride else 1]
        elif at:
            array = array[(slice(None), *at)]
        object.__setattr__(self, "array", array)

    array: np.ndarray

    def __setattr__(self, name: str, value: Any) -> None:
        if name not in type(self).columns:
            raise ColumnError(missing(type(self), name))
        object.__setattr__(self, name, value)

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(missing(type(self), name))

    @classmethod
    def named(cls, name: str, columns: Mapping[str, Column]) -> "type[Columns]":
        """A class called ``name`` of these columns."""
        return type(name, (cls,), dict(columns))

    @classmethod
    @cache
    def leaves(cls) -> tuple[str, ...]:
        """The names of all rows that are numbers, those within others included."""
        return tuple(leaf for name, c in cls.columns.items() for leaf in (c.of.leaves() if c.of else (name,)))

    @classmethod
    def zeros(cls, *lanes: int) -> Any:
        """All rows, 0, of so many lanes; its ``array`` is (rows, lanes)."""
        return cls(np.zeros((cls.size, *lanes)))

    @classmethod
    def stacked(cls, values: Mapping[str, Any]) -> list[Any]:
        """The rows of ``values`` by name, in their order; of several rows the value is a sequence of as many.

        Raises ColumnError where names lack or are unknown.
        """
        for name in values:
            if name not in cls.columns:
                raise ColumnError(missing(cls, name))
        rows: list[Any] = []
        for name, one in cls.columns.items():
            if name not in values:
                raise ColumnError(f"{cls.__qualname__} needs a value for {name}")
            value = values[name]
            if one.of is not None and isinstance(value, Mapping):
                value = one.of.stacked(value)
            parts = [value] if one.of is None and one.width is None else list(value)
            if one.rows and len(parts) != one.rows:
                raise ColumnError(f"{cls.__qualname__}.{name} is {one.rows} rows; got {len(parts)}")
            rows += parts
        return rows


def missing(of: type[Columns], name: str) -> str:
    """What to say of a column that a class does not have."""
    return f"{of.__qualname__}: " + expected(name, [*of.columns], "column")


def check_names(function: Callable[..., Any], known: Mapping[str, type[Columns]]) -> None:
    """Look at the columns that a function reads and writes of its arguments, those of ``known`` by name.

    Raises ColumnError, with file and line, for one that is not declared.
    """
    at: tuple[Any, ...] = ()
    line = function.__code__.co_firstlineno
    for step in dis.get_instructions(function):
        line = step.positions.lineno or line if step.positions is not None else line
        if step.opname.startswith("LOAD_FAST"):
            name = step.argval[-1] if isinstance(step.argval, tuple) else step.argval
            at = (known[name],) if name in known else ()
        elif step.opname in ("LOAD_ATTR", "STORE_ATTR") and at:
            if step.argval not in at[0].columns:
                raise ColumnError(f"{function.__code__.co_filename}:{line}: {missing(at[0], step.argval)}")
            inner = at[0].columns[step.argval].of
            at = () if inner is None else (inner,)
        elif step.opname != "COPY":
            at = ()


# What the compiler knows of them ----------------------------------------------------------------------------------


class LaneType(types.Type):
    """The compiled type of one lane: told by the layout of its class, and by the array's numbers.

    Of ``axes`` > 0 it is all lanes of an array, whose columns are arrays of so many axes.
    """

    def __init__(self, layout: tuple[Any, ...], dtype: Any, contiguous: bool, axes: int = 0) -> None:
        self.layout, self.dtype, self.contiguous, self.axes = layout, dtype, contiguous, axes
        self.places = {name: (row, width, of) for name, row, width, of in layout[1]}
        super().__init__(f"{layout[0]}({', '.join(self.places)})")

    @property
    def size(self) -> int:
        """How many rows are named; those up to the array's end do not count."""
        return _rows(self.layout)

    @property
    def key(self) -> Any:
        """By what two types are the same."""
        return self.layout, self.dtype, self.contiguous, self.axes

    def part(self, name: str) -> Any:
        """The type of a column; None if there is none of that name."""
        if name not in self.places:
            return None
        _, width, of = self.places[name]
        if of is not None:
            return LaneType(of, self.dtype, self.contiguous, self.axes)
        axes = self.axes + (width is not None)
        return types.Array(self.dtype, axes, "C" if self.contiguous else "A") if axes else self.dtype


def _rows(layout: tuple[Any, ...]) -> int:
    return sum(_rows(of) if of else 1 if width is None else width for _, _, width, of in layout[1])


@register_model(LaneType)
class _LaneModel(models.StructModel):
    """A pointer to the first row's number, the bytes from row to row, the rows there are, and the axes of a row."""

    def __init__(self, manager: Any, kind: LaneType) -> None:
        axes = types.UniTuple(types.intp, kind.axes)
        members = [("data", types.CPointer(kind.dtype)), ("stride", types.intp), ("rows", types.intp)]
        members += [("shape", axes), ("strides", axes)]
        super().__init__(manager, kind, members)


@infer_getattr
class _LaneAttributes(AttributeTemplate):
    key = LaneType

    def generic_resolve(self, lane: LaneType, name: str) -> Any:  # type: ignore[override]
        """The type of a column."""
        return lane.part(name)


def _make_callable(cls: type[Columns]) -> None:
    """Let compiled code call a class of columns."""

    class Template(AbstractTemplate):
        key = cls

        def generic(self, args: Any, kws: Any) -> Any:
            """The type of a lane of an array."""
            array, *at = args
            if kws or not isinstance(array, types.Array) or not all(isinstance(a, types.Integer) for a in at):
                return None
            axes = 0 if at else array.ndim - 1
            if len(at) not in ((0, 1, 2) if array.ndim == 1 else (0, array.ndim - 1)):
                return None
            contiguous = array.layout == "C" and (len(at) < 2 if array.ndim == 1 else not at)
            return signature(LaneType(cls.layout, array.dtype, contiguous, axes), *args)

    infer_global(cls, types.Function(Template))
    for more in ((), (types.Integer,), (types.Integer, types.Integer)):
        lower_builtin(cls, types.Array, *more)(_lane)


def _lane(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    """Make a lane of an array."""
    kind = sig.args[0]
    array = make_array(kind)(context, builder, args[0])
    at = [context.cast(builder, a, t, types.intp) for a, t in zip(args[1:], sig.args[1:], strict=True)]
    size = array.itemsize
    lane = cgutils.create_struct_proxy(sig.return_type)(context, builder)
    strides, shape = (cgutils.unpack_tuple(builder, part, kind.ndim) for part in (array.strides, array.shape))
    if kind.layout == "C":
        strides[-1] = context.get_constant(types.intp, context.get_abi_sizeof(context.get_data_type(kind.dtype)))
    if kind.ndim == 1 and at:
        step = at[1] if len(at) > 1 else context.get_constant(types.intp, 1)
        move, lane.stride = builder.mul(at[0], strides[0]), builder.mul(step, strides[0])
        left = builder.sub(builder.add(builder.sub(shape[0], at[0]), step), step.type(1))
        lane.rows = builder.sdiv(left, step)
    else:
        move = size.type(0)
        for place, stride in zip(at, strides[1:], strict=bool(at)):
            move = builder.add(move, builder.mul(place, stride))
        lane.stride, lane.rows = strides[0], shape[0]
        if sig.return_type.axes:
            lane.shape = cgutils.pack_array(builder, shape[1:])
            lane.strides = cgutils.pack_array(builder, strides[1:])
    lane.data = cgutils.pointer_add(builder, array.data, move)
    return lane._getvalue()


def _place(context: Any, builder: Any, kind: LaneType, value: Any, name: str) -> tuple[Any, Any]:
    """The lane as a structure, and the pointer to a column's first number."""
    lane = cgutils.create_struct_proxy(kind)(context, builder, value=value)
    row = context.get_constant(types.intp, kind.places[name][0])
    return lane, cgutils.pointer_add(builder, lane.data, builder.mul(lane.stride, row))


@lower_getattr_generic(LaneType)
def _read(context: Any, builder: Any, kind: LaneType, value: Any, name: str) -> Any:
    lane, pointer = _place(context, builder, kind, value, name)
    part, (row, width, of) = kind.part(name), kind.places[name]
    if width is None and of is None and not kind.axes:
        return context.unpack_value(builder, kind.dtype, pointer)
    left = builder.sub(lane.rows, context.get_constant(types.intp, row))
    if of is not None:
        inner = cgutils.create_struct_proxy(part)(context, builder)
        inner.data, inner.stride, inner.rows = pointer, lane.stride, left
        inner.shape, inner.strides = lane.shape, lane.strides
        return inner._getvalue()
    array = make_array(part)(context, builder)
    size = context.get_constant(types.intp, context.get_abi_sizeof(context.get_data_type(kind.dtype)))
    shape, strides = (cgutils.unpack_tuple(builder, axes, kind.axes) for axes in (lane.shape, lane.strides))
    if width is not None:
        shape = [context.get_constant(types.intp, width) if width else left, *shape]
        strides = [size if kind.contiguous and not kind.axes else lane.stride, *strides]
    populate_array(array, data=pointer, shape=shape, strides=strides, itemsize=size, meminfo=None)
    return array._getvalue()


@lower_cast(LaneType, LaneType)
def _same(context: Any, builder: Any, of: LaneType, to: LaneType, value: Any) -> Any:
    """Take a lane of the same columns for another: what is assigned to a part may lie otherwise in memory."""
    if of.layout != to.layout:
        raise TypeError(f"{of} is assigned where {to} is wanted")
    return value


@lower_setattr_generic(LaneType)
def _write(context: Any, builder: Any, sig: Any, args: Any, name: str) -> Any:
    kind, part = sig.args
    lane, pointer = _place(context, builder, kind, args[0], name)
    if isinstance(part, LaneType):
        other = cgutils.create_struct_proxy(part)(context, builder, value=args[1])
        for row in range(part.size):
            to, of = (
                cgutils.pointer_add(builder, first, builder.mul(stride, context.get_constant(types.intp, row)))
                for first, stride in ((pointer, lane.stride), (other.data, other.stride))
            )
            context.pack_value(builder, kind.dtype, context.unpack_value(builder, kind.dtype, of), to)
    else:
        context.pack_value(builder, kind.dtype, context.cast(builder, args[1], part, kind.dtype), pointer)
    return context.get_dummy_value()


LOWERING = (_lane, _place, _read, _write)  # what makes machine code of a class of columns

# Tuples of arrays -------------------------------------------------------------------------------------------------

Floats1 = Annotated[np.ndarray, types.float64[::1]]
Floats2 = Annotated[np.ndarray, types.float64[:, ::1]]
Floats3 = Annotated[np.ndarray, types.float64[:, :, ::1]]
Floats4 = Annotated[np.ndarray, types.float64[:, :, :, ::1]]
Floats5 = Annotated[np.ndarray, types.float64[:, :, :, :, ::1]]
Ints1 = Annotated[np.ndarray, types.int64[::1]]
Ints2 = Annotated[np.ndarray, types.int64[:, ::1]]
Ints3 = Annotated[np.ndarray, types.int64[:, :, ::1]]
ShortInts2 = Annotated[np.ndarray, types.int32[:, ::1]]
ShortInts3 = Annotated[np.ndarray, types.int32[:, :, ::1]]
Bools1 = Annotated[np.ndarray, types.boolean[::1]]
Bools2 = Annotated[np.ndarray, types.boolean[:, ::1]]
# Parts of larger arrays
PartOfFloats4 = Annotated[np.ndarray, types.Array(types.float64, 4, "A")]
PartOfSingles4 = Annotated[np.ndarray, types.Array(types.float32, 4, "A")]
PartOfBytes3 = Annotated[np.ndarray, types.Array(types.int8, 3, "A")]
PartOfBools3 = Annotated[np.ndarray, types.Array(types.boolean, 3, "A")]

_PLAIN = {int: types.int64, float: types.float64, bool: types.boolean}


@cache
def compiled_type(of: Any) -> Any:
    """The compiled type of a NamedTuple whose fields are annotated by kinds of arrays, numbers or such tuples."""
    hints = get_type_hints(of, include_extras=True)
    return types.NamedTuple(tuple(_kind(hints[name]) for name in of._fields), of)


def _kind(hint: Any) -> Any:
    if hasattr(hint, "__metadata__"):
        return hint.__metadata__[0]
    return compiled_type(hint) if hasattr(hint, "_fields") else _PLAIN[hint]


def check(values: Any) -> None:
    """Raise TypeError unless ``values`` are what their class declares: machine code looks at nothing."""
    for value, (name, wanted, inner, dtype) in zip(values, _wanted(cast(Any, type(values))), strict=True):
        if inner is not None:
            if not isinstance(value, inner):
                raise TypeError(f"{name} must be {inner.__name__}; got {value!r}")
            check(value)
        elif dtype is not None:
            good = value.dtype == dtype and value.ndim == wanted.ndim and value.flags.writeable
            if not (good and (wanted.layout == "A" or value.flags.c_contiguous)):
                raise TypeError(f"{name} must be {wanted}; got {value.dtype}, {value.ndim} axes, {value.flags}")
        elif type(value) is not (float if wanted == types.float64 else int):
            raise TypeError(f"{name} must be {wanted}; got {value!r}")


@cache
def _wanted(of: Any) -> tuple[tuple[str, Any, Any, Any], ...]:
    """The name and type of each field, the class of a tuple and the numbers of an array: to ask Numba takes longer."""
    return tuple(
        (name, kind, getattr(kind, "instance_class", None), as_dtype(kind.dtype) if hasattr(kind, "layout") else None)
        for name, kind in zip(compiled_type(of).fields, compiled_type(of).types, strict=True)
    )


# Numbers that stand for words -------------------------------------------------------------------------------------


def codes(words: Any) -> Any:
    """A tuple of 0, 1, 2, ... by the words of a Literal, or by ``words``: ``codes(Mode).csm``, in compiled code too.

    What is no letter or digit is "_" in a name, and a name that begins with a digit is the ``form_`` of it.
    """
    fields = [re.sub(r"\W", "_", word) for word in get_args(words) or words]
    fields = [f"form_{field}" if field[0].isdigit() else field for field in fields]
    return namedtuple("codes", fields)(*range(len(fields)))
