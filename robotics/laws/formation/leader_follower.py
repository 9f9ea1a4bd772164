"""Leader-follower formation, thesis 5.2: the leader's posture alone tells the leader and all followers how to move.

Robot 1 is the leader, the others are the followers, who all get the same command. With x_f the followers' mean x,
dx = x_l − x_f the leader's lead, κ the curvature of the leader's path and α_l the bearing, seen from the leader, of the
point of its path that lies L ahead, the law that the networks learn is

    v_l = v_d S(dx; 3, 0, 1.5)               the leader hurries from behind and waits in front (thesis 5.2.1)
    v_f = v_d S(dx; 1/2, 1.2, 1.2)           the followers go slower while the leader is behind (5.2.3)
    ω_l = 2 v_l sin(α_l)/L                   along the arc through that point: pure pursuit
    ω_f = v_f κ(x_l − dx)                    open loop, as in the thesis
          − K_y v_f e_i − K_ψ ψ_i            correction "own-pose": each follower by its own e_i, ψ_i

where S(dx; b, a, r) runs from b far behind over 1 at dx = 0 to a far ahead (:func:`pace`), e is a robot's lateral
offset from its own path [m, > 0 to the left] and ψ its heading minus the path's [rad]. The thesis describes the first
two lines in words; the numbers, the leader's steering and the followers' correction are choices. Pure pursuit: Coulter,
"Implementation of the Pure Pursuit Path Tracking Algorithm", CMU-RI-TR-92-01, 1992.

Inputs of a network: (5.7) takes x_l, y_l and θ_l; but the velocities of five formations are no function of these three,
see ``datasets/README.md``. The law above is a function of dx and α_l (leader) and of dx and κ_f = κ(x_l − dx)
(followers), smooth in both, and these follow from x_l, y_l, θ_l, the followers' x and the path. A network may have any
of the six.

Stability: for small errors α_l = −ψ − e/L + κL/2, so the leader's cross-track error obeys e'' + (2/L) e' + (2/L²) e = 0
per metre of its path: a damping of 0.71 at every speed. Where the curvature changes by κ' per metre it drives κ' L³/6
off its path: 1 cm. The followers' errors under "own-pose" obey e'' + (K_ψ/v) e' + K_y e = 0; open loop, nothing
corrects them.

The followers' controller reads the leader's posture, and the leader's the followers' x, directly from the shared
observation: in the thesis's set-up one computer commands all robots. There is no radio between that would delay or lose
these.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from importlib import resources
from pathlib import Path as FilePath
from types import MappingProxyType
from typing import Any, ClassVar, Literal, NamedTuple

import numpy as np

from fuzzy.compiled.columns import Columns, codes, column, several
from fuzzy.compiled.jit import kernel, without_refcounts
from fuzzy.compiled.packed import evaluate_packed
from fuzzy.compiled.sugeno import CompiledSugeno, compile_sugeno
from fuzzy.files.fisfile import read_fis
from fuzzy.naming import check_known
from fuzzy.quantity import quantity
from fuzzy.system import Sugeno
from robotics.laws.equation import EquationLaw, RobotColumns, equation
from robotics.laws.law import ControllerError
from robotics.laws.setting import Setting
from robotics.laws.tracking.fuzzy_tracking import load_rule_base, rule_base_files
from robotics.world.paths import path as nodes
from robotics.world.paths.joined import join_paths
from robotics.world.paths.posture import wrapped_compiled
from robotics.world.paths.road import TIMED, at, beside, by_x, last_x, road_of

_LOOK_AHEAD = 0.5  # m, L of the leader's pursuit
FORMATION_OUTPUTS = ("v_l", "w_l", "v_f", "w_f")  # m/s, rad/s, m/s, rad/s
LEADER_PACE, FOLLOWERS_PACE = (3.0, 0.0, 1.5), (0.5, 1.2, 1.2)  # b, a and r [1/m] of S
Correction = Literal["own-pose", "none"]
Speeds = Literal["lead", "literal"]
CORRECTION, _SPEEDS = codes(Correction), codes(Speeds)


class FormationInputs(Columns):
    """What a network may ask for."""

    x_l = column("m")
    y_l = column("m")
    theta_l = column("rad")
    dx = column("m")
    alpha_l = column("rad")
    kappa_f = column("1/m")


FORMATION_INPUTS = tuple(FormationInputs.columns)
INPUT = codes(FORMATION_INPUTS)


class LeadMemory(Columns):
    """What both laws remember."""

    first_lead = column("m", "dx at the start; not-a-number: there was none")
    together = column("", "1: the leader has met the followers")
    over = column("", "1: it has reached the end of its path; then all stand still")


class NetworkColumns(Columns):
    """A network of the formation."""

    begin = column("", "where it begins in the rule bases")
    drives_leader = column("", "1: it does")
    drives_followers = column("", "1: it does")
    asks = column("", "the number of its inputs")
    asked = several(len(FORMATION_INPUTS), "", "its inputs as places in INPUTS")
    answers = several(len(FORMATION_OUTPUTS), "", "where it has each of FORMATION_OUTPUTS, or -1")


class NetworksDerived(Columns):
    """What the law makes of its networks."""

    count = column("", "of networks")
    networks = several(
        NetworkColumns.size * len(FORMATION_OUTPUTS), "", "as NetworkColumns, with room for one of each output"
    )


class NetworkWork(Columns):
    """What the networks work in."""

    all = several(len(FORMATION_INPUTS), "", "as FormationInputs")
    asked = several(len(FORMATION_INPUTS), "", "the inputs of one network")
    answer = several(len(FORMATION_OUTPUTS), "", "and its outputs")
    rest = several(0)


class Velocities(NamedTuple):
    """The velocities of the leader and of the followers; each field has the shape of the leader's posture."""

    v_l: np.ndarray  # m/s
    w_l: np.ndarray  # rad/s
    v_f: np.ndarray  # m/s
    w_f: np.ndarray  # rad/s


# The law of the module's head ------------------------------------------------------------------------------------


def pace(dx: np.ndarray, behind: float, ahead: float, rate: float) -> np.ndarray:
    """S(dx; b, a, r) = b + (a − b)/(1 + q e^(−r dx)), q = (a − 1)/(1 − b): a logistic curve with S(0) = 1.

    Args:
        dx: The leader's lead [m], of any shape.
        behind: The limit b for a leader far behind; one of the limits is above 1 and the other below.
        ahead: The limit a for a leader far ahead.
        rate: How fast it goes from one to the other, r > 0 [1/m].
    """
    q = (ahead - 1) / (1 - behind)
    return behind + (ahead - behind) * (1 + np.tanh((rate * dx - np.log(q)) / 2)) / 2  # 1/(1 + e^−z) without overflow


pace_compiled = kernel(nogil=True)(pace)  # the same, for one number in a compiled loop


@kernel(nogil=True)
def leader_speed(dx, speed):  # type: ignore[no-untyped-def]
    """v_l [m/s] by the lead ``dx`` [m], a number or an array, and ``speed``, v_d [m/s]."""
    return speed * pace_compiled(dx, *LEADER_PACE)


@kernel(nogil=True)
def follower_speed(dx, speed):  # type: ignore[no-untyped-def]
    """v_f [m/s]; the arguments are those of :func:`leader_speed`."""
    return speed * pace_compiled(dx, *FOLLOWERS_PACE)


@kernel(nogil=True)
def pursuit(v, alpha, look_ahead):  # type: ignore[no-untyped-def]
    """ω_l [rad/s] of pure pursuit with the speed ``v`` [m/s] of a point at the bearing ``alpha``; numbers or arrays."""
    return 2 * v * np.sin(alpha) / look_ahead


def law(dx: np.ndarray, alpha: np.ndarray, kappa: np.ndarray, speed: float, look_ahead: float) -> Velocities:
    """Evaluate the law of this module's head, followers open loop; the arrays have any one shape.

    Args:
        dx: The leader's lead [m].
        alpha: α_l, the bearing of the path's point ahead, seen from the leader [rad].
        kappa: κ_f, the curvature of the leader's path where the followers are [1/m].
        speed: v_d [m/s].
        look_ahead: L [m].
    """
    v_l, v_f = leader_speed(dx, speed), follower_speed(dx, speed)
    return Velocities(v_l, pursuit(v_l, alpha, look_ahead), v_f, v_f * kappa)


@without_refcounts
def literal_speed(first_lead, together, speed):  # type: ignore[no-untyped-def]
    """v_l [m/s] as thesis 5.2.1 has it: the leader's speed depends on where it started.

    It is 3, 2, 1, 0, 0 times v_d for a start 4 and 2 m behind, level, 2 and 4 m ahead, until the leader meets the
    followers; v_d from then on, and for the followers always.

    Args:
        first_lead: dx at the start [m].
        together: Whether the leader has met the followers.
        speed: v_d [m/s].
    """
    return speed if together else speed * min(max(1 - first_lead / 2, 0.0), 3.0)


@without_refcounts
def correction(robot: RobotColumns, to_y, to_heading, v, gain):  # type: ignore[no-untyped-def]
    """−K_y v e − K_ψ ψ [rad/s] of a robot that shall drive along its path.

    Args:
        robot: What it knows of itself.
        to_y: The y of the path's point that has the robot's x [m].
        to_heading: The heading of the path there [rad].
        v: The robot's speed [m/s].
        gain: K_y [1/m²] and K_ψ [1/s].
    """
    lateral = (robot.y - to_y) * math.cos(to_heading)
    return -gain.ky * v * lateral - gain.kpsi * wrapped_compiled(robot.heading - to_heading)


@without_refcounts
def bearing(road, path, x, y, heading, look_ahead):  # type: ignore[no-untyped-def]
    """α_l [rad], in [−π, π): the bearing of the path's point ahead, seen from the leader.

    The point lies ``look_ahead`` further along the path than the point beside the leader; beyond its end the path goes
    on straight.

    Args:
        road: The leader's path is on it; x grows along it.
        path: Which of its paths that is.
        x: The leader's x [m].
        y: The leader's y [m].
        heading: The leader's heading [rad].
        look_ahead: The distance L along the path [m].
    """
    s = by_x(road, path, x) + look_ahead
    to_x, to_y, to_heading, _ = at(road, path, s)
    beyond = max(s - road.lengths[path], 0.0)
    to_x, to_y = to_x + beyond * math.cos(to_heading), to_y + beyond * math.sin(to_heading)
    return wrapped_compiled(math.atan2(to_y - y, to_x - x) - heading)


@kernel
def _bearings(road, x, y, heading, look_ahead):  # type: ignore[no-untyped-def]
    out = np.empty(x.shape)
    for i in range(len(x)):
        out[i] = bearing(road, 0, x[i], y[i], heading[i], look_ahead)
    return out


def bearings(path: nodes.Path, x: np.ndarray, y: np.ndarray, heading: np.ndarray, look_ahead: float) -> np.ndarray:
    """:func:`bearing` along one path for many postures (n,)."""
    road = road_of(join_paths([path]), TIMED.evenly, np.ones(1))
    return np.asarray(_bearings(road, x, y, heading, look_ahead))


def lead(x: np.ndarray) -> np.ndarray:
    """dx [m] (runs,): the leader's x minus the followers' mean, from ``x`` (runs, robots) [m]."""
    return x[:, 0] - x[:, 1:].mean(axis=1)


# Its controller, and the networks ---------------------------------------------------------------------------------


@without_refcounts
def formed(lane, known, memory: LeadMemory):  # type: ignore[no-untyped-def]
    """The lane of the leader, and its lead dx [m], which are remembered."""
    robots, seen = known.heard.shape[2], known.seen
    leader = lane - lane % robots
    followers = 0.0
    for j in range(leader + 1, leader + robots):
        followers += RobotColumns(seen, j).x
    x = RobotColumns(seen, leader).x
    dx = x - followers / (robots - 1)
    if math.isnan(memory.first_lead):
        memory.first_lead = dx
    first = memory.first_lead
    if (dx if first > 0 else -dx if first < 0 else 0.0) <= 0:
        memory.together = 1.0
    if x >= last_x(known.road, known.path[leader]):
        memory.over = 1.0
    return leader, dx


@without_refcounts
def form(  # type: ignore[no-untyped-def]
    v, w, follows, robot: RobotColumns, gain, memory: LeadMemory, road, path
):
    """The command of one robot, a follower's with its own correction if it has one; all stand still once it is over."""
    if follows and gain.correction == CORRECTION.own_pose:
        _, y, heading, _ = beside(road, path, robot.x)
        w += correction(robot, y, heading, v, gain)
    return (0.0, 0.0) if memory.over > 0 else (v, w)


@equation
def teach(robot, gain, memory, known, lane, road, path):  # type: ignore[no-untyped-def]
    """Evaluate the law of the module's head at the measured postures."""
    leader, dx = formed(lane, known, memory)
    first, x = known.path[leader], RobotColumns(known.seen, leader).x
    literal = gain.speeds == _SPEEDS.literal
    if lane != leader:
        v = gain.speed if literal else follower_speed(dx, gain.speed)
        w = v * beside(road, first, x - dx)[3]
    elif literal:
        v = literal_speed(memory.first_lead, memory.together > 0, gain.speed)
        _, y, heading, curvature = beside(road, first, x)
        w = v * curvature + correction(robot, y, heading, v, gain)
    else:
        v = leader_speed(dx, gain.speed)
        w = pursuit(v, bearing(road, first, x, robot.y, robot.heading, gain.look_ahead), gain.look_ahead)
    return form(v, w, lane != leader, robot, gain, memory, road, path)


@equation
def lead_and_follow(robot, gain, memory, command, work, known, lane, road, path, rules):  # type: ignore[no-untyped-def]
    """Evaluate those of the networks (5.7) that drive the robot."""
    leader, dx = formed(lane, known, memory)
    first, front = known.path[leader], RobotColumns(known.seen, leader)
    given, inputs, outputs = work.all, FormationInputs(work.all), 0 if lane == leader else 2
    inputs.x_l, inputs.y_l, inputs.theta_l, inputs.dx = front.x, front.y, wrapped_compiled(front.heading), dx
    inputs.alpha_l = inputs.kappa_f = np.nan  # until they are asked for
    told, v, w = 0, 0.0, 0.0
    for k in range(int(gain.count)):
        network = NetworkColumns(gain.networks, k, len(FORMATION_OUTPUTS))
        drives = (network.drives_leader if lane == leader else network.drives_followers) > 0
        asks = int(network.asks)
        for n in range(asks):
            place = int(network.asked[n])
            if drives and math.isnan(given[place]):
                if place == INPUT.alpha_l:
                    inputs.alpha_l = bearing(road, first, inputs.x_l, inputs.y_l, inputs.theta_l, gain.look_ahead)
                elif place == INPUT.kappa_f:
                    inputs.kappa_f = beside(road, first, inputs.x_l - dx)[3]
            work.asked[n] = given[place]
            command.inputs[told + n] = given[place] if drives else np.nan
        told += asks
        if drives:
            evaluate_packed(rules[int(network.begin) :], work.asked, work.answer, work.rest)
            at_v, at_w = int(network.answers[outputs]), int(network.answers[outputs + 1])
            v = work.answer[at_v] if at_v >= 0 else v
            w = work.answer[at_w] if at_w >= 0 else w
    v, w = form(v, w, lane != leader, robot, gain, memory, road, path)
    command.first, command.second, command.wish_v, command.wish_w = v, w, v, w


class _FormationLaw(EquationLaw):
    """What both laws remember."""

    remembers: ClassVar[type[Columns]] = LeadMemory

    def begin(self, setting: Setting, runs: int) -> np.ndarray:
        """Begin with no formation met. Raises ControllerError where x does not grow along every path."""
        paths, robots = setting.references.joined.paths, len(setting.robots)
        if robots < 2:
            raise ControllerError(f"{setting.name}: a formation needs a leader and followers, at least two robots")
        for i, path in enumerate(paths):
            if not np.all(np.diff(path.nodes.x) > 0):
                raise ControllerError(
                    f"{setting.name}: robot {i % robots + 1}: x must grow along the path of a formation"
                )
        memory = LeadMemory.zeros(runs, robots)
        memory.first_lead = np.nan
        return memory.array


@dataclass(frozen=True, kw_only=True)
class FormationTeacher(_FormationLaw):
    """The law of the module's head as a controller.

    Its ``speeds`` "literal" are those of the thesis's data; the leader then keeps to its path as followers do that are
    corrected by their own pose, with K_y and K_ψ.
    """

    speed: float = quantity(0.1, "m/s", above=0)  # v_d
    look_ahead: float = quantity(_LOOK_AHEAD, "m", above=0)  # L
    ky: float = quantity(4.0, "1/m²", least=0)
    kpsi: float = quantity(0.8, "1/s", least=0)
    correction: Correction = "none"  # of the followers; the leader always corrects itself
    speeds: Speeds = "lead"

    equation = teach


@dataclass(frozen=True, kw_only=True)
class LeaderFollower(_FormationLaw):
    """Four Sugeno systems, v_l, w_l, v_f and w_f of (5.7), that have learned the law and drive in its place.

    ``networks`` is the path of one .fis file with these four outputs, or of a folder that holds v_l.fis, w_l.fis,
    v_f.fis and w_f.fis, or a name of robotics/data/rulebases, or the systems themselves. The inputs of each are some of
    x_l, y_l, theta_l, dx, alpha_l and kappa_f, by name. Raises ControllerError for other inputs or outputs.

    "formation" is what ``robotics learn formation datasets/formation-well-posed.csv --check
    datasets/formation-well-posed-check.csv -o robotics/data/rulebases/formation`` makes; "thesis" the thesis's own.
    """

    networks: str | tuple[Sugeno, ...] = "formation"
    correction: Correction = "own-pose"  # "none": the thesis's followers, open loop
    look_ahead: float = quantity(_LOOK_AHEAD, "m", above=0)  # L of the input alpha_l: that of the data learnt from
    ky: float = quantity(4.0, "1/m²", least=0)  # of the followers' correction; the leader's is in its network
    kpsi: float = quantity(0.8, "1/s", least=0)
    systems: tuple[CompiledSugeno, ...] = field(init=False, repr=False, compare=False)

    tasks = MappingProxyType({"formation": "networks"})

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(
            self, "systems", tuple(compile_sugeno(fis, sample=True) for fis in load_networks(self.networks))
        )

    def with_fuzzy_system(self, task: str, fis: Sugeno) -> "LeaderFollower":
        """Return the same law with ``fis`` in the place of the networks that have its outputs; the others stay."""
        given = {v.name for v in fis.outputs}
        rest = [own.fis for own in self.systems if not given & {v.name for v in own.fis.outputs}]
        gain: dict[str, Any] = {self._gain_of(task): (*rest, fis)}
        return replace(self, **gain)

    @property
    def fuzzy_systems(self) -> Mapping[str, Sugeno]:
        """The networks, by the names of their outputs; a network tells nothing to robots that it does not drive."""
        return {" ".join(v.name for v in own.fis.outputs): own.fis for own in self.systems}

    @property
    def idle(self) -> frozenset[str]:
        """The gains that have no effect without a correction."""
        return frozenset({"ky", "kpsi"} if self.correction == "none" else ())

    equation = lead_and_follow
    derived: ClassVar[type[Columns]] = NetworksDerived
    works: ClassVar[type[Columns]] = NetworkWork

    def derive(self, setting: Setting) -> Mapping[str, Any]:
        """What each network asks and answers."""
        networks, begin = NetworkColumns.zeros(len(FORMATION_OUTPUTS)), 0
        for k, own in enumerate(self.systems):
            one, inputs = NetworkColumns(networks.array, k), [v.name for v in own.fis.inputs]
            outputs = [v.name for v in own.fis.outputs]
            one.begin, one.asks = begin, len(inputs)
            one.asked[: len(inputs)] = [FORMATION_INPUTS.index(name) for name in inputs]
            one.answers[:] = [outputs.index(name) if name in outputs else -1 for name in FORMATION_OUTPUTS]
            one.drives_leader, one.drives_followers = one.answers[:2].max() >= 0, one.answers[2:].max() >= 0
            begin += len(own.system)
        return {"count": len(self.systems), "networks": networks.array.ravel()}

    def rule_rows(self) -> Sequence[np.ndarray]:
        """The networks, one after the other."""
        return tuple(own.system for own in self.systems)


def load_networks(source: str | tuple[Sugeno, ...]) -> tuple[Sugeno, ...]:
    """Read the systems of that name, file or folder, which together have the four outputs. Raises ControllerError.

    Systems themselves are taken as they are.
    They do not warn of an input outside its universe, but are evaluated there, as in MATLAB.
    """
    systems = _read_networks(source) if isinstance(source, str) else [*source]
    name = source if isinstance(source, str) else systems[-1].name
    for fis in systems:
        for variable in fis.inputs:
            check_known(variable.name, FORMATION_INPUTS, "formation input", ControllerError, where=name)
    outputs = sorted(v.name for fis in systems for v in fis.outputs)
    if outputs != sorted(FORMATION_OUTPUTS):
        raise ControllerError(
            f"{name}: the outputs of formation networks are {', '.join(FORMATION_OUTPUTS)}; got {', '.join(outputs)}"
        )
    return tuple(replace(fis, out_of_range="ignore") if fis.out_of_range == "warn" else fis for fis in systems)


def _read_networks(name: str) -> list[Sugeno]:
    folder = FilePath(name)
    packaged = resources.files("robotics") / "data" / "rulebases" / name if name.isidentifier() else None
    if packaged is not None and packaged.is_dir():
        folder = FilePath(str(packaged))
    if folder.is_dir():
        return [read_fis(folder / f"{o}.fis") for o in FORMATION_OUTPUTS]
    inside = f"{name}/{FORMATION_OUTPUTS[0]}" in rule_base_files()  # of a plug-in's folder of that name
    return [load_rule_base(f"{name}/{o}") for o in FORMATION_OUTPUTS] if inside else [load_rule_base(name)]
