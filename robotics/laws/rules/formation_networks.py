"""Networks that drive a formation: the thesis's four, or a robot's own two for each robot of any formation.

``networks`` names a folder with v_l.fis, w_l.fis, v_f.fis and w_f.fis (:class:`LeaderFollower`), or with v_1.fis,
w_1.fis, v_2.fis and so on: the speed [m/s] and the turn rate [rad/s] of robot 1, 2 and so on. The inputs of the latter
are quantities of :mod:`robotics.laws.rules.quantities` as their own robot knows them. All robots stop when robot 1
reaches the end of its path.

One computer commands all robots, as in the thesis: unless a network asks for what is told by radio, such as
``robot1_gap``, the quantities of the formation are read directly, not late and without loss.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from fuzzy.files.fisfile import read_fis
from fuzzy.quantity import check_quantities
from fuzzy.system import Sugeno
from robotics.laws.formation.leader_follower import LeaderFollower
from robotics.laws.law import Command, ControllerError, Observation
from robotics.laws.rules.evaluation import RuleBase
from robotics.laws.rules.follow_leader import FormationMemory, level_target
from robotics.laws.rules.quantities import QUANTITY_GROUPS, Quantity
from robotics.laws.rules.situation import TEAM_MESSAGE
from robotics.laws.setting import Setting

_OUTPUT = re.compile(r"([vw])_([1-9]\d*)")
_MEANINGS = {"v": "m/s", "w": "rad/s"}


class RobotNetwork(NamedTuple):
    """One network of one robot."""

    robot: int  # from 1
    output: str  # "v" or "w"
    rules: RuleBase

    @property
    def name(self) -> str:
        """The name of its output, such as "v_2"."""
        return f"{self.output}_{self.robot}"


@dataclass(frozen=True, kw_only=True)
class FormationNetworks(LeaderFollower):
    """The networks of the module's head. Raises ControllerError for networks that make no such set."""

    own: tuple[RobotNetwork, ...] = field(init=False, repr=False, compare=False)  # none: the thesis's four

    def __post_init__(self) -> None:
        check_quantities(self, ControllerError)
        own = _robot_networks(self.networks)
        object.__setattr__(self, "own", own)
        if own:
            object.__setattr__(self, "systems", tuple(network.rules.compiled for network in own))
        else:
            super().__post_init__()

    @property
    def has_equation(self) -> bool:  # type: ignore[override]
        """Whether they are the thesis's four, which have one."""
        return not self.own

    @property
    def robots(self) -> int:
        """The number of robots that they drive; 0: the thesis's four drive a leader and any number of followers."""
        return max((network.robot for network in self.own), default=0)

    @property
    def idle(self) -> frozenset[str]:
        """The gains that have no effect as the others are set."""
        return frozenset({"correction", "look_ahead", "ky", "kpsi"}) if self.own else super().idle

    @property
    def message(self) -> tuple[str, ...]:
        """Where the robots are, if a network asks for what is told by radio."""
        return TEAM_MESSAGE if asks_radio(q for network in self.own for q in network.rules.inputs) else ()

    @property
    def needs(self) -> tuple[str, ...]:
        """The range sensors that networks name."""
        return tuple(dict.fromkeys(name for network in self.own for name in network.rules.sensors))

    @property
    def looks(self) -> bool:
        """Whether a network asks for the room around the robot."""
        return any(network.rules.looks for network in self.own)

    @property
    def fuzzy_systems(self) -> Mapping[str, Sugeno]:
        """The networks, by the names of their outputs; a network tells nothing to robots that it does not drive."""
        return {network.name: network.rules.fis for network in self.own} if self.own else super().fuzzy_systems

    def init(self, setting: Setting, runs: int) -> Any:
        """Find the robots on their paths. Raises ControllerError for another number of robots than there are networks.

        The thesis's networks refuse paths along which x does not grow.
        """
        if not self.own:
            return super().init(setting, runs)
        count = len(setting.robots)
        if count != self.robots:
            raise ControllerError(
                f"{setting.name} has {count} robot{'s' * (count > 1)}, and these networks drive {self.robots}: "
                f"{', '.join(network.name for network in self.own)}"
            )
        for network in self.own:
            network.rules.check(setting, network.rules.fis.name)
        return FormationMemory.start(setting, runs, meetings=bool(self.message) or self.looks)

    def control(self, seen: Observation, memory: Any, dt: float) -> tuple[Command, Any]:
        """Ask each robot's networks."""
        if not self.own:
            return super().control(seen, memory, dt)
        now = memory.situation(seen, dt)
        wish = {"v": np.zeros_like(seen.x), "w": np.zeros_like(seen.x)}
        rows = []
        for network in self.own:
            place = network.robot - 1
            known = np.ascontiguousarray(network.rules.known(now)[:, place])
            wish[network.output][:, place] = network.rules(known)[network.name]
            told = np.full((known.shape[1], *seen.x.shape), np.nan)
            told[..., place] = known.T
            rows.append(told)
        over = memory.arrived(now)[:, None]
        v, w = (np.where(over, 0.0, wish[name]) for name in ("v", "w"))
        after = memory.after(now, v, w)
        message = now.message(after.recall) if self.message else None
        target = level_target(now, v[:, :1])
        return Command(v, w, v, w, message, target, now.paths.share(now.place), inputs=np.concatenate(rows)), after


def asks_radio(quantities: Any) -> bool:
    """Whether robots must tell each other something for one of these; those of the formation are read directly."""
    formation = QUANTITY_GROUPS["The formation"].values()
    return any(isinstance(q, Quantity) and q.radio and q not in formation for q in quantities)


def _robot_networks(source: str | tuple[Sugeno, ...]) -> tuple[RobotNetwork, ...]:
    """The networks of single robots in that folder, or among those systems; none where there are the thesis's four.

    Raises ControllerError for inputs that are no quantities, and for robots without v and w.
    """
    if isinstance(source, str):
        folder = Path(source)
        files = [file for file in folder.glob("*.fis") if _OUTPUT.fullmatch(file.stem)] if folder.is_dir() else []
        systems = [read_fis(file) for file in files]
    else:
        systems = [fis for fis in source if any(_OUTPUT.fullmatch(v.name) for v in fis.outputs)]
    networks = sorted((_robot_network(fis) for fis in systems), key=lambda n: (n.robot, n.output))
    names = [network.name for network in networks]
    wanted = [f"{o}_{i}" for i in range(1, max((n.robot for n in networks), default=0) + 1) for o in ("v", "w")]
    if names != wanted:
        missing = [name for name in wanted if name not in names]
        what = f"{', '.join(missing)} missing" if missing else "one of them twice"
        called = source if isinstance(source, str) else "these systems"
        raise ControllerError(f"{called}: each robot needs the networks v and w; got {', '.join(names)}: {what}")
    return tuple(networks)


def _robot_network(fis: Sugeno) -> RobotNetwork:
    names = [v.name for v in fis.outputs]
    found = _OUTPUT.fullmatch(names[0])
    if len(names) > 1 or not found:
        raise ControllerError(
            f"{fis.name}: the network of one robot has one output, such as v_1 or w_1; got {', '.join(names)}"
        )
    rules = RuleBase.of(fis, {names[0]: _MEANINGS[found[1]]}, "a formation network")
    pairs = [v.name for v, q in zip(fis.inputs, rules.inputs, strict=True) if q.pair]
    if pairs:
        raise ControllerError(
            f"{fis.name}: {pairs[0]} is told of each other robot; a formation network takes what is told of one, such "
            "as robot1_gap"
        )
    return RobotNetwork(int(found[2]), found[1], rules)
