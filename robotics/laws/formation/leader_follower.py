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

Stability: for small errors α_l = −ψ − e/L + κL/2, so the leader's lateral error obeys e'' + (2/L) e' + (2/L²) e = 0 per
metre of its path: a damping of 0.71 at every speed. Where the curvature changes by κ' per metre it drives κ' L³/6 off
its path: 1 cm. The followers' errors under "own-pose" obey e'' + (K_ψ/v) e' + K_y e = 0; open loop, nothing corrects
them.

The followers' controller reads the leader's posture, and the leader's the followers' x, directly from the shared
observation: in the thesis's set-up one computer commands all robots. There is no radio between that would delay or lose
these.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from importlib import resources
from pathlib import Path as FilePath
from types import MappingProxyType
from typing import Any, Literal, NamedTuple

import numpy as np

from fuzzy.compiled.sugeno import CompiledSugeno, compile_sugeno
from fuzzy.files.fisfile import read_fis
from fuzzy.naming import expected
from fuzzy.system import Sugeno
from robotics.laws.law import Command, ControllerError, Law, Observation
from robotics.laws.setting import Setting
from robotics.laws.tracking.fuzzy_tracking import load_rule_base
from robotics.paths.path import Path, X
from robotics.paths.posture import wrapped
from robotics.quantity import check_quantities, quantity

# m, m, rad, m, rad, 1/m: the names of the inputs that a network may have
INPUTS = ("x_l", "y_l", "theta_l", "dx", "alpha_l", "kappa_f")
LOOK_AHEAD = 0.5  # m, L of the leader's pursuit
OUTPUTS = ("v_l", "w_l", "v_f", "w_f")  # m/s, rad/s, m/s, rad/s
Correction = Literal["own-pose", "none"]


class Velocities(NamedTuple):
    """The velocities of the leader and of the followers; each field has the shape of the leader's posture."""

    v_l: np.ndarray  # m/s
    w_l: np.ndarray  # rad/s
    v_f: np.ndarray  # m/s
    w_f: np.ndarray  # rad/s


class Memory(NamedTuple):
    """The memory of a formation controller."""

    first_lead: np.ndarray  # (runs,) m: dx at the start; not-a-number before it
    together: np.ndarray  # (runs,) bool: whether the leader has met the followers
    over: np.ndarray  # (runs,) bool: whether the leader has reached the end of its path; then all stand still
    paths: tuple[Path, ...]  # one for each robot


def correction(path: Path, x: Any, y: Any, heading: Any, v: Any, ky: float, kpsi: float) -> np.ndarray:
    """Return −K_y v e − K_ψ ψ [rad/s] for robots that drive along one path; the arrays have any one shape.

    Args:
        path: The path, along which x grows.
        x: The robots' x [m].
        y: Their y [m].
        heading: Their heading [rad].
        v: Their speed [m/s].
        ky: K_y [1/m²].
        kpsi: K_ψ [1/s].
    """
    point = path.beside(x)
    lateral = (y - point.y) * np.cos(point.heading)
    return -ky * v * lateral - kpsi * wrapped(heading - point.heading)


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


def speeds(dx: np.ndarray, speed: float) -> tuple[np.ndarray, np.ndarray]:
    """Return v_l and v_f [m/s] of this module's head by the lead ``dx`` [m], of any shape, and ``speed``, v_d [m/s]."""
    return speed * pace(dx, 3.0, 0.0, 1.5), speed * pace(dx, 0.5, 1.2, 1.2)


def bearing(path: Path, x: np.ndarray, y: np.ndarray, heading: np.ndarray, look_ahead: float) -> np.ndarray:
    """α_l [rad], in (−π, π]: the bearing of the path's point ahead, seen from the leader; all arrays have one shape.

    The point lies ``look_ahead`` further along the path than the point beside the leader; beyond its end the path goes
    on straight.

    Args:
        path: The leader's path, along which x grows.
        x: The leader's x [m].
        y: The leader's y [m].
        heading: The leader's heading [rad].
        look_ahead: The distance L along the path [m].
    """
    nodes = np.linspace(0.0, path.length, path.table.shape[1])
    s = np.interp(x, path.table[X], nodes) + look_ahead
    point, beyond = path.at(s), np.maximum(s - path.length, 0.0)
    ahead_x = point.x + beyond * np.cos(point.heading)
    ahead_y = point.y + beyond * np.sin(point.heading)
    return np.asarray(wrapped(np.arctan2(ahead_y - y, ahead_x - x) - heading))


def law(dx: np.ndarray, alpha: np.ndarray, kappa: np.ndarray, speed: float, look_ahead: float) -> Velocities:
    """Evaluate the law of this module's head, followers open loop; the arrays have any one shape.

    Args:
        dx: The leader's lead [m].
        alpha: α_l, the bearing of the path's point ahead, seen from the leader [rad].
        kappa: κ_f, the curvature of the leader's path where the followers are [1/m].
        speed: v_d [m/s].
        look_ahead: L [m].
    """
    v_l, v_f = speeds(dx, speed)
    return Velocities(v_l, 2 * v_l * np.sin(alpha) / look_ahead, v_f, v_f * kappa)


def literal_speeds(first_lead: np.ndarray, together: np.ndarray, speed: float) -> tuple[np.ndarray, np.ndarray]:
    """Return v_l and v_f [m/s] as thesis 5.2.1 has them: the leader's speed depends on where it started.

    It is 3, 2, 1, 0, 0 times v_d for a start 4 and 2 m behind, level, 2 and 4 m ahead, until the leader meets the
    followers; v_d from then on, and for the followers always.

    Args:
        first_lead: dx at the start [m], of any shape.
        together: Whether the leader has met the followers, bool, of the same shape.
        speed: v_d [m/s].
    """
    v_l = speed * np.where(together, 1.0, np.clip(1 - first_lead / 2, 0.0, 3.0))
    return v_l, np.full_like(v_l, speed)


@dataclass(frozen=True, kw_only=True)
class FormationTeacher(Law[Memory]):
    """The law of the module's head as a controller.

    Its ``speeds`` "literal" are those of the thesis's data; the leader then keeps to its path as followers do that are
    corrected by their own pose, with K_y and K_ψ.
    """

    speed: float = quantity(0.1, "m/s", above=0)  # v_d
    look_ahead: float = quantity(LOOK_AHEAD, "m", above=0)  # L
    ky: float = quantity(4.0, "1/m²", least=0)
    kpsi: float = quantity(0.8, "1/s", least=0)
    correction: Correction = "none"  # of the followers; the leader always corrects itself
    speeds: Literal["lead", "literal"] = "lead"

    def __post_init__(self) -> None:
        check_quantities(self, ControllerError)

    def init(self, setting: Setting, runs: int) -> Memory:
        """Begin with no formation met. Raises ControllerError where x does not grow along every path."""
        return _begin(setting, runs)

    def control(self, seen: Observation, memory: Memory, dt: float) -> tuple[Command, Memory]:
        """Evaluate the law at the measured postures."""
        memory = _remember(seen, memory)
        path, dx = memory.paths[0], lead(seen.x)
        x, y, heading = seen.x[:, 0], seen.y[:, 0], seen.heading[:, 0]
        if self.speeds == "lead":
            alpha = bearing(path, x, y, heading, self.look_ahead)
            wish = law(dx, alpha, path.beside(x - dx).curvature, self.speed, self.look_ahead)
        else:
            v_l, v_f = literal_speeds(memory.first_lead, memory.together, self.speed)
            w_l = v_l * path.beside(x).curvature + correction(path, x, y, heading, v_l, self.ky, self.kpsi)
            wish = Velocities(v_l, w_l, v_f, v_f * path.beside(x - dx).curvature)
        return _command(seen, wish, memory, self.correction, self.ky, self.kpsi), memory


@dataclass(frozen=True, kw_only=True)
class LeaderFollower(Law[Memory]):
    """Four Sugeno systems, v_l, w_l, v_f and w_f of (5.7), that have learned the law and drive in its place.

    ``networks`` is the path of one .fis file with these four outputs, or of a folder that holds v_l.fis, w_l.fis,
    v_f.fis and w_f.fis, or a name of robotics/rulebases, or the systems themselves. The inputs of each are some of
    x_l, y_l, theta_l, dx, alpha_l and kappa_f, by name. Raises ControllerError for other inputs or outputs.

    "formation" is what ``robotics learn formation datasets/formation-well-posed.csv --check
    datasets/formation-well-posed-check.csv -o robotics/rulebases/formation`` makes; "thesis" the thesis's own.
    """

    networks: str | tuple[Sugeno, ...] = "formation"
    correction: Correction = "own-pose"  # "none": the thesis's followers, open loop
    look_ahead: float = quantity(LOOK_AHEAD, "m", above=0)  # L of the input alpha_l: that of the data learnt from
    ky: float = quantity(4.0, "1/m²", least=0)  # of the followers' correction; the leader's is in its network
    kpsi: float = quantity(0.8, "1/s", least=0)
    systems: tuple[CompiledSugeno, ...] = field(init=False, repr=False, compare=False)

    tasks = MappingProxyType({"formation": "networks"})

    def __post_init__(self) -> None:
        check_quantities(self, ControllerError)
        object.__setattr__(self, "systems", tuple(compile_sugeno(fis) for fis in load_networks(self.networks)))

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

    def init(self, setting: Setting, runs: int) -> Memory:
        """Begin with no formation met. Raises ControllerError where x does not grow along every path."""
        return _begin(setting, runs)

    def control(self, seen: Observation, memory: Memory, dt: float) -> tuple[Command, Memory]:
        """Evaluate the networks (5.7)."""
        memory = _remember(seen, memory)
        path, dx = memory.paths[0], lead(seen.x)
        x, y, heading = seen.x[:, 0], seen.y[:, 0], wrapped(seen.heading[:, 0])
        alpha, kappa = bearing(path, x, y, heading, self.look_ahead), path.beside(x - dx).curvature
        known = dict(zip(INPUTS, (x, y, heading, dx, alpha, kappa), strict=True))
        found: dict[str, np.ndarray] = {}
        rows = []
        for system in self.systems:
            inputs = np.stack([known[v.name] for v in system.fis.inputs], axis=-1)
            z = system(inputs)
            found |= {v.name: z[:, i] for i, v in enumerate(system.fis.outputs)}
            rows.append(_told(inputs, [v.name for v in system.fis.outputs], seen.x.shape[1]))
        wish = Velocities(*(found[name] for name in OUTPUTS))
        command = _command(seen, wish, memory, self.correction, self.ky, self.kpsi)
        return command._replace(inputs=np.concatenate(rows)), memory


def _told(inputs: np.ndarray, outputs: list[str], robots: int) -> np.ndarray:
    """A network's ``inputs`` (runs, inputs) as those of the robots that it drives (inputs, runs, robots), else nan."""
    told = np.full((inputs.shape[1], len(inputs), robots), np.nan)
    if any(name.endswith("_l") for name in outputs):
        told[..., 0] = inputs.T
    if any(name.endswith("_f") for name in outputs):
        told[..., 1:] = inputs.T[..., None]
    return told


def load_networks(source: str | tuple[Sugeno, ...]) -> tuple[Sugeno, ...]:
    """Read the systems of that name, file or folder, which together have the four outputs. Raises ControllerError.

    Systems themselves are taken as they are.
    They do not warn of an input outside its universe, but are evaluated there, as in MATLAB.
    """
    systems = _read_networks(source) if isinstance(source, str) else [*source]
    name = source if isinstance(source, str) else systems[-1].name
    for fis in systems:
        for variable in fis.inputs:
            if variable.name not in INPUTS:
                raise ControllerError(f"{name}: " + expected(variable.name, INPUTS, "formation input"))
    outputs = sorted(v.name for fis in systems for v in fis.outputs)
    if outputs != sorted(OUTPUTS):
        raise ControllerError(
            f"{name}: the outputs of formation networks are {', '.join(OUTPUTS)}; got {', '.join(outputs)}"
        )
    return tuple(replace(fis, out_of_range="ignore") if fis.out_of_range == "warn" else fis for fis in systems)


def _read_networks(name: str) -> list[Sugeno]:
    folder = FilePath(name)
    packaged = resources.files("robotics") / "rulebases" / name if name.isidentifier() else None
    if packaged is not None and packaged.is_dir():
        folder = FilePath(str(packaged))
    return [read_fis(folder / f"{o}.fis") for o in OUTPUTS] if folder.is_dir() else [load_rule_base(name)]


def lead(x: np.ndarray) -> np.ndarray:
    """dx [m] (runs,): the leader's x minus the followers' mean, from ``x`` (runs, robots) [m]."""
    return x[:, 0] - x[:, 1:].mean(axis=1)


def _begin(setting: Setting, runs: int) -> Memory:
    paths = setting.references.joined.paths
    if len(paths) < 2:
        raise ControllerError(f"{setting.name}: a formation needs a leader and followers, at least two robots")
    for i, path in enumerate(paths):
        if not np.all(np.diff(path.table[X]) > 0):
            raise ControllerError(f"{setting.name}: robot {i + 1}: x must grow along the path of a formation")
    return Memory(np.full(runs, np.nan), np.zeros(runs, dtype=bool), np.zeros(runs, dtype=bool), paths)


def _remember(seen: Observation, memory: Memory) -> Memory:
    dx = lead(seen.x)
    first = np.where(np.isnan(memory.first_lead), dx, memory.first_lead)
    over = memory.over | (seen.x[:, 0] >= memory.paths[0].table[X, -1])
    return Memory(first, memory.together | (dx * np.sign(first) <= 0), over, memory.paths)


def _command(seen: Observation, wish: Velocities, memory: Memory, own: Correction, ky: float, kpsi: float) -> Command:
    """The command of the leader and of the followers, each with its own correction; 0 for all once it is over."""
    v, w = np.empty_like(seen.x), np.empty_like(seen.x)
    v[:, 0], w[:, 0] = wish.v_l, wish.w_l
    v[:, 1:], w[:, 1:] = wish.v_f[:, None], wish.w_f[:, None]
    if own == "own-pose":
        for i, path in enumerate(memory.paths[1:], start=1):
            w[:, i] += correction(path, seen.x[:, i], seen.y[:, i], seen.heading[:, i], wish.v_f, ky, kpsi)
    v[memory.over], w[memory.over] = 0.0, 0.0
    return Command(v, w, v, w)
