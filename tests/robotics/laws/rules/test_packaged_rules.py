"""The rule bases of the fuzzy team: their size, their inputs, that some rule always fires, and that they are told."""

from dataclasses import replace

import numpy as np
import pytest

from fuzzy.commands.application import main
from fuzzy.compiled.sugeno import compile_sugeno
from fuzzy.system import Sugeno
from robotics.laws.rules.fuzzy_team import NEUTRAL, TEAM_OUTPUTS
from robotics.laws.rules.quantities import RULE_QUANTITIES
from robotics.laws.tracking.fuzzy_tracking import RULE_BASES, load_rule_base

TEAM = tuple(TEAM_OUTPUTS)
ALL = ("tracking", *TEAM)


@pytest.mark.parametrize("name", ALL)
def test_a_person_can_read_it(name, capsys):
    fis = load_rule_base(name)
    assert 0 < len(fis.rules) <= 30
    values = [f"{v.name}={sum(v.universe) / 2}" for v in fis.inputs]
    assert main(["explain", str(RULE_BASES / f"{name}.fis"), *values]) == 0
    told = capsys.readouterr().out
    assert all(variable.name in told for variable in (*fis.inputs, *fis.outputs))


@pytest.mark.parametrize("name", TEAM)
def test_inputs_are_quantities_in_their_units(name):
    fis = load_rule_base(name)
    units = {v.name: v.unit or "1" for v in fis.inputs}
    assert units == {v: RULE_QUANTITIES[v].unit for v in units}
    assert {v.name for v in fis.outputs} <= {*TEAM_OUTPUTS[name]} == {*NEUTRAL[name]}


def points(fis: Sugeno) -> np.ndarray:
    """Corners of the terms and points between them, at random in every combination: (points, inputs)."""
    rng = np.random.default_rng(6)
    columns = []
    for variable in fis.inputs:
        low, high = variable.universe
        corners = np.array([p for term in variable.terms.values() for p in term.parameters])
        corners = np.unique(np.clip(corners, low, high))
        grid = np.unique(np.concatenate([corners, (corners[1:] + corners[:-1]) / 2, [low, high]]))
        columns.append(rng.choice(grid, 40_000))
    corners = np.stack(columns, axis=-1)
    low, high = np.array([variable.universe for variable in fis.inputs]).T
    return np.concatenate([corners, rng.uniform(low, high, corners.shape)])


@pytest.mark.parametrize("name", ALL)
def test_some_rule_fires_everywhere_for_each_output(name):
    fis = load_rule_base(name)
    asked = points(fis)
    out = compile_sugeno(replace(fis, no_rule_fires="nan"))(asked)
    for k, variable in enumerate(fis.outputs):
        silent = np.isnan(out[:, k])
        at = dict(zip([v.name for v in fis.inputs], asked[silent.argmax()].round(3).tolist(), strict=True))
        assert not silent.any(), f"{name}: no rule for {variable.name} at {at}; {silent.sum()} of {len(asked)} points"
