"""Judging a scenario before anything runs: can the robots do it, and is there room for it?

What is looked at are the references, each robot in its true size exactly on its own; obstacles, which robots do not
know, are known here. An error cannot go well, a warning is probably unwanted, a note is worth knowing.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from fuzzy.errors import InputError
from robotics.laws.catalogue import make_controller
from robotics.laws.law import Law, check_needs
from robotics.laws.setting import Setting
from robotics.measures.registry import chosen_metrics
from robotics.simulation.safety.coverage import blind_spots
from robotics.simulation.scenario.description import Scenario
from robotics.simulation.scenario.feasibility import Demand, demands
from robotics.simulation.scenario.survey import Survey
from robotics.studies.forewarnings import blind, first_meetings, poses_of, unmeasured
from robotics.studies.ruledemands import RuleDemand, rule_demands
from robotics.tables.build import Keys
from robotics.world.environment.collision import footprints, obstacle_clearance, obstacle_contacts, robot_contacts
from robotics.world.environment.swept import ContactColumns, Watch
from robotics.world.environment.world import Geometry
from robotics.world.paths.posture import wrapped
from robotics.world.paths.references import Reference
from robotics.world.vehicle.robot import Robot

Severity = Literal["error", "warning", "note"]

_GRAVEST: tuple[Severity, ...] = ("error", "warning", "note")
LITTLE = 0.1  # 1: a reserve of speed below which a robot that is behind hardly catches up
LAG = 0.05  # m: a robot that falls farther behind while it gathers speed is told
_ROOM = 0.05  # m: beside an obstacle; noise and tracking errors take as much
OFF, FAR_OFF = 0.05, 1.0  # m: a start beside its reference, and one that may be an oversight
TURNED, TURNED_AWAY = 0.35, np.pi / 2  # rad: likewise of the heading


@dataclass(frozen=True)
class ScenarioFinding:
    """Something about a scenario that its author should know."""

    severity: Severity
    kind: str  # in a few words, such as "path through an obstacle"
    sentence: str
    at: Keys = ()  # the keys of the file that it is about
    x: float | None = None  # m: where in the plane
    y: float | None = None  # m


@dataclass(frozen=True)
class Inspection:
    """A scenario with what was found about it."""

    scenario: Scenario | None  # None: too little of the file can be read
    controller: str
    findings: tuple[ScenarioFinding, ...]  # the gravest first
    demands: tuple[Demand, ...]  # of each robot's reference: the wheels', the speed's and the turn rate's
    asked: tuple[RuleDemand, ...] = ()  # by the rule bases of the controller

    @property
    def metrics(self) -> tuple[str, ...]:
        """The names in tables of the metrics that the file names as those of its task."""
        return tuple(chosen_metrics(self.scenario.metrics, self.scenario.kind)) if self.scenario is not None else ()

    @property
    def failed(self) -> bool:
        """Whether there are errors or warnings."""
        return any(finding.severity != "note" for finding in self.findings)


def inspect_survey(read: Survey, controller: str = "") -> Inspection:
    """Judge a file as far as it can be read.

    Args:
        read: The file.
        controller: The controller that is to drive, by default the file's own, or else fuzzy.
    """
    name = controller or read.controller or "fuzzy"
    findings = [ScenarioFinding("error", "not accepted", fault.sentence, fault.at) for fault in read.faults]
    if read.scenario is None:
        try:
            make_controller(name)
        except InputError as error:
            findings.append(ScenarioFinding("error", "controller", str(error), ("controller",)))
        return Inspection(None, name, tuple(findings), ())
    found = inspect_scenario(read.scenario, name)
    if read.robots != tuple(range(len(read.robots))):
        shifted = [f"robot {n + 1} as {k}" for k, n in enumerate(read.robots, start=1) if n + 1 != k]
        text = "robots that cannot be read are not counted: below stands " + ", ".join(shifted or ["none of them"])
        findings.append(ScenarioFinding("note", "numbers", text, ("robots",)))
    placed = (replace(f, at=_in_file(f.at, read.robots)) for f in found.findings)
    ordered = sorted([*findings, *placed], key=lambda f: _GRAVEST.index(f.severity))
    return replace(found, findings=tuple(ordered))


def _in_file(at: Keys, robots: tuple[int, ...]) -> Keys:
    """The keys in the file of what is about a robot by its number among those that could be read."""
    return (at[0], robots[at[1]], *at[2:]) if len(at) > 1 and at[0] == "robots" and isinstance(at[1], int) else at


def inspect_scenario(scenario: Scenario, controller: str) -> Inspection:
    """Judge a scenario that ``controller`` is to drive. Raises nothing: what is wrong is a finding."""
    setting = scenario.setting
    needed = demands(setting.robots, scenario.trajectory, scenario.duration)
    findings = [*_feasibility(needed), *_starts(setting), *_waits(setting), *_accelerations(setting), *_room(setting)]
    findings += _metrics(scenario)
    asked: list[RuleDemand] = []
    try:
        law = make_controller(controller)
    except InputError as error:
        findings.append(ScenarioFinding("error", "controller", str(error), ("controller",)))
    else:
        findings += [*_ends(setting, law), *_obstacles(setting, law), *_law(setting, law, controller)]
        findings += [*_meetings(setting, law, controller), *_radio(setting, law)]
        asked = rule_demands(law)
        findings += _beyond(setting, asked)
    ordered = sorted(findings, key=lambda f: _GRAVEST.index(f.severity))
    return Inspection(scenario, controller, tuple(ordered), tuple(needed), tuple(asked))


def _metrics(scenario: Scenario) -> Iterator[ScenarioFinding]:
    """Metrics of the task that are not measured, since there is nothing to touch."""
    for i, (name, metric) in enumerate(chosen_metrics(scenario.metrics, scenario.kind).items()):
        if metric.needs_others and not scenario.setting.has_others:
            text = f"{name} is not measured: there is no other robot and no obstacle"
            yield ScenarioFinding("warning", "metric not measured", text, ("metrics", i))


# One robot -------------------------------------------------------------------------------------------------------


def _feasibility(needed: list[Demand]) -> Iterator[ScenarioFinding]:
    for demand in needed:
        robot, at = f"robot {demand.robot + 1}", ("robots", demand.robot, "timing")
        place = f"at t = {demand.time:.2f} s, ({demand.x:.2f}, {demand.y:.2f}) m"
        if not demand.feasible:
            text = f"{robot}: the reference is infeasible: {place}, {demand.words}"
            yield ScenarioFinding("error", "infeasible", text, at, demand.x, demand.y)
        elif demand.reserve < LITTLE:
            text = f"{robot}: {place}, {100 * demand.reserve:.1f} % of its {demand.limit} are left to catch up"
            yield ScenarioFinding("note", "little reserve", text, at, demand.x, demand.y)


def _starts(setting: Setting) -> Iterator[ScenarioFinding]:
    """Starts beside the reference, or turned away from it."""
    if setting.goals:
        return  # to start away from a goal is the task
    first = setting.references.at(0.0)
    for i, (x, y, heading) in enumerate(setting.starts):
        off, turn = float(np.hypot(first.x[i] - x, first.y[i] - y)), float(abs(wrapped(first.heading[i] - heading)))
        at = ("robots", i, "start")
        if off >= setting.divergence:
            text = f"robot {i + 1} starts {off:.2f} m from its reference, and at {setting.divergence:g} m it is stopped"
            yield ScenarioFinding("error", "start beyond divergence", text, at, float(x), float(y))
        elif off > OFF or turn > TURNED:
            grave: Severity = "warning" if off > FAR_OFF + 1e-6 or turn > TURNED_AWAY else "note"
            text = f"robot {i + 1} starts {off:.2f} m from its reference and {np.degrees(turn):.0f}° turned from it"
            yield ScenarioFinding(grave, "start off the path", text, at, float(x), float(y))


def _waits(setting: Setting) -> Iterator[ScenarioFinding]:
    """Paths of a team on which a robot that gives way may be so far behind that it is stopped as diverged."""
    longest = float(setting.references.joined.lengths.max())
    if setting.kind == "team" and longest > setting.divergence:
        text = f"a robot that gives way may be {longest:.2f} m behind, and at {setting.divergence:g} m it is stopped"
        yield ScenarioFinding("note", "stopped while it waits", text, ("divergence",))


def _accelerations(setting: Setting) -> Iterator[ScenarioFinding]:
    """References that move at once with a speed that a robot gathers only later."""
    if setting.plant == "kinematic":
        return
    first = setting.references.at(0.0)
    for i, robot in enumerate(setting.robots):
        speed, most = float(first.v[i]), acceleration(robot)
        lag = speed**2 / (2 * most)
        if lag > LAG:
            text = (
                f"robot {i + 1}: the reference starts with {speed:.3g} m/s at once; with at most {most:.3g} m/s² the "
                f"robot needs {speed / most:.2g} s and falls {lag:.2g} m behind; a ramp gives it time"
            )
            place = (float(first.x[i]), float(first.y[i]))
            yield ScenarioFinding("warning", "sudden start", text, ("robots", i, "timing"), *place)


def acceleration(robot: Robot) -> float:
    """The highest forward acceleration [m/s²] of a robot from rest: of its command, or of its wheels' torque."""
    torque = 2 * max(robot.torque_limit - robot.friction_torque, 0.0) / robot.wheel_radius
    return min(torque / robot.effective_mass, robot.v_rate_max or np.inf)


# Robots and robots -----------------------------------------------------------------------------------------------


def _room(setting: Setting) -> Iterator[ScenarioFinding]:
    """Robots that touch each other, or an obstacle, where they start."""
    sizes = footprints(setting.robots)
    x, y, heading = (setting.starts[:, k][None] for k in range(3))
    for i, j in enumerate(robot_contacts(x, y, heading, sizes)[0]):
        if j > i:
            text = f"robots {i + 1} and {int(j) + 1} touch each other where they start"
            yield ScenarioFinding(
                "error", "starts too near", text, ("robots", i, "start"), float(x[0, i]), float(y[0, i])
            )
    if setting.world is not None:
        for i, o in enumerate(obstacle_contacts(x, y, heading, sizes, setting.world.at(0.0))[0]):
            if o >= 0:
                text = f"robot {i + 1} starts in obstacle {int(o) + 1}, or touches it"
                yield ScenarioFinding(
                    "error", "start in an obstacle", text, ("robots", i, "start"), *setting.starts[i, :2]
                )


def _ends(setting: Setting, law: Law[Any]) -> Iterator[ScenarioFinding]:
    """Goals that are not reached in time, or too near to each other; starts nearer than the law keeps robots."""
    ends = np.atleast_1d(setting.references.ends)
    length = setting.ticks * setting.period
    for i, end in enumerate(ends):
        if end > length + 1e-9:
            text = f"robot {i + 1}: the run ends at {length:g} s, its reference reaches its goal at {end:.1f} s"
            yield ScenarioFinding("note", "goal after the run", text, ("duration",))
    goal = setting.references.at(float(ends.max()))
    if (ends <= length + 1e-9).all():
        touched = robot_contacts(goal.x[None], goal.y[None], goal.heading[None], footprints(setting.robots))[0]
        for i, j in enumerate(touched):
            if j > i:
                text = f"robots {i + 1} and {int(j) + 1} touch each other at their goals"
                place = (float(goal.x[i]), float(goal.y[i]))
                yield ScenarioFinding("error", "goals too near", text, ("robots", i, "path"), *place)
    kept = law.safety_distance
    if kept is None:
        return
    for x, y, what, key in (
        (setting.starts[:, 0], setting.starts[:, 1], "starts", "start"),
        (goal.x, goal.y, "goals", "path"),
    ):
        for i in range(len(x)):
            for j in range(i + 1, len(x)):
                apart = float(np.hypot(x[j] - x[i], y[j] - y[i]))
                if apart < kept - 1e-9:
                    text = f"the {what} of robots {i + 1} and {j + 1} are {apart:.2f} m apart; the law keeps {kept:g} m"
                    at = ("robots", j, key)
                    yield ScenarioFinding("warning", f"{what} nearer than kept", text, at, float(x[i]), float(y[i]))


def _meetings(setting: Setting, law: Law[Any], name: str) -> Iterator[ScenarioFinding]:
    """Robots that touch if each follows its reference exactly, or one of them late."""
    when, found = first_meetings(setting)
    for (i, j), time in sorted(found.items(), key=lambda item: item[1]):
        there = setting.references.at(time)
        care = f"; {name} takes no care of other robots" if not law.yields else f"; {name} must keep them apart"
        text = f"robots {i + 1} and {j + 1} touch at t = {time:.1f} s {when}{care}"
        grave: Severity = "note" if law.yields else "warning"
        place = (float(there.x[i]), float(there.y[i]))
        yield ScenarioFinding(grave, "references meet", text, ("robots", j, "path"), *place)


# Robots and obstacles --------------------------------------------------------------------------------------------


def _obstacles(setting: Setting, law: Law[Any]) -> Iterator[ScenarioFinding]:
    """References that run through obstacles, or with little room beside them."""
    if setting.world is None:
        return
    last = min(float(np.max(setting.references.ends)), setting.ticks * setting.period)
    times = np.linspace(0.0, last, max(round(last / setting.period), 1) + 1)
    on = setting.references.sampled(times)
    world = setting.world.at(0.0)
    if setting.world.motion is not None:
        world = Geometry(*(np.concatenate(parts) for parts in zip(*map(setting.world.at, times), strict=True)))
    poses = poses_of(on)[:, None]
    begin = Geometry(*(part[:1] for part in world))
    watch, ended = Watch.opened(setting.robots, 0.0, poses[..., 0], begin).along(times, poses, world)
    rows = [ContactColumns(row) for row in np.concatenate([ended, watch.open_contacts()])]
    grave: Severity = "note" if law.looks else "error"
    does = "the law must go round it" if law.looks else "the law senses no obstacles"
    struck = set()
    for row in sorted((row for row in rows if row.obstacle >= 0), key=lambda row: float(row.start)):
        i, o = int(row.robot), int(row.obstacle)
        if (i, o) not in struck:
            struck.add((i, o))
            there = setting.references.at(float(row.start))
            place = (float(there.x[i]), float(there.y[i]))
            where = f"at t = {row.start:.1f} s, ({place[0]:.2f}, {place[1]:.2f}) m"
            text = f"robot {i + 1}: its path runs through obstacle {o + 1} {where}; {does}"
            yield ScenarioFinding(grave, "path through an obstacle", text, ("robots", i, "path"), *place)
    yield from _narrow(setting, on, world, {i for i, _ in struck})


def _narrow(setting: Setting, on: Reference, world: Geometry, struck: set[int]) -> Iterator[ScenarioFinding]:
    gaps = obstacle_clearance(on.x, on.y, on.heading, footprints(setting.robots), world)
    for i, k in enumerate(gaps.argmin(axis=0)):
        if i not in struck and gaps[k, i] < _ROOM:
            place = (float(on.x[k, i]), float(on.y[k, i]))
            where = f"at ({place[0]:.2f}, {place[1]:.2f}) m"
            text = f"robot {i + 1}: its path leaves {100 * gaps[k, i]:.1f} cm between it and an obstacle {where}"
            yield ScenarioFinding("warning", "little room", text, ("robots", i, "path"), *place)


# The law ---------------------------------------------------------------------------------------------------------


def _law(setting: Setting, law: Law[Any], name: str) -> Iterator[ScenarioFinding]:
    """What the law needs and lacks."""
    try:
        check_needs(setting, law)
    except InputError as error:
        yield ScenarioFinding("error", "sensors missing", str(error), ("sensors",))
        return
    try:
        law.init(setting, 1)
    except InputError as error:
        yield ScenarioFinding("error", "controller", str(error), ("controller",))
    yield from (ScenarioFinding("warning", "blind", text, ("obstacles",)) for text in blind(setting, law, name))
    yield from (ScenarioFinding("note", "blind spots", text, ("safety",)) for text in blind_spots(setting, law))
    yield from (ScenarioFinding("warning", "places unmeasured", text, ("kind",)) for text in unmeasured(setting, name))
    yield from (ScenarioFinding("note", "misgiving", text, ("controller",)) for text in law.misgivings(setting))


def _beyond(setting: Setting, asked: Sequence[RuleDemand]) -> Iterator[ScenarioFinding]:
    """What rule bases of the user's own ask for beyond what robots can do; those of packages do so knowingly."""
    for demand in asked:
        told = {demand.beyond(robot): i for i, robot in reversed([*enumerate(setting.robots)])}
        for words, i in sorted(told.items(), key=lambda item: item[1]):
            if words and not demand.packaged:
                text = f"robot {i + 1}: the rule base {demand.rule_base} can ask for {demand.output} = {words}"
                yield ScenarioFinding("note", "asks for too much", text, ("controller",))


def _radio(setting: Setting, law: Law[Any]) -> Iterator[ScenarioFinding]:
    """Messages that do not fit into a period, and links that reach too short."""
    radio, count = setting.radio, len(setting.robots)
    if not law.message or count < 2:
        return
    try:
        radio.check_bandwidth(count, len(law.message))
    except InputError as error:
        yield ScenarioFinding("error", "radio too slow", str(error), ("radio", *error.at))
    if radio.range is None:
        return
    times = setting.times
    on = setting.references.sampled(times)
    for j, i in np.argwhere(np.triu(radio.adjacency(count) + radio.adjacency(count).T, 1) > 0):
        apart = np.hypot(on.x[:, i] - on.x[:, j], on.y[:, i] - on.y[:, j])
        beyond = apart > radio.range
        if beyond.any():
            k = int(apart.argmax())
            text = (
                f"robots {j + 1} and {i + 1} cannot hear each other for {100 * beyond.mean():.0f} % of the run: they "
                f"are up to {apart[k]:.2f} m apart, at t = {times[k]:.1f} s, and the radio reaches {radio.range:g} m"
            )
            place = (float(on.x[k, i]), float(on.y[k, i]))
            yield ScenarioFinding("warning", "radio out of reach", text, ("radio", "range"), *place)
