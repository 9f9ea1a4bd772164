"""Training data of formations, thesis 5.2.1: what leader and followers do, by the leader's posture.

Two kinds:

``literal``: five formations as the thesis describes them, 400 samples each, evenly in time, until the leader is at
x = 6 m. The leader's speed depends on where it started, and so the outputs are not a function of x_l, y_l and
θ_l: :mod:`robotics.plugins.learning.scatter` says how far they scatter at equal inputs.

``well-posed``: the law of :mod:`robotics.laws.formation.leader_follower`, by what it is a smooth function of: the
lead dx, the bearing α_l of the leader's path ahead and the curvature κ_f where the followers are. Samples lie evenly
over all (x_l, dx), or a share of them along five formations' runs. Most are displaced from the path, so that α_l tells
how the leader comes back: a network that has only seen robots on the path drives off it.

Runs come from the shared simulator with its kinematic plant; between two periods a robot follows an arc, which is
evaluated exactly. Numbers are rounded to 1e-6, so that the files do not depend on a machine's last digit.
"""

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Literal, NamedTuple

import numpy as np

from fuzzy.errors import InputError
from fuzzy.quantity import check_quantities, described, is_number, quantity, whole
from robotics.laws.formation.leader_follower import FormationTeacher, bearings, law, lead
from robotics.plugins.learning.datatable import DataColumn, DataTable
from robotics.plugins.learning.formations import PERIOD, formation_scenario, leader_path
from robotics.simulation.loop import simulate
from robotics.tables.texts import TextFile
from robotics.world.paths.path import compile_path

_STARTS = (-4.0, -2.0, 0.0, 2.0, 4.0)  # m: the leader's x at the start of the five formations
CHECKING = (-1.0,)  # m: the leader's x at the start of the checking set, thesis Fig. 5.9
LITERAL_END = 6.0  # m: the printed centers end at 5.57, and the printed networks leave the curve beyond 6.5
MOST_SAMPLES = 1_000_000  # rows of a formation, or of a table of a scenario
MOST_SEED = 2**63 - 1
_OUTPUTS = ("v_l", "w_l", "v_f", "w_f")
LEARNING_TEXTS = TextFile("robotics.plugins.learning")


class FormationDataError(InputError):
    """Options from which no formation data can be made. The message names the option and what is accepted."""


@dataclass(frozen=True, kw_only=True)
class FormationRecipe:
    """The recipe of a set: the same recipe gives the same numbers.

    Raises FormationDataError for values out of their ranges.
    """

    kind: Literal["literal", "well-posed"] = described(
        "The thesis's formations: literal, or well-posed (with the lead dx, a bearing and a curvature as inputs).",
        "literal",
    )
    starts: tuple[float, ...] = described("The leader's x at the start, m; a formation each.", _STARTS)
    samples: int = whole(400, least=2, most=MOST_SAMPLES, doc="Rows of each formation.")
    speed: float = quantity(
        0.1, "m/s", above=0, most=0.25, doc="Desired speed v_d. The leader drives up to three times as fast."
    )
    # The rest is for the well-posed kind only
    coverage: float = quantity(1.0, "1", least=0, most=1, doc="Share spread over (x_l, dx), the rest along runs.")
    jitter: float = quantity(0.6, "1", least=0, most=1, doc="Share displaced from the path.")
    lateral: float = quantity(0.1, "m", least=0, most=1, doc="Largest displacement, to either side.")
    heading: float = quantity(0.15, "rad", least=0, most=1, doc="Largest rotation, either way.")
    lead: float = quantity(0.5, "m", least=0, most=4, doc="Largest change of dx, of samples along the runs.")
    reach: float = quantity(4.0, "m", above=0, most=10, doc="The farthest dx, either way; x_l begins at −reach.")
    seed: int = whole(0, least=0, most=MOST_SEED, doc="Seed of the displacements and of the cover.")
    stream: int = whole(
        0, least=0, most=MOST_SEED, doc="Which of the seed's random sequences is used; the checking set has 1."
    )

    def __post_init__(self) -> None:
        check_quantities(self, FormationDataError)
        if self.kind not in ("literal", "well-posed"):
            raise FormationDataError(f"kind must be 'literal' or 'well-posed', got {self.kind!r}")
        if not self.starts or not all(is_number(x) and -10 <= x < self.end - 0.1 for x in self.starts):
            raise FormationDataError(
                f"formations are the leader's x at the start in m, each >= -10 and < {self.end - 0.1:.4g}; "
                f"got {list(self.starts)!r}"
            )

    @property
    def end(self) -> float:
        """The leader's x [m] at which a run ends."""
        return LITERAL_END if self.kind == "literal" else PERIOD

    @property
    def inputs(self) -> tuple[str, ...]:
        """The names of the input columns."""
        return ("x_l", "y_l", "theta_l") if self.kind == "literal" else ("dx", "alpha_l", "kappa_f")


def checking_recipe(recipe: FormationRecipe) -> FormationRecipe:
    """The recipe of the checking set that belongs to another: one formation that this does not contain.

    Its samples lie along that formation's run, whatever the coverage.

    Args:
        recipe: The recipe of the set to learn from.
    """
    return replace(recipe, starts=CHECKING, stream=recipe.stream + 1, coverage=0.0)


# What `robotics dataset regenerate` writes
FILES: dict[str, FormationRecipe] = {
    "formation-literal.csv": FormationRecipe(),
    "formation-literal-check.csv": checking_recipe(FormationRecipe()),
    "formation-well-posed.csv": FormationRecipe(kind="well-posed"),
    "formation-well-posed-check.csv": checking_recipe(FormationRecipe(kind="well-posed")),
}


def formation_data(recipe: FormationRecipe) -> DataTable:
    """Make a set of formation data: rows in the order of the formations, then the cover.

    Args:
        recipe: What it is made of.

    Returns:
        The table: the inputs, then the four outputs, in m, rad, 1/m, m/s and rad/s; multiples of 1e-6.
    """
    values = _literal(recipe) if recipe.kind == "literal" else _well_posed(recipe)
    meanings: dict[str, tuple[str, str]] = LEARNING_TEXTS.table("columns")
    columns = [DataColumn(name, *meanings[name], name in _OUTPUTS) for name in recipe.inputs + _OUTPUTS]
    return DataTable(tuple(columns), np.round(values, 6) + 0.0)  # + 0.0: no -0


class FormationRun(NamedTuple):
    """A formation's run until its leader is at the end, sampled evenly in time; robot 1 leads."""

    time: np.ndarray  # (samples,) s
    x: np.ndarray  # (robots, samples) m
    y: np.ndarray  # (robots, samples) m
    heading: np.ndarray  # (robots, samples) rad
    dx: np.ndarray  # (samples,) m, the leader's lead
    v: np.ndarray  # (robots, samples) m/s, commanded


def _literal(recipe: FormationRecipe) -> np.ndarray:
    path = compile_path(leader_path(recipe.end, 10.0))
    rows = []
    for start in recipe.starts:
        run = formation_run(recipe, start, recipe.samples)
        x, v_l, v_f = run.x[0], run.v[0], run.v[1]
        w_l, w_f = v_l * path.beside(x).curvature, v_f * path.beside(x - run.dx).curvature
        rows.append(np.stack([x, run.y[0], run.heading[0], v_l, w_l, v_f, w_f], axis=1))
    return np.concatenate(rows)


def _well_posed(recipe: FormationRecipe) -> np.ndarray:
    rng = np.random.default_rng([recipe.seed, recipe.stream])
    teacher = FormationTeacher(speed=recipe.speed)
    path = compile_path(leader_path(recipe.end + 1.0, 10.0))  # a metre more: displaced followers may be beyond the end
    total = recipe.samples * len(recipe.starts)
    covered = round(recipe.coverage * total)
    shares = np.diff(np.round(np.linspace(0, total - covered, len(recipe.starts) + 1)).astype(int))
    runs = [formation_run(recipe, start, n) for start, n in zip(recipe.starts, shares, strict=True) if n]
    rows = [np.stack([run.x[0], run.y[0], run.heading[0], run.dx]) for run in runs]
    x, y, heading, dx = np.concatenate(rows or [np.empty((4, 0))], axis=1)
    dx = dx + np.where(rng.random(len(dx)) < recipe.jitter, rng.uniform(-recipe.lead, recipe.lead, len(dx)), 0.0)
    x_cover, dx_cover = _cover(recipe, covered, rng)
    point = path.beside(x_cover)
    x, dx = np.concatenate([x, x_cover]), np.concatenate([dx, dx_cover])
    y, heading = np.concatenate([y, point.y]), np.concatenate([heading, point.heading])
    displaced = rng.random(total) < recipe.jitter
    sideways = rng.uniform(-recipe.lateral, recipe.lateral, total) / np.cos(path.beside(x).heading)
    y = y + np.where(displaced, sideways, 0.0)
    heading = heading + np.where(displaced, rng.uniform(-recipe.heading, recipe.heading, total), 0.0)
    alpha, kappa = bearings(path, x, y, heading, teacher.look_ahead), path.beside(x - dx).curvature
    return np.stack([dx, alpha, kappa, *law(dx, alpha, kappa, recipe.speed, teacher.look_ahead)], axis=1)


def _cover(recipe: FormationRecipe, count: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """``count`` pairs (x_l, dx), even over all those whose followers are between x = 0 and the end."""
    kept = np.empty((0, 2))
    while len(kept) < count:
        draws = rng.uniform([-recipe.reach, -recipe.reach], [recipe.end, recipe.reach], (count, 2))
        behind = draws[:, 0] - draws[:, 1]
        kept = np.concatenate([kept, draws[(behind >= 0) & (behind <= recipe.end)]])
    return kept[:count, 0], kept[:count, 1]


def formation_run(recipe: FormationRecipe, start: float, count: int) -> FormationRun:
    """Drive a formation of ``recipe`` and take ``count`` samples of its run.

    Args:
        recipe: What sets the law, the speed and the end.
        start: The leader's x at the start [m].
        count: The number of samples.

    Raises FormationDataError where the leader does not come to the end.
    """
    pose, v, w, period = _driven(recipe.kind, start, recipe.speed, recipe.end)
    k = int(np.argmax(pose[0, 0] >= recipe.end))
    share = (recipe.end - pose[0, 0, k - 1]) / (pose[0, 0, k] - pose[0, 0, k - 1])
    times = np.linspace(0.0, (k - 1 + share) * period, count)
    tick = np.minimum((times / period).astype(int), k - 1)
    x, y, heading = _along_arc(pose[..., tick], v[:, tick], w[:, tick], times - tick * period)
    return FormationRun(times, x, y, heading, lead(x.T), v[:, tick])


@lru_cache(maxsize=16)
def _driven(kind: str, start: float, speed: float, end: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """The poses (3, robots, ticks), v and w (robots, ticks) of a formation's run, and its period [s]."""
    beyond = 0.0 if kind == "literal" else 1.0  # m, the path that a leader at the end still looks ahead to
    scenario = formation_scenario(start, speed, end + beyond)
    teacher = FormationTeacher(speed=speed, speeds="literal" if kind == "literal" else "lead", correction="own-pose")
    run = simulate(scenario, teacher)
    if not (run["x"][0, 0] >= end).any():
        raise FormationDataError(f"the formation from x = {start:g} m did not end within {scenario.duration:g} s")
    pose = np.stack([run["x"][0], run["y"][0], run["heading"][0]])
    return pose, run["command_1"][0], run["command_2"][0], scenario.period


def _along_arc(pose: np.ndarray, v: np.ndarray, w: np.ndarray, dt: np.ndarray) -> np.ndarray:
    """The poses (3, ...) after ``dt`` [s] with constant velocities: the exact solution of thesis (2.27)."""
    x, y, heading = pose
    half = w * dt / 2
    chord = v * dt * np.sinc(half / np.pi)  # sin(half)/half
    return np.stack([x + chord * np.cos(heading + half), y + chord * np.sin(heading + half), heading + 2 * half])
