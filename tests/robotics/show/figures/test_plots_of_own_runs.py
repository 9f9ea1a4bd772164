"""Every kind of picture of ``robotics plot``, for runs that have what it shows, and for runs that lack it."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

import robotics
from fuzzy.inference import infer
from robotics.commands.application import main
from robotics.commands.plot import PLOT_KINDS
from robotics.measures.clearance import clearances
from robotics.plugins.encounters.distances import plot_distances
from robotics.plugins.encounters.modes import plot_modes, plot_sonar
from robotics.simulation.run import Run
from robotics.world.sensing.carried import sensor_names
from tests.drawn import x_of, y_of

WITHOUT_UNIT = {"robot", "progress s", "$s_i − s_j$", ""}
RUNS = {  # scenario, law, duration in s, seeds
    "team": ("three-cross", "fuzzy-team", 4.0, (3, 5)),
    "obstacles": ("trap-u", "obstacles", 13.0, (0,)),
    "formation": ("formation-behind", "formation", 3.0, (0,)),
    "single": ("lyapunov-sine", "fuzzy", 2.0, (0,)),
}
EXTRA = {"rules": ["--time", "1.5", "--robot", "1"], "errors": ["--robot", "1"], "sonar": ["--robot", "1"]}
# The runs that a kind refuses, and what it says
REFUSES = {
    "formation": ("team", 'three-cross is no formation but of the kind "team"'),
    "progress": ("single", "has no progress"),
    "distances": ("single", "one robot without obstacles has no distances to draw"),
    "meetings": ("single", "a run of one robot has no meetings"),
    "sonar": ("team", "kept no readings of range sensors"),
    "modes": ("single", "has no modes"),
    "rules": ("obstacles", "no rule bases that could be explained"),
}
SUITS = {"formation": "formation", "sonar": "obstacles", "modes": "obstacles"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the runs."""
    folder = tmp_path_factory.mktemp("runs")
    for name, (scenario, law, duration, seeds) in RUNS.items():
        setting = replace(robotics.load_scenario(scenario), duration=duration)
        robotics.simulate(setting, robotics.make_controller(law), seeds, name=law).save(folder / f"{name}.npz")
    return folder


def run_of(folder: Path, name: str) -> Run:
    return robotics.load_run(folder / f"{name}.npz")


def labelled(figure: Figure) -> None:
    """Every axes says what it shows along both axes, with units; those above others leave the x axis to them."""
    for ax in figure.axes:
        for label in (ax.get_xlabel(), ax.get_ylabel()):
            assert "[" in label or label in WITHOUT_UNIT, label
    beside = [*(ax.get_ylabel() for ax in figure.axes), *(text.get_text() for text in figure.texts)]
    assert any("[" in label for label in beside) or beside[0] == "robot"
    assert any("[" in ax.get_xlabel() for ax in figure.axes)


@pytest.mark.parametrize("kind", PLOT_KINDS)
def test_the_command_draws_every_kind(
    kind: str, folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[Figure] = []
    monkeypatch.setattr("fuzzy.figures.drawing.save_figure", lambda figure, path: made.append(figure))
    name = SUITS.get(kind, "team")
    seed = str(RUNS[name][3][-1])
    file, extra = str(folder / f"{name}.npz"), EXTRA.get(kind, [])
    assert main(["plot", file, "--kind", kind, "-o", str(tmp_path / "a.png"), "--seed", seed, *extra, "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed == {"file": str(tmp_path / "a.png"), "kind": kind, "scenario": RUNS[name][0]}
    if kind != "rules":  # whose columns have their units above them
        labelled(made[0])
    if kind in REFUSES:
        other, said = REFUSES[kind]
        assert main(["plot", str(folder / f"{other}.npz"), "-k", kind, "-o", str(tmp_path / "b.png"), *extra]) == 2
        err = capsys.readouterr().err
        assert said in err
        assert err.count("\n") == 1
    assert main(["plot", file, "-k", kind, "-o", str(tmp_path / "b.png"), "--seed", "77", *extra]) == 2
    assert "seed 77 is not among those of the run" in capsys.readouterr().err
    assert len(made) == 1


def test_a_picture_is_written_whole(folder: Path, tmp_path: Path) -> None:
    file = str(folder / "obstacles.npz")
    assert main(["plot", file, "-k", "modes", "-o", str(tmp_path / "modes.png")]) == 0
    assert [path.name for path in tmp_path.iterdir()] == ["modes.png"]
    assert (tmp_path / "modes.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["-k", "distance"], "unknown kind of picture 'distance'; did you mean 'distances'"),
        (["-k", "modes", "--robot", "2"], "--robot belongs to the kinds errors and velocities and sonar and rules"),
        (["-k", "rules"], "the kind rules needs --time S"),
        (["-k", "modes", "team.npz"], "the kind modes shows one run, got 2"),
        (["-k", "errors", "single.npz"], "the runs of one figure must be those of one scenario"),
        (["-k", "errors", "--robot", "4"], "three-cross has the robots 1 to 3, there is no robot 4"),
        (["-k", "rules", "--time", "99"], "the run lasts from 0 to 4 s; there is nothing at 99 s"),
        (["-k", "rules", "--time", "1", "--task", "trackin"], "did you mean 'tracking'"),
        (["-k", "run", "-o", "a.bmp"], "end it in .png, .pdf or .svg"),
    ],
)
def test_what_cannot_be_drawn_is_told_in_a_sentence(
    arguments: list[str], said: str, folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    given = [str(folder / word) if word.endswith(".npz") else word for word in arguments]
    out = [] if "-o" in arguments else ["-o", str(tmp_path / "a.png")]
    assert main(["plot", str(folder / "team.npz"), *given, *out]) == 2
    err = capsys.readouterr().err
    assert said in err
    assert "Traceback" not in err


def test_distances_are_those_between_the_centers(folder: Path) -> None:
    run = run_of(folder, "team")
    (ax,) = plot_distances(run, seed=5).axes
    named = {line.get_label(): line for line in ax.get_lines()}
    x, y = run["x"][1], run["y"][1]
    for i, j in ((0, 1), (0, 2), (1, 2)):
        wanted = np.hypot(x[i] - x[j], y[i] - y[j])
        np.testing.assert_allclose(y_of(named[f"$d_{{{i + 1}{j + 1}}}$"]), wanted)
    crowd = run_of(folder, "team")
    crowd = crowd.with_recorded(samples=np.concatenate([crowd.samples, crowd.samples + 10.0], axis=-1))
    about = replace(run.about, robots=run.about.robots * 2, sensors=run.about.sensors * 2)
    crowd = replace(crowd, about=about, stopped=np.tile(crowd.stopped, 2), paths=run.paths * 2)
    lines = [line for line in plot_distances(crowd).axes[0].get_lines() if len(x_of(line)) > 2]
    x, y = crowd["x"][0], crowd["y"][0]
    apart = np.hypot(x[:, None] - x, y[:, None] - y) + np.where(np.eye(6), np.inf, 0)[..., None]
    for line, wanted in zip(lines, apart.min(axis=1), strict=False):
        np.testing.assert_allclose(y_of(line), wanted)
    clear = plot_distances(run_of(folder, "obstacles")).axes[1]
    obstacles = run_of(folder, "obstacles")
    drawn = y_of(clear.get_lines()[0])
    np.testing.assert_allclose(drawn, clearances(obstacles, 0)[0][: len(drawn)])


def test_progress_says_who_is_at_fault_and_when() -> None:
    run = robotics.simulate(robotics.load_scenario("outage-20s"), "virtual-structure", seeds=[1])
    above, below = robotics.plot_progress(run).axes
    legend = above.get_legend()
    assert legend is not None
    assert [text.get_text() for text in legend.get_texts()] == ["robot 1", "robot 2", "robot 3"]
    assert [text.get_text() for text in above.texts] == ["2: failure", "3: delay"]
    for ax in (above, below):
        spans = [patch for patch in ax.patches if isinstance(patch, Rectangle) and patch.get_hatch()]
        assert [(patch.get_x(), patch.get_width()) for patch in spans] == [(15.0, 20.0), (30.0, 20.0)]


def test_times_on_a_scenario_are_written_once_where_robots_meet() -> None:
    (ax,) = robotics.plot_scenario(robotics.load_scenario("three-cross")).axes
    times = [text.get_text() for text in ax.texts if text.get_text()]
    assert [times.count(time) for time in ("7 s", "15 s", "22 s", "30 s", "37 s")] == [3, 3, 1, 3, 3]


def test_sonar_and_modes_are_those_recorded(folder: Path) -> None:
    run = run_of(folder, "obstacles")
    assert run.ranges is not None
    assert run.modes is not None
    names = sensor_names(run.about.sensors)
    panels = plot_sonar(run).axes
    assert len(panels) == 3
    for robot, ax in enumerate(panels):
        for line in ax.get_lines()[: len(names)]:
            read = run.ranges[:, 0, robot, names.index(str(line.get_label()))].astype(float)
            np.testing.assert_array_equal(y_of(line), np.where(np.isfinite(read), read, np.nan)[: len(x_of(line))])
    with pytest.raises(robotics.PlotError, match="robot 7 carries no range sensors; those that do are 1, 2, 3"):
        plot_sonar(run, robot=7)
    (ax,) = plot_modes(run).axes
    legend = ax.get_legend()
    assert legend is not None
    words = [text.get_text() for text in legend.get_texts()]
    assert len(words) == len(set(words)) >= 2
    avoiding = next(line for line in ax.get_lines() if line.get_label() == "avoiding")
    assert np.isfinite(y_of(avoiding)).sum() == (run.modes[: len(x_of(avoiding)), 0, 0] & 3 == 1).sum()


def test_rules_at_a_time_are_those_of_the_recorded_inputs(folder: Path) -> None:
    run = run_of(folder, "team")
    assert run.inputs is not None
    assert run.about.rule_bases is not None
    figure = robotics.plot_rules_at(run, 2.0, robot=2, seed=5)
    k = int(np.searchsorted(run.time, 2.0 + 1e-9, side="right")) - 1
    task, fis = next(iter(run.about.rule_bases.items()))
    x = run.inputs[k, : len(fis.inputs), 1, 1].astype(float)
    strengths = {f"{value:.3f}" for value in infer(replace(fis, out_of_range="ignore"), x).firing if value > 0}
    texts = {text.get_text() for ax in figure.axes for text in ax.texts}
    assert strengths & texts
    assert figure.texts[0].get_text() == f"Fuzzy team on three-cross, seed 5: {task}, robot 2 at 2 s"


def test_every_picture_of_runs_is_public() -> None:
    for kind in PLOT_KINDS.values():
        assert kind.function in dir(robotics)
        about = getattr(robotics, kind.function).__doc__ or ""
        assert "Raises" in about
        assert "seed" in about
