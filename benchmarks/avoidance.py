"""How do robots that avoid each other compare with ORCA? Circle swaps and random goals, the same robots for all.

Circle swap: N robots on a circle, each to the opposite point. Random goals: starts and goals drawn in 16 m² a robot,
0.9 m between any two starts and any two goals, as in :mod:`robotics.plugins.stress.crossings`. Everybody has the
full plant (wheel loops, motors, limits), the pose with 3 mm and 3 mrad of noise, starts 1 cm off, cruises at 0.22 m/s
and may go twice as fast to avoid.

ORCA [van den Berg 2011] is RVO2 as pyrvo binds it. It moves discs that go any way at once; a robot's disc is therefore
around a point ahead of its axle, whose velocity the wheels can choose at will [Snape 2010]. The disc holds the whole
rectangle, and so is larger than the robot. What ORCA is given is favourable to it: poses and speeds of all, without
delay or loss. "keeping right" turns what it prefers by 0.15 rad, which breaks symmetries. Its horizon, lead and margin
were chosen by hand from fifteen settings, tried on some of these cases and on others with other seeds.

Our laws follow paths and talk by radio, a period late. They get the straight line from start to goal, and everything
of them is as it comes. Right of way bends the lines by itself where they have no plan: that robots go round where many
meet was made for these circles. "roundabout" gives it, on circle swaps, paths that already keep to the right around the
middle, by hand.

A run succeeds if all arrive within 4 times the time that the longest straight line takes, and no two rectangles ever
touch.

Run ``python -m benchmarks.avoidance [--quick] [--json]``.
"""

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from importlib.util import find_spec
from statistics import median
from typing import Any, NamedTuple

import numpy as np

from benchmarks.reporting import heading, machine, start
from robotics.laws.catalogue import make_controller
from robotics.laws.law import Command, Law, Observation
from robotics.laws.setting import Setting
from robotics.plugins.stress.crossings import APART, AREA, ASPECT, SPEED
from robotics.plugins.stress.outcome import StressOutcome
from robotics.plugins.stress.quintic_table import quintic_table
from robotics.plugins.stress.tally import run_ensemble
from robotics.simulation.scenario.description import Member, Scenario
from robotics.world.paths.joined import join_tables
from robotics.world.paths.path import Quintic
from robotics.world.paths.references import Reference, even_timing
from robotics.world.paths.trajectory import Timing
from robotics.world.sensing.posture import Sensing

FASTEST = 2 * SPEED  # m/s: a plan of right of way moves two cells a tick at most
ROOM, SMALLEST = 0.75, 2.0  # m of a circle's circumference a robot; its least radius
CASE_STREAM = 9  # of a seed's random streams: see robotics.world.radio.channel
SEEDS = {3: 20, 10: 20, 50: 2}  # by how many robots
QUICK = {3: 4, 10: 4}


@dataclass(frozen=True, kw_only=True)
class Orca(Law[list[Any]]):
    """ORCA for differential drives, through a point ahead of the axle; all robots of a run in one RVO2 simulator."""

    lead: float = 0.04  # m: from the axle's midpoint to the point
    margin: float = 0.01  # m: the disc is so much larger than the rectangle needs
    horizon: float = 5.0  # s
    neighbours: int = 10
    sight: float = 4.0  # m
    right: float = 0.0  # rad: by how much the preferred velocity is turned to the right
    gain: float = 1.0  # 1/s: how the preferred speed falls near the goal

    def init(self, setting: Setting, runs: int) -> list[Any]:
        """A simulator a run; its agents are set afresh in every period."""
        from pyrvo import RVOSimulator

        body = setting.robots[0]
        radius = np.hypot(self.lead + body.length / 2, body.width / 2) + self.margin
        shared = (setting.period, self.sight, self.neighbours, self.horizon, self.horizon, float(radius), FASTEST)
        simulators = [RVOSimulator(*shared) for _ in range(runs)]
        for simulator in simulators:
            for _ in setting.robots:
                simulator.add_agent((0.0, 0.0))
        return simulators

    def control(self, seen: Observation, memory: list[Any], dt: float) -> tuple[Command, list[Any]]:
        """The velocity that ORCA finds for each point, as the v and ω that give it that."""
        cos, sin = np.cos(seen.heading), np.sin(seen.heading)
        x, y = seen.x + self.lead * cos, seen.y + self.lead * sin
        v_x, v_y = seen.v * cos - self.lead * seen.w * sin, seen.v * sin + self.lead * seen.w * cos
        # The axle's midpoint shall come to the goal, and the point as far beyond it as the robot is heading.
        goal = seen.references.each_at(np.full(seen.x.shape, np.inf))
        dx, dy = goal.x - seen.x, goal.y - seen.y
        gap = np.hypot(dx, dy) + 1e-9
        speed = np.minimum(SPEED, self.gain * gap) / gap
        # A bias for ever would be a spiral; near the goal there is none.
        turn = self.right * np.minimum(1.0, gap)
        turned, across = np.cos(turn), np.sin(turn)
        wish_x, wish_y = speed * (turned * dx + across * dy), speed * (turned * dy - across * dx)
        velocity = np.empty((2, *seen.x.shape))
        rows = np.stack([x, y, v_x, v_y, wish_x, wish_y], axis=-1).tolist()
        for run, simulator in enumerate(memory):
            for i, (p_x, p_y, u_x, u_y, w_x, w_y) in enumerate(rows[run]):
                simulator.set_agent_position(i, (p_x, p_y))
                simulator.set_agent_velocity(i, (u_x, u_y))
                simulator.set_agent_pref_velocity(i, (w_x, w_y))
            simulator.do_step()
            for i in range(len(rows[run])):
                velocity[:, run, i] = simulator.get_agent_velocity(i).to_tuple()
        v = cos * velocity[0] + sin * velocity[1]
        w = (cos * velocity[1] - sin * velocity[0]) / self.lead
        rest = np.zeros_like(v)
        return Command(v, w, v, w, target=Reference(seen.x, seen.y, seen.heading, rest, rest, rest)), memory


class Entrant(NamedTuple):
    """Who takes part, and by which paths."""

    name: str
    law: Law[Any]
    roundabout: bool = False  # on circle swaps, and nowhere else

    def takes_part(self, case: str) -> bool:
        """Does it take part in ``case``?"""
        return case == "circle swap" or not self.roundabout


@dataclass
class Clocked:
    """A controller that keeps the processor time that it takes."""

    law: Any
    planning: float = 0.0  # s, before the start
    deciding: float = 0.0  # s
    decisions: int = 0  # a robot's, in one period

    def __getattr__(self, name: str) -> Any:
        return getattr(self.law, name)

    def init(self, setting: Setting, runs: int) -> Any:
        """The law's, timed."""
        began = time.process_time()
        memory = self.law.init(setting, runs)
        self.planning += time.process_time() - began
        return memory

    def control(self, seen: Observation, memory: Any, dt: float) -> tuple[Command, Any]:
        """The law's command, timed."""
        began = time.process_time()
        result: tuple[Command, Any] = self.law.control(seen, memory, dt)
        self.deciding += time.process_time() - began
        self.decisions += seen.x.size
        return result


def entrants() -> list[Entrant]:
    """Those that can take part here: ORCA only where pyrvo is installed."""
    orca = [Entrant("ORCA", Orca()), Entrant("ORCA, keeping right", Orca(right=0.15))]
    return [
        *(orca if find_spec("pyrvo") else []),
        Entrant("right of way", make_controller("right-of-way")),
        Entrant("right of way, roundabout", make_controller("right-of-way"), True),
        Entrant("crash avoidance, literal", make_controller("crash-literal")),
        Entrant("crash avoidance, yielding", make_controller("crash-yielding")),
    ]


def circle_swap(robots: int, seeds: Sequence[int]) -> tuple[np.ndarray, np.ndarray]:
    """Starts and goals (runs, robots, 2) [m] on a circle: the same for every seed, as the noise is not."""
    radius = max(SMALLEST, robots * ROOM / (2 * np.pi))
    angle = 2 * np.pi * np.arange(robots) / robots
    starts = np.tile(radius * np.stack([np.cos(angle), np.sin(angle)], axis=1), (len(seeds), 1, 1))
    return starts, -starts


def random_goals(robots: int, seeds: Sequence[int]) -> tuple[np.ndarray, np.ndarray]:
    """Starts and goals (runs, robots, 2) [m] anywhere in the field, each pair at least 2 m apart."""
    field = np.sqrt(AREA * robots * np.array([ASPECT, 1 / ASPECT]))
    drawn = np.empty((2, len(seeds), robots, 2))
    for k, seed in enumerate(seeds):
        rng = np.random.default_rng([seed, CASE_STREAM])
        for i in range(robots):
            while True:
                pair = rng.uniform(0.0, 1.0, (2, 2)) * field
                apart = np.hypot(*np.moveaxis(drawn[:, k, :i] - pair[:, None], -1, 0)) >= APART
                if apart.all() and np.hypot(*(pair[1] - pair[0])) >= 2.0:
                    break
            drawn[:, k, i] = pair
    return drawn[0], drawn[1]


CASES = {"circle swap": circle_swap, "random goals": random_goals}


def ensemble(starts: np.ndarray, goals: np.ndarray, roundabout: bool = False) -> Setting:
    """The robots on straight paths, or on paths that go around the middle as wide as they must on a circle swap.

    A quintic whose tangents are h times its chord to the right and to the left bows out by 5 h / 16 chords.
    """
    gap = goals - starts
    aside = np.stack([gap[..., 1], -gap[..., 0]], axis=-1)  # to the right
    radius = starts.shape[1] * ROOM / (2 * np.pi) if roundabout else 0.0
    share = radius * 16 / 5 / np.hypot(*np.moveaxis(gap, -1, 0))[..., None]
    along = np.sqrt(np.maximum(1 - share**2, 0.01)) * gap
    out, into = along + share * aside, along - share * aside
    tables = [
        [
            quintic_table(Quintic(start=tuple(a), end=tuple(b), start_tangent=tuple(c), end_tangent=tuple(d)))
            for a, b, c, d in zip(*run, strict=True)
        ]
        for run in zip(starts.tolist(), goals.tolist(), out.tolist(), into.tolist(), strict=True)
    ]
    paths = join_tables(tables)
    durations = paths.lengths.max(axis=1) / SPEED
    poses = np.array([[table[:3, 0] for table in run] for run in tables])
    longest = float(np.ceil(durations.max()))
    shared = Member(
        start=(0.0, 0.0, 0.0),
        path=Quintic(start=(0.0, 0.0), end=(SPEED * longest, 0.0)),
        timing=Timing(duration=longest),
    )
    scenario = Scenario(
        name="avoidance",
        robots=(shared,) * starts.shape[1],
        duration=4 * longest,
        kind="team",
        divergence=1e3,
        sensing=Sensing(posture="pose", position_noise=0.003, heading_noise=0.003, start_position=0.01),
    )
    return replace(scenario.setting, starts=poses, references=even_timing(paths, durations))


def entered(entrant: Entrant, case: str, robots: int, seeds: Sequence[int]) -> dict[str, Any]:
    """One line of the table: what became of ``entrant`` with every seed."""
    starts, goals = CASES[case](robots, seeds)
    clocked: Any = Clocked(entrant.law)
    course = ensemble(starts, goals, entrant.roundabout)
    outcome = run_ensemble(StressOutcome, course, clocked, seeds)
    straight = np.hypot(*np.moveaxis(goals - starts, -1, 0)).max(axis=1) / SPEED
    return figures(outcome, straight) | {
        "case": case,
        "robots": robots,
        "entrant": entrant.name,
        "planning_s": clocked.planning / len(seeds),
        "deciding_ms": 1e3 * clocked.deciding / (clocked.decisions * course.period),
    }


def figures(outcome: StressOutcome, straight: np.ndarray) -> dict[str, Any]:
    """What counts of ``outcome``; ``straight`` (runs,) [s] is how long the longest straight line takes."""
    ratio = outcome.arrivals.max(axis=1) / straight
    good = outcome.arrived & ~outcome.collided & (ratio <= 4.0)
    moving = ~outcome.refused
    return {
        "runs": len(straight),
        "success": float(good.mean()),
        "collisions": int(outcome.collided.sum()),
        "refused": int(outcome.refused.sum()),
        "late": int((moving & ~(ratio <= 4.0)).sum()),
        "makespan": median(ratio[good].tolist()) if good.any() else None,
        "min_distance_m": median(outcome.min_distance[moving].tolist()) if moving.any() else None,
        "worst_distance_m": float(outcome.min_distance[moving].min()) if moving.any() else None,
    }


def measure(seeds: dict[int, int] = SEEDS) -> dict[str, Any]:
    """Every line of the table."""
    takers = entrants()
    for taker in takers:  # the first call compiles
        entered(taker, "circle swap", 3, range(1))
    rows = [
        entered(taker, case, robots, range(count))
        for case in CASES
        for robots, count in seeds.items()
        for taker in takers
        if taker.takes_part(case)
    ]
    return machine(["numpy", "numba", "pyrvo"]) | {"rows": rows}


def report(result: dict[str, Any]) -> str:
    """The table."""
    titles = (
        f"{'seeds':>6}{'success':>9}{'touch':>7}{'refused':>9}{'late':>6}{'makespan':>10}{'nearest':>9}{'worst':>7}"
    )
    lines = [
        heading(result),
        "Makespan: over the longest straight line at 0.22 m/s, median of the successes; nearest: median and worst",
        "distance of two centers [m]; plan: s before the start; CPU: ms a robot and second, all seeds in one pass",
    ]
    if result["versions"]["pyrvo"] == "not installed":
        lines.append("pyrvo is not installed (`make bench` does): ORCA is left out")
    last = None
    for row in result["rows"]:
        group = (row["case"], row["robots"])
        if group != last:
            title = f"{row['case']}, {row['robots']} robots"
            lines += ["", f"{title:28}{titles}{'plan':>8}{'CPU':>8}"]
        last = group
        lines.append(
            f"  {row['entrant']:26}{row['runs']:>6}{100 * row['success']:>7.0f} %{row['collisions']:>7}"
            f"{row['refused']:>9}{row['late']:>6}{_number(row['makespan']):>10}{_number(row['min_distance_m']):>9}"
            f"{_number(row['worst_distance_m']):>7}{row['planning_s']:>8.2f}{row['deciding_ms']:>8.3f}"
        )
    return "\n".join(lines)


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.2f}"


if __name__ == "__main__":
    start(__doc__, lambda quick: measure(QUICK if quick else SEEDS), report, "few seeds, and no 50 robots")
