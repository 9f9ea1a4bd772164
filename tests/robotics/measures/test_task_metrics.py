"""Metrics that a scenario's file names as those of its task: they come first, and alone where few are shown."""

import json
from pathlib import Path

import numpy as np
import pytest

from robotics.commands.application import main
from robotics.laws.catalogue import make_controller
from robotics.measures.registry import short_metrics
from robotics.show.report.plan import parse_study
from robotics.show.report.summarytable import leading_metric, printed_metrics, summary_table
from robotics.simulation.scenario.description import ScenarioError
from robotics.simulation.scenario.reading import load_scenario, parse_scenario
from robotics.studies.comparison import compare
from robotics.studies.inspection import inspect_scenario

METRIC = 'import numpy as np\n\ndef top(run):\n    """Largest speed."""\n    return np.nanmax(run["v"], axis=-1)\n'
BARE = """
[[robots]]
start = [0.0, 0.0, 0.0]
path = { shape = "line", start = [0.0, 0.0], end = [2.0, 0.0] }
timing = { speed = 0.2 }
"""
OBSTACLE = '[[obstacles]]\nshape = "disc"\nposition = [1.0, 2.0]\n'


def text(*metrics: str) -> str:
    return f"duration = 0.5\nmetrics = {json.dumps(metrics)}\n{BARE}{OBSTACLE}"


@pytest.fixture
def course(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """A scenario in a folder, and a metric of the user's own beside it."""
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "metric.py").write_text(METRIC, encoding="utf-8")
    file = tmp_path / "mine" / "course.toml"
    file.write_text(text("min_clearance_m", "metric.py:top", "max_cross_track_m"), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return "mine/course.toml"


def test_run_and_check_show_them_first_and_in_their_order(course, capsys):
    wanted = ["min_clearance_m", "top", "max_cross_track_m"]
    assert main(["run", course, "-c", "lyapunov", "-q", "--seeds", "2"]) == 0
    lines = [line.split()[0] for line in capsys.readouterr().out.splitlines()[1:]]
    assert lines[:3] == wanted
    assert "mean_abs_x_error_m" in lines
    assert main(["run", course, "-c", "lyapunov", "-q", "--json"]) == 0
    assert [*json.loads(capsys.readouterr().out)["metrics"]][:3] == wanted
    main(["check", course, "--json"])
    assert json.loads(capsys.readouterr().out)["metrics"] == wanted
    main(["check", course])
    assert "metrics of the task, which come first: min_clearance_m, top, max_cross_track_m" in capsys.readouterr().out


def test_a_comparison_prints_them_alone_and_the_first_says_who_leads(course):
    scenario = load_scenario(course)
    found = compare([scenario], ["fuzzy", "lyapunov"], range(2))
    np.testing.assert_array_equal(
        found.table["top"], [v for run in found.runs.values() for v in run["v"].max(-1).ravel()]
    )
    assert [*printed_metrics(found, scenario)] == ["min_clearance_m", "top", "max_cross_track_m"]
    assert leading_metric(found, scenario)[0] == "min_clearance_m"
    titles = [row.title for row in summary_table(found, "course").rows]
    assert titles[:3] == [metric.title for metric in printed_metrics(found, scenario).values()]
    assert len(titles) == len(set(titles)) > 15
    first = printed_metrics(found, scenario, ["rms_cross_track_m"])
    assert [*first] == ["rms_cross_track_m", "min_clearance_m", "top", "max_cross_track_m"]


def test_a_study_measures_what_its_scenarios_name(course, tmp_path):
    study = 'scenarios = ["course.toml"]\ncontrollers = ["lyapunov"]\nseeds = 1\n'
    plan = parse_study(study, "study", folder=tmp_path / "mine")
    assert [*plan.own_metrics] == ["top"]
    assert Path(plan.metrics_located["top"].removesuffix(":top")).samefile(tmp_path / "mine" / "metric.py")
    twice = parse_study(f'metrics = ["metric.py:top"]\n{study}', "study", folder=tmp_path / "mine")
    assert twice.metrics_located == {"top": f"{tmp_path / 'mine' / 'metric.py'}:top"}


@pytest.mark.parametrize(
    ("names", "message"),
    [
        (("top_sped",), "course.toml:2: unknown metric 'top_sped'"),
        (("contact",), "unknown metric 'contact'; did you mean 'contacts'? Known: mean_abs_x_error_m, "),
        (
            ("contacts", "goal_time_s"),
            "goal_time_s is one of scenarios of kind goal, not of tracking; measured there: ",
        ),
        (("contacts", "contacts"), "course.toml:2: the metric contacts is named twice"),
        (("nowhere.py:x",), "course.toml:2: nowhere.py: cannot be read"),
    ],
)
def test_what_is_no_metric_of_such_a_scenario_is_refused_on_its_line(names, message, tmp_path, capsys):
    with pytest.raises(ScenarioError) as raised:
        parse_scenario(text(*names), "course", "course.toml")
    assert message in str(raised.value)
    file = tmp_path / "course.toml"
    file.write_text(text(*names), encoding="utf-8")
    assert main(["check", str(file)]) == 1
    assert message.removeprefix("course.toml:2: ") in capsys.readouterr().out


def test_check_warns_of_a_metric_that_is_not_measured_and_headlines_stand_in_for_it():
    alone = parse_scenario(f'duration = 0.5\nmetrics = ["contacts"]\n{BARE}', "alone")
    (found,) = [f for f in inspect_scenario(alone, "lyapunov").findings if f.kind == "metric not measured"]
    assert (found.severity, found.at) == ("warning", ("metrics", 0))
    assert "settling_time_s" in short_metrics(alone)
    compared = compare([alone], {"lyapunov": make_controller("lyapunov")}, [0])
    assert leading_metric(compared, alone)[0] in short_metrics(alone)
