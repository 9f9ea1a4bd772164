"""The figures of the article: ``python docs/paper/figures.py FOLDER`` writes crossings.png, noise.png and ranking.png.

The first two are of runs made now; the ranking is of ``docs/reference/arena.csv``, the summary.csv of a
``robotics arena``.
"""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from scipy.stats import binomtest

import fuzzy
import robotics

ARENA = Path(__file__).parent.parent / "reference" / "arena.csv"
GIVEN = {"lead=": "lead", "smooth=": "low-pass", "estimator=": "Kalman filter"}
NAMES = {
    "fuzzy-correcting": "fuzzy, nine rules",
    "mppi": "MPPI",
    "nmpc": "predictive control",
    "esm": "exponential sliding mode",
    "csm": "conventional sliding mode",
    "qssm": "quasi-continuous",
    "assm": "arbitrary second order",
    "pdc": "parallel compensation",
    "lqr": "LQR",
    "lyapunov": "Lyapunov",
    "pid": "PID",
    "fuzzy": "fuzzy rule base",
    "pursuit": "pure pursuit",
}
LAWS = {"rules of right of way": "right-of-way", "printed rules": "crash-literal", "no such rules": "virtual-structure"}


def crossings(runs: int = 200) -> Figure:
    """In how many random crossings of three robots some touch, with Wilson's 95 % interval."""
    figure = Figure(figsize=(5.2, 1.9), layout="constrained")
    ax = figure.subplots()
    for place, law in enumerate(LAWS.values()):
        count = int(robotics.stress_crossing(law, 3, range(runs)).collided.sum())
        low, high = binomtest(count, runs).proportion_ci(method="wilson")
        ax.plot([100 * low, 100 * high], [place, place], "-", color="0.5")
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


def called(law: str) -> str:
    """What the figure calls a law of the arena: its name, and what it is given."""
    name, _, gains = law.partition(":")
    given = [said for part, said in GIVEN.items() if part in gains]
    return NAMES[name] + (f" with {' and '.join(given)}" if given else "")


def ranking() -> Figure:
    """The arena's laws by their cost over that of tuned predictive control, as published and tuned."""
    table = pd.read_csv(ARENA)
    places = np.arange(len(table))
    figure = Figure(figsize=(5.8, 4.2), layout="constrained")
    ax = figure.subplots()
    for name, colour, said in (("published", "white", "as published"), ("tuned", "black", "tuned")):
        middle, low, high = (table[f"{name}_ratio{end}"].to_numpy() for end in ("", "_low", "_high"))
        ax.errorbar(
            middle,
            places,
            xerr=[middle - low, high - middle],
            fmt="o",
            color="black",
            markerfacecolor=colour,
            label=said,
        )
    ax.axvline(1.0, color="0.7", linewidth=0.8)
    ax.set_xscale("log")
    ticks = [0.7, 1, 2, 3, 5, 10]
    ax.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    ax.set_xticks([], minor=True)
    ax.set_yticks(places, [called(law) for law in table["law"]])
    ax.invert_yaxis()
    ax.set_xlabel("cost over that of tuned predictive control")
    ax.legend(loc="upper right")
    return figure


FIGURES = {"crossings.png": crossings, "ranking.png": ranking, "noise.png": noise}


def write(folder: Path) -> None:
    """Write all figures into ``folder``, which is made where there is none."""
    folder.mkdir(parents=True, exist_ok=True)
    with fuzzy.style():
        for name, draw in FIGURES.items():
            draw().savefig(folder / name, dpi=200)


if __name__ == "__main__":
    write(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
