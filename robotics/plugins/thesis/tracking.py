"""The report's chapter on one robot: the tracking laws, and the thesis's claims about them; thesis 2 and 5.4.

Everything is driven with noise, by as many seeds as a verdict needs, and without noise where a claim is about an ideal.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import product
from math import pi
from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure

from fuzzy.figures.drawing import PAGE_WIDTH
from robotics.laws.catalogue import CATALOGUE, label, make_controller
from robotics.laws.tracking.sliding_mode import SlidingMode, attraction
from robotics.measures.quantities import MEASURED_QUANTITIES, measured
from robotics.plugins.certificates.basins import Basin, plot_basins, sampled_basin
from robotics.plugins.certificates.loopmodel import LoopModel
from robotics.plugins.thesis import figures
from robotics.plugins.thesis.claims import Needed, judged, needed
from robotics.plugins.thesis.driving import experiments_of
from robotics.plugins.thesis.experiment import Effort, Experiment
from robotics.plugins.thesis.lemma import judge_lemma
from robotics.plugins.thesis.rows import TABLES, TEXTS, mean_cell
from robotics.show.report.chapter import Chapter, Claim, Grid, Picture
from robotics.show.report.claims import run_name
from robotics.simulation.loop import simulate
from robotics.simulation.run import Run
from robotics.simulation.scenario.description import Scenario
from robotics.simulation.scenario.reading import load_scenario
from robotics.simulation.scenario.robots import standard_robot
from robotics.studies.together import run_together
from robotics.world.paths.path import Sine
from robotics.world.paths.trajectory import Timing
from robotics.world.sensing.posture import Sensing

_MODES = ("csm", "assm", "qssm", "esm")
REALISATIONS = ("torque", "velocity")
TABLE = "table-2-1"
# Table 2.1 as printed: means of |x_err| [m], |y_err| [m], |ψ_err| [rad], norm ("MSE"), speed error ("Chatter")
PRINTED_TRACKING = {mode: tuple(row) for mode, row in TABLES.table("printed.tracking").items()}
_COLUMNS = TABLES.table("columns")  # of that table
CONDITIONS, SURFACE = "conditions of Table 2.1", "the surface"  # experiments, as claims call them
_STARTS = "random starts"
_FALL = "V' of (2.34)"
SWEEP_NOISE = 0.005  # m
# As printed, repaired, tuned, correcting, and two without rules; references as the designer's certificate assumes them
CERTIFIED_LAWS = ("fuzzy-literal", "fuzzy", "fuzzy-tuned", "fuzzy-correcting:smooth=0", "lyapunov", "esm")
CERTIFIED_REFERENCES = LoopModel(speed_low=0.2, speed_high=0.4, curvature=0.5)

Results = Mapping[Any, Any]


class _Condition(NamedTuple):
    """One cell of the sweep around Table 2.1."""

    amplitude: float  # m
    x_rate: float  # m/s
    latency: float  # s


_SWEEP = [_Condition(*c) for c in product((0.5, 1.0), (0.2, 0.3, 0.4), (0.02, 0.03, 0.04))]


def experiments(folder: str, seed: int, effort: Effort) -> list[Experiment]:
    """The experiments of the chapter, with ``effort.seeds`` seeds from ``seed`` on; ``folder`` does not matter."""
    wanted, seeds = needed("tracking"), effort.row(seed)
    shared = range(seed, seed + -(-effort.trials // len(_SWEEP)))  # all conditions together are the runs of a rate
    return [
        *experiments_of([*wanted, *(Needed(TABLE, mode, False) for mode in _MODES)], seeds),
        *(
            Experiment((CONDITIONS, r, m), partial(_swept, r, m, shared), partial(_sweep_files, r, m, shared))
            for r in REALISATIONS
            for m in _MODES
        ),
        *(
            Experiment(need, partial(_placed, *of), partial(_placed_files, need, *of))
            for need, of in ((need, (need.of, seed, effort.trials)) for need in wanted if need.on == _STARTS)
        ),
        *(
            Experiment(
                (Basin, law), partial(sampled_basin, law, standard_robot().robot, CERTIFIED_REFERENCES, seed=seed)
            )
            for law in CERTIFIED_LAWS
        ),
    ]


def chapter_of(results: Results) -> Chapter:
    """Write the chapter from the results of its experiments."""
    return TEXTS.chapter(
        "tracking",
        tables=[_table_2_1(results), _origins(), _proven(results)],
        pictures=[*_pictures(), TEXTS.picture("law-basins", partial(plot_basins, _basins(results)))],
        claims=claims_of(results),
    )


def claims_of(results: Results) -> list[Claim]:
    """Judge the claims of chapter 2, and that of 5.4 about one robot, from the experiments' results."""
    return judged("tracking", partial(_values, results))


def _values(results: Results, need: Needed, quantity: str, robots: str) -> np.ndarray:
    if need.on == CONDITIONS:
        return np.asarray(_orders({mode: results[CONDITIONS, need.of, mode] for mode in _MODES})[quantity])
    if need.on == SURFACE:
        return np.array([reaching_time(need.of)])
    if need.on == _FALL:  # (2.34) is (4.9) with S̃' = 0
        return np.array([next(c.worst for c in judge_lemma() if c.name == "3")])
    found = results[need]
    return found if isinstance(found, np.ndarray) else measured(found, quantity, robots)


def _table_2_1(results: Results) -> Grid:
    rows = []
    for mode, printed in PRINTED_TRACKING.items():
        run = results[Needed(TABLE, mode, False)]
        ours = (f"{label(mode)}: here", *(mean_cell(run, name) for name in _COLUMNS))
        rows += [(f"{label(mode)}: thesis", *(f"{v:.4f}" for v in printed)), ours]
    return TEXTS.grid("tracking.table-2-1", rows, table=TABLE, seeds=len(run.seeds))


def _origins() -> Grid:
    rows = [(preset.title, name, preset.note) for name, preset in CATALOGUE.items() if preset.kind == "tracking"]
    return TEXTS.grid("tracking.origins", rows)


def _basins(results: Results) -> list[Basin]:
    return [results[Basin, law] for law in CERTIFIED_LAWS]


def _proven(results: Results) -> Grid:
    rows = []
    for basin in _basins(results):
        came, found = f"{100 * basin.came.mean():.1f} % of {len(basin.came)}", basin.found
        if found is None:
            rows.append((label(basin.law), came, "", "", f"not certified: {basin.why}"))
            continue
        x, y, heading = found.half_widths()
        volume, area = (f"{100 * share:.2g} %" for share in basin.shares)
        reach = f"X ±{x:.2g} m, Y ±{y:.2g} m, ψ ±{heading:.2g} rad"
        rows.append((label(basin.law), came, volume, area, reach))
    return TEXTS.grid("tracking.proven", rows, model=CERTIFIED_REFERENCES)


def _pictures() -> list[Picture]:
    plots: dict[str, Callable[..., Figure]] = {
        "law-switching": figures.plot_switching,
        "law-memberships": figures.plot_tracking_memberships,
        "law-velocities": figures.plot_tracking_velocities,
        "law-lateral": partial(figures.plot_turn, "lateral"),
    }
    return [TEXTS.picture(name, partial(plot, width=PAGE_WIDTH)) for name, plot in plots.items()]


# Runs -------------------------------------------------------------------------------------------------------------


def _swept(realisation: str, mode: str, seeds: Sequence[int]) -> np.ndarray:
    """The mean error norm and the mean speed error in all conditions of the sweep (2, conditions, seeds)."""
    found = _sweep(realisation, mode, seeds)
    names = ("mean_error_norm", "mean_speed_error_mps")
    return np.array([[measured(found[c], name) for c in _SWEEP] for name in names])


def _sweep_files(realisation: str, mode: str, seeds: Sequence[int]) -> Iterator[tuple[str, Run]]:
    for k, run in enumerate(_sweep(realisation, mode, seeds).values()):
        yield run_name(f"{CONDITIONS} {k}", f"{realisation}-{mode}"), run


def _sweep(realisation: str, mode: str, seeds: Sequence[int]) -> dict[_Condition, Run]:
    law = f"{mode}:realisation={realisation}"
    found: dict[_Condition, Run] = {}
    for latency in sorted({c.latency for c in _SWEEP}):  # scenarios that are driven together share it
        cells = [c for c in _SWEEP if c.latency == latency]
        runs = run_together([_condition_scenario(c) for c in cells], law, seeds)
        found |= dict(zip(cells, runs, strict=True))
    return {c: found[c] for c in _SWEEP}


def _condition_scenario(condition: _Condition) -> Scenario:
    member = load_scenario("reference").robots[0]
    path = Sine(amplitude=condition.amplitude, phase=pi / 2, x_end=condition.x_rate * 25.0 + 0.5)
    sensing = Sensing(posture="pose", position_noise=SWEEP_NOISE)
    member = replace(member, start=(0.0, condition.amplitude, 0.0), path=path, timing=Timing(x_rate=condition.x_rate))
    return Scenario(name="sweep", robots=(member,), duration=25.0, latency=condition.latency, sensing=sensing)


def _placed(law: str, seed: int, places: int) -> np.ndarray:
    """Whether the robot settles from each of so many random places around the beginning of the S-curve (places,)."""
    return MEASURED_QUANTITIES["settles"].measure(_placed_run(law, seed, places))[0]


def _placed_files(need: Needed, law: str, seed: int, places: int) -> Iterator[tuple[str, Run]]:
    yield run_name(need.on, need.of), _placed_run(law, seed, places)


def _placed_run(law: str, seed: int, places: int) -> Run:
    scenario = load_scenario("fuzzy-on-path")
    member = scenario.robots[0]
    x, y, _ = member.start
    random = np.random.default_rng([seed, 2010])
    offsets = random.uniform(-1.5, 1.5, (places, 2))
    headings = random.uniform(-pi, pi, places)
    starts = [(x + dx, y + dy, h) for (dx, dy), h in zip(offsets.tolist(), headings.tolist(), strict=True)]
    # One scenario with a robot for each place: these robots do not see each other.
    crowd = replace(scenario, robots=tuple(replace(member, start=start) for start in starts))
    return simulate(crowd, make_controller(law), [seed])


# What decides -----------------------------------------------------------------------------------------------------


def _orders(cells: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Whether the orders of Table 2.1 hold in each run of the sweep (conditions · seeds,), by what they say.

    ``cells`` are by mode, as :func:`_swept` gives them.
    """
    norm, chatter = ({mode: found[k] for mode, found in cells.items()} for k in (0, 1))

    def leads(values: Mapping[str, np.ndarray], mode: str, sign: float) -> np.ndarray:
        others = [sign * v for name, v in values.items() if name != mode]
        return np.asarray(sign * values[mode] < np.min(others, axis=0))

    orders = leads(norm, "esm", 1), leads(chatter, "esm", 1), leads(norm, "csm", -1), leads(chatter, "csm", -1)
    found = {"all_four_orders": np.all(orders, axis=0), "esm_most_precise": orders[0], "esm_chatters_least": orders[1]}
    found["esm_chatters_less_than_csm"] = chatter["esm"] < chatter["csm"]
    return {name: values.ravel() for name, values in found.items()}


def reaching_time(specification: str, start: float = 0.45) -> float:
    """The ideal time [s] from S = ``start`` [m/s] to 0, by quadrature of dS / (K/Q(S)): (2.16), (2.23)."""
    law = make_controller(specification)
    assert isinstance(law, SlidingMode)
    s = np.linspace(0.0, start, 4501)
    q = attraction(s, law.mu0, law.alpha) if law.mode == "esm" else np.ones_like(s)
    return float(np.trapezoid(q / law.k, s))
