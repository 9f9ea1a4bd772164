"""Tables of quintic paths, made quickly: for thousands of random paths."""

import numpy as np

from robotics.paths.path import CURVATURE, HEADING, Quintic, U, X, Y


def quintic_table(shape: Quintic, spacing: float = 0.02) -> np.ndarray:
    """Make the table of :class:`robotics.paths.path.Path` for a quintic, to about 1e-6 m.

    Nodes are at most ``spacing`` [m] apart. :func:`robotics.paths.path.compile_path` is slower and more exact.
    """
    u = np.linspace(0.0, 1.0, 801)
    _, slope, _ = shape.curve(u)
    speed = np.hypot(slope[0], slope[1])
    # Simpson's rule over pairs of steps, and its half-step form between
    h = u[1]
    pieces = np.empty(800)
    pieces[0::2] = h / 12 * (5 * speed[:-2:2] + 8 * speed[1::2] - speed[2::2])
    pieces[1::2] = h / 12 * (-speed[:-2:2] + 8 * speed[1::2] + 5 * speed[2::2])
    measured = np.concatenate([[0.0], np.cumsum(pieces)])
    s = np.linspace(0.0, measured[-1], max(33, int(np.ceil(measured[-1] / spacing)) + 1))
    parameter = np.interp(s, measured, u)
    for _ in range(2):  # Newton, the speed taken linearly between the samples
        k = np.clip((parameter / h).astype(int), 0, 799)
        t = parameter - u[k]
        here = measured[k] + t * (speed[k] + (speed[k + 1] - speed[k]) * t / (2 * h))
        parameter = np.clip(parameter + (s - here) / np.interp(parameter, u, speed), 0.0, 1.0)
    position, slope, bend = shape.curve(parameter)
    speed = np.hypot(slope[0], slope[1])
    table = np.empty((5, len(s)))
    table[X], table[Y] = position
    table[HEADING] = np.unwrap(np.arctan2(slope[1], slope[0]))
    table[CURVATURE] = (slope[0] * bend[1] - slope[1] * bend[0]) / speed**3
    table[U] = parameter
    return table
