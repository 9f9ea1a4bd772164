"""The page of an arena: the answer in one look, and behind it the terms, the costs and how sure they are."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict
from functools import partial
from itertools import permutations
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from fuzzy.files.table import write_frame
from fuzzy.shell.progress import Begin, unwatched
from robotics.measures.registry import ALL_METRICS
from robotics.measures.statistics.intervals import Interval
from robotics.measures.statistics.ranking import swapped_pairs
from robotics.plugins.arena import figures
from robotics.plugins.arena.answer import answer, microseconds
from robotics.plugins.arena.changes import CHANGES
from robotics.plugins.arena.description import ARENA_PAGE, Arena, load_arena
from robotics.plugins.arena.design import Cells, Knowledge, called
from robotics.plugins.arena.entrants import sort_of, terms_of
from robotics.plugins.arena.figures import Entrant, Standings
from robotics.plugins.arena.outcome import Outcome
from robotics.plugins.arena.page import write_page
from robotics.plugins.arena.plan import BLOCKS
from robotics.plugins.arena.presets import write_presets
from robotics.plugins.arena.running import drive_arena
from robotics.plugins.arena.work import plain, tuned
from robotics.show.report.chapter import Chapter, Front, Grid, Picture
from robotics.show.report.texts import ReportTexts
from robotics.simulation.scenario.description import Scenario
from robotics.studies.executors import Workers
from robotics.studies.tuning.cost import Term
from robotics.studies.tuning.results import write_tuned

_TEXTS = ReportTexts("robotics.plugins.arena")


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
    """Hold an arena: tune every law with the same budget, choose, test, and write all results into a folder.

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
    return write_page(
        outcome,
        pictures,
        chapters,
        answer(outcome),
        folder / ARENA_PAGE,
        command=command,
        machine=outcome.machine,
        advance=begin("drawing", 2 * len(pictures)),
    )


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
    cost = " + ".join(map(_term, arena.made_cost.terms))
    note = _TEXTS.text("front-of-a-report.note", cost=cost, laws=len(arena.laws), evaluations=arena.evaluations)
    return Front(_TEXTS.text("front-of-a-report.title"), ranking(outcome), answer(outcome), note)


# Pictures -----------------------------------------------------------------------------------------------------------


def entrants(outcome: Outcome) -> list[Entrant]:
    """The laws as pictures show them."""
    return [Entrant(title, sort_of(made)) for title, made in zip(outcome.titles, outcome.made, strict=True)]


def standings(outcome: Outcome) -> Standings:
    """What the one look shows."""
    effort = outcome.effort("tuned")
    effort = np.full(len(outcome.laws), np.nan) if effort is None else effort
    return Standings(
        entrants(outcome),
        outcome.titles[outcome.reference],
        outcome.published_ratio,
        outcome.tuned_ratio,
        outcome.failures,
        np.where(np.isfinite(effort), effort, np.nan),
        np.array([outcome.computing[law] for law in outcome.laws]),
        np.array([float(len(entry.parameters)) for entry in outcome.entries]),
    )


def plot_arena(outcome: Outcome, width: float = figures.WIDTH) -> Figure:
    """Draw what came of an arena in one look: the laws from the least tuned cost down, as published and tuned.

    Beside the costs stand what a law asks for and how many runs it failed.

    Args:
        outcome: What :func:`robotics.run_arena` gives.
        width: The figure's width [inches].
    """
    return figures.plot_ranking(standings(outcome), width)


def ranking(outcome: Outcome) -> Picture:
    """The one look."""
    found, arena = standings(outcome), outcome.arena
    return _TEXTS.picture(
        "ranking",
        partial(figures.plot_ranking, found),
        reference=found.reference,
        scenarios=len(arena.scenarios("test")),
        runs=arena.testing_runs,
        computing=_TEXTS.text("ranking.computing") if outcome.clocked else "",
        said="; ".join(f"{outcome.titles[k]} {_number(float(outcome.tuned_ratio.value[k]))}" for k in outcome.order),
    )


def _front(outcome: Outcome) -> list[Picture]:
    """Precision against effort, where the cost has two such terms that tell the laws apart."""
    before, after = outcome.effort("published"), outcome.effort("tuned")
    metric = ALL_METRICS[outcome.arena.made_cost.terms[0].metric]
    if before is None or after is None or len(outcome.arena.made_cost.terms) < 2:
        return []
    scale, unit = (100.0, "cm") if metric.unit == "m" else (1.0, metric.unit)
    error = scale * outcome.term_means("tuned")[0]
    known = np.isfinite(after) & np.isfinite(error)
    if not known.any() or np.ptp(after[known]) == 0 or np.ptp(error[known]) == 0:
        return []
    titles = ("variation of the turn rate [rad/s²]", f"{metric.title} [{unit}]")
    published = np.stack([before, scale * outcome.term_means("published")[0]], axis=1)
    draw = partial(figures.plot_pareto, entrants(outcome), after, error, titles, published)
    return [_TEXTS.picture("front", draw)]


# Chapters -----------------------------------------------------------------------------------------------------------


def arena_chapters(outcome: Outcome, specifications: Sequence[str] = ()) -> list[Chapter]:
    """What stands behind the answer."""
    return [
        _terms(outcome),
        _costs(outcome),
        *([_conditions(outcome)] if outcome.under else []),
        _budgets(outcome),
        _weights(outcome),
        _robustness(outcome),
        _laws(outcome, specifications),
    ]


def _grid(
    outcome: Outcome, key: str, cells: Callable[[int], Iterable[str]], more: Iterable[str] = (), **values: Any
) -> Grid:
    """A table with a row for each law, from the least tuned cost up; ``cells`` gives those of the law at a place.

    The columns ``more`` follow those that the texts name.
    """
    found = _TEXTS.grid(key, [(outcome.titles[k], *cells(k)) for k in outcome.order], **values)
    return found._replace(head=(*found.head, *more))


def _terms(outcome: Outcome) -> Chapter:
    arena = outcome.arena
    conditions, cost = arena.conditions, arena.made_cost

    def cells(k: int) -> Iterator[str]:
        entry = outcome.entries[k]
        yield from (*terms_of(outcome.made[k]), str(len(entry.parameters)))
        yield f"{len(entry.searches)} × {arena.budget(entry.law)}" if entry.searches else "as published"
        yield microseconds(outcome.computing[entry.law])

    about: dict[str, Any] = {name: 1000 * value for name, value in asdict(conditions).items() if name != "title"}
    about |= {"start_position": 100 * conditions.start_position, "cost": " + ".join(map(_term, cost.terms))}
    about |= {"failed": cost.failed, "unseen": ", ".join(arena.unseen_sorts) or "none"}
    grid = _grid(outcome, "terms.of-each", cells)
    return _TEXTS.chapter("terms", about, tables=[grid], details=[_scenarios(arena)])


def _term(term: Term) -> str:
    metric = ALL_METRICS[term.metric]
    return f"{'' if term.weight == 1 else f'{term.weight:g} · '}({metric.title}) / {term.scale:.4g} {metric.unit}"


def _scenarios(arena: Arena) -> Grid:
    rows = [
        (label, _TEXTS.text(f"terms.blocks.{block}"), *_facts(scenario))
        for block in BLOCKS
        for label, scenario in zip(arena.labels(block), arena.scenarios(block), strict=True)
    ]
    return _TEXTS.grid("terms.scenarios", rows)


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


def _costs(outcome: Outcome) -> Chapter:
    unit, means, order = outcome.titles[outcome.reference], outcome.term_means("tuned"), outcome.order

    def ratios(k: int) -> Iterator[str]:
        yield from (interval_cell(found[k]) for found in (outcome.published_ratio, outcome.tuned_ratio))
        yield interval_cell(outcome.closed[k], 100, " %")
        yield from (interval_cell(found[k]) for found in (outcome.pooled, outcome.tail))
        yield interval_cell(outcome.failures[k], 100, " %")

    metrics = [ALL_METRICS[term.metric] for term in outcome.arena.made_cost.terms]
    head = [*(f"{metric.title} [{metric.unit}]" for metric in metrics), "Mean cost"]
    grid = _grid(outcome, "costs.ratios", ratios, reference=unit)
    parts = _grid(outcome, "costs.parts", lambda k: map(_number, (*means[:, k], outcome.mean[k])), head)
    cases = outcome.arena.labels("test")
    per = _grid(outcome, "costs.by-scenario", lambda k: map(_number, outcome.by_scenario[k]), cases, reference=unit)
    laws, pairs = entrants(outcome), np.ix_(order, order)
    ordered = [laws[k] for k in order]
    improvement = partial(figures.plot_improvement, ordered, outcome.improvement[pairs], outcome.verdicts[pairs])
    pictures = [_TEXTS.picture("improvement", improvement), *_front(outcome)]
    return _TEXTS.chapter("costs", tables=[grid, parts], details=[per], pictures=pictures)


def _conditions(outcome: Outcome) -> Chapter:
    cells = {title: Cells(of) for title, of in outcome.by_condition.items()}
    columns = list(dict.fromkeys(parts for each in cells.values() for parts in each.columns))
    rows = [
        (title, each.title(row), *(_cell(each, row, parts) for parts in columns))
        for title, each in cells.items()
        for row in each.rows
    ]
    grid = _TEXTS.grid("conditions.costs", rows)
    grid = grid._replace(head=(*grid.head, *map(called, columns)))
    picture = _TEXTS.picture("knowledge", partial(figures.plot_conditions, panels(outcome)))
    return _TEXTS.chapter("conditions", tables=[grid], pictures=[picture])


def _cell(cells: Cells, row: list[int], parts: Knowledge) -> str:
    found = [k for k in row if cells.knowledge[k] == parts]
    return interval_cell(cells.of.cost[found[0]]) if found else ""


def panels(outcome: Outcome) -> list[figures.ConditionPanel]:
    """What each condition's panel shows."""
    found = []
    for title, of in outcome.by_condition.items():
        cells = Cells(of)
        lines = []
        for row in cells.rows:
            own = sorted(row, key=lambda k: cells.columns.index(cells.knowledge[k]))
            law = Entrant(cells.title(row), sort_of(of.made[row[0]]))
            lines.append(figures.KnowledgeLine(law, [called(cells.knowledge[k]) for k in own], of.cost[own]))
        found.append(figures.ConditionPanel(title, [called(parts) for parts in cells.columns], lines, cells.floor))
    return found


def _budgets(outcome: Outcome) -> Chapter:
    grid = _grid(
        outcome,
        "budgets.engines",
        lambda k: (*map(_number, outcome.by_engine[:, k]), outcome.entries[k].by or "published"),
        (*outcome.arena.engines, "Chosen"),
    )
    draw = partial(figures.plot_budget, entrants(outcome), outcome.budgets, outcome.curves)
    return _TEXTS.chapter("budgets", tables=[grid], pictures=[_TEXTS.picture("budget", draw)])


def _weights(outcome: Outcome) -> Chapter:
    cost, weights = outcome.arena.made_cost, outcome.reweighted
    some = [term for term in cost.terms if term.weight > 0]
    rows = []
    for case, order, swapped in zip(weights.weights, weights.order, weights.swapped, strict=True):
        both = zip(some, case, strict=True)
        changed = [f"{term.metric} × {weight / term.weight:g}" for term, weight in both if weight != term.weight]
        rows.append((", ".join(changed) or "as they are", ", ".join(outcome.titles[k] for k in order), str(swapped)))
    alone = np.argsort(outcome.term_means("tuned"), axis=1, kind="stable")
    for term, order in zip(cost.terms, alone, strict=True):
        swapped = swapped_pairs(np.stack([weights.order[0], order]))[1]
        rows.append((f"{term.metric} alone", ", ".join(outcome.titles[k] for k in order), str(swapped)))
    said = _TEXTS.text("weights.changes" if weights.changed.any() else "weights.stays")
    return _TEXTS.chapter("weights", {"said": said}, tables=[_TEXTS.grid("weights.orders", rows)])


def _robustness(outcome: Outcome) -> Chapter:
    laws, order, failed = entrants(outcome), outcome.order, outcome.robust_failures
    changes = [change.replace("-", "−") for change in CHANGES]
    draw = partial(figures.plot_robustness, [laws[k] for k in order], changes, outcome.robustness[order])
    grid = _grid(outcome, "robustness.failed", lambda k: (f"{100 * share:.2g} %" for share in failed[k]), CHANGES)
    return _TEXTS.chapter("robustness", details=[grid], pictures=[_TEXTS.picture("robustness", draw)])


def _laws(outcome: Outcome, specifications: Sequence[str]) -> Chapter:
    def cells(k: int) -> tuple[str, str]:
        return outcome.entries[k].by or "as published", specifications[k] if specifications else ""

    return _TEXTS.chapter("laws", details=[_grid(outcome, "laws.chosen", cells)])


# Words --------------------------------------------------------------------------------------------------------------


def _number(value: float) -> str:
    if np.isnan(value):
        return "–"
    return "fails" if np.isinf(value) else f"{value:.3g}"


def interval_cell(found: Interval, factor: float = 1.0, unit: str = "") -> str:
    """One number, ``factor`` times what was ``found``, with the ends of its interval; a dash where it is not known."""
    value, low, high = (factor * float(v) for v in (found.value, found.low, found.high))
    if not np.isfinite(value):
        return _number(value)
    ends = " to ".join("∞" if v == np.inf else "-∞" if v == -np.inf else f"{v:.3g}" for v in (low, high))
    return f"{value:.3g}{unit} ({ends})"


# Tables -------------------------------------------------------------------------------------------------------------


def write_tables(outcome: Outcome, folder: Path) -> None:
    """Write results.csv, summary.csv, pairs.csv, budgets.csv, scenarios.csv and robustness.csv; and conditions.csv."""
    tables = {
        "results": results_table(outcome),
        "summary": summary_table(outcome),
        "pairs": pairs_table(outcome),
        "budgets": _crossed(outcome, "evaluations", outcome.budgets, "cost", outcome.curves),
        "scenarios": scenarios_table(outcome),
        "robustness": _crossed(outcome, "change", CHANGES, "ratio", outcome.robustness, failed=outcome.robust_failures),
    }
    tables |= {"conditions": conditions_table(outcome)} if outcome.under else {}
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


def conditions_table(outcome: Outcome) -> pd.DataFrame:
    """A row a law and condition, each condition's laws from the least cost up."""
    parts = {title: summary_table(of) for title, of in outcome.by_condition.items()}
    return pd.concat(parts, names=["condition"]).reset_index("condition").reset_index(drop=True)


def results_table(outcome: Outcome) -> pd.DataFrame:
    """A row a run of the test, as published and tuned: its metrics, and whether the robot was stopped."""
    names = [scenario.name for scenario in outcome.arena.scenarios("test")]
    runs = {(entry.law, part): table for entry in outcome.entries for part, table in entry.runs.items()}
    found = pd.concat(runs, names=["law", "gains"]).reset_index(["law", "gains"]).drop(columns="candidate")
    return found.assign(scenario=[names[k] for k in found["scenario"]]).reset_index(drop=True)


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
