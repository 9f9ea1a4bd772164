"""A tried run in time: what its rule base was asked at each moment, and which rule ruled when.

A run keeps what its law's rule bases were asked (:mod:`robotics.measures.decisions`). :class:`RunMoments` holds that of
the run that is drawn, so that a time is looked up and nothing is run anew.
"""

from typing import Any, NamedTuple

import numpy as np

from fuzzy.insight.explanation import firing_strengths
from fuzzy.system import Sugeno
from robotics.measures.decisions import decisions, shares
from robotics.plugins.designer.uses import TryoutError
from robotics.simulation.run import Run

COLUMNS = 300  # spans of time that a strip of rules is made of, at most
_EVERY = 700  # samples of a curve over time, at most about this many


class Asked(NamedTuple):
    """What one rule base was asked in a run of one seed."""

    time: np.ndarray  # (samples,) s
    inputs: np.ndarray  # (samples, robots, inputs), in the variables' units; NaN after a robot was stopped

    def at(self, time: float, robot: int = 0) -> np.ndarray | None:
        """The inputs (inputs,) that were in force at ``time`` [s]: those of the last period that had begun by then.

        None where they are no numbers: the robot had been stopped. Raises TryoutError for a robot that there is not.
        """
        if not 0 <= robot < self.inputs.shape[1]:
            raise TryoutError(f"there is no robot {robot + 1}: the run has {self.inputs.shape[1]}")
        # A slider's number is a rounded one: a microsecond before a period is that period.
        place = int(np.searchsorted(self.time, time + 1e-6, side="right")) - 1
        point = self.inputs[min(max(place, 0), len(self.time) - 1), robot]
        return point if np.isfinite(point).all() else None


def asked_of(run: Run, task: str) -> Asked | None:
    """What the rule base of ``task`` was asked in the run's first seed; None where the run does not say."""
    if not run.about.rule_bases or run.inputs is None:
        return None
    return next((Asked(run.time, np.array(each.inputs)) for each in decisions(run, 0) if each.task == task), None)


def rule_times(fis: Sugeno, asked: Asked, robot: int = 0) -> dict[str, Any]:
    """Which rule ruled when, in JSON's types: the "edges" [s] of spans, and the "rows" of all rules that ever fire.

    A row has the rule's number from 1, its sentence, and its mean share in each of up to COLUMNS equally long spans of
    time, null where it is not known; the rule with the largest mean share comes first.
    """
    found = shares(firing_strengths(fis, asked.inputs[:, robot]))
    edges = evenly(len(asked.time) + 1, COLUMNS + 1)
    known = ~np.isnan(found).any(axis=1)
    counts = np.add.reduceat(known.astype(float), edges[:-1])
    sums = np.add.reduceat(np.where(known[:, None], found, 0.0), edges[:-1], axis=0)
    means = np.where(counts[:, None] > 0, sums / np.maximum(counts, 1.0)[:, None], np.nan)
    whole = sums.sum(axis=0)
    order = [int(n) for n in np.argsort(-whole, kind="stable") if whole[n] > 0]
    step = float(asked.time[1] - asked.time[0]) if len(asked.time) > 1 else 0.0
    return {
        "edges": [round(float(t), 6) for t in (*asked.time[edges[:-1]], asked.time[-1] + step)],
        "rows": [{"rule": n + 1, "text": str(fis.rules[n]), "shares": rounded_list(means[:, n])} for n in order],
    }


def motion_curves(run: Run) -> dict[str, Any]:
    """The first seed's curves over time beside x, y and the error, in JSON's types, at every "every"-th sample.

    "v" and "w" are rows [m/s, rad/s], one a robot, of the truth; "torque_right" and "torque_left" [N m] are there where
    the run keeps them and the plant has motors.
    """
    every = max(1, len(run.time) // _EVERY)
    found: dict[str, Any] = {n: _rows(run[n][0][:, ::every]) for n in ("v", "w")}
    if run.torques is not None and run.torques.any():
        for wheel, name in enumerate(("torque_right", "torque_left")):
            found[name] = _rows(run.torques[::every, wheel, 0].T)
    return found | {"time": rounded_list(run.time[::every])}


def reference_curves(run: Run) -> dict[str, Any]:
    """The references' speeds "v" and "w" [m/s, rad/s], rows as of :func:`motion_curves`."""
    every = max(1, len(run.time) // _EVERY)
    return {name: _rows(run.target(name)[:, ::every]) for name in ("v", "w")}


def _rows(values: np.ndarray) -> list[list[float | None]]:
    return [rounded_list(row) for row in values]


def rounded_list(values: np.ndarray) -> list[float | None]:
    """Numbers as JSON has them, to a tenth of a millimetre; not-a-number is null."""
    return [v if v == v else None for v in (np.round(values, 4) + 0.0).tolist()]


def evenly(count: int, most: int) -> np.ndarray:
    """At most so many of the places 0 to ``count`` - 1, evenly from the first to the last."""
    return np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(int))


def bends(x: np.ndarray, y: np.ndarray, most: int) -> np.ndarray:
    """At most so many of a path's places, with the first and the last: as close as it is long and bends, alike."""
    if most >= len(x):
        return np.arange(len(x))
    step = np.nan_to_num(np.diff(x) + 1j * np.diff(y))
    moves = np.flatnonzero(np.abs(step) > 1e-4)  # m, to which places are drawn
    turned = np.zeros(len(step))
    turned[moves[1:]] = np.abs(np.angle(step[moves[1:]] / step[moves[:-1]]))
    shares = [each / max(each.sum(), 1e-12) for each in (np.abs(step), turned)]
    along = np.concatenate([[0.0], np.cumsum(sum(shares, np.full(len(step), 1e-9)))])
    return np.unique(np.searchsorted(along, np.linspace(0.0, along[-1], most)).clip(0, len(x) - 1))


class RunMoments:
    """The moments of the run that is drawn: looking at one of them, and at the rules that ruled then."""

    def __init__(self, bench: Any) -> None:
        self.bench = bench
        self.number = 0  # of the run that is drawn
        self.system: Sugeno | None = None
        self.asked: Asked | None = None
        self.keys: tuple[int, ...] = ()  # of the rules of the system that drove

    def take(self, fis: Sugeno, keys: tuple[int, ...], made: dict[str, Any]) -> dict[str, Any]:
        """Keep what a new run's rule base was asked; what remains of ``made`` is for the page.

        Args:
            fis: The system that drove.
            keys: The key of each of its rules, see ``fuzzy.plugins.designer.design.RuleLine``.
            made: The run as :func:`robotics.plugins.designer.tryout.design_data` hands it over.
        """
        self.number += 1
        self.system, self.keys, self.asked = fis, keys, made.get("asked")
        return {name: value for name, value in made.items() if name != "asked"} | {"number": self.number}

    def look(self, content: dict[str, Any]) -> dict[str, Any]:
        """Look at what a robot knew at a time, and lead to a rule if the page asks for it; what was done, for the page.

        ``content`` has "time" [s], "robot" from 0, "rule" (its number from 1, "strongest", or null) and "count", which
        comes back. Raises TryoutError for what cannot be.
        """
        time, robot, rule = content.get("time"), content.get("robot", 0), content.get("rule")
        if isinstance(time, bool) or not isinstance(time, (int, float)) or not np.isfinite(time):
            raise TryoutError(f"a time is a number of seconds; got {time!r}")
        if type(robot) is not int:
            raise TryoutError(f"robot must be the number of a robot; got {robot!r}")
        if self.asked is None or self.system is None:  # this law does not say what its rule base was asked
            return {"time": time, "count": content.get("count"), "known": False}
        point = self.asked.at(float(time), robot)
        done = {"time": time, "count": content.get("count"), "known": point is not None}
        if point is not None and point.size == len(self.bench.document.design.system.inputs):
            self.bench.look_at(point)
        if rule == "strongest" and point is not None:
            firing = firing_strengths(self.system, point)
            rule = int(np.argmax(firing)) + 1 if firing.size and firing.max() > 0 else None
        if type(rule) is int and 0 < rule <= len(self.keys):
            self.bench.open_rule(self.keys[rule - 1])
            done["rule"] = rule
        return done
