"""The pictures of a set that show a loop: its step response beside a PID, and the figures of both as a table."""

from collections.abc import Mapping
from contextlib import suppress
from functools import partial
from typing import Any

from matplotlib.figure import Figure

from fuzzy.figures.drawing import COLUMN, number, styled_figure
from fuzzy.figures.figureset import SetPicture
from fuzzy.figures.palette import ROLES
from fuzzy.plugins.loop.controller import LoopError, is_controller, roles_of
from fuzzy.plugins.loop.keptloop import design_settings, loop_of, pid_of, transfer_of
from fuzzy.plugins.loop.response import StepResponse, figure_rows, respond
from fuzzy.plugins.loop.scheduledrules import along_points, ruled_pid
from fuzzy.plugins.loop.stepfigure import plot_step_response
from fuzzy.system import Sugeno

_LINE = 0.18  # inches


def step_pictures(fis: Sugeno, chosen: Mapping[str, Any]) -> list[SetPicture]:
    """The step response of the loop that goes with a controller, and its figures; of others nothing.

    Raises LoopError where the plant is a file, which nobody has chosen here.
    """
    if not is_controller(fis):
        return []
    settings = design_settings(fis)
    if settings["source"]:
        raise LoopError(f"its plant is {settings['source']}; `fuzzy step --plant FILE --plot PICTURE` draws it")
    plant = transfer_of(settings)
    loop = along_points(plant, loop_of(settings))
    roles = {name: role for name, role in settings["roles"].items() if role}
    responses = {fis.name: respond(fis, plant, loop, roles_of(fis, roles))}
    with suppress(LoopError):  # no rule makes one for this plant
        responses["PID"] = respond(pid_of(settings) or ruled_pid(plant, loop), plant, loop)
    beside = " beside a PID" if len(responses) > 1 else ""
    about = f"{fis.name}{beside} on the plant {plant}"
    return [
        SetPicture("step", "step-response", f"Step response of {about}.", draw=partial(plot_step_response, responses)),
        SetPicture("table", "step-figures", f"What the step response of {about} is judged by.",
                   draw=partial(plot_step_figures, responses)),
    ]  # fmt: skip


def plot_step_figures(responses: Mapping[str, StepResponse]) -> Figure:
    """Draw the figures of step responses as a table: a row a figure, a column a controller."""
    rows = figure_rows(responses)
    with styled_figure(COLUMN, _LINE * (len(rows) + 2), constrained=False) as figure:
        ax = figure.add_axes((0, 0, 1, 1))
        ax.set(xlim=(0, 1), ylim=(len(rows) + 1.5, -0.5))
        ax.axis("off")
        places = [0.98 - 0.2 * k for k in reversed(range(len(responses)))]
        for place, name in zip(places, responses, strict=True):
            ax.text(place, 0, name, ha="right", va="center", weight="bold", parse_math=False)
        for line, (title, values) in enumerate(rows, 1):
            ax.axhline(line - 0.5, color=ROLES["line"].light, linewidth=0.5)
            ax.text(0.02, line, title, va="center")
            for place, value in zip(places, values, strict=True):
                ax.text(place, line, "–" if value is None else number(value), ha="right", va="center")
        return figure
