"""How well ``robotics identify`` knows robots of our own plant: coverage of its intervals, latency, prediction, time.

    python -m benchmarks.identification --robots 20 -o identification.json

Each robot is drawn around the EtsRo: mass, inertia, motors, gains, friction, limits, encoders, latency, and wheels that
odometry has wrong. It drives the minute that ``robotics excite`` writes; its log has encoders' rounding, and poses with
3 mm and 3 mrad of noise; with --noise its velocities have white noise besides. Rows are saved as they come.
"""

import argparse
import json
import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from fuzzy.files.atomic import write_json
from robotics.plugins.identify.excitation import excite
from robotics.plugins.identify.identified import Identified, identify
from robotics.plugins.identify.model import COORDINATE_NAMES, COORDINATES, values_of
from robotics.plugins.identify.replay import Program, replayed
from robotics.plugins.identify.signals import MeasuredVelocities, Poses, Signals
from robotics.plugins.logs.drive import Commands
from robotics.simulation.run import Run
from robotics.simulation.scenario.robots import load_robot
from robotics.world.sensing.posture import Sensing, wheel_errors
from robotics.world.vehicle.robot import Robot

SHEET = "etsro"
SENSING = Sensing(posture="pose", position_noise=0.003, heading_noise=0.003, wheel_error=0.01)


@dataclass(frozen=True)
class Hidden:
    """A robot that the estimator has never seen."""

    robot: Robot
    latency: float
    errors: np.ndarray  # (3,): sizes of right wheel, left wheel and axle that odometry assumes, over the true ones
    seed: int


def hidden(seed: int) -> Hidden:
    """Draw a robot around the data sheet."""
    sheet, generator = load_robot(SHEET).robot, np.random.default_rng(seed)
    names = ("kp", "ki", "torque_constant", "friction_torque", "torque_limit", "body_mass", "body_inertia")
    numbers = {name: getattr(sheet, name) * float(np.exp(0.2 * generator.standard_normal())) for name in names}
    numbers |= {"v_max": float(generator.uniform(0.4, 0.9)), "w_max": float(generator.uniform(2, 6))}
    numbers["counts_per_turn"] = float(generator.integers(800, 8000))
    if generator.uniform() < 0.5:
        numbers["v_rate_max"] = float(generator.uniform(0.6, 4))
    if generator.uniform() < 0.5:
        numbers["w_rate_max"] = float(generator.uniform(4, 20))
    errors = wheel_errors((SENSING,), [seed])
    assert errors is not None
    return Hidden(sheet.changed(**numbers), 0.01 * int(generator.integers(0, 21)), errors[:, 0], seed)


def signals_of(one: Hidden, program: Program, noise: float = 0.0) -> Signals:
    """The log of its drive, with white noise of ``noise`` [m/s] on v and five times as much [1/s] on ω besides."""
    run = replayed(one.robot, program, latency=one.latency, sensing=SENSING, seed=one.seed)
    drawn = np.random.default_rng([one.seed, 9]).standard_normal((2, len(run.time))) * noise
    return log_of(run, f"hidden-{one.seed}", (drawn[0], 5 * drawn[1]))


def log_of(run: Run, name: str, noise: tuple[float | np.ndarray, float | np.ndarray] = (0.0, 0.0)) -> Signals:
    """What is logged of a robot's run, with this noise on v [m/s] and ω [rad/s]."""
    assert run.encoders is not None
    velocities = MeasuredVelocities(run.time, run.encoders[:, 2, 0, 0] + noise[0], run.encoders[:, 3, 0, 0] + noise[1])
    poses = Poses(run.time, *(run[f"{axis}_measured"][0, 0] for axis in ("x", "y", "heading")))
    commands = Commands(run.time, run["command_1"][0, 0], run["command_2"][0, 0])
    return Signals(name, commands, velocities, poses)


def truths(one: Hidden) -> dict[str, float]:
    """The numbers that an interval may cover."""
    right, left, axle = one.errors
    found = dict(zip(COORDINATE_NAMES, values_of(one.robot, one.latency).tolist(), strict=True))
    # Odometry takes each wheel for so much larger, and the axle: turns are seen so much smaller
    found |= {"right_gain": right, "left_gain": left, "turn_gain": 1 / axle}
    found |= {"scale": (1 / right + 1 / left) / 2, "wheel_ratio": left / right, "axle_ratio": 1 / axle}
    return found | {
        "position_noise": 0.003,
        "heading_noise": 0.003,
        "counts_per_turn": one.robot.counts_per_turn / right,
    }


def judged(one: Hidden, found: Identified) -> list[dict[str, object]]:
    """A row a number: the truth, the interval, and whether it covers."""
    true = truths(one)
    rows: list[dict[str, object]] = []
    for each in found.numbers:
        if each.name in true:
            low, high = each.ends
            inside = bool(low <= true[each.name] <= high)
            rows.append({"robot": one.seed, "true": true[each.name], **each.row(), "covers": inside})
    return rows


def ahead(one: Hidden, found: Identified, program: Program, noise: float) -> dict[str, float]:
    """RMS errors of v and ω that the fit predicts on another drive, over the deviation of what is measured there."""
    from robotics.plugins.identify.model import Stimulus, drive, sampled

    other = Program(program.time, -program.v[::-1], program.w[::-1])
    log = signals_of(replace(one, seed=one.seed + 10_000), other, noise)
    log = replace(log, velocities=signals_of(one, other, noise).velocities)
    seen, given = log.velocities, log.commands
    stimulus = Stimulus.of(given.time, given.v, given.w, -0.1, float(seen.time[-1]))
    window = np.full(len(seen.time), 0.05 if found.motion.averaged else 0.0)
    sheet = load_robot(SHEET).robot
    own = sampled(drive(sheet, found.motion.values[:, None], stimulus), seen.time, window)[:, :, 0]
    wrong = (own - np.stack([seen.v, seen.w]))[:, 5:]
    # The noise: what the true robot's smooth motion, by the same plant, leaves
    count = 2 * np.pi * one.robot.wheel_radius / one.robot.counts_per_turn / 0.05
    rounding = np.array([count / np.sqrt(12), count / np.sqrt(12) / sheet.half_axle])
    scale = np.hypot(rounding, [noise, 5 * noise])
    v, w = np.sqrt((wrong**2).mean(axis=1)) / scale
    return {"v": float(v), "w": float(w)}


def main() -> None:
    """Draw, drive, identify, judge; print a summary."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robots", type=int, default=20)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--noise", type=float, default=0.0)
    parser.add_argument("-o", "--out", type=Path)
    chosen = parser.parse_args()
    program = excite(load_robot(SHEET).robot, 3.0, 60.0).program
    rows: list[dict[str, object]] = []
    runs: list[dict[str, object]] = []
    for seed in range(chosen.first, chosen.first + chosen.robots):
        one = hidden(seed)
        log = signals_of(one, program, chosen.noise)
        wall, used = time.perf_counter(), time.process_time()
        found = identify(log, load_robot(SHEET), seed=0)
        wall, used = time.perf_counter() - wall, time.process_time() - used
        mine = judged(one, found)
        late = abs(found.motion.value("latency") - one.latency)
        ratios = ahead(one, found, program, chosen.noise)
        runs.append({"robot": seed, "latency_error_s": late, "prediction": ratios, "wall_s": wall, "processor_s": used})
        rows += mine
        missed = [row["name"] for row in mine if not row["covers"]]
        print(
            f"robot {seed}: {len(mine) - len(missed)} of {len(mine)} covered, latency {1000 * late:.2f} ms off, "
            f"prediction {ratios['v']:.2f} and {ratios['w']:.2f} of the noise, {wall:.1f} s (processors {used:.1f} s)"
            f"; missed {missed}",
            flush=True,
        )
        if chosen.out is not None:
            write_json(chosen.out, {"noise": chosen.noise, "runs": runs, "rows": rows})
    share = np.mean([bool(row["covers"]) for row in rows])
    print(json.dumps({"covered": float(share), "numbers": len(rows), "coordinates": len(COORDINATES)}))


if __name__ == "__main__":
    main()
