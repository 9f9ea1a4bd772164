"""Tracks from tables: metres, degrees, smoothing, files beside the scenario, and what cannot be read."""

from pathlib import Path

import numpy as np
import pytest

from robotics.plugins.shapes.track import TrackFile
from robotics.simulation.loop import simulate
from robotics.simulation.scenario.description import ScenarioError
from robotics.simulation.scenario.reading import load_scenario
from robotics.world.paths.path import PathError, compile_path

ANGLES = np.linspace(0.0, 2 * np.pi, 181)
CIRCLE = np.stack([5 * np.cos(ANGLES), 5 * np.sin(ANGLES)], axis=1)  # m


def written(file: Path, header: str, rows: np.ndarray) -> str:
    file.write_text(header + "\n" + "".join(",".join(f"{v:.10f}" for v in row) + "\n" for row in rows))
    return str(file)


@pytest.mark.parametrize("header", ["x,y", "x_m,y_m", "X,Y", "x [m],y [m]"])
def test_a_circle_in_metres_is_one(tmp_path: Path, header: str) -> None:
    path = compile_path(TrackFile(file=written(tmp_path / "t.csv", header, CIRCLE)))
    assert path.length == pytest.approx(10 * np.pi, rel=1e-6)
    assert path.nodes.curvature == pytest.approx(
        np.full(path.table.shape[1], 0.2), rel=2e-3
    )  # closed: at its ends, too


def test_degrees_become_east_and_north(tmp_path: Path) -> None:
    """Against the lengths of a degree at 45° that are printed in tables: 111,132 m and 78,847 m."""
    rows = np.array([[-73.0, 45.0], [-72.999, 45.0], [-72.999, 45.001]])
    points = TrackFile(file=written(tmp_path / "t.csv", "lon,lat", rows), apart=1.0).points
    assert points[1] == pytest.approx((78.847, 0.0), abs=1e-3)
    assert points[2] == pytest.approx((78.847, 111.132), abs=1e-3)
    over = np.array([[179.9995, 0.0], [-179.9995, 0.0]])
    assert TrackFile(file=written(tmp_path / "o.csv", "lng,lat", over)).points[1][0] == pytest.approx(111.32, abs=1e-2)
    moved = TrackFile(file=str(tmp_path / "t.csv"), origin=(45.001, -73.0), apart=1.0).points
    assert moved[0] == pytest.approx((0.0, -111.132), abs=1e-3)


def test_noise_is_smoothed_by_what_is_asked(tmp_path: Path) -> None:
    noisy = CIRCLE + np.random.default_rng(0).normal(0.0, 0.05, CIRCLE.shape)
    noisy[-1] = noisy[0]
    file = written(tmp_path / "t.csv", "x,y", noisy)
    raw, smooth = (compile_path(TrackFile(file=file, smooth=s)) for s in (0.0, 0.07))
    assert np.abs(raw.nodes.curvature).max() > 5 * np.abs(smooth.nodes.curvature).max()
    off = np.hypot(smooth.nodes.x, smooth.nodes.y) - 5
    assert np.abs(off).max() < 0.06


def test_points_at_which_nobody_moved_are_left_out(tmp_path: Path) -> None:
    rows = np.array([[0.0, 0.0], [0.0, 0.0], [1.0, 0.0], [1.001, 0.0], [2.0, 0.0]])
    assert len(TrackFile(file=written(tmp_path / "t.csv", "x,y", rows)).points) == 3


def test_a_scenario_reads_the_table_beside_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    written(tmp_path / "lap.csv", "time,easting,northing", np.column_stack([ANGLES, CIRCLE]))
    text = """duration = 20.0
[[robots]]
start = [5.0, 0.0, 1.57]
path = { shape = "track", file = "lap.csv", x = "easting", y = "northing" }
timing = { speed = 0.4 }
"""
    (tmp_path / "lap.toml").write_text(text)
    monkeypatch.chdir("/")
    run = simulate(load_scenario(tmp_path / "lap.toml"), "fuzzy", [0])
    assert np.hypot(run["x"], run["y"])[0, 0, 100:] == pytest.approx(5.0, abs=0.02)
    for was, now, said in (
        ("lap.csv", "lop.csv", "cannot read lop.csv"),
        ("northing", "nothing", "unknown column|no column|'nothing'"),
        (', y = "northing"', "", "name both columns"),
        (', x = "easting", y = "northing"', "", "has the columns time, easting, northing"),
    ):
        (tmp_path / "lap.toml").write_text(text.replace(was, now))
        with pytest.raises(ScenarioError, match=rf"lap\.toml:4: .*({said})"):
            load_scenario(tmp_path / "lap.toml")


def test_what_is_no_track_is_said(tmp_path: Path) -> None:
    with pytest.raises(PathError, match="1 points of"):
        TrackFile(file=written(tmp_path / "t.csv", "x,y", CIRCLE), apart=100.0)
    with pytest.raises(PathError, match="latitudes lie within 90°"):
        TrackFile(file=written(tmp_path / "u.csv", "lat,lon", CIRCLE * 30))
    (tmp_path / "w.csv").write_text("x,y\n0,0\n1,a\n")
    with pytest.raises(PathError, match=r"w\.csv.*line 3"):
        TrackFile(file=str(tmp_path / "w.csv"))
