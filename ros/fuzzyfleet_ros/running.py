"""How a node of this package runs: until it is done or told to end, and every bad input is one sentence and exit 2."""

import gc
import signal
import sys
import warnings
from collections.abc import Callable, Sequence
from typing import Any, Protocol

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions

from fuzzy.errors import InputError

_LOOK = 0.1  # s from one look at whether it shall end to the next


class Runs(Protocol):
    """A node as :func:`run` needs it."""

    done: bool  # it has nothing more to do

    def leave(self) -> None:
        """Do the last things, while messages can still be sent. It may raise InputError."""
        ...

    def destroy_node(self) -> Any:
        """Destroy it."""
        ...


def run(make: Callable[[], Runs], program: str, arguments: Sequence[str] | None = None) -> int:
    """Run the node that ``make`` returns until it is done, or a signal says so; return the exit status.

    Args:
        make: Makes the node, after rclpy is initialised. It may raise InputError.
        program: Its name, in front of a sentence about what is wrong.
        arguments: With the program's name first, as ``sys.argv``.
    """
    try:
        rclpy.init(
            args=list(arguments) if arguments is not None else None, signal_handler_options=SignalHandlerOptions.NO
        )
    except Exception as error:  # what rclpy raises for arguments after --ros-args is not one kind
        print(f"{program}: {_line(error)}", file=sys.stderr)
        return 2

    def show(message: Warning | str, *others: object, **more: object) -> None:
        print(f"{program}: {message}", file=sys.stderr)

    told: list[int] = []
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda number, frame: told.append(number))
    node = None
    try:
        with warnings.catch_warnings():
            warnings.showwarning = show
            node = make()
            executor = SingleThreadedExecutor()
            executor.add_node(node)
            gc.collect()
            gc.freeze()  # what is there now stays; to look through it again takes longer than two periods
            try:
                while not told and not node.done:
                    executor.spin_once(timeout_sec=_LOOK)
            finally:
                node.leave()
    except InputError as error:
        print(f"{program}: {_line(error)}", file=sys.stderr)
        return 2
    finally:
        if node is not None:
            node.destroy_node()
        rclpy.try_shutdown()
    return 0


def _line(error: Exception) -> str:
    return " ".join(str(error).split())
