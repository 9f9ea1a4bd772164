"""What a page tells of a rule base while it is edited: certified with size and rate, or why not."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from fuzzy.errors import InputError
from fuzzy.system import Sugeno
from robotics.plugins.certificates.commandstates import StateCertificate, certified
from robotics.plugins.certificates.loopmodel import LoopModel, closed_loop
from robotics.plugins.certificates.regions import QUICK_EFFORT, LoopCertificate
from robotics.plugins.certificates.starts import follow, wheels_in_region
from robotics.simulation.scenario.robots import load_robot
from robotics.world.vehicle.robot import Robot

_STARTS = 24  # robots whose errors are drawn, all from the region's boundary
_DURATION = 6.0  # s that they drive
_EVERY = 2  # samples, of which one is drawn
PLANES = ((0, 1), (1, 2))  # of the errors X, Y and ψ, on which the region is drawn


@dataclass(frozen=True)
class LoopBadge:
    """The short answer about a rule base's own closed loop: a certificate, or why there is none."""

    found: LoopCertificate | StateCertificate | None
    why: str  # empty: it is certified


def badge(law: Sugeno | str, robot: Robot, model: LoopModel | None = None) -> LoopBadge:
    """Certify a rule base, or a law by its specification, in a small region; or say what is in the way."""
    try:
        found, why = certified(closed_loop(law, robot, model), QUICK_EFFORT)
    except InputError as error:
        return LoopBadge(None, str(error))
    if found is None:
        return LoopBadge(None, why)
    wrong = wheels_in_region(found, robot)
    return LoopBadge(None, wrong) if wrong else LoopBadge(found, "")


def drawn(fis: Sugeno, robot: str, model: LoopModel) -> dict[str, Any]:
    """The badge for a page, with the region on the planes of the errors and simulated errors, in JSON's types."""
    machine = load_robot(robot).robot
    told = badge(fis, machine, model)
    if (found := told.found) is None:
        return {"certified": False, "why": told.why}
    rng, z = np.random.default_rng(0), np.random.default_rng(1).standard_normal((_STARTS, 3))
    z *= np.sqrt(found.region / found.level(z))[:, None]
    errors, drives = follow(found.loop, machine, z, _DURATION, rng, found.from_reference)
    left = int((found.levels(errors, drives)[::_EVERY].max(axis=0) > found.region * (1 + 1e-9)).sum())
    errors = errors[::_EVERY]
    return {
        "certified": True,
        "half_widths": found.half_widths().tolist(),
        "end": found.half_widths(found.ultimate).tolist(),
        "rate": found.rate,
        "left": left,
        "starts": _STARTS,
        "outlines": [[_outline(found, level, pair) for level in (found.region, found.ultimate)] for pair in PLANES],
        "errors": [errors[:, :, list(pair)].swapaxes(0, 1).round(5).tolist() for pair in PLANES],
    }


def _outline(found: LoopCertificate | StateCertificate, level: float, pair: tuple[int, int]) -> list[list[float]]:
    """The shadow of V <= level on a plane of two errors (points, 2)."""
    shadow = np.linalg.cholesky(np.linalg.inv(found.P)[np.ix_(pair, pair)])
    angle = np.linspace(0, 2 * np.pi, 91)
    points: list[list[float]] = (np.sqrt(level) * shadow @ [np.cos(angle), np.sin(angle)]).T.tolist()
    return points
