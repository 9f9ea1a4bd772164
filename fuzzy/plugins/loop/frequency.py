"""Pictures in the frequency domain: Bode plots of linear controllers and loops, and describing functions."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from fuzzy.figures.drawing import COLUMN, new_figure, style
from fuzzy.figures.palette import COLORS
from fuzzy.plugins.loop.nlsys import describing_function
from fuzzy.system import Sugeno

_DASHES = ("-", "--", "-.", ":")


def plot_bode(systems: Mapping[str, Any], frequencies: Any = None) -> Figure:
    """Draw the frequency responses of linear systems of python-control: magnitude above, phase below.

    Args:
        systems: Systems of one input and one output by the names that the legend shows, such as those of
            :func:`fuzzy.plugins.loop.nlsys.linear_controller`.
        frequencies: [rad/s]; by default 300 from 0.01 to 100, for sampled systems up to half their rate.
    """
    with style():
        figure = new_figure(COLUMN, 3.6)
        above, below = figure.subplots(2, 1, sharex=True)
        for k, (name, system) in enumerate(systems.items()):
            sampled = isinstance(system.dt, (int, float)) and not isinstance(system.dt, bool) and system.dt > 0
            top = min(100.0, np.pi / system.dt * 0.999) if sampled else 100.0
            w = np.geomspace(0.01, top, 300) if frequencies is None else np.asarray(frequencies, dtype=float)
            response = np.asarray(system(np.exp(1j * w * system.dt) if sampled else 1j * w)).ravel()
            about = {"color": COLORS[k % len(COLORS)], "linestyle": _DASHES[k % len(_DASHES)], "label": name}
            above.semilogx(w, 20 * np.log10(np.abs(response)), **about)
            below.semilogx(w, np.degrees(np.unwrap(np.angle(response))), **about)
        above.set_ylabel("magnitude [dB]")
        below.set(ylabel="phase [°]", xlabel="angular frequency [rad/s]")
        if len(systems) > 1:
            above.legend()
        return figure


def plot_describing_function(fis: Sugeno, amplitudes: Any = None) -> Figure:
    """Draw the describing function of a rule base of one input and one output over the amplitude.

    Args:
        fis: The rule base.
        amplitudes: In the input's unit; by default 200 up to the larger end of its universe.
    """
    variable, output = fis.inputs[0], fis.outputs[0]
    largest = max(map(abs, variable.universe))
    a = np.linspace(largest / 200, largest, 200) if amplitudes is None else np.asarray(amplitudes, dtype=float)
    with style():
        figure = new_figure(COLUMN, 2.4)
        ax = figure.subplots()
        ax.plot(a, describing_function(fis, a).real, color=COLORS[0])
        ax.set_xlabel(f"amplitude of {variable.label}")
        unit = "/".join(u or "1" for u in (output.unit, variable.unit)) if output.unit or variable.unit else "1"
        ax.set_ylabel(f"describing function N [{unit}]")
        return figure
