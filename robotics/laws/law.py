"""What a control law is: its gains, what it may know, and what it commands.

A law is a frozen dataclass of gains. What it remembers is passed in and handed back; it never sees the true state.
Arrays carry (runs, robots) in front, and a law is written for all of them at once.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from math import inf
from typing import Any, ClassVar, Generic, NamedTuple, TypeVar

import numpy as np

from fuzzy.errors import InputError
from robotics.laws.setting import Setting
from robotics.paths.references import References
from robotics.paths.trajectory import Reference
from robotics.radio.channel import NOTHING, Heard
from robotics.sensing.sonar import Ranges
from robotics.vehicle.plant import Level

Memory = TypeVar("Memory")


class ControllerError(InputError):
    """An unknown controller, a gain that it does not have or cannot take, or a setting that it cannot drive."""


class Observation(NamedTuple):
    """What the robots know at one time."""

    time: float  # s
    x: np.ndarray  # (runs, robots) m, measured
    y: np.ndarray  # (runs, robots) m, measured
    heading: np.ndarray  # (runs, robots) rad, measured, not wrapped
    v: np.ndarray  # (runs, robots) m/s, from the encoders over the last period
    w: np.ndarray  # (runs, robots) rad/s, from the encoders over the last period
    reference: Reference  # (robots,) or (runs, robots) each field: the target at this time
    references: References  # each robot's own path and timing, for looking ahead
    heard: Heard = NOTHING  # what the radio brought
    ranges: Ranges | None = None  # what the range sensors read, for a law that needs some and where there are obstacles


class Command(NamedTuple):
    """What the robots shall do until the next period."""

    first: np.ndarray  # (runs, robots): v [m/s], or the right wheel's torque [N m]
    second: np.ndarray  # (runs, robots): ω [rad/s], or the left wheel's torque [N m]
    v: np.ndarray  # (runs, robots) m/s: the speed that the law tries to reach; v_d of (2.13), (2.26)
    w: np.ndarray  # (runs, robots) rad/s
    message: Mapping[str, np.ndarray] | None = None  # (runs, robots) each: what each robot broadcasts, by name
    target: Reference | None = None  # (runs, robots) each field, if it is not the scenario's reference
    progress: np.ndarray | None = None  # (runs, robots) the law's own path parameter, from 0 to 1
    refused: np.ndarray | None = None  # (runs,) bool: the law knows no safe way, and the robots stay where they are
    mode: np.ndarray | None = (
        None  # (runs, robots) int: what each robot is doing; an index of MODES in robotics.laws.modes
    )


class Law(ABC, Generic[Memory]):
    """A control law with its gains; ``Memory`` is what it remembers from one period to the next.

    A law is a frozen dataclass that derives from this class and gives :meth:`init` and :meth:`control`. Where the
    defaults below do not fit it overrides them.
    """

    message: ClassVar[tuple[str, ...]] = ()  # the names of the values that each robot broadcasts
    needs: ClassVar[tuple[str, ...]] = ()  # the names of the range sensors that each robot must carry

    @property
    def level(self) -> Level:
        """Whether it commands velocities or wheel torques."""
        return "velocity"

    @property
    def watchdog(self) -> float:
        """After how long [s] without a new command a robot stops by itself."""
        return inf

    @property
    def idle(self) -> frozenset[str]:
        """The names of the gains that have no effect as the others are set."""
        return frozenset()

    @abstractmethod
    def init(self, setting: Setting, runs: int) -> Memory:
        """What it remembers at the start of ``runs`` runs. Raises ControllerError where it cannot drive the setting."""

    @abstractmethod
    def control(self, seen: Observation, memory: Memory, dt: float) -> tuple[Command, Memory]:
        """Its command, and what it remembers, ``dt`` seconds after the last."""


def check_needs(setting: Setting, law: Law[Any]) -> None:
    """Raise ControllerError, saying what is missing, unless each robot carries the sensors that ``law`` needs."""
    for i, carried in enumerate(setting.sensors, start=1):
        missing = [name for name in law.needs if name not in carried]
        if missing:
            has = f"it carries {', '.join(carried)}" if carried else "it carries none"
            raise ControllerError(
                f"{setting.name}: robot {i} lacks the range sensor{'s' * (len(missing) > 1)} {', '.join(missing)} that "
                f"{type(law).__name__} needs; {has}; add a table [[sensors]] with this name"
            )


Controller = Law  # what it was called in version 0.1
