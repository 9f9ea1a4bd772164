"""Laws that are not of this package: what they raise and return becomes one sentence with their file and line.

In Python the sentence is raised from what the law raised, whose traceback stays whole.
"""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from fuzzy.errors import InputError
from fuzzy.files.pythonfile import told
from robotics.laws.law import Command, ControllerError, Law, Observation
from robotics.laws.setting import Setting

_OWN = __name__.partition(".")[0] + "."  # with which the modules of this package begin
_ARRAYS = ("first", "second", "v", "w", "progress", "mode")  # of a command, (runs, robots) each


def is_foreign(law: type[Law[Any]]) -> bool:
    """Whether a law's class is not of this package."""
    return not law.__module__.startswith(_OWN)


@contextmanager
def telling_errors(law: type[Law[Any]], what: str) -> Iterator[None]:
    """Turn what a foreign law raises in this block into a ControllerError, a sentence with the law's file and line.

    An InputError, and all that a law of this package raises, goes on as it is.

    Args:
        law: The law's class.
        what: What is done in the block, such as "control".
    """
    try:
        yield
    except InputError:
        raise
    except Exception as error:  # a law of the user's may raise anything
        if not is_foreign(law):
            raise
        place = _place(law)
        sentence = f"{told(error, place, Path(place).name)} (in {what} of the law {law.__name__})"
        raise ControllerError(sentence) from error


def checked_init(law: Law[Any], setting: Setting, runs: int) -> Any:
    """The memory with which a law begins, of :meth:`Law.init`. Raises ControllerError where a foreign law fails."""
    with telling_errors(type(law), "init"):
        return law.init(setting, runs)


def checked_control(law: Law[Any], seen: Observation, memory: Any, dt: float) -> tuple[Command, Any]:
    """The command and the new memory, of :meth:`Law.control`.

    Raises ControllerError where a foreign law fails, or returns something else.
    """
    if not is_foreign(type(law)):
        return law.control(seen, memory, dt)
    with telling_errors(type(law), "control"):
        returned: Any = law.control(seen, memory, dt)
    if not (isinstance(returned, tuple) and len(returned) == 2 and isinstance(returned[0], Command)):
        raise _wrong(law, f"must return a Command and its memory; got {type(returned).__name__}")
    command, shape = returned[0], seen.x.shape
    for name in _ARRAYS:
        value = getattr(command, name)
        if value is None and name in ("progress", "mode"):
            continue
        if not _fits(value, shape):
            got = f"shape {np.shape(value)}" if isinstance(value, np.ndarray) else repr(value)
            raise _wrong(law, f"must return numbers (runs, robots) = {shape} as {name}; got {got}")
    return returned


def _fits(value: Any, shape: tuple[int, ...]) -> bool:
    """Whether a value is numbers that can be laid over ``shape``."""
    try:
        return np.broadcast_shapes(np.shape(value), shape) == shape and np.asarray(value).dtype.kind in "fiub"
    except ValueError:
        return False


def _wrong(law: Law[Any], what: str) -> ControllerError:
    return ControllerError(f"{Path(_place(type(law))).name}: control of the law {type(law).__name__} {what}")


def _place(law: type[Law[Any]]) -> str:
    return getattr(sys.modules.get(law.__module__), "__file__", None) or law.__module__
