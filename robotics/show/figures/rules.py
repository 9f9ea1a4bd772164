"""The rules that decided at one time of a run, as a rule viewer: the thesis's Figs 5.9 and 6.24 for a run's own state.

Importing this module imports matplotlib.
"""

from dataclasses import replace

import numpy as np
from matplotlib.figure import Figure

from fuzzy.figures.ruleviewer import plot_rules
from fuzzy.naming import check_known
from robotics.measures.decisions import decisions
from robotics.show.figures.drawing import PlotError, page_title
from robotics.simulation.run import Run
from robotics.simulation.spans import seed_place

_FEW = 12  # rules; of a larger rule base only those that fired are drawn


def plot_rules_at(run: Run, time: float, *, robot: int = 1, task: str | None = None, seed: int | None = None) -> Figure:
    """Draw the rules of a rule base, and how strongly each fired for a robot at one time.

    Inputs and outputs have the units of the rule base. Of more than 12 rules those that did not fire are left out.

    Args:
        run: A run whose law has rule bases.
        time: The time [s]; what was decided at the last sample before it held then.
        robot: The robot, from 1.
        task: The rule base, by the task that it has in the law; by default the first.
        seed: The seed, by default the first.

    Raises:
        PlotError: A robot, a time or a task that the run does not have.
        DecisionError: A run that does not say what its rule bases were asked.
        ReplayError: A seed that was not run.
    """
    place, robots = seed_place(run, seed), run.samples.shape[3]
    first, last = float(run.time[0]), float(run.time[-1])
    if not 1 <= robot <= robots:
        raise PlotError(f"the robots of the run are 1 to {robots}, there is no robot {robot}")
    if not first <= time <= last:
        raise PlotError(f"the run lasts from {first:g} to {last:g} s; there is nothing at {time:g} s")
    k = int(np.searchsorted(run.time, time + 1e-9, side="right")) - 1
    asked = {each.task: each for each in decisions(run, place, slice(k, k + 1))}
    task = next(iter(asked)) if task is None else task
    check_known(task, asked, "task", PlotError)
    x, fis = asked[task].inputs[0, robot - 1].astype(float), asked[task].system
    if not np.isfinite(x).all():
        raise PlotError(f"at {time:g} s the rule base {task!r} of robot {robot} was not asked: the robot was stopped")
    quiet = replace(fis, out_of_range="ignore") if fis.out_of_range == "warn" else fis
    title = f"{page_title(run, [place])}: {task}, robot {robot} at {run.time[k]:g} s"
    return plot_rules(quiet, x, only_fired=len(fis.rules) > _FEW, title=title)
