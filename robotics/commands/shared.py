"""Shared parts of the commands: options, and how numbers and divergences are printed."""

import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fuzzy.errors import InputError
from fuzzy.shell.options import FieldOptions, argument, option
from fuzzy.shell.terminal import USAGE, print_json
from fuzzy.shown import shown
from robotics.commands.completion import controllers, metrics, scenarios
from robotics.studies.versions import versions

if TYPE_CHECKING:
    from robotics.commands.run_files import RunFiles
    from robotics.measures.outside import OutsideInput
    from robotics.measures.tracking import Metric as Measured
    from robotics.simulation.run import Run

UNTIL_CONTACT = "✕: runs with a contact count up to the first one, but for contacts and least clearance"
_COLUMNS = 6  # robots that get a column each
_SHOWN = 5  # runs whose first contact is named

Workers = Annotated[int | None, option("Number of processes. Default: one for each core, if it pays.", min=1, max=1000)]
ScenarioName = Annotated[str, argument("A scenario's name, or a .toml file.", autocompletion=scenarios)]
SavedRun = Annotated[Path, argument("A file that `robotics run ... --save` wrote.", "RUN.npz")]
OneSeed = Annotated[int | None, option("One of the run's seeds. Default: the first.")]
Laws = Annotated[list[str] | None, option("A law of your own besides: mylaw.py:MyLaw:gain=2.", "--law", "FILE.py:NAME")]
Law = Annotated[
    str | None, option("A law of your own as the controller: mylaw.py:MyLaw:gain=2.", "--law", "FILE.py:NAME")
]
Metric = Annotated[
    list[str] | None,
    option("Also measure your own metric, mymetric.py:comfort.", "--metric", "FILE.py:NAME", autocompletion=metrics),
]
Dask = Annotated[str | None, option("Address of a Dask scheduler, such as tcp://127.0.0.1:8786.", "--dask", "ADDRESS")]
Fresh = Annotated[bool, option("Discard what FOLDER has of a study that was interrupted.")]
Report = Annotated[bool, option("Draw figures and write report.html.", "--report/--no-report")]
Files = Annotated[
    "RunFiles",
    FieldOptions(
        "robotics.commands.run_files:RunFiles",
        *("plot", "save", "table", "events", "player"),
        added="fuzzyfleet.runfiles",
    ),
]


def controller_option(sentence: str) -> Any:
    """The option that names the controller."""
    return option(sentence, "--controller", "-c", autocompletion=controllers)


def chosen_controller(controller: str | None, law: str | None) -> str | None:
    """The controller that --controller or --law names, if one of them does. Raises InputError if both do."""
    if controller is not None and law is not None:
        raise InputError("give --controller or --law, not both")
    return controller if law is None else law


def print_result(as_json: bool, about: Any, text: str) -> None:
    """Print what came out, as JSON or in words."""
    if as_json:
        print_json(about)
    else:
        print(text)


def print_forewarnings(sentences: Iterable[str]) -> None:
    """Print on stderr what can be told before a run to go wrong, each sentence once."""
    for sentence in dict.fromkeys(sentences):
        print(f"robotics: warning: {sentence}", file=sys.stderr)


def print_outside(runs: "Iterable[Sequence[OutsideInput]]") -> list[dict[str, Any]]:
    """Print on stderr, one sentence a run, which learnt systems were asked outside their data; return every input."""
    from robotics.measures.outside import outside_sentence

    rows = []
    for found in runs:
        rows += [one.row() for one in found]
        if found:
            print(f"robotics: warning: {outside_sentence(found)}", file=sys.stderr)
    return rows


def print_run(
    run: "Run",
    page: Path | None,
    json: bool,
    outcome: Mapping[str, Any] | None = None,
    metrics: Mapping[str, "Measured"] = MappingProxyType({}),
    noise: Sequence[str] | None = None,
    first: Iterable[str] = (),
) -> None:
    """Print what was run and its metrics, and exit with 2 if robots were stopped.

    Args:
        run: The run.
        page: The file of a page that plays the run, if there is one.
        json: Whether one JSON object is printed instead of text.
        outcome: What a stress test says of the run.
        metrics: The user's own metrics, by name.
        noise: What was drawn at random, in words; None if that is not said.
        first: The metrics of the run's task, which come before the others where they were measured.
    """
    from robotics.measures.outside import outside
    from robotics.measures.registry import ALL_METRICS, measure_all

    found = measure_all(run, metrics)
    values = {name: found[name] for name in dict.fromkeys([*first, *found]) if name in found}
    left = print_outside([outside(run)])
    if json:
        print_json(
            {
                "scenario": run.scenario,
                "controller": run.controller,
                "level": run.level,
                "seeds": list(run.seeds),
                "metrics": {name: v[:, 0] if v.shape[1] == 1 else v for name, v in values.items()},
                "contacts": _contact_rows(run),
                "diverged": run.diverged,
                "outside": left,
                "versions": versions(),
            }
            | ({"outcome": outcome} if outcome is not None else {})
            | ({"player": str(page)} if page is not None else {})
        )
    else:
        print(_what_ran(run, noise))
        _print_metrics(values, {**ALL_METRICS, **metrics})
        _print_contacts(run)
        if outcome is not None:
            print(", ".join(f"{name} {outcome[name]}" for name in ("collisions", "deadlocks", "contacts", "arrived")))
        if page is not None:
            print(page)
    report_divergences(run.divergences())


def _what_ran(run: "Run", noise: Sequence[str] | None) -> str:
    """A sentence: the scenario, the controller, the seeds of which the numbers are means, and the noise."""
    first, last = run.seeds[0], run.seeds[-1]
    count = len(run.seeds)
    seeds = f"seed {first}" if count == 1 else f"means of seeds {first} {'and' if count == 2 else 'to'} {last}"
    drawn = "" if noise is None else f"; noise: {', '.join(noise) or 'none'}"
    return f"{run.scenario} under {run.controller}, {seeds}{drawn}"


def _print_metrics(values: Mapping[str, Any], about: Mapping[str, "Measured"]) -> None:
    """A line a metric, from its values (runs, robots): means over the seeds, a column a robot, under a header."""
    import numpy as np

    robots = max((found.shape[1] for found in values.values()), default=1)
    few = robots <= _COLUMNS
    if robots > 1:
        heads = [f"robot {i + 1}" for i in range(robots)] if few else ["least", "median", "largest"]
        of = "" if few else f"of {robots} robots"
        print(f"{of:28} {'  '.join(f'{head:>10}' for head in heads)}")
    for name, found in values.items():
        means = found.mean(axis=0)
        if not few:
            means = np.array([means.min(), np.median(means), means.max()])
        metric = about[name]
        print(f"{name:28} {'  '.join(f'{number_cell(v):>10}' for v in means)}  {metric.unit:8} {metric.title}")


def number_cell(value: float | None) -> str:
    """A number of SI units in a table; "-" where there is none."""
    return "-" if value is None or value != value else shown(float(value), span=1.0)


def _contact_rows(run: "Run") -> list[dict[str, Any]]:
    """Every contact of every seed, in JSON's types; robots and obstacles count from 1."""
    from robotics.measures.contacts import contacts

    rows = []
    for place, seed in enumerate(run.seeds):
        for c in contacts(run, place):
            names = {"seed": seed, "robot": c.robot + 1}
            names |= {"other": c.other + 1} if c.other is not None else {"obstacle": (c.obstacle or 0) + 1}
            rows.append(names | {"start_s": c.start, "end_s": c.end, "depth_m": c.depth, "x_m": c.x, "y_m": c.y})
    return rows


def _print_contacts(run: "Run") -> None:
    """Say which runs had a contact, and the first of each of the first few."""
    from robotics.measures.contacts import contact_sentences

    lines = contact_sentences(run)
    if not lines:
        return
    print(f"✕ contact in {len(lines)} of {len(run.seeds)} run{'s' * (len(run.seeds) > 1)}; {UNTIL_CONTACT[3:]}")
    for line in lines[:_SHOWN]:
        print(f"  {line}")
    if len(lines) > _SHOWN:
        print(f"  and {len(lines) - _SHOWN} more")


def report_divergences(lines: list[str]) -> None:
    """Print on stderr which robots were stopped, if any were, and exit with 2."""
    if lines:
        more = f" (and {len(lines) - 1} more)" if len(lines) > 1 else ""
        print(f"robotics: {lines[0]}{more}; what it did until then is kept", file=sys.stderr)
        raise typer.Exit(USAGE)
