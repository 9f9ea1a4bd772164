"""The report's chapter on leader-follower formations: data, clusters, learning, driving; thesis 5.2.

It generates both data sets, learns four networks from each, drives the two experiments of 5.2.3 with both, with the
analytic law and with the thesis's own systems, and judges the claims.
"""

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache, partial
from itertools import product
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
from matplotlib.figure import Figure

import anfis
from anfis.plot import plot_premises
from anfis.state import Epoch
from fuzzy.figures.drawing import PAGE_WIDTH
from fuzzy.figures.structure import plot_structure
from fuzzy.fitting.clustering import DataWarning
from robotics.laws.formation.leader_follower import FORMATION_OUTPUTS, load_networks
from robotics.measures.evidence import mean_of
from robotics.measures.formations import measure_formation
from robotics.measures.quantities import measured
from robotics.plugins.learning import figures as plots
from robotics.plugins.learning import formationdata
from robotics.plugins.learning import formationlearning as learning
from robotics.plugins.learning.datatable import DataTable
from robotics.plugins.learning.formation_run import plot_formation
from robotics.plugins.learning.formationdata import FormationRecipe, FormationRun
from robotics.plugins.learning.formationlearning import FRESH, FreshErrors, Learnt
from robotics.plugins.learning.report import fit_of, parameter_grid, setting_of
from robotics.plugins.learning.scatter import DRAWS, scatter
from robotics.plugins.thesis.claims import Needed, judged
from robotics.plugins.thesis.driving import driven
from robotics.plugins.thesis.experiment import Effort, Experiment
from robotics.plugins.thesis.rows import TABLES, TEXTS
from robotics.show.report.chapter import Chapter, Grid, Picture
from robotics.show.report.wording import shown
from robotics.simulation.run import Run
from robotics.simulation.scenario.reading import load_scenario

_EXPERIMENTS = ("formation-behind", "formation-ahead")
# The variants: specification (NETWORKS and LITERAL are the folders of the networks just learnt) and title
VARIANTS: dict[str, str] = TABLES.table("variants")
# Table 5.1: the thesis's training errors, in the outputs' units
THESIS_ERRORS: dict[str, float] = TABLES.table("printed.formation")


# The pictures of networks over data: name, the thesis's figures, what the data are, their table and time in _Data
_FITS = (
    ("formation-fit", "Figs 5.8, 5.12", "the five formations' runs", ("along", "time")),
    ("formation-fit-check", "Fig 5.9", "the checking formation, 1 m behind", ("check_along", "check_time")),
)
_DATA = "formation data, "  # and an output: what claims call the errors of learning it
Kind = Literal["literal", "well-posed"]
SETS: tuple[Kind, ...] = ("literal", "well-posed")  # the kinds of formation data


class _Data(NamedTuple):
    """A set of formation data."""

    table: DataTable
    check: DataTable  # the checking set of learning
    along: DataTable  # the runs of the set's formations along the path, in the order of time, for the pictures
    check_along: DataTable  # the checking formation's run along the path
    runs: dict[str, FormationRun]  # of the set's formations, by title
    time: np.ndarray  # s, of the samples of ``along``: one run after another
    check_time: np.ndarray  # likewise of ``check_along``


def experiments(folder: str, seed: int, effort: Effort) -> list[Experiment]:
    """The experiments of the chapter: data sets of ``seed``, their networks, fresh sets, and all variants driven.

    Networks go to ``folder``/networks, from where they drive, those of the literal set to its folder of that name.
    Running may raise OSError.
    """
    networks = Path(folder) / "networks"
    drives = {Needed(on, title, False): law for on in _EXPERIMENTS for law, title in VARIANTS.items()}
    return [
        *(Experiment(("data", kind), partial(_data, kind, seed)) for kind in SETS),
        *(Experiment(("learnt", *w), partial(_learnt, *w, seed, networks)) for w in product(SETS, FORMATION_OUTPUTS)),
        Experiment(("fresh",), partial(_fresh, seed, networks)),
        *(Experiment(need, partial(_driven, need, law, effort.row(seed), networks)) for need, law in drives.items()),
    ]


@lru_cache(maxsize=2)
def _data(kind: Kind, seed: int) -> _Data:
    recipe = FormationRecipe(kind=kind, seed=seed)
    held, still = formationdata.checking_recipe(recipe), replace(recipe, coverage=0.0, jitter=0.0)
    table, check = formationdata.formation_data(recipe), formationdata.formation_data(held)
    literal = kind == "literal"
    along, check_along = table, check
    if not literal:
        along, check_along = (formationdata.formation_data(r) for r in (still, formationdata.checking_recipe(still)))
    title = "leader from {:g} m".format
    runs = {title(x).replace("-", "−"): formationdata.formation_run(recipe, x, recipe.samples) for x in recipe.starts}
    held_runs = [formationdata.formation_run(held, start, held.samples) for start in held.starts]
    times = _one_after_another(list(runs.values())), _one_after_another(held_runs)
    return _Data(table, check, along, check_along, runs if literal else {}, *times)


def _one_after_another(runs: Sequence[FormationRun]) -> np.ndarray:
    """The times [s] of all samples of the runs, of which each begins a sample after the one before it."""
    begins = np.cumsum([0.0, *(run.time[-1] + run.time[1] for run in runs[:-1])])
    return np.concatenate([run.time + begin for run, begin in zip(runs, begins, strict=True)])


@lru_cache(maxsize=8)
def _learnt(kind: Kind, output: str, seed: int, networks: Path) -> Learnt:
    data = _data(kind, seed)
    # On the curve x, y and θ hang together: without a ridge, huge consequents tell formations apart by rounding.
    options = anfis.Options(epochs=60, ridge=1e-10) if kind == "literal" else anfis.Options(epochs=60)
    with warnings.catch_warnings():
        if kind == "literal":  # the thesis's own followers drive at the same speed in every row
            warnings.filterwarnings("ignore", "constant", DataWarning)
        learnt = learning.learn_network(output, data.table.names, data.table.values, data.check.values, options=options)
    learning.write_networks([learnt], networks if kind == "well-posed" else networks / "literal")
    return learnt


def _fresh(seed: int, networks: Path) -> dict[str, FreshErrors]:
    learnt = [_learnt("well-posed", output, seed, networks) for output in FORMATION_OUTPUTS]
    return learning.fresh_errors(learnt, FormationRecipe(kind="well-posed", seed=seed))


def _driven(need: Needed, specification: str, seeds: Sequence[int], networks: Path) -> Run:
    folders = {"NETWORKS": networks, "LITERAL": networks / "literal"}
    for name, folder in folders.items():
        specification = specification.replace(name, str(folder))
    return driven(need, load_scenario(need.on), specification, seeds)


def chapter_of(results: Mapping[tuple[Any, ...], Any]) -> Chapter:
    """Write the chapter from the results of its experiments."""
    learnt: dict[str, list[Learnt]]
    learnt = {kind: [results["learnt", kind, output] for output in FORMATION_OUTPUTS] for kind in SETS}
    runs = {(key.on, key.of): run for key, run in results.items() if isinstance(key, Needed)}
    last = {
        "literal": _scattered(results["data", "literal"].table),
        "well-posed": _drawn_afresh(results["fresh",]),
    }
    return TEXTS.chapter(
        "formation",
        tables=[*(_table_5_1(kind, learnt[kind], last[kind]) for kind in SETS), _driving(runs)],
        details=_antecedents_and_consequents(learnt["well-posed"]),
        pictures=[
            *_learning_pictures(learnt, {kind: results["data", kind] for kind in SETS}),
            *_driving_pictures(runs),
        ],
        claims=judged("formation", partial(_values, results), partial(_rules, results)),
    )


def _table_5_1(kind: Kind, networks: Sequence[Learnt], last: Mapping[str, Callable[[Learnt], str]]) -> Grid:
    def best(network: Learnt) -> Epoch:
        return network.training.history[network.training.best]

    columns: dict[str, Callable[[Learnt], str]] = {
        "network": lambda network: network.output,
        "rules": lambda network: str(network.trial.rules),
        "radius, squash, accept, reject": setting_of,
        "thesis, clustering": lambda network: f"{THESIS_ERRORS[network.output]:.2e}",
        "clustering": lambda network: f"{network.training.history[0].train:.2e}",
        "learnt, training": lambda network: f"{best(network).train:.2e}",
        "learnt, checking": lambda network: f"{best(network).check:.2e}",
    }
    about_last = TEXTS.text(f"formation.table-5-1.{kind}", draws=DRAWS, fresh=FRESH)
    caption = TEXTS.text("formation.table-5-1.caption", kind=kind, last=about_last)
    return Grid.of(caption, networks, columns | dict(last))


def _scattered(table: DataTable) -> dict[str, Callable[[Learnt], str]]:
    """The column that says how far the outputs of a table scatter."""
    found = scatter(table.values[:, : len(table.inputs)], table.values[:, len(table.inputs) :])
    cells = {
        output: f"{found.rms[k]:.1e} ({found.least[k]:.1e} to {found.most[k]:.1e})"
        for k, output in enumerate(FORMATION_OUTPUTS)
    }
    return {"scatter": lambda network: cells[network.output]}


def _drawn_afresh(fresh: Mapping[str, FreshErrors]) -> dict[str, Callable[[Learnt], str]]:
    """The columns that say what other sets of the same kind give."""
    return {
        "clustering, fresh sets": lambda network: _spanned(fresh[network.output].clustering),
        "their rules": lambda n: f"{fresh[n.output].rules.min():.0f} to {fresh[n.output].rules.max():.0f}",
        "learnt, fresh sets": lambda network: _spanned(fresh[network.output].learnt),
    }


def _spanned(values: np.ndarray) -> str:
    return f"{values.mean():.1e} ({values.min():.1e} to {values.max():.1e})"


def _antecedents_and_consequents(networks: Sequence[Learnt]) -> list[Grid]:
    """Tables 5.2 to 5.5 in the thesis's form: ours, and the thesis's as printed."""
    printed = {fis.outputs[0].name: fis for fis in load_networks("thesis")}
    grids = []
    for network in networks:
        for title, fis in (("ours, trained", network.after), ("thesis", printed[network.output])):
            caption = TEXTS.text("formation.parameters.caption", output=network.output, title=title)
            grids.append(parameter_grid(fis, caption))
    return grids


def _driving(runs: dict[tuple[str, str], Run]) -> Grid:
    rows = []
    for (experiment, title), run in runs.items():
        m = measure_formation(run)
        lateral = m["max_lateral_error_m"]
        found = {
            "aligned after": (m["alignment_time_s"][:, 0], "s"),
            "spread of x at the end": (m["final_spread_m"][:, 0], "m"),
            "leader's lateral error": (lateral[:, 0], "m"),
            "followers' lateral error": (lateral[:, 1:].max(axis=1), "m"),
        }
        rows.append((experiment, title, *(shown(mean_of(values), unit) for values, unit in found.values())))
    return Grid(TEXTS.text("formation.driving.caption"), ("experiment", "controller", *found), rows)


def _learning_pictures(learnt: Mapping[Any, list[Learnt]], data: Mapping[Any, _Data]) -> list[Picture]:
    posed, literal = learnt["well-posed"], data["literal"]
    first, searches = posed[0], {n.output: replace(n.search, wanted=n.trial.rules) for n in posed}
    turns = dict(zip(literal.runs, np.split(literal.table.values[:, [4, 6]].T, len(literal.runs), axis=1), strict=True))
    histories = {network.output: network.training.history for network in posed}
    units = {network.output: network.after.outputs[0].unit for network in posed}
    plotted: dict[str, Callable[[], Figure]] = {
        "formation-paths": partial(plots.plot_formation_paths, literal.runs, PAGE_WIDTH),
        "formation-signals": partial(plots.plot_formation_signals, literal.runs, turns, PAGE_WIDTH),
        "formation-rules": partial(plots.plot_searches, searches, PAGE_WIDTH),
        "formation-structure": partial(plot_structure, first.after),
        "formation-premises": lambda: plot_premises(first.before, first.after, PAGE_WIDTH),
        "formation-training": partial(plots.plot_epochs, histories, units, PAGE_WIDTH),
    }
    pictures = [TEXTS.picture(name, plot, output=first.output) for name, plot in plotted.items()]
    for name, figures, where, fields in _FITS:
        plot = partial(_plot_fits, learnt, data, *fields)
        pictures.append(TEXTS.picture(name, plot, key="formation-fits", where=where, figures=figures))
    return pictures


def _plot_fits(learnt: Mapping[Any, list[Learnt]], data: Mapping[Any, _Data], table: str, time: str) -> Figure:
    """Draw what all networks give over one of the tables of their data, over its times."""

    def fits(kind: Kind) -> list[plots.Fit]:
        own = data[kind]
        return [fit_of(network, getattr(own, table))._replace(time=getattr(own, time)) for network in learnt[kind]]

    return plots.plot_fits({f"{kind} set": fits(kind) for kind in learnt}, PAGE_WIDTH)


def _driving_pictures(runs: dict[tuple[str, str], Run]) -> list[Picture]:
    figures = {"formation-behind": "Figs 5.16, 5.17", "formation-ahead": "Figs 5.18, 5.19"}
    title = next(iter(VARIANTS.values()))
    drawn = {experiment: runs[experiment, title] for experiment in _EXPERIMENTS}
    return [
        TEXTS.picture(
            f"{experiment}-1",
            partial(plot_formation, run, width=PAGE_WIDTH),
            key="formation-drive",
            experiment=experiment,
            title=title,
            figures=figures[experiment],
        )
        for experiment, run in drawn.items()
    ]


def _values(results: Mapping[Any, Any], need: Needed, quantity: str, robots: str) -> np.ndarray:
    """The numbers that claims ask for; the literal set has nothing random in it, so that its errors are exact."""
    if need.on.startswith(_DATA):
        output = need.on.removeprefix(_DATA)
        if need.of == "literal set":
            learnt: Learnt = results["learnt", "literal", output]
            return np.array([learnt.training.history[0].train])
        fresh: FreshErrors = results["fresh",][output]
        return fresh.clustering
    return measured(results[need], quantity, robots)


def _rules(results: Mapping[Any, Any], need: Needed) -> str:
    """From how many rules the error of learning an output comes."""
    if not need.on.startswith(_DATA):
        return ""
    output = need.on.removeprefix(_DATA)
    if need.of == "literal set":
        return f"{results['learnt', 'literal', output].trial.rules} rules"
    rules = results["fresh",][output].rules
    return f"{rules.min():.0f} to {rules.max():.0f} rules"
