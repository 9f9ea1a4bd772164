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
from typing import Any, ClassVar, NamedTuple

import numpy as np

from fuzzy.compiled.columns import Columns, column, several, within
from fuzzy.compiled.jit import compiled_only
from fuzzy.files.fisfile import read_fis
from fuzzy.system import Sugeno
from robotics.laws.equation import EquationLaw, RobotColumns, equation
from robotics.laws.formation.leader_follower import LeaderFollower
from robotics.laws.law import ControllerError
from robotics.laws.rules.asking import MOST_OUTPUTS, AnswerColumns, AskColumns, ask_numbers, ask_rules
from robotics.laws.rules.evaluation import RuleBase
from robotics.laws.rules.follow_leader import aim_level, find_formation, formation_reach, places_at_start
from robotics.laws.rules.perceiving import Perceiving
from robotics.laws.rules.perception import (
    PerceivedColumns,
    TeamMessage,
    WantedColumns,
    know_formation,
    other_of,
    perceive,
    remember,
    tell,
)
from robotics.laws.rules.quantities import QUANTITY_GROUPS
from robotics.laws.rules.situation import RecallColumns, TeamColumns, recall_at_start, team_rows
from robotics.laws.setting import Setting
from robotics.world.paths.road import share

_OUTPUT = re.compile(r"([vw])_([1-9]\d*)")
_MEANINGS = {"v": "m/s", "w": "rad/s"}
_ASK = AskColumns.size


class RobotNetwork(NamedTuple):
    """One network of one robot."""

    robot: int  # from 1
    output: str  # "v" or "w"
    rules: RuleBase

    @property
    def name(self) -> str:
        """The name of its output, such as "v_2"."""
        return f"{self.output}_{self.robot}"


class FormationColumns(RecallColumns):
    """What a robot of a formation remembers."""

    over = column("", "1: robot 1 has arrived, and all stand still")
    places = several(0, "m", "(robots,): the abscissae of all")


class FormationWanted(Columns):
    """How a robot of a formation perceives."""

    asks = within(WantedColumns)
    formation = column("", "1: for quantities of the formation")
    radio = column("", "1: robots tell each other where they are, and it goes by that")
    told = column("", "where the inputs of rule bases begin behind the message")


@compiled_only(forceinline=True)
def find_others(robot, gain, memory, known, i, table, now, rest):  # type: ignore[no-untyped-def]
    """Find out where the robots of a formation are: directly, unless they tell each other; behind :func:`perceive`.

    Args:
        robot: RobotColumns.
        gain: FormationWanted.
        memory: FormationColumns.
        known: What the law knows.
        i: The lane.
        table: What the team knows before the start.
        now: PerceivedColumns.
        rest: What is told of the sensors and of the others.
    """
    find_formation(known, i, memory, memory.places)
    if gain.formation == 1:
        head, readings, robots = TeamColumns(table), rest[int(gain.asks.readings) :], known.heard.shape[2]
        for j in range(robots if gain.radio == 0 else 0):
            other_of(readings, head, robots, j).place = memory.places[j]
        know_formation(robot, known, i, head, table, now, readings)


class FormationPerceiving(Perceiving):
    """A law whose robots perceive as those of a formation; what they broadcast depends on what they are to know."""

    says: ClassVar[type[Columns]] = Columns
    remembers: ClassVar[type[Columns]] = FormationColumns

    @property
    def message(self) -> tuple[str, ...]:
        """Where the robots are, if they are to know what is told by radio; of the formation they read it directly."""
        asked = {q for base in self.rule_bases.values() for q in base.inputs if q.radio}
        return TeamMessage.leaves() if asked - {*QUANTITY_GROUPS["The formation"].values()} else ()

    def perceives(self, setting: Setting, ahead: float = 0.0) -> dict[str, Any]:
        """The numbers of FormationWanted; its target is the reference ``ahead`` [s] of what is due."""
        wanted, told = self.wanted(setting, ahead), len(self.message)
        asked = {"formation": wanted["formation"], "radio": float(told > 0), "told": told}
        return asked | {"asks": wanted | {"formation": 0.0}}

    def tables(self, setting: Setting) -> np.ndarray:
        """What the robots know before the start: where paths meet only if they hear each other."""
        return team_rows(setting, self.margin, self.reads(setting), meet=bool(self.message))

    def begin(self, setting: Setting, runs: int) -> np.ndarray:
        """Find the robots on their paths. Raises ControllerError for a single robot."""
        start = recall_at_start(setting, runs, formation_reach(setting))
        rest = np.zeros((self.remembers.size - len(start), *start.shape[1:]))
        return np.concatenate([start, rest, places_at_start(setting, runs)])


class RobotNetworksDerived(FormationWanted):
    """What the law makes of its networks."""

    inputs = column("", "how many they have in all")
    first_ask = column("", "where AskColumns of those of robot 1 begin in the table, v and w, then those of robot 2")


class RobotNetworksWork(Columns):
    """What the law works in."""

    now = within(PerceivedColumns)
    answer = within(AnswerColumns)
    said = several(MOST_OUTPUTS, "", "what a network says")
    rest = several(0)


@equation
def drive_formation(robot, gain, memory, command, work, known, i, rules, table):  # type: ignore[no-untyped-def]
    """Perceive, and ask the robot's own two networks."""
    now, rest, number, said = work.now, work.rest, i % known.heard.shape[2], work.said
    memory.clock = known.time
    perceive(robot, memory, gain.asks, known, i, table, now, rest)
    find_others(robot, gain, memory, known, i, table, now, rest)
    inputs, readings = command.inputs[int(gain.told) :], rest[int(gain.asks.readings) :]
    for n in range(int(gain.inputs)):
        inputs[n] = np.nan
    first = int(gain.first_ask) + 2 * number * _ASK
    ask_rules(AskColumns(table, first), rules, memory, known, i, table, now, work.answer, rest, readings, inputs, said)
    v = said[0]
    ask_rules(
        AskColumns(table, first + _ASK), rules, memory, known, i, table, now, work.answer, rest, readings, inputs, said
    )
    w = said[0]
    if memory.over > 0:
        v, w = 0.0, 0.0
    command.first, command.second, command.wish_v, command.wish_w = v, w, v, w
    # What robot 1 is about to be commanded, no other knows yet
    leads = v if number == 0 or memory.over > 0 else RobotColumns(known.seen, i - number).v
    aim_level(command.target, leads, known, i, memory.places[0], table[int(TeamColumns(table).begin) :])
    command.progress = share(known.road, known.path[i], now.place)
    if gain.radio == 1:
        tell(TeamMessage(command.inputs), robot, memory, now, known.dt, 1.0, 0.0)
    remember(memory, known, i, now, 1.0, 0.0, 0.0, v, w)


@dataclass(frozen=True, kw_only=True)
class FormationNetworks(LeaderFollower):
    """The networks of the module's head: the thesis's four, or a :class:`RobotNetworks`.

    Raises ControllerError for networks that make no such set.
    """

    def __new__(cls, networks: str | tuple[Sugeno, ...] = "formation", **_: Any) -> "FormationNetworks":
        """Choose the class by what the networks drive."""
        return super().__new__(RobotNetworks if cls is FormationNetworks and _robot_networks(networks) else cls)

    @property
    def robots(self) -> int:
        """The number of robots that they drive; 0: the thesis's four drive a leader and any number of followers."""
        return 0


@dataclass(frozen=True, kw_only=True)
class RobotNetworks(FormationNetworks, FormationPerceiving):
    """Two networks for each robot of a formation."""

    own: tuple[RobotNetwork, ...] = field(init=False, repr=False, compare=False)

    equation = drive_formation
    derived, remembers, works = RobotNetworksDerived, FormationColumns, RobotNetworksWork

    def __post_init__(self) -> None:
        object.__setattr__(self, "own", _robot_networks(self.networks))
        object.__setattr__(self, "systems", tuple(network.rules.compiled for network in self.own))
        EquationLaw.__post_init__(self)

    @property
    def robots(self) -> int:
        """The number of robots that they drive."""
        return max(network.robot for network in self.own)

    @property
    def idle(self) -> frozenset[str]:
        """The gains that have no effect as the others are set."""
        return frozenset({"correction", "look_ahead", "ky", "kpsi"})

    @property
    def rule_bases(self) -> Mapping[str, RuleBase]:
        """The networks, by the names of their outputs."""
        return {network.name: network.rules for network in self.own}

    @property
    def fuzzy_systems(self) -> Mapping[str, Sugeno]:
        """The networks, by the names of their outputs; a network tells nothing to robots that it does not drive."""
        return {network.name: network.rules.fis for network in self.own}

    def derive(self, setting: Setting) -> Mapping[str, Any]:
        """How robots perceive, and where it stands how their networks are asked."""
        first = super().tables(setting).shape[1]
        return {**self.perceives(setting), "inputs": self.rule_inputs, "first_ask": first}

    def tables(self, setting: Setting) -> np.ndarray:
        """What the robots know before the start, and how their networks are asked."""
        asks, begin, told = [], 0, 0
        for name, base in self.rule_bases.items():
            asks += AskColumns.stacked(ask_numbers(base, {name: 0.0}, begin, told, self.reads(setting)))
            begin, told = begin + len(base.compiled.system), told + len(base.inputs)
        rows = super().tables(setting)
        return np.concatenate([rows, np.tile(np.array(asks, dtype=float), (len(rows), 1))], axis=1)

    def begin(self, setting: Setting, runs: int) -> np.ndarray:
        """Find the robots on their paths. Raises ControllerError for a single robot."""
        return FormationPerceiving.begin(self, setting, runs)

    def init(self, setting: Setting, runs: int) -> Any:
        """Find the robots on their paths. Raises ControllerError for another number of robots than networks."""
        count = len(setting.robots)
        if count != self.robots:
            raise ControllerError(
                f"{setting.name} has {count} robot{'s' * (count > 1)}, and these networks drive {self.robots}: "
                f"{', '.join(network.name for network in self.own)}"
            )
        for network in self.own:
            network.rules.check(setting, network.rules.fis.name)
        return super().init(setting, runs)


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
