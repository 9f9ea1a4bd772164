"""What knowledge is worth, and what the law: costs over tuned predictive control on scenarios that nobody was tuned on.

    python -m benchmarks.knowledge                  the EtsRo, with lead or low-pass taken away
    python -m benchmarks.knowledge mir100 --seeds 5 --wrong 0.01

The scenarios are four of each sort that the packaged arena tests on, with numbers from ``--first`` on, which belongs to
no block of an arena. Intervals are bootstraps over scenarios and seeds.
"""

import argparse
import warnings
from dataclasses import replace

import numpy as np

from robotics.measures.statistics.aggregates import IQM, UNSEEN_IQM
from robotics.measures.statistics.bootstrap import contrasts
from robotics.plugins.arena.description import load_arena
from robotics.plugins.arena.plan import ArenaError
from robotics.simulation.scenario.description import Scenario
from robotics.studies.tuning.cost import costs_of

LAWS = (
    "nmpc-tuned",
    "fuzzy-correcting",
    "fuzzy-correcting:lead=0",
    "fuzzy-correcting:smooth=0",
    "fuzzy-correcting:lead=0,smooth=0",
    "lyapunov:lead=auto,smooth=0.2",
    "lyapunov",
    "fuzzy-correcting:estimator=kalman",
    "lyapunov:lead=auto,smooth=0.2,estimator=kalman",
    "nmpc-tuned:estimator=kalman",
)


def scenarios(robot: str, first: int, count: int = 4) -> list[Scenario]:
    """The scenarios of a robot; a sort that it cannot drive is left out."""
    arena = load_arena("default")
    found: list[Scenario] = []
    for family in arena.test:
        for _ in range(count):
            try:
                found.append(replace(family, robot=robot, count=1).scenario(first + len(found), arena.conditions))
            except ArenaError:
                break
    return found


def under(scenario: Scenario, wrong: float, noise: float, latency: float) -> Scenario:
    """The scenario with encoders that are wrong, more noise or a later command."""
    own = scenario.sensing
    louder = {name: noise * getattr(own, name) for name in ("position_noise", "heading_noise")}
    sensing = replace(own, wheel_error=wrong, axle_error=wrong, **louder)
    return replace(scenario, sensing=sensing, latency=round(latency * scenario.latency, 9))


def main() -> None:
    """Print a row a law."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0] if __doc__ else "")
    parser.add_argument("robot", nargs="?", default="etsro")
    parser.add_argument("--laws", default="", help="specifications, a space between two; the first is the unit")
    parser.add_argument("--first", type=int, default=7_000_000, help="the first number and seed")
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--wrong", type=float, default=0.0, help="spread of the wheels and axles that odometry assumes")
    parser.add_argument("--noise", type=float, default=1.0, help="times the noise of the pose sensor")
    parser.add_argument("--latency", type=float, default=1.0, help="times the latency, of which laws are told")
    given = parser.parse_args()
    laws = tuple(given.laws.split()) or LAWS
    told = [under(s, given.wrong, given.noise, given.latency) for s in scenarios(given.robot, given.first)]
    seeds, cost = range(given.first, given.first + given.seeds), load_arena("default").made_cost
    with warnings.catch_warnings(action="ignore"):
        found = costs_of(cost, told, laws, seeds).sum(axis=-1)
    ratios = contrasts(found, UNSEEN_IQM, generator=np.random.default_rng(1))[:, 0]
    each = IQM(found[:, :, None, :])
    print(f"{given.robot}: {len(told)} scenarios from number {given.first}, {given.seeds} seeds each; over {laws[0]}")
    for n, law in enumerate(laws):
        interval = f"{ratios.value[n]:.3f} ({ratios.low[n]:.3f} to {ratios.high[n]:.3f})"
        fewer = f"less on {(each[n] < each[0]).sum()}"
        print(f"{law:36} {interval:26} {fewer:12} mean cost {each[n].mean():.3f}")


if __name__ == "__main__":
    main()
