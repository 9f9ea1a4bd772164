"""The command ``robotics compare``."""

import shlex
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fuzzy.errors import InputError
from fuzzy.shell.progress import Begin, progress_bar
from fuzzy.shell.terminal import INTERRUPTED, print_json
from robotics.commands.shared import Json, Quiet, report_divergences, versions

if TYPE_CHECKING:
    import pandas as pd

    from robotics.experiments.comparison import Comparison
    from robotics.report.chapter import Claim
    from robotics.thesis.chapters import Judgement


class Suite(StrEnum):
    """What ``robotics compare`` runs without names."""

    thesis = "thesis"
    tracking = "tracking"
    formation = "formation"
    team = "team"


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

    from fuzzy.files.table import write_frame
    from robotics.experiments.comparison import DEFAULT_CONTROLLERS, summarise
    from robotics.experiments.comparison import compare as compare_all
    from robotics.laws.catalogue import make_controller
    from robotics.scenario.reading import load_scenario, scenario_names

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
    report_divergences(comparison.divergences)


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
    from robotics.thesis.chapters import judging

    with judging(begin, out, seed, draw) as wait:
        yield wait


def _write_configuration(out: Path, scenarios: list[str], laws: list[str], seeds: int, seed: int) -> None:
    import json

    from fuzzy.files.atomic import replacing
    from robotics.laws.catalogue import gains_of, make_controller

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

    from robotics.laws.catalogue import label
    from robotics.measures.registry import metrics_of

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
