"""The share of the way on which a law's emergency rule acted: recorded, measured, and shown only where there is one."""

from dataclasses import replace

import numpy as np
import pytest

from robotics.commands.study_printing import print_comparisons
from robotics.laws.catalogue import make_controller
from robotics.measures.avoidance import emergency_share
from robotics.measures.registry import measure_all
from robotics.show.report.study import Study
from robotics.show.report.summarytable import summary_table
from robotics.simulation.loop import simulate
from robotics.simulation.run import load_run
from robotics.simulation.scenario.description import Member, Scenario
from robotics.studies.comparison import Comparison, rows_of, summarise
from robotics.world.paths.path import Line
from robotics.world.paths.trajectory import Timing
from robotics.world.sensing.posture import Sensing
from tests.robotics.guardedlaw import Guarded

LENGTHS = (1.0, 3.0)  # m: at 0.2 m/s the first robot has 99.5 % behind it at 4.975 s, the second one never
NAME = "virtual-structure"  # tables of comparisons have titles for what the catalogue lists


@pytest.fixture(scope="module")
def scenario():
    members = tuple(
        Member(start=(0.0, y, 0.0), path=Line(start=(0.0, y), end=(length, y)), timing=Timing(duration=15.0))
        for y, length in enumerate(LENGTHS)
    )
    sensing = Sensing(posture="pose")
    return Scenario(name="odd", robots=members, kind="team", plant="kinematic", duration=8.0, sensing=sensing)


@pytest.fixture(scope="module")
def run(scenario):
    return simulate(scenario, Guarded(), (0, 1), name=NAME)


def test_a_run_keeps_when_the_rule_acted_saves_it_and_tables_it(run, tmp_path):
    odd = np.floor(run.time + 1e-9) % 2 == 1
    assert run.guarded.dtype == bool
    np.testing.assert_array_equal(run.guarded, np.broadcast_to(odd[:, None, None], (len(odd), 2, 2)))
    run.only(1).save(tmp_path / "one.npz")
    np.testing.assert_array_equal(load_run(tmp_path / "one.npz").guarded, run.guarded[:, 1:])
    frame = run.frame()
    np.testing.assert_array_equal(frame[(frame["seed"] == 1) & (frame["robot"] == 2)]["guarded"], odd)


def test_the_share_is_of_the_way_until_arrival(run):
    """[1, 2) and [3, 4) of the 5 s until the first sample that has arrived; four of 8 s for a robot that never does."""
    np.testing.assert_allclose(measure_all(run)["emergency_share"], [[0.4, 0.5]] * 2, rtol=1e-12)


def test_the_share_ends_with_the_first_contact(scenario):
    """Both come to the place (0.8, 0) at 0.2 m/s, at right angles.

    The first is 0.8 - 0.2 t short of it and the second 0.55 - 0.2 t: their rectangles meet at half a length and half a
    width, 0.215 m, of both: at 2.925 s. Of the 59 samples until then, at 50 ms, the 20 of [1, 2) are odd.
    """
    path = Line(start=(0.0, 0.0), end=(3.0, 0.0))
    first = replace(scenario.robots[1], start=(0.0, 0.0, 0.0), path=path)
    second = replace(first, start=(0.8, -0.55, np.pi / 2), path=Line(start=(0.8, -0.55), end=(0.8, 3.0)))
    meeting = simulate(replace(scenario, robots=(first, second)), Guarded(), (0,))
    np.testing.assert_allclose(measure_all(meeting)["emergency_share"], [[20 / 59] * 2], rtol=1e-12)


def test_a_robot_never_on_its_way_and_a_law_without_a_rule_have_none(scenario, run):
    stopped = run.with_recorded(samples=np.where(np.arange(2) == 1, np.nan, run.samples))
    share = emergency_share(stopped)
    assert np.isnan(share[:, 1]).all()
    assert np.isfinite(share[:, 0]).all()
    plain = simulate(scenario, make_controller("cooperation"), (0,))
    assert plain.guarded is None
    assert "emergency_share" not in measure_all(plain)
    assert "guarded" not in plain.frame()


def test_a_comparison_shows_it_for_the_laws_that_have_one(scenario, run, capsys, tmp_path):
    import pandas as pd

    plain = simulate(scenario, make_controller("cooperation"), (0, 1), name="cooperation")
    tables = [rows_of(plain), rows_of(run)]
    laws = {"cooperation": make_controller("cooperation"), NAME: Guarded()}
    runs = {("odd", "cooperation"): plain, ("odd", NAME): run}
    both = Comparison((scenario,), laws, (0, 1), pd.concat(tables, ignore_index=True), runs)
    summary = summarise(both.table)
    rows = summary[summary["metric"] == "emergency_share"]
    assert rows["controller"].tolist() == [NAME]
    assert rows["mean"].tolist() == pytest.approx([0.45])
    (row,) = (row for row in summary_table(both, "odd").rows if "emergency" in row.title)
    assert [cell.mean for cell in row.cells] == ["–", "0.450"]
    assert [cell.mark for cell in row.cells] == ["", ""]  # there is nothing to compare with
    print_comparisons(Study((both,), summary, [], tmp_path, []))
    lines = [line for line in capsys.readouterr().out.splitlines() if "never" in line]  # neither law ends in 8 s
    assert [line.split("│")[6].strip() for line in lines] == ["–", "0.450"]
    without = Comparison((scenario,), {"cooperation": laws["cooperation"]}, (0, 1), tables[0], runs)
    assert not [row for row in summary_table(without, "odd").rows if "emergency" in row.title]
