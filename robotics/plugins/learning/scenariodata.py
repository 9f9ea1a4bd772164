"""Formation data from any scenario: what each robot knows, and what a teacher makes it do.

A teacher, any law that commands velocities, drives the scenario with its plant and its noise. A learner that saw only
robots in their places would not know the way back to them. Half of the rows are therefore of displaced robots: from
many times of the timing on, each robot begins beside where it should be, some way ahead or behind, to a side, and
turned, each by its own draw, and is driven for some seconds.

A row is one moment of one run, until the leader has arrived. Its columns are named by robot: ``leader_ahead_2`` is the
quantity ``leader_ahead`` of :mod:`robotics.laws.rules.quantities` as robot 2 knows it, ``v_2`` and ``w_2`` are what the
teacher commands it then. Numbers are rounded to 1e-6.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fuzzy.quantity import check_quantities, described, quantity, whole
from robotics.laws.catalogue import make_controller, preset_of
from robotics.laws.law import Law
from robotics.laws.rules.follow_leader import FollowLeader
from robotics.laws.rules.quantities import Quantity, quantity_of
from robotics.laws.rules.situation import NOTHING_NEAR
from robotics.laws.setting import Setting
from robotics.plugins.learning.datatable import COMMAND_OUTPUTS, TIMED_COLUMNS, DataColumn, DataTable
from robotics.plugins.learning.formationdata import MOST_SAMPLES, MOST_SEED, FormationDataError
from robotics.plugins.learning.onlooker import Onlooker, OnlookerColumns, asking_for
from robotics.plugins.learning.tandem import TandemMemory, TeacherAndPupil
from robotics.simulation.loop import drive
from robotics.simulation.scenario.description import Scenario
from robotics.world.paths.references import later
from robotics.world.vehicle import plant as p

_FOLLOWING = ("leader_ahead", "stretch", "onward_bearing")  # what the law leader-follower is a function of
_FORMATION = (*_FOLLOWING, "curvature")
DISPLACED_STREAM = 9  # of a seed's random streams: see robotics.world.random_streams
NEXT_SEEDS = 1000  # by which the seeds of a checking set are larger


@dataclass(frozen=True, kw_only=True)
class ScenarioRecipe:
    """How a set is made of a scenario: the same recipe and scenario give the same numbers."""

    teacher: str = described("The law that drives, name or name:gain=value,...", "leader-follower")
    inputs: tuple[str, ...] = described(
        "Quantities that each robot's networks know (docs/reference/quantities.md). Default: "
        "leader_ahead,stretch,onward_bearing for leader-follower (with curvature for other formation laws), "
        "x_err,y_err,heading_err,target_v,target_w for laws that follow a timing.",
        (),
    )
    samples: int = whole(2000, least=2, most=MOST_SAMPLES, doc="Rows.")
    runs: int = whole(2, least=0, most=10_000, doc="Runs from its own starts, one a seed.")
    places: int = whole(
        24, least=1, most=10_000, doc="Times of the timing, evenly spread, from which displaced robots start."
    )
    starts: int = whole(8, least=1, most=10_000, doc="Displaced starts from each of the places.")
    displaced: float = quantity(0.5, "1", least=0, most=1, doc="Share of the rows that are of displaced robots.")
    lead: float = quantity(0.4, "m", least=0, most=4, doc="Largest displacement along the path, either way.")
    lateral: float = quantity(0.15, "m", least=0, most=1, doc="Largest displacement to a side.")
    heading: float = quantity(0.3, "rad", least=0, most=1.5, doc="Largest rotation, either way.")
    span: float = quantity(4.0, "s", above=0, most=60, doc="How long displaced robots are driven.")
    seed: int = whole(0, least=0, most=MOST_SEED, doc="Seed of the runs and of the displacements.")
    stream: int = whole(
        0, least=0, most=MOST_SEED, doc="Which of the seed's random sequences is used; the checking set has 1."
    )

    def __post_init__(self) -> None:
        check_quantities(self, FormationDataError)
        if self.runs == 0 and self.displaced < 1:
            raise FormationDataError("without runs from the scenario's own starts displaced must be 1")

    @property
    def seeds(self) -> range:
        """The seeds of the runs from the scenario's own starts; those of displaced starts follow."""
        first = self.seed + NEXT_SEEDS * self.stream
        return range(first, first + self.runs)


@dataclass(frozen=True, eq=False)
class RobotTable(DataTable):
    """A set of samples; the columns are those of robot 1, its inputs and then v and w, then those of robot 2."""

    quantities: tuple[str, ...]  # that each robot knows, without robots' numbers
    robots: int


def checking_set(recipe: ScenarioRecipe) -> ScenarioRecipe:
    """The recipe of the checking set that belongs to ``recipe``: other seeds, other displaced starts, fewer rows.

    None of its rows are from the scenario's own starts: without noise these would be the same again.
    """
    return replace(recipe, stream=recipe.stream + 1, samples=max(2, recipe.samples // 4), runs=0, displaced=1.0)


def default_inputs(specification: str) -> tuple[str, ...]:
    """The quantities that the networks of a teacher know by default: those of which its commands are a function."""
    law, kind = make_controller(specification), preset_of(specification).kind
    return _FOLLOWING if isinstance(law, FollowLeader) else _FORMATION if kind == "formation" else TIMED_COLUMNS


def column(name: str, robot: int) -> str:
    """The name of a column: of the quantity or output ``name`` of ``robot``, counted from 1."""
    return f"{name}_{robot}"


def passes(recipe: ScenarioRecipe) -> int:
    """How often :func:`scenario_data` calls ``advance``."""
    return (recipe.runs > 0 and recipe.displaced < 1) + (recipe.places if recipe.displaced > 0 else 0)


def scenario_data(scenario: Scenario, recipe: ScenarioRecipe, advance: Callable[[], None] | None = None) -> RobotTable:
    """Make the set that ``recipe`` describes of ``scenario``; ``advance`` is called after every simulation.

    Raises FormationDataError where the teacher commands no velocities or an input does not suit, and what the teacher
    raises for a scenario that it cannot drive.
    """
    teacher: Law[Any] = make_controller(recipe.teacher)
    if teacher.level != "velocity":
        raise FormationDataError(f"{recipe.teacher} commands torques; a formation's networks learn v and w")
    names = recipe.inputs or default_inputs(recipe.teacher)
    known = _quantities(names, len(scenario.robots))
    law = TeacherAndPupil(teacher=teacher, pupil=Onlooker(base=asking_for(names)), learns="inputs")
    step = advance or (lambda: None)
    rng = np.random.default_rng([recipe.seed, DISPLACED_STREAM, recipe.stream])
    displaced = round(recipe.displaced * recipe.samples)
    parts = []
    if displaced < recipe.samples:
        rows = _rows(scenario.setting, law, recipe.seeds)
        step()
        parts.append(_drawn(rows, recipe.samples - displaced, rng))
    if displaced:  # more of them, where the runs are short
        more = recipe.samples - sum(map(len, parts))
        parts.append(_drawn(_displaced_rows(scenario.setting, law, recipe, rng, step), more, rng))
    values = np.round(np.concatenate(parts), 6) + 0.0  # + 0.0: no -0
    if not len(values):
        raise FormationDataError(f"{scenario.name}: no row is left: nothing is known of what the networks shall know")
    described = [(name, q.unit, q.meaning) for name, q in zip(names, known, strict=True)]
    described += [(name, *words) for name, words in COMMAND_OUTPUTS.items()]
    robots = range(1, len(scenario.robots) + 1)
    columns = [
        DataColumn(column(name, i), unit, meaning, name in COMMAND_OUTPUTS, i)
        for i in robots
        for name, unit, meaning in described
    ]
    return RobotTable(tuple(columns), values, tuple(names), len(robots))


def _quantities(names: tuple[str, ...], robots: int) -> tuple[Quantity, ...]:
    if len(set(names)) < len(names):
        raise FormationDataError(f"inputs: each quantity once; got {', '.join(names)}")
    found = tuple(quantity_of(name, "inputs") for name in names)
    for name, known in zip(names, found, strict=True):
        if known.pair:
            raise FormationDataError(
                f"inputs: {name} is told of each other robot; a robot's networks take what is told of one, such as "
                "robot1_gap"
            )
        if known.robot > robots:
            raise FormationDataError(f"inputs: {name} is of robot {known.robot}, and the scenario has {robots}")
    return found


def _rows(setting: Setting, law: TeacherAndPupil, seeds: range) -> np.ndarray:
    """The rows (rows, columns) of all moments of the runs of ``seeds`` in which robots drive and all is known."""
    # The values of two laws are sent, which no channel was laid out for
    setting = replace(setting, radio=replace(setting.radio, baud=None))
    kept = []
    for state in drive(setting, law, seeds):
        memory: TandemMemory = state.memory
        assert memory.said is not None
        said = np.stack(p.saturate(p.velocity_limits(setting.robots), memory.said.v, memory.said.w), axis=-1)
        known = np.minimum(memory.known[:, :, 0], NOTHING_NEAR)
        rows = np.concatenate([known, said], axis=-1)  # (runs, robots, columns of one robot)
        over = OnlookerColumns(memory.pupil.rows).over.reshape(said.shape[:2])[:, 0] > 0
        drives = ~over & (state.stopped < 0).all(axis=1) & np.isfinite(rows).all(axis=(1, 2))
        kept.append(rows.reshape(len(rows), -1)[drives])
        if over.all():
            break
    return np.concatenate(kept)


def _displaced_rows(
    setting: Setting, law: TeacherAndPupil, recipe: ScenarioRecipe, rng: np.random.Generator, step: Callable[[], None]
) -> np.ndarray:
    """The rows of robots that begin beside their places, from ``recipe.places`` times of the timing on."""
    first = recipe.seeds.stop
    shape = recipe.starts, len(setting.robots)
    most = np.array([recipe.lead, recipe.lateral, recipe.heading])
    parts = []
    for k in range(recipe.places):
        time = (k + rng.random()) / recipe.places * float(setting.references.ends.max())
        along, aside, turned = np.moveaxis(rng.uniform(-most, most, (*shape, 3)), -1, 0)
        joined = setting.references.joined
        point = joined.at(np.clip(setting.references.at(time).s + along, 0.0, joined.lengths))
        x, y = point.x - aside * np.sin(point.heading), point.y + aside * np.cos(point.heading)
        starts, ticks = np.stack([x, y, point.heading + turned], axis=-1), max(1, round(recipe.span / setting.period))
        begun = replace(setting, starts=starts, references=later(setting.references, time), ticks=ticks, faults=())
        parts.append(_rows(begun, law, range(first + k * recipe.starts, first + (k + 1) * recipe.starts)))
        step()
    return np.concatenate(parts)


def _drawn(rows: np.ndarray, count: int, rng: np.random.Generator) -> np.ndarray:
    """``count`` of the rows at random, in their order; all of them, if there are no more."""
    return rows[np.sort(rng.permutation(len(rows))[:count])]
