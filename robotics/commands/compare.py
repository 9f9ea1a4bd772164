"""The command ``robotics compare``: every controller on every scenario, into tables, pictures and a report."""

import shlex
import sys
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from fuzzy.entrypoints import entry_points
from fuzzy.errors import InputError
from fuzzy.files.atomic import check_folder
from fuzzy.naming import expected
from fuzzy.shell.options import Json, Quiet, argument, option
from fuzzy.shell.progress import progress_bar
from fuzzy.words import split_list
from robotics.commands.completion import controller_list, scenarios, suites
from robotics.commands.shared import Fresh, Laws, Metric, Report, print_forewarnings, report_divergences
from robotics.commands.study_printing import already_there, print_study, rows_kept

if TYPE_CHECKING:
    from robotics.show.report.study import MakeChapters

SUITE_GROUP = "fuzzyfleet.suites"  # entry points: by the name of a packaged study, what makes its chapters
FRONT_GROUP = "fuzzyfleet.fronts"  # entry points: what opens a report
KINDS = ("tracking", "formation", "team")  # of scenarios


def compare(
    scenarios: Annotated[
        list[str] | None, argument("Names or .toml files, of one kind. Default: a suite.", autocompletion=scenarios)
    ] = None,
    suite: Annotated[
        str | None,
        option(
            "Without names: all scenarios of a kind (tracking, formation, team), or a study of a plug-in with its "
            "claims. Default: such a study.",
            autocompletion=suites,
        ),
    ] = None,
    controllers: Annotated[
        str | None,
        option(
            "Comma-separated: fuzzy,csm:k=0.3,esm. Default: those of the scenarios' kind.",
            *("--controllers", "-c", "A,B"),
            autocompletion=controller_list,
        ),
    ] = None,
    law: Laws = None,
    metric: Metric = None,
    seeds: Annotated[int, option("Number of seeds, from --seed on.", min=1)] = 20,
    seed: Annotated[int, option("The first seed.", min=0)] = 0,
    out: Annotated[Path, option("Where tables and report.html go.", "--out", "-o", "FOLDER")] = Path("out"),
    claims: Annotated[
        bool | None, option("Judge a plug-in's claims too. Default: in its suite.", "--claims/--no-claims")
    ] = None,
    thorough: Annotated[
        bool, option("Judge claims by 100 seeds, and rates by 1000 runs, in place of 20 and 200.")
    ] = False,
    save_runs: Annotated[bool, option("Save the runs that decide claims, in FOLDER/runs.")] = False,
    arena: Annotated[
        bool | None,
        option(
            "Open the report with laws tuned alike, as `robotics arena demo`. Default: in a plug-in's suite.",
            "--arena/--no-arena",
        ),
    ] = None,
    report: Report = True,
    fresh: Fresh = False,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Run every controller on every scenario with the same seeds, and write tables, figures and a report.

    Writes results.csv (one row a seed), summary.csv (mean and 95 % interval), configuration.json, figures/ and
    report.html. After a stop the same command goes on. The suite of a plug-in also makes that study's experiments,
    judges its claims and writes claims.csv.

    \b
    Example:
      robotics compare lyapunov-sine --controllers fuzzy,esm:k=0.5 --seeds 5 --out out
    """
    from robotics.laws.catalogue import make_controller
    from robotics.show.report.plan import load_study
    from robotics.show.report.study import run_study, with_seeds, write_study
    from robotics.simulation.scenario.reading import load_scenario, scenario_names
    from robotics.studies.comparison import DEFAULT_CONTROLLERS, check_comparison
    from robotics.studies.forewarnings import forewarnings

    # A list with commas is read as those of laws are, but for a file whose name has one
    lists = (([] if Path(each).exists() else split_list(each)) or [each] for each in scenarios or [])
    scenarios = [part for parts in lists for part in parts]
    own = bool(scenarios) or controllers is not None or bool(law) or bool(metric)
    packaged = {point.name: point for point in entry_points(group=SUITE_GROUP)}
    default = next(iter(packaged), KINDS[0])
    if suite is None and not own and not packaged:
        print("robotics: no installed plug-in brings a study: the tracking scenarios are compared", file=sys.stderr)
    suite = suite or default
    if suite not in {*KINDS, *packaged}:
        raise InputError(expected(suite, [*packaged, *KINDS], "suite"))
    plan = with_seeds(load_study(suite), seeds, seed) if not own and suite in packaged else None
    if plan is not None:
        settings, laws = list(plan.settings), list(plan.controllers)
    else:
        kind = suite if suite in KINDS else KINDS[0]
        settings = [load_scenario(name) for name in scenarios or scenario_names(kind)]
        usual = DEFAULT_CONTROLLERS[settings[0].kind]
        laws = [*(split_controllers(controllers) if controllers is not None else usual), *(law or [])]
    judged = claims if claims is not None else plan is not None
    command = ["robotics", "compare", *scenarios, f"--seeds={seeds}", f"--seed={seed}"]
    if suite != default:
        command.append(f"--suite={suite}")
    if controllers is not None or law:
        command.append(f"--controllers={','.join(laws)}")
    command += [f"--metric={name}" for name in metric or []]
    check_folder(out)
    check_comparison(settings, laws, metric or ())
    made = {name: make_controller(name) for name in laws}
    print_forewarnings(s for x in settings for name in laws for s in forewarnings(x.setting, made[name], name))
    wanted = sum(len(s.robots) for s in settings) * len(laws) * seeds
    with rows_kept(wanted, out / "results.csv") as kept, progress_bar(quiet) as begin:
        chapters = _chapters(packaged, suite, thorough, save_runs) if judged else None
        opened = plan is not None if arena is None else arena
        front = next((point.load() for point in entry_points(group=FRONT_GROUP) if opened), None)
        told: Any = {"front": front, "begin": begin, "report": report, "command": shlex.join(command), "kept": kept}
        told |= {"fresh": fresh, "resumed": already_there(out, quiet)}
        if judged and plan is not None:
            study = run_study(plan, out, chapters=chapters, **told)
        else:
            every = range(seed, seed + seeds)
            study = write_study(out, settings, laws, every, metrics=metric or (), chapters=chapters, **told)
    told_as_json = ("summary", "claims", "contacts", "diverged", "outside", "files", "versions")
    print_study(study, told_as_json if json else ())
    report_divergences(study.divergences)


def split_controllers(text: str) -> list[str]:
    """The specifications in a comma-separated list; a part such as "k=0.3" is one more gain of the one before.

    >>> split_controllers("fuzzy,csm:k=0.3,realisation=velocity,esm")
    ['fuzzy', 'csm:k=0.3,realisation=velocity', 'esm']
    """
    from robotics.laws.specification import starts_gain

    result: list[str] = []
    for part in (p.strip() for p in text.split(",")):
        if starts_gain(part) and result:
            result[-1] += f",{part}"
        elif part:
            result.append(part)
    if not result:
        raise InputError("--controllers: at least one name is needed; `robotics list` shows them")
    return result


def _chapters(packaged: dict[str, EntryPoint], suite: str, thorough: bool, save_runs: bool) -> "MakeChapters":
    """What makes the chapters of a plug-in's study: of the suite, or the first. Raises InputError if there is none."""
    from robotics.studies.executors import import_ahead

    if not packaged:
        raise InputError("--claims: no installed plug-in brings a study with claims")
    point = packaged.get(suite) or next(iter(packaged.values()))
    import_ahead([point.module])  # this takes seconds, in which the same is done here
    made: MakeChapters = point.load()(thorough, save_runs)
    return made
