"""Scenarios with a new name: the old name still works in this release, with a warning."""

import warnings

NEW_NAMES = {  # by the old name
    "chapter-3": "ahead-and-behind",
    "chapter-4-circles": "concentric-circles",
    "chapter-4-crossing": "crossing-in-turn",
    "chapter-4-faults": "outage-10s",
    "chapter-4-faults-20": "outage-20s",
    "chapter-4-noise": "noisy-position",
    "chapter-5-test-1": "unequal-lengths",
    "chapter-5-test-2": "start-off-paths",
    "chapter-6-case-1": "wait-for-one",
    "chapter-6-case-2": "neighbour-stops",
    "chapter-6-case-3": "turn-towards-each-other",
    "chapter-6-case-4": "trap-u-middle",
    "chapter-6-experiment": "obstacles-on-outer-paths",
    "chapter-6-simulation-1": "obstacles-on-two-paths",
    "chapter-6-simulation-2": "turn-into-neighbour",
    "chapter-6-simulation-3": "trap-u",
    "chapter-6-test-1": "two-meetings",
    "chapter-6-test-2": "three-cross",
}


class RenamedWarning(UserWarning, DeprecationWarning):
    """An old name was used. A command prints it as one line on stderr; in Python it is a DeprecationWarning."""


def current_name(name: str) -> str:
    """The present name of the scenario ``name``. Warns with RenamedWarning if that is an old one."""
    new = NEW_NAMES.get(name)
    if new is None:
        return name
    warnings.warn(f"the scenario {name} is now called {new}; the old name goes in the next release", RenamedWarning, 3)
    return new
