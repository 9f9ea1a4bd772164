"""State diagrams whose words do not overlap."""

from itertools import combinations

import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch

from robotics.laws.catalogue import label, make_controller
from robotics.laws.modes import YIELD
from robotics.plugins.thesis.states import hub_of, plot_states

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
