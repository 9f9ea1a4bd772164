"""``robotics stress``, and ``robotics repeat`` of what it names, through the command line."""

import json

import numpy as np
import pytest

from robotics.commands.application import main
from robotics.measures.teams import nearest_distance
from robotics.simulation.run import load_run

KEYS = {
    "runs",
    "collisions",
    "deadlocks",
    "refused",
    "arrived_together",
    "arrival_spread_p95_s",
    "time_ratio_median",
    "min_distance_m",
    "contacts",
    "failed_seeds",
}


def printed(capsys, *arguments):
    assert main([*arguments, "-q", "--json"]) == 0
    return capsys.readouterr().out


def test_it_prints_what_happened_and_the_same_seed_prints_the_same_bytes(capsys):
    arguments = ("stress", "crossing", "--robots", "3", "--runs", "2", "--seed", "30", "--freeze", "2", "--loss", "0.1")
    first = printed(capsys, *arguments)
    found = json.loads(first)
    assert set(found) >= KEYS
    assert (found["runs"], found["collisions"], found["deadlocks"]) == (2, 0, 0)
    assert found["arrived_together"] == 2
    assert printed(capsys, *arguments) == first


def test_the_number_of_processes_changes_nothing(capsys, monkeypatch):
    monkeypatch.setattr("robotics.plugins.stress.running.ROBOTS_A_PASS", 6)
    options = ("--robots", "3", "--lanes", "crossing", "--freeze", "3", "--controller", "cooperation")
    arguments = ("stress", "obstacles", *options, "--runs", "3", "--workers")
    assert printed(capsys, *arguments, "1") == printed(capsys, *arguments, "2")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["stress", "crossing", "--controller", "nobody"], "unknown controller 'nobody'"),
        (["stress", "crossing", "--class", "C"], ": --class: "),
        (["stress", "crossing", "--robots", "1"], ": --robots: "),
        (["stress", "crossing", "--loss", "1.5"], ": --loss: "),
        (["stress", "crossing", "--freeze", "-1"], ": --freeze: "),
        (["repeat", "chess"], "'chess' is not one of"),
        (["repeat", "crossing", "--class", "U"], "unknown class 'U'"),
        (["repeat", "crossing", "--robots", "1"], "robots must be 2 or more, got 1"),
        (["repeat", "obstacles", "--robots", "2"], "robots must be 1 or 3, got 2"),
        (["repeat", "obstacles", "--lanes", "crossing"], "lanes cross where there are 2 robots or more, got 1"),
        (["stress", "obstacles", "--lanes", "crossing"], "lanes cross where there are 2 robots or more, got 1"),
        (["stress", "obstacles", "--lanes", "aslant"], ": --lanes: "),
        (["repeat", "crossing", "--lanes", "crossing"], "lanes belong to `obstacles`"),
        (["repeat", "crossing", "--moving", "1"], "belong to `obstacles`"),
        (["run", "lyapunov-sine", "--robots", "3"], "No such option: --robots"),
        (["run", "--seed", "4", "crossing"], "`robotics repeat crossing` repeats one run"),
        (["repeat", "crossing", "--class", "B", "--seed", "203"], "seed 203: right-of-way has no safe plan"),
    ],
)
def test_what_cannot_be_is_said_in_a_sentence(capsys, arguments, said):
    assert main([*arguments, "-q"]) == 2
    err = capsys.readouterr().err
    assert said in err
    assert "Traceback" not in err


def test_repeat_repeats_the_crossing_of_a_seed_exactly(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    options = ("crossing", "--robots", "3", "--class", "A", "--seed", "20", "--controller", "none")
    stress = json.loads(printed(capsys, "stress", *options, "--runs", "1"))
    run = json.loads(printed(capsys, "repeat", *options, "--save", "it.npz", "--animate"))
    shared = set(stress) & set(run["outcome"])
    assert {name: run["outcome"][name] for name in shared} == {name: stress[name] for name in shared}
    saved = load_run("it.npz")
    assert nearest_distance(saved).min() == stress["min_distance_m"]
    assert run["metrics"]["min_distance_m"][0][0] >= stress["min_distance_m"]
    # Saved without loss, the paths with it: the robots begin on them.
    starts = np.array([nodes[:, 0] for nodes in saved.paths])
    np.testing.assert_allclose(np.stack([saved["x"][0, :, 0], saved["y"][0, :, 0]], axis=1), starts, atol=1e-9)
    page = tmp_path / run["player"]
    assert page.name == "crossing-3-A-seed-20.html"
    assert "data-fleet-player" in page.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    "options",
    [
        ("--seed", "2", "--freeze", "2"),
        ("--seed", "1", "--robots", "3", "--loss", "0.2", "--latency", "0.3", "--moving", "1", "--lanes", "crossing"),
    ],
)
def test_repeat_repeats_a_course_among_obstacles(capsys, monkeypatch, options):
    monkeypatch.setattr(
        "robotics.plugins.stress.obstaclecourse.ObstacleOutcome.limit", 0.5
    )  # half of the way is enough to compare
    stress = json.loads(printed(capsys, "stress", "obstacles", *options, "--runs", "1"))
    run = json.loads(printed(capsys, "repeat", "obstacles", *options))
    shared = set(stress) & set(run["outcome"])
    assert shared >= {"min_clearance_m", "min_distance_m", "contacts", "followed_wall"}
    assert {name: run["outcome"][name] for name in shared} == {name: stress[name] for name in shared}


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["crossing", "--runs=1", "--controller=none"], "takes no care of other robots"),
        (["crossing", "--runs=1", "--controller=yielding"], "keeps 1 m between robots"),
        (["obstacles", "--runs=1", "--controller=cooperation"], "drives blind"),
        (["obstacles", "--runs=1"], ""),
    ],
)
def test_laws_that_do_not_see_are_warned_of(capsys, arguments, words):
    assert main(["stress", *arguments, "--json", "-q"]) == 0
    err = capsys.readouterr().err
    assert words in err
    assert err.count("warning") == bool(words)
