"""Whether a ranking of laws survives on robots that the simulator has never seen: hidden ones in MuJoCo.

    python -m benchmarks.transfer --robots 10 -o docs/explanation/transfer.json
    python -m benchmarks.transfer --draw docs/explanation/transfer.json docs/explanation/transfer.svg

Each robot is drawn around the EtsRo, and has what our plant has not, or does not by default: contacts whose tyres creep
and slip, castors that drag, wheel loops of another order, a dead band, rounded commands. It drives the minute of
`robotics excite`; `robotics identify` makes a robot of its log. Twelve laws then drive two scenarios in our simulator
and on the hidden robot, told of the identified robot, of that with wheels and axle of the data sheet, and of the
data sheet alone. The gains of one law are tuned on each. Rows are saved as they come, and robots
whose rows stand in the file are not asked again.
"""

import argparse
import json
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import minimize
from scipy.stats import spearmanr

from benchmarks.identification import SENSING, SHEET, log_of
from fuzzy.files.atomic import write_json
from robotics.laws.catalogue import make_controller
from robotics.laws.setting import TrueParameters
from robotics.plugins.identify.excitation import excite
from robotics.plugins.identify.identified import Identified, identify
from robotics.plugins.identify.replay import Program, replayed
from robotics.plugins.identify.robotfile import identified_text
from robotics.simulation.loop import record_run
from robotics.simulation.run import Run
from robotics.simulation.scenario.reading import load_scenario
from robotics.simulation.scenario.robots import RobotModel, load_robot, parse_robot

LAWS = (
    *("fuzzy", "fuzzy-correcting", "lyapunov", "pdc", "lqr", "pursuit", "pid", "csm", "assm", "qssm", "esm"),
    "lyapunov-lead-tuned",
)
SCENARIOS = ("lyapunov-sine", "fuzzy-off-path")
SETTLED = 5.0  # s, from which on errors count
STOPPED = 10.0  # m: the cost of a run that was stopped
AHEAD = 5.0  # s
TOLD = ("identified", "identified, sheet's sizes", "data sheet")
TUNING = 40  # evaluations, from the gains of the preset
GAINS = (1.0, 10.0, 5.0)  # kx, ky, kpsi: where both tunings begin


class Hidden:
    """A robot that nobody has seen: its numbers, its latency, and the ground in MuJoCo that it drives on."""

    def __init__(self, seed: int) -> None:
        sheet, draw = load_robot(SHEET).robot, np.random.default_rng([seed, 39])
        names = ("kp", "ki", "torque_constant", "friction_torque", "body_mass", "body_inertia")
        numbers = {name: getattr(sheet, name) * float(np.exp(0.2 * draw.standard_normal())) for name in names}
        numbers |= {"v_max": float(draw.uniform(0.6, 0.9)), "w_max": float(draw.uniform(3, 6))}
        numbers |= {
            "mass_offset": float(draw.uniform(-0.05, -0.01)),
            "counts_per_turn": float(draw.integers(800, 8000)),
        }
        numbers |= {"filter_frequency": float(draw.uniform(8, 25)), "dead_band": float(draw.uniform(0, 0.03))}
        numbers |= {"v_resolution": float(draw.choice([0.0, 0.01])), "w_resolution": float(draw.choice([0.0, 0.02]))}
        if draw.uniform() < 0.5:
            numbers["v_rate_max"] = float(draw.uniform(0.8, 4))
        self.robot, self.seed = sheet.changed(**numbers), seed
        self.latency = 0.01 * int(draw.integers(0, 21))
        friction, castor = draw.uniform(0.3, 0.9), draw.uniform(0.02, 0.25)
        self.ground = f"mujoco:friction={friction:.3f},castor_friction={castor:.3f}"

    def drive(self, program: Program) -> Run:
        """What it does by a program, as it is and as it is measured."""
        return replayed(
            self.robot, program, latency=self.latency, sensing=SENSING, seed=self.seed, plant=self.ground
        )  # fmt: skip


# Predictions ------------------------------------------------------------------------------------------------------


def steps_ahead(run: Run, measured: str = "") -> np.ndarray:
    """How far the robot comes within 5 s, seen from where it begins, as x + i y [m]."""
    x, y, heading = (run[f"{name}{measured}"][0, 0] for name in ("x", "y", "heading"))
    count = round(AHEAD / (run.time[1] - run.time[0]))
    begin = np.arange(0, len(x) - count, count // 2)
    return np.asarray((x + 1j * y)[begin + count] - (x + 1j * y)[begin]) * np.exp(-1j * heading[begin])


def prediction(one: Hidden, robots: dict[str, tuple[RobotModel, float]], program: Program) -> dict[str, float]:
    """RMS errors [m] of 5 s ahead on another drive, by each robot of our simulator, and of a measured pose itself."""
    other = Program(program.time, -program.v[::-1], program.w[::-1])
    driven = one.drive(other)
    true = steps_ahead(driven)
    wrong = {"noise": steps_ahead(driven, "_measured") - true}
    for name, (model, latency) in robots.items():
        wrong[name] = steps_ahead(replayed(model.robot, other, latency=latency)) - true
    return {name: float(np.sqrt((np.abs(each) ** 2).mean())) for name, each in wrong.items()}


# Rankings ---------------------------------------------------------------------------------------------------------


def cost(law: Any, told: tuple[RobotModel, float], seed: int, hidden: Hidden | None = None) -> float:
    """The RMS distance [m] from the reference after 5 s, the geometric mean over the scenarios.

    The law is ``told`` of a robot and its latency, which drives, or of which a ``hidden`` one is the truth.
    """
    model, latency = told
    found = []
    for name in SCENARIOS:
        setting = replace(load_scenario(name).with_robot(model), latency=latency).setting
        if hidden is not None:
            setting = replace(setting, truth=TrueParameters(robots=(hidden.robot,), latency=hidden.latency))
        run = record_run(setting, law, [seed], plant=hidden.ground if hidden else "")
        late = run.time >= SETTLED
        away = np.hypot(run["x"][0, 0] - run.reference[0, :, 0], run["y"][0, 0] - run.reference[1, :, 0])[late]
        found.append(float(np.sqrt((away**2).mean())) if np.isfinite(away).all() else STOPPED)
    return float(np.exp(np.mean(np.log(found))))


def tuned(told: tuple[RobotModel, float], seed: int) -> Any:
    """The Lyapunov law with the gains that are best for a robot of our simulator."""

    def law(logarithms: np.ndarray) -> Any:
        gains = np.exp(np.clip(logarithms, -3, 4))
        return make_controller("lyapunov:kx={:.4g},ky={:.4g},kpsi={:.4g}".format(*gains))

    search = minimize(
        lambda x: np.log(cost(law(x), told, seed)), np.log(GAINS), method="Nelder-Mead", options={"maxfev": TUNING}
    )
    return law(search.x)


def studied(seed: int, program: Program, say: Callable[[str], None]) -> dict[str, Any]:
    """All of one robot."""
    one, sheet = Hidden(seed), load_robot(SHEET)
    began = time.process_time()
    found: Identified = identify(log_of(one.drive(program), f"hidden-{seed}"), sheet, seed=0)
    used = time.process_time() - began
    mine = parse_robot(identified_text(found, SHEET), f"identified-{seed}")
    late = round(found.motion.value("latency") / 0.01) * 0.01
    sizes = {name: getattr(sheet.robot, name) for name in ("wheel_radius", "half_axle")}
    sized = replace(mine, robot=mine.robot.changed(**sizes))
    robots = dict(zip(TOLD, ((mine, late), (sized, late), (sheet, 0.0)), strict=True))
    row: dict[str, Any] = {
        "robot": seed,
        "ground": one.ground,
        "latency": [one.latency, float(found.motion.value("latency"))],
        "size": float(mine.robot.wheel_radius / sheet.robot.wheel_radius),
        "dead_band": [one.robot.dead_band, float(found.motion.value("dead_band"))],
        "identify_processor_s": used,
        "prediction_m": prediction(one, robots, program),
    }
    for name, told in robots.items():
        costs = {
            law: (cost(make_controller(law), told, seed), cost(make_controller(law), told, seed, one)) for law in LAWS
        }
        row[name] = {"costs": costs, **_ranked(np.array([*costs.values()]))}
        row[name]["tuned"] = cost(tuned(told, seed), told, seed, one)
        say(f"robot {seed}, told of {name}: ranks {row[name]['spearman']:.2f}, regret {row[name]['regret']:.1%}")
    return row


def _ranked(costs: np.ndarray) -> dict[str, float]:
    """Of costs (laws, 2) in our simulator and on the hidden robot."""
    here, there = costs.T
    return {
        "spearman": float(spearmanr(here, there).statistic),
        "regret": float(there[np.argmin(here)] / there.min() - 1),
        "ratio": float(np.median(there / here)),
    }


# Summary and figure -----------------------------------------------------------------------------------------------


def summary(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Medians over the robots, with 95 % intervals by a bootstrap over robots (percentiles of 10,000)."""
    draw = np.random.default_rng(0).integers(len(rows), size=(10_000, len(rows)))

    def median(values: list[float]) -> list[float]:
        each = np.array(values)
        low, high = np.quantile(np.median(each[draw], axis=1), [0.025, 0.975])
        return [float(np.median(each)), float(low), float(high)]

    found: dict[str, Any] = {"robots": len(rows)}
    for name in TOLD:
        found[name] = {key: median([row[name][key] for row in rows]) for key in ("spearman", "regret", "ratio")}
        predicted = [row["prediction_m"] for row in rows]
        found[name]["prediction_m"] = median([each[name] for each in predicted])
        found[name]["prediction_over_noise"] = median([each[name] / each["noise"] for each in predicted])
    found["tuned_identified_over_sheet"] = median([row[TOLD[1]]["tuned"] / row[TOLD[2]]["tuned"] for row in rows])
    return found


def draw(rows: list[dict[str, Any]], target: Path) -> None:
    """Draw the ranks, the regrets and the predictions, a point a robot."""
    from fuzzy.figures.drawing import new_figure, save_figure

    figure = new_figure(9.0, 3.2)
    axes = figure.subplots(1, 3)
    for k, name in enumerate(TOLD):
        values = (
            [row[name]["spearman"] for row in rows],
            [100 * row[name]["regret"] for row in rows],
            [1000 * row["prediction_m"][name] for row in rows],
        )
        for ax, each in zip(axes, values, strict=True):
            ax.plot(k + np.linspace(-0.15, 0.15, len(each)), each, "o", ms=4)
            ax.plot([k - 0.25, k + 0.25], [np.median(each)] * 2, "-k", lw=1)
    titles = ("Rank correlation of 12 laws", "Regret of the law chosen [%]", "5 s ahead, off by [mm]")
    for ax, title in zip(axes, titles, strict=True):
        ax.set_title(title, fontsize="medium")
        ax.set_xticks(range(3), ["identified", "identified,\nsheet's sizes", "data sheet"])
        ax.set_xlim(-0.5, 2.5)
    axes[1].set_yscale("symlog", linthresh=10)
    axes[1].set_ylim(-3, 20000)
    axes[1].set_yticks([0, 10, 100, 1000, 10000], ["0", "10", "100", "1000", "10000"])
    axes[2].set_yscale("log")
    save_figure(figure, target)


def main() -> None:
    """Study robots one by one; or draw what was found."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robots", type=int, default=20)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("-o", "--out", type=Path)
    parser.add_argument("--draw", nargs=2, type=Path, metavar=("RESULT.json", "PICTURE"))
    chosen = parser.parse_args()
    if chosen.draw:
        result, picture = chosen.draw
        draw(json.loads(result.read_text(encoding="utf-8"))["rows"], picture)
        return
    program = excite(load_robot(SHEET).robot, 3.0, 60.0).program
    rows: list[dict[str, Any]] = []
    if chosen.out is not None and chosen.out.exists():
        rows = json.loads(chosen.out.read_text(encoding="utf-8"))["rows"]
    done = {row["robot"] for row in rows}
    for seed in sorted({*range(chosen.first, chosen.first + chosen.robots)} - done):
        began = time.process_time()
        rows.append(studied(seed, program, lambda line: print(line, flush=True)))
        rows[-1]["processor_s"] = time.process_time() - began
        if chosen.out is not None:
            write_json(chosen.out, {"summary": summary(rows), "rows": rows})
    print(json.dumps(summary(rows), indent=1))


if __name__ == "__main__":
    main()
