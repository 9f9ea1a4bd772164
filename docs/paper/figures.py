"""The figures of the article: ``python docs/paper/figures.py FOLDER`` writes crossings.png and noise.png."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from scipy.stats import binomtest

import robotics

LAWS = {"rules of right of way": "right-of-way", "printed rules": "crash-literal", "no such rules": "virtual-structure"}


def crossings(runs: int = 200) -> Figure:
    """In how many random crossings of three robots some touch, with Wilson's 95 % interval."""
    figure = Figure(figsize=(5.2, 1.9), layout="constrained")
    ax = figure.subplots()
    for place, law in enumerate(LAWS.values()):
        count = int(robotics.stress_crossing(law, 3, range(runs)).collided.sum())
        low, high = binomtest(count, runs).proportion_ci(method="wilson")
        ax.plot([100 * low, 100 * high], [place, place], color="0.5")
        ax.plot(100 * count / runs, place, "o", color="black")
    ax.set_yticks(np.arange(len(LAWS)), list(LAWS))
    ax.set_ylim(len(LAWS) - 0.5, -0.5)
    ax.set_xlim(-2, 100)
    ax.set_xlabel(f"runs in which robots touch [%], of {runs}")
    return figure


def noise(seeds: int = 10) -> Figure:
    """The variation of the demanded turn rate over the sensor's noise, for four laws on a sine."""
    levels = np.array([0.0, 1.0, 2.0, 3.0, 5.0])  # mm and mrad
    figure = Figure(figsize=(5.2, 2.6), layout="constrained")
    ax = figure.subplots()
    sine = robotics.load_scenario("lyapunov-sine")
    for law, style in (("fuzzy", "-"), ("lyapunov", "--"), ("csm", "-."), ("esm", ":")):
        varied = []
        for level in levels / 1000:
            sensing = robotics.Sensing(posture="pose", position_noise=level, heading_noise=level)
            run = robotics.simulate(replace(sine, sensing=sensing), law, seeds=range(seeds))
            varied.append(float(robotics.measure_all(run)["w_variation_late_radps2"].mean()))
        ax.plot(levels, varied, style, marker="o", markersize=3, label=law)
    ax.set_xlabel("noise of the measured position [mm] and heading [mrad]")
    ax.set_ylabel("variation of the\nturn rate [rad/s²]")
    ax.legend(ncols=2)
    return figure


FIGURES = {"crossings.png": crossings, "noise.png": noise}


def write(folder: Path) -> None:
    """Write all figures into ``folder``, which is made where there is none."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, draw in FIGURES.items():
        draw().savefig(folder / name, dpi=200)


if __name__ == "__main__":
    write(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
