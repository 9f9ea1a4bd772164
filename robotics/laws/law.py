"""The base of all control laws: gains, what a law may know, and what it commands.

A law is a frozen dataclass of gains. Its memory is passed in and handed back; it never sees the true state.
Arrays carry (runs, robots) in front, and a law is written for all of them at once.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from difflib import get_close_matches
from math import inf
from types import MappingProxyType
from typing import Any, ClassVar, Generic, NamedTuple, Self, TypeVar, cast

import numpy as np

from fuzzy.errors import InputError
from fuzzy.naming import check_known, expected
from fuzzy.quantity import check_quantities
from fuzzy.system import Sugeno
from robotics.laws.modes import StateDiagram
from robotics.laws.setting import Kind, Setting
from robotics.world.paths.references import Reference, References
from robotics.world.radio.channel import NOTHING, Heard
from robotics.world.radio.graph import is_connected
from robotics.world.sensing.sonar import Ranges
from robotics.world.vehicle.plant import Level
from robotics.world.vehicle.robot import Robot

Memory = TypeVar("Memory")
# What a law of motion may know beside its robot's posture, in the words of Law.knows
KNOWLEDGE = (
    "reference",  # where it shall be now
    "reference velocity",
    "curvature",  # of the path at the reference
    "preview",  # the reference at later times
    "wheel speeds",  # by the encoders
    "wheel lag",  # how the wheels follow a command
    "latency",  # how late a command acts, and so which commands are still to act
)


class ControllerError(InputError):
    """An unknown controller, a gain that it does not have or cannot take, or a setting that it cannot drive."""


class Observation(NamedTuple):
    """All that the robots know at one time.

    Attributes:
        time: Since the start [s].
        x: (runs, robots) m, measured.
        y: (runs, robots) m, measured.
        heading: (runs, robots) rad, measured, not wrapped.
        v: (runs, robots) m/s, from the encoders over the last period.
        w: (runs, robots) rad/s, from the encoders over the last period.
        reference: (robots,) or (runs, robots) each field: the target at this time.
        references: Each robot's own path and timing, for looking ahead.
        heard: What the radio brought.
        ranges: What the range sensors read, for a law that needs some and where there are obstacles.
    """

    time: float
    x: np.ndarray
    y: np.ndarray
    heading: np.ndarray
    v: np.ndarray
    w: np.ndarray
    reference: Reference
    references: References
    heard: Heard = NOTHING
    ranges: Ranges | None = None


class Command(NamedTuple):
    """The command to the robots until the next period.

    Attributes:
        first: (runs, robots): v [m/s], or the right wheel's torque [N m].
        second: (runs, robots): ω [rad/s], or the left wheel's torque [N m].
        v: (runs, robots) m/s: the speed that the law tries to reach; v_d of (2.13), (2.26).
        w: (runs, robots) rad/s: likewise the turn rate.
        message: By name (runs, robots): what each robot broadcasts.
        target: Each field (runs, robots), where the target is not the setting's reference.
        progress: (runs, robots) the law's own path parameter, from 0 to 1.
        refused: (runs,) bool: the law knows no safe way, and the robots stay where they are.
        mode: (runs, robots) int: each robot's mode, an index of robotics.laws.modes.MODES.
        inputs: (inputs, runs, robots): the inputs of all of the law's rule bases, in the order of Law.fuzzy_systems and
            of each.
        guarded: (runs, robots) bool: the emergency rule overrode what the law wanted.
    """

    first: np.ndarray
    second: np.ndarray
    v: np.ndarray
    w: np.ndarray
    message: Mapping[str, np.ndarray] | None = None
    target: Reference | None = None
    progress: np.ndarray | None = None
    refused: np.ndarray | None = None
    mode: np.ndarray | None = None
    inputs: np.ndarray | None = None
    guarded: np.ndarray | None = None


class Law(ABC, Generic[Memory]):
    """A control law with its gains; ``Memory`` is what it remembers from one period to the next.

    A law is a frozen dataclass that derives from this class and defines :meth:`control`, and :meth:`init` where it
    remembers something. It overrides those of the defaults below that do not fit.
    """

    def __init_subclass__(cls) -> None:
        """Refuse a misspelt name of this class, which would be silence: the default would act."""
        own = {name for name in vars(Law) if not name.startswith("_")}
        for name in {*vars(cls), *vars(cls).get("__annotations__", {})} - own:
            if not name.startswith("_") and (close := get_close_matches(name, own, n=1, cutoff=0.85)):
                raise TypeError(f"{cls.__name__}.{name} is no part of a law; is {close[0]} meant?")
        said = vars(cls).get("knows", ())
        if isinstance(said, tuple) and (unknown := [word for word in said if word not in KNOWLEDGE]):
            raise TypeError(f"{cls.__name__}.knows: " + expected(unknown[0], KNOWLEDGE, "word"))

    def __post_init__(self) -> None:
        """Hold the gains to their ranges. Raises ControllerError."""
        check_quantities(self, ControllerError)

    yields: ClassVar[bool] = False  # whether it keeps robots clear of each other
    sort_of_law: ClassVar[str] = ""  # of the class itself, not of those derived from it: what arenas group it under
    # The gains that name its rule bases, by the task of each; or the parts that have it
    tasks: ClassVar[Mapping[str, str]] = MappingProxyType({})

    safe: str = ""  # "yes", "no": whether the monitor of passive safety is below it; "": as the scenario says
    estimator: float | str | None = None  # by which its robots join pose sensor and odometry; None: the scenario's

    @property
    def learnt_how(self) -> str:
        """How it was learnt, in words; "" if it was not."""
        return ""

    @property
    def message(self) -> tuple[str, ...]:
        """The names of the values that each robot broadcasts."""
        return ()

    @property
    def knows(self) -> tuple[str, ...]:
        """What it uses beside its robot's posture, in words of :data:`KNOWLEDGE`; a class may give the tuple itself."""
        return ()

    @property
    def needs(self) -> tuple[str, ...]:
        """The names of the range sensors that each robot must carry."""
        return ()

    @property
    def looks(self) -> bool:
        """Whether it uses what range sensors read; those that it needs, or whatever a robot carries."""
        return bool(self.needs)

    @property
    def fuzzy_systems(self) -> Mapping[str, Sugeno]:
        """The rule bases that make its commands, by the name of their task; their inputs are ``Command.inputs``."""
        return {}

    @property
    def rule_inputs(self) -> int:
        """The number of inputs of all its rule bases."""
        return sum(len(system.inputs) for system in self.fuzzy_systems.values())

    @property
    def composites(self) -> Mapping[str, Any]:
        """The trees and type-2 systems, of which :attr:`fuzzy_systems` has the variables alone."""
        return {}

    def with_fuzzy_system(self, task: str, fis: Any) -> Self:
        """The same law with ``fis`` as the rule base of ``task``, one of :attr:`tasks`.

        Raises:
            ControllerError: A task that it does not have, or a system that does not suit the task.
        """
        gain = self._gain_of(task)
        held = getattr(self, gain)
        other = held.with_fuzzy_system(task, fis) if isinstance(held, Law) else fis
        changed = cast(Self, replace(cast(Any, self), **{gain: other}))
        if changed.safe != self.safe:  # of a law of arrays it is no field, and is told beside its gains
            object.__setattr__(changed, "safe", self.safe)
        return changed

    def rule_base_gain(self, task: str) -> str:
        """The gain that names the rule base of ``task``, as a specification calls it: "tracker.rule_base".

        Raises:
            ControllerError: A task that it does not have.
        """
        gain = self._gain_of(task)
        held = getattr(self, gain)
        return f"{gain}.{held.rule_base_gain(task)}" if isinstance(held, Law) else gain

    def _gain_of(self, task: str) -> str:
        check_known(task, self.tasks, f"task of a rule base in {type(self).__name__}", ControllerError)
        return self.tasks[task]

    @property
    def level(self) -> Level:
        """Whether it commands velocities or wheel torques."""
        return "velocity"

    @property
    def watchdog(self) -> float:
        """The time [s] without a new command after which a robot stops by itself."""
        return inf

    @property
    def safety_distance(self) -> float | None:
        """The distance [m] between the centers of two robots that it keeps; None: it keeps none."""
        return None

    def distance_between(self, robots: Sequence[Robot]) -> float | None:
        """The distance [m] that it keeps between the centers of ``robots``, if that depends on their size."""
        return self.safety_distance

    @property
    def idle(self) -> frozenset[str]:
        """The names of the gains that have no effect as the others are set."""
        return frozenset()

    @property
    def diagrams(self) -> tuple[StateDiagram, ...]:
        """Its state diagrams; a law without states has none."""
        return ()

    def misgivings(self, setting: Setting) -> tuple[str, ...]:
        """All sentences that say why it may not do its task in ``setting``, which it can drive all the same."""
        return ()

    def init(self, setting: Setting, runs: int) -> Memory:
        """The memory at the start of ``runs`` runs of ``setting``; None of a law that remembers nothing.

        Raises:
            ControllerError: It cannot drive ``setting``.
        """
        return cast(Memory, None)

    @abstractmethod
    def control(self, seen: Observation, memory: Memory, dt: float) -> tuple[Command, Memory]:
        """The command for what the robots have ``seen``, and the new ``memory``, ``dt`` seconds after the last.

        Arrays of the command are (runs, robots).
        """


def check_needs(setting: Setting, law: Law[Any]) -> None:
    """Raise ControllerError, saying what is missing, unless each robot carries the sensors that ``law`` needs."""
    for i, carried in enumerate(setting.sensors, start=1):
        missing = [name for name in law.needs if name not in carried]
        if missing:
            few = [*carried] if len(carried) <= 6 else [*[*carried][:2], "...", [*carried][-1]]
            has = f"it carries {', '.join(few)}" if carried else "it carries none"
            raise ControllerError(
                f"{setting.name}: robot {i} lacks the range sensor{'s' * (len(missing) > 1)} {', '.join(missing)} that "
                f"{type(law).__name__} needs; {has}; add a table [[sensors]] with "
                f'{"this name" if len(missing) == 1 else "each name"}, or with preset = "sonar"'
            )


def check_team(setting: Setting) -> None:
    """Raise ControllerError unless the scenario is one of a team, whose robots shall arrive together."""
    if setting.kind != "team":
        raise ControllerError(f'{setting.name}: this law needs a scenario of kind = "team"')


def check_connected(setting: Setting) -> None:
    """Raise ControllerError unless the message of every robot reaches every other, over others if need be."""
    if not is_connected(setting.radio.adjacency(len(setting.robots))):
        raise ControllerError(
            f"{setting.name}: the graph {setting.radio.graph!r} is not connected: every robot must reach every other, "
            "over others if need be"
        )


@dataclass(frozen=True)
class Preset:
    """A law with some of its gains set.

    Attributes:
        law: The class.
        gains: Those that differ from its defaults, by name.
        title: What tables and pictures call it.
        note: Where the gains come from.
        kind: The kind of scenario that it drives.
    """

    law: type[Law[Any]]
    gains: dict[str, Any]
    title: str
    note: str
    kind: Kind = "tracking"
