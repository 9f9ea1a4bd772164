"""The page ``docs/reference/quantities.md``: what a robot can know, and what a rule base can say.

``python -m robotics.laws.rules.table > docs/reference/quantities.md`` makes it of the tables beside this module.
"""

from collections.abc import Iterable

import numpy as np

from fuzzy.words import listed
from robotics.laws.rules import fuzzy_team, own_rules
from robotics.laws.rules.clearances import ABEAM, AHEAD
from robotics.laws.rules.evaluation import ADDED
from robotics.laws.rules.quantities import PATTERNS, QUANTITY_GROUPS, Quantity, quantity_of
from robotics.laws.rules.situation import FARTHEST, NOTHING_NEAR, SIDE_TIME
from robotics.laws.tracking.fuzzy_tracking import TRACKING_INPUTS

_HEAD = """\
# What a robot can know

A rule base's inputs are quantities that a robot knows, by these names, and its outputs say what to do. Any rule base of
such names drives: `robotics run SCENARIO --controller fuzzy:rule_base=mine.fis`, and *Try it* in the designer. An input
that is out of its range counts as the nearer end of the range (`OutOfRange='error'` in the `.fis` refuses it).

Units are SI, angles in radians; x is forward, y and all bearings and turns are positive to the left. A quantity that
needs

* **the radio** is heard from the other robots, by messages that may be late or lost. A rule base that names one, or has
  the output `rate`, makes them tell it. A `robotN_` quantity of a robot that was not heard yet is the upper end of its
  range.
* **range sensors** is what those that the robot carries read, whichever these are: *ahead* within {ahead:.0f}° of
  straight ahead, on a *side* within {abeam:.0f}°, *behind* beyond. Room counts from the circle in which the robot turns
  on the spot. A team-mate that is heard and drives is no obstacle. Where nothing is seen, or no sensor looks, there are
  {none:g} m in a direction, `room` is {farthest:g} m, and `range:NAME` is the upper end of its range.
"""
_TARGET = """\
Under `fuzzy` the target is the point of the path due `look_ahead` seconds from now, in a fuzzy team the point due now.

"""
_PATH = """\
Without the output `rate` the clock shows the time: `late` is 0. Under `fuzzy` nobody gives way: `gives_way` and
`their_yield` are 0.

"""
_FORMATION = """\
Robots are level at equal shares of their ways: in a formation by offsets of the virtual path, otherwise of their own
paths from where their references begin. Robot 1 leads; who has not heard of it knows a lead of 0. Under `formation` and
`leader-follower` one computer drives all robots, and nothing is heard late or lost.

"""
_PAIRS = """\
A rule base with one of these among its inputs is asked once for each other robot, and its answers are joined:
{added} add up, and of every other output the least holds. A robot that is not heard takes no part; one that
hears nobody tracks.

"""
_NAMED = """\

## Names with a number or a name in them

N is the number of a robot, from 1 on; NAME is that of a sensor. These are of one robot and make no pairs, so that the
rule base is asked once; a robot's quantities of itself are 0.

"""
_OUTPUTS = """\

## Outputs of `fuzzy`

A rule base has one or more of these. What it does not give, fuzzy tracking does, which drives to the target. The robot
whose number is `leader`, as in `fuzzy:rule_base=mine.fis,leader=1`, only tracks.

"""
_KEEP = """\

The robot remembers `keep` as σ, from −1 to 1: σ' = (keep · sign σ − σ) / {side:g} s. It takes a side slowly, keeps it
while the rules say 1, leaves it for the other by −1, and forgets it by 0. `kept` is |σ|. With σ ≥ 0 it goes round to
the left of an obstacle: `wall` is the room on its right and `beyond` that on its left. With σ < 0 it is the other way
round, so that one set of rules serves both sides. A rule base that says `keep`
says `turn` in the same way: > 0 is away from the obstacle. Without `keep` it is to the left.

## Outputs in a fuzzy team

In `fuzzy-team` a rule base of one's own takes the place of one of five: `fuzzy-team:crash_rule_base=mine.fis`. That of
*tracking* has the outputs `v` and `w`, in this order, and no inputs but
{tracking}.

"""
_EXAMPLE = """\

## An example: keep a formation

Robot 2 stays 0.65 m behind robot 1: the farther ahead it is, the faster; the farther to the left, the more to the left.

```python
import fuzzy, robotics

keeper = fuzzy.Sugeno(
    inputs=[
        fuzzy.Variable("robot1_ahead", (-1, 2), {"near": fuzzy.LinearZ(0.4, 1), "far": fuzzy.LinearS(0.4, 1)}, "m"),
        fuzzy.Variable("robot1_left", (-1, 1), {"right": fuzzy.LinearZ(-1, 1), "left": fuzzy.LinearS(-1, 1)}, "m"),
    ],
    outputs=[
        fuzzy.Variable("v", (0, 0.6), {"stop": 0, "fast": 0.6}, "m/s"),
        fuzzy.Variable("w", (-2, 2), {"left": 1.6, "right": -1.6}, "rad/s"),
    ],
    rules=[
        "if robot1_ahead is near then v is stop",
        "if robot1_ahead is far then v is fast",
        "if robot1_left is left then w is left",
        "if robot1_left is right then w is right",
    ],
)
fuzzy.write_fis(keeper, "keeper.fis")
team = robotics.parse_scenario(
    \"\"\"
    kind = "team"
    duration = 30.0
    [[robots]]
    start = [0.0, 0.0, 0.0]
    path = { shape = "sine", amplitude = 0.4, wavenumber = 1.0, x_end = 8.0 }
    timing = { duration = 35.0, ramp = 2.0 }
    [[robots]]
    start = [-1.2, 0.5, 0.0]
    path = { shape = "line", start = [-1.2, 0.5], end = [7.0, 0.5] }
    timing = { duration = 35.0, ramp = 2.0 }
    \"\"\",
    "pair",
)
run = robotics.simulate(team, "fuzzy:rule_base=keeper.fis,leader=1")
```
"""


_NOTES = {
    "The target": _TARGET,
    "The path and the timetable": _PATH,
    "The formation": _FORMATION,
    "Each other robot": _PAIRS,
}
_COLUMNS = ("name", "unit", "meaning", "needs")


def page() -> str:
    """The text of the page, in Markdown."""
    degrees = {"ahead": np.degrees(AHEAD), "abeam": np.degrees(ABEAM)}
    parts = [_HEAD.format(none=NOTHING_NEAR, farthest=FARTHEST, **degrees)]
    for title, group in QUANTITY_GROUPS.items():
        note = _NOTES.get(title, "").format(added=_coded(sorted(ADDED)))
        rows = [(f"`{name}`", q.unit, q.meaning, _needs(q)) for name, q in group.items()]
        parts += [f"\n## {title}\n\n", note, _table(_COLUMNS, rows)]
    named = [(name, *words, _needs(quantity_of(name.replace("N_", "1_"), name))) for name, words in PATTERNS.items()]
    parts += [_NAMED, _table(_COLUMNS, [(f"`{name}`", *rest) for name, *rest in named])]
    own = [(f"`{name}`", words) for name, words in own_rules.RULE_OUTPUTS.items()]
    parts += [_OUTPUTS, _table(("output", "unit and meaning"), own)]
    team = [
        (f"*{task}*", f"`{name}`", words, f"{fuzzy_team.NEUTRAL[task][name]:g}")
        for task, outputs in fuzzy_team.TEAM_OUTPUTS.items()
        for name, words in outputs.items()
    ]
    parts += [_KEEP.format(side=SIDE_TIME, tracking=_coded(TRACKING_INPUTS))]
    parts += [_table(("task", "output", "unit and meaning", "where there is none"), team), _EXAMPLE]
    return "".join(parts)


def _needs(quantity: Quantity) -> str:
    return "the radio" if quantity.radio else "range sensors" if quantity.ranges else ""


def _table(head: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> str:
    lines = [head, ("---",) * len(head), *rows]
    return "".join("| " + " | ".join(cells) + " |\n" for cells in lines)


def _coded(names: Iterable[str]) -> str:
    return listed(f"`{name}`" for name in names)


if __name__ == "__main__":
    print(page(), end="")
