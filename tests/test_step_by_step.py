"""The page docs/howto/step-by-step.md: manual stepping and an observer, executed and held against the recorded run."""

from pathlib import Path

import numpy as np
import pytest

import robotics
from tests.snippets import snippets

PAGE = Path(__file__).parents[1] / "docs" / "howto" / "step-by-step.md"
BY_HAND, OBSERVED = (text for _, text in snippets(PAGE, changed=False))


def test_stepping_by_hand_is_the_run_but_for_what_the_hand_changes(capsys):
    changed: dict[str, object] = {}
    exec(BY_HAND, changed)
    assert "after 5 s: x = " in capsys.readouterr().out
    plain: dict[str, object] = {}
    exec(BY_HAND.replace("k == 60", "k == -1"), plain)
    run = robotics.simulate(robotics.load_scenario("lyapunov-sine"), "lyapunov", (3,))
    assert plain["truth"].x == run["x"][0, 0, 100]  # type: ignore[attr-defined]
    assert changed["truth"].x < run["x"][0, 0, 100] - 1e-3  # type: ignore[attr-defined]


@pytest.mark.long
def test_the_observer_notes_what_the_samples_tell(capsys):
    space: dict[str, object] = {}
    exec(OBSERVED, space)
    run, notes = space["run"], space["notes"]
    x, y = run.reference[:2, :, 0]  # type: ignore[attr-defined]
    expected = np.hypot(run["x"][:, 0] - x, run["y"][:, 0] - y).max(axis=-1)  # type: ignore[index]
    np.testing.assert_allclose(notes.distance, expected, rtol=1e-12)  # type: ignore[attr-defined]
    assert f"{expected.max():.3f} m" in capsys.readouterr().out


def test_an_observer_of_fifteen_lines():
    code = [line for line in OBSERVED.splitlines() if line.strip() and not line.startswith(("import", "from"))]
    assert len(code) <= 15
