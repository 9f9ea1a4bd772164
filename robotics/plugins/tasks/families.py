"""Families of scenarios of teams: a family says how they are drawn, and a number which of them one is.

A scenario is one run. Its number of robots, what they are, its layout, the radio, who is held up or falls silent and
when, and all noise are drawn from generators of its task and its number alone: the same number is the same run
everywhere, and for every law. Blocks of numbers have nothing in common (:mod:`robotics.plugins.arena.plan`).
"""

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from fuzzy.errors import InputError
from fuzzy.naming import check_known
from fuzzy.quantity import check_quantities, described, part, quantity, whole
from robotics.laws.setting import Setting
from robotics.plugins.arena.plan import ArenaError
from robotics.plugins.stress.crossings import drawn_ensemble, growth
from robotics.plugins.stress.disturbance import Disturbance
from robotics.plugins.stress.obstaclecourse import grown_world
from robotics.plugins.stress.outcome import StressOutcome
from robotics.plugins.tasks.layouts import TASKS, Layout, Task, draw_layout
from robotics.simulation.scenario.robots import STANDARD, RobotModel, load_robot
from robotics.world.environment.world import Wall, World, compile_worlds
from robotics.world.paths.joined import table_length
from robotics.world.radio.faults import Fault, Faults

TASK_STREAM = 10  # of a scenario's random streams: see robotics.world.radio.channel
_FEWEST = 2  # robots
_MOST = 10
_HALL = 2.5  # m from the outermost point of a path to the wall of the hall, for the EtsRo
_HELD = (2.0, 8.0)  # s, from and to: for which a robot is held up
_SILENT = (1.0, 6.0)  # s: for which a robot's radio is
_WITHIN = 0.8  # of the nominal time: by then it begins
_CROSSING_LANES = 4  # robots of "joined": more lanes hardly ever cross clear of each other's ends


class TaskScenario(NamedTuple):
    """One run: who drives where, and what goes wrong."""

    name: str
    setting: Setting
    faults: Faults | None
    seed: int
    extra: float  # s: by which it may take longer than a StressOutcome's limit
    limit: float  # nominal durations, without what a robot is held up
    facts: dict[str, Any]  # what was drawn, as columns of the table of scenarios


@dataclass(frozen=True, kw_only=True)
class TaskFamily:
    """How scenarios of a task are drawn. Raises ArenaError."""

    task: Task = described(f"What robots do: one of {', '.join(TASKS)}.", example="crossing")
    count: int = whole(1, least=1, most=100_000, doc="How many scenarios are drawn.")
    fewest: int = whole(3, least=_FEWEST, most=_MOST, doc="The least number of robots.")
    most: int = whole(6, least=_FEWEST, most=_MOST, doc="The greatest number of robots.")
    models: tuple[str, ...] = described("The robots, one of which is drawn: names, or .toml files.", (STANDARD,))
    loss: float = part(0.0, doc="The share of messages that is lost is drawn up to this.")
    latency: float = quantity(0.0, "s", least=0, most=10, doc="The latency of the radio is drawn up to this.")
    held_up: float = part(0.0, doc="The share of scenarios in which a robot is held up for 2 to 8 s.")
    silent: float = part(0.0, doc="The share of scenarios in which a robot's radio is silent for 1 to 6 s.")
    discs: int = whole(0, least=0, most=10, doc="Of course, joined and trap: up to so many discs cross the lanes.")
    limit: float = quantity(
        4.0, "1", above=1, most=100, doc="A run that takes longer than so many times its nominal time is a deadlock."
    )
    title: str = described("What it is called in tables and pictures.", "", example="20 % loss")

    def __post_init__(self) -> None:
        check_quantities(self, ArenaError)
        check_known(self.task, TASKS, "task", ArenaError, "task")
        if self.fewest > self.most:
            raise ArenaError(f"fewest must be <= most, {self.most}; got {self.fewest}").about("fewest")
        if not self.models:
            raise ArenaError("models must have at least one").about("models")
        if self.task == "joined" and self.most > _CROSSING_LANES:
            raise ArenaError(f"most must be <= {_CROSSING_LANES} where task is joined; got {self.most}").about("most")
        if self.discs and self.task not in ("course", "joined", "trap"):
            raise ArenaError(f"discs belong to course, joined and trap; got {self.discs} of {self.task}").about("discs")
        for i, model in enumerate(self.models):
            try:
                load_robot(model)
            except InputError as error:
                raise ArenaError(f"models: {error}").about("models", i) from None

    @property
    def label(self) -> str:
        """What it is called."""
        return self.title or self.task

    def scenario(self, number: int) -> TaskScenario:
        """Draw the scenario of that number."""
        return _drawn(self, number)


@lru_cache(maxsize=800)
def _drawn(family: TaskFamily, number: int) -> TaskScenario:
    rng = np.random.default_rng([TASK_STREAM, TASKS.index(family.task), number])
    robots = int(rng.integers(family.fewest, family.most, endpoint=True))
    model = load_robot(family.models[int(rng.integers(len(family.models)))])
    loss, latency = float(rng.uniform(0, family.loss)), float(rng.uniform(0, family.latency))
    discs = int(rng.integers(0, family.discs, endpoint=True))
    spans = (_HELD, family.held_up), (_SILENT, family.silent)
    held, silent = (float(rng.uniform(*span)) * (rng.random() < share) for span, share in spans)
    disturbance = Disturbance(loss=loss, latency=latency, freeze=held)
    layout = draw_layout(family.task, rng, robots, discs)
    name, longest = f"{family.task}-{number}", max(table_length(table) for table in layout.tables)
    setting = drawn_ensemble(name, [layout.tables], family.limit, longest, disturbance, model)
    setting = replace(setting, world=compile_worlds([_hall(layout, model)]))
    nominal = float(setting.references.ends[0, 0])
    faults = _faults(rng, robots, nominal, {"stall": held, "silence": silent})
    facts = {
        "task": family.label,
        "robots": robots,
        "model": model.name,
        "loss": disturbance.loss,
        "latency_s": disturbance.latency,
        "held_up_s": held,
        "silent_s": silent,
        "discs": discs,
        "nominal_s": nominal,
    }
    extra = (family.limit - StressOutcome.limit) * nominal + disturbance.extra
    return TaskScenario(name, setting, faults, number, extra, family.limit, facts)


def _hall(layout: Layout, model: RobotModel) -> World:
    """The obstacles in a hall: sensors have something to see in every task, and so see the other robots."""
    factor = growth(model)
    world = grown_world(World(obstacles=layout.obstacles, known=False), factor)
    x, y = (factor * np.concatenate([table[row] for table in layout.tables]) for row in (0, 1))
    room = factor * _HALL
    west, east, south, north = (float(v) for v in (x.min() - room, x.max() + room, y.min() - room, y.max() + room))
    corners = ((west, south), (east, south), (east, north), (west, north), (west, south))
    return replace(world, obstacles=(*world.obstacles, Wall(points=corners)))


def _faults(rng: np.random.Generator, robots: int, nominal: float, lasting: dict[str, float]) -> Faults | None:
    """Who is held up and who falls silent, drawn, and from when on."""
    drawn = [
        (Fault(robot=1 + int(rng.integers(robots)), kind=kind, duration=seconds), float(rng.uniform(0, _WITHIN)))  # type: ignore[arg-type]
        for kind, seconds in lasting.items()
        if seconds > 0
    ]
    if not drawn:
        return None
    starts = np.array([[nominal * share for _, share in drawn]])
    return Faults(tuple(f for f, _ in drawn), robots, starts, starts + [f.duration for f, _ in drawn])
