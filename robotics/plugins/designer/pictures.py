"""The pictures of a set that show how a robot drives by a system."""

from collections.abc import Mapping
from functools import partial
from typing import Any

from fuzzy.figures.figureset import SetPicture
from fuzzy.system import Sugeno
from robotics.laws.catalogue import label
from robotics.plugins.designer.uses import TryoutError, uses_of
from robotics.show.figures.controllers import plot_paths


def path_pictures(fis: Sugeno, chosen: Mapping[str, Any]) -> list[SetPicture]:
    """The path of the trial that is ``chosen``, by default the one that suits the system; of others nothing.

    Raises an InputError where the run cannot be made.
    """
    file = chosen.get("file", "")
    try:
        uses_of(fis, file)
    except TryoutError:
        return []
    from robotics.plugins.designer.tryout import TryoutTrial, run_design, settled  # the simulator: only for robots

    trial = settled(fis, chosen.get("trial") or TryoutTrial(), file)
    run = run_design(fis, trial).run
    caption = f"{label(trial.law)} by {fis.name} on {trial.scenario}, seed {trial.seed}: paths and cross-track errors."
    return [SetPicture("path", "path", caption, draw=partial(plot_paths, run))]
