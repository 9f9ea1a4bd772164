"""Plants in files and texts."""

from typing import Any

import numpy as np
import pytest

from fuzzy import Scale, step_response
from fuzzy.plugins.designer.starts.control import rule_table
from fuzzy.plugins.loop.plant import PlantError
from fuzzy.plugins.loop.plantfile import PLANT_EXAMPLES, TEMPLATE, plant_of_text, read_plant


def test_a_text_and_a_toml_file_are_a_transfer_function(tmp_path):
    (tmp_path / "p.toml").write_text("numerator = [1]\ndenominator = [1, 0.4, 1]\ndead_time = 0.2\n", encoding="utf-8")
    plant = plant_of_text("1; 1, 0.4 1 ; 0.2")
    assert plant == read_plant(tmp_path / "p.toml") == plant_of_text(str(plant))


def test_the_template_is_a_pendulum(tmp_path):
    (tmp_path / "p.py").write_text(TEMPLATE, encoding="utf-8")
    plant = read_plant(tmp_path / "p.py")
    done = step_response(rule_table("pid", 5), plant, reference=0.3, duration=20, scale=Scale(3, 1, 1, 6, 3))
    assert done.figures.settling_time < 15
    assert done.control[-1] == pytest.approx(9.81 * np.sin(0.3), rel=1e-2)  # what holds it there


@pytest.mark.parametrize(
    ("name", "kind"), [(n, "pid") for n in PLANT_EXAMPLES] + [("motor", "pd"), ("integrating", "pd")]
)
def test_each_example_is_controlled_by_a_template(name, kind):
    example = PLANT_EXAMPLES[name]
    about: dict[str, Any] = {"duration": example.duration, "scale": Scale(*example.scale), "limits": example.limits}
    done = step_response(rule_table(kind, 7), example.plant, disturbance=example.disturbance, **about)
    assert not done.stopped
    assert done.figures.overshoot < 30
    assert done.figures.settling_time is not None


@pytest.mark.parametrize(
    ("file", "text", "sentence"),
    [
        ("a.toml", "numerator = [1]", "a.toml: the denominator is missing"),
        ("a.toml", "numerator = [1]\ndenominator = [1]\ndeadtime = 1", "did you mean 'dead_time'"),
        ("a.toml", "numerator = ", "a.toml: cannot be read"),
        (
            "a.toml",
            f"numerator = [0x1{'0' * 4000}]\ndenominator = [1]",
            "a.toml: cannot be read: numerator: a whole",
        ),
        ("a.toml", f"numerator = [1{'0' * 400}]\ndenominator = [1]", "numerator must be numbers"),
        ("a.toml", f"numerator = [1]\ndenominator = [1]\ndead_time = 1{'0' * 400}", "the dead time must be a finite"),
        ("a.toml", f"numerator = {'9' * 5000}", "a.toml: cannot be read"),
        ("a.toml", f"numerator = {'[' * 5000}", "a.toml: cannot be read"),
        ("a.py", "x = 1", r"a.py: there is no function plant\(x, u, t\)"),
        ("a.py", "def plant(x, u, t):\n    return 1 / 0", "a.py:2: ZeroDivisionError"),
        ("a.py", "def plant(x, u, t):\n    return [u]\nstates = 2", "must give 2 derivatives"),
        ("a.py", "def plant(x, u, t:\n", "a.py:1: SyntaxError"),
        ("a.txt", "", "a .toml or a .py file"),
    ],
)
def test_what_is_no_plant_is_refused_with_its_file(tmp_path, file, text, sentence):
    (tmp_path / file).write_text(text, encoding="utf-8")
    with pytest.raises(PlantError, match=sentence):
        step_response(rule_table("pd", 3), read_plant(tmp_path / file, file), duration=1)


@pytest.mark.parametrize("text", ["1", "1; x", "1; 1 1; 1 2", "1 2 3; 1"])
def test_texts_that_are_no_transfer_function(text):
    with pytest.raises(PlantError):
        plant_of_text(text)
