"""Ctrl-C and SIGTERM in a command line: both stop what is being done, are said in one sentence, and lose nothing.

Within :func:`answered` both raise KeyboardInterrupt in the main thread. Who keeps what is done catches it, and ends
with :func:`interrupted`.
"""

import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import NoReturn

import typer

INTERRUPTED = 130  # the exit status after SIGINT: 128 + 2
TERMINATED = 143  # the exit status after SIGTERM: 128 + 15
_AGAIN = 0.05  # s after which an interrupt that was swallowed is raised once more


class _Answers:
    """What has come, and whether it was said."""

    def __init__(self) -> None:
        self.number = signal.SIGINT  # the last signal that came
        self.came = self.told = False
        self.prefix = ""


_answers = _Answers()


@contextmanager
def answered(name: str = "") -> Iterator[None]:
    """Answer Ctrl-C and SIGTERM in this block by a KeyboardInterrupt in the main thread.

    One that falls into a callback of a library, which can only drop it, is raised again. What is ignored stays ignored,
    and a handler of somebody else stays. Messages begin with ``name``, that of the program.
    """
    _answers.number, _answers.came, _answers.told = signal.SIGINT, False, False
    _answers.prefix = f"{name}: " if name else ""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    ours = {signal.SIGINT: signal.default_int_handler, signal.SIGTERM: signal.SIG_DFL}
    before = {number: handler for number, handler in ours.items() if signal.getsignal(number) == handler}
    hook = sys.unraisablehook
    sys.unraisablehook = lambda lost: _raised_again() if lost.exc_type is KeyboardInterrupt else hook(lost)
    for number in before:
        signal.signal(number, _stop)
    try:
        yield
    finally:
        sys.unraisablehook = hook
        for number, handler in before.items():
            if signal.getsignal(number) is _stop:
                signal.signal(number, handler)


def interrupted(message: str = "") -> NoReturn:
    """End a command that was interrupted, with one sentence on stderr that begins with "interrupted".

    Args:
        message: What is kept, and how to go on.
    """
    said = "interrupted" if _answers.number == signal.SIGINT else "interrupted by SIGTERM"
    print(_answers.prefix + said + (f"; {message}" if message else ""), file=sys.stderr)
    _answers.told = True
    raise typer.Exit(exit_code())


def exit_code() -> int:
    """The exit code of a command that was interrupted: 130 of Ctrl-C, 143 of SIGTERM."""
    return INTERRUPTED if _answers.number == signal.SIGINT else TERMINATED


def is_told() -> bool:
    """Whether :func:`interrupted` has said it."""
    return _answers.told


def of_interrupt(error: BaseException | None) -> bool:
    """Whether ``error`` was raised because of a KeyboardInterrupt, as by compiled code that translates it.

    After a signal, so is one of the operating system's that names no file: the signal ended our processes, too, and
    what is missing is a socket of theirs.
    """
    if _answers.came and isinstance(error, OSError) and error.filename is None:
        return True
    seen: set[int] = set()
    while error is not None and id(error) not in seen:
        if isinstance(error, KeyboardInterrupt):
            return True
        seen.add(id(error))
        error = error.__cause__ or error.__context__
    return False


def raise_interrupt(error: BaseException) -> None:
    """Raise KeyboardInterrupt if ``error`` was raised because of one: nothing else is wrong."""
    if of_interrupt(error):
        raise KeyboardInterrupt from error


def _stop(number: int, _: FrameType | None) -> None:
    _answers.number, _answers.came = signal.Signals(number), True
    raise KeyboardInterrupt


def _raised_again() -> None:
    timer = threading.Timer(_AGAIN, signal.raise_signal, (_answers.number,))
    timer.daemon = True
    timer.start()
