"""Where each metric is measured and shown: one table."""

import pytest

from robotics.measures.registry import ALL_METRICS, headlines, metrics_of, panel_metrics
from robotics.measures.tracking import SCENARIO_KINDS, TIMETABLED

SHORT = {
    "tracking": [
        "error norm",
        "speed error",
        "RMS cross-track",
        "RMS under way",
        "settling",
        "effort",
        "torque variation",
    ],
    "team": ["arrival", "arrival spread", "largest s_i − s_j", "least distance", "RMS cross-track"],
    "goal": ["success", "time", "final error", "final heading error", "share there"],
    "formation": ["alignment", "spread at the end", "largest lateral"],
}


@pytest.mark.parametrize("kind", SCENARIO_KINDS)
def test_a_short_table_has_its_metrics_with_their_short_titles(kind):
    assert [metric.short for metric in headlines(kind, others=False).values()] == SHORT[kind]
    touching = [*SHORT[kind], "contacts", "least clearance"]
    assert [metric.short for metric in headlines(kind, others=True).values()] == touching


def test_try_it_shows_arrivals_first_of_a_team_and_the_own_places_of_a_formation():
    assert list(panel_metrics("team")) == [
        "arrival_time_s",
        "arrival_spread_s",
        "max_progress_gap",
        "min_distance_m",
        "rms_cross_track_m",
        "torque_variation_nmps",
        "contacts",
        "min_clearance_m",
    ]
    assert len(panel_metrics("tracking")) == 8
    assert list(panel_metrics("formation")) == ["max_place_error_m", "rms_place_error_m"]


def test_an_entry_says_all_and_nothing_that_cannot_be():
    for name, metric in ALL_METRICS.items():
        assert metric.kinds, name
        assert set(metric.kinds) <= set(SCENARIO_KINDS), name
        assert set(metric.headline) <= set(metric.kinds), name
        assert set(metric.tried) <= set(metric.kinds), name
        assert bool(metric.short) == bool(metric.headline), name
        assert metric.title, name
        assert metric.unit, name


def test_kinds_share_what_every_robot_has():
    common = set.intersection(*(set(metrics_of(kind)) for kind in TIMETABLED))
    assert set(metrics_of("tracking")) == common
    assert len(common) == 19
    assert common & set(metrics_of("goal")) == {
        "control_effort",
        "torque_variation_nmps",
        "v_variation_mps2",
        "w_variation_radps2",
    }
    assert set(metrics_of("tracking", others=True)) - common == {"contacts", "min_clearance_m"}
    assert {name for kind in SCENARIO_KINDS for name in metrics_of(kind, guard=True)} == set(ALL_METRICS)


def test_only_laws_with_an_emergency_rule_are_measured_by_it():
    for kind in ("tracking", "team"):
        assert set(metrics_of(kind, guard=True)) - set(metrics_of(kind)) == {"emergency_share"}
    assert metrics_of("formation", guard=True) == metrics_of("formation")
