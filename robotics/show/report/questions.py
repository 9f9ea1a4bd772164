"""Questions to the table of a study: functions of the table that give an answer, those of the package and one's own.

A study's file names them, `questions = ["leads", "mine.py:clearance"]`. The table has a row for each run and robot; its
``attrs`` say the units and the titles of its columns, and which metric comes first.
"""

import inspect
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from fuzzy.errors import InputError
from fuzzy.figures.drawing import DOUBLE, PAGE_WIDTH, styled_figure
from fuzzy.files.pythonfile import load_python_file, told
from fuzzy.naming import expected
from fuzzy.shown import shown
from fuzzy.words import counted, listed
from robotics.laws.catalogue import law_title
from robotics.laws.specification import Specification
from robotics.measures.evidence import mean_of, rate_of
from robotics.measures.registry import ALL_METRICS
from robotics.measures.statistics.ranking import pareto_front
from robotics.measures.tracking import Metric
from robotics.show.figures.drawing import looks
from robotics.show.figures.leads import plot_leads
from robotics.show.report.answer import leading_sentences
from robotics.show.report.chapter import Chapter, Grid, Picture
from robotics.show.report.summarytable import lead_by
from robotics.studies.comparison import summarise

CASE = ("scenario", "condition", "point")  # the columns that say where a run was driven
_BANDS = 8  # into which the values of an axis of many are gathered


class QuestionError(InputError):
    """A question that there is not, that fails, or that gives no answer."""


@dataclass(frozen=True, eq=False)
class Answer:
    """What a question finds in the table of a study.

    Attributes:
        sentence: The answer, in a sentence or a few.
        title: What stands over it; by default the name of the question.
        table: Numbers behind it.
        picture: What shows it, or a function that draws it when its turn comes.

    Raises:
        QuestionError: Something that cannot be shown.
    """

    sentence: str
    title: str = ""
    table: pd.DataFrame | None = None
    picture: Figure | Callable[[], Figure] | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.sentence, str) or not self.sentence.strip():
            raise QuestionError(f"an answer needs a sentence, text that is not empty; got {self.sentence!r}")
        if self.table is not None and not isinstance(self.table, pd.DataFrame):
            raise QuestionError(f"the table of an answer must be a pandas.DataFrame; got {type(self.table).__name__}")
        if not (self.picture is None or isinstance(self.picture, Figure) or callable(self.picture)):
            what = f"a matplotlib.figure.Figure, or a function that makes one; got {type(self.picture).__name__}"
            raise QuestionError(f"the picture of an answer must be {what}")

    def row(self) -> dict[str, Any]:
        """The answer in JSON's types, without the picture."""
        rows = None if self.table is None else self.table.to_dict(orient="records")
        return {"title": self.title, "sentence": self.sentence, "table": rows}


Question = Callable[[pd.DataFrame], Answer]


def question_called(name: str, folder: Path = Path(), own: Mapping[str, Metric] | None = None) -> Question:
    """The question of that name, or that of a Python file, ``file.py:function``.

    Args:
        name: A name of QUESTIONS, or a specification.
        folder: Where the file is looked for first.
        own: The study's own metrics, by name.

    Raises QuestionError where there is none.
    """
    about = Specification.of(name)
    if not about.file.endswith(".py"):
        if name not in QUESTIONS:
            raise QuestionError(f"{expected(name, QUESTIONS, 'question')}; or a function of a table, file.py:function")
        return partial(QUESTIONS[name], own=own or {})
    file = about.located(folder).file
    module = load_python_file(file, QuestionError)
    functions = [n for n, thing in vars(module).items() if inspect.isfunction(thing) and n[0] != "_"]
    if about.name not in functions:
        known = expected(about.name or "", functions, "question")
        raise QuestionError(f"{file}: {known}; a question is named file.py:function")
    return partial(_asked, vars(module)[about.name], about.name, file)


def _asked(function: Question, name: str, file: str, table: pd.DataFrame) -> Answer:
    """The answer of a user's own function."""
    try:
        found = function(table)
    except Exception as error:
        place = inspect.getsourcefile(inspect.unwrap(function)) or ""
        where = f"{told(error, place, Path(file).name)} (in the question {name})"
        if isinstance(error, KeyError) and error.args[0] not in table:
            where += f"; the columns of the table are {', '.join(map(str, table))}"
        raise QuestionError(where) from error
    if not isinstance(found, Answer):
        raise QuestionError(f"{file}: the question {name} must return a robotics.Answer; got {found!r}")
    return found


def asked(
    names: Sequence[str], table: pd.DataFrame, folder: Path = Path(), own: Mapping[str, Metric] | None = None
) -> dict[str, Answer]:
    """The answers to questions, by their names. Raises QuestionError."""
    return {name: question_called(name, folder, own)(table) for name in names}


def described_table(
    table: pd.DataFrame, own: Mapping[str, Metric], first: str, axes: Sequence[str] = ()
) -> pd.DataFrame:
    """The table of a study for questions: its ``attrs`` describe the columns; ``first`` is the metric that leads."""
    known = {name: about for name, about in {**ALL_METRICS, **own}.items() if name in table}
    table = table.copy(deep=False)
    table.attrs = {
        "units": {name: about.unit for name, about in known.items()},
        "titles": {name: about.title for name, about in known.items()},
        "first": first,
        "axes": list(axes),
    }
    return table


def answer_chapters(answers: Mapping[str, Answer]) -> list[Chapter]:
    """A chapter of the report for each answer."""
    return [_chapter(place, name, answer) for place, (name, answer) in enumerate(answers.items(), start=1)]


def _chapter(place: int, name: str, answer: Answer) -> Chapter:
    title, tables, pictures = answer.title or name, list[Grid](), list[Picture]()
    if answer.table is not None:
        rows = [tuple(map(_cell, row)) for row in answer.table.itertuples(index=False)]
        tables = [Grid(title, tuple(map(str, answer.table.columns)), rows)]
    if answer.picture is not None:
        caption = title if title[-1] in ".?!" else f"{title}."
        pictures = [Picture(f"question-{place}", caption, answer.sentence, partial(_drawn, answer.picture))]
    return Chapter(f"question-{place}", title, (answer.sentence,), tables=tables, pictures=pictures)


def _drawn(picture: Figure | Callable[[], Figure]) -> Figure:
    found = picture if isinstance(picture, Figure) else picture()
    if not isinstance(found, Figure):
        raise QuestionError(f"the picture of an answer must be a matplotlib.figure.Figure; got {type(found).__name__}")
    if found.get_layout_engine() is None:
        found.set_layout_engine("constrained")
    return found


def _cell(value: Any) -> str:
    return shown(float(value), 1.0) if isinstance(value, (float, np.floating)) else str(value)


# Those of the package ---------------------------------------------------------------------------------------------


def _first(table: pd.DataFrame, own: Mapping[str, Metric]) -> tuple[str, Metric]:
    name = table.attrs["first"]
    return name, {**ALL_METRICS, **own}[name]


def _cases(table: pd.DataFrame) -> Iterator[tuple[str, pd.DataFrame]]:
    """The rows of each scenario, condition and point, by what it is called."""
    names = [name for name in CASE if name in table]
    for key, rows in table.groupby(names, sort=False, dropna=False):
        words = [f"point {part}" if name == "point" else str(part) for name, part in zip(names, key, strict=True)]
        yield ", ".join(word for word in words if word), rows


def _by_run(rows: pd.DataFrame, column: str) -> Any:
    """A column by the runs of one case or of several."""
    names = [name for name in (*CASE, "seed") if name in rows]
    return rows.groupby(names, sort=False, dropna=False)[column]


def _runs(rows: pd.DataFrame, metric: str, about: Metric) -> np.ndarray:
    """One number a run, of the rows of one case or of several."""
    return np.asarray(_by_run(rows, metric).agg(about.of_run).to_numpy(dtype=float))


def _summary(table: pd.DataFrame, own: Mapping[str, Metric]) -> Answer:
    """Means with their intervals."""
    parts = [summarise(rows, own).assign(scenario=name) for name, rows in _cases(table)]
    found = pd.concat(parts, ignore_index=True)
    metrics, laws = found["metric"].nunique(), found["controller"].nunique()
    sentence = f"Means and 95 % intervals of {counted(metrics, 'metric')} of {counted(laws, 'controller')}."
    return Answer(sentence, "Means with intervals", found)


def _leads(table: pd.DataFrame, own: Mapping[str, Metric]) -> Answer:
    """Who leads where, by the first metric."""
    metric, about = _first(table, own)
    found = []
    for name, rows in _cases(table):
        by_law = {str(law): mine for law, mine in rows.groupby("controller", sort=False)}
        found.append(lead_by(metric, about, by_law, name))
    standings = [
        {"where": one.scenario, "controller": s.law, metric: s.value.value, "leads": "yes" if s.leads else "no"}
        for one in found
        for s in one.standings
    ]
    sentence = " ".join(leading_sentences(found)) or "There is one law only."
    return Answer(sentence, "Who leads where", pd.DataFrame(standings), partial(plot_leads, found, PAGE_WIDTH))


def _ranking(table: pd.DataFrame, own: Mapping[str, Metric]) -> Answer:
    """The ranks of the laws, by the first metric, in each run that all of them drove."""
    metric, about = _first(table, own)
    by_law = {law: _by_run(mine, metric).agg(about.of_run) for law, mine in table.groupby("controller", sort=False)}
    shared = pd.concat(by_law, axis=1, join="inner")
    if shared.empty:
        raise QuestionError("ranking: there is no scenario that all controllers drive")
    laws, values = list(map(str, shared)), shared.to_numpy(dtype=float).T
    ranks = pd.DataFrame(-values if about.larger else values).rank(axis=0, method="average").to_numpy()
    means = [mean_of(row) for row in ranks]
    order = sorted(range(len(laws)), key=lambda k: means[k].value)
    rows = [
        {"controller": laws[k], "mean rank": means[k].value, "low": means[k].low, "high": means[k].high,
         "first in": f"{100 * np.mean(ranks[k] == ranks.min(axis=0)):.0f} %"}
        for k in order
    ]  # fmt: skip
    said = listed([f"{law_title(laws[k])} {means[k].value:.2f}" for k in order])
    sentence = f"Mean rank by {about.title}, run by run over {counted(values.shape[1], 'run')}: {said}."
    return Answer(sentence, "Ranking", pd.DataFrame(rows))


def _rates(table: pd.DataFrame, own: Mapping[str, Metric]) -> Answer:
    """How often something goes wrong: contacts, and robots that lost their references."""
    rows, bad = [], []
    for law, mine in table.groupby("controller", sort=False):
        for what in ("contact", "diverged"):
            if what in mine and mine[what].notna().any():
                happened = _by_run(mine.assign(**{what: mine[what].eq(True)}), what).any()
                found = rate_of(happened.to_numpy())
                share = {"share": found.value, "low": found.low, "high": found.high, "runs": found.runs}
                rows.append({"controller": law, "what": what} | share)
                bad += [f"{law_title(str(law))} {100 * found.value:.1f} % {what}"] * bool(found.value)
    sentence = f"Shares of runs: {listed(bad)}." if bad else "No run had a contact, and no robot lost its reference."
    return Answer(sentence, "What went wrong, and how often", pd.DataFrame(rows))


def _front(table: pd.DataFrame, own: Mapping[str, Metric]) -> Answer:
    """Who is beaten in nothing, by the first metric and the changes of the demanded turn rate."""
    metric, _ = _first(table, own)
    metrics = {**ALL_METRICS, **own}
    chosen = [metric, next(n for n in ("w_variation_radps2", *metrics) if n in table and n != metric)]
    laws = list(dict.fromkeys(table["controller"]))
    means = np.array(
        [[np.mean(_runs(table[table["controller"] == law], n, metrics[n])) for n in chosen] for law in laws]
    )
    signs = np.array([-1.0 if metrics[n].larger else 1.0 for n in chosen])
    front = {law for law, there in zip(laws, pareto_front(signs * means), strict=True) if there}
    rows = pd.DataFrame(means, columns=chosen)
    rows.insert(0, "controller", laws)
    rows["on the front"] = ["yes" if law in front else "no" for law in laws]
    sentence = f"In {metric} and {chosen[1]} together {listed([law_title(law) for law in laws if law in front])}"
    return Answer(f"{sentence} {'is' if len(front) == 1 else 'are'} beaten by nobody.", "The front", rows)


def _axes(table: pd.DataFrame, own: Mapping[str, Metric]) -> Answer:
    """How the first metric changes along each axis."""
    metric, about = _first(table, own)
    names = [name for name in table.attrs.get("axes", ()) if pd.api.types.is_numeric_dtype(table[name])]
    if not names:
        return Answer("The study has no axis of numbers.", "Along the axes")
    rows = []
    for axis in names:
        for law, mine in table.groupby("controller", sort=False):
            for value, band in mine.groupby(_banded(mine[axis])):
                mean = mean_of(_runs(band, metric, about))
                rows.append({"axis": axis, "controller": law, "value": value, metric: mean.value,
                             "low": mean.low, "high": mean.high, "runs": mean.runs})  # fmt: skip
    found, said = pd.DataFrame(rows), []
    for (along, who), line in found.groupby(["axis", "controller"], sort=False):
        first, last = (f"{line[metric].iloc[k]:.3g}" for k in (0, -1))
        said.append(f"{law_title(str(who))} along {along} from {first} to {last}")
    sentence = f"{about.title[0].upper()}{about.title[1:]} [{about.unit}]: {'; '.join(said)}."
    return Answer(sentence, "Along the axes", found, partial(_plot_axes, found, metric, about))


def _banded(values: pd.Series) -> pd.Series:
    """The values of an axis; of many, the middle of the band that each is in."""
    if values.nunique() <= _BANDS:
        return values
    bands = pd.qcut(values, _BANDS, labels=False, duplicates="drop")
    return values.groupby(bands).transform("median")


def _plot_axes(found: pd.DataFrame, metric: str, about: Metric) -> Figure:
    axes = list(dict.fromkeys(found["axis"]))
    looked = looks(found["controller"])
    with styled_figure(DOUBLE, 2.4 * len(axes)) as figure:
        for ax, axis in zip(np.atleast_1d(figure.subplots(len(axes), 1)), axes, strict=True):
            for law, line in found[found["axis"] == axis].groupby("controller", sort=False):
                look = looked[str(law)]
                ax.plot(line["value"], line[metric], color=look.color, linestyle=look.line, marker=look.marker,
                        markersize=3, label=law_title(str(law)))  # fmt: skip
                ax.fill_between(line["value"], line["low"], line["high"], color=look.color, alpha=0.15, linewidth=0)
            ax.set_xlabel(axis)
            ax.set_ylabel(f"{about.short or about.title} [{about.unit}]")
        figure.axes[0].legend(fontsize=7)
        return figure


QUESTIONS: Mapping[str, Callable[..., Answer]] = {
    "summary": _summary,
    "leads": _leads,
    "ranking": _ranking,
    "rates": _rates,
    "front": _front,
    "axes": _axes,
}
