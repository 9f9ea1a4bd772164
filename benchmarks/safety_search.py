"""Search for the worst: CMA-ES over orders, obstacles and a disc, for the least gap into which a robot moves.

    python benchmarks/safety_search.py 2000                    # scenarios for each robot, with the monitor
    python benchmarks/safety_search.py 500 --without --robot etsro

Two robots are given twelve orders each, among two boxes and, where their sensors see all round, a disc that moves. The
cost is the least gap [m] that a robot's own motion made smaller, all else held where it was; 0 or less is a contact.
It is judged until something has run into the robot: a disc then passes into its body, which no real one does.
"""

import argparse
import json
import time
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from benchmarks.safety_attack import ROBOTS
from fuzzy.tuning.engines import CmaEs
from fuzzy.tuning.parameter import SearchParameter
from robotics.laws.knowledge import Safe
from robotics.laws.law import Command, Law
from robotics.plugins.stress.crossings import growth
from robotics.simulation.loop import Simulation
from robotics.simulation.safety.assumptions import AT_REST
from robotics.simulation.safety.coverage import blind_directions
from robotics.simulation.scenario.description import Member, Scenario
from robotics.simulation.scenario.robots import load_robot
from robotics.world.environment.collision import footprints, obstacle_clearance, robot_clearance
from robotics.world.environment.world import Disc, Geometry, Polygon, World, box, compile_worlds
from robotics.world.paths.path import Line
from robotics.world.paths.trajectory import Timing
from robotics.world.radio.description import Radio
from robotics.world.vehicle.plant import TruthColumns

ORDERS, SECONDS = 12, 12.0  # of a script, and how long it takes
AROUND = 0.35  # m of an EtsRo: nothing is nearer to a start, whose surroundings are taken for free
DISC_SPEED = 0.2  # m/s, at most
LESS = 1e-5  # m: by which its own motion has to make a gap smaller


@dataclass(frozen=True, kw_only=True, eq=False)
class Scripted(Law[None]):
    """Orders that were written before: as shares of the top speeds (runs, robots, orders, 2)."""

    script: np.ndarray
    seconds: float  # of each order
    safe: Safe = "yes"

    def control(self, seen: Any, memory: None, dt: float) -> tuple[Command, None]:
        """The order of this moment."""
        now = min(int(seen.time / self.seconds), self.script.shape[2] - 1)
        v, w = self.script[:, :, now, 0], self.script[:, :, now, 1]
        return Command(v, w, v, w), memory


class Search:
    """The scenarios of one robot."""

    def __init__(self, name: str, safe: Safe) -> None:
        self.model = load_robot(name)
        robot = self.model.robot
        self.scale, self.safe = growth(self.model), safe
        self.discs = not blind_directions(robot, self.model.sensors)
        away = 1.2 * self.scale
        members = tuple(
            Member(
                start=start, path=Line(start=(0.0, 0.0), end=(1.0, 0.0)), timing=Timing(speed=0.1), robot=robot,
                model=self.model,
            )
            for start in ((-away, 0.0, 0.0), (away, 0.0, np.pi))
        )  # fmt: skip
        scenario = Scenario(name="search", robots=members, duration=SECONDS, divergence=1e6, radio=Radio(loss=0.1))
        # What is assumed: surfaces send an echo at any angle
        sensors = {name: replace(one, incidence=np.pi / 2) for name, one in self.model.sensors.items()}
        self.setting = replace(scenario.setting, sensors=(sensors,) * 2)
        self.size = 4 * ORDERS + 8 + 4 * self.discs

    def world(self, at: np.ndarray) -> World:
        """The obstacles of one point in unit coordinates."""
        found: list[Any] = []
        for x, y, heading, size in at[:8].reshape(2, 4):
            half = self.scale * (0.15 + 0.2 * size)
            place = self._clear(3 * self.scale * np.array([x - 0.5, y - 0.5]), half * np.sqrt(2))
            found.append(Polygon(corners=box(2 * half, 2 * half), position=place, heading=float(heading * np.pi)))
        if self.discs:
            x, y, course, speed = at[8:]
            step = np.array([np.cos(2 * np.pi * course), np.sin(2 * np.pi * course)])
            speed = 0.02 + (DISC_SPEED - 0.02) * float(speed)
            start = self._clear(3 * self.scale * np.array([x - 0.5, y - 0.5]), 0.25 * self.scale)
            end = np.array(start) + (speed * SECONDS + 1.0) * step
            path = Line(start=start, end=(float(end[0]), float(end[1])))
            found.append(Disc(radius=0.25 * self.scale, path=path, timing=Timing(speed=speed)))
        return World(obstacles=tuple(found), known=False)

    def _clear(self, place: np.ndarray, radius: float) -> tuple[float, float]:
        """The place, moved away from the two starts."""
        for start in (np.array([-1.2, 0.0]), np.array([1.2, 0.0])):
            away, least = place - self.scale * start, radius + AROUND * self.scale
            far = float(np.hypot(*away))
            if far < least:
                place = self.scale * start + away * (least / max(far, 1e-9))
        return float(place[0]), float(place[1])

    def costs(self, points: np.ndarray, seed: int) -> np.ndarray:
        """The least gap [m] into which a robot moves, of every point (points, parameters) in unit coordinates."""
        runs, robot = len(points), self.model.robot
        script = 2 * points[:, : 4 * ORDERS].reshape(runs, 2, ORDERS, 2) - 1
        script = script * [robot.v_max, robot.w_max]
        world = compile_worlds([self.world(at) for at in points[:, 4 * ORDERS :]])
        setting = replace(self.setting, world=world)
        law = Scripted(script=script, seconds=SECONDS / ORDERS, safe=self.safe)
        simulation = Simulation(setting, law, tuple(range(seed, seed + runs)))
        sizes, least, before = footprints(setting.robots), np.full(runs, np.inf), None
        untouched = np.ones((runs, 2), dtype=bool)
        for k, _ in simulation.periods():
            now = TruthColumns(simulation.rows(simulation.lanes.body.truth).copy())
            here = Geometry(*world.at(k * setting.period))
            if before is not None:
                moves = np.abs(before[0].v) + robot.turning_circle * np.abs(before[0].w) > AT_REST
                for i in range(2):
                    least = np.minimum(least, self._into(before, now, sizes, i, moves[:, i] & untouched[:, i]))
            untouched &= obstacle_clearance(now.x, now.y, now.heading, sizes, here) > 0
            before = now, here
        return least

    def _into(self, before: Any, now: Any, sizes: np.ndarray, i: int, moves: np.ndarray) -> np.ndarray:
        """The gap of robot ``i`` (runs,) that its motion alone has made smaller; infinite where it has not."""
        old, here = before
        was = old.x, old.y, old.heading
        came = was[0].copy(), was[1].copy(), was[2].copy()
        for a, b in zip(came, (now.x, now.y, now.heading), strict=True):
            a[:, i] = b[:, i]
        found = np.full(len(moves), np.inf)
        for first, last in (
            (robot_clearance(*was, sizes), robot_clearance(*came, sizes)),
            (obstacle_clearance(*was, sizes, here), obstacle_clearance(*came, sizes, here)),
        ):
            nearer = moves & (last[:, i] < first[:, i] - LESS)
            found = np.where(nearer, np.minimum(found, last[:, i]), found)
        return found


def search(name: str, count: int, seed: int, safe: Safe) -> dict[str, Any]:
    """Try ``count`` scenarios of one robot; tell the least gap, and how many ended in a contact."""
    searched, begin = Search(name, safe), time.perf_counter()
    starts = np.random.default_rng(seed).uniform(0.1, 0.9, searched.size).tolist()
    engine = CmaEs([SearchParameter(name=str(n), start=start) for n, start in enumerate(starts)], seed)
    tried, contacts, best = 0, 0, np.inf
    while tried < count:
        points = engine.ask()
        costs = searched.costs(points, seed + tried)
        engine.tell(points, costs[:, None])
        tried, contacts, best = tried + len(points), contacts + int((costs <= 0).sum()), min(best, float(costs.min()))
    return {
        "robot": name, "seed": seed, "scenarios": tried, "safe": safe, "contacts": contacts, "least": round(best, 4),
        "seconds": round(time.perf_counter() - begin, 1),
    }  # fmt: skip


def main() -> None:
    """Read the command line, and search."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenarios", type=int, help="for each robot")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--without", action="store_true", help="without the monitor")
    parser.add_argument("--robot", choices=ROBOTS)
    asked = parser.parse_args()
    for robot in ROBOTS:
        if asked.robot in (None, robot):
            print(json.dumps(search(robot, asked.scenarios, asked.seed, "no" if asked.without else "yes")), flush=True)


if __name__ == "__main__":
    main()
