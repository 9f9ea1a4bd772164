"""The path in a set of pictures: of the trial that was chosen, or of one that suits the rule base."""

import fuzzy
from robotics.laws.tracking.fuzzy_tracking import load_rule_base
from robotics.plugins.designer.pictures import path_pictures
from robotics.plugins.designer.tryout import TryoutTrial, run_design, settled
from tests.drawn import x_of


def test_the_path_is_that_of_the_trial() -> None:
    fis = load_rule_base("tracking")
    wish = TryoutTrial(scenario="lyapunov-sine", seed=3)
    (picture,) = path_pictures(fis, {"trial": wish})
    assert picture.caption == f"Fuzzy by {fis.name} on lyapunov-sine, seed 3: paths and cross-track errors."
    assert picture.draw is not None
    run = run_design(fis, settled(fis, wish)).run
    ends = [x_of(line)[-1] for line in picture.draw().axes[0].lines]
    assert run["x"][0, 0, -1] in ends


def test_a_system_that_drives_no_robot_has_none() -> None:
    x = fuzzy.Variable("service", (0, 1), {"poor": fuzzy.trimf(0, 0, 1)})
    assert path_pictures(fuzzy.Sugeno([x], [fuzzy.Variable("tip", (0, 1), {"none": 0.0})]), {}) == []
