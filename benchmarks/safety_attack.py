"""Attack passive safety: laws that drive at random, or try to hit, in random runs of all families, with all robots.

One of the laws is the fuzzy team with other numbers in all of its rule bases, drawn anew for every call.

    python benchmarks/safety_attack.py 1000                 # runs of each family and law, with the monitor
    python benchmarks/safety_attack.py 200 --without        # the same without: the job fails
    python benchmarks/safety_attack.py 200 --family discs --robot mir100

Counted are contacts that robots caused: the motion of the robot alone leads to it. Told beside them are those of a
robot that moved, by more than 0.02 m/s (moving), and those in which what is assumed was broken before: with an obstacle
that had given no echo for a second, as no cone of the robot's sensors met it, or too steeply (unseen), or not the part
of it that touches (partly), or that had run into the robot before, and so into its body, which no real one does
(overlapped).
"""

import argparse
import json
import math
import time
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from fuzzy.compiled.columns import Columns, column
from fuzzy.compiled.jit import compiled_only
from fuzzy.quantity import quantity
from robotics.laws.equation import EquationLaw, HeardColumns, equation
from robotics.laws.knowledge import Safe
from robotics.laws.law import Law
from robotics.laws.rules.fuzzy_team import FuzzyTeam
from robotics.laws.setting import Setting
from robotics.plugins.stress.crossings import crossing_ensemble
from robotics.plugins.stress.disturbance import UNDISTURBED, Disturbance
from robotics.plugins.stress.obstaclecourse import ObstacleOutcome, obstacle_ensemble
from robotics.plugins.stress.outcome import StressOutcome
from robotics.plugins.stress.tally import Tally, run_ensemble
from robotics.simulation.loop import Simulation
from robotics.simulation.safety.assumptions import AT_REST
from robotics.simulation.safety.view import seen
from robotics.simulation.scenario.robots import load_robot
from robotics.world.environment.collision import footprints, obstacle_clearance
from robotics.world.environment.world import Geometry
from robotics.world.paths.posture import wrapped_compiled
from robotics.world.radio.faults import Faults
from robotics.world.sensing.carried import sensor_names
from robotics.world.vehicle.plant import TruthColumns

ROBOTS = ("etsro", "pioneer-3dx", "turtlebot3-burger", "mir100")
LAWS = ("random", "raging", "ramming", "chasing", "rules")  # kinds of BadLaw, and a team of shuffled rule bases
BROKEN = ("unseen", "partly", "overlapped")
TOUCHING = 0.02  # m: so much farther from the robot than the nearest point of it is the part of a disc that touches
LATELY = 1.0  # s: what was not in view for so long, no sensor has told of
HARD = Disturbance(loss=0.2, latency=0.3, freeze=8.0)


class Whims(Columns):
    """What a bad law remembers."""

    dice = column("1", "the state of its generator")
    v = column("m/s")
    w = column("rad/s")
    left = column("s", "for how long it goes on so")


class Told(Columns):
    """What it broadcasts."""

    x = column("m")
    y = column("m")


class HeardTold(HeardColumns):
    """The same as others hear it."""

    x = column("m")
    y = column("m")


class Powers(Columns):
    """What its robot can do."""

    v_max = column("m/s")
    w_max = column("rad/s")
    sensors = column("", "how many it reads")


@compiled_only
def thrown(memory):  # type: ignore[no-untyped-def]
    """A random number from 0 to 1: Park and Miller's generator."""
    memory.dice = (memory.dice * 16807.0) % 2147483647.0
    return memory.dice / 2147483647.0


@equation
def misbehave(robot, aim, gain, memory, command, known, i):  # type: ignore[no-untyped-def]
    """Drive as the law's kind says."""
    if memory.left <= 0:
        memory.left = 0.05 + 1.5 * thrown(memory) ** 2
        memory.v, memory.w = gain.v_max * (2 * thrown(memory) - 1), gain.w_max * (2 * thrown(memory) - 1) ** 3
        if thrown(memory) < 0.2:
            memory.v = 0.0
        if thrown(memory) < 0.3:
            memory.w = 0.0
    memory.left -= known.dt
    v, w = memory.v, memory.w
    if gain.kind == 1:  # full speed ahead, turning at random
        v, w = gain.v_max, 0.5 * w
    goal_x, goal_y, wants = aim.x, aim.y, gain.kind >= 2
    if gain.kind == 3:  # after the nearest robot
        nearest = math.inf
        for j in range(known.heard.shape[2]):
            heard = HeardTold(known.heard, i, j)
            if heard.age < math.inf:
                distance = math.hypot(heard.x - robot.x, heard.y - robot.y)
                if distance < nearest:
                    nearest, goal_x, goal_y = distance, heard.x, heard.y
    bearing = wrapped_compiled(math.atan2(goal_y - robot.y, goal_x - robot.x) - robot.heading)
    if gain.kind == 2:  # at the nearest echo
        nearest = math.inf
        for n in range(int(gain.sensors)):
            if known.ranges[n, i] < nearest:
                nearest, bearing = known.ranges[n, i], known.tables[known.table[i], n]
    if wants and memory.left > 0.2:
        w = min(max(4 * bearing, -gain.w_max), gain.w_max)
        v = gain.v_max * max(math.cos(bearing), 0.0)
    command.first, command.second, command.wish_v, command.wish_w = v, w, v, w
    say = command.say
    say.x, say.y = robot.x, robot.y


@dataclass(frozen=True, kw_only=True, eq=False)
class BadLaw(EquationLaw):
    """A law that drives at random, or tries to hit something."""

    kind: float = quantity(0.0, "1", least=0, most=3)
    dice: float = quantity(1.0, "1", least=1)
    equation = misbehave
    derived = Powers
    remembers = Whims
    says = Told
    looks = True

    def derive(self, setting: Setting) -> dict[str, Any]:
        """The robots' top speeds, and how many sensors are read."""
        robots = setting.robots
        return {
            "v_max": np.array([r.v_max for r in robots]),
            "w_max": np.array([r.w_max for r in robots]),
            "sensors": float(len(self.reads(setting))),
        }

    def reads(self, setting: Setting) -> tuple[str, ...]:
        """All range sensors that there are."""
        return sensor_names(setting.sensors) if setting.world is not None else ()

    def tables(self, setting: Setting) -> np.ndarray:
        """Where they look [rad]."""
        carried = setting.sensors[0]
        return np.array([[carried[name].axis for name in self.reads(setting)]])

    def begin(self, setting: Setting, runs: int) -> np.ndarray:
        """A state of its own for each generator."""
        memory = np.zeros((Whims.size, runs, len(setting.robots)))
        memory[0] = np.random.default_rng(int(self.dice)).integers(1, 2147483646, memory.shape[1:])
        return memory


def shuffled_team(dice: int, safe: Safe) -> FuzzyTeam:
    """The fuzzy team, in all of whose rule bases the numbers of the consequents are drawn from their universes."""
    rng, team = np.random.default_rng(dice), FuzzyTeam()
    bases: dict[str, Any] = {}
    for task, fis in team.fuzzy_systems.items():
        outputs = [replace(v, terms={t: float(rng.uniform(*v.universe)) for t in v.terms}) for v in fis.outputs]
        bases[f"{task}_rule_base"] = replace(fis, outputs=outputs)
    return replace(team, safe=safe, **bases)


@dataclass(frozen=True)
class Family:
    """A kind of random runs."""

    name: str
    seconds: float  # the longest that a run takes

    def drawn(self, seeds: range, robot: str) -> tuple[Setting, Disturbance]:
        """The runs of these seeds."""
        model, number = load_robot(robot), 3 if self.name not in ("field", "trap", "disc") else 1
        dice = np.random.default_rng([seeds.start, 99])
        worse = UNDISTURBED
        if self.name in ("crossing-bad", "courses-bad"):
            worse = Disturbance(
                loss=float(dice.uniform(0, 0.4)), latency=float(0.05 * dice.integers(0, 13)), freeze=5.0
            )
        if self.name == "hard":
            worse = HARD
        if self.name.startswith("crossing"):
            ensemble = crossing_ensemble(3, seeds, "A", disturbance=worse, robot=model)
        else:
            kind: Any = "U" if self.name == "trap" else "B" if self.name == "overlapping" else "A"
            ensemble = obstacle_ensemble(
                seeds, kind, number, disturbance=worse, robot=model, moving=2 if self.name in ("hard", "disc") else 0,
                lanes="crossing" if number > 1 else "beside",
            )  # fmt: skip
        latency = 0.0 if self.name in ("field", "crossing") else float(0.01 * dice.integers(0, 31))
        ticks = min(ensemble.ticks, round(self.seconds / ensemble.period))
        return replace(ensemble, latency=latency, ticks=ticks, divergence=1e6), worse


FAMILIES = [
    Family(name, 25.0)
    for name in ("field", "trap", "disc", "crossing", "crossing-bad", "courses-bad", "overlapping", "hard")
]


def attack(family: Family, robot: str, law: str, count: int, first: int, safe: Safe) -> dict[str, Any]:
    """Drive ``count`` runs; tell how many ended with a contact that a robot caused."""
    seeds = range(first, first + count)
    setting, worse = family.drawn(seeds, robot)
    driver: EquationLaw = (
        BadLaw(kind=float(LAWS.index(law)), dice=1.0 + first, safe=safe)
        if law != "rules"
        else (shuffled_team(first, safe))
    )
    kind = ObstacleOutcome if setting.world is not None else StressOutcome
    begin = time.perf_counter()
    faults = worse.faults(setting, seeds)
    outcome = run_ensemble(kind, setting, driver, seeds, faults)
    caused, touched = outcome.caused.any(axis=1), outcome.collided
    if isinstance(outcome, ObstacleOutcome):
        touched = touched | outcome.hit
    runs = list(map(int, np.flatnonzero(caused) if safe == "yes" else ()))
    broken = [broken_assumption(setting, driver, seeds, faults, run) for run in runs]
    moving = [contact_speed(setting, driver, seeds, faults, run) > AT_REST for run in runs]
    return {
        "family": family.name, "robot": robot, "law": law, "runs": count, "first": first, "safe": safe,
        "caused": int(caused.sum()), "moving": sum(moving), **{name: broken.count(name) for name in BROKEN},
        "touched": int(touched.sum()), "seeds": np.array(outcome.seeds)[caused][:20].tolist(),
        "seconds": round(time.perf_counter() - begin, 1),
    }  # fmt: skip


def _replayed(setting: Setting, driver: Law[Any], seeds: range, faults: Faults | None) -> tuple[Tally, Simulation]:
    """Runs once more from their start, and what is judged of them."""
    tally = Tally(setting, ObstacleOutcome.longest(setting, 0.0), 0, len(seeds))
    return tally, Simulation(setting, driver, tuple(seeds), faults, observers=[tally.observer])


def contact_speed(setting: Setting, driver: Law[Any], seeds: range, faults: Faults | None, run: int) -> float:
    """How fast [m/s] the fastest point of a robot was that caused its contact, before or after that period."""
    tally, simulation = _replayed(setting, driver, seeds, faults)
    radii, now = np.array([robot.turning_circle for robot in setting.robots]), np.zeros(len(setting.robots))
    for _ in simulation.periods():
        truth = TruthColumns(simulation.rows(simulation.lanes.body.truth))
        before, now = now, np.abs(truth.v[run]) + radii * np.abs(truth.w[run])
        if tally.caused[run].any():
            return float(np.maximum(before, now)[tally.caused[run]].max())
    return 0.0


def broken_assumption(setting: Setting, driver: Law[Any], seeds: range, faults: Faults | None, run: int) -> str:
    """What was broken before a robot of a run caused its contact, one of BROKEN; "" if nothing was.

    "overlapped": the same obstacle or robot had touched it before. "unseen": none of its sensors could have heard the
    obstacle for LATELY, in its cone and not too steep; "partly": what it touches of the obstacle.
    """
    tally, simulation = _replayed(setting, driver, seeds, faults)
    sizes = footprints(setting.robots)
    since = tally.known.watch.contacts.since[run]
    last, touching, touched = None, np.zeros(len(since), dtype=bool), np.zeros(len(since), dtype=bool)
    for k, _ in simulation.periods():
        begun = ~np.isnan(since) & ~touching
        if tally.caused[run].any() and (touched[begun].any() if begun.any() else touched.any()):
            return "overlapped"  # where none begun is left it was for a hair, within a period
        touching = ~np.isnan(since)
        touched |= touching
        if setting.world is None:
            continue
        now, time = TruthColumns(simulation.rows(simulation.lanes.body.truth)), k * setting.period
        here = Geometry(*setting.world.at(time))
        surface, facing, body = surfaces(here, run % len(here.counts))
        last = np.full((len(setting.robots), len(surface)), -np.inf) if last is None else last
        turn = np.exp(-1j * now.heading[run])[:, None]
        own, faces = (surface - (now.x[run] + 1j * now.y[run])[:, None]) * turn, np.angle(np.exp(1j * facing) * turn)
        for i, sensors in enumerate(setting.sensors):
            last[i, seen(list(sensors.values()), own[i].real, own[i].imag, faces[i])] = time
        if tally.caused[run].any():
            i = int(np.argmax(tally.caused[run]))
            gap = obstacle_clearance(now.x, now.y, now.heading, sizes, here)[run, i]
            away = np.hypot(*np.maximum(np.abs([own[i].real, own[i].imag]) - sizes[:2, i, None], 0.0))
            whole = body == body[np.argmin(away)]
            touches = whole & (away < away.min() + TOUCHING)
            if gap > 0.01 or time - last[i, touches].max() <= LATELY:
                return ""
            return "unseen" if time - last[i, whole].max() > LATELY else "partly"
    return ""


def surfaces(geometry: Geometry, run: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points of the obstacles' surfaces x + iy [m] (points,), where they face [rad], and of which body they are."""
    found = []
    for n in range(geometry.counts[run]):
        (x, y, radius), (first, number, closed, _) = geometry.circles[run, n], geometry.bodies[run, n]
        if number == 0:
            facing = np.linspace(0, 2 * np.pi, 60)
            found.append((x + 1j * y + radius * np.exp(1j * facing), facing, n))
            continue
        ends = geometry.segments[run, first : first + number]
        begin, along = ends[:, 0] + 1j * ends[:, 1], ends[:, 2] - ends[:, 0] + 1j * (ends[:, 3] - ends[:, 1])
        points = (begin[:, None] + along[:, None] * np.linspace(0, 1, 30)).ravel()
        for side in (-1j,) if closed else (-1j, 1j):
            found.append((points, np.repeat(np.angle(side * along), 30), n))
    bodies = [np.full(len(points), n) for points, _, n in found]
    return np.concatenate([f[0] for f in found]), np.concatenate([f[1] for f in found]), np.concatenate(bodies)


def main() -> None:
    """Read the command line, and attack."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("runs", type=int, help="of each family, robot and law")
    parser.add_argument("--first", type=int, default=0, help="the first seed")
    parser.add_argument("--without", action="store_true", help="without the monitor")
    parser.add_argument("--family", choices=[f.name for f in FAMILIES])
    parser.add_argument("--robot", choices=ROBOTS)
    parser.add_argument("--law", choices=LAWS)
    parser.add_argument("--out", help="a file to which each row is added, as JSON")
    asked = parser.parse_args()
    total, caused, told = 0, 0, dict.fromkeys(("moving", *BROKEN), 0)
    for family, robot, law in product(FAMILIES, ROBOTS, LAWS):
        if asked.family not in (None, family.name) or asked.robot not in (None, robot) or asked.law not in (None, law):
            continue
        if law == "ramming" and family.name.startswith("crossing"):
            continue  # there is nothing to see
        row = attack(family, robot, law, asked.runs, asked.first, "no" if asked.without else "yes")
        print(json.dumps(row), flush=True)
        if asked.out:
            with Path(asked.out).open("a", encoding="utf-8") as file:
                file.write(json.dumps(row) + "\n")
        total, caused = total + row["runs"], caused + row["caused"]
        told = {name: count + row[name] for name, count in told.items()}
    which = ", ".join(f"{count} of them {name}" for name, count in told.items())
    print(f"{caused} of {total} runs with a contact that a robot caused, {which}")


if __name__ == "__main__":
    main()
