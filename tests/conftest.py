"""The order of the files: long ones first, so that both workers have something to do until the end.

Two workers share two cores: threads of their own in every linear algebra call would only wait for each other.
"""

import os

for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")  # before anything imports numpy or torch; commands that are started inherit it

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
