"""The command line ``robotics``: list, run and compare.

Data goes to stdout, progress and messages to stderr. What a command needs is imported when it runs, so that
``--help`` is quick.
"""

import shlex
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fuzzy.errors import InputError
from fuzzy.progress import Begin, progress_bar
from fuzzy.terminal import INTERRUPTED, USAGE, application, print_json, run
from robotics.commands.animate import animate
from robotics.commands.certify import certify
from robotics.commands.dataset import dataset
from robotics.commands.learn import learn
from robotics.commands.stress import stress
from robotics.commands.sweep import sweep
from robotics.commands.team import team

if TYPE_CHECKING:
    import pandas as pd

    from robotics.comparison import Comparison
    from robotics.report.chapters import Judgement
    from robotics.report.claims import Claim

app = application("Simulate robots and compare their controllers, fuzzy and nonlinear, on the same terms.")

app.add_typer(dataset, name="dataset")
app.add_typer(stress, name="stress")
app.command()(learn)
app.command()(animate)
app.command()(certify)
app.command()(sweep)
app.command()(team)

_COLUMNS = 6  # robots that get a column each
_MOST_AGES = 100_000_000  # of messages that a saved run holds: 400 MB


class Suite(StrEnum):
    """What ``robotics compare`` runs without names."""

    thesis = "thesis"
    tracking = "tracking"
    formation = "formation"
    team = "team"


Json = Annotated[bool, typer.Option("--json", help="Print one JSON object instead of text.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="No progress bar.")]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return the exit code: 0 fine, 2 an error or a diverged controller, 130 Ctrl-C."""
    return run(app, (InputError,), "robotics", arguments)


def _version(wanted: bool) -> None:
    if wanted:
        print(" ".join(f"{name} {version}" for name, version in versions().items()))
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the versions and stop.")
    ] = False,
) -> None:
    """Simulate robots and compare their controllers, fuzzy and nonlinear, on the same terms.

    Example: robotics compare --seeds 20 --out out
    """


def versions() -> dict[str, str]:
    """The versions that a result depends on."""
    from importlib.metadata import version

    names = ("fuzzyfleet", "numpy", "numba", "scipy", "pandas", "matplotlib")
    return {name: version(name) for name in names} | {"python": ".".join(map(str, sys.version_info[:3]))}


@app.command("list")
def list_(json: Json = False) -> None:
    """The scenarios and controllers that come with the package.

    Example: robotics list
    """
    from robotics.catalogue import CATALOGUE, gains_of, make_controller
    from robotics.scenario import load_scenario, scenario_names

    scenarios = [load_scenario(name) for name in scenario_names()]
    gains = {name: gains_of(make_controller(name)) for name in CATALOGUE}
    if json:
        print_json(
            {
                "scenarios": [
                    {"name": s.name, "kind": s.kind, "title": s.title, "source": s.source} for s in scenarios
                ],
                "controllers": [
                    {"name": name, "title": preset.title, "note": preset.note, "gains": gains[name]}
                    for name, preset in CATALOGUE.items()
                ],
            }
        )
        return
    print("Scenarios (a name, or the path of a .toml file)")
    for s in scenarios:
        print(f"  {s.name:16} {s.title}")
    print("\nControllers (a name, or name:gain=value,gain=value)")
    for name, preset in CATALOGUE.items():
        print(f"  {name:16} {preset.title}: {preset.note}")
        print(
            " " * 19 + ", ".join(f"{k}={v:g}" if isinstance(v, float) else f"{k}={v}" for k, v in gains[name].items())
        )


@app.command("run")
def run_(
    scenario: Annotated[
        str,
        typer.Argument(
            help="A scenario's name, or a .toml file; crossing or obstacles: the random one of --seed.",
            show_default=False,
        ),
    ],
    controller: Annotated[
        str | None,
        typer.Option("--controller", "-c", help="name or name:gain=value,... Default: the scenario's own, or fuzzy."),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="The first seed.")] = 0,
    seeds: Annotated[int, typer.Option(min=1, help="How many seeds, from --seed on.")] = 1,
    plot: Annotated[Path | None, typer.Option(metavar="PICTURE", help="Draw the first seed: .png, .pdf, .svg.")] = None,
    save: Annotated[Path | None, typer.Option(metavar="FILE.npz", help="Save the run without loss.")] = None,
    table: Annotated[Path | None, typer.Option(metavar="FILE.csv", help="Save every sample as CSV.")] = None,
    events: Annotated[
        Path | None, typer.Option(metavar="FILE.csv", help="Save who avoided, yielded or timed out, and when.")
    ] = None,
    player: Annotated[
        bool, typer.Option("--animate", help="Write a page that plays the first seed: SCENARIO-seed-N.html.")
    ] = False,
    robots: Annotated[int | None, typer.Option(min=1, max=200, help="Of a crossing (3) or obstacles (1).")] = None,
    kind: Annotated[str | None, typer.Option("--class", help="Of a crossing: A or B; of obstacles: A, B or U.")] = None,
    loss: Annotated[float, typer.Option(min=0.0, max=1.0, help="Of these: share of messages lost.")] = 0.0,
    latency: Annotated[float, typer.Option(min=0.0, max=10.0, help="Of these: of the messages, s.")] = 0.0,
    freeze: Annotated[float, typer.Option(min=0.0, max=600.0, help="In a crossing: s one robot is held up.")] = 0.0,
    moving: Annotated[int, typer.Option(min=0, max=10, help="Of obstacles: discs that cross the lanes.")] = 0,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """One scenario under one controller: its figures of merit, and a picture if asked.

    "crossing" and "obstacles" repeat exactly what `robotics stress` made of a seed, with the options it had.
    Example: robotics run lyapunov-sine --controller lyapunov:ky=10,kpsi=5 --seed 3 --plot out.png
    """
    import numpy as np

    from fuzzy.table import write_frame
    from robotics.catalogue import make_controller
    from robotics.merits import measure_all, metrics_of
    from robotics.scenario import load_scenario
    from robotics.simulation import simulate

    random = scenario if scenario in ("crossing", "obstacles") else None
    if random is not None:
        from robotics.stress.single import ALIASES, STRESSES

        if seeds > 1:
            raise InputError(f"{random}: one seed at a time; `robotics stress {random}` runs many")
        controller = controller or STRESSES[random]
        law = make_controller(ALIASES[random].get(controller, controller))
    else:
        if robots is not None or kind is not None or loss or latency or freeze or moving:
            raise InputError(
                "--robots, --class, --loss and --latency belong to `robotics run crossing` and `obstacles`, --freeze "
                f"to the first, --moving to the second; {scenario} says in its file what it has"
            )
        setting = load_scenario(scenario)
        controller = controller or setting.controller or "fuzzy"
        law = make_controller(controller)
    if plot is not None:
        from fuzzy.drawing import check_picture

        check_picture(plot)
    for path, suffix in ((save, ".npz"), (table, ".csv"), (events, ".csv")):
        if path is not None and path.suffix != suffix:
            raise InputError(f"{path}: the file's name must end in {suffix}")
    outcome: dict[str, Any] | None = None
    with progress_bar(quiet) as begin:
        if random is not None:
            from robotics.stress.single import single_run

            links = save is not None or player
            disturbed = {"loss": loss, "latency": latency, "freeze": freeze}
            result, about, team_kind = single_run(
                random, law, seed, robots, kind, disturbed, controller, links, begin, moving=moving
            )
            outcome = about.summary()
            name, count = result.scenario, result.samples.shape[3]
        else:
            advance = begin(f"{setting.name}: {controller}", setting.ticks + 1)
            # How old each message is, for moving pictures: as many numbers as robots squared.
            links = (save is not None or player) and setting.kind == "team"
            if links and seeds * len(setting.robots) ** 2 * setting.ticks > _MOST_AGES:
                links = False
                print(
                    "robotics: too many robots and seeds to save the age of every message; the rest is", file=sys.stderr
                )
            result = simulate(setting, law, range(seed, seed + seeds), name=controller, links=links, progress=advance)
            name, count, team_kind = setting.name, len(setting.robots), setting.kind
    if save is not None:
        result.save(save)
    if table is not None:
        write_frame(result.frame(), table)
    if events is not None:
        from robotics.events import events_of

        write_frame(events_of(result), events)
    if plot is not None:
        from fuzzy.drawing import save_figure
        from robotics.figures.saving import plot_run

        save_figure(plot_run(result), plot)
    page = Path(f"{name}-seed-{seed}.html")
    if player:
        from robotics.playback.player import write_player

        write_player(result, page)
    values, meanings = measure_all(result, team_kind), metrics_of(team_kind)
    if json:
        print_json(
            {
                "scenario": name,
                "controller": controller,
                "level": law.level,
                "seeds": list(result.seeds),
                "metrics": {name: v[:, 0] if v.shape[1] == 1 else v for name, v in values.items()},
                "diverged": result.diverged,
                "versions": versions(),
            }
            | ({"outcome": outcome} if outcome is not None else {})
            | ({"player": str(page)} if player else {})
        )
    else:
        for name, metric in meanings.items():
            shown = values[name].mean(axis=0)
            if count > _COLUMNS:
                shown = np.array([shown.min(), np.median(shown), shown.max()])
            print(f"{name:28} {'  '.join(f'{v:10.4g}' for v in shown)}  {metric.unit:8} {metric.title}")
        if seeds > 1 or count > 1:
            columns = "; one column a robot" if count <= _COLUMNS else f"; least, median and largest of {count} robots"
            print(f"(mean over {seeds} seeds{columns if count > 1 else ''})")
        if outcome is not None:
            print(", ".join(f"{name} {outcome[name]}" for name in ("collisions", "deadlocks", "contacts", "arrived")))
        if player:
            print(page)
    _report_divergences(result.divergences())


@app.command()
def compare(
    scenarios: Annotated[
        list[str] | None, typer.Argument(help="Names or .toml files of one kind; by default a suite.")
    ] = None,
    suite: Annotated[
        Suite,
        typer.Option(help="Without names: thesis (everything), or only the tracking, formation or team scenarios."),
    ] = Suite.thesis,
    controllers: Annotated[
        str | None, typer.Option(help="Comma-separated: fuzzy,csm:k=0.3,esm. Default: those of the scenarios' kind.")
    ] = None,
    seeds: Annotated[int, typer.Option(min=1, help="How many seeds, from --seed on.")] = 20,
    seed: Annotated[int, typer.Option(min=0, help="The first seed.")] = 0,
    out: Annotated[Path, typer.Option(metavar="FOLDER", help="Where tables and report.html go.")] = Path("out"),
    claims: Annotated[
        bool | None,
        typer.Option("--claims/--no-claims", help="Judge the thesis's claims too. Default: in the suite thesis."),
    ] = None,
    report: Annotated[bool, typer.Option("--report/--no-report", help="Draw figures, write report.html.")] = True,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Every controller on every scenario with the same seeds: tables, figures and a report.

    Writes results.csv (one row a seed), summary.csv (mean and 95 % interval), claims.csv, configuration.json,
    figures/ and report.html. The suite thesis also learns formation networks, drives teams, also among obstacles, and
    judges every claim.
    Example: robotics compare lyapunov-sine --controllers fuzzy,esm:k=0.5 --seeds 5 --out out
    """
    import pandas as pd
    from threadpoolctl import threadpool_limits

    from fuzzy.table import write_frame
    from robotics.catalogue import make_controller
    from robotics.comparison import DEFAULT_CONTROLLERS, summarise
    from robotics.comparison import compare as compare_all
    from robotics.scenario import load_scenario, scenario_names

    kind = "tracking" if suite is Suite.thesis else suite.value
    settings = [load_scenario(name) for name in scenarios or scenario_names(kind)]
    _expect_distinct([s.name for s in settings], "scenario")
    kinds = {s.kind for s in settings}
    if len(kinds) > 1:
        raise InputError(f"scenarios of one kind can be compared; these are {', '.join(sorted(kinds))}")
    laws = split_controllers(controllers) if controllers is not None else list(DEFAULT_CONTROLLERS[settings[0].kind])
    _expect_distinct(laws, "controller")
    for law in laws:
        make_controller(law)
    judged = claims if claims is not None else not scenarios and controllers is None and suite is Suite.thesis
    out.mkdir(parents=True, exist_ok=True)
    results = out / "results.csv"
    _write_configuration(out, [s.name for s in settings], laws, seeds, seed)
    wanted, done = sum(len(s.robots) for s in settings) * len(laws) * seeds, 0

    def keep(rows: "pd.DataFrame") -> None:
        nonlocal done
        write_frame(rows, results)
        done = len(rows)

    judgement = None
    try:
        # Matrices here are small: with more threads they wait for each other, and last digits depend on the machine.
        with (
            threadpool_limits(1, "blas"),
            progress_bar(quiet) as begin,
            _judging(judged, begin, out, seed, report) as wait,
        ):
            advance = begin("simulating", sum(s.ticks + 1 for s in settings) * len(laws))
            comparison = compare_all(settings, laws, range(seed, seed + seeds), advance=advance, finished=keep)
            summary = summarise(comparison.table)
            write_frame(summary, out / "summary.csv")
            if report:
                from robotics.report.page import draw_sections, figure_count

                sections = draw_sections(comparison, begin("drawing", figure_count(comparison)))
            judgement = wait()
            if judgement is not None:
                write_frame(pd.DataFrame([vars(c) for c in judgement.all_claims]), out / "claims.csv")
            if report:
                from robotics.report.page import write_report

                command = ["robotics", "compare", *(scenarios or []), f"--seeds={seeds}", f"--seed={seed}"]
                if suite is not Suite.thesis:
                    command.append(f"--suite={suite.value}")
                if controllers is not None:
                    command.append(f"--controllers={','.join(laws)}")
                claimed, chapters = (judgement.claims, judgement.chapters) if judgement else ([], [])
                said = shlex.join(command)
                write_report(comparison, claimed, out, chapters=chapters, command=said, sections=sections)
    except KeyboardInterrupt:
        print(f"robotics: interrupted; {done} of {wanted} rows are in {results}", file=sys.stderr)
        raise typer.Exit(INTERRUPTED) from None
    judgements = judgement.all_claims if judgement else []
    if json:
        print_json(
            {
                "summary": summary.to_dict(orient="records"),
                "claims": [vars(c) for c in judgements],
                "diverged": comparison.divergences,
                "files": sorted(str(p.relative_to(out)) for p in out.rglob("*") if p.is_file()),
                "versions": versions(),
            }
        )
    else:
        _print_summary(comparison, summary, judgements)
        print(f"\n{out / 'report.html' if report else results}")
    _report_divergences(comparison.divergences)


def split_controllers(text: str) -> list[str]:
    """The specifications in a comma-separated list; a part with "=" alone is one more gain of the one before.

    >>> split_controllers("fuzzy,csm:k=0.3,realisation=velocity,esm")
    ['fuzzy', 'csm:k=0.3,realisation=velocity', 'esm']
    """
    result: list[str] = []
    for part in (p.strip() for p in text.split(",")):
        if "=" in part and ":" not in part and result:
            result[-1] += f",{part}"
        elif part:
            result.append(part)
    if not result:
        raise InputError("--controllers: at least one name is needed; `robotics list` shows them")
    return result


def _expect_distinct(names: Sequence[str], what: str) -> None:
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"{what} {name!r} is given twice")


@contextmanager
def _judging(
    wanted: bool, begin: Begin, out: Path, seed: int, draw: bool
) -> "Iterator[Callable[[], Judgement | None]]":
    if not wanted:
        yield lambda: None
        return
    from robotics.report.chapters import judging

    with judging(begin, out, seed, draw) as wait:
        yield wait


def _write_configuration(out: Path, scenarios: list[str], laws: list[str], seeds: int, seed: int) -> None:
    import json

    from fuzzy.atomic import replacing
    from robotics.catalogue import gains_of, make_controller

    configuration: dict[str, Any] = {
        "scenarios": scenarios,
        "controllers": {law: gains_of(make_controller(law)) for law in laws},
        "seeds": list(range(seed, seed + seeds)),
        "versions": versions(),
    }
    with replacing(out / "configuration.json") as temporary:
        temporary.write_text(json.dumps(configuration, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")


def _print_summary(comparison: "Comparison", summary: "pd.DataFrame", verdicts: "list[Claim]") -> None:
    from rich.console import Console
    from rich.table import Table

    from robotics.comparison import label
    from robotics.merits import metrics_of

    shown = {
        "mean_error_norm": "error norm",
        "mean_speed_error_mps": "speed error",
        "rms_cross_track_m": "RMS cross-track",
        "settling_time_s": "settling",
        "control_effort": "effort",
        "torque_variation_nmps": "torque variation",
    }
    kind = comparison.scenarios[0].kind
    if kind == "team":
        shown = {
            "arrival_time_s": "arrival",
            "arrival_spread_s": "arrival spread",
            "max_progress_gap": "largest s_i − s_j",
            "rms_cross_track_m": "RMS cross-track",
            "min_distance_m": "least distance",
        }
    elif kind == "formation":
        shown = {
            "alignment_time_s": "alignment",
            "final_spread_m": "spread at the end",
            "max_lateral_error_m": "largest lateral",
        }
    # A pipe has no width of its own: wide enough that no number is cut.
    console = Console() if sys.stdout.isatty() else Console(width=120)
    for scenario in comparison.scenarios:
        table = Table(title=f"{scenario.name}: {scenario.title}", title_justify="left", caption_justify="left")
        table.add_column("controller")
        for metric, title in shown.items():
            table.add_column(f"{title}\n[{metrics_of(kind)[metric].unit}]".replace("[", "\\["), justify="right")
        mine = summary[summary["scenario"] == scenario.name]
        for law in comparison.controllers:
            rows = {row["metric"]: row for row in mine[mine["controller"] == law].to_dict(orient="records")}
            cells = []
            for metric in shown:
                mean = rows[metric]["mean"]
                half = rows[metric]["high"] - mean
                cells.append("never" if mean == float("inf") else f"{mean:.4f}" + (f" ±{half:.4f}" if half > 0 else ""))
            table.add_row(label(law), *cells)
        console.print(table)
    print(f"mean over {len(comparison.seeds)} seeds ± half the 95 % confidence interval")
    for claim in verdicts:
        print(f"\n{claim.name} ({claim.source}): {claim.verdict.upper()}\n  {claim.measured}")


def _report_divergences(lines: list[str]) -> None:
    if lines:
        more = f" (and {len(lines) - 1} more)" if len(lines) > 1 else ""
        print(f"robotics: {lines[0]}{more}; what it did until then is kept", file=sys.stderr)
        raise typer.Exit(USAGE)
