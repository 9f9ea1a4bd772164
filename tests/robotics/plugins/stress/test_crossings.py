"""Random crossings: what the classes promise, how runs are judged, and robots that are parked in each other's way."""

from dataclasses import replace
from functools import partial

import numpy as np
import pandas as pd
import pytest

from robotics.laws.avoidance.reservation import CELLS, plan_right_of_way
from robotics.laws.avoidance.sidestep import sidestepped
from robotics.laws.catalogue import make_controller
from robotics.plugins.stress.crew import Crew
from robotics.plugins.stress.crossings import crossing_ensemble, random_crossings, stress_crossing
from robotics.plugins.stress.disturbance import Disturbance
from robotics.plugins.stress.outcome import StressOutcome, table_of
from robotics.plugins.stress.quintic_table import quintic_table
from robotics.plugins.stress.running import in_pieces
from robotics.simulation.loop import record_run
from robotics.simulation.scenario.robots import load_robot
from robotics.world.paths.joined import table_length
from robotics.world.paths.path import PathColumns, Quintic
from tests.robotics.plugins.stress.equalprogress import samples


@pytest.mark.parametrize(("kind", "robots"), [("A", 3), ("B", 3), ("A", 5), ("B", 5)])
def test_a_class_keeps_what_it_promises(kind, robots):
    """16 m² a robot, 4 : 3; a conflict at equal progress; ends clear of the other paths, or of each other."""
    field = np.sqrt(16 * robots * np.array([4 / 3, 3 / 4]))
    for seed in range(4):
        tables = random_crossings(robots, [np.random.default_rng(seed)], kind)[0]
        points = samples(tables)
        ends = points[:, [0, -1]]
        assert (ends >= 0).all()
        assert (ends <= field).all()
        assert max(np.abs(PathColumns(t).curvature).max() for t in tables) < 1 / 0.34
        gaps = np.hypot(*np.moveaxis(points[:, None] - points[None], -1, 0)).min(axis=-1) + 9 * np.eye(robots)
        assert gaps.min() < 0.41
        for i in range(robots):
            for j in set(range(robots)) - {i}:
                if kind == "A":
                    for end in ends[i]:
                        assert np.hypot(*(points[j] - end).T).min() > 0.58
                else:
                    assert np.hypot(*(ends[i] - ends[j]).T).min() >= 0.89


def test_class_b_has_ends_on_other_paths():
    near = []
    for seed in range(8):
        points = samples(random_crossings(3, [np.random.default_rng(seed)], "B")[0])
        near += [
            np.hypot(*(points[j] - points[i, k]).T).min() for i in range(3) for j in range(3) if i != j for k in (0, -1)
        ]
    assert min(near) < 0.3


def test_a_crossing_is_the_same_however_many_numbers_are_drawn_at_a_time(monkeypatch):
    whole = crossing_ensemble(3, range(4))
    monkeypatch.setattr("robotics.plugins.stress.crossings._DRAWS", 1)
    np.testing.assert_array_equal(crossing_ensemble(3, range(4)).references.joined.table, whole.references.joined.table)


def test_a_seed_makes_its_crossing_whatever_is_beside_it():
    alone, beside = crossing_ensemble(3, [7]), crossing_ensemble(3, [2, 7, 9])
    np.testing.assert_array_equal(alone.starts[0], beside.starts[1])
    np.testing.assert_array_equal(alone.references.joined.lengths[0], beside.references.joined.lengths[1])
    assert alone.references.ends[0] == pytest.approx(alone.references.joined.lengths[0].max() / 0.22, abs=0)


def assert_same(whole, part, k):
    for name in ("arrivals", "collided", "refused", "min_distance", "nominal"):
        np.testing.assert_array_equal(getattr(whole, name)[k : k + len(part.seeds)], getattr(part, name))


def test_an_outcome_does_not_depend_on_chunks():
    law, wrong = make_controller("right-of-way"), Disturbance(freeze=3.0, loss=0.2)
    whole = stress_crossing(law, 3, range(3), "A", wrong)
    tables = [stress_crossing(law, 3, part, "A", wrong).table for part in (range(1), range(1, 3))]
    parts = StressOutcome(pd.concat(tables, ignore_index=True))
    assert whole.seeds == parts.seeds
    assert_same(whole, parts, 0)


def test_a_run_that_never_ends_is_judged_alike_alone(literal, monkeypatch):
    """It is given up after a multiple of its own duration, not of the longest of all."""
    monkeypatch.setattr(StressOutcome, "limit", GIVEN_UP)
    whole = literal["crash-literal"]
    quickest = np.argmin(np.where(whole.deadlocked, whole.nominal, np.inf))
    assert_same(whole, stress_crossing(make_controller("crash-literal"), 3, [int(quickest)]), quickest)


def test_rates_are_counted_apart():
    """A run that touches and never ends is both a collision and a deadlock; a refused one is neither."""
    inf = np.inf
    arrivals = np.array([[30.0, 30.5], [30.0, inf], [30.0, 32.0], [inf, inf]])
    yes = np.array([False, True, False, False])
    refused, clearance = yes[[0, 2, 3, 1]], np.array([0.3, -0.02, 0.2, -1.0])
    near, blamed, driven = np.full(4, 0.5), np.stack([yes, yes], axis=1), np.array([60.5, 150.0, 62.0, 0.0])
    columns = {"seed": np.arange(5, 9), "nominal_s": np.full(4, 30.0), "arrival_s": arrivals, "collided": yes}
    columns |= {"refused": refused, "min_distance_m": near, "clearance_m": clearance, "caused": blamed}
    columns |= {"driven_s": driven, "overridden_s": np.full(4, np.nan)}
    judged = StressOutcome(table_of(columns))
    found = judged.summary()
    assert (found["collisions"], found["deadlocks"], found["refused"], found["arrived"]) == (1, 1, 1, 2)
    assert found["arrived_together"] == 1
    assert found["min_clearance_m"] == -0.02  # of those that started
    assert (found["contacts"], found["contacts_caused"], found["emergency_share"]) == (1, 1, None)
    assert found["failed_seeds"] == {"collision": [6], "deadlock": [6], "refused": [8], "apart": [7]}


GIVEN_UP = 1.5  # nominal durations


@pytest.fixture(scope="module")
def literal():
    """What (6.4), (6.5) as printed and no avoidance make of 40 crossings, given up early."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(StressOutcome, "limit", GIVEN_UP)
        return {
            name: stress_crossing(make_controller(name), 3, range(40))
            for name in ("crash-literal", "cooperation-literal")
        }


def test_as_printed_robots_touch_or_wait_for_ever_and_without_avoidance_they_touch_more(literal):
    """On 400 seeds 30 % touch, 35 % do not end and 56 % do neither; the bounds are those of 40 at 3 standard errors.

    (Given 4 nominal durations 26 % never end.)
    """
    printed, none = literal["crash-literal"], literal["cooperation-literal"]
    assert 0.08 <= printed.collided.mean() <= 0.51
    assert 0.12 <= printed.deadlocked.mean() <= 0.57
    assert 0.32 <= (~printed.collided & ~printed.deadlocked).mean() <= 0.80
    assert none.collided.mean() > printed.collided.mean() + 0.2
    assert not none.deadlocked.any()


# Parked robots ---------------------------------------------------------------------------------------------------


def nodes(tables):
    out = []
    for table in tables:
        place = np.linspace(0, table.shape[1] - 1, CELLS + 1)
        out.append(np.stack([np.interp(place, np.arange(table.shape[1]), row) for row in table[:2]], axis=1))
    return np.array([out])


PARKED = [
    Quintic(start=(0.0, 0.0), end=(8.0, 0.0)),
    Quintic(start=(5.0, -4.0), end=(5.0, 0.1), start_tangent=(0.0, 4.0), end_tangent=(0.0, 4.0)),
]


def test_a_robot_whose_end_is_on_anothers_path_arrives_after_it_has_passed():
    plan = plan_right_of_way(nodes([quintic_table(p) for p in PARKED]), together=np.array([0.02]))
    assert plan.found.all()
    first, second = plan.progress[0]
    assert (second[first < 5.4 / 8] < 1 - 0.4 / 4.1).all()  # robot 2 is not in the way yet
    last = int(plan.factor[0] * CELLS)
    assert first[last] == second[last] == 1
    assert max(first[last - 5], second[last - 5]) < 1  # and nobody is at its end before


def test_where_both_ends_are_in_the_way_a_sidestep_makes_the_plan():
    """Robot 1 must pass the end of robot 2 after robot 2 is there, as robot 2 must pass that of robot 1."""
    shapes = [
        Quintic(start=(0.0, 0.0), end=(8.0, 0.0)),
        Quintic(start=(9.0, -0.1), end=(3.0, -0.1), start_tangent=(-6.0, 0.0), end_tangent=(-6.0, 0.0)),
    ]
    tables = [quintic_table(shape) for shape in shapes]
    assert not plan_right_of_way(nodes(tables)).found.any()
    bent = sidestepped(tables, 0.6)
    assert plan_right_of_way(nodes(bent)).found.all()


def test_a_sidestep_keeps_the_ends_and_clears_the_other():
    tables = [quintic_table(shape) for shape in PARKED]
    bent, same = sidestepped(tables, 0.6)
    np.testing.assert_array_equal(same, tables[1])
    for k in (0, -1):
        np.testing.assert_allclose(bent[:3, k], tables[0][:3, k], atol=1e-6)
    found = PathColumns(bent)
    end = tables[1][:2, -1]
    assert np.hypot(found.x - end[0], found.y - end[1]).min() >= 0.59
    # What says where it leads agrees with where it lies: nodes are evenly spaced, headings their direction.
    chords = np.hypot(np.diff(found.x), np.diff(found.y))
    np.testing.assert_allclose(chords, table_length(bent) / len(chords), rtol=2e-3)
    direction = np.arctan2(np.diff(found.y), np.diff(found.x))
    np.testing.assert_allclose(direction, (found.heading[1:] + found.heading[:-1]) / 2, atol=2e-3)
    turned = np.diff(found.heading) / chords
    np.testing.assert_allclose(turned, (found.curvature[1:] + found.curvature[:-1]) / 2, atol=0.05)
    mirrored = sidestepped(tables, 0.6, mirrored=True)[0]
    middle = [PathColumns(table).y[np.argmin(np.abs(PathColumns(table).x - 5.0))] for table in (bent, mirrored)]
    assert middle[0] < -0.4
    assert middle[1] > 0.6


def test_robots_parked_in_the_way_are_passed_without_contact():
    found = stress_crossing(make_controller("right-of-way"), 3, range(20), "B").summary()
    assert found["collisions"] == found["deadlocks"] == 0
    assert found["refused"] <= 1  # of 300 it is 2
    assert found["arrived_together"] == 20 - found["refused"]


def test_an_outcome_does_not_depend_on_threads():
    """Chunks in threads of this process, and all runs one after the other: the same bits."""
    stress, seeds = partial(stress_crossing, "right-of-way", 3, disturbance=Disturbance(loss=0.2)), range(40)
    alone = stress(seeds)
    shared = in_pieces(stress, 3, seeds, Crew(workers=2), threads=True)
    pd.testing.assert_frame_equal(alone.table, shared.table, check_exact=True)


def test_a_robot_that_waits_far_behind_its_reference_is_not_stopped():
    """A large robot waits for another more than 10 m behind: it goes on when the way is free."""
    setting = crossing_ensemble(3, [960071], robot=load_robot("mir100"))
    law = make_controller("fuzzy-team")
    assert not record_run(setting, law, [960071]).diverged.any()
    assert record_run(replace(setting, divergence=10.0), law, [960071]).diverged.any()
