"""The picture of a certificate: its region, and trajectories of the nonlinear error dynamics inside it."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from fuzzy.figures.drawing import COLORS, DOUBLE, number, styled_figure
from robotics.plugins.certificates.certificate import Certificate, CertificateTrial, try_out
from robotics.world.vehicle.robot import Robot

_NAMES = ("x_err [m]", "y_err [m]", "ψ_err [rad]")
_TRAJECTORY: dict[str, Any] = {"color": COLORS[0], "linestyle": "-", "linewidth": 0.5, "alpha": 0.7}
_REGION: dict[str, Any] = {"color": "black", "linestyle": "-", "linewidth": 1.2}
_UNSATURATED: dict[str, Any] = {"color": COLORS[1], "linestyle": "--", "linewidth": 1.2}
_BOUND: dict[str, Any] = {"color": "0.45", "linestyle": ":", "linewidth": 1.0}


def plot_certificate(
    certificate: Certificate, robot: Robot, starts: int = 40, duration: float = 20.0, seed: int = 0
) -> Figure:
    """Draw the certified region over (x, y) and (y, ψ), and √V over time against the certified bound.

    The trajectories begin anywhere on the region's boundary; the reference's v_r and ω_r jump about in their ranges
    every second. A dashed line encloses where no command saturates.

    Args:
        certificate: The certificate.
        robot: The robot whose limits count.
        starts: Number of trajectories.
        duration: Length of the trajectories [s].
        seed: Seed of the starts and of the jumps.
    """
    trial = try_out(certificate, starts=starts, steps=max(1, round(duration / 0.01)), hold=100, seed=seed)
    share = certificate.unsaturated(robot)
    with styled_figure(DOUBLE, 2.5) as figure:
        left, middle, right = figure.subplots(1, 3)
        _draw_region(left, certificate, trial, share, (0, 1))
        _draw_region(middle, certificate, trial, share, (1, 2))
        left.set_aspect("equal", adjustable="datalim")
        for side in (-1, 1):
            middle.axhline(side * certificate.model.heading, **_BOUND)
        _draw_decay(right, certificate, trial)
        handles = [
            Line2D([], [], **_REGION, label="certified region, e'Pe ≤ 1"),
            Line2D([], [], **_TRAJECTORY, marker=".", label="nonlinear error dynamics"),
            Line2D([], [], **_BOUND, label="premise |ψ| ≤ " + number(certificate.model.heading) + " rad"),
        ]
        if share > 0:
            handles.insert(1, Line2D([], [], **_UNSATURATED, label="no command saturates"))
        figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), columnspacing=1.2)
        return figure


def _draw_region(
    ax: Axes, certificate: Certificate, trial: CertificateTrial, share: float, pair: tuple[int, int]
) -> None:
    """The ellipsoid's shadow on a plane of two errors, and the trajectories'."""
    i, j = pair
    for n in range(trial.errors.shape[1]):
        ax.plot(trial.errors[:, n, i], trial.errors[:, n, j], **_TRAJECTORY)
    ax.plot(trial.errors[0, :, i], trial.errors[0, :, j], ".", color=COLORS[0], markersize=3)
    angle = np.linspace(0, 2 * np.pi, 361)
    shadow = np.linalg.cholesky(np.linalg.inv(certificate.P)[np.ix_(pair, pair)])
    outline = shadow @ np.stack([np.cos(angle), np.sin(angle)])
    ax.plot(*outline, **_REGION)
    if share > 0:
        ax.plot(*(share * outline), **_UNSATURATED)
    ax.set(xlabel=_NAMES[i], ylabel=_NAMES[j])


def _draw_decay(ax: Axes, certificate: Certificate, trial: CertificateTrial) -> None:
    ax.semilogy(trial.time, np.sqrt(trial.levels), **_TRAJECTORY)
    bound = np.exp(-certificate.decay * trial.time)
    ax.semilogy(trial.time, bound, **_REGION, label=f"certified: $e^{{-{certificate.decay:.3g}\\,t}}$")
    ax.legend(loc="lower left")  # what falls leaves this corner free
    ax.set_xlim(0, trial.time[-1])
    ax.set_ylim(top=2.0)
    ax.set(xlabel="time [s]", ylabel="√(e'Pe)")
