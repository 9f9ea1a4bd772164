"""The order of the files: long ones first, so that both workers have something to do until the end.

Two workers share two cores: threads of their own in every linear algebra call would only wait for each other.
"""

import os
import signal
import tomllib
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")  # before anything imports numpy or torch; commands that are started inherit it

# A busy machine is no fault of the code.
settings.register_profile("without a clock", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("without a clock")

# A shell ignores Ctrl-C for what it starts in the background; the tests of interruptions send it.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# Files that take long although they hold few tests; the option --no-loadscope-reorder keeps this order.
LONG = (
    "test_formation_learning.py",
    "test_team_chapter.py",
    "test_avoidance_chapter.py",
    "test_crossings.py",
    "test_stress_command.py",
    "test_readme.py",
    "test_sweep_command.py",
    "test_coordination.py",
    "test_own_formation.py",
    "test_laws_of_other_packages.py",
    "test_study.py",
    "test_own_robot.py",
    "test_learning_report.py",
    "test_inference.py",
    "test_jit.py",
    "test_compiled.py",
    "test_player.py",
    "test_animation.py",
    "test_designer_page.py",
    "test_designer_modules.py",
    "test_designer_panels.py",
    "test_wheel.py",
    "test_right_of_way.py",
    "test_crash_avoidance.py",
    "test_obstacle_stress.py",
    "test_report.py",
    "test_sweep.py",
    "test_sonar.py",
    "test_robotics_command.py",
    "test_team_simulation.py",
    "test_estimator.py",
)


def pytest_collection_modifyitems(items):
    """Files of LONG first, in its order; the others as they were collected."""
    place = {name: k for k, name in enumerate(LONG)}
    items.sort(key=lambda item: place.get(item.path.name, len(LONG)))


@pytest.fixture
def site(tmp_path_factory, monkeypatch):
    """A folder of installed packages that is searched first; in it fuzzyfleet, as this tree's pyproject.toml has it."""
    folder = tmp_path_factory.mktemp("site")
    project = tomllib.loads((Path(__file__).parent.parent / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    declare(folder, project["name"], project["entry-points"])
    monkeypatch.syspath_prepend(folder)
    return folder


def declare(site, name, groups):
    """Write the metadata of an installed package ``name`` into ``site``: its entry points, by group and by name."""
    about = site / f"{name.replace('-', '_')}-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n", encoding="utf-8")
    lines = [
        line for group, points in groups.items() for line in (f"[{group}]", *(f"{k} = {v}" for k, v in points.items()))
    ]
    (about / "entry_points.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")
