"""Modules by the names that they had before they were moved: the same ones, and a warning says the new name."""

import importlib
import pickle
import subprocess
import sys
import warnings

import pytest

import robotics
from fuzzy.renamed import name_now
from robotics.world.paths.path import Line

MOVED = {
    "robotics.vehicle.plant": "robotics.world.vehicle.plant",
    "robotics.paths": "robotics.world.paths",
    "robotics.radio.graph": "robotics.world.radio.graph",
    "robotics.environment.world": "robotics.world.environment.world",
    "robotics.sensing.posture": "robotics.world.sensing.posture",
    "robotics.random_streams": "robotics.world.random_streams",
    "robotics.scenario.reading": "robotics.simulation.scenario.reading",
    "robotics.statistics.costs": "robotics.measures.statistics.costs",
    "robotics.experiments.learning.drivedata": "robotics.plugins.logs.drivedata",
    "robotics.laws.predictive.nmpc": "robotics.plugins.predictive.nmpc",
    "robotics.show.report.arena": "robotics.plugins.arena.report",
    "robotics.report.learning": "robotics.plugins.learning.report",
    "robotics.experiments.learning.courses": "robotics.plugins.learning.demonstrations",
    "robotics.plugins.logs.resampling": "robotics.plugins.logs.drivedata",
    "robotics.studies.stress.crossings": "robotics.plugins.stress.crossings",
    "robotics.studies.certificate": "robotics.plugins.certificates.certificate",
    "robotics.studies.lemma": "robotics.plugins.thesis.lemma",
    "robotics.tuning.cost": "robotics.studies.tuning.cost",
    "robotics.arena.description": "robotics.plugins.arena.description",
    "robotics.figures.team": "robotics.show.figures.team",
    "robotics.figures.sonar": "robotics.plugins.encounters.modes",
    "robotics.laws.preset": "robotics.laws.law",
    "robotics.playback.player": "robotics.show.playback.player",
    "robotics.report.study": "robotics.show.report.study",
    "robotics.show.figures.states": "robotics.plugins.thesis.states",
    "robotics.commands.crew": "robotics.plugins.stress.crew",
    "robotics.designer": "robotics.plugins.designer",
    "robotics.starts": "robotics.plugins.designer.starts",
    "robotics.ccode.terms": "robotics.plugins.ccode.terms",
    "robotics.logs.names": "robotics.plugins.logs.names",
    "robotics.reinforcement.task": "robotics.plugins.reinforcement.task",
    "robotics.thesis.claims": "robotics.plugins.thesis.claims",
}


@pytest.fixture(autouse=True)
def nothing_yet(monkeypatch):
    """Nothing has been imported by a former name."""
    for name in [*sys.modules]:
        if name_now(name):
            monkeypatch.delitem(sys.modules, name)


@pytest.mark.parametrize(("former", "now"), MOVED.items())
def test_a_former_name_is_the_same_module(former, now):
    with pytest.warns(DeprecationWarning, match="is now") as told:
        module = importlib.import_module(former)
    assert module is importlib.import_module(now)
    assert module.__name__ == module.__spec__.name == now
    assert str(told[-1].message) == f"{former} is now called {now}; the old name goes in the next release"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert importlib.import_module(former) is module  # once told, once done


def test_the_name_for_laws_of_ones_own_stays():
    from fuzzy.quantity import quantity

    assert importlib.import_module("robotics.quantity").quantity is quantity
    assert getattr(robotics, "quantity").quantity is quantity  # noqa: B009


def test_who_imports_is_told():
    code = (
        "import robotics\nprint(robotics.vehicle.__name__)\n"
        "from robotics.paths.path import Line\nprint(Line.__module__)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout.split() == ["robotics.world.vehicle", "robotics.world.paths.path"]
    assert "<string>:3: DeprecationWarning: robotics.paths.path is now called robotics.world.paths.path" in done.stderr


def test_what_was_pickled_by_a_former_name_is_read():
    with pytest.warns(DeprecationWarning, match="is now called robotics.world.paths"):
        assert pickle.loads(b"crobotics.paths.path\nLine\n.") is Line


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
@pytest.mark.parametrize(("name", "missing"), [("paths.nothing", "world.paths.nothing"), ("path", "path")])
def test_what_never_was_is_not_found(name, missing):
    with pytest.raises(ModuleNotFoundError, match=f"'robotics.{missing}'"):
        importlib.import_module(f"robotics.{name}")
