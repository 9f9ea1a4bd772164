"""A law's equation: one compiled function of one robot, by the names of what it reads and writes.

A law that has one is written once, for one robot, in scalars. Everything else is made of it: the loop over all robots,
that the compiled simulation calls through a pointer, :meth:`EquationLaw.control` for arrays, and the law in C.

    @equation
    def steer(robot, aim, gain):
        v = aim.v * math.cos(aim.heading - robot.heading) + gain.kx * (aim.x - robot.x)
        return v, aim.w

    @dataclass(frozen=True, kw_only=True)
    class Steer(EquationLaw):
        kx: float = quantity(1.0, "1/s", above=0)
        equation = steer

What an equation may ask for are the names of :data:`ARGUMENTS`, in any order. One that does not ask for ``command``
returns v [m/s] and ω [rad/s]. A column that is not declared is an error where the law is defined.

It is compiled once in an installation, found on disk by the next process, and compiled anew when it, or anything that
it calls, has changed (:mod:`fuzzy.compiled.jit`). All arrays are columns, a lane after the other; a lane is one robot
of one run, and no lane reads what another one writes in the same period.
"""

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cache, cached_property
from threading import Lock
from typing import Any, ClassVar, Literal, NamedTuple, cast, get_args, get_origin, get_type_hints

import numpy as np

from fuzzy.compiled.columns import (
    Column,
    Columns,
    Floats2,
    Floats3,
    Ints1,
    check_names,
    column,
    compiled_type,
    several,
    within,
)
from fuzzy.compiled.jit import NotCompiledError, fingerprint, kernel, types, without_refcounts
from fuzzy.compiled.packed import packed_work
from fuzzy.naming import check_known
from fuzzy.quantity import described, quantity
from robotics.laws.knowledge import (
    AUTO,
    ESTIMATOR,
    LEAD,
    SAFE,
    SMOOTH,
    Estimator,
    KnowledgeColumns,
    Lead,
    Safe,
    SmoothedColumns,
    read_ahead,
    share_of,
    smooth_correction,
)
from robotics.laws.law import Command, ControllerError, Law, Observation
from robotics.laws.setting import Setting
from robotics.world.paths.references import Reference
from robotics.world.paths.road import Road
from robotics.world.radio.channel import AirColumns
from robotics.world.radio.channel import HeardColumns as HeardColumns
from robotics.world.vehicle.plant import MotionColumns, velocity_limits


class RobotColumns(Columns):
    """What a robot knows of itself."""

    x = column("m", "measured")
    y = column("m", "measured")
    heading = column("rad", "measured; need not be wrapped")
    v = column("m/s", "by the encoders over the last period")
    w = column("rad/s", "by the encoders over the last period")


class AimColumns(MotionColumns):
    """Where a robot shall be now, and how fast."""

    s = column("m", "how far along its path")


class SeenColumns(Columns):
    """What a robot knows of itself, and the reference of the setting."""

    robot = within(RobotColumns)
    aim = within(AimColumns)


class CommandColumns(Columns):
    """What a law commands: the target is the setting's reference, the rest not-a-number or 0, unless it is written."""

    first = column("", "as the fields of Command")
    second = column("")
    wish_v = column("m/s")
    wish_w = column("rad/s")
    target = within(AimColumns)
    progress = column("1")
    mode = column("", "an index of robotics.laws.modes.MODES")
    guarded = column("", "1: the emergency rule acted")
    refused = column("", "1: there is no safe way")


class WrittenColumns(CommandColumns):
    """The same with all that the equation of any law writes."""

    values = several(0, "", "of the message; after them the inputs of the rule bases")


class Known(NamedTuple):
    """All that the equation of a law may read."""

    time: float  # s
    dt: float  # s, the control period
    seen: Floats2  # (SeenColumns, lanes)
    heard: Floats3  # (HeardColumns and values, lanes, robots): what each lane heard of each robot of its run
    ranges: Floats2  # (sensors, lanes) m: what the range sensors of EquationLaw.reads read, in their order
    road: Road  # the paths and their timing
    path: Ints1  # (lanes,): the lane's path on the road
    column: Ints1  # (lanes,): the lane's column of the gains
    gains: Floats2  # (gains, columns)
    base: Ints1  # (lanes,): the lane's row of the rule bases
    rules: Floats2  # (rows, numbers): packed rule bases, one after the other
    table: Ints1  # (lanes,): the lane's row of the tables
    tables: Floats2  # (rows, numbers): of EquationLaw.tables


EQUATION_TYPE = types.void(
    types.int64, types.int64, compiled_type(Known), types.float64[:, ::1], types.float64[:, ::1], types.float64[::1]
)
# What an equation may ask for, and what it is given
ARGUMENTS = {
    "robot": "Seen(known.seen, lane).robot",  # RobotColumns
    "aim": "Seen(known.seen, lane).aim",  # AimColumns
    "gain": "Gain(known.gains, known.column[lane])",  # the law's fields that are numbers, and EquationLaw.derived
    "memory": "Memory(memory, lane)",  # EquationLaw.remembers
    "command": "Out(command, lane)",  # CommandColumns, the message as ``say``, and the rule bases' ``inputs``
    "work": "Work(work)",  # EquationLaw.works: numbers without a meaning before or after
    "known": "known",  # Known, as a whole
    "lane": "lane",
    "i": "lane",
    "time": "known.time",  # s
    "dt": "known.dt",  # s
    "road": "known.road",
    "path": "known.path[lane]",  # the lane's path on the road
    "rules": "known.rules[known.base[lane]]",  # the packed rule bases, one after the other
    "table": "known.tables[known.table[lane]]",  # what the law knows before the start of the lane's run
}
_LOOP = """
def each(first, last, known, memory, command, work):
    givens, kept = known.gains[len(known.gains) - {given} :], memory[len(memory) - {smoothed} :]
    for lane in range(first, last):
        given, reference = Given(givens, known.column[lane]), Seen(known.seen, lane).aim
        at_v, at_w = reference.v, reference.w
        if given.lead > 0:
            read_ahead(reference, known.road, known.path[lane], known.time + given.lead)
        {call}
        if given.share < 1:
            smooth_correction(Sent(command, lane), reference, given.share, given.limit, Smoothed(kept, lane))
        reference.v, reference.w = at_v, at_w
"""
_RETURNED = """v, w = {call}
        out = Out(command, lane)
        out.first, out.second, out.wish_v, out.wish_w = v, w, v, w"""


class Equation:
    """The equation of one robot; read of the class of its law it is the loop over all robots.

    ``function`` is what it was made of.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        self.function = function
        self.asks = tuple(inspect.signature(function).parameters)
        for name in self.asks:
            check_known(name, ARGUMENTS, "argument of an equation", ControllerError, where=function.__name__)
        self._one = kernel(nogil=True, _nrt=False, inline="always")(function)
        self._loops: dict[Any, Any] = {}  # of each class that gave it to a law, and each layout of memory and work

    def __get__(self, law: Any, owner: Any) -> Any:
        home = vars(giver(owner, self))
        if "equation" in home.get("__annotations__", {}) and "__dataclass_fields__" not in home:
            return self  # it is the decorator that reads it, before there are fields
        key = giver(owner, self), *(of.layout[1] for of in (owner.remembers, command_columns(owner), owner.works))
        if key not in self._loops:
            self._loops[key] = self._loop(owner)
        return self._loops[key]

    def check(self, law: "type[EquationLaw]") -> None:
        """Look at the columns that it names; raises ColumnError."""
        own = (vars(c).get("__annotations__", {}) for c in law.__mro__ if c not in EquationLaw.__mro__)
        names = [name for said in own for name, kind in said.items() if get_origin(kind) is not ClassVar]
        gains = Columns.named(f"{law.__name__}.gain", dict.fromkeys(names, Column()) | dict(law.derived.columns))
        known: dict[str, type[Columns]] = {"robot": RobotColumns, "aim": AimColumns, "gain": gains}
        known |= {"memory": law.remembers, "work": law.works, "command": command_columns(law)}
        check_names(self.function, known)

    def _loop(self, law: "type[EquationLaw]") -> Any:
        call = f"one({', '.join(ARGUMENTS[name] for name in self.asks)})"
        rows = {"given": KnowledgeColumns.size, "smoothed": SmoothedColumns.size}
        source = _LOOP.format(**rows, call=call if "command" in self.asks else _RETURNED.format(call=call))
        space: dict[str, Any] = {
            "one": self._one,
            "Seen": SeenColumns,
            "Gain": gain_columns(giver(law, self)),
            "Memory": law.remembers,
            "Out": command_columns(law),
            "Work": law.works,
            "Sent": CommandColumns,  # with which all commands begin: one type, compiled once for all laws
            "Given": KnowledgeColumns,
            "Smoothed": SmoothedColumns,
            "read_ahead": read_ahead,
            "smooth_correction": smooth_correction,
            equation.__name__: equation,  # by which the cache on disk knows that the loop is still there
        }
        exec(compile(source, __file__, "exec"), space)
        each = space["each"]
        each.__module__, each.__qualname__ = __name__, f"{equation.__name__}.<locals>.each"
        return without_refcounts(each)


def giver(law: type, equation: Equation) -> Any:
    """The class that gave a law its equation, whose columns it reads: a derived law may have fields of its own."""
    return next((c for c in law.__mro__ if any(v is equation for v in vars(c).values())), law)


def equation(law: Callable[..., Any]) -> Any:
    """Make the equation of a law of a function of one robot, whose arguments are some of :data:`ARGUMENTS`.

    Raises ControllerError for an argument that is none of them.
    """
    return Equation(law)


_IN_THE_LOOP = ("lead", "smooth")  # what is done about the equation; the estimator is before it
# Of every law with an equation, no gains of the equation itself
KNOWLEDGE_FIELDS = (*_IN_THE_LOOP, "estimator", "safe")
_hints_of = cache(get_type_hints)  # of a law's class; it takes longer than a law's numbers


@cache
def gain_columns(law: "type[EquationLaw]") -> type[Columns]:
    """The numbers of a law that its equation reads as ``gain``: fields of its dataclass, and those of ``derived``.

    A field that is one of some words is its place among them, and one that is such a law has that law's.
    """
    hints, found = _hints_of(law), {}
    for field in fields(law):
        kind = hints[field.name]
        if field.name in KNOWLEDGE_FIELDS:
            continue
        if kind in (float, int, bool) or get_origin(kind) is Literal:
            found[field.name] = column(field.metadata.get("unit", ""))
        elif isinstance(kind, type) and issubclass(kind, EquationLaw):
            found[field.name] = within(gain_columns(kind))
    return Columns.named(f"{law.__qualname__}.gain", found | dict(law.derived.columns))


@cache
def command_columns(law: "type[EquationLaw]") -> type[Columns]:
    """What the equation of a law writes as ``command``."""
    more = {"say": within(law.says), "inputs": several(0)}
    return CommandColumns.named(f"{law.__qualname__}.command", more)


@cache
def compiled(each: Any) -> Any:
    """The machine code of an equation's loop, which then takes the types of EQUATION_TYPE only.

    Raises ControllerError where the equation calls a function of Python.
    """
    try:
        return pointed(each, EQUATION_TYPE.args)
    except NotCompiledError as error:
        raise ControllerError(str(error)) from None


@cache
def pointed(function: Any, kinds: tuple[Any, ...]) -> Any:
    """The machine code of a function that others call by a pointer: it then takes arguments of ``kinds`` only."""
    if not hasattr(function, "compile"):  # NUMBA_DISABLE_JIT
        return function
    with _ONE_AT_A_TIME:
        if not function.signatures:
            # A pointer is found by its function's name, which several have: the loops of all equations, say.
            function.py_func.__qualname__ += f"_{fingerprint(function)[:16]}"
            function.compile(kinds)
            function.disable_compile()
            (only,) = function.overloads.values()
            function.get_compile_result = lambda signature: only  # at each call Numba would hash all types for it
            only.library.get_pointer_to_function = cache(only.library.get_pointer_to_function)  # and ask LLVM for it
    return function


_ONE_AT_A_TIME = Lock()  # several threads may want the same machine code first


class Setup(NamedTuple):
    """What the equation of a law reads and does not change while a simulation goes on."""

    road: Road
    path: np.ndarray
    column: np.ndarray
    gains: np.ndarray
    base: np.ndarray
    rules: np.ndarray
    table: np.ndarray
    tables: np.ndarray


class Memory(NamedTuple):
    """The memory of a law with an equation, from one period to the next."""

    setup: Setup
    rows: np.ndarray  # (numbers, runs * robots)
    reads: tuple[str, ...]  # the range sensors that the equation is told of


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class EquationLaw(Law[Memory]):
    """A law whose command is an equation of one robot; a derived class is a frozen dataclass of gains, as any law.

    It gives :attr:`equation`; where it remembers something, :attr:`remembers` too. What it is given beside its errors,
    :mod:`robotics.laws.knowledge` tells: None is what the scenario says.

    Raises:
        ControllerError: A lead or a low-pass of a law that cannot have it (:attr:`barred`), or of a part of a law.
    """

    lead: Lead | None = quantity(None, **LEAD)
    smooth: float | None = quantity(None, **SMOOTH)
    estimator: Estimator | None = quantity(None, **ESTIMATOR)
    safe: Safe = described(SAFE, "")

    def __post_init__(self) -> None:
        super().__post_init__()
        self.check_knowledge()

    def check_knowledge(self) -> None:
        """Raise ControllerError for a lead or a low-pass that this law, or one of its parts, cannot have."""
        for name in KNOWLEDGE_FIELDS:
            if name != "safe" and getattr(self, name) and (why := self.barred.get(name)):
                raise ControllerError(f"{name} is nothing for {type(self).__name__}: {why}").about(name)
        for part in fields(self):
            held = getattr(self, part.name, None)
            if isinstance(held, EquationLaw):
                for name in KNOWLEDGE_FIELDS:
                    if getattr(held, name) not in (None, ""):
                        raise ControllerError(f"{name} belongs to {type(self).__name__}, not to its part {part.name}")

    def __init_subclass__(cls) -> None:
        """Drive by a derived class's own ``control`` where it has one, and not by the equation that it inherits."""
        super().__init_subclass__()
        if taken := set(KNOWLEDGE_FIELDS) & {*vars(cls).get("__annotations__", {})}:
            raise TypeError(f"{cls.__name__}.{min(taken)}: every law has a gain of that name; call this one otherwise")
        own = vars(cls)
        for value in own.values():
            if isinstance(value, Equation):
                value.check(cls)
        if "control" in own and "equation" not in own and "has_equation" not in own:
            cls.has_equation = False

    equation: ClassVar[Any]  # of :func:`equation`
    derived: ClassVar[type[Columns]] = Columns  # what the equation reads beside the gains: see :meth:`derive`
    remembers: ClassVar[type[Columns]] = Columns
    works: ClassVar[type[Columns]] = Columns
    says: ClassVar[type[Columns]] = Columns  # the message
    has_equation: ClassVar[bool] = True  # False: it is driven by its ``control``, as a law without an equation
    aims: ClassVar[bool] = False  # whether its target is another than the setting's reference
    progresses: ClassVar[bool] = False  # whether it has a path parameter of its own
    has_modes: ClassVar[bool] = False
    guards: ClassVar[bool] = False  # whether an emergency rule is below it, which writes ``guarded``
    may_refuse: ClassVar[bool] = False

    @property
    def barred(self) -> Mapping[str, str]:
        """Why it can have no lead or no low-pass, by "lead" and "smooth"."""
        found = {}
        if not self.has_equation:
            return dict.fromkeys(_IN_THE_LOOP, "it drives by a control of its own, in Python")
        if self.aims or (self.knows and "reference velocity" not in self.knows):
            found["lead"] = "it does not drive by the velocity of the reference at the present time"
        if self.level == "torque":
            found["smooth"] = "it commands torques, of which no feed-forward is known"
        elif self.aims or self.yields or self.may_refuse:
            found["smooth"] = "a low-pass would delay its braking"
        return found

    def knowledge_rows(self, setting: Setting) -> list[Any]:
        """The numbers of :class:`KnowledgeColumns`: what the law says, or else the setting, where it is able to."""
        self.check_knowledge()  # a derived class may have a __post_init__ of its own
        told = setting.knowledge
        ahead, constant = (
            getattr(self if getattr(self, name) is not None else told, name) if name not in self.barred else 0.0
            for name in _IN_THE_LOOP
        )
        ahead = setting.auto_lead(self.level) if ahead == AUTO else ahead
        return [ahead, share_of(constant, setting.period), *velocity_limits(setting.robots)]

    def derive(self, setting: Setting) -> Mapping[str, Any]:
        """The numbers of :attr:`derived` by name: each a number, (robots,) or (runs, robots)."""
        return {}

    def gain_rows(self, setting: Setting) -> Sequence[Any]:
        """The numbers that the equation reads as ``gain``, in the order of :func:`gain_columns`."""
        law = giver(type(self), inspect.getattr_static(self, "equation"))
        hints, found = _hints_of(law), dict(self.derive(setting))
        for name in gain_columns(law).columns:
            if name not in found:
                value = getattr(self, name)
                if get_origin(hints[name]) is Literal:
                    value = get_args(hints[name]).index(value)
                found[name] = value.gain_rows(setting) if isinstance(value, EquationLaw) else float(value)
        return gain_columns(law).stacked(found)

    def gain_array(self) -> np.ndarray:
        """The same as a column (numbers, 1), of a law that reads nothing of its setting."""
        return np.array(self.gain_rows(cast(Setting, None)), dtype=float)[:, None]

    @property
    def message(self) -> tuple[str, ...]:
        """The names of the values that each robot broadcasts."""
        return self.says.leaves()

    def rule_rows(self) -> Sequence[np.ndarray]:
        """The packed rule bases that the equation reads as a row of ``known.rules``."""
        return ()

    def reads(self, setting: Setting) -> tuple[str, ...]:
        """The names of the range sensors that the equation is told of as ``known.ranges``, in their order."""
        return self.needs

    def tables(self, setting: Setting) -> np.ndarray:
        """What the equation knows before the start as ``table``: a row for each run, or one for all."""
        return np.empty((1, 0))

    def begin(self, setting: Setting, runs: int) -> np.ndarray:
        """The memory (numbers, runs, robots) at the start. Raises ControllerError where it cannot drive ``setting``."""
        return np.zeros((self.remembers.size, runs, len(setting.robots)))

    def setup(self, setting: Setting, runs: int) -> Setup:
        """All that the equation reads and does not change; raises as :meth:`begin`."""
        robots = len(setting.robots)
        road, lanes = setting.references.road, np.arange(runs * robots)
        flat = [np.ravel(row) for row in (*self.gain_rows(setting), *self.knowledge_rows(setting))]
        width = max(len(row) for row in flat)
        gains = np.empty((len(flat), width))
        for row, values in zip(gains, flat, strict=True):
            row[...] = values if len(values) in (1, width) else np.resize(values, width)
        rules = np.concatenate([np.empty(0), *self.rule_rows()])[None]
        tables = self.tables(setting)
        table = lanes // robots % len(tables)
        return Setup(road, lanes % len(road.lengths), lanes % width, gains, np.zeros_like(lanes), rules, table, tables)

    def init(self, setting: Setting, runs: int) -> Memory:
        """Return its memory at the start of ``runs`` runs. Raises ControllerError where it cannot drive ``setting``."""
        rows = self.begin(setting, runs)
        lanes = runs * len(setting.robots)
        rows = np.asarray(rows, dtype=float).reshape(len(rows), lanes)
        kept = np.concatenate([rows, SmoothedColumns.zeros(lanes).array])
        return Memory(self.setup(setting, runs), kept, self.reads(setting))

    def control(self, seen: Observation, memory: Memory, dt: float) -> tuple[Command, Memory]:
        """Return its command for what the robots have ``seen``, and its new memory, ``dt`` seconds after the last."""
        if not isinstance(memory, Memory):
            raise ControllerError(
                f"{type(self).__name__}.control needs the memory that its init(setting, runs) gave; got "
                f"{type(memory).__name__}"
            )
        runs, robots = seen.x.shape
        rows = np.empty((SeenColumns.size, runs, robots))
        for row, of in zip(rows, (*seen[1:6], *seen.reference), strict=True):
            row[...] = of
        heard = np.empty((AirColumns.size + len(seen.heard.fields), runs * robots, robots))
        planes = AirColumns(heard)
        if seen.heard.fields:
            planes.age = seen.heard.age.reshape(heard.shape[1:])
            planes.hears = np.tile(seen.heard.hears, (runs, 1))
            planes.values[...] = seen.heard.values.reshape(-1, *heard.shape[1:])
        else:
            planes.age, planes.hears = np.inf, 0.0
        lanes = rows.reshape(len(rows), -1)
        ranges = np.full((len(memory.reads), runs * robots), np.inf)
        if seen.ranges is not None:
            ranges[...] = seen.ranges.of(memory.reads).reshape(runs * robots, -1).T
        known = Known(float(seen.time), float(dt), lanes, heard, ranges, *memory.setup)
        command = fresh_commands(lanes, self)
        after = memory.rows.copy()
        work = np.empty(self.working_for(robots, len(memory.reads)))
        compiled(type(self).equation)(0, runs * robots, known, after, command, work)
        return self.commanded(command.reshape(-1, runs, robots)), memory._replace(rows=after)

    @cached_property
    def working(self) -> int:
        """How many numbers the equation works in: its own, and those in which its rule bases are evaluated."""
        return self.works.size + max((packed_work(rules) for rules in self.rule_rows()), default=0)

    def working_for(self, robots: int, sensors: int) -> int:
        """The same where so many ``robots`` of a run and range ``sensors`` each need some of them."""
        return self.working

    def commanded(self, rows: np.ndarray) -> Command:
        """The rows (rows, runs, robots) that the equation has written, as a command."""
        out, said = WrittenColumns(rows), len(self.message)
        message: Mapping[str, np.ndarray] | None = dict(zip(self.message, out.values[:said], strict=True)) or None
        return Command(
            out.first,
            out.second,
            out.wish_v,
            out.wish_w,
            message,
            Reference(*out.target.array) if self.aims else None,
            out.progress if self.progresses else None,
            out.refused[:, 0] > 0 if self.may_refuse else None,
            out.mode.astype(int) if self.has_modes else None,
            out.values[said:] if self.rule_inputs else None,
            out.guarded > 0 if self.guards else None,
        )


def fresh_commands(seen: np.ndarray, law: Law[Any]) -> np.ndarray:
    """Commands (rows, lanes) before a ``law`` writes them, by what is ``seen`` (SeenColumns, lanes)."""
    rows = np.zeros((CommandColumns.size + len(law.message) + law.rule_inputs, seen.shape[1]))
    out = CommandColumns(rows)
    out.target = SeenColumns(seen).aim
    out.progress = np.nan
    return rows
