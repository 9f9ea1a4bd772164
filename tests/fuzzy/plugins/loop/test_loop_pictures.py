"""What a set of pictures shows of a loop."""

import pickle
from dataclasses import replace
from importlib import metadata

import fuzzy
from fuzzy.figures.figureset import PICTURE_ENTRY_POINTS, files_of, pictures_of, readme
from fuzzy.plugins.designer.starts.control import rule_table
from fuzzy.plugins.loop.keptloop import kept_settings, step_arguments, transfer_of
from fuzzy.plugins.loop.pictures import step_pictures
from fuzzy.shown import shown
from tests.drawn import y_of


def test_the_step_response_stands_beside_a_pid_and_their_figures_are_a_table() -> None:
    fis = replace(rule_table("pi", 5), loop='{"example": "motor"}')
    drawn = [pickle.loads(pickle.dumps(picture)).draw() for picture in step_pictures(fis, {})]  # by a worker
    settings = kept_settings(fis.loop)
    done = fuzzy.step_response(fis, transfer_of(settings), **step_arguments(settings))
    lines = {line.get_label(): line for line in drawn[0].axes[0].lines}
    assert list(y_of(lines[fis.name])) == done.output.tolist()
    assert "PID" in lines
    said = [text.get_text() for text in drawn[1].axes[0].texts]
    assert said[:2] == [fis.name, "PID"]
    assert said[said.index("Overshoot [%]") + 1] == shown(done.figures.overshoot)


def test_a_set_has_them_and_says_why_where_it_has_none() -> None:
    assert {point.name for point in metadata.entry_points(group=PICTURE_ENTRY_POINTS)} >= {"step", "path", "data"}
    fis = rule_table("pi", 3)
    pictures = pictures_of(fis, (0, 0))
    assert {"step", "table", "matrix"} <= {picture.kind for picture in pictures}
    file = replace(fis, loop='{"example": "lag", "source": "plant.py"}')
    pictures = pictures_of(file, (0, 0))
    assert "step" not in {picture.kind for picture in files_of(pictures)}
    assert "Left out: the picture 'step': its plant is plant.py; `fuzzy step" in readme(file, pictures, (0, 0), "pdf")
    assert step_pictures(fuzzy.Sugeno([fuzzy.Variable("x", (0, 1), {"a": fuzzy.trimf(0, 0, 1)})],
                                      [fuzzy.Variable("y", (0, 1), {"b": 1.0})]), {}) == []  # fmt: skip
