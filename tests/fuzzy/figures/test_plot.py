import subprocess
import sys
from itertools import pairwise

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.figure import Figure

from fuzzy.figures.drawing import DOUBLE, save_figure, shortened, text_width
from fuzzy.figures.plot import (
    gensurf,
    plot_memberships,
    plot_rules,
    plot_structure,
    plot_surface,
    plotfis,
    plotmf,
    ruleview,
    surface,
)
from fuzzy.inference import infer
from fuzzy.membership import Gaussian, Triangle
from fuzzy.system import FuzzySystemError, Linear, NoRuleFires, Sugeno, Variable
from tests.drawn import x_of, y_of

DISTANCE = Variable("distance", (0, 4), {"near": Triangle(0, 0, 2), "far": Triangle(0, 4, 4)}, "m")
BEARING = Variable("bearing", (-1, 1), {"left": Triangle(-2, -1, 0), "right": Triangle(0, 1, 2)}, "rad")
LOAD = Variable("load", (0, 10), {"light": Gaussian(3, 0), "heavy": Gaussian(3, 10)}, "kg")
SPEED = Variable("speed", (0, 1), {"slow": 0.1, "fast": 0.9, "careful": Linear([0.1, 0, 0.01], 0.2)}, "m/s")
TURN = Variable("turn", (-1, 1), {"left": -0.5, "right": 0.5})
FIS = Sugeno(
    [DISTANCE, BEARING, LOAD],
    [SPEED, TURN],
    [
        "if distance is far and load is light then speed is fast",
        "if distance is not very near and bearing is left then speed is slow and turn is left",
        "if bearing is right or load is heavy then speed is careful and turn is right with 0.5",
    ],
)
# Between 3 and 6 no rule fires.
GAP = Sugeno(
    [Variable("x", (0, 10), {"low": Triangle(-1, 1, 3), "high": Triangle(6, 8, 11)}), DISTANCE],
    [Variable("z", (0, 1), {"a": 0.25, "b": 0.75})],
    ["if x is low then z is a", "if x is high then z is b"],
)


def texts(figure: Figure) -> list[str]:
    return [t.get_text() for t in figure.findobj(mpl.text.Text) if t.get_text() and t.get_visible()]


def boxes(figure: Figure, wanted: list[str]) -> list[mpl.transforms.Bbox]:
    figure.draw_without_rendering()
    found = [t for t in figure.findobj(mpl.text.Text) if t.get_text() in wanted]
    return [t.get_window_extent() for t in found]


def test_surface_values_are_those_of_the_system() -> None:
    x, y, z, fired = surface(FIS, ("load", "distance"), "turn", {"bearing": 0.5}, points=(5, 4))
    assert x.shape == y.shape == z.shape == fired.shape == (4, 5)
    assert x[0].tolist() == [0, 2.5, 5, 7.5, 10]
    assert y[:, 0].tolist() == pytest.approx([0, 4 / 3, 8 / 3, 4])
    points = np.stack([y, np.full_like(x, 0.5), x], axis=-1)
    assert np.array_equal(z, FIS(points)[..., 1])
    assert fired.all()


def test_other_inputs_are_held_at_midrange_as_in_gensurf() -> None:
    x, y, z, _ = surface(FIS, points=3)
    assert np.array_equal(z[2, 1], FIS([2.0, 1.0, 5.0])[0])
    assert (x[2, 1], y[2, 1]) == (2.0, 1.0)


def test_a_single_input_gives_a_curve() -> None:
    x, y, z, fired = surface(FIS, "load", fixed={0: 1.0}, points=7)
    assert y is None
    assert np.array_equal(z, FIS(np.stack([np.full(7, 1.0), np.zeros(7), x], axis=-1))[:, 0])
    assert fired.shape == (7,)


@pytest.mark.parametrize("no_rule_fires", ["midrange", "nan", "error"])
def test_surface_says_where_no_rule_fires_without_warning(no_rule_fires: NoRuleFires) -> None:
    fis = Sugeno(GAP.inputs, GAP.outputs, GAP.rules, no_rule_fires=no_rule_fires)
    x, _, z, fired = surface(fis, points=(11, 2))
    assert np.array_equal(fired[0], (x[0] < 3) | (x[0] > 6))
    assert np.array_equal(z[0, 3:7], np.full(4, 0.5 if no_rule_fires == "midrange" else np.nan), equal_nan=True)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"inputs": ("distance", "lod")}, "unknown input 'lod'; did you mean 'load'"),
        ({"inputs": (0, 0)}, "one or two different inputs"),
        ({"inputs": (0, 3)}, "no input 3; the system has 3"),
        ({"output": "sped"}, "did you mean 'speed'"),
        ({"fixed": {"distance": 1.0}}, "'distance' cannot both be held and be an axis"),
        ({"fixed": {"load": float("nan")}}, "must be a finite number"),
        ({"points": 1}, "at least 2"),
    ],
)
def test_surface_refuses(arguments: dict, message: str) -> None:
    with pytest.raises(FuzzySystemError, match=message):
        surface(FIS, **arguments)


def test_contour_shows_the_surface_and_hatches_the_gap() -> None:
    figure = plot_surface(GAP, points=21)
    said = texts(figure)
    assert "distance [m]" in said
    assert "no rule fires: 0.5 stands there" in said
    assert any("/" in hatch for c in figure.findobj(mpl.contour.ContourSet) for hatch in c.hatches if hatch)
    assert "no rule fires: 0.5 stands there" not in texts(plot_surface(FIS))


def test_a_system_without_gap_and_a_flat_surface_can_be_drawn() -> None:
    flat = Sugeno(
        [DISTANCE, BEARING], [Variable("z", (0, 1), {"a": 0.0})], ["if distance is near or bearing is left then z is a"]
    )
    for kind in ("contour", "3d", "both"):
        plot_surface(flat, kind=kind).draw_without_rendering()


def test_surface_title_says_what_is_held() -> None:
    assert "at load = 3 kg" in texts(plot_surface(FIS, fixed={"load": 3}))
    assert "at bearing = 0 rad, load = 5 kg" in texts(plot_surface(FIS, "distance"))


def test_curve_is_the_output() -> None:
    figure = plot_surface(FIS, "distance", points=9)
    line = figure.axes[0].lines[0]
    assert np.array_equal(line.get_ydata(), surface(FIS, "distance", points=9).z)


def test_pictures_are_drawn_on_given_axes_and_the_style_stays_local() -> None:
    before = dict(mpl.rcParams)
    figure = Figure()
    one, two = figure.subplots(1, 2)
    assert plot_surface(FIS, ax=one) is figure
    assert plot_memberships(FIS, "load", ax=two) is figure
    assert len(two.lines) >= 2
    assert one.get_xlabel() == "distance [m]"
    assert dict(mpl.rcParams) == before
    with pytest.raises(FuzzySystemError, match="takes no axes"):
        plot_surface(FIS, kind="both", ax=one)
    with pytest.raises(FuzzySystemError, match="one axes shows one variable"):
        plot_memberships(FIS, ax=one)


def test_membership_curves_are_the_degrees_and_carry_their_names() -> None:
    figure = plot_memberships(FIS, "load")
    ax = figure.axes[0]
    for name, function in LOAD.terms.items():
        line = next(line for line in ax.lines if line.get_label() == name)
        x, y = line.get_data()
        assert np.allclose(function(x), y, equal_nan=False)
        assert name in texts(figure)
    assert ax.get_xlabel() == "load [kg]"


def test_constants_are_stems_at_their_values() -> None:
    ax = plot_memberships(FIS, "turn").axes[0]
    stems = sorted(x_of(line)[0] for line in ax.lines if list(y_of(line)) == [0, 1])
    assert stems == [-0.5, 0.5]


def test_a_linear_consequent_is_a_bar_over_what_it_reaches() -> None:
    ax = plot_memberships(FIS, "speed").axes[0]
    bars = [list(x_of(line)) for line in ax.lines if len(x_of(line)) == 2]
    assert bars == [[0.1, 0.1], [0.9, 0.9], pytest.approx([0.2, 0.2 + 0.4 + 0.1])]
    assert [t.get_text() for t in ax.get_yticklabels()] == ["slow", "fast", "careful"]


@pytest.mark.parametrize("terms", [3, 5, 9, 14])
def test_names_do_not_overlap(terms: int) -> None:
    names = [f"somewhat long {n}" for n in range(terms)]
    variable = Variable("x", (0, 1), {n: Gaussian(0.05, k / (terms - 1)) for k, n in enumerate(names)})
    rules = [f"if x is '{n}' then y is a" for n in names]
    figure = plot_memberships(Sugeno([variable], [Variable("y", (0, 1), {"a": 0})], rules), "x")
    found = boxes(figure, names)
    assert len(found) == terms
    width, height = figure.get_size_inches() * figure.dpi
    for k, box in enumerate(found):
        assert box.x0 >= -1
        assert box.x1 <= width + 1
        assert box.y1 <= height + 1
        assert not any(box.overlaps(other) for other in found[:k])


def test_firing_bars_show_the_firing_strengths() -> None:
    x = [2.5, 0.4, 3.0]
    figure = plot_rules(FIS, x)
    firing = infer(FIS, np.array(x)).firing
    bars = {p.get_gid(): p.get_width() for p in figure.findobj(mpl.patches.Rectangle) if p.get_gid()}
    assert bars == {f"firing-{r + 1}": pytest.approx(w) for r, w in enumerate(firing)}


def test_rule_viewer_says_the_result_and_the_clauses() -> None:
    x = [2.5, -0.4, 3.0]
    said = texts(plot_rules(FIS, x))
    speed, turn = FIS(x)
    assert f"= {speed:.4g} m/s" in said
    assert f"= {turn:.4g}".replace("-", "−") in said
    assert "not very near" in said
    assert "3\nor\n×0.5" in said
    assert "distance [m]\n= 2.5" in said


def test_rule_viewer_can_leave_out_what_does_not_fire() -> None:
    figure = plot_rules(GAP, [7.0, 1.0], only_fired=True)
    assert {p.get_gid() for p in figure.findobj(mpl.patches.Rectangle) if p.get_gid()} == {"firing-2"}


def test_rule_viewer_says_when_nothing_fires_and_when_an_input_is_outside() -> None:
    assert "no rule fires: 0.5" in texts(plot_rules(GAP, [4.0, 9.0]))


def test_rule_viewer_refuses_another_shape() -> None:
    with pytest.raises(FuzzySystemError, match=r"one point of 3 inputs \(distance, bearing, load\), got shape \(2,\)"):
        plot_rules(FIS, [1, 2])


@pytest.mark.parametrize("rules", [5, 25])
def test_rows_of_the_rule_viewer_stay_readable(rules: int) -> None:
    many = Sugeno(FIS.inputs, FIS.outputs, [FIS.rules[n % 3] for n in range(rules)])
    figure = plot_rules(many, [2.5, 0.4, 3.0])
    width, height = figure.get_size_inches()
    assert width <= DOUBLE
    assert height / rules >= 0.26
    numbers = boxes(figure, [str(n + 1) for n in range(rules)])
    assert len(numbers) >= rules / 3


@pytest.mark.parametrize("high", [1.0, 11.48, 123.4, 1234.0])
def test_numbers_under_a_column_of_the_rule_viewer_do_not_meet(high: float) -> None:
    terms = {"low": Triangle(-high, -high, high), "high": Triangle(-high, high, high)}
    inputs = [Variable(name, (-high, high), terms) for name in "abcd"]
    outputs = [Variable(name, (-high, high), {"down": -high, "up": high}) for name in "uv"]
    fis = Sugeno(inputs, outputs, ["if a is low then u is down and v is up", "if a is high then u is up and v is down"])
    figure = plot_rules(fis, [0.1, 0.2, 0.3, 0.4])
    figure.draw_without_rendering()
    for ax in figure.axes:
        boxes = [label.get_window_extent() for label in ax.get_xticklabels() if label.get_text()]
        assert all(right.x0 > left.x1 for left, right in pairwise(boxes)), [b.x0 for b in boxes]


def test_structure_shows_every_name_and_joins_terms_to_their_rules() -> None:
    figure = plot_structure(FIS)
    said = texts(figure)
    for variable in (*FIS.inputs, *FIS.outputs):
        assert {variable.name, *variable.terms} <= set(said)
    assert {"Π 1", "Π 2", "or 3 ×0.5"} <= set(said)
    # 6 of input to term, 6 of term to rule, 9 of rule to N, 5 of N to consequent, 5 of consequent to output
    lines = figure.axes[0].lines
    assert len(lines) == 6 + 6 + 9 + 5 + 5
    assert [line.get_linestyle() for line in lines].count("--") == 1


def test_structure_of_many_rules_has_one_normalising_box() -> None:
    many = Sugeno(FIS.inputs, FIS.outputs, [FIS.rules[n % 3] for n in range(25)])
    assert "normalised: w / Σw" in texts(plot_structure(many))


def test_matlab_names_are_aliases() -> None:
    assert (plotmf, gensurf, ruleview, plotfis) == (plot_memberships, plot_surface, plot_rules, plot_structure)


def test_names_with_dollars_are_no_mathematics() -> None:
    variable = Variable("$x_1$", (0, 1), {"a$b$": Gaussian(0.2, 0), "c_d": Gaussian(0.2, 1)})
    fis = Sugeno([variable], [Variable("$y^$", (0, 1), {"$": 1})], ["if '$x_1$' is 'a$b$' then '$y^$' is '$'"])
    for figure in (plot_memberships(fis), plot_surface(fis), plot_rules(fis, [0.3]), plot_structure(fis)):
        figure.draw_without_rendering()


def test_pictures_of_a_system_in_training() -> None:
    torch = pytest.importorskip("torch")
    c = torch.tensor(1.0, requires_grad=True)
    fis = Sugeno(
        [Variable("x", (0, 2), {"a": Gaussian(c, c), "b": Gaussian(0.5, 0.0)})],
        [Variable("y", (0, 1), {"k": Linear(torch.ones(1, requires_grad=True), c)})],
        ["if x is a then y is k"],
    )
    for figure in (plot_memberships(fis), plot_surface(fis), plot_rules(fis, [0.3]), plot_structure(fis)):
        figure.draw_without_rendering()


@pytest.mark.parametrize("suffix", ["png", "pdf", "svg"])
def test_saved_pictures_are_whole_and_of_their_kind(tmp_path, suffix: str) -> None:
    path = tmp_path / f"a.{suffix}"
    save_figure(plot_structure(FIS), path)
    start = path.read_bytes()[:100]
    assert {"png": b"\x89PNG", "pdf": b"%PDF", "svg": b"<?xml"}[suffix] in start
    assert [p.name for p in tmp_path.iterdir()] == [f"a.{suffix}"]


def test_saved_svg_is_reproducible(tmp_path) -> None:
    for name in ("a.svg", "b.svg"):
        save_figure(plot_memberships(FIS), tmp_path / name)
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()


def test_saving_refuses_other_suffixes_and_leaves_nothing_behind(tmp_path) -> None:
    with pytest.raises(FuzzySystemError, match=r"end it in \.png, \.pdf or \.svg"):
        save_figure(Figure(), tmp_path / "a.gif")
    with pytest.raises(OSError, match="no folder"):
        save_figure(Figure(), tmp_path / "missing" / "a.png")
    assert list(tmp_path.iterdir()) == []


def test_shortened_text_fits() -> None:
    assert shortened("short", 1.0, 7) == "short"
    cut = shortened("a very long name indeed", 0.5, 7)
    assert cut.endswith("…")
    assert text_width(cut, 7) <= 0.5


@pytest.mark.parametrize("x", [[0.3], [float("nan")], [-9.0]])
def test_degenerate_systems_can_be_drawn(x: list[float]) -> None:
    dot = Variable("dot", (1, 1), {"a": Triangle(0, 1, 2), "nowhere": Triangle(5, 6, 7)})
    fis = Sugeno([dot], [Variable("y", (2, 2), {"k": 2}), Variable("empty", (0, 1))], ["if dot is a then y is k"])
    for figure in (plot_memberships(fis), plot_surface(fis), plot_rules(fis, x), plot_structure(fis)):
        figure.draw_without_rendering()
    assert "nowhere: 0 everywhere" in texts(plot_memberships(fis, "dot"))
    with pytest.raises(FuzzySystemError, match="no rules to show"):
        plot_rules(Sugeno([dot], [Variable("y", (0, 1), {"k": 2})]), x)


def test_pyplot_is_not_touched() -> None:
    program = "import fuzzy.figures.plot, sys; assert 'matplotlib.pyplot' not in sys.modules"
    subprocess.run([sys.executable, "-c", program], check=True)
