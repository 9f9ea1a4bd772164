"""Observers: what looks at every period of a simulation, after the law has decided and before the robots move.

The recorder, the judge of stress tests, the reward of environments and whatever a user wants to know are observers of
one loop. An observer is a compiled function of a :class:`Moment` and of its own notes, which it writes in place:

    class Fastest(NamedTuple):
        speed: Floats1  # (lanes,) m/s

    @observer
    def fastest(moment, notes):
        for i in range(len(notes.speed)):
            notes.speed[i] = max(notes.speed[i], abs(TruthColumns(moment.truth, i).v))
        return False

It returns whether it wants to be asked something before the simulation goes on; most never do.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any, NamedTuple

from fuzzy.compiled.columns import Bools1, Floats2, Floats3, Ints1, check, compiled_type
from fuzzy.compiled.jit import kernel, types
from robotics.laws.equation import pointed
from robotics.simulation.lanes import Lanes


class Moment(NamedTuple):
    """A period as an observer sees it; a lane is one robot of one run, run after run."""

    k: int  # the period
    period: float  # s
    robots: int  # of a run
    values: int  # in a message
    every: int  # periods from message to message
    truth: Floats2  # (TruthColumns, lanes)
    seen: Floats2  # (SeenColumns, lanes)
    command: Floats2  # (CommandColumns, message and inputs, lanes)
    order: Floats2  # (2, lanes): the command after faults
    code: Ints1  # (lanes,): of robotics.world.radio.faults.FAULTS, or 0
    heard: Floats3  # (HeardColumns and values, lanes, robots)
    readings: Floats2  # (lanes, sensors) m
    stopped: Ints1  # (lanes,): the period in which the robot was stopped, or -1
    goes_on: Bools1  # (runs,): in a run that does not nobody looks, decides or moves any more; an observer may end it


def moment_of(lanes: Lanes, k: int) -> Moment:
    """Period ``k`` of ``lanes`` as an observer sees it."""
    one, air = lanes, lanes.air
    return Moment(
        k, one.period, one.robots, air.values, air.every, one.body.truth, one.known.seen, one.command, one.order,
        one.trouble.code, air.heard, one.readings, one.stopped, one.goes_on,
    )  # fmt: skip


def observer(watch: Callable[..., Any]) -> Any:
    """Compile a function of a moment and of notes, which returns whether it wants to be asked something."""
    return kernel(nogil=True)(watch)


@dataclass(frozen=True, eq=False)
class Observer:
    """A function of :func:`observer` and the notes that it writes.

    ``asked`` is called with the period in which the function has returned True; it returns the last period that is to
    be driven, or None, which changes nothing.
    """

    watch: Any
    notes: Any
    asked: Callable[[int], int | None] = lambda k: None

    def __post_init__(self) -> None:
        _check(self.notes)

    @cached_property
    def classes(self) -> Any:
        """The class of its notes, or of a :class:`Pair` those of both: they say the compiled types, and hash sooner."""
        return _classes(self.notes)

    @property
    def pointer(self) -> Any:
        """The machine code of its function."""
        return _pointer(self.watch, self.classes)

    def look(self, moment: Moment) -> bool:
        """Look at a moment, from Python; return whether it wants to be asked something."""
        return bool(self._entry(moment, self.notes))

    @cached_property
    def _entry(self) -> Any:
        code = self.pointer
        if not hasattr(code, "get_overload"):  # NUMBA_DISABLE_JIT
            return code
        return code.get_overload(watch_type(self.classes).args)  # which takes parts of larger arrays, too

    def beside(self, other: "Observer") -> "Observer":
        """An observer that is both."""

        def asked(k: int) -> int | None:
            ends = [end for end in (self.asked(k), other.asked(k)) if end is not None]
            return min(ends, default=None)

        return Observer(_both(self.watch, other.watch), Pair(self.notes, other.notes), asked)


class Pair(NamedTuple):
    """The notes of two observers, of whatever class: machine code on disk is found again by classes with a name."""

    first: Any
    second: Any


def _check(notes: Any) -> None:
    if isinstance(notes, Pair):
        _check(notes.first)
        _check(notes.second)
    else:
        check(notes)


def _classes(notes: Any) -> Any:
    return (_classes(notes.first), _classes(notes.second)) if isinstance(notes, Pair) else type(notes)


@cache
def noted_type(classes: Any) -> Any:
    """The compiled type of notes of ``classes``."""
    if isinstance(classes, tuple):
        return types.NamedTuple(tuple(map(noted_type, classes)), Pair)
    return compiled_type(classes)


@cache
def watch_type(classes: Any) -> Any:
    """The compiled type of an observer's function whose notes are of ``classes``."""
    return types.boolean(compiled_type(Moment), noted_type(classes))


@cache
def _pointer(watch: Any, classes: Any) -> Any:
    return pointed(watch, watch_type(classes).args)


@cache
def _both(first: Any, second: Any) -> Any:
    @observer
    def both(moment, notes):  # type: ignore[no-untyped-def]
        one, other = first(moment, notes.first), second(moment, notes.second)
        return one or other

    return both
