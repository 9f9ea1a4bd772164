"""How fast is the simulation? One run, a thousand runs at once, the plant alone, and where the time goes.

One run: three robots for 60 s on the full plant under velocity commands. Thousand runs: 1,000 seeds in one array
pass with 1 and with 3 robots, for three controllers, in robot-ticks (a robot's 50 ms period) a second. Teams: 1,000
seeds of the test with noise, failure and delay of thesis chapter 4, radio and coordination law included. The cases
take turns, one round after another, so that a busy machine disturbs all of them alike; each number is the median
over the rounds, after a first call that compiles, and beside it that of the best round.

Run ``python -m benchmarks.simulation [--json]``.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from statistics import median
from typing import Any

import numpy as np

from benchmarks.reporting import heading, machine, start
from robotics.laws.catalogue import make_controller
from robotics.laws.law import Command, Controller, Observation
from robotics.laws.setting import Setting
from robotics.paths.trajectory import Timing
from robotics.scenario.description import STEP, Scenario
from robotics.scenario.reading import load_scenario
from robotics.sensing.posture import read_encoders
from robotics.simulation.loop import simulate
from robotics.vehicle import plant as p

SEEDS, ROUNDS = 1000, 5
ONE_RUN, MANY_RUNS, TEAMS = 0.25, 1.5e6, 3e5  # what we aim for: s; robot-ticks a second
TEAM_CONTROLLERS = ("virtual-structure-virtual", "virtual-structure", "cooperation", "graph-esm")
CONTROLLERS = ("lyapunov", "fuzzy", "esm")


@dataclass
class Timed:
    """A controller that keeps the time that it takes."""

    law: Controller[Any]
    seconds: float = field(default=0.0)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.law, name)

    def init(self, setting: Setting, runs: int) -> Any:
        """The law's."""
        return self.law.init(setting, runs)

    def control(self, seen: Observation, memory: Any, dt: float) -> tuple[Command, Any]:
        """The law's command, timed."""
        start = time.perf_counter()
        result = self.law.control(seen, memory, dt)
        self.seconds += time.perf_counter() - start
        return result


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


def stages(about: Scenario, law: Controller[Any], seeds: int) -> dict[str, float]:
    """Share of the time by stage: the plant, reference and sensing timed apart, the decision inside a run."""
    ticks, lanes = about.ticks, seeds * len(about.robots)
    timed: Any = Timed(law)
    whole = seconds(lambda: simulate(about, timed, range(seeds)))
    machine = p.Plant(np.tile(np.stack([p.parameters(m.robot, STEP) for m in about.robots], axis=1), (1, seeds)))
    state = p.initial_state(np.zeros((lanes, 3)))
    counts, velocity = np.zeros((2, lanes)), np.zeros((2, lanes))
    noise = [np.random.default_rng(seed) for seed in range(seeds)]

    def sense() -> None:
        if about.sensing.posture == "pose":
            for _ in range(-(-ticks // 256)):
                np.stack([g.standard_normal((256, 3, len(about.robots))) for g in noise], axis=2)
        for _ in range(ticks):
            read_encoders(machine.parameters, state, counts, about.period, velocity)

    parts = {
        "plant": seconds(plant_alone(lanes, ticks)),
        "decide": timed.seconds,
        "sense": seconds(sense),
        "reference": seconds(lambda: [about.trajectory.at(k * about.period) for k in range(ticks)]),
    }
    parts["record and the rest"] = max(0.0, whole - sum(parts.values()))
    return {name: part / whole for name, part in parts.items()}


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
    shares: dict[str, list[dict[str, float]]] = {}
    for _ in range(ROUNDS):
        alone.append(kernel_ticks / seconds(kernel))
        for name, law in laws.items():
            one_run[name].append(seconds(lambda law=law: simulate(one, law)))  # type: ignore[misc]
            for robots, crowd in crowds.items():
                taken = seconds(lambda law=law, crowd=crowd: simulate(crowd, law, range(SEEDS)))  # type: ignore[misc]
                key = f"{name}, {robots} robot{'s' if robots > 1 else ''}"
                rates.setdefault(key, []).append(SEEDS * robots * crowd.ticks / taken)
            shares.setdefault(f"{name}, one run", []).append(stages(one, law, 1))
            shares.setdefault(f"{name}, {SEEDS} runs", []).append(stages(crowds[3], law, SEEDS))
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
        "share_of_time": {
            case: {part: median(r[part] for r in rounds) for part in rounds[0]} for case, rounds in shares.items()
        },
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
    lines += ["", "Share of the time"]
    for case, parts in result["share_of_time"].items():
        shares = ", ".join(f"{part} {100 * share:.0f} %" for part, share in parts.items())
        lines.append(f"  {case:22}{shares}")
    return "\n".join(lines)


def main() -> None:
    start(__doc__, measure, report)


if __name__ == "__main__":
    main()
