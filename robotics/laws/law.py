"""What a controller is: its parameters, what it may know, and what it commands.

A controller is a frozen dataclass of gains. What it remembers is passed in and handed back; it never sees the true
state. Arrays carry (runs, robots) in front, and a law is written for all of them at once.
"""

from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np

from fuzzy.errors import InputError
from robotics.paths.trajectory import Reference, Trajectory
from robotics.radio.channel import Heard
from robotics.vehicle.plant import Level

if TYPE_CHECKING:
    from robotics.scenario.description import Scenario


class ControllerError(InputError):
    """An unknown controller, or a gain that it does not have or cannot take."""


class Observation(NamedTuple):
    """What the robots know at one time."""

    time: float  # s
    x: np.ndarray  # (runs, robots) m, measured
    y: np.ndarray  # (runs, robots) m, measured
    heading: np.ndarray  # (runs, robots) rad, measured, not wrapped
    v: np.ndarray  # (runs, robots) m/s, from the encoders over the last period
    w: np.ndarray  # (runs, robots) rad/s, from the encoders over the last period
    reference: Reference  # (robots,) each field: the target at this time
    trajectory: Trajectory  # each robot's own path and timing, for looking ahead
    heard: Heard | None = None  # what the radio brought, for a law that says something
    ranges: np.ndarray | None = None  # (runs, robots, sensors) m, for a law with sensors where there are obstacles


class Command(NamedTuple):
    """What the robots shall do until the next period."""

    first: np.ndarray  # (runs, robots): v [m/s], or the right wheel's torque [N m]
    second: np.ndarray  # (runs, robots): ω [rad/s], or the left wheel's torque [N m]
    v: np.ndarray  # (runs, robots) m/s: the speed that the law tries to reach; v_d of (2.13), (2.26)
    w: np.ndarray  # (runs, robots) rad/s
    message: np.ndarray | None = None  # (fields, runs, robots): what each robot broadcasts
    target: Reference | None = None  # (runs, robots) each field, if it is not the scenario's reference
    progress: np.ndarray | None = None  # (runs, robots) the law's own path parameter, from 0 to 1
    refused: np.ndarray | None = None  # (runs,) bool: the law knows no safe way, and the robots stay where they are
    mode: np.ndarray | None = (
        None  # (runs, robots) int: what each robot is about; an index of robotics.laws.modes.MODES
    )


class Controller(Protocol):
    """A control law with its gains.

    A law whose robots talk has an attribute ``message``, the names of the values that each of them broadcasts; one
    with a ``watchdog`` [s] stops a robot that has been without a new command for that long; one whose robots look
    around has ``sensors``, a tuple of :class:`robotics.sensing.sonar.RangeSensor`.
    """

    @property
    def level(self) -> Level:
        """Whether it commands velocities or wheel torques."""
        ...

    def init(self, scenario: "Scenario", runs: int) -> Any:
        """What it remembers at the start of ``runs`` runs of ``scenario``."""
        ...

    def control(self, seen: Observation, memory: Any, dt: float) -> tuple[Command, Any]:
        """Its command, and what it remembers, ``dt`` seconds after the last."""
        ...
