"""A page about networks that were learnt from own data: the data, the errors, every network, and how robots drive.

Its numbers and pictures are those of the report's chapter on formations, for any outputs, inputs and number of
networks. The page is one HTML file that needs nothing else.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from anfis.plot import plot_premises
from anfis.training import UNLIKE
from fuzzy.errors import InputError
from fuzzy.files.atomic import write_whole
from fuzzy.shell.progress import Begin, unwatched
from fuzzy.system import Sugeno
from fuzzy.words import counted, listed
from robotics.laws.catalogue import make_controller
from robotics.measures.contacts import can_touch, contact_sentences
from robotics.measures.evidence import mean_of
from robotics.measures.registry import headlines, measure_all
from robotics.plugins.learning.datacard import Card, card_path, read_card
from robotics.plugins.learning.datatable import DataTable, Samples
from robotics.plugins.learning.figures import Fit, plot_search_and_epochs, plot_shares, plot_stages, rms
from robotics.plugins.learning.formation_run import is_formation, plot_formation
from robotics.plugins.learning.formationlearning import Errors, Learnt, columns_of, input_columns
from robotics.plugins.learning.scatter import DRAWS, ScatterError, scatter
from robotics.show.figures.drawing import seeds_as_text
from robotics.show.figures.run import plot_run
from robotics.show.playback.player import player_fragment
from robotics.show.report.chapter import Chapter, Film, Grid
from robotics.show.report.plates import plates_of
from robotics.show.report.template import program, rendered
from robotics.show.report.texts import ReportTexts
from robotics.show.report.wording import shown
from robotics.simulation.loop import simulate
from robotics.simulation.run import Run
from robotics.simulation.scenario.description import Scenario

_MOST_COLUMNS = 16  # of the data that are listed unfolded
_OPEN = 6  # networks that are shown unfolded, at most
_TEMPLATE = Path(__file__).with_name("learning")
STAGES = ("after clustering", "after learning")
_TEXTS = ReportTexts("robotics.plugins.learning")
_ROBOTS = 6  # robots that get a column each
_SENTENCES = 5  # contacts and stops that are told
# What the remarks remark on
_UNLIKE = 2.0  # times the scatter
_LOOSE = 0.05  # of the output's range: a fit that is not close
_SCATTERED = 0.1  # of the output's range: outputs that the inputs do not tell
_OUTSIDE = 0.05  # of the checking samples
_FALLING = 0.01  # decrease of the error over the last tenth of the epochs


class LearningReportError(InputError):
    """Networks and tables that do not belong together."""


def write_learning_report(
    path: str | Path,
    networks: Sequence[Learnt],
    samples: Samples,
    check: Samples | None = None,
    *,
    runs: Sequence[Run] = (),
    title: str | None = None,
    folder: str = "networks",
    command: str | None = None,
    begin: Begin = unwatched,
) -> Path:
    """Write the page about ``networks`` to ``path``, whole or not at all, and return the path.

    The folder of the page is made if it is missing.

    Args:
        path: The file.
        networks: The networks, one for each output.
        samples: The table that they were learnt from.
        check: The checking table, if there was one.
        runs: What the networks drove, a run for each scenario.
        title: The page's title.
        folder: The folder into which the networks were written, for the program on the page.
        command: The command line that made the page.
        begin: Starts a bar of a progress display, by its text and total.

    Raises LearningReportError for a table without the networks' columns, OSError.
    """
    chapters = learning_chapters(networks, samples, check, runs)
    pictures = [picture for chapter in chapters for picture in chapter.pictures]
    page = rendered(
        "paper.html.j2",
        chapters,
        plates_of(pictures, begin("drawing", len(pictures))),
        (),
        title=title or _TEXTS.text("title", file=samples.file),
        lead=[*_lead(networks, samples, check), *([] if runs else [_TEXTS.text("no-drive")])],
        command=command,
        program=program(str(_TEMPLATE), first=networks[0], samples=samples, check=check, folder=folder, path=path),
    )
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, page)
    return Path(path)


def drive_networks(
    folder: str | Path, scenarios: Sequence[Scenario], seeds: Sequence[int], begin: Begin = unwatched
) -> list[Run]:
    """Drive the scenarios with the networks in ``folder``; return a run for each.

    Args:
        folder: The folder of the networks' .fis files.
        scenarios: The scenarios.
        seeds: One run for each, of every scenario.
        begin: Starts a bar of a progress display, by its text and total.

    Raises ControllerError for networks that cannot drive a scenario.
    """
    runs = []
    specification = f"formation:networks={folder}"
    for scenario in scenarios:
        advance = begin(f"driving {scenario.name}", scenario.ticks + 1)
        runs.append(simulate(scenario, make_controller(specification), seeds, name=specification, progress=advance))
    return runs


def learning_chapters(
    networks: Sequence[Learnt], samples: Samples, check: Samples | None = None, runs: Sequence[Run] = ()
) -> list[Chapter]:
    """The chapters of :func:`write_learning_report`, whose arguments these are: summary, data, networks, drives."""
    for table in [samples] if check is None else [samples, check]:
        _demand_columns(networks, table)
    errors = [errors_of(network, samples, check) for network in networks]
    return [
        _summary(errors),
        _data(networks, samples, check),
        *(_network(k, each, samples, check, len(networks) > _OPEN) for k, each in enumerate(errors)),
        *(_drive(k, run) for k, run in enumerate(runs)),
    ]


def _demand_columns(networks: Sequence[Learnt], table: Samples) -> None:
    wanted = [name for network in networks for name in (*input_columns(network.after), network.output)]
    missing = [name for name in dict.fromkeys(wanted) if name not in table.names]
    if missing:
        raise LearningReportError(
            f"{table.file}: the networks need its column{'s' * (len(missing) > 1)} {', '.join(missing)}; "
            f"it has {', '.join(table.names)}"
        )


def errors_of(network: Learnt, samples: Samples, check: Samples | None = None) -> Errors:
    """Measure a network on the samples that it was learnt from and on the checking samples, if there are any."""
    x, y = columns_of(network.after, samples)
    first, last = (rms(found - y) for found in stages(network, x).values())
    try:
        found = scatter(x, y)
        spread = float(found.rms[0]), float(found.least[0]), float(found.most[0])
    except ScatterError:  # too few samples
        spread = (np.nan, np.nan, np.nan)
    checking = outside = np.nan
    if check is not None:
        x_check, y_check = columns_of(network.after, check)
        checking = rms(stages(network, x_check)[STAGES[1]] - y_check)
        outside = float(((x_check < x.min(axis=0)) | (x_check > x.max(axis=0))).any(axis=1).mean())
    return Errors(network, first, last, checking, float(np.ptp(y)), spread, outside)


def stages(network: Learnt, x: np.ndarray) -> dict[str, np.ndarray]:
    """What the network gives at the inputs ``x`` (samples, inputs), by stage of learning: (samples,) each."""
    # Samples may lie beyond those that the clusters were found in
    systems = (replace(network.before, out_of_range="ignore"), network.after)
    return {stage: fis(x)[:, 0] for stage, fis in zip(STAGES, systems, strict=True)}


def fit_of(network: Learnt, table: DataTable | Samples) -> Fit:
    """The network's output over a table, for a picture."""
    x, y = columns_of(network.after, table)
    return Fit(network.after.outputs[0].label, y, stages(network, x))


def parameter_grid(fis: Sugeno, caption: str) -> Grid:
    """The parameters of a network of Gaussian terms and linear consequents, a row for each rule."""
    rows = []
    for r, rule in enumerate(fis.rules):
        clauses = {c.variable: c.term for c in rule.when}
        shapes = [v.terms[clauses[v.name]] for v in fis.inputs]
        plane = fis.outputs[0].terms[rule.then[0][1]]
        widths = (f"{abs(s.sigma):.4g}, {s.c:.4g}" for s in shapes)
        rows.append((str(r + 1), *widths, *(f"{p:.4g}" for p in plane.parameters)))
    names = [v.name for v in fis.inputs]
    return Grid(caption, ("rule", *names, *(f"× {n}" for n in names), "constant"), rows)


def setting_of(network: Learnt) -> str:
    """Radius, squash, accept and reject of the setting that was taken, as a table shows them."""
    trial = network.trial
    return f"{trial.radius:g}, {trial.options.squash:g}, {trial.options.accept:g}, {trial.options.reject:g}"


# The chapters -----------------------------------------------------------------------------------------------------


def _lead(networks: Sequence[Learnt], samples: Samples, check: Samples | None) -> list[str]:
    found = {"wanted": " or ".join(map(str, sorted({network.search.wanted for network in networks})))}
    found |= {"count": counted(len(networks), "network"), "were": "was" if len(networks) == 1 else "were"}
    found |= {"kept": "training", "beside": ""}
    if check is not None:
        beside = _TEXTS.text("lead.beside", samples=len(check.values), file=check.file)
        found |= {"kept": "checking", "beside": beside}
    sizes = {"samples": len(samples.values), "trials": len(networks[0].search.trials)}
    return [_TEXTS.text("lead.text", **sizes, **found, file=samples.file, options=networks[0].training.options)]


def _summary(errors: Sequence[Errors]) -> Chapter:
    columns: dict[str, Callable[[Errors], str]] = {
        "output": lambda each: each.network.after.outputs[0].label,
        "rules": lambda each: str(each.network.trial.rules),
        "radius, squash, accept, reject": lambda each: setting_of(each.network),
        "clustering": lambda each: _plain(each.clustering),
        "learnt, training": lambda each: _plain(each.training),
        "learnt, checking": lambda each: _plain(each.checking),
        "of its range": lambda each: _percent(each.last, each.range),
        "scatter": lambda each: _spanned(each.scatter),
        "of the scatter": lambda each: _times(each.last, each.scatter[0]),
    }
    known = all(np.isfinite(each.scatter[0]) for each in errors)
    untold = "" if known else _TEXTS.text("summary.untold")
    found = [(each.network.output, remark) for each in errors for remark in remarks(each) or ["nothing"]]
    return Chapter(
        "summary",
        _TEXTS.text("summary.title"),
        tables=[
            Grid.of(_TEXTS.text("summary.caption", draws=DRAWS, untold=untold), errors, columns),
            _TEXTS.grid("remarks", found),
        ],
        pictures=[_TEXTS.picture("errors", partial(plot_shares, errors), outputs=len(errors))],
    )


def remarks(errors: Errors) -> list[str]:
    """What stands out about a network, in sentences."""
    network, training = errors.network, errors.training
    trial, wanted = network.trial, network.search.wanted
    mean, least, most = errors.scatter
    found = []

    def remark(key: str, **values: float) -> None:
        found.append(_TEXTS.text(f"remarks.{key}", **values))

    if trial.rules != wanted:
        remark("other-rules", wanted=wanted, rules=trial.rules)
    if trial.rank < trial.parameters:
        remark("few-samples", rank=trial.rank, parameters=trial.parameters)
    if errors.range == 0:
        remark("constant")
        return found
    if network.training.added_nothing:
        remark("nothing-added", epoch=network.training.best)
    if (less := network.fewer) is not None:
        remark("fewer", rules=less.rules, error=less.error, taken=trial.error)
    if errors.checking > UNLIKE * training:
        remark("overfit", times=errors.checking / training)
    if errors.outside > _OUTSIDE:
        remark("outside", share=100 * errors.outside)
    if mean > _SCATTERED * errors.range:
        remark("scattered", share=100 * mean / errors.range)
    if training < least:
        remark("below-scatter")
    elif errors.last > _LOOSE * errors.range and errors.last > _UNLIKE * most:
        remark("loose")
    if _falling(network):
        remark("falling")
    return found


def _falling(network: Learnt) -> bool:
    history = network.training.history
    if network.training.stopped != "epochs" or network.training.best != history[-1].epoch or len(history) < 2:
        return False
    errors = [row.check if np.isfinite(row.check) else row.train for row in history]
    before = errors[-1 - max(1, (len(errors) - 1) // 10)]
    return errors[-1] < (1 - _FALLING) * before


def _data(networks: Sequence[Learnt], samples: Samples, check: Samples | None) -> Chapter:
    inputs: dict[str, list[str]] = {}
    outputs, units = {network.output for network in networks}, {}
    for network in networks:
        for name, variable in zip(input_columns(network.after), network.after.inputs, strict=True):
            inputs.setdefault(name, []).append(network.output)
            units[name] = variable.unit
        units[network.output] = network.after.outputs[0].unit
    card = _card(samples)
    rows, meanings = [], set()
    for name in samples.names:
        role = "output" if name in outputs else f"input of {', '.join(inputs[name])}" if name in inputs else "not used"
        known = card.columns.get(name, {})
        row = [name, units.get(name) or known.get("unit") or "–", role]
        for table in (samples, check):
            if table is not None:
                column = table.values[:, table.names.index(name)] if name in table.names else np.array([np.nan])
                row += [_plain(float(v)) for v in (column.min(), column.max(), column.std())]
        meaning = known.get("meaning", "")
        row += ["the same" if meaning in meanings else meaning] if card.columns else []
        meanings.add(meaning)
        rows.append(tuple(row))
    head = _TEXTS.texts("data.head") + (() if check is None else _TEXTS.texts("data.checking-head"))
    head += ("meaning",) if card.columns else ()
    told = _TEXTS.text("data.told", file=samples.file, samples=len(samples.values))
    told += "" if check is None else _TEXTS.text("data.checked", file=check.file, samples=len(check.values))
    left_out = samples.skipped + (0 if check is None else check.skipped)
    told += _TEXTS.text("data.left-out", rows=left_out) if left_out else ""
    columns = Grid(f"{told}.", head, rows)
    made = Grid(_TEXTS.text("data.made", file=samples.file), ("fact", "value"), list(card.facts.items()))
    shown, title = [made] if card.facts else [], _TEXTS.text("data.title")
    if len(rows) > _MOST_COLUMNS:
        folded = _TEXTS.text("data.folded", columns=len(rows))
        return Chapter("data", title, tables=shown, details=[columns], folded=folded)
    return Chapter("data", title, tables=[columns, *shown])


def _card(samples: Samples) -> Card:
    """The data card beside the table's file; an empty one where there is none that can be read."""
    try:
        return read_card(card_path(samples.file))
    except (OSError, StopIteration, ValueError, IndexError):
        return Card({}, {})


def _network(k: int, errors: Errors, samples: Samples, check: Samples | None, closed: bool) -> Chapter:
    network, training = errors.network, errors.network.training
    output, inputs = network.after.outputs[0], listed([v.name for v in network.after.inputs])
    fits = {"training samples": fit_of(network, samples)}
    if check is not None:
        fits["checking samples"] = fit_of(network, check)
    # The ring marks the setting that was taken, which need not have the wanted number of rules
    search = replace(network.search, outputs=((output.name, output.unit),), wanted=network.trial.rules)
    name = f"network-{k + 1}"
    plots = {
        "learning": partial(plot_search_and_epochs, search, training.history, output.unit),
        "fit": partial(plot_stages, fits),
        "memberships": partial(plot_premises, network.before, network.after),
    }
    about: dict[str, Any] = {"output": output, "inputs": inputs, "rules": network.trial.rules, "search": search}
    about |= {"setting": setting_of(network), "trials": len(search.trials), "epochs": len(training.history)}
    about |= {stage: _plain(getattr(errors, stage)) for stage in ("clustering", "training", "checking")}
    about |= {"best": training.best, "last": training.history[-1].epoch, "reason": training.stopped}
    about["checked"] = "" if check is None else _TEXTS.text("network.checked", **about)
    about["stopped"] = "" if training.stopped == "epochs" else _TEXTS.text("network.stopped", **about)
    return Chapter(
        name,
        _TEXTS.text("network.title", **about),
        (_TEXTS.text("network.text", **about),),
        details=[
            parameter_grid(network.before, _TEXTS.text("network.before")),
            parameter_grid(network.after, _TEXTS.text("network.after")),
        ],
        pictures=[_TEXTS.picture(f"{name}-{k}", plot, key=f"network.{k}", **about) for k, plot in plots.items()],
        folded="Parameters",
        closed=closed,
    )


def _drive(k: int, run: Run) -> Chapter:
    values, robots = measure_all(run), run.samples.shape[3]
    few = robots <= _ROBOTS
    rows = []
    for name, metric in headlines(run.about.kind, can_touch(run)).items():
        found = values[name]
        columns = found.T if few else np.stack([np.min(found, 1), np.median(found, 1), np.max(found, 1)])
        rows.append((metric.title, *(shown(mean_of(c), metric.unit) for c in columns)))
    lines = [*contact_sentences(run), *run.divergences()]
    more = [] if len(lines) <= _SENTENCES else [_TEXTS.text("drive.more", lines=len(lines) - _SENTENCES)]
    several = len(run.seeds) > 1
    about = {"scenario": run.scenario, "s": "s" * several, "seeds": seeds_as_text(run.seeds)}
    caption = _TEXTS.text("drive.table", **about, many=_TEXTS.text("drive.many") if several else "")
    head = [f"robot {i + 1}" for i in range(robots)] if few else ["least", "median", "largest"]
    first: dict[str, Any] = {"scenario": run.scenario, "seed": run.seeds[0]}
    page, name = partial(plot_formation if is_formation(run) else plot_run, run), f"drive-{k + 1}"
    return Chapter(
        name,
        _TEXTS.text("drive.title", scenario=run.scenario),
        tuple(f"{line[0].upper()}{line[1:].rstrip('.')}." for line in lines[:_SENTENCES]) + tuple(more)
        if lines
        else (_TEXTS.text("drive.quiet"),),
        [Grid(caption, ("quantity", *head), rows)],
        pictures=[_TEXTS.picture(name, page, key="drive", **first, robots=robots, s="s" * (robots > 1))],
        films=[Film(_TEXTS.text("drive.film", **first), partial(player_fragment, run), name)],
    )


# Numbers in words ---------------------------------------------------------------------------------------------------


def _plain(value: float) -> str:
    if not np.isfinite(value):
        return "–"
    number, _, power = f"{value:.3g}".replace("-", "−").partition("e")
    return f"{number}e{power[0].strip('+')}{power[1:].lstrip('0')}" if power else number


def _percent(value: float, span: float) -> str:
    return "–" if span == 0 or not np.isfinite(value) else f"{100 * value / span:.2g} %"


def _times(value: float, scattered: float) -> str:
    return f"{value / scattered:.2g} ×" if scattered > 0 else "–"


def _spanned(spread: tuple[float, float, float]) -> str:
    mean, least, most = map(_plain, spread)
    return mean if mean == "–" else f"{mean} ({least} to {most})"
