"""Why a robot did what it did at one time of a run, in words and as data: where it was, and which rules decided."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from fuzzy.insight.explanation import Explanation
from fuzzy.insight.explanation import explain as explain_point
from fuzzy.shown import shown
from robotics.laws.modes import MODES
from robotics.measures.decisions import NONE, UNKNOWN, DecisionError, RuleSpan, decisions, rule_spans
from robotics.measures.standing import stands_still
from robotics.simulation.run import Run
from robotics.simulation.spans import FAULT_KINDS, seed_place
from robotics.world.environment.collision import footprints, obstacle_clearance, robot_clearance
from robotics.world.environment.world import Geometry

_FEW = 6  # robots that all get a sentence
SLOW_TURN = 0.02  # rad/s: a robot that turns no faster is said to drive straight


class RobotMoment(NamedTuple):
    """Where one robot was, and what it did, at one sample; sizes are true, and distances are gaps between surfaces."""

    robot: int  # from 1
    time: float  # s
    x: float  # m
    y: float  # m
    heading: float  # rad, from −π to π
    v: float  # m/s
    w: float  # rad/s
    mode: str | None  # of robotics.laws.modes.MODES; None: the law has no modes
    fault: str | None  # a value of robotics.simulation.spans.FAULT_KINDS; None: it is at no fault
    nearest_robot: int | None  # from 1; None: there is no other
    robot_gap: float | None  # m
    obstacle_gap: float | None  # m; None: there are no obstacles
    stopped: float | None  # s: when it was stopped; None: it had not been by then

    def __str__(self) -> str:
        begin = f"Robot {self.robot} "
        if self.stopped is not None:
            return begin + f"stands; at {self.stopped:.2f} s its command was not finite, or it was lost."
        begin += "is " + (f"{self.mode}: it is " if self.mode else "")
        begin += f"at x = {_rounded(self.x)} m, y = {_rounded(self.y)} m, heads {_rounded(self.heading)} rad and "
        gaps = []
        if self.robot_gap is not None:
            gaps.append(f"to the nearest robot, robot {self.nearest_robot}, {_gap(self.robot_gap)}")
        if self.obstacle_gap is not None:
            gaps.append(f"to the nearest obstacle {_gap(self.obstacle_gap)}")
        fault = f"; it has a fault, {self.fault}" if self.fault else ""
        return begin + self._motion() + fault + (f"; the gap {' and '.join(gaps)}" if gaps else "") + "."

    def _motion(self) -> str:
        still, straight = bool(stands_still(np.array(self.v))), abs(self.w) < SLOW_TURN
        if still and straight:
            return "stands still"
        side = "left" if self.w > 0 else "right"
        turning = "straight on" if straight else f"turning {side} at {abs(self.w):.2f} rad/s"
        if still:
            return f"stands on the spot, {turning}"
        return f"drives {'backwards ' if self.v < 0 else ''}at {abs(self.v):.2f} m/s, {turning}"


@dataclass(frozen=True)
class DecisionExplained:
    """What one robot did at one time, and what led to it. ``str()`` gives it in words, ``as_dict()`` as plain data."""

    run: str  # the controller and the scenario, in words
    seed: int
    situation: RobotMoment
    others: tuple[RobotMoment, ...]  # of the other robots, where they are few
    rule_bases: Mapping[str, Explanation]  # by task; none of a robot that had been stopped
    demand: tuple[float, float]  # m/s, rad/s: the velocities that the law wanted in the end, within the robot's limits

    def as_dict(self) -> dict[str, Any]:
        """The explanation as dictionaries and lists, ready for JSON except that numbers may not be finite."""
        return {
            "run": self.run,
            "seed": self.seed,
            **self.situation._asdict(),
            "others": [other._asdict() for other in self.others],
            "rule_bases": {task: explanation.as_dict() for task, explanation in self.rule_bases.items()},
            "demand": dict(zip(("v", "w"), self.demand, strict=True)),
        }

    def __str__(self) -> str:
        begin = f"At {self.situation.time:.2f} s of {self.run}, seed {self.seed}:"
        lines = [begin, "", str(self.situation), *map(str, self.others)]
        for task, explanation in self.rule_bases.items():
            lines += ["", f"Rule base {task}:"]
            lines += [f"  {line}".rstrip() for line in str(explanation).splitlines()]
        if self.rule_bases:
            v, w = self.demand
            lines += ["", f"In the end the law asks for v = {shown(v, 1.0)} m/s and w = {shown(w, 1.0)} rad/s."]
        return "\n".join(lines)


def explain_decision(run: Run, robot: int, time: float, seed: int | None = None) -> DecisionExplained:
    """Explain what a robot did at one time, by the rules that decided.

    Args:
        run: The run.
        robot: The robot, from 1.
        time: The time [s]; what was decided at the last sample before it held then.
        seed: The seed, by default the first.

    Returns:
        The rules that fired, what they were asked and what each added; ``str()`` gives it in words.

    Raises:
        DecisionError: A robot or a time that the run does not have, or a run that does not say.
        ReplayError: A seed that was not run.
    """
    place, i = seed_place(run, seed), _checked_robot(run, robot)
    first, last = float(run.time[0]), float(run.time[-1])
    if not first <= time <= last:
        raise DecisionError(f"the run lasts from {first:g} to {last:g} s; there is nothing at {time:g} s")
    k = int(np.searchsorted(run.time, time + 1e-9, side="right")) - 1
    robots = len(run.about.robots)
    others = [j for j in range(robots) if j != i] if robots <= _FEW else []
    asked = decisions(run, place, slice(k, k + 1))
    mine = situation(run, place, k, i)
    told = {each.task: (each.system, each.inputs[0, i]) for each in asked}
    if run.about.kind == "formation":  # a network of another robot tells this one nothing
        told = {task: (system, known) for task, (system, known) in told.items() if not np.isnan(known).all()}
    explained = {task: explain_point(system, known) for task, (system, known) in told.items()}
    return DecisionExplained(
        f"{run.controller} on {run.scenario}",
        run.seeds[place],
        mine,
        tuple(situation(run, place, k, j) for j in others),
        explained if mine.stopped is None else {},
        (float(run["v_demand"][place, i, k]), float(run["w_demand"][place, i, k])),
    )


def explain_spans(
    run: Run, robot: int, start: float | None = None, end: float | None = None, seed: int | None = None
) -> list[tuple[RuleSpan, str]]:
    """The spans of :func:`robotics.measures.decisions.rule_spans` of a robot, each with its sentence.

    Args:
        run: The run.
        robot: The robot, from 1.
        start: The time [s] from which on spans are sought, by default the run's first.
        end: The time [s] up to which, by default the run's last.
        seed: One of the run's seeds, by default the first.

    Raises as :func:`explain_decision`, and ReplayError for a span of time that the run does not have.
    """
    place, i = seed_place(run, seed), _checked_robot(run, robot)
    found = rule_spans(run, place, i, start, end)
    rules = {task: system.rules for task, system in (run.about.rule_bases or {}).items()}
    return [(each, _span_sentence(each, rules[each.task][each.rule - 1])) for each in found]


def situation(run: Run, place: int, k: int, robot: int) -> RobotMoment:
    """Where a robot (from 0) was, and what it did, at the sample ``k`` of the seed at ``place``."""
    stop = int(run.stopped[place, robot])
    xs, ys, headings, *_ = run.samples[k, :, place]
    x, y, heading, v, w = (float(value) for value in run.samples[k, :5, place, robot])
    sizes = footprints(run.about.robots)
    gaps = np.full(len(xs), np.inf)
    for j in range(len(gaps)):
        if j != robot:
            pair = np.array([[robot, j]])
            gaps[j] = robot_clearance(xs[pair], ys[pair], headings[pair], sizes[:, pair[0]])[0, 0]
    near = int(np.argmin(gaps))
    obstacle: float | None = None
    if run.obstacles is not None:
        moment = slice(k, k + 1) if len(run.obstacles.counts) > 1 else slice(None)
        here = Geometry(*(part[moment] for part in run.obstacles))
        mine = np.array([[robot]])
        obstacle = float(obstacle_clearance(xs[mine], ys[mine], headings[mine], sizes[:, mine[0]], here)[0, 0])
    fault = 0.0 if run.team is None else float(run["fault"][place, robot, k])
    return RobotMoment(
        robot + 1,
        float(run.time[k]),
        x,
        y,
        float(np.arctan2(np.sin(heading), np.cos(heading))),
        v,
        w,
        None if run.modes is None else MODES[int(run.modes[k, place, robot])],
        FAULT_KINDS[int(fault)] if fault > 0 else None,
        near + 1 if np.isfinite(gaps[near]) else None,
        float(gaps[near]) if np.isfinite(gaps[near]) else None,
        obstacle if obstacle is not None and np.isfinite(obstacle) else None,
        float(run.time[stop]) if 0 <= stop <= k else None,
    )


def _checked_robot(run: Run, robot: int) -> int:
    """The place of a robot (from 1) in the run's arrays. Raises DecisionError."""
    robots = len(run.about.robots)
    if not 1 <= robot <= robots:
        has = "one robot, robot 1" if robots == 1 else f"the robots 1 to {robots}"
        raise DecisionError(f"there is no robot {robot} in this run; it has {has}")
    return robot - 1


def _span_sentence(found: RuleSpan, rule: Any) -> str:
    begin = f"{found.start:.2f}-{found.end:.2f} s: "
    if found.rule == UNKNOWN:
        return begin + f"an input of {found.task} was not a number"
    if found.rule == NONE:
        return begin + f"no rule of {found.task} fired"
    strengths = [f"{value:.2f}" for value in (found.least, found.most)]
    fires = strengths[0] if strengths[0] == strengths[1] else " to ".join(strengths)
    return begin + f"rule {found.rule} of {found.task} (fires {fires}): {rule}"


def _rounded(value: float) -> str:
    """``value`` with two decimal places, and no minus before a zero."""
    return f"{value + 0.0:.2f}".replace("-0.00", "0.00")


def _gap(value: float) -> str:
    return f"is {value:.2f} m" if value > 0 else "is closed: they touch"
