"""A run with a contact is marked wherever its numbers or its path are shown, and is never the best."""

import json

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest

from robotics.commands.application import main
from robotics.laws.catalogue import make_controller
from robotics.measures.contacts import contacts, judge
from robotics.plugins.designer.tryout import TryoutTrial, choices, course_data, rival_data
from robotics.plugins.encounters.avoidance import plot_avoidance
from robotics.plugins.films.scene import set_scene, show_frame
from robotics.show.figures.controllers import plot_paths
from robotics.show.figures.run import plot_run
from robotics.show.playback.player import player_data
from robotics.show.playback.replay import replay
from robotics.show.report.page import write_report
from robotics.show.report.summarytable import summary_table
from robotics.simulation.loop import simulate
from robotics.simulation.scenario.reading import load_scenario, parse_scenario
from robotics.studies.comparison import compare, contact_runs, rows_of, summarise

# Two robots whose paths cross; the one that ignores the other is quicker, and runs into it. And a box beside the first.
CROSS = """
kind = "team"
duration = 36.0
[[robots]]
start = [0.0, 0.0, 0.0]
path = { shape = "line", start = [0.0, 0.0], end = [4.0, 0.0] }
timing = { duration = 20.0 }
[[robots]]
start = [2.0, -2.0, 1.5707963]
path = { shape = "line", start = [2.0, -2.0], end = [2.0, 2.0] }
timing = { duration = 20.0 }
"""
# A single robot that drives along a thin wall which its corner scrapes
SCRAPE = """
duration = 8.0
[[robots]]
start = [0.0, 0.0, 0.0]
path = { shape = "line", start = [0.0, 0.0], end = [2.0, 0.0] }
timing = { duration = 6.0 }
[[obstacles]]
shape = "wall"
points = [[1.0, 0.05], [1.0, 1.0]]
"""
NAMES = ("cooperation", "right-of-way")


@pytest.fixture(scope="module")
def comparison():
    return compare([parse_scenario(CROSS, "cross")], NAMES, range(3))


@pytest.fixture(scope="module")
def touched(comparison):
    return comparison.runs["cross", "cooperation"]


def test_the_table_has_a_column_that_marks_the_run_and_the_metrics(comparison):
    table = comparison.table
    marked = table.groupby("controller")["contact"].agg(["min", "max"])
    assert marked.loc["cooperation"].tolist() == [True, True]
    assert marked.loc["right-of-way"].tolist() == [False, False]
    assert contact_runs(table, "cross", "cooperation") == (3, 3)
    assert contact_runs(table, "cross", "right-of-way") == (0, 3)
    means = summarise(table).set_index(["controller", "metric"])["mean"]
    assert means["cooperation", "contacts"] >= 1
    assert means["cooperation", "min_clearance_m"] < 0 < means["right-of-way", "min_clearance_m"]
    assert np.isinf(means["cooperation", "arrival_time_s"])
    assert "contact" not in rows_of(simulate(load_scenario("reference"), make_controller("lyapunov")))


def test_a_controller_with_a_contact_is_never_marked_lowest(comparison):
    found = summary_table(comparison, "cross")
    assert found.contacts == [(3, 3), (0, 3)]
    assert all(row.cells[0].mark == "" for row in found.rows)
    effort = next(row for row in found.rows if row.title.startswith("total variation of the torques"))
    assert effort.cells[1].mark == "lowest"
    table = comparison.table.set_index("controller")["torque_variation_nmps"]
    assert table["cooperation"].mean() < table["right-of-way"].mean()  # it would be, by its number


@pytest.mark.long
def test_the_report_marks_it(comparison, tmp_path, monkeypatch):
    monkeypatch.setattr("robotics.show.report.plates.DPI", 30)
    page = write_report([comparison], [], tmp_path).read_text(encoding="utf-8")
    assert page.count("✕ contact in 3 of 3 runs") == 1
    assert "runs with a contact</th><td>3 of 3</td><td>0 of 3</td>" in page
    assert "never marked lowest" in page


def test_terminal_tables_and_files_mark_it(tmp_path, capsys):
    file = tmp_path / "cross.toml"
    file.write_text(CROSS)
    assert main(["run", str(file), "-c", "cooperation", "--seeds", "2", "-q"]) == 0
    shown = capsys.readouterr().out
    assert "✕ contact in 2 of 2 runs" in shown
    assert "seed 0: robots 1 and 2 touch at t = " in shown
    assert main(["run", str(file), "-c", "cooperation", "--json", "-q"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["metrics"]["contacts"] == [[1.0, 1.0]]
    assert told["metrics"]["min_clearance_m"][0][0] == pytest.approx(-told["contacts"][0]["depth_m"], abs=1e-9)
    assert {"seed": 0, "robot": 1, "other": 2}.items() <= told["contacts"][0].items()
    out = ["--out", str(tmp_path / "out"), "--no-report", "-q"]
    assert main(["compare", str(file), "--controllers", ",".join(NAMES), "--seeds", "1", *out]) == 0
    shown = capsys.readouterr().out
    assert "✕ Fuzzy cooperation: contact in 1 of 1 runs" in shown
    assert "✕ Right of way" not in shown
    assert pd.read_csv(tmp_path / "out" / "results.csv")["contact"].tolist() == [True, True, False, False]
    sweep = tmp_path / "sweep.toml"
    sweep.write_text('scenario = "cross.toml"\ncontrollers = ["cooperation"]\nseeds = 2\n')
    assert main(["sweep", str(sweep), "--out", str(tmp_path / "swept"), "-q"]) == 0
    assert "✕ contact in 2 of 2 runs" in capsys.readouterr().out
    found = pd.read_parquet(tmp_path / "swept" / "results.parquet")
    assert found["contact"].all()
    assert (found["min_clearance_m"] < 0).all()


def test_a_tracking_robot_that_scrapes_a_wall_is_marked_too(tmp_path, capsys):
    file = tmp_path / "scrape.toml"
    file.write_text(SCRAPE)
    assert main(["run", str(file), "-c", "lyapunov", "--json", "-q"]) == 0
    shown = capsys.readouterr()
    told = json.loads(shown.out)
    assert told["metrics"]["contacts"] == [1.0]
    assert told["contacts"][0]["obstacle"] == 1
    assert (told["contacts"][0]["x_m"], told["contacts"][0]["y_m"]) == pytest.approx((1.0, 0.08), abs=0.05)
    assert "lyapunov drives blind" in shown.err


def labels(figure):
    names = [t.get_text() for legend in figure.legends for t in legend.get_texts()]
    return names + [t.get_text() for ax in figure.axes if ax.get_legend() for t in ax.get_legend().get_texts()]


def test_pictures_mark_where_it_began(comparison, touched):
    (contact,) = contacts(touched, 0)
    assert np.hypot(contact.x - 2.0, contact.y) < 0.4  # where the paths cross
    free = comparison.runs["cross", "right-of-way"]
    for figure in (plot_run(touched), plot_paths([touched, free]), plot_avoidance([touched])):
        assert "contact" in labels(figure)
        (mark,) = [x for ax in figure.axes[:1] for x in ax.lines if x.get_label() == "contact"]
        assert np.asarray(mark.get_xydata()).ravel().tolist() == [contact.x, contact.y]
        plt.close(figure)
    for figure in (plot_run(free), plot_paths([free])):
        assert "contact" not in labels(figure)
        plt.close(figure)


def test_moving_pictures_show_it_from_its_begin_on(touched):
    (contact,) = contacts(touched, 0)
    assert player_data(touched)["contacts"] == [
        [*(round(v, 4) for v in (contact.start, contact.end, contact.x, contact.y, contact.depth)), "robots 1 and 2"]
    ]
    later = player_data(touched, start=contact.end + 1)
    assert later["contacts"] == []
    film = replay(touched, touched.time[::4])
    scene = set_scene(film, 1.0, 60)
    for time, count in ((contact.start - 0.1, 0), (contact.start + 0.1, 1), (touched.time[-1], 1)):
        show_frame(scene, time)
        assert np.asarray(scene.touches.get_xydata()).shape[0] == count
    plt.close(scene.figure)


def test_try_it_tells_of_it_and_knows_who_must_not_be_best():
    trial = TryoutTrial(scenario="obstacles-on-two-paths")
    blind = rival_data("graph-esm", trial)
    assert blind["metrics"]["contacts"] > 0 > blind["metrics"]["min_clearance_m"]
    assert any("drives blind" in warning for warning in blind["warned"])
    (kind, said) = blind["outcomes"][0]
    assert (kind, said.partition(" = ")[0]) == ("contact", "robot 1 and obstacle 1 touch at t")
    assert [row[3] for row in blind["contacts"]][:1] == ["robot 1 and obstacle 1"]
    assert {"contacts", "min_clearance_m"} <= {metric["name"] for metric in course_data(trial)["metrics"]}
    assert "graph-esm" in dict(choices()["rivals"]["team"])
    alone = TryoutTrial(scenario="reference")
    assert rival_data("lyapunov", alone)["contacts"] == []
    assert "contacts" not in {metric["name"] for metric in course_data(alone)["metrics"]}


def test_judging_a_run_alone_gives_the_same_contacts(touched):
    assert len(judge(touched).episodes) == sum(len(contacts(touched, place)) for place in range(3))
