"""Metrics of the user's own: measured, tabulated and shown as those of the package."""

import json
from importlib.metadata import EntryPoint
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest

from robotics.commands.application import main
from robotics.laws.catalogue import make_controller
from robotics.laws.law import ControllerError
from robotics.laws.tracking.lyapunov import Lyapunov
from robotics.measures import own
from robotics.measures.own import MetricError, metric
from robotics.measures.registry import headlines, measure_all, own_metrics
from robotics.measures.tracking import Metric
from robotics.plugins.designer.tryout import TryoutTrial, rival_data
from robotics.show.figures.comparison import plot_comparison
from robotics.show.report.summarytable import summary_table
from robotics.simulation.loop import simulate
from robotics.simulation.scenario.reading import parse_scenario
from robotics.studies.comparison import ComparisonError, compare, summarise
from tests.robotics.laws.test_laws_in_files import SCENARIO

METRICS = '''
import numpy as np
from robotics import Metric, metric

@metric(unit="m/s", title="largest speed", larger=True)
def top_speed(run):
    return np.nanmax(run["v"], axis=-1)

def comfort(run):
    """The largest demanded acceleration. It is felt."""
    return np.nanmax(np.abs(np.diff(run["v_demand"], axis=-1)), axis=-1) / (run.time[1] - run.time[0])

spread = Metric(lambda run: np.full(run.stopped.shape, 2.0), "1", "two")
'''


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.py").write_text(METRICS, encoding="utf-8")
    (tmp_path / "short.toml").write_text(SCENARIO, encoding="utf-8")
    return tmp_path


@pytest.fixture(scope="module")
def run():
    return simulate(parse_scenario(SCENARIO, "short"), make_controller("lyapunov"), (3, 5))


def top(run):
    return run["v"].max(axis=-1)


def test_functions_in_files_and_as_they_are_are_measured_after_all_others(folder, run):
    found = measure_all(run, ["mine.py:top_speed", top, ("also", top)])
    assert [*found][-3:] == ["top_speed", "top", "also"]
    for name in ("top_speed", "top", "also"):
        np.testing.assert_array_equal(found[name], run["v"].max(axis=-1))
    assert [*measure_all(run)] == [*found][:-3]
    assert [*measure_all(run, {"mine": top})][-1] == "mine"


def test_what_a_metric_says_of_itself(folder):
    mine = own_metrics(["mine.py:top_speed", "mine.py:comfort", "mine.py:spread"])
    assert [(m.unit, m.title, m.short, m.larger) for m in mine.values()] == [
        ("m/s", "largest speed", "top speed", True),
        ("–", "The largest demanded acceleration. It is felt", "comfort", False),
        ("1", "two", "spread", False),
    ]
    assert [*headlines("team", own=mine)][-3:] == [*mine]
    top.unit, top.title = "m/s", "speed"  # type: ignore[attr-defined]
    assert own_metrics([top])["top"][1:3] == ("m/s", "speed")


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (["mine.py:top_sped"], "mine.py: unknown metric 'top_sped'; did you mean 'top_speed'?"),
        (["mine.py"], "mine.py: one metric is needed, a function of a run; it has top_speed, spread: say which"),
        (["nowhere.py:x"], "nowhere.py: cannot be read: No such file"),
        (["comfort"], "unknown metric 'comfort'. Known: (none); or a file: mymetric.py:comfort"),
        (["mine.py:np"], "the metric np must be a robotics.Metric, or a function of a run; got <module 'numpy'"),
        ([top, top], "the metric top is given twice"),
        ([lambda run: 1], "a metric needs a name"),
        ([("settling_time_s", top)], "settling_time_s has the name of one that comes with fuzzyfleet"),
        ([("robot", top)], "robot has the name of one that comes with fuzzyfleet"),
        ([("odd", Metric(top, "1", "odd", kinds=("tame",)))], "odd: unknown kind of scenarios 'tame'"),
    ],
)
def test_a_metric_that_there_is_not_is_refused_with_a_sentence(folder, given, message):
    with pytest.raises(MetricError) as raised:
        own_metrics(given)
    assert message in str(raised.value)


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("return run.nothing", "bad.py:2: AttributeError: 'Run' object has no attribute 'nothing' (in the metric bad)"),
        ("return 1.0", "bad.py: the metric bad must give one number for each run and robot, (2, 1); got the shape ()"),
        ("return run['v'].max(-1)[0]", "(2, 1); got the shape (1,)"),
        ("return run['v'].max(-1) * float('nan')", "bad.py: the metric bad is not a number for seed 3, robot 1"),
        ("return (run['v'].max(-1) > 9).astype(str)", "must give numbers; got <U5"),
    ],
)
def test_a_metric_that_fails_is_one_sentence_with_file_and_name(folder, run, body, message):
    (folder / "bad.py").write_text(f"def bad(run):\n    {body}\n", encoding="utf-8")
    with pytest.raises(MetricError) as raised:
        measure_all(run, ["bad.py:bad"])
    assert message in str(raised.value)


def test_a_field_that_a_metric_has_not_is_refused_at_the_decorator():
    with pytest.raises(MetricError, match="unknown field of a metric 'lager'; did you mean 'larger'"):
        metric(unit="1", lager=True)


def test_another_package_brings_a_metric(monkeypatch, run, capsys):
    entries = [
        EntryPoint(name="top", value=f"{__name__}:top", group=own.METRIC_GROUP),
        EntryPoint(name="gone", value="nowhere_at_all:top", group=own.METRIC_GROUP),
    ]
    monkeypatch.setattr(own, "entry_points", lambda group: entries)
    own.installed_metrics.cache_clear()
    try:
        np.testing.assert_array_equal(measure_all(run, ["top"])["top"], top(run))
        with pytest.raises(MetricError, match="the metric 'gone' of nowhere_at_all:top cannot be used: ModuleNotFound"):
            own_metrics(["gone"])
        assert main(["list", "metrics"]) == 0
        said = capsys.readouterr()
        assert "measured if asked for: --metric top" in " ".join(said.out.split())
        assert "the metric 'gone' of nowhere_at_all:top cannot be used" in said.err
        tried_out = rival_data("lyapunov", TryoutTrial(scenario="own.toml", text=SCENARIO))
        assert [*tried_out["metrics"]][-1] == "top"
    finally:
        monkeypatch.undo()
        own.installed_metrics.cache_clear()


def test_objects_are_compared_and_shown_like_what_is_packaged():
    scenario = parse_scenario(SCENARIO, "short")
    made = compare(
        [scenario], ["lyapunov", ("brisk", Lyapunov(kx=2.0)), Lyapunov(kx=3.0)], (0, 1), metrics={"top": top}
    )
    same = compare(
        [scenario],
        {"lyapunov": "lyapunov", "brisk": make_controller("lyapunov:kx=2"), "Lyapunov": "lyapunov:kx=3"},
        (0, 1),
    )
    pd.testing.assert_frame_equal(made.table.drop(columns="top"), same.table)
    rows = summarise(made.table, made.metrics).set_index(["controller", "metric"])["mean"]
    assert rows["brisk", "top"] == pytest.approx(top(made.runs["short", "brisk"]).mean(), rel=1e-12)
    table = summary_table(made, "short")
    assert table.controllers == ["Lyapunov", "brisk", "Lyapunov"]
    assert len(table.rows) == len(summary_table(same, "short").rows) + 1
    labels = [ax.get_xlabel() for ax in plot_comparison(made).axes]
    assert any(text.startswith(made.metrics["top"].title) for text in labels)


@pytest.mark.parametrize(
    ("controllers", "fault", "message"),
    [
        ([("lyapunov", Lyapunov(kx=2.0))], ControllerError, "'lyapunov' is another law than the catalogue's"),
        ([Lyapunov], ControllerError, r"a controller is a specification, a law, or a pair \(name, law\); got <class"),
        ({"mine": 3}, ControllerError, "'mine' must be a law or a specification; got 3"),
        (["csm", ("csm", "csm")], ComparisonError, "controller 'csm' is given twice"),
    ],
)
def test_what_is_no_controller_is_refused(controllers, fault, message):
    with pytest.raises(fault, match=message):
        compare([parse_scenario(SCENARIO, "short")], controllers, (0,))


def test_a_run_a_comparison_and_a_sweep_show_it(folder, capsys):
    assert main(["run", "short.toml", "-c", "lyapunov", "--metric", "mine.py:top_speed", "-q"]) == 0
    assert "m/s      largest speed" in capsys.readouterr().out.splitlines()[-1]
    line = ["compare", "short.toml", "--controllers", "lyapunov", "--metric", "mine.py:top_speed", "--seeds", "2", "-q"]
    assert main([*line, "--no-report"]) == 0
    assert "top speed" in capsys.readouterr().out
    rows = pd.read_csv("out/results.csv")
    about = json.loads(Path("out/configuration.json").read_text(encoding="utf-8"))
    assert (about["metrics"], [*about["files_sha256"]]) == (["top_speed"], ["mine.py"])
    sweep = 'scenario = "../short.toml"\ncontrollers = ["lyapunov"]\nseeds = 2\nmetrics = ["../mine.py:top_speed"]\n'
    (folder / "swept").mkdir()
    (folder / "swept" / "one.toml").write_text(sweep, encoding="utf-8")
    assert main(["sweep", "swept/one.toml", "--metric", "mine.py:comfort", "--out", "out", "-q"]) == 0
    table = pq.read_table("out/results.parquet").to_pandas()
    np.testing.assert_array_equal(table["top_speed"], rows["top_speed"])
    assert (table["comfort"] > 0).all()
    files = json.loads(Path("out/pieces/plan.json").read_text(encoding="utf-8"))["files_sha256"]
    assert {*files} == {"../mine.py", "mine.py", "../short.toml"}


def test_what_is_wrong_is_said_before_anything_runs(folder, capsys):
    (folder / "wrong.toml").write_text('scenario = "short.toml"\ncontrollers = ["csm"]\nmetrics = ["x.py:y"]\n')
    team = "import robotics\n@robotics.metric(unit='1', kinds=('team',))\ndef late(run):\n    return run['v'][..., 0]\n"
    (folder / "team.py").write_text(team, encoding="utf-8")
    for line, message in (
        (["sweep", "wrong.toml"], "wrong.toml:3: x.py: cannot be read"),
        (["run", "short.toml", "--metric", "team.py:late"], "late is one of scenarios of kind team, not of tracking"),
        (["compare", "short.toml", "--metric", "team.py:late"], "late is one of scenarios of kind team"),
        (["run", "short.toml", "-c", "csm", "--law", "mylaw.py:MyLaw"], "give --controller or --law, not both"),
    ):
        assert main([*line, "-q"]) == 2
        assert message in capsys.readouterr().err
