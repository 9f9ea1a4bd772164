import warnings
from dataclasses import replace

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.colors import same_color
from matplotlib.figure import Figure

from fuzzy.figures.drawing import PAGE_WIDTH
from fuzzy.inference import infer
from robotics.laws.tracking.fuzzy_tracking import load_rule_base
from robotics.measures.registry import headlines
from robotics.measures.tracking import cross_track_error, tracking_error, under_way
from robotics.plugins.thesis.figures import (
    plot_switching,
    plot_tracking_memberships,
    plot_tracking_velocities,
    plot_turn,
)
from robotics.show.figures.comparison import plot_comparison
from robotics.show.figures.controllers import plot_errors, plot_paths, plot_velocities
from robotics.show.figures.drawing import POINTS, cut_axis, looks, only, room_for, seeds_as_text, thinned, unjumped
from robotics.show.figures.run import plot_run
from robotics.simulation.channels import CHANNELS
from robotics.simulation.run import Run
from robotics.simulation.scenario.reading import parse_scenario
from robotics.studies.comparison import Comparison, compare, summarise
from robotics.world.environment.world import Disc, World, compile_world
from tests.drawn import faults_of, vertices, x_of, y_of
from tests.robotics.world.vehicle.etsro import ETSRO

TWO_ROBOTS = """
duration = 6.0
divergence = 1.5
[sensing]
posture = "pose"
position_noise = 0.003
[[robots]]
start = [-0.5, 0.0, 0.0]
path = { shape = "sine", amplitude = 1.0, x_end = 8.0 }
timing = { x_rate = 0.3 }
[[robots]]
start = [0.0, -2.0, 0.3]
path = { shape = "line", start = [0.0, -2.0], end = [5.0, -2.0] }
timing = { speed = 0.3 }
"""
LAWS = ("lyapunov", "lyapunov:signs=literal", "esm")  # the second one diverges
LOST = LAWS[1]


@pytest.fixture(scope="module")
def comparison() -> Comparison:
    return compare([parse_scenario(TWO_ROBOTS, "two")], LAWS, (3, 4, 9))


@pytest.fixture(scope="module")
def runs(comparison: Comparison) -> list[Run]:
    return [comparison.runs["two", name] for name in LAWS]


def lines(figure: Figure) -> list[mpl.lines.Line2D]:
    return [line for ax in figure.axes for line in ax.lines]


def drawn(ax: mpl.axes.Axes, x: np.ndarray, y: np.ndarray) -> list[mpl.lines.Line2D]:
    """The lines with exactly this data."""
    return [
        line
        for line in ax.lines
        if np.array_equal(x_of(line), x, equal_nan=True) and np.array_equal(y_of(line), y, equal_nan=True)
    ]


def crosses(ax: mpl.axes.Axes) -> list[tuple[float, float]]:
    return [(x_of(line)[0], y_of(line)[0]) for line in ax.lines if line.get_marker() == "X"]


def labels(figure: Figure) -> set[str]:
    return {text.get_text() for text in figure.findobj(mpl.text.Text)}


def test_paths_are_those_of_the_runs(runs: list[Run]) -> None:
    figure = plot_paths(runs, seed=4)
    overview, *tracks = figure.axes
    for run in runs:
        for robot in range(2):
            (line,) = drawn(overview, run["x"][1, robot], run["y"][1, robot])
            assert same_color(line.get_color(), looks(LAWS)[run.controller].color)
    for nodes in runs[0].paths:
        found = [line for line in overview.lines if x_of(line)[-1] == nodes[0, -1] and y_of(line)[-1] == nodes[1, -1]]
        assert [line.get_linestyle() for line in found] == ["--"]
        assert set(x_of(found[0])) <= set(nodes[0])
    assert overview.get_xlabel() == "x [m]"
    assert overview.get_ylabel() == "y [m]"
    assert overview.get_aspect() == 1
    starts = {(x_of(line)[0], y_of(line)[0]) for line in overview.lines if line.get_marker() == "o"}
    assert starts == {(-0.5, 0.0), (0.0, -2.0)}
    assert {"Lyapunov", "Lyapunov (signs=literal)", "Exponential SM", "reference", "start"} <= labels(figure)
    assert len(tracks) == len(LAWS)


def test_cross_track_errors_are_the_median_and_the_band_of_all_seeds(runs: list[Run]) -> None:
    _, *tracks = plot_paths(runs, seed=4).axes
    assert tracks[0].get_ylabel() in ("off path [m]", "off path [mm]")
    scale = 1000 if "mm" in tracks[0].get_ylabel() else 1
    for ax, run in zip(tracks, runs, strict=True):
        rows = scale * cross_track_error(run).reshape(6, -1)
        with np.errstate(all="ignore"), warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            low, middle, high = np.nanpercentile(rows, (5, 50, 95), axis=0)
        (line,) = [line for line in ax.lines if len(x_of(line)) > 2]
        np.testing.assert_array_equal(y_of(line), middle[: len(x_of(line))])
        (band,) = ax.collections
        corners = vertices(band.get_paths()[0])
        assert corners[:, 1].max() == pytest.approx(np.nanmax(high[: len(x_of(line))]))
        assert corners[:, 1].min() == pytest.approx(np.nanmin(low[: len(x_of(line))]))
    assert len({ax.get_ylim() for ax in tracks}) == 1  # can be compared


def test_what_lies_beyond_an_axis_is_marked() -> None:
    time, figure = np.linspace(0.0, 10.0, 101), Figure()
    ax = figure.add_subplot()
    cut_axis(ax, time, np.stack([np.where(time < 1, -250.0, 0.1 * time), 0.0 * time]), -1.0, 2.0)
    assert ax.get_ylim() == (-1.0, 2.0)
    (said,) = ax.texts
    assert said.get_text() == " ▼ to −250"
    assert said.get_position()[0] == 0.0
    assert room_for(np.array([[1.0, np.nan], [3.0, 2.0]])) == pytest.approx((-0.24, 3.24))


def test_a_heading_that_jumps_is_interrupted() -> None:
    found = unjumped(np.array([3.0, 3.1, -3.1, -3.0, 0.0]))
    np.testing.assert_array_equal(found, [3.0, 3.1, np.nan, -3.0, 0.0])


def test_commands_that_no_robot_can_follow_do_not_set_the_axis(runs: list[Run]) -> None:
    samples = runs[0].samples.copy()
    place = list(CHANNELS).index("command_1")
    samples[5:9, place, 0, 0] = -250.0
    figure = plot_run(runs[0].with_recorded(samples=samples))
    (ax,) = [ax for ax in figure.axes if ax.get_ylabel() == "commanded v [m/s]"]
    assert ax.get_ylim()[0] > -5 * ETSRO.v_max
    assert any("▼ to −250" in text.get_text() for text in ax.texts)


def test_a_cross_marks_where_a_robot_was_stopped(runs: list[Run]) -> None:
    lost = runs[1]
    assert lost.diverged.all()
    assert not runs[0].diverged.any()
    ends = [(lost["x"][0, r, k], lost["y"][0, r, k]) for r, k in enumerate(lost.stopped[0])]
    assert crosses(plot_paths(runs).axes[0]) == ends
    k = lost.stopped[0, 1]
    v_axes = plot_velocities(runs, robot=1).axes[3]
    assert crosses(v_axes) == [(lost.time[k], lost["v"][0, 1, k])]
    assert len(crosses(plot_run(lost).axes[0])) == lost.diverged.size
    assert crosses(plot_run(runs[0]).axes[0]) == []


def test_errors_are_those_of_the_metrics(runs: list[Run]) -> None:
    figure = plot_errors(runs, seed=9, robot=1)
    left = [ax for ax in figure.axes if ax.get_subplotspec().is_first_col()]
    names = [("x error", "m"), ("y error", "m"), ("heading error", "rad")]
    for ax, (name, unit), field in zip(left, names, ("x", "y", "heading"), strict=True):
        assert ax.get_ylabel() in (f"{name} [{unit}]", f"{name} [m{unit}]")
        scale = 1000 if ax.get_ylabel() == f"{name} [m{unit}]" else 1
        for run in runs:
            error = getattr(tracking_error(run), field)[2, 1]
            assert len(drawn(ax, run.time, scale * error)) == 1
    assert "time [s]" in labels(figure)


def test_second_half_is_magnified_where_it_is_dwarfed(runs: list[Run]) -> None:
    figure = plot_errors(runs[:1], robot=0)
    assert len(figure.axes) == 6
    right = figure.axes[1]
    half = runs[0].time >= 3.0
    assert right.get_ylabel() == "x error [mm]"
    assert drawn(right, runs[0].time[half], 1000 * tracking_error(runs[0]).x[0, 0][half])


def test_velocities_have_one_row_a_controller(comparison: Comparison, runs: list[Run]) -> None:
    robot = comparison.scenarios[0].robots[0].robot
    figure = plot_velocities(runs, machine=robot)
    assert len(figure.axes) == 3 * len(LAWS)
    for row, run in enumerate(runs):
        for column, channel in enumerate(("v", "w", "w_demand")):
            ax = figure.axes[3 * row + column]
            assert drawn(ax, run.time, run[channel][0, 0])
            assert drawn(ax, run.time, run.target(channel[0])[0])
    assert {"speed v [m/s]", "turn rate ω [rad/s]", "demanded ω [rad/s]", "time [s]"} <= labels(figure)
    late = runs[0]["w_demand"][0, 0][under_way(runs[0])[0]]
    change = np.abs(np.diff(late)).sum() / (0.05 * (len(late) - 1))
    assert figure.axes[2].get_title(loc="right") == f"changes {change:.2g} rad/s²"
    # The wheels end at 0.825 m/s, before the 1.12 m/s that the robot's field says; one run comes near it.
    limits = [y_of(line)[0] for line in figure.axes[0].lines if line.get_label() == "limit"]
    assert limits == [pytest.approx(robot.wheel_speed_limit)]
    # The diverging law turns right at nearly the 5.74 rad/s that the command may have; it does not set the axis.
    assert figure.axes[1].get_ylim()[0] > -3.0
    least = np.nanmin(runs[1]["w"][0, 0])
    assert f" ▼ to −{-least:.2g}" in {text.get_text() for text in figure.axes[4].texts}
    assert not [line for line in lines(plot_velocities(runs)) if line.get_label() == "limit"]


def test_a_controller_looks_the_same_in_every_figure(comparison: Comparison, runs: list[Run]) -> None:
    assert looks(["esm"])["esm"] == looks(["fuzzy", "csm", "esm", "csm:k=0.3"])["esm"]
    many = looks(["fuzzy", "lyapunov", "csm", "assm", "qssm", "esm", *(f"csm:k={k}" for k in range(1, 16))])
    assert len({(look.color, look.line) for look in many.values()}) == len(many)
    own = looks(["csm:k=1", "fuzzy"])
    assert own["fuzzy"] == many["fuzzy"] != own["csm:k=1"]
    color = looks(LAWS)["esm"].color
    for figure in (plot_paths(runs), plot_errors(runs), plot_velocities(runs), plot_comparison(comparison)):
        assert any(same_color(line.get_color(), color) for line in lines(figure))


def test_run_page_shows_every_seed_and_channel(runs: list[Run]) -> None:
    run = runs[2]  # torques
    figure = plot_run(run)
    text = labels(figure)
    assert {"x error [m]", "v [m/s]", "ω [rad/s]", "right wheel [N m]", "left wheel [N m]", "time [s]"} <= text
    assert "commanded v [m/s]" in labels(plot_run(runs[0]))
    panels = {ax.get_ylabel(): ax for ax in figure.axes}
    for seed in range(3):
        for robot in range(2):
            assert drawn(panels["right wheel [N m]"], run.time, run["command_1"][seed, robot])
            assert drawn(panels["y [m]"], run["x"][seed, robot], run["y"][seed, robot])
    assert "Exponential SM on two, seed 3; faint: seeds 4, 9" in text
    assert any("stopped (×): 6 of 6" in t for t in labels(plot_run(runs[1])))


def test_comparison_shows_every_seed_mean_and_interval(comparison: Comparison) -> None:
    figure = plot_comparison(comparison)
    shown = [name for name in headlines("tracking", others=True) if comparison.table[name].any()]
    assert "contacts" not in shown  # 0 in all runs
    assert len(figure.axes) == len(shown)
    summary = summarise(comparison.table).set_index(["metric", "controller"])
    for ax, metric in zip(figure.axes, shown, strict=True):
        assert ax.get_xlabel().replace("\n", " ").count("[") == 1
        assert ("better →" if metric == "min_clearance_m" else "← better") in ax.get_xlabel()
        if ax.get_xscale() == "linear" and comparison.table[metric].min() >= 0:
            assert ax.get_xlim()[0] == 0.0
        for row, name in enumerate(LAWS):
            group = comparison.table[comparison.table["controller"] == name].groupby("seed")[metric].mean()
            mean, low, high = summary.loc[(metric, name), ["mean", "low", "high"]].to_numpy(dtype=float)
            if np.isinf(mean):
                assert "never: 3 of 3 ×" in {t.get_text() for t in ax.texts}
                continue
            assert any(np.array_equal(x_of(line), group.to_numpy()) for line in ax.lines)
            assert any(list(x_of(line)) == [mean] and list(y_of(line)) == [row] for line in ax.lines)
            bars = [line for line in ax.lines if list(y_of(line)) == [row, row]]
            assert any(np.allclose(x_of(line), [max(low, x_of(line)[0]), high]) for line in bars)
    norm = figure.axes[shown.index("mean_error_norm")]
    assert norm.get_xscale() == "log"  # the diverging law is more than ten times worse
    assert "logarithmic" in norm.get_xlabel()


def test_equal_seeds_are_one_dot_without_an_interval(comparison: Comparison) -> None:
    table = comparison.table.copy()
    for metric in headlines("tracking", others=True):
        table[metric] = table.groupby(["controller", "robot"])[metric].transform("first")
    figure = plot_comparison(replace(comparison, table=table))
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["every seed gives this"]
    assert all(len(x_of(line)) <= 1 for ax in figure.axes for line in ax.lines)


def test_switching_law_is_the_controllers() -> None:
    figure = plot_switching()
    alike = [(0.2, 0.1), (0.2, 0.2), (0.2, 0.5), (0.2, 1.0)]
    others = [(0.4, 0.1), (0.2, 0.1), (0.1, 0.1), (1.0, 1.0)]
    for ax, curves in zip(figure.axes, (alike, others), strict=True):
        assert ax.get_xlabel() == "S [m/s]"
        assert "[m/s²]" in ax.get_ylabel()
        for line, (k, mu0) in zip(ax.lines, curves, strict=True):  # the highest end first
            s = x_of(line)
            expected = k / (mu0 + (1 - mu0) * np.exp(-3.0 * np.abs(s))) * np.sign(s)
            np.testing.assert_allclose(y_of(line), expected, rtol=1e-12)
    assert any("conventional" in text for text in labels(figure))


def test_rule_base_figures_show_the_rule_bases() -> None:
    tracking = load_rule_base("tracking")
    memberships = plot_tracking_memberships()
    assert [ax.get_xlabel() for ax in memberships.axes] == ["distance [m]", "α [rad]"]
    assert {"Very close", "Very far", "Straight"} <= labels(memberships)
    v, w = plot_tracking_velocities().axes[:2]
    distance, speed = x_of(v.lines[0]), y_of(v.lines[0])
    x = np.column_stack([distance, 0 * distance, 0 * distance + 0.1, 0 * distance])
    np.testing.assert_allclose(speed, infer(tracking, x).output[:, 0], atol=1e-12)
    assert np.interp(0.2, distance, speed) == pytest.approx(0.5, abs=0.01)  # distance / 0.4 s
    assert w.get_ylabel() == "ω [rad/s]"
    assert y_of(w.lines[0]).max() == pytest.approx(5.74)
    lateral, turn = plot_turn("lateral").axes
    assert lateral.get_xlabel() == "y_err [m]"
    assert turn.get_ylabel() == "λ [rad]"
    assert y_of(turn.lines[0])[0] == pytest.approx(-0.6)


def test_turns_of_avoidance_are_those_of_the_rule_bases() -> None:
    """The straight lines that the comments of eta.fis and theta.fis give, and the sets that make them."""
    for figure, argument, symbol, near, far, most, sets in (
        (plot_turn("eta"), "d_ij", "η", 0.3, 0.6, 1.2, ("Overlapping", "Touching", "Apart")),
        (plot_turn("theta"), "ro", "Θ", 0.15, 0.8, 1.6, ("Near", "Medium", "Far")),
    ):
        memberships, turn = figure.axes
        assert [ax.get_xlabel() for ax in figure.axes] == [f"{argument} [m]"] * 2
        assert turn.get_ylabel() == f"{symbol} [rad]"
        distance = x_of(turn.lines[0])
        np.testing.assert_allclose(y_of(turn.lines[0]), most * (far - distance) / (far - near), atol=1e-9)
        assert len(memberships.lines) >= 3
        assert set(sets) <= labels(figure)


def test_long_lines_keep_their_extremes() -> None:
    time = np.linspace(0, 1, 100_000)
    values = np.sin(40 * time)
    values[12_345], values[77_777] = 9.0, -9.0
    few, shown = thinned(time, values)
    assert len(few) <= POINTS
    assert (shown.max(), shown.min()) == (9.0, -9.0)
    assert (few[0], few[-1]) == (0.0, 1.0)
    assert np.all(np.diff(few) > 0)
    assert thinned(time[:POINTS], values[:POINTS])[0] is not None
    values[50_000:] = np.nan
    assert np.isnan(thinned(time, values)[1]).any()


def test_seeds_in_words() -> None:
    assert seeds_as_text(range(20)) == "0–19"
    assert seeds_as_text((3, 4, 7, 8, 9, 42)) == "3, 4, 7–9, 42"


def test_wrong_requests_are_refused(comparison: Comparison, runs: list[Run]) -> None:
    with pytest.raises(ValueError, match="seed 7 is not among those of the run: 3, 4, 9"):
        plot_paths(runs, seed=7)
    with pytest.raises(ValueError, match="at least one run"):
        plot_errors([])
    with pytest.raises(ValueError, match="'elsewhere' was not compared"):
        plot_comparison(comparison, "elsewhere")
    assert only(runs[0], None).seeds == (3,)


def test_obstacles_and_robots_are_drawn_in_true_size(runs: list[Run]) -> None:
    world = compile_world(World(obstacles=(Disc(position=(1.0, 0.7), radius=0.2),)))
    about = replace(runs[0].about, robots=(ETSRO, replace(ETSRO, length=0.5, width=0.3)))
    top = plot_run(replace(only(runs[0], None), about=about, obstacles=world.rest)).axes[0]
    disc, body = (
        [vertices(p) for c in top.collections if c.get_zorder() == zorder for p in c.get_paths()] for zorder in (1.5, 3)
    )
    np.testing.assert_allclose(disc[0].mean(axis=0), (1.0, 0.7), atol=0.02)
    assert len(body) == 8 * runs[0].samples.shape[3]
    for corners, sides in zip(body, [[0.23, 0.20, 0.23]] * 8 + [[0.5, 0.3, 0.5]] * 8, strict=True):
        np.testing.assert_allclose(np.linalg.norm(np.diff(corners[:4], axis=0), axis=1), sides)


@pytest.mark.long
def test_figures_of_the_report_have_no_faults(comparison: Comparison, runs: list[Run]) -> None:
    """Units, nothing beyond the canvas, lines told apart by more than colour, legends over nothing."""
    machine = comparison.scenarios[0].robots[0].robot
    for figure in (
        plot_paths(runs, width=PAGE_WIDTH),
        plot_errors(runs, width=PAGE_WIDTH),
        plot_velocities(runs, machine=machine, width=PAGE_WIDTH),
        plot_comparison(comparison, width=PAGE_WIDTH),
        plot_run(runs[0], width=PAGE_WIDTH),
        plot_switching(width=PAGE_WIDTH),
    ):
        assert not faults_of(figure)


def test_every_fault_of_a_figure_is_found() -> None:
    figure = Figure(figsize=(3, 2))
    ax = figure.add_axes((0.0, 0.0, 0.9, 0.9))
    time = np.linspace(0.0, 1.0, 50)
    ax.plot(time, time, color="tab:blue", label="one")
    ax.plot(time, 1 - time, color="tab:red", label="two")
    ax.set_xlabel("time")
    ax.legend(loc="center")
    figure.legend(loc="upper right")
    found = faults_of(figure)
    assert [fault.partition(":")[0] for fault in found[:2]] == [
        "something is " + found[0].split()[2] + " in beyond the left",
        "something is " + found[1].split()[2] + " in beyond the bottom",
    ]
    assert found[2:] == [
        "axes 0: 'time' has no unit",
        "axes 0: #1f77b4 and #d62728 look alike but for the colour",
        "axes 0: the legend lies over a line",
        "the legend of the figure lies over a panel",
    ]
