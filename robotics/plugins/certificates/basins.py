"""From which errors a law's robot comes to its path: proven, beside what simulated starts do."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi

import numpy as np
from matplotlib.figure import Figure

from fuzzy.figures.drawing import COLORS, DOUBLE, styled_figure
from robotics.laws.catalogue import label
from robotics.measures.tracking import cross_track_error, timetable_error
from robotics.plugins.certificates.badge import LoopBadge, badge
from robotics.plugins.certificates.commandstates import StateCertificate
from robotics.plugins.certificates.loopmodel import LoopModel
from robotics.plugins.certificates.regions import LoopCertificate
from robotics.simulation.loop import simulate
from robotics.simulation.scenario.description import Member, Scenario
from robotics.world.paths.path import Circle, Line
from robotics.world.paths.trajectory import Timing
from robotics.world.vehicle.robot import Robot

START_BOX = (1.0, 1.0, pi / 3)  # m, m, rad: the errors from which is started
COME_WITHIN = 0.05, 0.1  # m, rad: within which a robot is that has come to its path
_KEPT = 2.0  # s that it stays there, at the end


@dataclass(frozen=True, kw_only=True, eq=False)
class Basin:
    """What is proven of a law's closed loop and what simulated starts did, under the same references.

    Attributes:
        law: Its specification.
        found: The certificate; None: there is none.
        why: Why there is none; empty: there is one.
        starts: Errors (n, 3) from which the robot started at rest: X [m], Y [m], ψ [rad].
        came: Whether it came to its path and stayed there (n,).
        slice: As ``starts`` (n, 2), Y and ψ of starts with X = 0.
        slice_came: As ``came``.
    """

    law: str
    found: LoopCertificate | StateCertificate | None
    why: str
    starts: np.ndarray
    came: np.ndarray
    slice: np.ndarray
    slice_came: np.ndarray

    @property
    def shares(self) -> tuple[float, float]:
        """The certified region's part of the sampled basin: by volume, and by area in the plane X = 0."""
        if self.found is None:
            return 0.0, 0.0
        level, P = self.found.region, self.found.P
        volume = 4 / 3 * pi * level**1.5 / np.sqrt(np.linalg.det(P))
        area = pi * level / np.sqrt(np.linalg.det(P[1:, 1:]))
        basin = 8 * np.prod(START_BOX) * self.came.mean(), 4 * np.prod(START_BOX[1:]) * self.slice_came.mean()
        return float(volume / max(basin[0], volume)), float(area / max(basin[1], area))


def sampled_basin(
    law: str,
    robot: Robot,
    model: LoopModel,
    starts: int = 600,
    *,
    told: LoopBadge | None = None,
    duration: float = 25.0,
    seed: int = 0,
) -> Basin:
    """Certify a law's closed loop, and start robots at rest from errors within 1 m and 60 degrees.

    The starts are on a line and on circles both ways round, at the least and the greatest speed of the ``model``,
    without noise: half of ``starts`` anywhere in the box, half with X = 0.

    Args:
        law: A law's specification.
        robot: The robot.
        model: The assumptions of the certificate.
        starts: Number of starts.
        told: What was proven, where that is known; by default a small region is tried.
        duration: Length of each run [s].
        seed: Seed of the starts.

    Raises ControllerError for a law that there is not.
    """
    told = told or badge(law, robot, model)
    ways = [(v, k) for v in (model.speed_low, model.speed_high) for k in (0.0, model.curvature, -model.curvature)]
    each, parts = -(-starts // (2 * len(ways))), []
    for x in (START_BOX[0], 0.0):
        outcomes = [
            _driven(law, robot, model, way, (x, *START_BOX[1:]), duration, range(first, first + each))
            for way, first in zip(ways, range(seed, seed + len(ways) * each, each), strict=True)
        ]
        parts += [np.concatenate([outcome[k] for outcome in outcomes]) for k in (0, 1)]
    errors, came, flat, flat_came = parts
    return Basin(
        law=law,
        found=told.found,
        why=told.why,
        starts=errors,
        came=came,
        slice=flat[:, 1:],
        slice_came=flat_came,
    )


def _driven(
    law: str,
    robot: Robot,
    model: LoopModel,
    way: tuple[float, float],
    spread: tuple[float, float, float],
    duration: float,
    seeds: Sequence[int],
) -> tuple[np.ndarray, np.ndarray]:
    """The errors from which runs started (seeds, 3), and whether each came to its path (seeds,)."""
    v, curvature = way
    length = v * duration
    if curvature == 0:
        path: Line | Circle = Line(start=(0.0, 0.0), end=(length, 0.0))
    else:
        radius, left = 1 / abs(curvature), curvature > 0
        path = Circle(
            center=(0.0, 1 / curvature),
            radius=radius,
            start_angle=-pi / 2 if left else pi / 2,
            direction="counter-clockwise" if left else "clockwise",
            turns=length / (2 * pi * radius),
        )
    member = Member(start=(0, 0, 0), path=path, timing=Timing(duration=duration), start_spread=spread, robot=robot)
    scenario = Scenario(
        name="basin", robots=(member,), duration=duration, latency=model.latency, period=model.period, divergence=50.0
    )
    run = simulate(scenario, law, seeds=seeds)
    errors, last = timetable_error(run), round(_KEPT / model.period)
    path_error, heading = (np.abs(each[:, 0, -last:]).max(axis=1) for each in (cross_track_error(run), errors.heading))
    # Errors in the reference's frame, which at the start is the world's
    start = -np.stack([run[name][:, 0, 0] for name in ("x", "y", "heading")], axis=1)
    return start, (path_error < COME_WITHIN[0]) & (heading < COME_WITHIN[1])


def plot_basins(basins: Sequence[Basin]) -> Figure:
    """Draw, of each law, starts with X = 0 over Y and ψ and the section of the certified region.

    Args:
        basins: The laws, each as :func:`sampled_basin` gives it.
    """
    columns = min(3, len(basins))
    rows = -(-len(basins) // columns)
    with styled_figure(DOUBLE, 0.4 + 2.1 * rows) as figure:
        axes = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
        for ax in axes.flat[len(basins) :]:
            ax.set_visible(False)
        for ax, basin in zip(axes.flat, basins, strict=False):
            for came, color, marker, name in (
                (True, COLORS[0], ".", "comes to its path"),
                (False, COLORS[1], "x", "does not"),
            ):
                at = basin.slice[basin.slice_came == came]
                ax.plot(at[:, 0], at[:, 1], marker, color=color, markersize=3, label=name)
            if basin.found is not None:
                angle = np.linspace(0, 2 * np.pi, 181)
                shape = np.linalg.inv(np.linalg.cholesky(basin.found.P[1:, 1:])).T
                section = np.sqrt(basin.found.region) * shape @ np.stack([np.cos(angle), np.sin(angle)])
                ax.plot(*section, color="black", linestyle="-", linewidth=1.2)
            ax.plot([], [], color="black", linestyle="-", linewidth=1.2, label="certified")
            ax.set_title(label(basin.law))
        figure.supxlabel("Y [m]")
        figure.supylabel("ψ [rad]")
        handles, labels = axes.flat[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=3)
        return figure
