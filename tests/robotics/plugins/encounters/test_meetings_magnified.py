"""Meetings magnified where robots truly came nearest."""

import numpy as np
import pytest
from matplotlib.patches import Circle

from robotics.plugins.encounters.meetings import MEETINGS_DRAWN, NEAR, plot_meetings
from robotics.simulation.run import Run
from robotics.simulation.spans import ReplayError
from tests.drawn import vertices
from tests.robotics.handmade import handmade


def meeting(*tracks: np.ndarray) -> Run:
    """A run of robots on these tracks (samples, 2), a sample every 0.1 s, all heading along x."""
    samples = np.zeros((len(tracks[0]), 5, 1, len(tracks)))
    for i, track in enumerate(tracks):
        samples[:, :2, 0, i] = track
    paths = [np.asarray(track).T for track in tracks]
    reference = np.zeros((len(tracks[0]), 6, len(tracks)))
    return handmade((7,), 0.1 * np.arange(len(samples)), samples, reference, paths, np.full((1, len(tracks)), -1))


def test_meetings_are_those_of_geometry() -> None:
    t = np.linspace(0, 10, 101)
    east = np.stack([t - 5, 0 * t], axis=1)
    north = np.stack([0 * t + 0.4, t - 5], axis=1)  # 0.4 m / √2 from the other at 5.2 s
    far = np.stack([t - 5, 0 * t + 3.0], axis=1)
    figure = plot_meetings(meeting(east, north, far))
    (ax,) = figure.axes
    assert ax.get_title() == "robots 1 and 2: 0.28 m at 5.2 s"
    (circle,) = [p for p in ax.patches if isinstance(p, Circle)]
    assert 2 * circle.radius == pytest.approx(0.4 / np.sqrt(2))
    filled = [c for c in ax.collections if len(c.get_paths()) == 1 and np.asarray(c.get_facecolor()).size]
    middles = sorted(tuple(vertices(c.get_paths()[0])[:4].mean(axis=0).round(2)) for c in filled)
    assert len(middles) == 2
    assert np.linalg.norm(np.subtract(*middles)) == pytest.approx(2 * circle.radius, abs=0.01)
    low, high = ax.get_xlim()
    assert high - low < 1.5  # magnified
    words = [text.get_text() for text in figure.legends[0].get_texts()]
    assert words == ["robot 1", "robot 2"]


def test_robots_that_stay_apart_have_their_nearest_pair_and_crowds_the_nearest_three() -> None:
    t = np.linspace(0, 10, 101)
    lanes = [np.stack([t, 0 * t + y], axis=1) for y in (0.0, 1.5, 4.0)]
    (ax,) = plot_meetings(meeting(*lanes)).axes
    assert ax.get_title().startswith("robots 1 and 2: 1.50 m")
    crowd = [np.stack([t, 0 * t + 0.4 * k], axis=1) for k in range(6)]
    assert len(plot_meetings(meeting(*crowd)).axes) == MEETINGS_DRAWN
    assert NEAR > 0.8
    with pytest.raises(ValueError, match="one robot"):
        plot_meetings(meeting(lanes[0]))
    with pytest.raises(ReplayError, match="seed 5"):
        plot_meetings(meeting(*lanes), seed=5)
