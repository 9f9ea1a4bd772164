"""The page of a team's run: every line is the run's, faults are shaded and named, and many robots stay readable."""

from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.collections import FillBetweenPolyCollection, PolyCollection
from matplotlib.colors import same_color
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.text import Text

from fuzzy.figures.drawing import COLORS
from robotics.commands.application import main
from robotics.laws.catalogue import make_controller
from robotics.measures.tracking import tracking_error
from robotics.show.figures.drawing import POINTS
from robotics.show.figures.run import plot_run
from robotics.show.figures.team import plot_team
from robotics.simulation.loop import simulate
from robotics.simulation.run import Run
from robotics.simulation.scenario.reading import parse_scenario
from robotics.simulation.spans import ReplayError
from robotics.world.environment.world import Disc, Geometry, World, box, compile_world
from robotics.world.environment.world import Polygon as Block
from robotics.world.paths.path import Line
from robotics.world.paths.trajectory import Timing
from tests.drawn import vertices, x_of, y_of

FAULTS = """
[[faults]]
robot = 2
kind = "failure"
start = 3.0
duration = 2.0
[[faults]]
robot = 3
kind = "delay"
start = 4.5
duration = 1.5
"""
SENSING = """
[sensing]
posture = "pose"
position_noise = 0.002
"""


def described(robots: int, faults: str = FAULTS) -> str:
    members = "".join(
        f"[[robots]]\nstart = [0.0, {i}.0, 0.0]\ntiming = {{ duration = 10.0 }}\n"
        f'path = {{ shape = "quintic", start = [0.0, {i}.0], end = [{1.5 + 0.1 * (i % 5)}, {i}.3] }}\n'
        for i in range(robots)
    )
    return f'kind = "team"\nplant = "kinematic"\nduration = 12.0\n{SENSING}{faults}{members}'


def team(robots: int, seeds: tuple[int, ...] = (3, 5, 8)) -> Run:
    law = "virtual-structure-virtual"
    return simulate(parse_scenario(described(robots), "made up"), make_controller(law), seeds, name=law)


@pytest.fixture(scope="module")
def run() -> Run:
    return team(3)


@pytest.fixture(scope="module")
def page(run: Run) -> Figure:
    return plot_team(run)


def panel(figure: Figure, name: str) -> Axes:
    (ax,) = [ax for ax in figure.axes if ax.get_ylabel() == name]
    return ax


def drawn(ax: Axes, x: np.ndarray, y: np.ndarray) -> list:
    """The lines with exactly this data."""
    return [
        line
        for line in ax.lines
        if np.array_equal(x_of(line), x, equal_nan=True) and np.array_equal(y_of(line), y, equal_nan=True)
    ]


def words(figure: Figure) -> set[str]:
    return {text.get_text() for text in figure.findobj(Text)}


def shades(ax: Axes) -> list[tuple[float, float, str]]:
    found = [p for p in ax.patches if isinstance(p, Rectangle) and p.get_hatch()]
    return [(p.get_x(), p.get_x() + p.get_width(), p.get_hatch()) for p in found]


def test_every_panel_shows_every_seed_and_robot(run: Run, page: Figure) -> None:
    error = tracking_error(run)
    channels = {
        "x error [m]": error.x,
        "y error [m]": error.y,
        "heading error [rad]": error.heading,
        "v [m/s]": run["v"],
        "ω [rad/s]": run["w"],
        "progress s": run["progress"],
    }
    for name, values in channels.items():
        ax = panel(page, name)
        for robot in range(3):
            for seed in range(3):
                lines = drawn(ax, run.time, values[seed, robot])  # several, where noise changes nothing
                assert (1.0 if seed == 0 else 0.25) in {line.get_alpha() for line in lines}
                assert any(same_color(line.get_color(), COLORS[robot]) for line in lines)
    top = panel(page, "y [m]")
    for robot in range(3):
        assert drawn(top, run["x"][1, robot], run["y"][1, robot])
    assert {"path", "robot 1", "robot 3", "start", "end", "time [s]", "x [m]"} <= words(page)
    assert "Virtual structure, virtual on made up, seed 3; faint: seeds 5, 8" in words(page)


def test_errors_are_against_the_laws_own_target(run: Run, page: Figure) -> None:
    # The frame of the robot: what lies ahead of it, and to its left.
    dx = run["x_target"][0, 1] - run["x"][0, 1]
    dy = run["y_target"][0, 1] - run["y"][0, 1]
    ahead = np.cos(run["heading"][0, 1]) * dx + np.sin(run["heading"][0, 1]) * dy
    (line,) = [
        line
        for line in panel(page, "x error [m]").lines
        if same_color(line.get_color(), COLORS[1]) and line.get_alpha() == 1.0
    ]
    np.testing.assert_allclose(y_of(line), ahead, atol=1e-12)
    assert ahead.max() > 0.1  # the target went on while robot 2 stood still


def test_differences_are_those_of_all_pairs(run: Run, page: Figure) -> None:
    ax = panel(page, "$s_i − s_j$")
    s = run["progress"][0]
    for i, j in combinations(range(3), 2):
        (line,) = [line for line in drawn(ax, run.time, s[i] - s[j]) if line.get_alpha() == 1.0]
        assert line.get_label() == f"$s_{{{i + 1}}} − s_{{{j + 1}}}$"
    named = [line for line in ax.lines if str(line.get_label())[0] == "$"]
    assert len({(line.get_color(), str(line.get_linestyle())) for line in named}) == 3


def test_faults_are_shaded_in_every_panel_and_named(page: Figure) -> None:
    panels = [ax for ax in page.axes if ax.get_ylabel() != "y [m]"]
    assert len(panels) == 7
    for ax in panels:
        (first, second) = shades(ax)
        assert first[:2] == pytest.approx((3.0, 5.0))
        assert second[:2] == pytest.approx((4.5, 6.0))
        assert first[2] != second[2]
        assert ax.get_xlim() == (0.0, 12.0)
    named = [text for text in panel(page, "$s_i − s_j$").texts if text.get_text()]
    assert [text.get_text() for text in named] == ["2: failure", "3: delay"]
    page.draw_without_rendering()
    boxes = [text.get_window_extent() for text in named]
    assert not boxes[0].overlaps(boxes[1])
    assert {"2: failure", "3: delay"} <= {text.get_text() for text in panel(page, "y [m]").texts}


def test_another_seed_and_one_that_is_not_there(run: Run) -> None:
    figure = plot_team(run, 8)
    (line,) = drawn(panel(figure, "v [m/s]"), run.time, run["v"][2, 1])
    assert line.get_alpha() == 1.0
    assert "Virtual structure, virtual on made up, seed 8; faint: seeds 3, 5" in words(figure)
    with pytest.raises(ReplayError, match="seed 4 is not among those of the run: 3, 5, 8"):
        plot_team(run, 4)


def test_many_robots_are_thin_lines_and_a_band() -> None:
    run = team(12, (3,))
    figure = plot_team(run)
    for name, values in (("v [m/s]", run["v"][0]), ("progress s", run["progress"][0])):
        ax = panel(figure, name)
        assert all(drawn(ax, run.time, row)[0].get_linewidth() < 0.5 for row in values)
        (middle,) = [line for line in ax.lines if line.get_label() == "median"]
        np.testing.assert_allclose(y_of(middle), np.median(values, axis=0))
        (band,) = [c for c in ax.collections if isinstance(c, FillBetweenPolyCollection)]
        corners = vertices(band.get_paths()[0])
        at = corners[np.isclose(corners[:, 0], run.time[90])][:, 1]
        np.testing.assert_allclose([at.min(), at.max()], np.percentile(values[:, 90], (5, 95)))
    bottom = panel(figure, "$s_i$ − median")
    s = run["progress"][0]
    assert drawn(bottom, run.time, s[1] - np.median(s, axis=0))
    assert {"5–95 % of the robots", "median", "2: failure"} <= words(figure)
    assert "Virtual structure, virtual on made up, seed 3" in words(figure)


def test_a_stopped_robot_is_marked_and_its_lines_end(run: Run) -> None:
    samples, moved, stopped = run.samples.copy(), run.team.copy(), run.stopped.copy()
    samples[100:, :, 0, 2], moved[100:, :, 0, 2], stopped[0, 2] = np.nan, np.nan, 100
    figure = plot_team(replace(run, stopped=stopped).with_recorded(samples=samples, team=moved))
    for ax in figure.axes[:-1]:
        assert sum(line.get_marker() == "X" for line in ax.lines) == 1
    (cross,) = [line for line in figure.axes[0].lines if line.get_marker() == "X"]
    assert x_of(cross)[0] == run["x"][0, 2, 99]
    assert any("stopped (×): 1 of 9" in text for text in words(figure))


def test_a_law_without_progress_shows_the_distance_to_the_target(run: Run) -> None:
    nothing = run.team.copy()
    nothing[:, 0] = np.nan
    other = run.with_recorded(team=nothing)
    figure = plot_team(other)
    error = tracking_error(other)
    assert drawn(panel(figure, "to the target [m]"), run.time, np.hypot(error.x, error.y)[0, 2])
    assert len(figure.axes) == 7
    assert "3: delay" in words(figure)


def test_plot_of_a_run_chooses_the_page(run: Run, page: Figure) -> None:
    assert [ax.get_ylabel() for ax in plot_run(run).axes] == [ax.get_ylabel() for ax in page.axes]
    alone = run.with_recorded(team=None)
    assert "cross-track error [m]" in {ax.get_ylabel() for ax in plot_run(alone).axes}


def test_command_draws_a_team(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    picture, file = tmp_path / "team.png", tmp_path / "short.toml"
    file.write_text(described(3).replace("duration = 12.0", "duration = 2.0"), encoding="utf-8")
    assert main(["run", str(file), "-c", "cooperation", "--plot", str(picture), "-q"]) == 0
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert capsys.readouterr().err == ""


def test_long_runs_are_thinned(run: Run) -> None:
    many = 20
    long = replace(
        run, time=np.arange(len(run.time) * many) * 0.05, reference=np.repeat(run.reference, many, axis=1)
    ).with_recorded(samples=np.repeat(run.samples, many, axis=0), team=np.repeat(run.team, many, axis=0))
    assert max(len(x_of(line)) for ax in plot_team(long).axes for line in ax.lines) <= 2 * POINTS


def test_obstacles_and_robots_are_drawn_in_true_size(run: Run, page: Figure) -> None:
    line = Line(start=(0.5, 3.0), end=(2.5, 3.0))
    block = Block(corners=box(0.4, 0.2), path=line, timing=Timing(speed=0.1), orientation="fixed")
    world = compile_world(World(obstacles=(Disc(position=(1.0, 0.7), radius=0.2), block)))
    moving = Geometry(*(np.concatenate(parts) for parts in zip(*(world.at(t) for t in run.time), strict=True)))

    def shapes(obstacles: Geometry) -> tuple[list[np.ndarray], list[np.ndarray]]:
        """What is drawn of obstacles, and of robots."""
        found = panel(plot_team(replace(run, obstacles=obstacles)), "y [m]").collections
        polygons = [c for c in found if isinstance(c, PolyCollection)]
        solid = [vertices(p) for c in polygons if c.get_zorder() == 1.5 for p in c.get_paths()]
        return solid, [vertices(p)[:4] for c in polygons if c.get_zorder() == 3 for p in c.get_paths()]

    solid, bodies = shapes(moving)
    assert len(solid) == 2 * 8  # at eight times
    places = [points[:4].mean(axis=0) for points in solid[1::2]]
    np.testing.assert_allclose(np.array(places)[:, 1], 3.0)
    assert places[0][0] == pytest.approx(0.5)
    assert np.diff(np.array(places)[:, 0]).min() > 0.05
    assert len(bodies) == 3 * 8
    for body in bodies:
        sides = np.linalg.norm(np.diff(body, axis=0), axis=1)
        np.testing.assert_allclose(sides, [0.23, 0.20, 0.23])
    starts = [body.mean(axis=0) for body in bodies[::8]]
    np.testing.assert_allclose(starts, np.stack([run["x"][0, :, 0], run["y"][0, :, 0]], axis=-1), atol=1e-9)
    rest, _ = shapes(Geometry(*(part[:1] for part in moving)))
    assert len(rest) == 2
    np.testing.assert_allclose(np.hypot(*(rest[0] - (1.0, 0.7)).T), 0.2)
    assert not any(isinstance(c, PolyCollection) for c in panel(page, "y [m]").collections)
