"""Trees: their answers by hand, compiled, in C, their gradients; what makes none; their files."""

from pathlib import Path

import numpy as np
import pytest
import torch

import fuzzy
from fuzzy.plugins import ccode
from fuzzy.plugins.ccode.compiler import find_compiler, run_program
from fuzzy.plugins.ccode.phrases import filled
from fuzzy.plugins.trees.training import numbers_of, with_numbers
from tests.fuzzy.plugins.trees.randomtrees import by_hand, random_system, random_tree

silent_places = pytest.mark.filterwarnings("ignore:.*no rule fires:fuzzy.inference.InferenceWarning")


def system(inputs, output, name="fuzzy", universe=(0, 1), unit=""):
    """A system that averages its inputs roughly: one rule for each, high with high."""
    variables = [fuzzy.Variable(i, (0, 1), {"high": fuzzy.LinearS(0, 1), "low": fuzzy.LinearZ(0, 1)}) for i in inputs]
    rules = [f"if {i} is {word} then {output} is {word}" for i in inputs for word in ("high", "low")]
    return fuzzy.Sugeno(variables, [fuzzy.Variable(output, universe, {"high": 1, "low": 0}, unit)], rules, name)


GRIP, SPEED = system(["wet", "wear"], "friction", "grip"), system(["friction", "distance"], "v", "speed")
TREE = fuzzy.Tree({"speed": SPEED, "grip": GRIP})


def test_names_connect_and_the_order_follows():
    assert TREE.connections == (("grip/friction", "speed/friction"),)
    assert TREE.order == ("grip", "speed")
    assert [v.name for v in TREE.inputs] == ["distance", "wet", "wear"]
    assert TREE.evaluate({"wet": 0.2, "wear": 0.4, "distance": 0.9})["v"] == pytest.approx((0.3 + 0.9) / 2)
    both = fuzzy.Tree({"speed": SPEED, "grip": GRIP}, answers=["speed/v", "grip/friction"])
    assert both([0.9, 0.2, 0.4]).tolist() == pytest.approx([0.6, 0.3])


def test_inputs_of_one_name_are_one_and_without_names_in_common_they_are_called_as_their_ports():
    sides = {"left": system(["a", "b"], "u"), "right": system(["b", "c"], "w")}
    assert [v.name for v in fuzzy.Tree(sides).inputs] == ["a", "b", "c"]
    apart = fuzzy.Tree(sides, [])
    assert [v.name for v in apart.inputs] == ["a", "left/b", "right/b", "c"]
    assert apart([0, 0.5, 1, 1]).tolist() == [0.25, 1]


def test_values_by_name_are_broadcast():
    wet = np.linspace(0, 1, 5)
    found = TREE.evaluate({"distance": 0.9, "wet": wet[:, None], "wear": np.array([0.1, 0.2])})["v"]
    assert found.shape == (5, 2)
    assert found == pytest.approx((((wet[:, None] + np.array([0.1, 0.2])) / 2) + 0.9) / 2)


@silent_places
@pytest.mark.parametrize("trees", [20, pytest.param(200, marks=pytest.mark.long)])
def test_random_trees_answer_as_calls_of_their_systems_do_to_the_last_bit(trees):
    wires = set()
    for seed in range(trees):
        tree = random_tree(seed)
        x = np.random.default_rng(seed).uniform(-1, 1, (70, len(tree.inputs)))
        found = tree(x)
        assert np.array_equal(found, by_hand(tree, x, lambda fis, points: fis(points))), seed
        compiled = fuzzy.compile_tree(tree)
        wanted = by_hand(tree, x, lambda fis, points: fuzzy.compile_sugeno(fis)(points))
        assert np.array_equal(compiled(x), wanted), seed
        assert wanted == pytest.approx(found, rel=1e-9, abs=1e-9), seed
        assert np.array_equal(compiled(x[3]), wanted[3])
        wires.add(len(tree.connections))
    assert max(wires) > 8


def test_many_points_are_shared_out_and_each_system_speaks_for_itself():
    compiled = fuzzy.compile_tree(TREE)
    x = np.random.default_rng(0).uniform(0, 1, (70_000, 3))
    assert np.array_equal(compiled(x)[::997], compiled(x[::997]))
    x[69_000, 0] = 2.0
    with pytest.warns(fuzzy.InferenceWarning, match=r"speed: input distance outside \[0 1\]"):
        compiled(x)
    with pytest.warns(fuzzy.InferenceWarning, match=r"speed: input distance outside \[0 1\]"):
        TREE(x)
    assert compiled(np.empty((0, 3))).shape == (0, 1)


def test_gradients_are_those_of_differences():
    for seed in range(8):
        tree = random_tree(seed, smooth=True)
        rng = np.random.default_rng(seed)
        x, weight = rng.uniform(-1, 1, (4, len(tree.inputs))), rng.uniform(-1, 1, (4, len(tree.outputs)))
        numbers = np.array(numbers_of(tree))
        free, points = (torch.tensor(values, requires_grad=True) for values in (numbers, x))
        (with_numbers(tree, free.unbind())(points) * torch.tensor(weight)).sum().backward()
        for _ in range(3):
            along, across = rng.standard_normal(numbers.shape), rng.standard_normal(x.shape)
            steps = [
                float((with_numbers(tree, (numbers + h * along).tolist())(x + h * across) * weight).sum())
                for h in (1e-5, -1e-5)
            ]
            wanted = float((free.grad.numpy() * along).sum() + (points.grad.numpy() * across).sum())
            assert (steps[0] - steps[1]) / 2e-5 == pytest.approx(wanted, rel=1e-6, abs=1e-6), seed


def test_a_tree_learns_what_another_of_its_form_says_from_its_outputs_alone():
    rng = np.random.default_rng(1)
    tree = random_tree(5, smooth=True)
    numbers = np.array(numbers_of(tree))
    other = with_numbers(tree, (numbers * rng.uniform(0.85, 1.15, len(numbers))).tolist())
    x = rng.uniform(-1, 1, (90, len(tree.inputs)))
    learnt = fuzzy.train_tree(tree, x[:60], other(x[:60]), epochs=25, check=(x[60:], other(x[60:])))
    assert learnt.errors[-1] < learnt.errors[0] / 2
    wanted = other(x[:60])
    spread = [column.std() if len({*column}) > 1 else 1.0 for column in wanted.T]  # one of them is always the same
    left = np.sqrt(np.mean(((learnt.tree(x[60:]) - other(x[60:])) / spread) ** 2))
    assert left == pytest.approx(min(learnt.check_errors), rel=1e-9)
    assert learnt.tree.connections == tree.connections


def test_an_output_that_is_always_one_number_is_measured_in_its_own_unit():
    x = np.random.default_rng(0).uniform(0, 1, (7, 3))
    y = np.full(7, 0.1)
    assert y.std() > 0  # by rounding of the mean
    wanted = np.sqrt(np.mean((TREE(x)[:, 0] - 0.1) ** 2))
    assert fuzzy.train_tree(TREE, x, y, epochs=0).errors == pytest.approx((wanted,))


def test_a_proposed_tree_takes_what_says_something_and_each_system_errs_no_more_than_the_one_before():
    rng = np.random.default_rng(0)
    x = rng.uniform(0, 1, (160, 5))
    y = 3 * x[:, 3] - 2 * x[:, 1] ** 2 + np.sin(3 * x[:, 0]) + rng.normal(0, 0.02, 160)
    tree = fuzzy.identify_tree(x, y, input_names="abcde", output_name="y", folds=3)
    assert [v.name for v in tree.inputs][:1] == ["d"]
    assert {v.name for v in tree.inputs} == {"a", "b", "d"}
    assert tree.columns[3:] == ("stage 1/y 1", "stage 2/y")
    values = tree.values({v.name: x[:, "abcde".index(v.name)] for v in tree.inputs})
    errors = [np.sqrt(np.mean((value - y) ** 2)) for value in values[3:]]
    assert errors[1] < 0.1 < errors[0]
    with pytest.raises(fuzzy.InputError, match="a name for each of 5 inputs"):
        fuzzy.identify_tree(x, y, input_names="ab")


def test_learning_keeps_vertices_in_order():
    tree = fuzzy.Tree({"a": system(["x"], "y"), "b": system(["y"], "z")})
    x = np.linspace(0, 1, 20)[:, None]
    learnt = fuzzy.train_tree(tree, x, x > 0.5, epochs=40, step=0.2)
    for fis in learnt.tree.systems.values():
        for term in fis.inputs[0].terms.values():
            assert term.numbers[0] <= term.numbers[1]
    with pytest.raises(fuzzy.TreeError, match=r"need y of shape \(20, 1\), got \(19, 1\)"):
        fuzzy.train_tree(tree, x, x[1:])


@silent_places
@pytest.mark.parametrize("seed", [3, 8])
def test_its_c_answers_as_it_does(seed, tmp_path):
    tree = random_tree(seed)
    files = fuzzy.write_c_tree(tree, tmp_path)
    assert sorted(tmp_path.iterdir()) == sorted(
        [files.header, files.source, *(path for each in files.systems for path in each[:2])]
    )
    x = np.random.default_rng(seed).uniform(-1, 1, (300, len(tree.inputs)))
    driver, points, answers = (tmp_path / name for name in ("driver.c", "points", "answers"))
    driver.write_text(filled(Path(ccode.__file__).with_name("driver.c"), NAME="tree", UPPER="TREE", REAL="double"))
    points.write_bytes(x.tobytes())
    program = find_compiler().compile([driver, *tmp_path.glob("tree*.c")], tmp_path / "program", f"-I{tmp_path}", "-O1")
    run_program(program, str(points), str(answers))
    y = np.frombuffer(answers.read_bytes()).reshape(len(x), -1)
    assert y == pytest.approx(tree(x), rel=1e-12, abs=1e-12)


def test_systems_of_like_names_have_files_of_their_own(tmp_path):
    tree = fuzzy.Tree({"a b": system(["x"], "y"), "A_b": system(["y"], "z"), "a": system(["z"], "o")}, name="a")
    fuzzy.write_c_tree(tree, tmp_path, "q16.16")
    assert len({path.name.casefold() for path in tmp_path.glob("*.c")}) == 4
    find_compiler().compile([*tmp_path.glob("*.c")], tmp_path / "a.o", f"-I{tmp_path}", "-shared", "-fPIC")


def test_an_explanation_tells_each_system_and_where_it_takes_from():
    found = fuzzy.explain_tree(TREE, {"wet": 0.2, "wear": 0.4, "distance": 0.9})
    assert found.output == pytest.approx(tuple(TREE([0.9, 0.2, 0.4])))
    assert list(found.systems) == ["grip", "speed"]
    assert found.systems["speed"].x == pytest.approx((0.3, 0.9))
    assert "speed takes friction from grip/friction:\n  friction = 0.3 is low (0.70), high (0.30)" in str(found)
    assert found.as_dict()["systems"]["grip"]["outputs"] == {"friction": pytest.approx(0.3)}
    with pytest.raises(fuzzy.TreeError, match="one point of 3 inputs can be explained"):
        fuzzy.explain_tree(TREE, np.zeros((2, 3)))


def test_it_is_described_with_its_wires_and_what_no_rule_uses():
    lone = fuzzy.Variable("lone", (0, 1), {"high": fuzzy.LinearS(0, 1)})
    with_lone = fuzzy.Sugeno([*GRIP.inputs, lone], GRIP.outputs, GRIP.rules)
    tree = fuzzy.Tree({"grip": with_lone, "speed": SPEED})
    assert tree.unused_inputs == ("grip/lone",) == tuple(tree.as_dict()["unused"])
    assert "grip/friction -> speed/friction\ngrip/lone: no rule uses it\n" in tree.describe()
    plane = fuzzy.Variable("friction", (0, 1), {"high": fuzzy.Linear([0, 0, 1], 0), "low": 0})
    assert fuzzy.Tree({"grip": fuzzy.Sugeno(with_lone.inputs, [plane], GRIP.rules)}).unused_inputs == ()


def test_its_picture_has_every_name_and_as_many_wires_as_there_are_takers():
    figure = fuzzy.plot_tree(TREE)
    (ax,) = figure.axes
    texts = [text.get_text() for text in ax.texts]
    assert sorted(texts) == sorted(
        ["grip: 4 rules", "speed: 4 rules", *2 * ["distance", "wet", "wear", "v", "friction"]]  # boxes; ends and ports
    )
    assert len(ax.patches) == 2 + 5 + 1  # boxes, wires, and one that passes by a box


WRONG = {
    "a tree needs systems": lambda: fuzzy.Tree({}),
    "called by letters, digits": lambda: fuzzy.Tree({"a/b": GRIP}),
    "of the type Sugeno, got Type2Sugeno": lambda: fuzzy.Tree({"a": fuzzy.to_type2(GRIP)}),  # type: ignore[dict-item]
    "an input and an output are both called wet": lambda: fuzzy.Tree({"a": system(["wet"], "wet")}),
    "the same name but for capitals: a, A": lambda: fuzzy.Tree({"a": GRIP, "A": SPEED}),
    "speed/friction: a and b have an output of this name": lambda: fuzzy.Tree({"a": GRIP, "b": GRIP, "speed": SPEED}),
    "in a circle: a -> b -> a": lambda: fuzzy.Tree({"a": system(["v"], "u"), "b": system(["u"], "v")}),
    "in a circle: a/wet <- a/wear <- a/wet": lambda: fuzzy.Tree(
        {"a": GRIP}, [("a/wear", "a/wet"), ("a/wet", "a/wear")]
    ),
    "in a circle: a -> a": lambda: fuzzy.Tree({"a": GRIP}, [("a/friction", "a/wet")]),
    "unknown port 'grip/frictoin'; did you mean 'grip/friction'": lambda: fuzzy.Tree(
        {"grip": GRIP, "speed": SPEED}, [("grip/frictoin", "speed/friction")]
    ),
    "unknown input of a system 'speed/v'": lambda: fuzzy.Tree(
        {"grip": GRIP, "speed": SPEED}, [("grip/friction", "speed/v")]
    ),
    "two connections end in a/wet": lambda: fuzzy.Tree({"a": GRIP}, [("a/wear", "a/wet"), ("a/wear", "a/wet")]),
    "a connection is a pair of ports": lambda: fuzzy.Tree({"a": GRIP}, ["a/wear"]),  # type: ignore[list-item]
    "unknown output of a system 'a/wet'": lambda: fuzzy.Tree({"a": GRIP}, answers=["a/wet"]),
    "outputs, one at least and each once, got []": lambda: fuzzy.Tree({"a": GRIP}, answers=[]),
    "each once, got ['a/friction', 'a/friction']": lambda: fuzzy.Tree(
        {"a": GRIP}, answers=["a/friction", "a/friction"]
    ),
    "nothing that speed answers reaches grip/friction": lambda: fuzzy.Tree(
        {"grip": GRIP, "speed": SPEED}, answers=["grip/friction"]
    ),
    "grip/friction -> speed/friction: the universe [0 2] of the first must lie in": lambda: fuzzy.Tree(
        {"grip": system(["wet"], "friction", universe=(0, 2)), "speed": SPEED}
    ),
    "the first is in 'N', the second in 'm'": lambda: fuzzy.Tree(
        {
            "a": system(["x"], "y", unit="N"),
            "b": fuzzy.Sugeno([fuzzy.Variable("y", (0, 1), GRIP.inputs[0].terms, "m")], GRIP.outputs),
        }
    ),
    "no value for wet and wear": lambda: TREE.evaluate({"distance": 1}),
    "unknown input 'wett'; did you mean 'wet'": lambda: TREE.evaluate({"wett": 1}),
    "the last axis of the input must hold 3 values (distance, wet, wear)": lambda: TREE([1.0, 2.0]),
}


@pytest.mark.parametrize("said", WRONG)
def test_what_makes_no_tree_is_said(said):
    with pytest.raises(fuzzy.InputError) as caught:
        WRONG[said]()
    assert said in str(caught.value)


def test_random_trees_come_back_from_their_folders(tmp_path):
    for seed in range(20):
        tree = random_tree(seed)
        tree.write(tmp_path / str(seed), "Title\n\nmore")
        assert fuzzy.read_tree(tmp_path / str(seed)) == tree
    assert (tmp_path / "3" / "tree.toml").read_text().startswith('# Title\n#\n# more\nname = "tree"\n')


def test_a_tree_that_cannot_be_written_leaves_the_one_that_is_there(tmp_path):
    TREE.write(tmp_path)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    with pytest.raises(fuzzy.TreeError, match="no valid text"):
        fuzzy.Tree({"grip": random_system(np.random.default_rng(0), False)}, name="\ud800").write(tmp_path)
    (tmp_path / "late.fis").mkdir()
    with pytest.raises(IsADirectoryError, match=r"late\.fis"):
        fuzzy.Tree({"grip": SPEED, "late": GRIP}).write(tmp_path)
    (tmp_path / "late.fis").rmdir()
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_a_file_without_connections_and_answers_is_read_by_the_names(tmp_path):
    TREE.write(tmp_path)
    (tmp_path / "tree.toml").write_text('[systems]\nspeed = "speed.fis"\ngrip = "grip.fis"\n')
    assert fuzzy.read_tree(tmp_path / "tree.toml") == TREE


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("name = 3", "name must be a str, got '3'"),
        ("syste = 3", "unknown key 'syste'; did you mean 'systems'"),
        ("", "a tree needs systems"),
        ("[systems]\ngrip = 3", "systems.grip must be the name of a .fis file, got '3'"),
        ("[systems", "no TOML in UTF-8"),
        ('answers = ["grip/v"]\n[systems]\ngrip = "grip.fis"', "unknown output of a system 'grip/v'"),
        ('connections = [["grip/v", 3]]\n[systems]\ngrip = "grip.fis"', "unknown port 'grip/v'"),
        ('connections = [3]\n[systems]\ngrip = "grip.fis"', "a connection is a pair of ports"),
        ('[systems]\ngrip = "gripp.fis"', "gripp.fis"),
    ],
)
def test_a_file_that_describes_no_tree_is_refused_with_its_name(text, said, tmp_path):
    TREE.write(tmp_path)
    (tmp_path / "tree.toml").write_text(text)
    with pytest.raises(fuzzy.InputError) as caught:
        fuzzy.read_tree(tmp_path)
    assert said in str(caught.value)
    assert str(tmp_path) in str(caught.value)
