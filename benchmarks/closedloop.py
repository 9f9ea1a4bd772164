"""How close is the simulation to a hand-written C program? One run, a thousand runs, and what tuning and stress take.

The closed loop is that of benchmarks/simulation.py: three EtsRos on the sine with 3 mm of posture noise, on the full
plant, under velocity commands. closedloop.c is the same loop under the Lyapunov law as a plain C program, compiled now
for this machine; Python hands it the parameters, the references and the noise, and both keep the same 14 channels. It
first has to give our answer, to a nanometre. What our time contains and the C program's does not is the
drawing of the noise, which is listed beside it. The cases take turns, one round after another; numbers are medians.

Run ``python -m benchmarks.closedloop [--quick] [--json]``; --quick leaves out population, stress
and the other simulators, which get virtual environments of their own in build/.
"""

import ctypes
import inspect
import os
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

import robotics
from benchmarks.reporting import heading, machine, start
from benchmarks.robotsimulators import PEERS, measured
from benchmarks.simulation import CONTROLLERS, scenario, seconds
from robotics.laws.catalogue import make_controller
from robotics.laws.tracking.fuzzy_tracking import FuzzyTracking
from robotics.laws.tracking.lyapunov import Lyapunov
from robotics.plugins.stress.crew import Crew
from robotics.plugins.stress.crossings import stress_crossing
from robotics.plugins.stress.running import in_pieces
from robotics.simulation.loop import simulate
from robotics.simulation.scenario.description import Scenario
from robotics.world.vehicle import plant as p

ROBOTS, ONE_DURATION = 3, 60.0  # s
SEEDS, MANY_DURATION, ROUNDS = 1024, 5.0, 5
AGREEMENT, COUNT = 1e-9, 2e-4  # m; COUNT: what a wheel rolls from one count of its encoder to the next
EARLY = 10.0  # s
FINE = 2**40  # counts a turn
ONE_RUN, TIMES_C, MANY_TIMES_C, SECOND_THREAD = 8e-3, 3.0, 1.5, 1.8  # what we aim for
CANDIDATES, TRIALS, TRIAL = 1000, 20, 22.0  # of the population: laws, seeds, s
CROSSINGS = ((2000, 3), (200, 20))  # of stress: how many, of how many robots
TEAM, TEAMS = "2000 of 3, fuzzy-team", 2000  # crossings, in a process that has all machine code
AIMS = {"population": 15.0, "2000 crossings of 3": 5.0, "200 crossings of 20": 15.0, TEAM: 8.0}  # s
THREADS = (1, 2)


class Gains(ctypes.Structure):
    """The gains as closedloop.c has them."""

    _fields_ = [(name, ctypes.c_double) for name in ("kx", "ky", "kpsi", "catch_up")]


@dataclass(frozen=True)
class Numbers:
    """What closedloop.c is given: a scenario and its seeds, as arrays."""

    parameters: np.ndarray  # (robots, PARAMETERS)
    starts: np.ndarray  # (runs, robots, 3) m, m, rad: the true poses
    believed: np.ndarray  # likewise: where the robots believe to stand
    references: np.ndarray  # (ticks + 1, robots, 5): x, y, heading, v, w
    noise: np.ndarray  # (runs, ticks + 1, 3, robots) m, m, rad
    late: int  # steps

    @classmethod
    def of(cls, about: Scenario, seeds: int) -> "Numbers":
        """The numbers of ``about``, whose noise is white and acts all the time, for the first ``seeds`` seeds."""
        setting, robots = about.setting, len(about.robots)
        assert all(s.posture == "pose" and s.filter_gain == 1 and s.relative_noise == 0 for s in setting.sensing)
        spread = np.array([(s.start_position, s.start_position, s.start_heading) for s in setting.sensing])
        believed = np.broadcast_to(setting.starts, (seeds, robots, 3)).copy()
        starts, noise = believed.copy(), np.empty((seeds, setting.ticks + 1, 3, robots))
        deviations = np.array([(s.position_noise, s.position_noise, s.heading_noise) for s in setting.sensing]).T
        for seed in range(seeds):
            generator = np.random.default_rng(seed)
            starts[seed] += generator.standard_normal((robots, 3)) * spread
            generator.standard_normal(out=noise[seed])
        noise *= deviations
        at = [setting.references.at(t) for t in setting.times]
        rows = np.array([(r.x, r.y, r.heading, r.v, r.w) for r in at])
        return cls(
            np.stack([p.parameters(robot, p.STEP) for robot in setting.robots]),
            starts,
            believed,
            np.ascontiguousarray(rows.transpose(0, 2, 1)),
            noise,
            round(setting.latency / p.STEP),
        )


def compiled() -> ctypes.CDLL:
    """closedloop.c, compiled now for this machine. Raises ImportError where there is no compiler."""
    compiler = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    if compiler is None:
        raise ImportError("no C compiler")
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "closedloop.so"
        # Strict IEEE arithmetic: no contraction to fused multiply-add, no fast-math.
        flags = ["-std=c99", "-O3", "-march=native", "-ffp-contract=off", "-shared", "-fPIC"]
        source = Path(__file__).with_suffix(".c")
        subprocess.run([compiler, *flags, str(source), "-o", str(target), "-lm"], check=True)
        return ctypes.CDLL(str(target))


def c_program(library: ctypes.CDLL, numbers: Numbers, threads: int = 1) -> np.ndarray:
    """The samples (runs, ticks + 1, channels, robots) of the C program; ``threads`` share out the runs."""
    runs, samples, _, robots = numbers.noise.shape
    law = Lyapunov()
    gains = Gains(law.kx, law.ky, law.kpsi, law.catch_up)
    kept = np.empty((runs, samples, 14, robots))
    inputs = (numbers.parameters, numbers.starts, numbers.believed, numbers.references, numbers.noise)
    places = [ctypes.c_void_p(array.ctypes.data) for array in inputs]
    size = ctypes.c_ssize_t

    def drive(first: int, last: int) -> None:
        counts = (size(first), size(last), size(robots), size(samples - 1), size(numbers.late))
        library.drive(*counts, *places, ctypes.byref(gains), ctypes.c_void_p(kept.ctypes.data))

    if threads == 1:
        drive(0, runs)
        return kept
    edges = [runs * k // threads for k in range(threads + 1)]
    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(drive, edges[:-1], edges[1:]))
    return kept


def ours(about: Scenario, law: Any, seeds: int, threads: int | None = None) -> Any:
    """Our run, with so many threads where the simulation takes them."""
    options: dict[str, Any] = {"threads": threads} if takes_threads() else {}
    return simulate(about, law, range(seeds), **options)


def takes_threads() -> bool:
    """Whether a simulation can be given threads."""
    return "threads" in inspect.signature(simulate).parameters


def differences(library: ctypes.CDLL, about: Scenario, seeds: int) -> dict[str, float]:
    """The greatest distances [m] between our robots and the C program's. AssertionError beyond AGREEMENT.

    Between two counts of an encoder a wheel's loop sees nothing, and differences grow tenfold in some five seconds: two
    programs that round but once otherwise agree to a nanometre for EARLY seconds, and later to some micrometres.
    With encoders so FINE that this does not happen they agree to a nanometre at the end.
    """
    fine = replace(about, robots=tuple(replace(m, robot=replace(m.robot, counts_per_turn=FINE)) for m in about.robots))
    found: dict[str, float] = {}
    for name, case in (("encoders as they are", about), ("fine encoders", fine)):
        kept = c_program(library, Numbers.of(case, seeds))
        run = ours(case, Lyapunov(), seeds)
        gap = np.hypot(*(run[channel] - kept[:, :, i].transpose(0, 2, 1) for i, channel in enumerate(("x", "y"))))
        until = {f"{name}, {EARLY:g} s": gap[..., run.time <= EARLY], f"{name}, {run.time[-1]:g} s": gap}
        found |= {when: float(part.max()) for when, part in until.items()}
    early, late, fine_early, fine_late = found.values()
    assert max(early, fine_early, fine_late) < AGREEMENT, f"the C program drives elsewhere: {found}"
    assert late < COUNT, f"the C program drives elsewhere: {found}"
    return found


def cases(library: ctypes.CDLL | None) -> Mapping[str, Callable[[], Any]]:
    """What takes turns, by name. "one: ..." is a run of 60 s, "many: ..., 2 threads" are SEEDS runs."""
    one, crowd = (scenario(ROBOTS, duration, noise=True) for duration in (ONE_DURATION, MANY_DURATION))
    laws = {name: make_controller(name) for name in CONTROLLERS}
    turns: dict[str, Callable[[], Any]] = {}
    numbers = {1: Numbers.of(one, 1), SEEDS: Numbers.of(crowd, SEEDS)}
    turns |= {f"one: {name}": partial(ours, one, law, 1) for name, law in laws.items()}
    turns |= {
        f"draw: {name}": partial(Numbers.of, *of) for name, of in {"one": (one, 1), "many": (crowd, SEEDS)}.items()
    }
    if library is not None:
        turns["one: C"] = partial(c_program, library, numbers[1])
    for threads in THREADS:
        if library is not None:
            turns[f"many: C, {threads}"] = partial(c_program, library, numbers[SEEDS], threads)
        if threads == 1 or takes_threads():
            turns |= {
                f"many: {name}, {threads}": partial(ours, crowd, law, SEEDS, threads) for name, law in laws.items()
            }
    return turns


def population() -> float | None:
    """Seconds for CANDIDATES laws of 16 fuzzy rules, TRIALS seeds each, metrics only; None where it cannot be done."""
    together = getattr(robotics, "simulate_many", None)
    if together is None:
        return None
    about, law = scenario(1, TRIAL, noise=True), FuzzyTracking()
    laws: list[Any] = [replace(law, look_ahead=ahead) for ahead in np.linspace(0.3, 0.6, CANDIDATES).tolist()]
    together(about, laws[:2], range(2), keep="metrics", threads=THREADS[-1])
    return seconds(lambda: together(about, laws, range(TRIALS), keep="metrics", threads=THREADS[-1]))


def stress(runs: int, robots: int) -> float:
    """Seconds for so many random crossings under right of way, as `robotics stress crossing` simulates them."""
    one, crew = partial(stress_crossing, "right-of-way", robots), Crew(workers=THREADS[-1])
    in_pieces(one, robots, range(2), Crew(workers=1))
    return seconds(lambda: in_pieces(one, robots, range(runs), crew))


def team() -> float:
    """Seconds for TEAMS random crossings of three under the fuzzy team, in threads of one process."""
    drive = partial(stress_crossing, "fuzzy-team", 3)
    drive(range(2))
    return seconds(lambda: drive(range(TEAMS)))


def large(quick: bool) -> dict[str, float | None]:
    """Seconds of what takes long, each once."""
    if quick:
        return {}
    found = {"population": population()}
    found |= {f"{runs} crossings of {robots}": stress(runs, robots) for runs, robots in CROSSINGS}
    return found | {TEAM: team()}


def measure(quick: bool = False) -> dict[str, Any]:
    """Every number of the report, by name."""
    notes = []
    try:
        library = compiled()
    except ImportError as error:
        library = None
        notes.append(f"The C program is left out: {error}.")
    if not takes_threads():
        notes.append("A simulation takes no threads yet.")
    gaps = {} if library is None else differences(library, scenario(ROBOTS, ONE_DURATION, noise=True), 8)
    turns = cases(library)
    times: dict[str, list[float]] = {name: [] for name in turns}
    for call in turns.values():
        call()
    for _ in range(ROUNDS):
        for name, call in turns.items():
            times[name].append(seconds(call))
    peers: dict[str, Any] = {}
    for name in () if quick else PEERS:
        try:
            peers[name] = measured(name)
        except ImportError as error:
            notes.append(f"{name} is left out: {error}.")
    # The loaded machine disturbs the two of a pair alike only within a round.
    ratios = {}
    for name in times:
        kind, _, law = name.partition(": ")
        rival = f"{kind}: C{law[law.find(',') :] if ',' in law else ''}"
        if kind != "draw" and rival in times and rival != name:
            ratios[name] = median(a / b for a, b in zip(times[name], times[rival], strict=True))
    ticks = round(MANY_DURATION / 0.05)
    return machine(["numpy", "numba"]) | {
        "load": os.getloadavg()[0] if hasattr(os, "getloadavg") else None,
        "difference_m": gaps,
        "seconds": {name: median(values) for name, values in times.items()},
        "ratio_to_c": ratios,
        "robot_ticks_per_s": {
            name: SEEDS * ROBOTS * ticks / median(values) for name, values in times.items() if name.startswith("many")
        },
        "once_s": large(quick),
        "peers": peers,
        "rounds": ROUNDS,
        "seeds": SEEDS,
        "notes": notes,
    }


def report(result: dict[str, Any]) -> str:
    """The result as a table, beside what we aim for."""
    load = "" if result["load"] is None else f"; load {result['load']:.1f}"
    lines = [f"{heading(result)}; median of {result['rounds']} rounds{load}", ""]
    if result["difference_m"]:
        gaps = ", ".join(f"{gap:.0e} m ({name})" for name, gap in result["difference_m"].items())
        lines += [f"Our robots and the C program's are apart by at most: {gaps}", ""]
    ratio = {name: f"{value:>9.2f} x C" for name, value in result["ratio_to_c"].items()}
    taken = result["seconds"]
    lines.append(f"One run of {ROBOTS} robots, 60 s (aim: {ONE_RUN * 1e3:g} ms, {TIMES_C:g} x C)")
    for name in (n for n in taken if n.startswith("one")):
        lines.append(f"  {name[5:]:22}{taken[name] * 1e3:>9.2f} ms{ratio.get(name, '')}")
    lines += [f"  {'drawing the noise':22}{taken['draw: one'] * 1e3:>9.2f} ms", ""]
    aim = f"aim: {MANY_TIMES_C:g} x C, {SECOND_THREAD:g} times as many on two threads"
    lines.append(f"{result['seeds']:,} seeds of {ROBOTS} robots, million robot-ticks a second by threads ({aim})")
    for name, rate in result["robot_ticks_per_s"].items():
        lines.append(f"  {name[6:]:22}{rate / 1e6:>9.2f}   {ratio.get(name, '')}")
    share = SEEDS * ROBOTS * round(MANY_DURATION / 0.05) / taken["draw: many"] / 1e6
    lines.append(f"  {'drawing the noise':22}{share:>9.2f}")
    if result["peers"]:
        lines += [
            "",
            "Other simulators, robot-ticks a second of robots that have their velocity at once, without a law",
        ]
    for name, peer in result["peers"].items():
        rates = "; ".join(f"{case} {rate:,.0f}" for case, rate in peer["robot_ticks_per_s"].items())
        lines.append(f"  {name + ' ' + peer['version']:22}{rates} ({PEERS[name].models})")
    if result["once_s"]:
        lines += ["", "Once, on two cores"]
    for name, value in result["once_s"].items():
        time_taken = "not possible yet" if value is None else f"{value:.1f} s"
        lines.append(f"  {name:22}{time_taken} (aim: {AIMS[name]:g} s)")
    return "\n".join(lines + result["notes"])


if __name__ == "__main__":
    start(__doc__, measure, report, quick="leave out population, stress and the other simulators")
