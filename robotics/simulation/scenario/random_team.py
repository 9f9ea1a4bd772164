"""Random teams of any size: paths that every robot can drive, as the text of a scenario file."""

import numpy as np

from fuzzy.errors import InputError
from robotics.simulation.scenario.description import Scenario
from robotics.simulation.scenario.reading import parse_scenario
from robotics.world.paths.path import PathError, Quintic, compile_path


class TeamError(InputError):
    """A team that cannot be made."""


def random_team(
    robots: int, seed: int = 0, *, speed: float = 0.25, controller: str = "virtual-structure", radio: str = "complete"
) -> Scenario:
    """Make a team on random paths that every robot can drive.

    Args:
        robots: Their number, 2 to 2000.
        seed: Of the random paths.
        speed: The speed on the longest path [m/s].
        controller: The specification of the controller.
        radio: The name of the graph.

    Returns:
        The scenario.

    Raises:
        TeamError: Numbers with which no team can be made.
        ScenarioError: A controller or graph that does not suit.
    """
    name = f"team-{robots}"
    return parse_scenario(team_toml(robots, seed, speed=speed, controller=controller, radio=radio), name, name)


def team_toml(
    robots: int, seed: int = 0, *, speed: float = 0.25, controller: str = "virtual-structure", radio: str = "complete"
) -> str:
    """The scenario of :func:`random_team` as the text of a TOML file.

    Starts are drawn on a square lattice of 1.5 m, ends 4 to 9 m away, tangents at random; a path that no robot can
    follow at the speed is drawn again. Nothing keeps the paths apart: they cross.

    Args:
        robots: Their number, 2 to 2000.
        seed: Of the random paths.
        speed: The speed on the longest path [m/s].
        controller: The specification of the controller.
        radio: The name of the graph.

    Raises:
        TeamError: Numbers with which no team can be made.
    """
    if not 2 <= robots <= 2000:
        raise TeamError(f"a team has 2 to 2000 robots, got {robots}")
    if not 0.02 <= speed <= 0.5:
        raise TeamError(f"speed must be a number in m/s, >= 0.02 and <= 0.5, got {speed!r}")
    rng = np.random.default_rng(seed)
    side = int(np.ceil(np.sqrt(robots)))
    cells = rng.permutation(side * side)[:robots]
    drawn = [_random_path(rng, 1.5 * np.array(divmod(int(cell), side), dtype=float), speed) for cell in cells]
    duration = float(np.ceil(max(length for *_, length in drawn) / speed / 0.05) * 0.05)
    parts = [
        f'kind = "team"\ntitle = "A random team of {robots}"\n'
        f'source = "random paths, seed {seed}; everything is a choice"\n'
        f'duration = {1.5 * duration + 10:.2f}\ncontroller = "{controller}"\n\n'
        f'[sensing]\nposture = "pose"\nposition_noise = 0.003\nheading_noise = 0.003\n\n[radio]\ngraph = "{radio}"\n'
    ]
    for start, end, out, into, _ in drawn:
        heading = float(np.arctan2(out[1], out[0]))
        parts.append(
            f"\n[[robots]]\nstart = [{start[0]:.3f}, {start[1]:.3f}, {heading:.6f}]\n"
            f'path = {{ shape = "quintic", start = {_pair(start)}, end = {_pair(end)}, '
            f"start_tangent = {_pair(out)}, end_tangent = {_pair(into)} }}\n"
            f"timing = {{ duration = {duration:.2f}, ramp = 2.0 }}\n"
        )
    return "".join(parts)


def _pair(point: np.ndarray) -> str:
    return f"[{point[0]:.3f}, {point[1]:.3f}]"


def _random_path(
    rng: np.random.Generator, start: np.ndarray, speed: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, float]:
    """Draw the start, the end, the tangents at both [m] and the length [m] of a path with radii of 0.3 m or more."""
    for _ in range(100):
        bearing, reach = rng.uniform(-np.pi, np.pi), rng.uniform(4.0, 9.0)
        end = np.round(start + reach * np.array([np.cos(bearing), np.sin(bearing)]), 3)
        bends = bearing + rng.uniform(-1.0, 1.0, 2)
        out, into = (np.round(reach * np.array([np.cos(a), np.sin(a)]), 3) for a in bends)
        try:
            path = compile_path(
                Quintic(start=tuple(start), end=tuple(end), start_tangent=tuple(out), end_tangent=tuple(into))
            )
        except PathError:
            continue
        if np.abs(path.nodes.curvature).max() <= 1 / 0.3:
            return start, end, out, into, path.length
    raise TeamError("no path that a robot can drive was found in 100 draws")  # pragma: no cover
