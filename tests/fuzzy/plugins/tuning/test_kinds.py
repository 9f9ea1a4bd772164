"""Tuning of trees and of type-2 systems: numbers that made the data are found again, symmetries are kept."""

import json
from typing import Any

import numpy as np
import pytest

import fuzzy
from fuzzy.commands.application import main
from fuzzy.tuning.parameter import TuningError
from fuzzy.tuning.systemspace import search_space
from tests.fuzzy.plugins.trees.randomtrees import by_hand, random_tree


def ends(name, middle=0.5, low=0.0, high=1.0):
    """A variable of three triangles."""
    terms = {
        "low": fuzzy.Triangle(low - 1, low, middle),
        "mid": fuzzy.Triangle(low, middle, high),
        "high": fuzzy.Triangle(middle, high, high + 1),
    }
    return fuzzy.Variable(name, (low, high), terms)


def system(inputs, output, numbers, middle=0.5):
    terms = ("low", "mid", "high")
    rules = [f"if {inputs[0]} is {a} and {inputs[1]} is {b} then {output} is {a}{b}" for a in terms for b in terms]
    named = {f"{a}{b}": number for (a, b), number in zip([(a, b) for a in terms for b in terms], numbers, strict=True)}
    variables = [ends(inputs[0], middle), ends(inputs[1])]
    return fuzzy.Sugeno(variables, [fuzzy.Variable(output, (0, 1), named)], rules)


PLANE = (0.0, 0.25, 0.5, 0.25, 0.5, 0.75, 0.5, 0.75, 1.0)
BENT = (0.05, 0.2, 0.5, 0.25, 0.4, 0.75, 0.5, 0.85, 0.9)
X = np.random.default_rng(0).uniform(0, 1, (200, 3))


def tree(middle, numbers):
    return fuzzy.Tree({"last": system("sc", "v", PLANE), "first": system("ab", "s", numbers, middle)})


def test_a_tree_comes_near_to_the_one_that_made_the_data():
    true, bent = tree(0.3, BENT), tree(0.6, (0.5,) * 9)
    y = true(X)
    found = fuzzy.tune(bent, X, y, evaluations=300)
    assert {p.name.partition("/")[0] for p in found.space.parameters} == {"first", "last"}
    assert found.before == pytest.approx(np.sqrt(np.mean((bent(X) - y) ** 2)))
    assert found.after == pytest.approx(np.sqrt(np.mean((found.system(X) - y) ** 2)))
    assert found.after < 0.6 * found.before
    assert found.system.connections == bent.connections
    assert found.system.systems["first"].inputs[0].terms["mid"].b < 0.6
    constants = [t.value for t in found.system.systems["first"].outputs[0].terms.values()]
    assert all(0 <= value <= 1 for value in constants)  # what the next system takes


def test_values_of_a_start_make_the_tree_and_each_number_moves_its_own_system():
    for seed in range(5):
        start = random_tree(seed)
        x = np.random.default_rng(seed).uniform(-1, 1, (30, len(start.inputs)))
        space = search_space(start, None, False, (x, by_hand(start, x, lambda fis, points: fis(points))))
        values = np.array([p.start for p in space.parameters])
        assert space.made(values) == start
        other: Any = space.made(np.array([p.upper for p in space.parameters]))
        assert all(other.systems[name] != start.systems[name] for name in start.order)
        assert other.connections == start.connections


def slanted(lag, scale):
    fis = fuzzy.Sugeno(
        [ends("a"), ends("b")],
        [fuzzy.Variable("y", (0, 1), dict(zip("pqr", (0, 0.3, 1), strict=True)))],
        ["if a is low then y is p", "if a is mid then y is q", "if a is high and b is high then y is r"],
    )
    return fuzzy.to_type2(fis, {"a": lag}, {"a": scale})


def test_lags_and_scales_that_made_the_data_are_found_again():
    true, start = slanted({"mid": (0.3, 0.1), "low": 0.2}, 0.7), slanted({"mid": (0.1, 0.2), "low": 0.1}, 0.9)
    x, y = X[:, :2], true(X[:, :2])
    found = fuzzy.tune(start, x, y, move=["footprints"], evaluations=400)
    assert found.after == pytest.approx(np.sqrt(np.mean((found.system(x) - y) ** 2)))
    assert found.after < 0.25 * found.before
    assert found.system.upper == start.upper
    left, right = found.system.lower["a"]["mid"].lag
    assert left > 0.2 > right
    usual = fuzzy.tune(start, x, y, evaluations=2)
    names = {p.name for p in usual.space.parameters}
    assert {"a.mid.left lag", "a.mid.right lag", "a.low.lag", "b.low.scale", "y.p"} <= names


def test_a_symmetric_footprint_stays_so():
    level = ends("e", 0.0, -1.0, 1.0)
    fis = fuzzy.Sugeno(
        [level],
        [fuzzy.Variable("u", (-1, 1), {"n": -1, "z": 0, "p": 1})],
        ["if e is low then u is n", "if e is mid then u is z", "if e is high then u is p"],
    )
    mirrored = fuzzy.to_type2(fis, {"e": {"low": (0.3, 0.1), "high": (0.1, 0.3)}}, 0.9)
    x = np.linspace(-1, 1, 41)[:, None]
    found = fuzzy.tune(mirrored, x, np.tanh(3 * x) + 0.1 * x**2, symmetric=True, evaluations=60).system
    assert found != mirrored
    np.testing.assert_allclose(found(-x), -found(x), atol=1e-12)
    slant = fuzzy.to_type2(fis, {"e": {"low": 0.3}}, 0.9)
    parameters = [p.name for p in search_space(slant, None, True, (x, x)).parameters]
    assert "e.low.lag" in parameters
    assert "e.high.lag" in parameters


def test_what_cannot_be_is_told():
    for other in (tree(0.5, PLANE), slanted(0.1, 0.9)):
        x = X[:, : len(other.inputs)]
        with pytest.raises(TuningError, match="consequents do not follow by least squares"):
            fuzzy.tune(other, x, x[:, 0], solve=True)
    with pytest.raises(TuningError, match="footprints"):
        fuzzy.tune(tree(0.5, PLANE), X, X[:, 0], move=["footprints"])


def test_the_command_takes_a_folder_and_a_type2_file(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    start, true = tree(0.6, (0.5,) * 9), tree(0.3, BENT)
    start.write("start")
    given = X[:, ["abc".index(v.name) for v in start.inputs]]
    heads = [v.name for v in start.inputs]
    table = np.column_stack([given, true(given)])
    np.savetxt("data.csv", table, delimiter=",", header=",".join([*heads, "v"]), comments="")
    options = ["--evaluations", "80", "--seed", "2", "--json"]
    assert main(["tune", "data.csv", "start", "-o", "tuned", *options]) == 0
    said = json.loads(capsys.readouterr().out)
    error = np.sqrt(np.mean((fuzzy.read_tree("tuned")(given) - true(given)) ** 2))
    assert said["after"] == pytest.approx(error)
    assert error < said["before"]

    wide = slanted(0.1, 0.9)
    fuzzy.write_fis(wide, "wide.fis")
    y = slanted(0.4, 0.5)(X[:, :2])
    np.savetxt("two.csv", np.column_stack([X[:, :2], y]), delimiter=",", header="a,b,y", comments="")
    assert main(["tune", "two.csv", "wide.fis", "-o", "narrow.fis", "--move", "footprints", *options]) == 0
    said = json.loads(capsys.readouterr().out)
    narrow = fuzzy.read_type2("narrow.fis")
    assert said["after"] == pytest.approx(np.sqrt(np.mean((narrow(X[:, :2]) - y) ** 2)))
    assert narrow.upper.inputs == wide.upper.inputs
    assert narrow.lower != wide.lower
