"""Simulated starts in a certified region, with the simulator's plant: what a wrong proof or assumption has to fear."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from robotics.plugins.certificates.loopcolumns import LoopColumns
from robotics.plugins.certificates.loopmodel import ClosedLoop
from robotics.plugins.certificates.wheels import WINDOW, Drives, differences, driven_period
from robotics.world.vehicle import plant
from robotics.world.vehicle.plant import STEP, Plant, TruthColumns
from robotics.world.vehicle.robot import Robot


@dataclass(frozen=True)
class Starts:
    """What V did, over that on the region's boundary: at its greatest and at the end of each start (starts,).

    Attributes:
        greatest: Of any sample.
        last: Of the last one.
        drives: What was commanded and what the wheels did.
    """

    greatest: np.ndarray
    last: np.ndarray
    drives: Drives


def simulate_starts(
    certificate: Any,
    robot: Robot,
    starts: int,
    duration: float = 10.0,
    seed: int = 0,
    share: float = 1.0,
) -> Starts:
    """Drive robots on lines and circles from errors with V <= ``share`` of the region's, half of them at just that.

    Before the start they have driven at the speeds that the law asks for there, or as their reference. Noise is at the
    ends of its range, or anywhere in it.
    """
    loop, rng = certificate.loop, np.random.default_rng(seed)
    z = rng.standard_normal((starts, 3))
    radius = np.where(np.arange(starts) % 2, 1.0, rng.uniform(0, 1, starts) ** (1 / 3))
    z *= (radius * np.sqrt(share * certificate.region / certificate.level(z)))[:, None]
    errors, drives = follow(loop, robot, z, duration, rng, certificate.from_reference)
    level = certificate.levels(errors, drives) / certificate.region
    return Starts(level.max(axis=0), level[-1], drives)


def follow(
    loop: ClosedLoop,
    robot: Robot,
    start: np.ndarray,
    duration: float,
    rng: np.random.Generator,
    from_reference: bool = False,
) -> tuple[np.ndarray, Drives]:
    """Drive robots from errors (starts, 3) by the law itself; the errors (samples, starts, 3), and the drives.

    Before the start they have driven at the speeds that the law asks for there, or ``from_reference`` at its speeds.
    """
    model, n = loop.model, len(start)
    v_r = rng.uniform(model.speed_low, model.speed_high, n)
    extreme = rng.random(n) < 0.3
    v_r = np.where(extreme, rng.choice([model.speed_low, model.speed_high], n), v_r)
    bend = np.where(rng.random(n) < 0.3, rng.choice([-1, 1], n), rng.uniform(-1, 1, n)) * model.curvature
    w_r = bend * v_r
    steps, late = round(model.period / STEP), round(model.latency / STEP)
    machine = Plant(np.repeat(plant.parameters(robot)[:, None], n, axis=1), steps=1)
    state = plant.initial_state(np.zeros((n, 3)))
    limits = np.repeat(plant.velocity_limits([robot]), n, axis=1)
    fresh = float(LoopColumns(loop.numbers).fresh)
    first = np.array(plant.saturate(limits, *((v_r, w_r) if from_reference else asked(loop, start, v_r, w_r))))
    for _ in range(round(2 / STEP)):
        state = machine.advance(state, first, first, 0, "velocity")
    state, *settled = driven_period(machine, state, [first] * steps, model.period)
    truth = TruthColumns(state)
    # The reference begins at the origin, along x
    truth.x, truth.y, truth.heading = -start[:, 0], -start[:, 1], -start[:, 2]
    ref, commands, errors, means, instants = np.zeros((3, n)), [first] * (WINDOW + 1), [], [], []
    for _ in range(round(duration / model.period) + 1):
        here = TruthColumns(state)
        dx, dy, cos, sin = ref[0] - here.x, ref[1] - here.y, np.cos(ref[2]), np.sin(ref[2])
        z = np.array([cos * dx + sin * dy, cos * dy - sin * dx, ref[2] - here.heading]).T
        errors.append(z)
        angle, far = rng.uniform(-np.pi, np.pi, n), rng.choice([1.0, rng.random()], n)
        noise = np.array([np.cos(angle) * far, np.sin(angle) * far, rng.choice([-1, 1], n) * far]).T
        wanted = np.array(asked(loop, z + noise * model.noise, v_r, w_r))
        # Behind a low-pass: the correction of the reference's velocity, of which it keeps what can be driven
        wanted = fresh * wanted + (1 - fresh) * commands[-1]
        commands.append(np.array(plant.saturate(limits, *wanted)))
        held = [commands[-1] if i >= late else commands[-2] for i in range(steps)]
        state, mean, row = driven_period(machine, state, held, model.period)
        means.append(mean)
        instants.append(row)
        turn = w_r * model.period
        along, middle = v_r * model.period * np.sinc(turn / 2 / np.pi), ref[2] + turn / 2
        ref = np.array([ref[0] + along * np.cos(middle), ref[1] + along * np.sin(middle), ref[2] + turn])
    before = WINDOW + 1
    seen = np.array([settled[0]] * before + means), np.array([settled[1]] * before + instants)
    drives = Drives(np.array(commands), *seen)
    return np.array(errors), drives


def asked(loop: ClosedLoop, z: np.ndarray, v_r: np.ndarray, w_r: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What the law asks for at errors (n, 3), by itself and not by intervals: v [m/s] and ω [rad/s] (n,)."""
    cos, sin, psi = np.cos(z[:, 2]), np.sin(z[:, 2]), z[:, 2]
    x_err, y_err = cos * z[:, 0] - sin * z[:, 1], sin * z[:, 0] + cos * z[:, 1]
    if loop.rules is None:
        return loop.law.velocities(np.column_stack([x_err, y_err, psi]), v_r, w_r)
    known = {"x_err": x_err, "y_err": y_err, "heading_err": psi, "target_v": v_r, "target_w": w_r}
    said = np.asarray(loop.rules(np.column_stack([known[v.name] for v in loop.rules.inputs])))
    found = dict(zip((v.name for v in loop.rules.outputs), said.T, strict=True))
    v = v_r * cos + found.get("dv", 0.0)
    speed = np.maximum(np.abs(v_r), np.minimum(np.abs(v), float(LoopColumns(loop.numbers).catch_up)))
    return v, w_r + found.get("dw", 0.0) + speed * found.get("bend", 0.0)


def wheels_in_region(certificate: Any, robot: Robot, starts: int = 400) -> str:
    """What the wheels did in the region that is not assumed of them; empty: nothing."""
    wheels, drives = certificate.loop.wheels, simulate_starts(certificate, robot, starts, 3.0).drives
    steady, reversing, beyond = differences(robot, wheels, drives)
    for seen, assumed, what in (
        (steady, wheels.error, "differ from the mean of their commands"),
        (
            reversing,
            wheels.error + wheels.reversal,
            "differ, where a wheel turns round, from that mean",
        ),
        (beyond, wheels.ripple, "leave the hull of their commands"),
    ):
        if (seen > assumed).any():
            return f"v and ω {what} by {seen[0]:.3g} m/s and {seen[1]:.3g} rad/s, more than was measured before"
    return ""
