"""How many random cases the dear tests with Hypothesis try: a third in `make test`, all in `make check-all`."""

import os

EVERY = "EVERY_RANDOM_CASE"  # the variable of the environment that asks for all


def cases(number: int) -> int:
    """The share of ``number`` that this run tries."""
    return number if EVERY in os.environ else number // 3
