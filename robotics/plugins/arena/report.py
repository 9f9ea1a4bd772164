"""The page of an arena: the answer in one look, and behind it the terms, the costs and how sure they are."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from itertools import permutations
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from fuzzy.figures.drawing import save_figure
from fuzzy.files.atomic import write_whole
from fuzzy.files.table import write_frame
from fuzzy.shell.progress import Begin, unwatched
from robotics.measures.registry import ALL_METRICS
from robotics.measures.statistics.intervals import Interval
from robotics.plugins.arena import figures
from robotics.plugins.arena.answer import answer, microseconds
from robotics.plugins.arena.changes import CHANGES
from robotics.plugins.arena.description import BLOCKS, Arena, load_arena
from robotics.plugins.arena.entrants import sort_of, terms_of
from robotics.plugins.arena.figures import Entrant, Standings
from robotics.plugins.arena.outcome import Outcome
from robotics.plugins.arena.presets import write_presets
from robotics.plugins.arena.running import drive_arena
from robotics.plugins.arena.work import plain, tuned
from robotics.show.report.chapter import Chapter, Front, Grid, Picture
from robotics.show.report.plates import plate
from robotics.show.report.template import rendered
from robotics.simulation.scenario.description import Scenario
from robotics.studies.executors import Workers
from robotics.studies.tuning.cost import Term
from robotics.studies.tuning.results import write_tuned

PAGE_FILE = "arena.html"
WIDE = 6.3  # inches: the one look has columns of numbers beside it
_FORMATS = ("png", "svg", "pdf")


def run_arena(
    arena: Arena,
    out: str | Path | None = None,
    *,
    workers: Workers | None = None,
    fresh: bool = False,
    begin: Begin = unwatched,
    announce: Callable[[str], None] = lambda text: None,
    command: str | None = None,
) -> Outcome:
    """Hold an arena: tune every law with the same budget, choose, test, and write all that came of it into a folder.

    The files are arena.html, figures/, results.csv (a row a run of the test), summary.csv (a row a law), pairs.csv,
    budgets.csv and robustness.csv, tuned/LAW with the chosen law, and searches/ and runs/, from which a stopped arena
    goes on.

    Args:
        arena: The arena, such as :func:`robotics.load_arena` reads it.
        out: The folder of the results. Default: out/arena.
        workers: Who does the work, by default this process.
        fresh: Whether to discard what the folder holds of an arena.
        begin: Starts a bar of a progress display, by its text and total.
        announce: Called with a sentence before the work begins: how long it will take.
        command: The command line that the page names.

    Returns:
        The tuned laws, their costs with intervals, and who leads.

    Raises:
        ArenaError: An arena that cannot be held, or a folder of another one.
        ControllerError: A controller that is unknown, or cannot drive the scenario.
        OSError: Files cannot be written.
    """
    folder = Path(out) if out is not None else Path("out") / "arena"
    outcome = drive_arena(arena, folder, workers, fresh=fresh, begin=begin, announce=announce)
    write_arena(outcome, folder, command=command, begin=begin)
    return outcome


def write_arena(outcome: Outcome, folder: Path, *, command: str | None = None, begin: Begin = unwatched) -> Path:
    """Write the tables, the figures, the tuned laws and the page of an arena; return the page's path.

    Args:
        outcome: What came of it.
        folder: The folder, in which the arena was held.
        command: The command line that the page names.
        begin: Starts a bar of a progress display, by its text and total.
    """
    write_tables(outcome, folder)
    specifications = write_laws(outcome, folder)
    write_presets(outcome, specifications, folder / "presets")
    chapters = arena_chapters(outcome, specifications)
    head = ranking(outcome)
    pictures = [head, *(picture for chapter in chapters for picture in chapter.pictures)]
    advance = begin("drawing", len(pictures))
    plates = []
    (folder / "figures").mkdir(parents=True, exist_ok=True)
    for picture in pictures:
        assert isinstance(picture, Picture)
        plates.append(plate(picture))
        figure = picture.draw()
        for suffix in _FORMATS:
            save_figure(figure, folder / "figures" / f"{picture.name}.{suffix}")
        advance()
    page = rendered(
        str(Path(__file__).with_name("arena.html.j2")),
        chapters,
        plates,
        (),
        laws=outcome.laws,
        title=outcome.arena.title or f"The arena {outcome.arena.name}",
        head=plates[0],
        answer=answer(outcome),
        command=command,
        machine=outcome.machine,
    )
    write_whole(folder / PAGE_FILE, page)
    return folder / PAGE_FILE


def small_arena(begin: Begin, folder: Path) -> Front:
    """Hold the arena ``demo`` in ``folder``/arena for the front of a report, in this process.

    Computing times are not measured, so that the report is the same wherever it is made.

    Args:
        begin: Starts a bar of a progress display, by its text and total.
        folder: The folder of the report.
    """
    arena = load_arena("demo")
    outcome = drive_arena(arena, folder / "arena", fresh=True, clocked=False, begin=begin)
    write_tables(outcome, folder / "arena")
    return Front(
        "At their best: tuned alike, on runs that no tuning has seen",
        ranking(outcome),
        answer(outcome),
        f"A small arena of {len(arena.laws)} laws with {arena.evaluations} evaluations each. The command robotics "
        "arena holds the whole one, and robotics arena demo says more of this one.",
    )


# Pictures -----------------------------------------------------------------------------------------------------------


def entrants(outcome: Outcome) -> list[Entrant]:
    """The laws as pictures show them."""
    return [Entrant(title, sort_of(made)) for title, made in zip(outcome.titles, outcome.made, strict=True)]


def standings(outcome: Outcome) -> Standings:
    """What the one look shows."""
    cost = outcome.arena.made_cost
    place = next((n for n, term in enumerate(cost.terms) if "variation" in term.metric), len(cost.terms) - 1)
    effort = outcome.term_means("tuned")[place]
    return Standings(
        entrants(outcome),
        outcome.titles[outcome.reference],
        outcome.published_ratio,
        outcome.tuned_ratio,
        outcome.failures,
        np.where(np.isfinite(effort), effort, np.nan),
        "effort\n[rad/s²]",
        np.array([outcome.computing[law] for law in outcome.laws]),
        np.array([float(len(entry.parameters)) for entry in outcome.entries]),
    )


def plot_arena(outcome: Outcome, width: float = WIDE) -> Figure:
    """Draw what came of an arena in one look: the laws from the least tuned cost down, as published and tuned.

    Beside the costs stand what a law asks for and how many runs it failed.

    Args:
        outcome: What :func:`robotics.run_arena` gives.
        width: The figure's width [inches].
    """
    return figures.plot_ranking(standings(outcome), width)


def ranking(outcome: Outcome) -> Picture:
    """The one look."""
    arena = outcome.arena
    found = standings(outcome)
    computing = "; computing is the law's own time a period on this machine" if outcome.clocked else ""
    said = "; ".join(f"{outcome.titles[k]} {_number(float(outcome.tuned_ratio.value[k]))}" for k in outcome.order)
    return Picture(
        "ranking",
        f"Cost over that of {found.reference}, tuned, on {len(arena.scenarios('test'))} scenarios that no search had "
        f"seen, {arena.testing_runs} runs each: hollow as published, filled tuned, with 95 % intervals; less is better."
        f" Effort is the variation of the demanded turn rate{computing}.",
        f"Laws from the least cost up, in multiples of {found.reference}: {said}.",
        partial(figures.plot_ranking, found, WIDE),
    )


def arena_pictures(outcome: Outcome) -> dict[str, Picture]:
    """The other pictures, by name."""
    laws, order = entrants(outcome), outcome.order
    ordered, pairs = [laws[k] for k in order], np.ix_(order, order)
    cost, means = outcome.arena.made_cost, outcome.term_means("tuned")
    found = [
        Picture(
            "budget",
            "What a law costs on the choosing runs after so many evaluations: the median over the searches of all "
            "engines and repeats, and their range. Where curves cross, the better law depends on the budget.",
            "Curves of cost over the number of evaluations, one a law.",
            partial(figures.plot_budget, laws, outcome.budgets, outcome.curves),
        ),
        Picture(
            "profiles",
            f"The share of runs that cost at most a multiple of {outcome.titles[outcome.reference]}'s interquartile "
            "mean on the same scenario, with 95 % bands.",
            "Performance profiles of all laws, a panel for each sort.",
            partial(figures.plot_profiles, laws, outcome.limits, outcome.profiles, "cost [reference = 1]"),
        ),
        Picture(
            "improvement",
            "How often the row's law costs less than the column's, run by run at the same start and noise, and what "
            "can be said of the pair: better or worse only where Holm's adjusted p is below 0.05 too.",
            "A matrix of probabilities of improvement between each two laws.",
            partial(figures.plot_improvement, ordered, outcome.improvement[pairs], outcome.verdicts[pairs]),
        ),
        Picture(
            "robustness",
            "The cost when something is otherwise than the laws, the wheel loops and odometry are told, over the cost "
            "when it is as told; nobody was tuned for it.",
            "A heat map of cost ratios, laws by changes.",
            partial(
                figures.plot_robustness, ordered, [c.replace("-", "−") for c in CHANGES], outcome.robustness[order]
            ),
        ),
    ]
    points = means[[0, -1]][:, np.isfinite(means[[0, -1]]).all(axis=0)]
    if len(cost.terms) >= 2 and points.size and (np.ptp(points, axis=1) > 0).all():
        scale = 100.0 if cost.terms[0].metric.endswith("_m") else 1.0
        before = outcome.term_means("published")
        found.append(
            Picture(
                "front",
                "Precision against effort: the interquartile means of the tuned laws, hollow as published. Whoever is "
                "on the front is beaten by nobody in both.",
                "Points of effort and cross-track error, one a law, and the front of the unbeaten.",
                partial(
                    figures.plot_pareto,
                    laws,
                    means[-1],
                    scale * means[0],
                    ("variation of the turn rate [rad/s²]", "cross-track RMS [cm]" if scale == 100 else "error"),
                    np.stack([before[-1], scale * before[0]], axis=1),
                ),
            )
        )
    return {picture.name: picture for picture in found}


# Chapters -----------------------------------------------------------------------------------------------------------


def arena_chapters(outcome: Outcome, specifications: Sequence[str] = ()) -> list[Chapter]:
    """What stands behind the answer."""
    pictures = arena_pictures(outcome)
    failed = outcome.robust_failures
    return [
        _terms(outcome),
        _costs(outcome, pictures),
        _budgets(outcome, pictures),
        _weights(outcome),
        Chapter(
            "robustness",
            "Robustness without re-tuning",
            (
                "The robot is heavier or lighter, its wheels larger or smaller, its gears rougher or smoother by a "
                "fifth, its commands later or its sensors noisier by a factor of two, and nobody is told: neither the "
                "laws, nor the wheel loops, nor odometry.",
            ),
            details=[
                _grid(outcome, "Share of runs that failed.", CHANGES, lambda k: (f"{100 * v:.2g} %" for v in failed[k]))
            ],
            pictures=[pictures["robustness"]],
            folded="Failed runs under each change",
        ),
        _laws(outcome, specifications),
    ]


def _grid(outcome: Outcome, caption: str, head: Iterable[str], cells: Callable[[int], Iterable[str]]) -> Grid:
    """A table with a row for each law, from the least tuned cost up; ``cells`` gives those of the law at a place."""
    return Grid(caption, ("Law", *head), [(outcome.titles[k], *cells(k)) for k in outcome.order])


def _terms(outcome: Outcome) -> Chapter:
    arena = outcome.arena
    c = arena.conditions

    def cells(k: int) -> Iterator[str]:
        entry, terms = outcome.entries[k], terms_of(outcome.made[k])
        yield from (terms.level, terms.knows, str(len(entry.parameters)))
        yield f"{len(entry.searches)} × {arena.budget(entry.law)}" if entry.searches else "as published"
        yield microseconds(outcome.computing[entry.law])

    unseen = ", ".join(arena.unseen_sorts) or "none"
    text = (
        f"All laws drive the same dynamic plant with the same limits, a period of {1000 * c.period:g} ms, a latency of "
        f"{1000 * c.latency:g} ms, a pose sensor with noise of {1000 * c.position_noise:g} mm and "
        f"{1000 * c.heading_noise:g} mrad, and starts that scatter by {100 * c.start_position:g} cm and "
        f"{1000 * c.start_heading:g} mrad from run to run. All know their robot's measured posture; the table says "
        "what else.",
        "The cost of a run is fixed beforehand: "
        + " + ".join(map(_term, arena.made_cost.terms))
        + f". In a search a failed run costs {arena.made_cost.failed:g}; in the test it is a failure.",
        "The blocks of scenarios and seeds, for tuning, choosing and testing, have nothing in common. Sorts of test "
        f"scenarios that no law was tuned on: {unseen}.",
    )
    head = ("Commands", "Knows beside the posture", "Numbers tuned", "Searches × evaluations", "Computing a period")
    grid = _grid(outcome, "The terms of each law.", head, cells)
    return Chapter("terms", "The terms", text, [grid], [_scenarios(arena)], folded="The scenarios")


def _term(term: Term) -> str:
    metric = ALL_METRICS[term.metric]
    return f"{'' if term.weight == 1 else f'{term.weight:g} · '}({metric.title}) / {term.scale:.4g} {metric.unit}"


def _scenarios(arena: Arena) -> Grid:
    rows = []
    words = {"tune": "tuning", "choose": "choosing", "test": "testing"}
    for block in BLOCKS:
        for label, scenario in zip(arena.labels(block), arena.scenarios(block), strict=True):
            rows.append((label, words[block], *_facts(scenario)))
    head = ("Scenario", "Block", "Length", "Speed", "Tightest curve", "Start off", "Robot")
    return Grid("All scenarios, drawn at random by their number.", head, rows)


def _facts(scenario: Scenario) -> tuple[str, ...]:
    member, path = scenario.robots[0], scenario.trajectory.paths[0]
    at = scenario.trajectory.at(0.0)
    off = float(np.hypot(member.start[0] - at.x[0], member.start[1] - at.y[0]))
    curve = float(np.abs(path.table[3]).max())
    return (
        f"{(member.timing.speed or 0) * scenario.duration:.1f} m",
        f"{member.timing.speed or 0:.2f} m/s",
        f"{1 / curve:.2f} m" if curve > 0 else "straight",
        f"{off:.2f} m",
        f"{member.model.name if member.model else 'robot'}, {member.robot.mass:.1f} kg",
    )


def _costs(outcome: Outcome, pictures: dict[str, Picture]) -> Chapter:
    unit, means = outcome.titles[outcome.reference], outcome.term_means("tuned")
    columns: dict[str, tuple[Any, ...]] = {
        "As published": (outcome.published_ratio,),
        "Tuned": (outcome.tuned_ratio,),
        "Share of the gap closed": (outcome.closed, 100, " %"),
        "IQM of all runs": (outcome.pooled,),
        "Worst tenth": (outcome.tail,),
        "Failed": (outcome.failures, 100, " %"),
    }
    caption = f"Costs over that of {unit}, tuned, with 95 % intervals."
    grid = _grid(outcome, caption, columns, lambda k: (_interval(found[k], *how) for found, *how in columns.values()))
    metrics = [ALL_METRICS[term.metric] for term in outcome.arena.made_cost.terms]
    head = [f"{metric.title} [{metric.unit}]" for metric in metrics]
    caption = "What the tuned laws' cost is made of, interquartile means of all runs; and its mean over the scenarios."
    parts = _grid(outcome, caption, [*head, "Mean cost"], lambda k: map(_number, (*means[:, k], outcome.mean[k])))
    caption = f"Interquartile means of each scenario, over {unit}'s."
    per = _grid(outcome, caption, outcome.arena.labels("test"), lambda k: map(_number, outcome.by_scenario[k]))
    text = (
        "What ranks the laws is the interquartile mean of each scenario's runs, its geometric mean over the scenarios, "
        "so that no scenario counts for more because it is harder; the arithmetic mean beside it is of the costs "
        "themselves, as is the worst tenth of all runs. Intervals are bootstraps of scenarios and of runs within them, "
        "the same for all laws. A law that fails in more than a quarter of the runs of a scenario fails.",
    )
    shown = [pictures[name] for name in ("improvement", "profiles", "front") if name in pictures]
    return Chapter("costs", "The costs, and how sure they are", text, [grid, parts], [per], shown, folded="By scenario")


def _budgets(outcome: Outcome, pictures: dict[str, Picture]) -> Chapter:
    grid = _grid(
        outcome,
        "Cost on the choosing runs of the best that each engine found, or of the law as published if that is better.",
        (*outcome.arena.engines, "Chosen"),
        lambda k: (*map(_number, outcome.by_engine[:, k]), outcome.entries[k].by or "published"),
    )
    return Chapter("budgets", "Budgets and engines", tables=[grid], pictures=[pictures["budget"]])


def _weights(outcome: Outcome) -> Chapter:
    cost, weights = outcome.arena.made_cost, outcome.reweighted
    some = [term for term in cost.terms if term.weight > 0]
    rows = []
    for case, order, swapped in zip(weights.weights, weights.order, weights.swapped, strict=True):
        both = zip(some, case, strict=True)
        changed = [f"{term.metric} × {weight / term.weight:g}" for term, weight in both if weight != term.weight]
        rows.append((", ".join(changed) or "as they are", ", ".join(outcome.titles[k] for k in order), str(swapped)))
    grid = Grid("The order of the laws under other weights of the cost.", ("Weights", "Order", "Pairs swapped"), rows)
    text = (
        "The order does not change when a weight is halved or doubled."
        if not weights.changed.any()
        else "The order changes with the weights: who weighs precision and effort otherwise may choose another law.",
    )
    return Chapter("weights", "Other weights", text, [grid])


def _laws(outcome: Outcome, specifications: Sequence[str]) -> Chapter:
    grid = _grid(
        outcome,
        "The chosen laws, usable with --controller.",
        ("By", "Specification"),
        lambda k: (outcome.entries[k].by or "as published", specifications[k] if specifications else ""),
    )
    return Chapter("laws", "The tuned laws", details=[grid], folded="Specifications")


# Words --------------------------------------------------------------------------------------------------------------


def _number(value: float) -> str:
    if np.isnan(value):
        return "–"
    return "fails" if np.isinf(value) else f"{value:.3g}"


def _interval(found: Interval, factor: float = 1.0, unit: str = "") -> str:
    value, low, high = (factor * float(v) for v in (found.value, found.low, found.high))
    if not np.isfinite(value):
        return _number(value)
    ends = " to ".join("∞" if v == np.inf else "-∞" if v == -np.inf else f"{v:.3g}" for v in (low, high))
    return f"{value:.3g}{unit} ({ends})"


# Tables -------------------------------------------------------------------------------------------------------------


def write_tables(outcome: Outcome, folder: Path) -> None:
    """Write results.csv, summary.csv, pairs.csv, budgets.csv, scenarios.csv and robustness.csv."""
    tables = {
        "results": results_table(outcome),
        "summary": summary_table(outcome),
        "pairs": pairs_table(outcome),
        "budgets": _crossed(outcome, "evaluations", outcome.budgets, "cost", outcome.curves),
        "scenarios": scenarios_table(outcome),
        "robustness": _crossed(outcome, "change", CHANGES, "ratio", outcome.robustness, failed=outcome.robust_failures),
    }
    for name, table in tables.items():
        write_frame(table, folder / f"{name}.csv")


def _crossed(
    outcome: Outcome, name: str, values: Iterable[Any], called: str, found: Interval, **more: np.ndarray
) -> pd.DataFrame:
    """A row for each law and each of the ``values``, in the column ``name``, with what was ``found`` (laws, values)."""
    rows = pd.MultiIndex.from_product([outcome.laws, values], names=["law", name])
    cells = {called: found.value, "low": found.low, "high": found.high, **more}
    return pd.DataFrame({column: array.ravel() for column, array in cells.items()}, rows).reset_index()


def scenarios_table(outcome: Outcome) -> pd.DataFrame:
    """A row a law, a column a scenario of the test: the interquartile mean of the tuned law's cost."""
    names = [scenario.name for scenario in outcome.arena.scenarios("test")]
    found = pd.DataFrame(outcome.scenario_costs, outcome.laws, names).rename_axis("law").iloc[outcome.order]
    return found.reset_index()


def results_table(outcome: Outcome) -> pd.DataFrame:
    """A row a run of the test, as published and tuned: its metrics, and whether the robot was stopped."""
    names, parts = [scenario.name for scenario in outcome.arena.scenarios("test")], []
    for entry in outcome.entries:
        for part, table in entry.runs.items():
            own = table.drop(columns="candidate")
            own["scenario"] = [names[k] for k in own["scenario"]]
            own.insert(0, "gains", part)
            own.insert(0, "law", entry.law)
            parts.append(own)
    return pd.concat(parts, ignore_index=True)


def summary_table(outcome: Outcome) -> pd.DataFrame:
    """A row a law, from the least cost up."""
    columns: dict[str, Any] = {"law": outcome.laws, "sort": [sort_of(made) for made in outcome.made]}
    columns["chosen"] = [entry.by or "published" for entry in outcome.entries]
    for name, found in (
        ("cost", outcome.cost),
        ("tuned_ratio", outcome.tuned_ratio),
        ("published_ratio", outcome.published_ratio),
        ("gap_closed", outcome.closed),
        ("worst_tenth", outcome.tail),
        ("failed", outcome.failures),
    ):
        columns |= {name: found.value, f"{name}_low": found.low, f"{name}_high": found.high}
    columns["mean_cost"] = outcome.mean
    columns["numbers_tuned"] = [len(entry.parameters) for entry in outcome.entries]
    columns["evaluations"] = [outcome.arena.budget(law) for law in outcome.laws]
    terms = [term.metric for term in outcome.arena.made_cost.terms]
    columns |= dict(zip(terms, outcome.term_means("tuned"), strict=True))
    return pd.DataFrame(columns).iloc[outcome.order].reset_index(drop=True)


def pairs_table(outcome: Outcome) -> pd.DataFrame:
    """A row for each two laws: the ratio of their costs, the verdict, and how often the first costs less."""
    pairs = tuple(np.array(list(permutations(outcome.order, 2))).T)
    laws, ratio = np.array(outcome.laws), outcome.pairs[pairs]
    return pd.DataFrame(
        {
            "law": laws[pairs[0]],
            "against": laws[pairs[1]],
            "ratio": ratio.value,
            "low": ratio.low,
            "high": ratio.high,
            "verdict": outcome.verdicts[pairs],
            "p_holm": outcome.p_values[pairs],
            "costs_less": outcome.improvement.value[pairs],
        }
    )


def write_laws(outcome: Outcome, folder: Path) -> list[str]:
    """Write each chosen law with its rule bases and where they come from into tuned/LAW; return the specifications."""
    found = []
    for entry in outcome.entries:
        search = next((s for s in entry.searches if s.name == entry.by), None)
        if search is not None:
            there = folder / "tuned" / plain(entry.law)
            there.mkdir(parents=True, exist_ok=True)
            found.append(write_tuned(tuned(outcome.arena, folder, None, search), search.law, there))
        else:
            found.append(entry.law)
    return found
