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
from robotics.laws.formation.leader_follower import OUTPUTS, load_networks
from robotics.measures.evidence import mean_of
from robotics.measures.formations import measure_formation
from robotics.report.chapter import Chapter, Grid, Picture
from robotics.report.wording import shown
from robotics.scenario.reading import load_scenario
from robotics.simulation.run import Run
from robotics.thesis.claims import Needed, judged
from robotics.thesis.driving import driven
from robotics.thesis.experiment import Effort, Experiment
from robotics.thesis.quantities import measured

EXPERIMENTS = ("formation-behind", "formation-ahead")
# The variants: specification (NETWORKS is the folder of the networks just learnt) and title
VARIANTS = {
    "formation:networks=NETWORKS,correction=own-pose": "networks, own posture",
    "formation:networks=NETWORKS,correction=none": "networks, open loop",
    "formation:networks=thesis,correction=none": "the thesis's systems",
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


def experiments(folder: str, seed: int, effort: Effort) -> list[Experiment]:
    """The experiments of the chapter: both data sets of ``seed``, their networks, and all variants driven.

    Networks learnt from the well-posed set go to ``folder``/networks, from where they drive. Running may raise OSError.
    """
    networks = Path(folder) / "networks"
    return [
        *(Experiment(("data", kind), partial(_data, kind, seed)) for kind in SETS),
        *(Experiment(("learnt", *which), partial(_learnt, *which, seed, networks)) for which in product(SETS, OUTPUTS)),
        *(
            Experiment(
                Needed(experiment, title, False), partial(_driven, experiment, title, effort.row(seed), networks)
            )
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


def _driven(experiment: str, title: str, seeds: Sequence[int], networks: Path) -> Run:
    specification = next(law for law, name in VARIANTS.items() if name == title)
    law = specification.replace("NETWORKS", str(networks))
    return driven(Needed(experiment, title, False), load_scenario(experiment), law, seeds)


def chapter_of(results: Mapping[tuple[Any, ...], Any]) -> Chapter:
    """Write the chapter from the results of its experiments."""
    learnt: dict[str, list[Learnt]] = {kind: [results["learnt", kind, output] for output in OUTPUTS] for kind in SETS}
    runs = {(key.on, key.of): run for key, run in results.items() if isinstance(key, Needed)}
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
        judged("formation", partial(_values, results)),
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
        lateral = m["max_lateral_error_m"]
        found = (
            (m["alignment_time_s"][:, 0], "s"),
            (m["final_spread_m"][:, 0], "m"),
            (lateral[:, 0], "m"),
            (lateral[:, 1:].max(axis=1), "m"),
        )
        rows.append((experiment, title, *(shown(mean_of(values), unit) for values, unit in found)))
    return Grid(
        "The two experiments of 5.2.3 on the full plant, with noise: leader 3 m behind, and 3 m ahead. Means with 95 % "
        "intervals over the seeds; “never”: not in every run.",
        (
            "experiment",
            "controller",
            "aligned after",
            "spread of x at the end",
            "leader's lateral error",
            "followers' lateral error",
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


def _values(results: Mapping[Any, Any], need: Needed, quantity: str, robots: str) -> np.ndarray:
    """The numbers that claims ask for; the literal set has no noise, so that its errors are exact."""
    if need.on.startswith("literal data, "):
        learnt: Learnt = results["learnt", "literal", need.on.removeprefix("literal data, ")]
        return np.array([learnt.training.history[0].train])
    return measured(results[need], quantity, robots)
