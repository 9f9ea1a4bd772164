"""What moves the robots of a simulation in place of its own plant: physics of plug-ins, by name.

A plug-in names a frozen dataclass by an entry point of the group ``fuzzyfleet.plants``. Its fields are the options of
``name:option=value,...``.
"""

from collections.abc import Callable
from dataclasses import fields
from typing import Any, Protocol, cast

import numpy as np

from fuzzy.entrypoints import entry_points
from fuzzy.errors import InputError
from fuzzy.naming import expected
from fuzzy.quantity import accepted, got
from robotics.laws.setting import Setting
from robotics.laws.specification import assignments
from robotics.simulation.lanes import PlantLanes

GROUP = "fuzzyfleet.plants"
# As :func:`robotics.simulation.steps.move`: period, plant, orders (2, lanes), when stopped, and who is lost (lanes,)
Mover = Callable[[int, PlantLanes, np.ndarray, np.ndarray, np.ndarray], None]


class PhysicsError(InputError):
    """Physics that there are not, that lack a package, or that cannot move what a scenario has."""


class Physics(Protocol):
    """Physics with its options."""

    def opened(self, setting: Setting, body: PlantLanes) -> Mover:
        """What moves all lanes, which begin as ``body``, by a period. Raises PhysicsError."""
        ...


def physics_of(specification: str) -> Physics:
    """The physics of ``name:option=value,...``. Raises PhysicsError for what there is not, and for a wrong value."""
    name, _, rest = specification.partition(":")
    known = {entry.name: entry for entry in entry_points(GROUP)}
    if name not in known:
        raise PhysicsError(expected(name, known, "plant"))
    made = known[name].load()
    options, values = {f.name: f for f in fields(made)}, {}
    for option, _, text in assignments(rest):
        if option not in options:
            raise PhysicsError(f"plant {name}: " + expected(option, options, "option"))
        try:
            values[option] = float(text)
        except ValueError:
            what = f"{option} must be {accepted(options[option].metadata)}; {got(text)}"
            raise PhysicsError(f"plant {name}: {what}") from None
    return cast(Physics, made(**values))


def as_physics(plant: "Physics | str") -> Any:
    """Physics itself, that of a specification, or None for no name: the simulator's own plant."""
    return physics_of(plant) if isinstance(plant, str) and plant else plant or None
