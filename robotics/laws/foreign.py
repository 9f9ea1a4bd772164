"""Laws that are not of this package: what they raise and return becomes one sentence with their file and line.

In Python the sentence is raised from what the law raised, whose traceback stays whole.
"""

import sys
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


def error_in_law(law: type[Law[Any]], error: Exception, what: str) -> ControllerError:
    """What a law raised, as a sentence.

    Args:
        law: The law's class.
        error: What it raised.
        what: What failed, such as "control".
    """
    place = _place(law)
    return ControllerError(f"{told(error, place, Path(place).name)} (in {what} of the law {law.__name__})")


def checked_init(law: Law[Any], setting: Setting, runs: int) -> Any:
    """The memory with which a law begins, of :meth:`Law.init`. Raises ControllerError where a foreign law fails."""
    try:
        return law.init(setting, runs)
    except InputError:
        raise
    except Exception as error:
        if not is_foreign(type(law)):
            raise
        raise error_in_law(type(law), error, "init") from error


def checked_control(law: Law[Any], seen: Observation, memory: Any, dt: float) -> tuple[Command, Any]:
    """The command and the new memory, of :meth:`Law.control`.

    Raises ControllerError where a foreign law fails, or returns something else.
    """
    if not is_foreign(type(law)):
        return law.control(seen, memory, dt)
    try:
        returned: Any = law.control(seen, memory, dt)
    except InputError:
        raise
    except Exception as error:
        raise error_in_law(type(law), error, "control") from error
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
