"""Runs and their files: what ran, what was recorded, older files, and one channel more."""

import io
import json
import re
from dataclasses import replace

import numpy as np
import pytest

from fuzzy.files import arrays
from fuzzy.files.sealed import sealed_archive
from robotics.laws.catalogue import make_controller
from robotics.measures.clearance import clearances
from robotics.simulation import channels, recorder
from robotics.simulation import run as runs
from robotics.simulation.loop import simulate
from robotics.simulation.run import ChannelError, RunError, load_run
from robotics.simulation.scenario.reading import load_scenario
from robotics.world.environment.world import Disc
from robotics.world.sensing.sonar import SONAR
from tests.robotics.world.vehicle.etsro import ETSRO

BROAD = replace(ETSRO, length=0.5, width=0.45)


@pytest.fixture(scope="module")
def mixed():
    """A team of which one robot is larger and carries other sensors."""
    scenario = load_scenario("obstacles-on-two-paths")
    carried = {name: replace(sensor, range=1.5) for name, sensor in SONAR.items()} | {"rear": SONAR["left"]}
    large = replace(scenario.robots[1], robot=BROAD, sensors=carried)
    scenario = replace(scenario, robots=(scenario.robots[0], large, scenario.robots[2]), duration=1.5)
    return simulate(scenario, make_controller("obstacles"), (0, 7), name="obstacles", message_ages=True)


def test_a_file_of_another_format_is_refused_by_the_number_of_the_format(saved, tmp_path):
    with np.load(io.BytesIO(saved)) as file:
        arrays = dict(file)
    for number in (2, 4, "three"):
        told = json.loads(str(arrays["about"])) | {"format": number}
        np.savez(tmp_path / "run.npz", **arrays | {"about": np.array(json.dumps(told))})
        said = rf"run\.npz: a saved run of format '?{number}'?; this version reads format 3$"
        with pytest.raises(RunError, match=said):
            load_run(tmp_path / "run.npz")


def test_a_file_says_which_robots_ran_and_what_they_carried(mixed, tmp_path):
    mixed.save(tmp_path / "run.npz")
    back = load_run(tmp_path / "run.npz")
    assert back.about == mixed.about
    assert back.about.robots[1] == BROAD
    assert list(back.about.sensors[1]) == [*SONAR, "rear"]
    with np.load(tmp_path / "run.npz") as file:
        assert len(json.loads(str(file["about"]))["robots"]) == 2  # those that are alike stand once


def test_clearances_are_those_of_the_true_robot(mixed):
    """One disc, 1 m beside the second robot's start: 1 m less half its width and the radius."""
    x, y, heading = (mixed[name][0, 1, 0] for name in ("x", "y", "heading"))
    disc = Disc(position=(float(x - np.sin(heading)), float(y + np.cos(heading))), radius=0.2)
    beside = replace(load_scenario("obstacles-on-two-paths"), obstacles=(disc,)).setting.world.rest
    found = clearances(replace(mixed, obstacles=beside), 0)[1, 0]
    assert found == pytest.approx(1.0 - 0.45 / 2 - 0.2, abs=1e-9)


def test_one_seed_of_a_run_keeps_all_that_was_recorded(mixed):
    part = mixed.only(7)
    assert part.seeds == (7,)
    assert set(part.recorded) == {"samples", "team", "message_ages", "modes", "ranges"}
    for name, record in part.recorded.items():
        axis = record.axes.index("run")
        assert record.values.shape[axis] == 1, name
        np.testing.assert_array_equal(record.values, np.take(mixed.recorded[name].values, [1], axis=axis))
    with pytest.raises(ValueError, match="not in tuple"):
        mixed.only(3)


def test_a_run_saved_by_version_0_2_0_is_read(mixed, tmp_path):
    """It called the ages of messages links."""
    named = {"links" if name == "message_ages" else name: record for name, record in mixed.recorded.items()}
    replace(mixed, recorded=named).save(tmp_path / "old.npz")
    np.testing.assert_array_equal(load_run(tmp_path / "old.npz").message_ages, mixed.message_ages)


def test_a_recorded_array_more_is_cut_saved_and_loaded_by_its_declaration(monkeypatch, tmp_path):
    """Where each robot's clock stood, for instance: by its axes alone."""
    monkeypatch.setitem(channels.RECORDS, "clocks", channels.Record(axes=("sample", "run", "robot"), dtype="float32"))
    assert recorder.RECORDS is runs.RECORDS is channels.RECORDS
    scenario = replace(load_scenario("concentric-circles"), duration=1.0)
    run = simulate(scenario, make_controller("virtual-structure"), (0, 1))
    clock = np.arange(21 * 2 * 3, dtype=np.float32).reshape(21, 2, 3)
    run.with_recorded(clocks=clock).only(1).save(tmp_path / "one.npz")
    np.testing.assert_array_equal(load_run(tmp_path / "one.npz").recorded["clocks"].values, clock[:, 1:])


def test_figures_of_a_run_with_other_sensors_show_their_true_mounting(mixed):
    from robotics.show.playback.player import player_data

    data = player_data(mixed)
    assert data["sizes"] == [[0.23, 0.20], [0.5, 0.45], [0.23, 0.20]]
    sonar = data["sonar"]
    first, second = sonar["sensors"][0], sonar["sensors"][1]
    assert len(first) == len(second) == 5
    assert first[4] is None
    assert second[4] == pytest.approx(
        [SONAR["left"].x, SONAR["left"].y, SONAR["left"].axis, SONAR["left"].half_cone, 1.2], abs=1e-6
    )
    assert [mount[4] for mount in second[:4]] == [1.5] * 4


@pytest.fixture(scope="module")
def saved(tmp_path_factory, mixed):
    """The bytes of a saved run."""
    path = tmp_path_factory.mktemp("saved") / "run.npz"
    mixed.save(path)
    return path.read_bytes()


def test_every_flipped_bit_is_refused(saved, tmp_path):
    path = tmp_path / "run.npz"
    for bit in range(3, 8 * len(saved), len(saved) // 4):
        flipped = bytearray(saved)
        flipped[bit // 8] ^= 1 << bit % 8
        path.write_bytes(flipped)
        with pytest.raises(RunError, match=r"run\.npz: this saved run is damaged"):
            load_run(path)


WRONG = {
    "a channel less": ("samples", lambda a: a[:, :-1], "'samples' has the shape"),
    "a robot less": ("stopped", lambda a: a[:, :-1], "where the others ask for"),
    "texts for times": ("time", lambda a: a.astype(str), "'time' must be floating point"),
    "time that stands": ("time", np.zeros_like, "'time' does not grow"),
    "time in leaps": ("time", lambda a: a * 1e6, "'time' does not grow from sample to sample, by 1 s at most"),
    "faster than light": ("samples", lambda a: a * 1e12, "'samples' holds places or speeds beyond 1e+06"),
    "seeds twice": ("seeds", np.zeros_like, "'seeds' are not different"),
    "a mode that is none": ("modes", lambda a: a + 90, "'modes' must lie between 0 and 8"),
    "a fault that is none": ("team", lambda a: np.concatenate([a[:, :-1], a[:, -1:] - 2], 1), "'team' holds faults of"),
    "a fault without end": ("team", lambda a: np.where(np.isfinite(a), np.inf, a), "'team' holds faults of"),
    "a sensor less": ("ranges", lambda a: a[..., :-1], "'ranges' has 4 sensors, and the robots have 5"),
    "a body without sides": ("obstacles_bodies", lambda a: a + 9000, "'obstacles_bodies' must lie between"),
    "no path": ("path_1", None, "the array 'path_1' is missing"),
    "no robots": ("about", lambda a: np.array(str(a).replace('"robots"', '"r"')), "cannot be read"),
}


@pytest.mark.parametrize(("name", "change", "said"), WRONG.values(), ids=WRONG)
def test_arrays_that_are_not_those_of_one_run_are_refused(saved, tmp_path, name, change, said):
    """As a program that knows how to make a checksum may write them."""
    with np.load(io.BytesIO(saved)) as file:
        arrays = dict(file)
    if change is None:
        del arrays[name]
    else:
        arrays[name] = change(arrays[name])
    content = io.BytesIO()
    np.savez(content, **arrays)
    (tmp_path / "run.npz").write_bytes(sealed_archive(content.getvalue()))
    with pytest.raises(RunError, match=re.escape("run.npz: this saved run is damaged: ")) as caught:
        load_run(tmp_path / "run.npz")
    assert said in str(caught.value)


GOAL = {"within": 0.05, "heading_within": None, "hold": 1.0, "region": [[0, 0], [1, 0], [1, 1]]}


@pytest.mark.parametrize(
    "change",
    [
        {"within": "near"},
        {"within": -1.0},
        {"hold": float("nan")},
        {"heading_within": [1.0]},
        {"hold": None},
        {"region": [[0, 0], [1, 0]]},
        {"region": [[0, 0, 0], [1, 0, 0], [1, 1, 0]]},
        {"region": [[0, 0], [1, 0], [1, float("inf")]]},
        {"region": "abc"},
        {"region": 3},
        {"place": 1.0},
    ],
)
def test_goals_that_no_robot_can_have_are_refused(tmp_path, change):
    run = simulate(replace(load_scenario("parking"), duration=1.0), make_controller("polar"), (0,))
    file = tmp_path / "run.npz"
    run.save(file)
    with np.load(file) as saved:
        arrays = dict(saved)

    def load(goal):
        about = json.loads(str(arrays["about"]))
        content = io.BytesIO()
        np.savez(content, **arrays | {"about": np.array(json.dumps(about | {"goals": [goal] * len(about["goals"])}))})
        file.write_bytes(sealed_archive(content.getvalue()))
        return load_run(file)

    assert load(GOAL).about.goals[0].region == ((0, 0), (1, 0), (1, 1))
    with pytest.raises(RunError, match=r"run\.npz: this saved run is damaged: "):
        load(GOAL | change)


def test_what_is_no_run_is_not_unpacked(tmp_path, monkeypatch):
    (tmp_path / "plant.csv").write_text("t,y\n0,1\n")
    with pytest.raises(RunError, match=r"plant\.csv: this is not a run saved by `robotics run --save`$"):
        load_run(tmp_path / "plant.csv")
    monkeypatch.setattr(arrays, "MOST_BYTES", 10_000)
    np.savez_compressed(tmp_path / "bomb.npz", about=np.array("{}"), samples=np.zeros(10_000))
    with pytest.raises(RunError, match=r"bomb\.npz: .* its arrays would take .* are read"):
        load_run(tmp_path / "bomb.npz")


def test_an_unknown_channel_names_the_known_ones(mixed):
    with pytest.raises(ChannelError, match=r"^unknown channel of a run 'heding'; did you mean 'heading'\?") as caught:
        mixed["heding"]
    assert isinstance(caught.value, KeyError)
    assert isinstance(caught.value, ValueError)
