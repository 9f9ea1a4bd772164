"""The page of an arena of tasks: the answer in one look and ten sentences, and behind it the numbers and the terms."""

from collections.abc import Iterable
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd

from fuzzy.files.table import write_frame
from fuzzy.shell.progress import Begin, unwatched
from robotics.laws.specification import Specification
from robotics.measures.statistics.intervals import Interval
from robotics.plugins.arena.page import write_page
from robotics.plugins.arena.plan import BLOCKS
from robotics.plugins.arena.report import interval_cell
from robotics.plugins.tasks.answer import answer
from robotics.plugins.tasks.description import CLASSES, TASKS_PAGE, TaskArena
from robotics.plugins.tasks.figures import TaskRow, plot_tasks
from robotics.plugins.tasks.outcome import MEANS, TaskOutcome, paired_p
from robotics.show.report.chapter import Chapter, Grid, Picture
from robotics.show.report.texts import ReportTexts

_TEXTS = ReportTexts("robotics.plugins.tasks")


def write_tasks(outcome: TaskOutcome, folder: Path, *, command: str | None = None, begin: Begin = unwatched) -> Path:
    """Write the tables, the figure and the page of an arena of tasks; return the page's path.

    The files are tasks.html, figures/, results.csv (a row a law and run), ranking.csv (a row a law) and laws.csv (the
    chosen laws as specifications).
    """
    for name, table in (
        ("results", results_table(outcome)),
        ("ranking", ranking_table(outcome)),
        ("laws", laws_table(outcome)),
    ):
        write_frame(table, folder / f"{name}.csv")
    head = one_look(outcome)
    chapters = [_ranking(outcome), _sorts(outcome), _terms(outcome)]
    advance = begin("drawing", 2)
    return write_page(outcome, [head], chapters, answer(outcome), folder / TASKS_PAGE, command=command, advance=advance)


def one_look(outcome: TaskOutcome) -> Picture:
    """The one look."""
    order = [k for knowledge in outcome.filled for k in outcome.among(knowledge)]
    rows = [
        TaskRow(outcome.titles[k], CLASSES.index(outcome.classes[k]), 1 + outcome.among(outcome.classes[k]).index(k))
        for k in order
    ]
    caused, without = outcome.share("caused"), outcome.share("caused", unguarded=True)
    shares = (caused[order], without[order], outcome.share("deadlock")[order])
    draw = partial(plot_tasks, rows, CLASSES, *shares, outcome.mean("time")[order])
    said = "; ".join(f"{outcome.titles[k]} {1000 * caused.value[k]:.3g}" for k in order)
    return _TEXTS.picture("tasks", draw, runs=f"{outcome.runs:,}", said=said)


# Tables -------------------------------------------------------------------------------------------------------------


def results_table(outcome: TaskOutcome) -> pd.DataFrame:
    """A row a law and run of the test: what was drawn, and what became of it."""
    facts = pd.DataFrame([scenario.facts for scenario in outcome.arena.scenarios("test")])
    parts = []
    for entry in outcome.entries:
        for guarded, table in (("as it is", entry.runs), ("without", entry.unguarded)):
            if table is not None:
                own = table.drop(columns="candidate").reset_index(drop=True)
                drawn = facts.iloc[own["scenario"]].reset_index(drop=True)
                parts.append(pd.concat([own.assign(law=entry.law, emergency_rule=guarded), drawn], axis=1))
    found = pd.concat(parts, ignore_index=True)
    first = ["law", "emergency_rule", "scenario", *facts.columns]
    return found[[*first, *(name for name in found.columns if name not in first)]]


def ranking_table(outcome: TaskOutcome) -> pd.DataFrame:
    """A row a law, class by class, the first of each on top."""
    order = [k for knowledge in outcome.filled for k in outcome.among(knowledge)]
    columns: dict[str, object] = {
        "class": [outcome.classes[k] for k in order],
        "rank": [1 + outcome.among(outcome.classes[k]).index(k) for k in order],
        "law": [outcome.laws[k] for k in order],
        "runs": outcome.runs,
    }
    shares = (("caused", False), ("caused", True), ("deadlock", False), ("refused", False), ("touched", False))
    for name, without in shares:
        key = f"{name}{'_without_emergency' if without else ''}_per_1000"
        found = outcome.share(name, without)[order]
        columns |= {key: 1000 * found.value, f"{key}_low": 1000 * found.low, f"{key}_high": 1000 * found.high}
    for name in (*MEANS, "emergency"):
        found = outcome.mean(name)[order]
        columns |= {name: found.value, f"{name}_low": found.low, f"{name}_high": found.high}
    columns["least_clearance_m"] = [outcome.least_clearance(k) for k in order]
    return pd.DataFrame(columns)


def laws_table(outcome: TaskOutcome) -> pd.DataFrame:
    """A row a law: as it is specified, and with the numbers that were chosen, usable with --controller."""
    return pd.DataFrame({"law": outcome.laws, "chosen": [chosen_law(outcome, k) for k in range(len(outcome.laws))]})


def chosen_law(outcome: TaskOutcome, k: int) -> str:
    """The specification of the chosen law."""
    entry = outcome.entries[k]
    space = outcome.arena.space(entry.law)
    if entry.values is None or space is None:
        return entry.law
    gains = [f"{name}={value!r}" for name, value in space.gains_at(entry.values).items()]
    return str(Specification.of(entry.law).with_gains(gains))


# Chapters -----------------------------------------------------------------------------------------------------------


def _ranking(outcome: TaskOutcome) -> Chapter:
    caused, locked = outcome.share("caused"), outcome.share("deadlock")
    means = {name: outcome.mean(name) for name in (*MEANS, "emergency")}
    order = [k for knowledge in outcome.filled for k in outcome.among(knowledge)]
    rows = [
        (
            outcome.titles[k],
            outcome.classes[k],
            interval_cell(caused[k], 1000),
            interval_cell(locked[k], 1000),
            *(interval_cell(means[name][k], 100 if name == "gap" else 1) for name in MEANS),
            f"{outcome.least_clearance(k):.3f}",
        )
        for k in order
    ]
    grids = [_TEXTS.grid("ranking.of-all", rows)]
    without = outcome.share("caused", unguarded=True)
    if own := [k for k in order if np.isfinite(without.value[k])]:
        grids.append(_TEXTS.grid("ranking.without", [_without(outcome, k, means["emergency"]) for k in own]))
    return _TEXTS.chapter("ranking", tables=grids)


def _without(outcome: TaskOutcome, k: int, acted: Interval) -> tuple[str, ...]:
    entry = outcome.entries[k]
    assert entry.unguarded is not None
    p = paired_p(entry.runs["caused"].to_numpy(), entry.unguarded["caused"].to_numpy())
    shares = [interval_cell(outcome.share("caused", without)[k], 1000) for without in (True, False)]
    return outcome.titles[k], *shares, f"{p:.2g}", interval_cell(acted[k], 100)


def _sorts(outcome: TaskOutcome) -> Chapter:
    counts: dict[str, int] = {}
    for family in outcome.arena.test:
        counts[family.label] = counts.get(family.label, 0) + family.count
    grids = []
    for key, name in (("sorts.caused", "caused"), ("sorts.deadlocks", "deadlock")):
        table = outcome.by_family(name)
        rows = [
            (label, str(counts[label]), *(f"{100 * value:.3g}" for value in row))
            for label, row in zip(table.index, table.to_numpy(), strict=True)
        ]
        grid = _TEXTS.grid(key, rows)
        grids.append(grid._replace(head=(*grid.head, *table.columns)))
    return _TEXTS.chapter("sorts", tables=grids)


def _terms(outcome: TaskOutcome) -> Chapter:
    arena = outcome.arena
    cost = (
        f"{arena.contact:g} times the share of runs with a contact caused, {arena.deadlock:g} times that of deadlocks, "
        f"{arena.tail:g} times the tail of the clearances, the mean over the nearest {100 * arena.worst:g} % of "
        f"1 − clearance/{arena.near:g} m, and the mean time over nominal less 1"
    )
    laws = [
        (
            outcome.titles[k],
            str(len(entry.parameters)),
            f"{len(entry.searches)} × {arena.budget(entry.law)}" if entry.searches else "as published",
            chosen_law(outcome, k) if entry.chosen else "as published",
        )
        for k, entry in enumerate(outcome.entries)
    ]
    return _TEXTS.chapter("terms", {"cost": cost}, tables=[_TEXTS.grid("terms.laws", laws)], details=[_families(arena)])


def _families(arena: TaskArena) -> Grid:
    rows: Iterable[tuple[str, ...]] = [
        (
            block,
            family.label,
            str(family.count),
            f"{family.fewest} to {family.most}",
            ", ".join(family.models),
            f"{family.loss:g}",
            f"{family.latency:g}",
            f"{family.held_up:g}",
            f"{family.silent:g}",
            str(family.discs),
        )
        for block in BLOCKS
        for family in getattr(arena, block)
    ]
    return _TEXTS.grid("terms.families", list(rows))
