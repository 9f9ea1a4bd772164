"""The report's chapter on leader-follower formations: data, clusters, learning, driving; thesis 5.2.

It generates both data sets, learns four networks from each, drives the two experiments of 5.2.3 with the networks
learnt from the well-posed set, with the analytic law and with the thesis's own systems, and judges the claims.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache, partial
from itertools import product
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np

import anfis
from anfis.plot import plot_fit, plot_premises, plot_training
from fuzzy.figures.search import plot_rules_error
from fuzzy.figures.structure import plot_structure
from robotics.experiments.learning.formationdata import Recipe, Table, checking, conditional_mean_floor, formation_data
from robotics.experiments.learning.formationlearning import Learnt, learn_network, write_networks
from robotics.figures.run import plot_run
from robotics.laws.catalogue import make_controller
from robotics.laws.formation.leader_follower import OUTPUTS, load_networks
from robotics.measures.formations import measure_formation
from robotics.report.chapter import Chapter, Claim, Grid, Picture, Verdict
from robotics.scenario.reading import load_scenario
from robotics.simulation.loop import simulate
from robotics.simulation.run import Run
from robotics.thesis.experiment import Experiment

EXPERIMENTS = ("formation-behind", "formation-ahead")
# The variants: specification (NETWORKS is the folder of the networks just learnt) and title
VARIANTS = {
    "formation:networks=NETWORKS,correction=own-pose": "networks, followers corrected by their own pose",
    "formation:networks=NETWORKS,correction=none": "networks, followers open loop (thesis)",
    "formation:networks=thesis,correction=none": "the thesis's own systems, open loop",
    "formation-teacher": "analytic law (the teacher)",
}
# Table 5.1: the thesis's training errors, in the outputs' units
THESIS_ERRORS = {"v_l": 7.997e-3, "w_l": 2.011e-3, "v_f": 8.287e-4, "w_f": 2.757e-3}


Kind = Literal["literal", "well-posed"]
SETS: tuple[Kind, ...] = ("literal", "well-posed")  # the kinds of formation data


class _Data(NamedTuple):
    """A set of formation data."""

    table: Table
    check: Table  # the checking set of learning
    along: Table  # one run along the path, in the order of time, for the pictures


def experiments(folder: str, seed: int = 0) -> list[Experiment]:
    """The experiments of the chapter, with ``seed``: both data sets, their networks, and all variants driven.

    Networks learnt from the well-posed set go to ``folder``/networks, from where they drive. Running may raise OSError.
    """
    networks = Path(folder) / "networks"
    return [
        *(Experiment(("data", kind), partial(_data, kind, seed)) for kind in SETS),
        *(Experiment(("learnt", *which), partial(_learnt, *which, seed, networks)) for which in product(SETS, OUTPUTS)),
        *(
            Experiment(("driven", experiment, title), partial(_driven, experiment, title, seed, networks))
            for experiment, title in product(EXPERIMENTS, VARIANTS.values())
        ),
    ]


@lru_cache(maxsize=2)
def _data(kind: Kind, seed: int) -> _Data:
    recipe = Recipe(kind=kind, seed=seed)
    check = formation_data(checking(recipe))
    along = check if kind == "literal" else formation_data(replace(checking(recipe), coverage=0.0, jitter=0.0))
    return _Data(formation_data(recipe), check, along)


def _learnt(kind: Kind, output: str, seed: int, networks: Path) -> Learnt:
    data = _data(kind, seed)
    # On the curve x, y and θ hang together: without a ridge, huge consequents tell formations apart by rounding.
    options = anfis.Options(epochs=60, ridge=1e-10) if kind == "literal" else anfis.Options(epochs=60)
    learnt = learn_network(output, data.table.names, data.table.values, data.check.values, options=options)
    if kind == "well-posed":
        write_networks([learnt], networks)
    return learnt


def _driven(experiment: str, title: str, seed: int, networks: Path) -> Run:
    specification = next(law for law, name in VARIANTS.items() if name == title)
    law = make_controller(specification.replace("NETWORKS", str(networks)))
    return simulate(load_scenario(experiment), law, [seed], name=title)


def chapter_of(results: Mapping[tuple[Any, ...], Any]) -> Chapter:
    """Write the chapter from the results of its experiments."""
    learnt: dict[str, list[Learnt]] = {kind: [results["learnt", kind, output] for output in OUTPUTS] for kind in SETS}
    runs = {(key[1], key[2]): run for key, run in results.items() if key[0] == "driven"}
    literal = results["data", "literal"].table.values
    found = conditional_mean_floor(literal[:, 0], literal[:, 3:])
    floor = dict(zip(OUTPUTS, found.tolist(), strict=True))
    return Chapter(
        "formation",
        "Leader and followers: learning from formation data (thesis 5.2)",
        (
            "One network each for the leader's and the followers' linear and angular speed. Inputs are the leader's "
            "posture and, in the well-posed set, its lead dx over the followers. The search over the settings of "
            "subtractive clustering takes the best for 8 rules (or as near as any comes); hybrid learning then runs "
            "for 60 epochs, and the network of least checking error is kept.",
            "The literal set is the thesis's: 5 formations of 400 samples on the curve, inputs x, y and θ of the "
            "leader. What the robots shall do depends on where the followers are, which these inputs do not tell.",
        ),
        [
            _table_5_1("literal", learnt["literal"], floor),
            _table_5_1("well-posed", learnt["well-posed"], None),
            _driving(runs),
        ],
        _antecedents_and_consequents(learnt["well-posed"]),
        [
            *_learning_pictures(learnt, {kind: results["data", kind].along for kind in SETS}),
            *_driving_pictures(runs),
        ],
        _claims(learnt, runs, floor),
        folded="Parameters of the networks, ours and the thesis's",
    )


def _table_5_1(kind: str, networks: Sequence[Learnt], floor: dict[str, float] | None) -> Grid:
    rows = []
    for network in networks:
        trial, training = network.trial, network.training
        best = training.history[training.best]
        rows.append(
            (
                network.output,
                str(trial.rules),
                f"{trial.radius:g}, {trial.options.squash:g}, {trial.options.accept:g}, {trial.options.reject:g}",
                f"{THESIS_ERRORS[network.output]:.2e}",
                f"{training.history[0].train:.2e}",
                f"{best.train:.2e}",
                f"{best.check:.2e}",
                "" if floor is None else f"{floor[network.output]:.2e}",
            )
        )
    return Grid(
        f"Table 5.1 beside ours, {kind} set: RMSE in m/s and rad/s."
        + (" The floor: what no function smooth over 5 cm goes below." if floor is not None else ""),
        (
            "network",
            "rules",
            "radius, squash, accept, reject",
            "thesis, clustering",
            "clustering",
            "learnt, training",
            "learnt, checking",
            "floor",
        ),
        rows,
    )


def _antecedents_and_consequents(networks: Sequence[Learnt]) -> list[Grid]:
    """Tables 5.2 to 5.5 in the thesis's form: ours, and the thesis's as printed."""
    printed = {fis.outputs[0].name: fis for fis in load_networks("thesis")}
    grids = []
    for network in networks:
        for title, fis in (("ours, trained", network.after), ("thesis", printed[network.output])):
            rows = []
            for r, rule in enumerate(fis.rules):
                clauses = {c.variable: c.term for c in rule.when}
                shapes = [v.terms[clauses[v.name]] for v in fis.inputs]
                plane = fis.outputs[0].terms[rule.then[0][1]]
                rows.append(
                    (
                        str(r + 1),
                        *(f"{abs(s.sigma):.4g}, {s.c:.4g}" for s in shapes),
                        *(f"{p:.4g}" for p in plane.parameters),
                    )
                )
            names = [v.name for v in fis.inputs]
            grids.append(
                Grid(
                    f"{network.output}, {title}: antecedents as σ, c (Tables 5.2, 5.3), consequents (5.4, 5.5).",
                    ("rule", *names, *(f"× {n}" for n in names), "constant"),
                    rows,
                )
            )
    return grids


def _driving(runs: dict[tuple[str, str], Run]) -> Grid:
    rows = []
    for (experiment, title), run in runs.items():
        m = measure_formation(run)
        aligned = float(m["alignment_time_s"][0, 0])
        lateral = m["max_lateral_error_m"][0]
        rows.append(
            (
                experiment,
                title,
                f"{aligned:.1f}" if np.isfinite(aligned) else "never",
                f"{m['final_spread_m'][0, 0]:.3f}" if np.isfinite(m["final_spread_m"][0, 0]) else "not reached",
                f"{lateral[0]:.3f}",
                f"{lateral[1:].max():.3f}",
            )
        )
    return Grid(
        "The two experiments of 5.2.3 on the full plant: leader 3 m behind, and 3 m ahead.",
        (
            "experiment",
            "controller",
            "aligned after [s]",
            "spread of x at the end [m]",
            "leader's lateral error [m]",
            "followers' lateral error [m]",
        ),
        rows,
    )


def _learning_pictures(learnt: dict[str, list[Learnt]], checks: dict[str, Table]) -> list[Picture]:
    posed = learnt["well-posed"]
    first = posed[0]
    pictures = [
        Picture(
            "formation-rules",
            "Training error over the number of rules (thesis Fig 5.6), well-posed set; the best of 108 settings each.",
            "Error against number of rules for the four networks.",
            partial(plot_rules_error, {network.output: network.search for network in posed}),
        ),
        Picture(
            "formation-structure",
            f"The network {first.output} as the layers of ANFIS (thesis Figs 5.7, 5.11); learning does not change it.",
            f"Inputs, terms, rules, shares, consequents and the output of {first.output}.",
            partial(plot_structure, first.after),
        ),
        Picture(
            "formation-training",
            f"Training and checking error of the network {first.output} over the epochs (thesis Fig 5.13).",
            "Error curves of hybrid learning.",
            lambda: plot_training(first.training.history),
        ),
        Picture(
            "formation-premises",
            f"Membership functions of the network {first.output} before and after learning (thesis Fig 5.10).",
            "Gaussian membership functions of each input, before dashed, after solid.",
            lambda: plot_premises(first.before, first.after),
        ),
    ]
    stages = {"clustering": "5.8", "learning": "5.12"}
    for kind, networks in learnt.items():
        for network in networks[:2]:  # the leader's, as in the thesis
            for stage, figure in stages.items():
                if kind == "literal" or stage == "learning":
                    pictures.append(_fit(kind, network, stage, figure, checks[kind]))
    return pictures


def _fit(kind: str, network: Learnt, stage: str, figure: str, check: Table) -> Picture:
    """Output against data that were not learnt from: the formation that starts with the leader at x = −1 m."""
    fis = network.before if stage == "clustering" else network.after
    columns = [check.names.index(v.name) for v in fis.inputs]
    x, y = check.values[:, columns], check.values[:, check.names.index(network.output)]
    return Picture(
        f"formation-fit-{kind}-{network.output}-{stage}",
        f"{network.output} after {stage}, {kind} set: the network over the checking formation, 1 m behind (thesis Figs "
        f"5.9, {figure}), against it, and what is left.",
        f"Checking data and output of the network {network.output} after {stage}, and a histogram of the residuals.",
        partial(plot_fit, fis, x, y),
    )


def _driving_pictures(runs: dict[tuple[str, str], Run]) -> list[Picture]:
    pictures = []
    figures = {"formation-behind": "Figs 5.16, 5.17", "formation-ahead": "Figs 5.18, 5.19"}
    titles = list(VARIANTS.values())
    for experiment in EXPERIMENTS:
        for k in (0, 2):
            run = runs[experiment, titles[k]]
            pictures.append(
                Picture(
                    f"{experiment}-{k + 1}",
                    f"{experiment}: {titles[k]} (thesis {figures[experiment]}). Robot 1 leads.",
                    f"Paths, errors and speeds of three robots in {experiment}.",
                    partial(plot_run, run),
                )
            )
    return pictures


def _claims(learnt: dict[str, list[Learnt]], runs: dict[tuple[str, str], Run], floor: dict[str, float]) -> list[Claim]:
    errors = {n.output: n.training.history[n.training.best].train for n in learnt["literal"]}
    reached = [o for o in errors if errors[o] <= 1.1 * THESIS_ERRORS[o]]
    listed = ", ".join(f"{o} {errors[o]:.1e} (thesis {THESIS_ERRORS[o]:.1e}, floor {floor[o]:.1e})" for o in errors)
    titles = list(VARIANTS.values())
    good = {key: _succeeds(run) for key, run in runs.items()}
    both_open = [good[e, titles[1]] for e in EXPERIMENTS]
    both_own = [good[e, titles[0]] for e in EXPERIMENTS]
    own = [good[e, titles[2]] for e in EXPERIMENTS]
    return [
        Claim(
            "Formation data from the leader's posture",
            "thesis 5.2.1, Table 5.1",
            "The leader's posture gives all that is needed; eight rules reach the errors of Table 5.1.",
            f"Literal set, 8 rules, 60 epochs, training RMSE: {listed}. The floor is the scatter of the targets at "
            "equal inputs (cells of 5 cm in x): no function that is smooth over a cell goes below it.",
            _verdict(len(reached), len(errors)),
        ),
        Claim(
            "The networks drive leader and followers",
            "thesis 5.2.3, Figs 5.16-5.19",
            "From 3 m behind and from 3 m ahead the robots align and go on together, the followers open loop.",
            "With the lead dx as an input and data off the path too: "
            + "; ".join(f"{e}, {t}: {_said(runs[e, t])}" for e in EXPERIMENTS for t in (titles[1], titles[0]))
            + ". Success: aligned, spread at the end below 10 cm, no robot further than 0.5 m from its path.",
            "holds" if all(both_open) else "holds in part" if any(both_open) or any(both_own) else "does not hold",
        ),
        Claim(
            "The thesis's trained systems",
            "thesis Tables 5.2-5.5",
            "The printed systems are those that drove the experiments.",
            "Driven as printed (Table 5.2 repeats 5.3, so the leader's antecedents are lost): "
            + "; ".join(f"{e}: {_said(runs[e, titles[2]])}" for e in EXPERIMENTS)
            + ".",
            _verdict(sum(own), len(own)),
        ),
    ]


def _verdict(successes: int, cases: int) -> Verdict:
    return "holds" if successes == cases else "holds in part" if successes else "does not hold"


def _succeeds(run: Run) -> bool:
    m = measure_formation(run)
    return bool(
        np.isfinite(m["alignment_time_s"][0, 0])
        and m["final_spread_m"][0, 0] < 0.1
        and m["max_lateral_error_m"][0].max() < 0.5
    )


def _said(run: Run) -> str:
    m = measure_formation(run)
    aligned = float(m["alignment_time_s"][0, 0])
    when = f"aligned after {aligned:.1f} s" if np.isfinite(aligned) else "never aligned"
    spread = float(m["final_spread_m"][0, 0])
    end = f"spread {spread:.3f} m" if np.isfinite(spread) else "the end of the path not reached"
    return f"{when}, {end}, lateral errors up to {m['max_lateral_error_m'][0].max():.2f} m"
