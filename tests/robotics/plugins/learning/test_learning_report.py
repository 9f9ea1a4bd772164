"""The page of ``robotics learn formation --report``: end to end, its numbers against their definitions."""

import base64
import json
import re
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

import anfis
from fuzzy.files.fisfile import read_fis
from fuzzy.files.table import read_table, write_table
from robotics.commands.application import main
from robotics.measures.formations import leads, place_error
from robotics.plugins.learning.datatable import Samples
from robotics.plugins.learning.figures import plot_search_and_epochs, plot_shares, plot_stages
from robotics.plugins.learning.formation_run import plot_formation
from robotics.plugins.learning.formationdata import FormationRecipe, checking_recipe, formation_data
from robotics.plugins.learning.formationlearning import Errors, Learnt, learn_network
from robotics.plugins.learning.report import (
    LearningReportError,
    errors_of,
    fit_of,
    learning_chapters,
    remarks,
    write_learning_report,
)
from robotics.show.figures.drawing import PlotError
from robotics.simulation.run import Run
from tests.drawn import faults_of, x_of, y_of
from tests.robotics.show.report.test_report import Page

OUTPUTS = ("v_l", "w_l", "v_f", "w_f")
SHORT = """
kind = "formation"
title = "three in a row"
duration = 6.0
[sensing]
posture = "pose"
position_noise = 0.001
"""
ROBOT = """
[[robots]]
start = [{start}, {side}, 0.0]
path = {{ shape = "line", start = [-1.0, {side}], end = [3.0, {side}] }}
timing = {{ speed = 0.1 }}
"""


@pytest.fixture(autouse=True)
def coarse_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("robotics.show.report.plates.DPI", 25)


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a small table, its checking table and a scenario."""
    folder = tmp_path_factory.mktemp("own")
    recipe = FormationRecipe(kind="well-posed", samples=30)
    for name, table in (("own.csv", formation_data(recipe)), ("check.csv", formation_data(checking_recipe(recipe)))):
        write_table(folder / name, table.names, table.values)
    robots = [ROBOT.format(start=start, side=side) for start, side in ((-1.0, 0.0), (0.0, 1.0), (0.0, -1.0))]
    (folder / "short.toml").write_text(SHORT + "".join(robots), encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def network(data: Path) -> tuple[Learnt, Samples, Samples]:
    own, check = read_table(data / "own.csv"), read_table(data / "check.csv")
    names, values, held = own.names, own.values, check.values
    assert names is not None
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        learnt = learn_network("v_l", names, values, held, options=anfis.Options(epochs=2))
    return learnt, Samples("own.csv", names, values), Samples("check.csv", names, held)


@pytest.mark.long
def test_the_command_writes_one_page_that_needs_nothing_else(
    data: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    for slow in ("plot_stages", "plot_premises"):  # other tests draw them
        monkeypatch.setattr(f"robotics.plugins.learning.report.{slow}", lambda *_: Figure(figsize=(1, 1)))
    page, out = data / "deep" / "page.html", data / "networks"
    command = ["learn", "formation", str(data / "own.csv"), "--check", str(data / "check.csv"), "-o", str(out)]
    command += ["--epochs", "1", "--report", str(page), "--title", "Mine & <yours>", "--json", "-q"]
    command += ["--drive", str(data / "short.toml"), "--seeds", "2"]
    assert main(command) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed["report"] == str(page)
    assert [path.name for path in page.parent.iterdir()] == ["page.html"]  # no other file, no temporary one
    text = page.read_text(encoding="utf-8")
    read = Page(text)
    assert "Mine & <yours>" in read.words
    assert not [t for t in read.tags if t[1].get("src", "data:").partition(":")[0] not in ("data", "")]
    assert not read.all("link")
    images = [base64.b64decode((i["src"] or "").partition(",")[2]) for i in read.all("img")]
    assert len(images) == 1 + 3 * len(OUTPUTS) + 1  # shares; search, fit, memberships of each; the drive
    assert all(image.startswith(b"RIFF") and image[8:16] == b"WEBPVP8L" for image in images)
    assert all(i["alt"] for i in read.all("img"))
    assert len([t for t in read.tags if "data-fleet-player" in t[1]]) == 1
    for word in ("thesis", "mehrjerdi", "(5.9)"):
        assert word not in re.sub(r"base64,[A-Za-z0-9+/=]+", "", text).lower()
    ids = {t[1]["id"] for t in read.tags if t[1].get("id")}
    assert {(a["href"] or "")[1:] for a in read.all("a")} <= ids
    # The table of errors, from the files that were written
    own, check = read_table(data / "own.csv"), read_table(data / "check.csv")
    x, names, held = own.values, own.names, check.values
    for output in OUTPUTS:
        fis = read_fis(out / f"{output}.fis")
        wanted = []
        for table in (x, held):
            inputs = np.stack([table[:, names.index(v.name)] for v in fis.inputs], axis=1)
            y = table[:, names.index(output)]
            wanted.append(np.sqrt(np.mean((fis(inputs)[:, 0] - y) ** 2)))
        row = re.search(rf'<th scope="row">{output} \[.*?</tr>', text, re.S)
        assert row is not None
        cells = [c.replace("−", "-") for c in re.findall(r"<td>(.*?)</td>", row.group())]
        np.testing.assert_allclose([float(cells[3]), float(cells[4])], wanted, rtol=5e-3)
        share = 100 * wanted[1] / np.ptp(x[:, names.index(output)])
        assert float(cells[5].removesuffix(" %")) == pytest.approx(share, rel=0.05)


def test_errors_pictures_and_their_numbers(network: tuple[Learnt, Samples, Samples]) -> None:
    learnt, samples, check = network
    errors = errors_of(learnt, samples, check)
    x = samples.values[:, [samples.names.index(v.name) for v in learnt.after.inputs]]
    y = samples.values[:, samples.names.index("v_l")]
    assert errors.training == pytest.approx(learnt.training.history[learnt.training.best].train, rel=1e-6)
    held = check.values[:, [check.names.index(v.name) for v in learnt.after.inputs]]
    target = check.values[:, check.names.index("v_l")]
    wanted = learnt.training.history[learnt.training.best].check  # beyond the training samples it goes on
    free = replace(learnt.after, out_of_range="ignore")
    assert np.sqrt(np.mean((free(held)[:, 0] - target) ** 2)) == pytest.approx(wanted, rel=1e-6)
    clipped = np.clip(held, x.min(axis=0), x.max(axis=0))  # as it drives
    assert errors.checking == pytest.approx(np.sqrt(np.mean((free(clipped)[:, 0] - target) ** 2)), rel=1e-9)
    assert errors.clustering == pytest.approx(learnt.trial.rmse[0], rel=1e-6)
    assert errors.range == y.max() - y.min()
    inside = [all(x[:, k].min() <= row[k] <= x[:, k].max() for k in range(x.shape[1])) for row in held]
    assert errors.outside == pytest.approx(1 - np.mean(inside))
    figure = plot_stages({"training": fit_of(learnt, samples)})
    over, below, against = figure.axes
    order = np.argsort(y, kind="stable")  # the set is no run: samples jump
    np.testing.assert_array_equal(y_of(over.get_lines()[0]), y[order])
    np.testing.assert_array_equal(y_of(over.get_lines()[2]), learnt.after(x)[order, 0])
    np.testing.assert_allclose(y_of(below.get_lines()[2]), (learnt.after(x)[:, 0] - y)[order])
    np.testing.assert_array_equal(x_of(against.get_lines()[2]), y)
    assert over.get_ylabel() == "v_l [m/s]"
    left, right = plot_search_and_epochs(learnt.search, learnt.training.history, "m/s").axes
    assert right.get_ylabel() == "RMSE [m/s]"
    np.testing.assert_array_equal(y_of(right.get_lines()[0]), [row.train for row in learnt.training.history])
    assert left.get_xlabel() == "number of rules"


def test_remarks_tell_what_stands_out(network: tuple[Learnt, Samples, Samples]) -> None:
    learnt, samples, check = network
    rng = np.random.default_rng(0)
    column = samples.names.index("v_l")
    noisy = samples.values.copy()
    noisy[:, column] += rng.normal(0, 0.2, len(noisy))
    said = " ".join(remarks(errors_of(learnt, samples._replace(values=noisy), check)))
    assert "these inputs do not tell it" in said
    far = check.values.copy()
    far[:, 0] += 20.0
    said = " ".join(remarks(errors_of(learnt, samples, check._replace(values=far))))
    assert "100 % of the checking samples have an input beyond" in said
    assert "times the training error" in said
    few = errors_of(learnt, samples._replace(values=samples.values[:20]))
    assert np.isnan(few.scatter).all()
    assert np.isnan(few.checking)
    figure = plot_shares(
        [
            Errors(learnt, 0.2, 0.1, 0.16, 2.0, (0.02, 0.0, 0.04), np.nan),
            Errors(learnt, 0.3, 0.2, 0.25, 1.0, (np.nan, np.nan, np.nan), np.nan),
        ]
    )
    marks = {line.get_label(): line for line in figure.axes[0].get_lines()}
    np.testing.assert_allclose(x_of(marks["after learning, training"]), [5.0, 20.0])
    assert figure.axes[0].get_xlabel() == "RMSE [% of the output's range]"


def test_many_networks_are_folded_and_a_missing_column_is_told(
    network: tuple[Learnt, Samples, Samples], tmp_path: Path
) -> None:
    learnt, samples, check = network
    chapters = learning_chapters([learnt] * 7, samples)
    assert [c.closed for c in chapters] == [False, False, *[True] * 7]
    assert len({p.name for c in chapters for p in c.pictures}) == 1 + 7 * 3
    keep = [k for k, name in enumerate(check.names) if name != "alpha_l"]
    cut = Samples("cut.csv", tuple(check.names[k] for k in keep), check.values[:, keep])
    with pytest.raises(LearningReportError, match=r"cut\.csv: the networks need its column alpha_l; it has dx"):
        write_learning_report(tmp_path / "page.html", [learnt], samples, cut)
    assert not list(tmp_path.iterdir())


def test_a_formation_of_a_run(data: Path) -> None:
    run = driven(data)
    figure = plot_formation(run)
    top, lead, off, away, v, w, right, left = figure.axes
    shown = len(y_of(lead.get_lines()[-1]))
    np.testing.assert_array_equal(y_of(lead.get_lines()[1]), leads(run)[0, :shown])
    np.testing.assert_array_equal(y_of(away.get_lines()[2]), place_error(run)[0, 1, :shown])
    half = run.about.robots[0].half_axle
    for ax, sign in ((right, 1), (left, -1)):
        wanted = run["v"][0, 0] + sign * half * run["w"][0, 0]
        np.testing.assert_allclose(y_of(ax.get_lines()[1])[:5], wanted[:5])
    labels = [ax.get_ylabel() for ax in (top, lead, off, away, v, w, right, left)]
    assert all("[" in label for label in labels)
    assert lead.get_xlim()[0] == 0.0
    assert not faults_of(figure)
    first, *others = [line for line in v.get_lines() if line.get_linewidth() >= 1.0 and len(x_of(line)) > 2]
    assert all(first.get_linewidth() > line.get_linewidth() for line in others)  # none is wholly covered
    with pytest.raises(PlotError, match='short is no formation but of the kind "team"'):
        plot_formation(replace(run, about=replace(run.about, kind="team", controller="cooperation")))
    plot_formation(replace(run, about=replace(run.about, kind="team")))


def test_networks_of_single_robots_are_found_in_their_columns() -> None:
    """Tables of a scenario name columns by robot; what a robot's networks know has no number in them."""
    rng = np.random.default_rng(3)
    own = rng.uniform(-1, 1, (120, 4))
    speeds = [0.2 + 0.1 * np.tanh(own[:, 0]), 0.5 * own[:, 1], 0.2 - 0.1 * own[:, 2], own[:, 3] ** 3]
    names = ("leader_ahead_1", "onward_bearing_1", "leader_ahead_2", "onward_bearing_2", "v_1", "w_1", "v_2", "w_2")
    samples = Samples("own.csv", names, np.column_stack([own, *speeds]))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        options = anfis.Options(method="least-squares", epochs=1)
        learnt = [learn_network(o, names, samples.values, rules=4, options=options) for o in ("v_1", "w_2")]
    first, second = (errors_of(network, samples) for network in learnt)
    assert [v.name for v in learnt[0].after.inputs] == ["leader_ahead"]
    found = learnt[0].after(own[:, :1])[:, 0]
    assert first.training == pytest.approx(np.sqrt(np.mean((found - speeds[0]) ** 2)))
    assert second.range == np.ptp(speeds[3])
    chapters = {chapter.name: chapter for chapter in learning_chapters(learnt, samples)}
    roles = {row[0]: row[2] for row in chapters["data"].tables[0].rows}
    assert roles["leader_ahead_1"] == "input of v_1"
    assert roles["onward_bearing_2"] == "input of w_2"
    assert roles["leader_ahead_2"] == roles["v_2"] == "not used"
    units = {row[0]: row[1] for row in chapters["data"].tables[0].rows}
    assert (units["leader_ahead_1"], units["w_2"], units["v_2"]) == ("m", "rad/s", "–")


def driven(data: Path) -> Run:
    from robotics.laws.catalogue import make_controller
    from robotics.simulation.loop import simulate
    from robotics.simulation.scenario.reading import load_scenario

    return simulate(load_scenario(str(data / "short.toml")), make_controller("formation"), [0], name="formation")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--report", "page.txt"], "page.txt: the file's name must end in .html"),
        (["--drive", "formation-behind"], "--drive belongs to --report PAGE.html"),
        (["--title", "Mine"], "--title belongs to --report PAGE.html"),
        (["--report", "page.html", "--drive", "formation-behnd"], "did you mean 'formation-behind'"),
    ],
)
def test_a_wrong_wish_is_told_before_anything_is_learnt(
    arguments: list[str], said: str, data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "networks"
    assert main(["learn", "formation", str(data / "own.csv"), "-o", str(out), *arguments, "-q"]) == 2
    err = capsys.readouterr().err
    assert said in err
    assert "Traceback" not in err
    assert not out.exists()


def test_fewer_rules_that_do_as_well_are_named(network: tuple[Learnt, Samples, Samples]) -> None:
    learnt, samples, check = network
    errors = {rules: trial.error for rules, trial in learnt.search.by_rules.items()}
    for rules, trial in learnt.search.by_rules.items():
        taken = replace(learnt, trial=trial)
        enough = min(n for n, error in errors.items() if error <= 1.02 * errors[rules])
        assert (taken.fewer.rules if taken.fewer else rules) == enough
        said = f"{enough} rules do as well after clustering"
        assert any(remark.startswith(said) for remark in taken.remarks) == (enough < rules)
        assert any(said in remark for remark in remarks(errors_of(taken, samples, check))) == (enough < rules)
