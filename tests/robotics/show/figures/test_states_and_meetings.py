"""State diagrams whose words do not overlap, and meetings magnified where robots truly came nearest."""

from itertools import combinations

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.patches import Circle, FancyArrowPatch, FancyBboxPatch

from robotics.laws.catalogue import label, make_controller
from robotics.laws.modes import YIELD
from robotics.show.figures.meetings import MEETINGS_DRAWN, NEAR, plot_meetings
from robotics.show.figures.states import hub_of, plot_states
from robotics.simulation.run import Run
from robotics.simulation.spans import ReplayError
from tests.drawn import vertices
from tests.robotics.handmade import handmade

LAWS = (
    ["cooperation-literal", "cooperation"],
    ["crash-literal", "right-of-way"],
    ["obstacles-literal", "obstacles"],
    ["hierarchy-literal"],
)


@pytest.mark.parametrize("laws", LAWS)
def test_a_diagram_has_every_state_and_arrow_and_no_words_overlap(laws: list[str]) -> None:
    figure = plot_states(laws)
    diagrams = [d for name in laws for d in make_controller(name).diagrams]
    unique = [d for k, d in enumerate(diagrams) if not any(d is other for other in diagrams[:k])]
    patches = [patch for ax in figure.axes for patch in ax.patches]
    assert sum(isinstance(p, FancyBboxPatch) for p in patches) == sum(len(d.states) for d in unique)
    assert sum(isinstance(p, FancyArrowPatch) for p in patches) == sum(len(d.transitions) for d in unique)
    texts = [text for ax in figure.axes for text in ax.texts]
    words = [" ".join(text.get_text().split()) for text in texts]
    for diagram in unique:
        assert all(box.name in words and box.does in words for box in diagram.states.values())
        assert all(t.condition in words for t in diagram.transitions)
    assert all(any(label(name) in word for word in words) for name in laws)
    renderer = FigureCanvasAgg(figure).get_renderer()
    extents = [text.get_window_extent(renderer) for text in texts]
    for a, b in combinations(extents, 2):
        assert not a.overlaps(b)
    assert all(figure.bbox.x0 <= e.x0 and e.x1 <= figure.bbox.x1 for e in extents)
    boxes = [p.get_window_extent(renderer) for p in patches if isinstance(p, FancyBboxPatch)]
    for text in extents:  # words stand in a box or beside it
        assert all(not box.overlaps(text) or (box.containsx(text.x0) and box.containsx(text.x1)) for box in boxes)


def test_the_state_that_is_linked_with_all_others_is_the_hub() -> None:
    committed, group = make_controller("obstacles").diagrams
    assert hub_of(committed) == YIELD
    assert hub_of(group) is None
    with pytest.raises(ValueError, match="lyapunov has no states"):
        plot_states(["lyapunov"])


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
