"""A law's equation: one compiled function of one robot, and what it may read and write.

A law that has one is written once, for one robot, in scalars. Everything else is made of it: the loop over all robots,
that the compiled simulation calls through a pointer, and :meth:`EquationLaw.control` for arrays. All arrays are
columns, a lane after the other; a lane is one robot of one run, and no lane reads what another one writes in the same
period.

    @equation
    def law(i, known, memory, command, work):
        g = known.column[i]
        command[FIRST, i] = known.gains[0, g] * known.seen[AT_V, i]
        ...

It is compiled once in an installation, found on disk by the next process, and compiled anew when it, or anything that
it calls, has changed (:mod:`fuzzy.compiled.jit`).
"""

from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from threading import Lock
from typing import Any, ClassVar, NamedTuple

import numpy as np

from fuzzy.compiled.jit import fingerprint, kernel, types, uncounted
from robotics.laws.law import Command, ControllerError, Law, Observation
from robotics.laws.setting import Setting
from robotics.paths.references import References
from robotics.paths.road import Road
from robotics.paths.trajectory import Reference
from robotics.radio.channel import AGE, HEARD, HEARS

# Rows of Known.seen: the posture as measured, the velocity by the encoders, and the reference of the setting.
X, Y, HEADING, V, W = range(5)  # m, m, rad, m/s, rad/s
AT_X, AT_Y, AT_HEADING, AT_V, AT_W, AT_S = range(5, 11)  # m, m, rad, m/s, rad/s, m
SEEN = 11
# Rows of a command. The target is the setting's reference, and the rest not-a-number or 0, unless the law writes them.
FIRST, SECOND, WISH_V, WISH_W = range(4)  # as the fields of Command
TO_X, TO_Y, TO_HEADING, TO_V, TO_W, TO_S = range(4, 10)  # the target
PROGRESS, MODE, GUARDED, REFUSED = range(10, 14)
SAYS = 14  # the first value of the message; after the last one come the inputs of the rule bases


class Known(NamedTuple):
    """All that the equation of a law may read."""

    time: float  # s
    dt: float  # s, the control period
    seen: np.ndarray  # (SEEN, lanes)
    heard: np.ndarray  # (HEARD + values, lanes, robots): what each lane heard of each robot of its run
    ranges: np.ndarray  # (sensors, lanes) m: what the range sensors of Law.needs read, in their order
    road: Road  # the paths and their timing
    path: np.ndarray  # (lanes,) int: the lane's path on the road
    column: np.ndarray  # (lanes,) int: the lane's column of the gains
    gains: np.ndarray  # (gains, columns)
    base: np.ndarray  # (lanes,) int: the lane's row of the rule bases
    rules: np.ndarray  # (rows, numbers): packed rule bases, one after the other


_F1, _F2, _F3 = types.float64[::1], types.float64[:, ::1], types.float64[:, :, ::1]
_I1, _I, _F = types.int64[::1], types.int64, types.float64
ROAD_TYPE = types.NamedTuple((_F2, _I1, _I1, _F1, _I, _F1, _F1, _F3, _F2, _F2, _F), Road)
KNOWN_TYPE = types.NamedTuple((_F, _F, _F2, _F3, _F2, ROAD_TYPE, _I1, _I1, _F2, _I1, _F2), Known)
EQUATION_TYPE = types.void(_I, _I, KNOWN_TYPE, _F2, _F2, _F1)


def equation(law: Callable[..., None]) -> Any:
    """Compile the equation of one robot, ``law(lane, known, memory, command, work)``, into the loop over all robots.

    ``memory`` (numbers, lanes) is what the law remembers, ``command`` the rows above, and ``work`` a row of numbers to
    work in, whose content has no meaning before or after.
    """
    one = kernel(nogil=True, _nrt=False, inline="always")(law)

    @uncounted
    def each(first, last, known, memory, command, work):  # type: ignore[no-untyped-def]
        for lane in range(first, last):
            one(lane, known, memory, command, work)

    return each


@cache
def compiled(each: Any) -> Any:
    """The machine code of an equation's loop, which then takes the types of EQUATION_TYPE only."""
    if not hasattr(each, "compile"):  # NUMBA_DISABLE_JIT
        return each
    with _ONE_AT_A_TIME:
        if each.signatures:
            return each
        # The pointer to the loop is found by its name, and all equations' loops have the same one but for this.
        each.py_func.__qualname__ = f"equation.<locals>.each_{fingerprint(each)[:16]}"
        each.compile(EQUATION_TYPE.args)
        each.disable_compile()
    return each


_ONE_AT_A_TIME = Lock()  # several threads may want the same machine code first


class Setup(NamedTuple):
    """What the equation of a law reads and does not change while a simulation goes on."""

    road: Road
    path: np.ndarray
    column: np.ndarray
    gains: np.ndarray
    base: np.ndarray
    rules: np.ndarray


class Memory(NamedTuple):
    """The memory of a law with an equation, from one period to the next."""

    setup: Setup
    rows: np.ndarray  # (numbers, runs * robots)


class EquationLaw(Law[Memory]):
    """A law whose command is an equation of one robot; a derived class is a frozen dataclass of gains, as any law.

    It gives :attr:`equation`, and :meth:`gain_rows`; where it remembers something, :meth:`begin` too.
    """

    def __init_subclass__(cls) -> None:
        """Drive by a derived class's own ``control`` where it has one, and not by the equation that it inherits."""
        super().__init_subclass__()
        own = vars(cls)
        if "control" in own and "equation" not in own and "has_equation" not in own:
            cls.has_equation = False

    equation: ClassVar[Any]  # of :func:`equation`
    has_equation: ClassVar[bool] = True  # False: it is driven by its ``control``, as a law without an equation
    aims: ClassVar[bool] = False  # whether its target is another than the setting's reference
    progresses: ClassVar[bool] = False  # whether it has a path parameter of its own
    has_modes: ClassVar[bool] = False
    may_refuse: ClassVar[bool] = False

    @abstractmethod
    def gain_rows(self, setting: Setting) -> Sequence[Any]:
        """The numbers that the equation reads as ``known.gains``: each a number, (robots,) or (runs, robots)."""

    def rule_rows(self) -> Sequence[np.ndarray]:
        """The packed rule bases that the equation reads as a row of ``known.rules``."""
        return ()

    def drives_on(self, setting: Setting) -> References:
        """The paths and their timing that the equation reads as ``known.road``."""
        return setting.references

    def begin(self, setting: Setting, runs: int) -> np.ndarray:
        """The memory (numbers, runs, robots) at the start. Raises ControllerError where it cannot drive ``setting``."""
        return np.zeros((0, runs, len(setting.robots)))

    def setup(self, setting: Setting, runs: int) -> Setup:
        """All that the equation reads and does not change; raises as :meth:`begin`."""
        robots = len(setting.robots)
        road, lanes = self.drives_on(setting).road, np.arange(runs * robots)
        flat = [np.ravel(row) for row in self.gain_rows(setting)]
        width = max((len(row) for row in flat), default=1)
        gains = np.array([np.resize(row, width) for row in flat], dtype=float).reshape(-1, width)
        rules = np.concatenate([np.empty(0), *self.rule_rows()])[None]
        return Setup(road, lanes % len(road.lengths), lanes % width, gains, np.zeros_like(lanes), rules)

    def init(self, setting: Setting, runs: int) -> Memory:
        """Return its memory at the start of ``runs`` runs. Raises ControllerError where it cannot drive ``setting``."""
        rows = self.begin(setting, runs)
        rows = np.ascontiguousarray(rows, dtype=float).reshape(len(rows), runs * len(setting.robots))
        return Memory(self.setup(setting, runs), rows)

    def control(self, seen: Observation, memory: Memory, dt: float) -> tuple[Command, Memory]:
        """Return its command for what the robots have ``seen``, and its new memory, ``dt`` seconds after the last."""
        return self.by(type(self).equation, seen, memory, dt)

    def by(self, each: Any, seen: Observation, memory: Memory, dt: float) -> tuple[Command, Memory]:
        """Do as :meth:`control`, by an equation ``each`` that need not be the law's own."""
        if not isinstance(memory, Memory):
            raise ControllerError(
                f"{type(self).__name__}.control needs the memory that its init(setting, runs) gave; got "
                f"{type(memory).__name__}"
            )
        runs, robots = seen.x.shape
        rows = np.empty((SEEN, runs, robots))
        for row, of in zip(rows, (*seen[1:6], *seen.reference), strict=True):
            row[...] = of
        heard = np.empty((HEARD + len(seen.heard.fields), runs * robots, robots))
        if seen.heard.fields:
            heard[AGE] = seen.heard.age.reshape(heard.shape[1:])
            heard[HEARS] = np.tile(seen.heard.hears, (runs, 1))
            heard[HEARD:] = seen.heard.values.reshape(-1, *heard.shape[1:])
        else:
            heard[AGE], heard[HEARS] = np.inf, 0.0
        lanes = rows.reshape(SEEN, -1)
        ranges = np.full((len(self.needs), runs * robots), np.inf)
        if seen.ranges is not None:
            ranges[...] = seen.ranges.of(self.needs).reshape(runs * robots, -1).T
        known = Known(float(seen.time), float(dt), lanes, heard, ranges, *memory.setup)
        command = fresh_commands(lanes, SAYS + len(self.message) + self.rule_inputs)
        after = memory.rows.copy()
        compiled(each)(0, runs * robots, known, after, command, np.empty(self.working))
        return self.commanded(command.reshape(-1, runs, robots)), Memory(memory.setup, after)

    @property
    def working(self) -> int:
        """How many numbers the equation works in."""
        return 0

    def commanded(self, rows: np.ndarray) -> Command:
        """The rows (rows, runs, robots) that the equation has written, as a command."""
        first, inputs = SAYS, SAYS + len(self.message)
        message: Mapping[str, np.ndarray] | None = dict(zip(self.message, rows[first:inputs], strict=True)) or None
        return Command(
            rows[FIRST],
            rows[SECOND],
            rows[WISH_V],
            rows[WISH_W],
            message,
            Reference(*rows[TO_X : TO_S + 1]) if self.aims else None,
            rows[PROGRESS] if self.progresses else None,
            rows[REFUSED][:, 0] > 0 if self.may_refuse else None,
            rows[MODE].astype(int) if self.has_modes else None,
            rows[inputs:] if self.rule_inputs else None,
            None,
        )


def fresh_commands(seen: np.ndarray, rows: int) -> np.ndarray:
    """Commands (rows, lanes) before a law writes them, by what is ``seen`` (SEEN, lanes)."""
    command = np.zeros((rows, seen.shape[1]))
    command[TO_X : TO_S + 1] = seen[AT_X : AT_S + 1]
    command[PROGRESS] = np.nan
    return command
