"""A law that another package brings: installed, and then as good as one's own."""

import json
import os
import subprocess
import sys
from importlib.metadata import EntryPoint
from typing import Any

import pytest

from fuzzy.errors import InputError
from robotics.laws import catalogue
from robotics.laws.catalogue import CATALOGUE, make_controller, presets, unusable_laws
from robotics.laws.law import Law

PROJECT = """
[build-system]
requires = ["hatchling"]
build-backend = "hatchling.build"
[project]
name = "carrot-on-a-stick"
version = "1.0"
[project.entry-points."fuzzyfleet.laws"]
carrot = "carrot:CARROT"
carrot-team = "carrot:TEAM"
broken = "carrot:nothing_there"
[tool.hatch.build.targets.wheel]
packages = ["carrot"]
"""
LAW = '''
from dataclasses import dataclass

import numpy as np

from robotics.laws.catalogue import Preset
from robotics.laws.law import Command, ControllerError, Law
from robotics.world.paths.posture import posture_error
from robotics.quantity import check_quantities, quantity


@dataclass(frozen=True, kw_only=True)
class Carrot(Law[None]):
    """Turn to a point some metres ahead of the reference, and drive there."""

    gain: float = quantity(2.0, "1/s", above=0)

    def __post_init__(self):
        check_quantities(self, ControllerError)

    def init(self, setting, runs):
        return None

    def control(self, seen, memory, dt):
        e = posture_error(seen.x, seen.y, seen.heading, seen.reference)
        bearing = np.arctan2(e.y, e.x + 0.3)
        v = np.clip(seen.reference.v + e.x, 0.0, 0.6)
        w = np.clip(self.gain * bearing, -3.0, 3.0)
        return Command(v, w, v, w), None


CARROT = Preset(Carrot, {}, "Carrot", "a point 0.3 m ahead")
TEAM = Preset(Carrot, {"gain": 3.0}, "Carrots", "each robot by itself", "team")
'''
SWEEP = """
scenario = "short.toml"
controllers = ["carrot"]
seeds = 2
[controller_parameters]
gain = [1.0, 3.0]
"""
USES = """
import contextlib, io, json, sys
from robotics.commands.application import main
from robotics.plugins.designer.tryout import TryoutTrial, choices, rival_data

def said(*arguments):
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = main(list(arguments))
    return [code, out.getvalue(), err.getvalue()]

told = {
    "run": said("run", "fuzzy-on-path", "-c", "carrot:gain=2.5", "--json", "-q"),
    "compare": said("compare", "short.toml", "--controllers", "carrot,lyapunov", "--seeds", "1", "--out", "out", "-q"),
    "stress": said("stress", "crossing", "--controller", "carrot-team", "--runs", "1", "--json", "-q"),
    "sweep": said("sweep", "gains.toml", "--out", "swept", "-q"),
    "list": said("list"),
    "broken": said("run", "fuzzy-on-path", "-c", "broken", "-q"),
    "rivals": choices()["rivals"]["tracking"],
    "tried": rival_data("carrot", TryoutTrial(scenario="fuzzy-on-path"))["label"],
}
print(json.dumps(told))
"""


@pytest.fixture(scope="module")  # installed by pip: seconds
def told(tmp_path_factory):
    """What fuzzyfleet's commands say once the package is installed."""
    from robotics.simulation.scenario.reading import scenario_names

    assert "fuzzy-on-path" in scenario_names()
    folder = tmp_path_factory.mktemp("carrot")
    source, site = folder / "source", folder / "site"
    (source / "carrot").mkdir(parents=True)
    (source / "pyproject.toml").write_text(PROJECT, encoding="utf-8")
    (source / "carrot" / "__init__.py").write_text(LAW, encoding="utf-8")
    quiet = ["--quiet", "--no-deps", "--no-build-isolation", "--no-index", "--target", str(site)]
    subprocess.run([sys.executable, "-m", "pip", "install", *quiet, str(source)], check=True, timeout=120)
    (folder / "gains.toml").write_text(SWEEP, encoding="utf-8")
    (folder / "short.toml").write_text(
        "duration = 1.0\n[[robots]]\nstart = [0.0, 0.0, 0.0]\ntiming = { speed = 0.2 }\n"
        'path = { shape = "line", start = [0.0, 0.0], end = [2.0, 0.0] }\n',
        encoding="utf-8",
    )
    paths = os.pathsep.join([str(site), *filter(None, [os.environ.get("PYTHONPATH")])])
    done = subprocess.run(
        [sys.executable, "-c", USES],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": paths},
        capture_output=True,
        text=True,
        check=False,
        timeout=240,
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout) | {"folder": folder}


def test_the_law_has_thirty_lines():
    assert len([line for line in LAW.splitlines() if line.strip()]) <= 30


@pytest.mark.long
def test_it_runs_with_its_gains(told):
    code, out, err = told["run"]
    assert (code, err) == (0, "")
    result = json.loads(out)
    assert result["controller"] == "carrot:gain=2.5"
    assert 0 < result["metrics"]["rms_cross_track_m"][0] < 0.1


@pytest.mark.long
def test_it_is_compared(told):
    code, _, err = told["compare"]
    assert (code, err) == (0, "")
    rows = (told["folder"] / "out" / "results.csv").read_text(encoding="utf-8")
    assert rows.count("\nshort,carrot,") == rows.count("\nshort,lyapunov,") == 1
    report = (told["folder"] / "out" / "report.html").read_text(encoding="utf-8")
    assert "Carrot" in report


@pytest.mark.long
def test_it_is_swept_and_stressed(told):
    assert told["sweep"][0] == 0, told["sweep"]
    code, out, _ = told["stress"]
    assert code == 0
    assert json.loads(out)["runs"] == 1


@pytest.mark.long
def test_the_designer_offers_it_for_comparison(told):
    assert ["carrot", "Carrot"] in told["rivals"]
    assert told["tried"] == "Carrot"


@pytest.mark.long
def test_one_that_cannot_be_loaded_is_said_and_harms_nobody(told):
    code, _, err = told["broken"]
    assert code == 2
    assert err.startswith(
        "robotics: the law 'broken' of the package carrot-on-a-stick cannot be loaded: AttributeError"
    )
    code, out, err = told["list"]
    assert code == 0
    assert "Carrot: a point 0.3 m ahead" in out
    assert "the law 'broken' of the package carrot-on-a-stick cannot be loaded" in err


@pytest.mark.parametrize("name", ["watchdgo", "mesage", "safety_distances"])
def test_a_misspelt_part_of_a_law_is_no_silence(name):
    with pytest.raises(TypeError, match=f"Bad.{name} is no part of a law; is .* meant"):
        type("Bad", (Law,), {name: ()})


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("lyapunov", "robotics.laws.tracking.lyapunov:Lyapunov", "has the name of one that comes with fuzzyfleet"),
        ("text", "robotics.laws.catalogue:LAW_ENTRY_POINTS", "must be a Preset, or a dataclass derived from Law"),
    ],
)
def test_what_is_no_law_is_refused_with_a_sentence(name, value, message, monkeypatch):
    entry = EntryPoint(name=name, value=value, group=catalogue.LAW_ENTRY_POINTS)
    monkeypatch.setattr(catalogue, "entry_points", lambda group: [entry])
    catalogue._installed.cache_clear()
    try:
        assert presets() == CATALOGUE
        ((_, reason),) = unusable_laws().items()
        assert message in reason
        if name == "text":
            with pytest.raises(InputError, match="must be a Preset"):
                make_controller("text")
        else:
            law: Any = make_controller("lyapunov")
            assert law.kx == 1.0
    finally:
        monkeypatch.undo()
        catalogue._installed.cache_clear()
