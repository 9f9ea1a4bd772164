"""The length of hybrid learning's steps, by Jang's two rules worked by hand."""

import pytest

import anfis
from anfis import Options
from anfis.methods.hybrid import jang_step
from tests.anfis.training_problem import FIS, X, Y


def steps_of(errors: list[float], step: float = 1.0) -> list[float]:
    steps = [step]
    for n in range(1, len(errors)):
        steps.append(jang_step(errors[:n], steps, 1.1, 0.9))
    return steps


def test_the_step_grows_after_every_four_reductions():
    steps = steps_of([float(20 - n) for n in range(14)])
    # Errors 0 to 4 are four reductions: step 5 is longer; then errors 4 to 8, 8 to 12.
    assert steps == pytest.approx([1.0] * 5 + [1.1] * 4 + [1.21] * 4 + [1.331])


def test_the_step_shrinks_after_two_ups_and_downs():
    steps = steps_of([1.0, 2.0, 1.0, 2.0, 1.0, 2.0, 1.0, 2.0, 1.0, 2.0])
    assert steps == pytest.approx([1.0] * 5 + [0.9] * 4 + [0.81])
    # The count starts with an increase: down, up, down, up changes nothing before the next reduction.
    assert steps_of([2.0, 1.0, 2.0, 1.0, 2.0, 1.0, 2.0]) == pytest.approx([1.0] * 6 + [0.9])
    assert steps_of([1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0]) == [1.0] * 7
    assert steps_of([5.0, 4.0, 3.0, 2.0, 2.0, 1.0, 0.5]) == [1.0] * 7


def test_hybrid_takes_jangs_steps():
    history = anfis.train(FIS, X, Y, Options(epochs=30, step=0.02)).history
    assert [row.step for row in history] == steps_of([row.train for row in history], 0.02)
