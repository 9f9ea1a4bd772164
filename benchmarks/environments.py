"""How many steps a second do environments take? Ours beside those of Gymnasium, side by side in one process.

A step is a control period of one lane: 50 ms of the whole robot with its wheel loops, motors, encoders and noise, 20
steps of its differential equations, the observation and the reward. Beside it stand Gymnasium's own CartPole as a
vector environment of numpy arrays (one Euler step of four numbers), its Pendulum in its loop over environments, and
ours of one lane in that same loop. Lanes drive random actions drawn before; those whose episodes end begin the next
one, and that time counts. The cases take turns; each number is the median over the rounds, and beside it that of the
best round.

Run ``python -m benchmarks.environments [--json]``.
"""

import time
from collections.abc import Callable
from statistics import median
from typing import Any

import numpy as np

from benchmarks.reporting import heading, machine, start

ROUNDS, STEPS = 7, 400
GOAL = 500_000  # steps a second of 1,024 lanes on 2 cores


def many(make: Callable[[], Any], steps: int) -> Callable[[], float]:
    """Steps of all lanes a second of a vector environment."""
    env = make()
    env.action_space.seed(0)
    actions = [env.action_space.sample() for _ in range(16)]
    env.reset(seed=0)
    for n in range(5):
        env.step(actions[n])

    def once() -> float:
        begin = time.perf_counter()
        for n in range(steps):
            env.step(actions[n % 16])
        return float(env.num_envs * steps / (time.perf_counter() - begin))

    return once


def cases() -> dict[str, Callable[[], float]]:
    """What is timed, by its name."""
    import gymnasium

    import robotics.plugins.reinforcement
    from robotics.plugins.reinforcement.registration import TRACKING

    _ = robotics.plugins.reinforcement
    return {
        "ours, 1,024 lanes": many(lambda: gymnasium.make_vec(TRACKING, num_envs=1024), STEPS),
        "ours, 1,024 lanes, 1 thread": many(lambda: gymnasium.make_vec(TRACKING, num_envs=1024, threads=1), STEPS),
        "ours, 1,024 lanes, same-step": many(
            lambda: gymnasium.make_vec(TRACKING, num_envs=1024, autoreset="same-step"), STEPS
        ),
        "CartPole, 1,024 lanes of arrays": many(
            lambda: gymnasium.make_vec("CartPole-v1", num_envs=1024, vectorization_mode="vector_entry_point"), STEPS
        ),
        "Pendulum, 64 in a loop of Python": many(
            lambda: gymnasium.make_vec("Pendulum-v1", num_envs=64, vectorization_mode="sync"), STEPS // 8
        ),
        "ours, 64 in a loop of Python": many(
            lambda: gymnasium.make_vec(TRACKING, num_envs=64, vectorization_mode="sync", draws=2), STEPS // 8
        ),
    }


def measure() -> dict[str, Any]:
    """Steps a second of each case, over the rounds."""
    timed = cases()
    found: dict[str, list[float]] = {name: [] for name in timed}
    for _ in range(ROUNDS):
        for name, once in timed.items():
            found[name].append(once())
    ours = np.array(found["ours, 1,024 lanes"])
    return {
        **machine(("numpy", "numba", "gymnasium")),
        "steps_per_s": {name: median(values) for name, values in found.items()},
        "steps_best_per_s": {name: max(values) for name, values in found.items()},
        "over_cartpole": float(np.median(ours / found["CartPole, 1,024 lanes of arrays"])),
        "threads_over_one": float(np.median(ours / found["ours, 1,024 lanes, 1 thread"])),
        "rounds": ROUNDS,
    }


def report(result: dict[str, Any]) -> str:
    """The result as a table, beside what we aim for."""
    lines = [f"{heading(result)}; median of {result['rounds']} rounds", ""]
    lines.append(f"Environments, thousand steps a second (aim for 1,024 lanes: {GOAL / 1e3:g})")
    best = result["steps_best_per_s"]
    lines += [
        f"  {name:34}{value / 1e3:>8.1f}    (best {best[name] / 1e3:.1f})"
        for name, value in result["steps_per_s"].items()
    ]
    lines.append(
        f"  ours over CartPole {result['over_cartpole']:.2f}, all threads over one {result['threads_over_one']:.2f}"
    )
    return "\n".join(lines)


if __name__ == "__main__":
    start(__doc__, measure, report)
