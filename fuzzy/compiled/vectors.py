"""How wide the vectors are that a compiled loop may use."""

from collections.abc import Callable
from typing import Any

from numba import types
from numba.core.extending import intrinsic, overload


def wide_vectors() -> None:
    """Ask for vectors of 512 bits where the CPU has them, in the compiled function that calls this.

    LLVM keeps to 256 bits on most CPUs of Intel that have 512, because a few wide instructions would slow down all
    others beside them. Loops that are nothing else take two thirds of the time (Cascade Lake), and give the same bits.
    """


@intrinsic
def _ask(_context: Any) -> Any:
    def ask(context: Any, builder: Any, _signature: Any, _arguments: Any) -> Any:
        # llvmlite knows few attributes by name and refuses others: this one is LLVM's, for x86.
        set.add(builder.function.attributes, '"prefer-vector-width"="512"')
        return context.get_dummy_value()

    return types.void(), ask


@overload(wide_vectors, inline="always")  # into the function itself: the attribute is one of functions
def _compiled() -> Callable[[], None]:
    return lambda: _ask()  # type: ignore[call-arg]  # Numba gives the context
