"""Rules that learn to correct as predictive control does: accuracy over their number, before and after the closed loop.

    python -m benchmarks.learntrules                       2 to 30 rules from nmpc-tuned
    python -m benchmarks.learntrules --rules 4 --evaluations 300

The teacher drives one scenario of each sort that the packaged arena tunes on and a fast one, half of the runs
disturbed; what was learnt is then tuned on others of these sorts. All is judged as in ``benchmarks.knowledge``: on
scenarios with numbers from 7,000,000 on, over the cost of the hand-written rules with the same lead, low-pass and
Kalman filter.
"""

import argparse
import tempfile
import warnings
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

import anfis
from benchmarks.knowledge import scenarios
from robotics.measures.statistics.aggregates import UNSEEN_IQM
from robotics.measures.statistics.bootstrap import contrasts
from robotics.plugins.arena.description import Arena, load_arena
from robotics.plugins.learning.demonstrations import scenario_course
from robotics.plugins.learning.imitation import imitate, write_rule_base
from robotics.plugins.learning.lesson import RIDGE, ImitationPlan
from robotics.simulation.scenario.description import Scenario
from robotics.studies.tuning.cost import costs_of
from robotics.studies.tuning.space import LawSpace
from robotics.studies.tuning.tune import tune

TEACHER = "nmpc-tuned:estimator=kalman"
RULES = "fuzzy-correcting:estimator=kalman"  # the hand-written ones
INTO = "fuzzy:lead=auto,smooth=0.2,estimator=kalman,rule_base"
_LEARN, _TUNE, _JUDGE = 8_000_000, 8_000_100, 7_000_000  # the first numbers of scenarios, of no block of an arena


def lessons(arena: Arena, first: int) -> list[Scenario]:
    """One scenario of each sort that the arena tunes on, and a fast one."""
    fast = next(family for family in arena.test if family.title == "fast")
    return [replace(f, count=1).scenario(first + n, arena.conditions) for n, f in enumerate([*arena.tune, fast])]


def lesson(arena: Arena, rules: int, outputs: Sequence[str]) -> ImitationPlan:
    """What is learnt."""
    return ImitationPlan(
        teacher=TEACHER,
        courses=tuple(scenario_course(s) for s in lessons(arena, _LEARN)),
        inputs=("x_err", "y_err", "heading_err", "target_v"),
        outputs=tuple(outputs),
        into=INTO,
        seeds=tuple(range(8)),
        rules=rules,
        rounds=2,
        options=anfis.Options(epochs=30, ridge=RIDGE),
    )


def main() -> None:
    """Print a row a number of rules."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0] if __doc__ else "")
    parser.add_argument("--rules", default="2,3,4,6,9,15,30")
    parser.add_argument("--outputs", default="dv,bend")
    parser.add_argument("--evaluations", type=int, default=3000)
    parser.add_argument("--seeds", type=int, default=10)
    given = parser.parse_args()
    arena, told = load_arena("default"), scenarios("etsro", _JUDGE)
    seeds = range(_JUDGE, _JUDGE + given.seeds)
    print(f"{'rules':>5} {'learnt':24} {'tuned, and on how many of the ' + str(len(told)) + ' scenarios less':40}")
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings(action="ignore"):
        for rules in map(int, given.rules.split(",")):
            plan, file = lesson(arena, rules, given.outputs.split(",")), Path(folder) / f"{rules}.fis"
            write_rule_base(imitate(plan), file)
            learnt = LawSpace(plan_law := arena.law(plan.controller(file)), move=("gains", "consequents"))
            tuned = tune(
                learnt,
                lessons(arena, _TUNE),
                specification=plan.controller(file),
                runs=2,
                evaluations=given.evaluations,
                cost=arena.made_cost,
                first_seed=_TUNE,
            )
            costs = costs_of(arena.made_cost, told, [RULES, plan_law, tuned.law], seeds).sum(axis=-1)
            found = contrasts(costs, UNSEEN_IQM, generator=np.random.default_rng(1))[:, 0]
            cells = [f"{found.value[n]:.2f} ({found.low[n]:.2f} to {found.high[n]:.2f})" for n in (1, 2)]
            less = int((costs[2].mean(axis=-1) < costs[0].mean(axis=-1)).sum())
            print(f"{rules:5} {cells[0]:24} {cells[1]:24} {less}", flush=True)


if __name__ == "__main__":
    main()
