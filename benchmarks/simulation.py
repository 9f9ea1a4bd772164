"""How fast is the simulation? One run, a thousand runs at once, teams, and the plant alone.

One run: three robots for 60 s on the full plant under velocity commands. Thousand runs: 1,000 seeds in one array
pass with 1 and with 3 robots, for three controllers, in robot-ticks (a robot's 50 ms period) a second. Teams: 1,000
seeds of the test with noise, failure and delay of thesis chapter 4, radio and coordination law included. The cases
take turns, one round after another, so that a busy machine disturbs all of them alike; each number is the median
over the rounds, after a first call that compiles, and beside it that of the best round.

Run ``python -m benchmarks.simulation [--json]``.
"""

import time
from collections.abc import Callable
from dataclasses import replace
from statistics import median
from typing import Any

import numpy as np

from benchmarks.reporting import heading, machine, start
from robotics.laws.catalogue import make_controller
from robotics.simulation.loop import simulate
from robotics.simulation.scenario.description import Scenario
from robotics.simulation.scenario.reading import load_scenario
from robotics.world.paths.trajectory import Timing
from robotics.world.vehicle import plant as p

SEEDS, ROUNDS = 1000, 5
ONE_RUN, MANY_RUNS, TEAMS = 0.25, 1.5e6, 3e5  # what we aim for: s; robot-ticks a second
TEAM_CONTROLLERS = ("virtual-structure-virtual", "virtual-structure", "cooperation", "graph-esm")
CONTROLLERS = ("lyapunov", "fuzzy", "esm")


def scenario(robots: int, duration: float, noise: bool) -> Scenario:
    """``robots`` EtsRos on the sine, slowly enough for 60 s."""
    base = load_scenario("lyapunov-sine")
    member = replace(base.robots[0], path=replace(base.robots[0].path, x_end=20.0), timing=Timing(x_rate=0.3))  # type: ignore[type-var]
    sensing = base.sensing if noise else load_scenario("reference").sensing
    return replace(base, robots=(member,) * robots, duration=duration, sensing=sensing)


def seconds(call: Callable[[], Any]) -> float:
    start = time.perf_counter()
    call()
    return time.perf_counter() - start


def plant_alone(lanes: int, ticks: int) -> Callable[[], None]:
    """``ticks`` periods of the plant for ``lanes`` robots, nothing else."""
    robot = load_scenario("reference").robots[0].robot
    machine = p.Plant(np.tile(p.parameters(robot)[:, None], (1, lanes)))
    command = np.stack([np.full(lanes, 0.3), np.linspace(-1.0, 1.0, lanes)])

    def call() -> None:
        state = p.initial_state(np.zeros((lanes, 3)))
        for _ in range(ticks):
            state = machine.advance(state, command, command, 3, "velocity")

    return call


def measure() -> dict[str, Any]:
    """Every number of the report, by name."""
    laws = {name: make_controller(name) for name in CONTROLLERS}
    one = scenario(3, 60.0, noise=True)
    crowds = {robots: scenario(robots, 5.0, noise=True) for robots in (1, 3)}
    kernel, kernel_ticks = plant_alone(SEEDS, 100), SEEDS * 100
    for law in laws.values():
        simulate(replace(one, duration=0.2), law)
    kernel()
    fleet = replace(load_scenario("outage-10s"), duration=20.0)
    coordination = {name: make_controller(name) for name in TEAM_CONTROLLERS}
    for law in coordination.values():
        simulate(replace(fleet, duration=0.2), law)
    teams: dict[str, list[float]] = {name: [] for name in coordination}
    one_run: dict[str, list[float]] = {name: [] for name in laws}
    rates: dict[str, list[float]] = {}
    alone: list[float] = []
    for _ in range(ROUNDS):
        alone.append(kernel_ticks / seconds(kernel))
        for name, law in laws.items():
            one_run[name].append(seconds(lambda law=law: simulate(one, law)))  # type: ignore[misc]
            for robots, crowd in crowds.items():
                taken = seconds(lambda law=law, crowd=crowd: simulate(crowd, law, range(SEEDS)))  # type: ignore[misc]
                key = f"{name}, {robots} robot{'s' if robots > 1 else ''}"
                rates.setdefault(key, []).append(SEEDS * robots * crowd.ticks / taken)
        for name, law in coordination.items():
            taken = seconds(lambda law=law: simulate(fleet, law, range(SEEDS)))  # type: ignore[misc]
            teams[name].append(SEEDS * 3 * fleet.ticks / taken)
    return machine(["numpy", "numba", "scipy"]) | {
        "one_run_s": {name: median(times) for name, times in one_run.items()},
        "one_run_best_s": {name: min(times) for name, times in one_run.items()},
        "robot_ticks_per_s": {name: median(values) for name, values in rates.items()},
        "robot_ticks_best_per_s": {name: max(values) for name, values in rates.items()},
        "team_robot_ticks_per_s": {name: median(values) for name, values in teams.items()},
        "team_robot_ticks_best_per_s": {name: max(values) for name, values in teams.items()},
        "plant_robot_ticks_per_s": median(alone),
        "plant_robot_ticks_best_per_s": max(alone),
        "rounds": ROUNDS,
        "seeds": SEEDS,
    }


def report(result: dict[str, Any]) -> str:
    """The result as a table, beside what we aim for."""
    lines = [f"{heading(result)}; median of {result['rounds']} rounds", ""]
    lines.append(f"One run of three robots, 60 s, full plant (aim: below {ONE_RUN:g} s)")
    best = result["one_run_best_s"]
    lines += [f"  {name:22}{value:>8.3f} s  (best {best[name]:.3f})" for name, value in result["one_run_s"].items()]
    lines += ["", f"{result['seeds']:,} seeds at once, million robot-ticks a second (aim: {MANY_RUNS / 1e6:g})"]
    rates = result["robot_ticks_per_s"] | {"the plant alone": result["plant_robot_ticks_per_s"]}
    best = result["robot_ticks_best_per_s"] | {"the plant alone": result["plant_robot_ticks_best_per_s"]}
    lines += [f"  {name:22}{value / 1e6:>8.2f}    (best {best[name] / 1e6:.2f})" for name, value in rates.items()]
    title = f"Teams of three, outage-10s, {result['seeds']:,} seeds, million robot-ticks a second"
    lines += ["", f"{title} (aim: {TEAMS / 1e6:g})"]
    best = result["team_robot_ticks_best_per_s"]
    teams = result["team_robot_ticks_per_s"]
    lines += [f"  {name:28}{value / 1e6:>8.2f}    (best {best[name] / 1e6:.2f})" for name, value in teams.items()]
    return "\n".join(lines)


if __name__ == "__main__":
    start(__doc__, measure, report)
