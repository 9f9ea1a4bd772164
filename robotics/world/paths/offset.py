"""Formations by offsets from one virtual robot, thesis (3.3) as corrected: q_id = q_0 + T(ψ_0) l_i.

(3.3) prints l_i = T(ψ_d) q_0, without an index. Here l_i = (ahead, left) is constant in the frame of a virtual robot
that drives along a path of its own; the robot's path is the exact curve of that point,

    r_i' = v_0 ((1 − κ_0 l_left) t + κ_0 l_ahead n)

with t, n the virtual robot's unit vectors ahead and to the left, and κ_0 its path's curvature. A robot to the left is
slower in a left turn; one ahead swings out, and its heading leads the virtual robot's by atan2(κ_0 l_ahead,
1 − κ_0 l_left). Neither the lengths of the paths nor the shares of them that are due at one time are alike: each path
keeps, beside its own abscissa, the share of the virtual path at which the virtual robot is then.
"""

from dataclasses import dataclass, replace

import numpy as np

from fuzzy.quantity import described, got, is_number
from robotics.world.paths.path import Path, PathError, Shape, compile_path
from robotics.world.paths.posture import wrapped
from robotics.world.paths.trajectory import Timing, Trajectory, compile_trajectory

_STEP = 1e-5  # of the virtual path's parameter: for its third derivative, which only the curvature needs
_KINK = 0.02  # rad: a heading that changes by more between two nodes than its curvature explains has jumped


@dataclass(frozen=True, kw_only=True)
class Offset:
    """The path of a point that is fixed in the frame of a virtual robot, which drives along ``path``."""

    path: Shape = described("The path of the virtual robot.")
    offset: tuple[float, float] = described(
        "The robot's place in a formation: how far [m] ahead of the virtual robot, and how far to its left.",
        example=[0.0, 0.5],
        accepts="2 finite numbers [ahead, left] in m, from the virtual robot",
    )

    def __post_init__(self) -> None:
        if not all(map(is_number, self.offset)):
            raise PathError(f"offset must be two finite numbers in m, ahead and to the left; {got(self.offset)}")

    def curve(self, u: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """See :class:`robotics.world.paths.path.Shape`."""
        ahead, left = self.offset
        p, slope, bend = self.path.curve(u)
        after, before = np.minimum(u + _STEP, 1.0), np.maximum(u - _STEP, 0.0)
        jerk = (self.path.curve(after)[2] - self.path.curve(before)[2]) / (after - before)
        speed = np.hypot(*slope)
        t = slope / speed
        n = np.stack([-t[1], t[0]])
        turn = _cross(slope, bend) / speed**2  # dψ/du
        turn_rate = _cross(slope, jerk) / speed**2 - 2 * turn * (slope * bend).sum(axis=0) / speed**2
        arm, across = ahead * t + left * n, ahead * n - left * t  # T l, and its derivative by ψ
        return p + arm, slope + turn * across, bend + turn_rate * across - turn**2 * arm


def compile_offset(shape: Offset, timing: Timing) -> Trajectory:
    """The trajectory of one robot of a formation, whose virtual robot drives along ``shape.path`` by ``timing``.

    Raises PathError where the path has a cusp or would be driven backwards, or where it has a corner, and for a virtual
    path or a timing that cannot be driven.
    """
    virtual = compile_path(shape.path)
    _check(shape, virtual)
    path = compile_path(shape)
    s_virtual = virtual.abscissa(path.nodes.u)
    share = s_virtual / virtual.length
    path = replace(path, shares=np.stack([share, virtual.length * _speed_ratio(shape, virtual, s_virtual)]))
    motion = compile_trajectory((virtual,), (timing,))
    due, rate = motion.tables[0]
    nodes = np.linspace(0.0, path.length, path.table.shape[1])
    s = np.interp(due / virtual.length, share, nodes)
    return Trajectory((path,), np.stack([s, rate * _speed_ratio(shape, virtual, due)])[None], motion.ends)


def offset_start(shape: Offset, timing: Timing) -> tuple[float, float, float]:
    """Where a robot of the formation shall be at time 0: x [m], y [m], heading [rad]. Raises as compile_offset."""
    begin = compile_offset(shape, timing).at(0.0)
    return float(begin.x[0]), float(begin.y[0]), float(wrapped(begin.heading)[0])


def _speed_ratio(shape: Offset, virtual: Path, s: np.ndarray) -> np.ndarray:
    """The robot's speed over the virtual robot's, where that is at the abscissae ``s`` [m]."""
    ahead, left = shape.offset
    curvature = virtual.at(s).curvature
    return np.hypot(1 - curvature * left, curvature * ahead)


def _check(shape: Offset, virtual: Path) -> None:
    """Refuse an offset beyond the virtual path's center of curvature, and one ahead where the curvature jumps."""
    ahead, left = shape.offset
    curvature = virtual.nodes.curvature
    forward = 1 - curvature * left
    k = int(forward.argmin())
    if forward[k] <= 0.01:
        least, most = float(curvature.min()), float(curvature.max())
        bounds = [f"> {1 / least:.4g}"] if least < 0 else []
        bounds += [f"< {1 / most:.4g}"] if most > 0 else []
        raise PathError(
            f"offset: {abs(left):g} m to the {'left' if left > 0 else 'right'} reaches the center of curvature of the "
            f"virtual path, which is {1 / abs(curvature[k]):.4g} m beside ({virtual.nodes.x[k]:.3g}, "
            f"{virtual.nodes.y[k]:.3g}) m: there the robot's path has a cusp and runs back; accepted to the left are "
            f"offsets {' and '.join(bounds)} m"
        )
    heading = virtual.nodes.heading + np.arctan2(curvature * ahead, forward)
    jump = np.abs(np.diff(np.arctan2(curvature * ahead, forward)))
    k = int(jump.argmax())
    beside = np.abs(np.diff(heading))[max(k - 2, 0) : k + 3]
    if jump[k] > _KINK and jump[k] > 5 * np.median(beside):
        raise PathError(
            f"offset: {ahead:g} m ahead gives the robot's path a corner of {jump[k]:.3g} rad, for the curvature of the "
            f"virtual path jumps near ({virtual.nodes.x[k]:.3g}, {virtual.nodes.y[k]:.3g}) m; "
            "accepted there is 0 m ahead"
        )


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return a[0] * b[1] - a[1] * b[0]
