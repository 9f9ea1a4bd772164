"""The proof of a law in C: compiled, put into the simulator's loop, and compared with the law here."""

import ctypes
import math
import re
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from fuzzy.plugins.ccode.compiler import SANITIZERS, Compiler, find_compiler, run_program
from fuzzy.plugins.ccode.numbertype import ExportError
from fuzzy.plugins.ccode.phrases import filled
from robotics.laws.equation import EquationLaw
from robotics.laws.law import Command, Law, Observation
from robotics.laws.rules.own_rules import OwnRules
from robotics.laws.setting import Setting
from robotics.plugins.ccode.source import AIM_SYMBOLS, LawSources, law_sources
from robotics.plugins.ccode.writing import CLawFiles
from robotics.simulation.loop import Simulation, record_run, when_stopped
from robotics.simulation.recorder import Recorder
from robotics.simulation.safety.opening import told_by
from robotics.simulation.scenario.description import Scenario
from robotics.world.paths.road import rows_at
from robotics.world.vehicle.plant import Level, TruthColumns, saturate, velocity_limits

_COUNTS = 1e12  # a turn: of encoders that count finely
_LIMIT = 1e-9  # m: between the two trajectories, in double
_REAL = {"double": (ctypes.c_double, np.float64), "float": (ctypes.c_float, np.float32)}
_WHEELS = {"double": 1e-9, "float": 1e-4}  # rad/s: of the wheel speeds from those of the robot's limits


@dataclass(frozen=True)
class DriveDifference:
    """How far the robots with the C are from those with the law here, over one scenario."""

    scenario: str
    seeds: tuple[int, ...]
    greatest: float  # m: of all robots, samples and seeds
    fine: float  # m: the same, where the encoders count finely: a step of theirs multiplies the last bit of a command
    wheels: float  # rad/s: of the wheel speeds from the simulator's limits; 0 for torques
    steps: int


@dataclass(frozen=True)
class VerifiedLaw:
    """What a proof has found.

    Attributes:
        drives: Each scenario and seed with both trajectories' distance.
        compiler: Which compiler made the program.
        sanitized: Whether the sanitizers watched a drive; they are not on every machine.
        number: "double" or "float".
    """

    drives: tuple[DriveDifference, ...]
    compiler: str
    sanitized: bool
    number: str

    @property
    def greatest(self) -> float:
        """The greatest distance [m] between the two trajectories."""
        return max(drive.greatest for drive in self.drives)

    @property
    def holds(self) -> bool | None:
        """Whether the trajectories are the same; None in float, whose distance is only told."""
        if not all(drive.wheels <= _WHEELS[self.number] for drive in self.drives):
            return False
        same = all(min(drive.greatest, drive.fine) <= _LIMIT for drive in self.drives)
        return same if self.number == "double" else None if math.isfinite(self.greatest) else False


class CStep:
    """The step of a law in C, in a shared library."""

    def __init__(self, sources: LawSources, number: str, library: Path) -> None:
        real = _REAL[number][0]
        loaded = ctypes.CDLL(str(library))

        def struct(fields: Sequence[str]) -> Any:
            parts = [re.findall(r"\w+", field) for field in fields]
            kinds = [(name, real * math.prod(map(int, many)) if many else real) for name, *many in parts]
            return type("Fields", (ctypes.Structure,), {"_fields_": kinds})

        self.sources, self.number = sources, number
        self.Input, self.Output = struct(sources.inputs), struct(sources.outputs)
        self.State = ctypes.c_double * sources.room
        self.begin, self.step = loaded[f"{sources.name}_init"], loaded[f"{sources.name}_step"]
        self.begin.restype = None

    def state(self, robot: int = 0) -> Any:
        """A state before the first step; of a team it is of the ``robot``, counted from 0."""
        state = self.State()
        self.begin(ctypes.byref(state), *([robot] if self.sources.team > 1 else []))
        return state


@dataclass(frozen=True)
class InC(Law[Any]):
    """A law whose control step is that in C."""

    law: Law[Any]
    c: CStep
    kept: dict[str, Any]  # what the steps of the first robot read and said, and the wheels' greatest deviation
    estimator: float | str | None = None  # the law's: what is in C sees the posture behind it
    looks: bool = False  # whether its monitor reads range sensors
    safe: str = "no"  # that monitor is in C, too
    message: tuple[str, ...] = ()  # what it tells the others

    @property
    def level(self) -> Level:
        """What the law commands."""
        return self.law.level

    def init(self, setting: Setting, runs: int) -> Any:
        """A state for every robot of every run."""
        self.law.init(setting, runs)
        for row in (self.kept["inputs"], self.kept["outputs"]):
            row.clear()
        states = [self.c.state(robot) for _ in range(runs) for robot in range(len(setting.robots))]
        lead = self.law.knowledge_rows(setting)[0] if isinstance(self.law, EquationLaw) else 0.0
        known = None
        if isinstance(self.law, OwnRules) and self.c.sources.handed:
            asks = replace(self.law, lead=0.0, smooth=0.0, estimator=None)
            known = asks, asks.init(setting, runs)
        return setting.references.road, velocity_limits(setting.robots), setting.robots, states, lead, known

    def control(self, seen: Observation, memory: Any, dt: float) -> tuple[Command, Any]:
        """Let every robot make its step."""
        road, limits, robots, states, lead, known = memory
        shape, sources = seen.x.shape, self.c.sources
        columns = dict(zip(("x", "y", "heading", "v", "w"), seen[1:6], strict=True))
        columns |= {f"at_{k}": row for k, row in zip(("x", "y", "heading", "v", "w", "s"), seen.reference, strict=True)}
        columns |= {"wish_v": columns["at_v"], "wish_w": columns["at_w"]}  # of a HandedOrder
        if np.any(lead):
            columns["at_v"], columns["at_w"] = rows_at(road, np.full(len(road.lengths), seen.time) + lead)[3:5]
        if "ahead_x" in sources.inputs:
            ahead = rows_at(road, np.full(len(road.lengths), seen.time + sources.look_ahead))
            columns |= dict(zip(AIM_SYMBOLS, ahead, strict=True))
        if known:
            asks, recalled = known
            told, recalled = asks.control(seen, recalled, dt)
            by_name = dict(zip((v.name for v in asks.own.fis.inputs), told.inputs, strict=True))
            columns |= {field: by_name[name] for name, field in sources.handed.items()}
            memory = (*memory[:-1], (asks, recalled))
        lanes = {field: np.broadcast_to(values, shape).reshape(-1, 1) for field, values in columns.items()}
        if self.looks:
            odometry, ranges = TruthColumns(self.kept["truth"]), sources.inputs[-1]
            lanes |= {f: getattr(odometry, f)[:, None] for f in sources.inputs if f.startswith("odo_")}
            nothing = np.full((len(states), int(ranges.strip("ranges[]"))), np.inf)
            lanes[ranges] = nothing if seen.ranges is None else seen.ranges.values.reshape(nothing.shape)
        if self.message:
            age, heard = sources.inputs[-3:-1]
            lanes[age] = seen.heard.age.reshape(len(states), -1)
            lanes[heard] = np.moveaxis(seen.heard.values, 0, -1).reshape(len(states), -1)
        given = np.concatenate([lanes[field] for field in sources.inputs], axis=1).astype(_REAL[self.c.number][1])
        said = np.full((len(states), ctypes.sizeof(self.c.Output) // ctypes.sizeof(_REAL[self.c.number][0])), np.nan)
        for lane, (row, state) in enumerate(zip(given, states, strict=True)):
            output, asked = self.c.Output(), self.c.Input.from_buffer_copy(row.tobytes())
            told = self.c.step(ctypes.byref(state), ctypes.byref(asked), ctypes.byref(output))
            if told:
                said[lane] = np.frombuffer(output, _REAL[self.c.number][1])
            if lane == 0 and told:
                self.kept["inputs"].append(bytes(asked))
                self.kept["outputs"].append(bytes(output))
        self.kept["steps"] += len(states)
        rows = said.T.reshape(-1, *shape)
        by_name = dict(zip(sources.outputs, rows, strict=False))
        message = dict(zip(self.message, rows[-len(self.message) :], strict=True)) if self.message else None
        v, w = by_name["v"], by_name["w"]
        if self.level == "torque":
            return Command(by_name["torque_right"], by_name["torque_left"], v, w), memory
        can_v, can_w = saturate(limits, v, w)
        radius, half = np.array([r.wheel_radius for r in robots]), limits[2]
        for side, sign in (("right", 1), ("left", -1)):
            off = np.abs(by_name[f"wheel_{side}"] - (can_v + sign * half * can_w) / radius)
            self.kept["wheels"] = max(self.kept["wheels"], float(np.nanmax(off, initial=0.0)))
        return Command(v, w, v, w, message), memory


def verify_c_law(files: CLawFiles, scenarios: Sequence[Scenario], seeds: Sequence[int] = (1, 2, 3)) -> VerifiedLaw:
    """Compile the files and drive with them.

    Args:
        files: What :func:`write_c_law` wrote.
        scenarios: Their robots must be those that the law was written for.
        seeds: The seeds of every scenario: the noise.

    Returns:
        How far the two trajectories of each drive are apart.

    Raises:
        CompilerError: No compiler, or it refuses the C.
        ExportError: A scenario with other robots or another control period.
    """
    compiler, sources = find_compiler(), files.sources
    codes = [file for file in files.files if file.suffix == ".c"]
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as held:
        folder = Path(held)
        library = compiler.compile(codes, folder / f"{sources.name}.so", "-O2", "-ffp-contract=off", "-shared", "-fPIC")
        step = CStep(sources, files.number, library)
        drives, steps = [], {}
        for scenario in scenarios:
            _check_robots(files, scenario)
            steps = {"inputs": [], "outputs": [], "steps": 0, "wheels": 0.0}
            looks = sources.inputs[-1].startswith("ranges")
            tells = told_by(scenario.setting, files.law)
            in_c = InC(files.law, step, steps, files.law.estimator, looks, message=tells)
            drives.append(_driven(files.law, in_c, scenario, tuple(seeds)))
        watched = compiler.sanitizes(folder)
        if watched:
            _watched(compiler, folder, files, codes, steps)
    return VerifiedLaw(tuple(drives), compiler.version, watched, files.number)


def _check_robots(files: CLawFiles, scenario: Scenario) -> None:
    setting = scenario.setting
    for robot in dict.fromkeys(setting.robots):
        other = replace(setting, robots=(robot,) * len(setting.robots))
        if law_sources(files.law, other, files.sources.name, files.number) != files.sources:
            raise ExportError(
                f"{setting.name} drives other robots, or with another period or latency, than the law was written for"
            )


def _driven(law: Law[Any], in_c: InC, scenario: Scenario, seeds: tuple[int, ...]) -> DriveDifference:
    setting = scenario.setting
    apart = _apart(law, in_c, setting, seeds)
    steps, fine = in_c.kept["steps"], apart
    # One encoder count sooner or later is 1e-5 m, and the law's last bit decides about it
    if in_c.c.number == "double" and apart > _LIMIT:
        robots = tuple(replace(robot, counts_per_turn=_COUNTS) for robot in setting.robots)
        fine = _apart(law, in_c, replace(setting, robots=robots), seeds)
    return DriveDifference(scenario.name, seeds, apart, fine, in_c.kept["wheels"], steps)


def _apart(law: Law[Any], in_c: InC, setting: Setting, seeds: tuple[int, ...]) -> float:
    """The greatest distance [m] between robots with the C and those with the law here."""
    recorder = Recorder(setting, in_c, len(seeds))
    simulation = Simulation(setting, in_c, seeds, recorder=recorder)
    in_c.kept["truth"] = simulation.lanes.body.truth  # of which the monitor reads odometry
    for _ in simulation.periods():
        pass
    gone = when_stopped(simulation.lanes, simulation.end)
    here, there = record_run(setting, law, seeds), recorder.run(setting, seeds, "", gone, simulation.end + 1)
    if not np.array_equal(np.isnan(here["x"]), np.isnan(there["x"])):
        return math.inf
    return float(np.nanmax(np.hypot(here["x"] - there["x"], here["y"] - there["y"]), initial=0.0))


def _watched(compiler: Compiler, folder: Path, files: CLawFiles, codes: list[Path], steps: dict[str, Any]) -> None:
    """Make the steps of the first robot again, under the sanitizers, and see that they say the same."""
    driver = folder / "driver.c"
    words = {"NAME": files.sources.name, "FIRST": ", 0" if files.sources.team > 1 else ""}
    driver.write_text(filled(Path(__file__).with_name("driver.c"), **words), encoding="utf-8")
    flags = ("-O1", "-g", "-ffp-contract=off", f"-I{files.folder}", *SANITIZERS)
    program = compiler.compile([driver, *codes], folder / "driver", *flags)
    asked, said = folder / "asked", folder / "said"
    asked.write_bytes(b"".join(steps["inputs"]))
    run_program(program, str(asked), str(said))
    real = _REAL[files.number][1]
    before = np.frombuffer(b"".join(steps["outputs"]), real)
    if not np.allclose(before, np.frombuffer(said.read_bytes(), real), rtol=1e-6, atol=1e-6):
        raise ExportError(f"{files.sources.name}: other answers under the sanitizers")
