"""Trials under one's own conditions: robots, noise, several seeds; files of the folder, none of which runs unasked."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fuzzy.errors import InputError
from fuzzy.files.examples import write_examples
from fuzzy.files.fisfile import write_fis
from fuzzy.plugins.designer.folder import FolderError, open_folder
from fuzzy.plugins.designer.saving import OverwriteError
from fuzzy.system import Sugeno
from robotics.laws.catalogue import make_controller
from robotics.laws.tracking.fuzzy_tracking import load_rule_base
from robotics.plugins.designer.conditions import packaged_text, scenario_of
from robotics.plugins.designer.folderfiles import (
    FolderOffers,
    law_path,
    read_text_file,
    scenario_files,
    write_text_file,
)
from robotics.plugins.designer.severalseeds import (
    design_seeds,
    rival_seeds,
    state_of,
    summary,
    worst_seed,
)
from robotics.plugins.designer.tryout import (
    _IN_PYTHON,
    TryoutError,
    TryoutTrial,
    checked,
    course_data,
    driven_law,
    place_data,
    rival_data,
    run_design,
    settled,
    shown,
    untaken,
)
from robotics.simulation.loop import simulate
from robotics.simulation.scenario.conditions import noises
from robotics.simulation.scenario.reading import parse_scenario
from robotics.simulation.scenario.robots import load_robot
from robotics.studies.tuning.cost import Cost
from tests.browsers import run_apart

NOISY = """
duration = 3.0
sensing = { posture = "pose", position_noise = 0.02, heading_noise = 0.03, filter_gain = 0.5, start_position = 0.01 }
[[robots]]
start = [0.0, 0.1, 0.0]
path = { shape = "line", start = [0.0, 0.0], end = [0.6, 0.0] }
timing = { duration = 3.0 }
"""
KNOWN = '\n[knowledge]\nlead = "auto"\nsmooth = 0.2\n'
EXACT = NOISY.replace(", position_noise = 0.02, heading_noise = 0.03, filter_gain = 0.5, start_position = 0.01", "")
# A disc that some seeds touch: the robot begins 4 cm beside it, give or take what the seed draws
TIGHT = f"""{NOISY.replace("start_position = 0.01", "start_position = 0.05").replace("0.1, 0.0]", "0.0, 0.0]")}
[[obstacles]]
shape = "disc"
position = [0.1, 0.24]
radius = 0.1
"""
LAW = """
from dataclasses import dataclass
from pathlib import Path
from robotics import Command, Law

Path(__file__).with_name("ran").touch()

@dataclass(frozen=True, kw_only=True)
class Straight(Law[None]):
    def init(self, setting, runs):
        return None

    def control(self, seen, memory, dt):
        v = 0.2 + 0 * seen.x
        return Command(v, 0 * v, v, 0 * v), None
"""


@pytest.fixture(scope="module")
def tracking() -> Sugeno:
    return load_rule_base("tracking")


def mine(text: str, **more: Any) -> TryoutTrial:
    return TryoutTrial(scenario="mine.toml", text=text, law="fuzzy", task="tracking", **more)


def test_without_noise_all_is_as_if_the_file_had_none(tracking: Sugeno) -> None:
    off = run_design(tracking, mine(NOISY, noise=False, seed=3)).run
    assert np.array_equal(off.samples, run_design(tracking, mine(EXACT, seed=8)).run.samples)
    assert not np.array_equal(off.samples, run_design(tracking, mine(NOISY, seed=3)).run.samples)
    told = course_data(mine(NOISY, noise=False))["noises"]
    assert told == ["position ± 20 mm", "heading ± 1.7°", "start ± 10 mm"]
    assert noises(scenario_of("mine.toml", EXACT)) == []
    radio = packaged_text("scenario", "crossing-in-turn").replace("hub = 1", "hub = 1\nloss = 0.1\njitter = 0.02")
    assert noises(scenario_of("mine.toml", radio))[-2:] == ["lost messages", "messages late by up to 0.02 s"]


def test_what_laws_are_given_is_as_if_the_file_said_it(tracking: Sugeno) -> None:
    bare = NOISY.replace(", filter_gain = 0.5", "")
    told = bare.replace("start_position", 'estimator = "kalman", start_position') + KNOWN
    given = run_design(tracking, mine(bare, given="lead, low-pass, filter", seed=3)).run
    assert np.array_equal(given.samples, run_design(tracking, mine(told, seed=3)).run.samples)
    assert not np.array_equal(given.samples, run_design(tracking, mine(bare, seed=3)).run.samples)
    assert place_data(tracking, mine(bare))["course"]["untaken"] == ["no lead: its target is look_ahead ahead"]
    assert untaken(make_controller("fuzzy-correcting")) == ["its own lead and low-pass"]
    with pytest.raises(TryoutError, match="lead, low-pass"):
        mine(bare, given="low-pass")


def test_another_robot_for_all_or_for_one(tracking: Sugeno) -> None:
    small = packaged_text("robot", "etsro").replace("length = 0.23", "length = 0.15")
    trial = TryoutTrial(scenario="three-cross", robot="small.toml", robot_text=small)
    lengths = [robot.length for robot in trial.conditioned().setting.robots]
    assert lengths == [0.15] * 3
    second = TryoutTrial(scenario="three-cross", robot="small.toml", robot_text=small, robot_of=2)
    assert [robot.length for robot in second.conditioned().setting.robots] == [0.23, 0.15, 0.23]
    packaged = TryoutTrial(scenario="mine.toml", text=EXACT, robot="mir100").conditioned()
    assert packaged.setting.robots[0] == load_robot("mir100").robot
    assert packaged.setting.sensors[0] == load_robot("mir100").sensors
    fast = EXACT.replace("3.0 }", "1.0 }")
    with pytest.raises(InputError, match=r"mine cannot be driven with the robot turtlebot3-burger: .* infeasible"):
        TryoutTrial(scenario="mine.toml", text=fast, robot="turtlebot3-burger").conditioned()
    with pytest.raises(InputError, match="there is no robot 4"):
        TryoutTrial(scenario="three-cross", robot="etsro", robot_of=4).conditioned()
    with pytest.raises(InputError, match="did you mean 'etsro'"):
        TryoutTrial(scenario="three-cross", robot="etsr").conditioned()
    fault = checked("robot", "small.toml", small.replace("width", "widht"))
    assert small.splitlines()[fault["line"] - 1].startswith("width")
    assert checked("robot", "small.toml", small) == checked("scenario", "mine.toml", NOISY) == {}


def test_seeds_together_are_those_alone(tracking: Sugeno) -> None:
    trial, seeds = mine(NOISY), range(4)
    rows = design_seeds(tracking, trial, 4, seeds)
    metrics = course_data(trial)["metrics"]
    alone = [shown(run_design(tracking, mine(NOISY, seed=seed)), "", Cost()) for seed in seeds]
    assert [row["metrics"] for row in rows] == [one["metrics"] for one in alone]
    assert [row["cross_track"][0][-1] for row in rows] == [one["cross_track"][0][-1] for one in alone]
    errors = [one["metrics"]["rms_cross_track_m"] for one in alone]
    assert worst_seed(rows, "rms_cross_track_m") == int(np.argmax(errors))
    told = summary(rows, metrics)
    assert told["median"]["rms_cross_track_m"] == pytest.approx(np.median(errors))
    assert told["worst"]["rms_cross_track_m"] == max(errors)
    assert (told["runs"], told["contact"], told["stopped"], told["refused"]) == (4, 0, 0, 0)
    assert [row["metrics"] for row in rival_seeds(tracking, trial, "", seeds)] == [row["metrics"] for row in rows]
    assert "x" not in rival_seeds("lyapunov", trial, "", [0])[0]


def test_the_worst_touched_first(tracking: Sugeno) -> None:
    trial = mine(TIGHT)
    rows = design_seeds(tracking, trial, 6, range(6))
    law_run = simulate(trial.conditioned(), driven_law(tracking, trial), range(6))
    gaps = np.hypot(law_run["x"][:, 0] - 0.1, law_run["y"][:, 0] - 0.24).min(axis=1)
    states = [state_of(row) for row in rows]
    assert {"contact", "done"} == {*states}
    # Whoever comes nearer than half the robot's width and the radius touched; who stays a diagonal away did not.
    assert all(state == "contact" for state, gap in zip(states, gaps, strict=True) if gap < 0.2 - 1e-3)
    assert all(state == "done" for state, gap in zip(states, gaps, strict=True) if gap > 0.1 + np.hypot(0.115, 0.1))
    first = min((row["contacts"][0][0], row["seed"]) for row in rows if row["contacts"])
    assert worst_seed(rows, "rms_cross_track_m") == first[1]
    assert summary(rows, course_data(trial)["metrics"])["contact"] == states.count("contact")


def test_a_refusal_is_a_result(tracking: Sugeno) -> None:
    trial = settled(tracking, TryoutTrial(scenario="trap-u", law="obstacles", robot="mir100"))
    rows = design_seeds(tracking, trial, 2, range(2))
    assert [state_of(row) for row in rows] == ["refused", "refused"]
    assert "lacks the range sensors" in rows[0]["why"]
    told = summary(rows, course_data(trial)["metrics"])
    assert (told["refused"], told["median"]["contacts"], len(told["whys"])) == (2, None, 1)


# The folder -----------------------------------------------------------------------------------------------------


@pytest.fixture
def folder(tmp_path: Path, tracking: Sugeno) -> Path:
    place = tmp_path / "open"
    (place / "sub").mkdir(parents=True)
    (place / "mine.toml").write_text(NOISY, encoding="utf-8")
    (place / "sub" / "small.toml").write_text(packaged_text("robot", "etsro"), encoding="utf-8")
    (place / "pyproject.toml").write_text("[project]\n", encoding="utf-8")
    (place / "own.py").write_text(LAW, encoding="utf-8")
    (place / "broken.py").write_text("class Worse(Law:", encoding="utf-8")
    write_fis(tracking, place / "tracking.fis")
    write_fis(tracking, place / "other.fis")
    write_examples([("tipper", place / "tipper.fis")])  # drives nobody, nor does what cannot be read
    (place / "faulty.fis").write_text("[System]", encoding="utf-8")
    (tmp_path / "far.toml").write_text(packaged_text("robot", "etsro"), encoding="utf-8")
    (place / "way").symlink_to(tmp_path)
    return place


def test_what_the_folder_offers(folder: Path, tracking: Sugeno) -> None:
    opened = open_folder(folder)
    assert scenario_files(opened) == ["mine.toml"]
    looked: list[str] = []

    async def read(name: str, function: Any, *args: Any) -> Any:
        looked.append(name)
        if name == "slow.py":
            raise InputError("slow.py was not read within 20 s")
        return function(*args)

    (folder / "slow.py").write_text("", encoding="utf-8")
    offers = FolderOffers(opened, read)
    # A file that is late is said and left out, and is not looked at again while it stays as it is.
    assert run_apart(offers.look()) == "slow.py was not read within 20 s"
    assert offers.found(folder / "tracking.fis") == {
        "scenarios": ["mine.toml"],
        "robots": ["sub/small.toml"],
        "laws": ["other.fis", "own.py:Straight"],
    }
    assert looked.count("mine.toml") == looked.count("slow.py") == 1
    looked.clear()
    (folder / "mine.toml").unlink()
    assert run_apart(offers.look()) == ""
    assert offers.found(folder)["scenarios"] == []
    assert looked == ["the folder"]
    specification = law_path(opened, "own.py:Straight")
    assert not (folder / "ran").exists()  # to be listed a law does not run
    assert rival_data(specification, mine(EXACT))["label"] == "Straight"
    assert (folder / "ran").exists()
    for wrong in ("own.py:Curved", "way/own.py:Straight", "../own.py:Straight", "own.txt:Straight"):
        with pytest.raises(InputError):
            law_path(opened, wrong)


def test_a_scenario_runs_no_python_and_reads_no_robot_from_elsewhere(folder: Path) -> None:
    at = str(folder)
    named = f'controller = "{folder}/own.py:Straight"\n{EXACT}'
    assert scenario_of("mine.toml", named, at).controller == ""
    assert not (folder / "ran").exists()
    parse_scenario(named, "mine")  # outside the designer it does
    assert (folder / "ran").exists()
    inside = f'robot = "sub/small.toml"\n{EXACT}'
    assert scenario_of("mine.toml", inside, at).setting.robots[0].length == 0.23
    changed = packaged_text("robot", "etsro").replace("length = 0.23", "length = 0.3")
    (folder / "sub" / "small.toml").write_text(changed, encoding="utf-8")
    assert scenario_of("mine.toml", inside, at).setting.robots[0].length == 0.3
    for wrong in ("../far.toml", "way/far.toml", f"{folder.parent}/far.toml", "none.toml"):
        with pytest.raises(InputError, match=r"there is no robot .* in the opened folder"):
            scenario_of("mine.toml", f'robot = "{wrong}"\n{EXACT}', at)


def test_files_are_written_in_the_folder_and_never_over_what_was_not_read(folder: Path) -> None:
    opened = open_folder(folder)
    file = read_text_file(opened, "mine.toml")
    edited = write_text_file(opened, file._replace(text=EXACT), "mine.toml")
    assert (folder / "mine.toml").read_text(encoding="utf-8") == EXACT
    assert read_text_file(opened, "mine.toml") == edited
    (folder / "mine.toml").write_text("# another program's\n", encoding="utf-8")
    with pytest.raises(OverwriteError, match=r"mine.toml was changed on disk"):
        write_text_file(opened, edited, "mine.toml")
    with pytest.raises(OverwriteError, match=r"small.toml exists already"):
        write_text_file(opened, edited, "sub/small.toml")
    write_text_file(opened, edited, "mine.toml", overwrite=True)
    assert (folder / "mine.toml").read_text(encoding="utf-8") == EXACT
    before = (folder.parent / "far.toml").read_bytes()
    for wrong in ("../far.toml", "way/far.toml", "mine.txt", ".hidden.toml", "a/../b.toml", ""):
        with pytest.raises(FolderError):
            write_text_file(opened, edited, wrong, overwrite=True)
    with pytest.raises(InputError, match="there is no folder"):
        write_text_file(opened, edited, "nowhere/x.toml")
    assert (folder.parent / "far.toml").read_bytes() == before


def test_what_python_would_write_is_no_word_of_the_page() -> None:
    said = "x: no rule fires at some inputs; 5 stands there (no_rule_fires = 'nan' or 'error' chooses otherwise; `a` b)"
    assert _IN_PYTHON.sub("", said) == "x: no rule fires at some inputs; 5 stands there"
    assert _IN_PYTHON.sub("", "lies outside (a path of its own)") == "lies outside (a path of its own)"
