"""The command ``robotics compare``: every controller on every scenario, into tables, pictures and a report."""

import shlex
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from fuzzy.errors import InputError
from fuzzy.files.atomic import check_folder
from fuzzy.shell.options import Json, Quiet, argument, option
from fuzzy.shell.progress import progress_bar
from fuzzy.shell.terminal import print_json
from robotics.commands.completion import controller_list, scenarios
from robotics.commands.shared import Fresh, Laws, Metric, print_forewarnings, print_outside, report_divergences
from robotics.commands.study_printing import already_there, contact_rows, print_comparisons, print_verdicts, rows_kept
from robotics.studies.versions import versions

if TYPE_CHECKING:
    from fuzzy.shell.progress import Begin
    from robotics.show.report.chapter import Front
    from robotics.show.report.study import MakeChapters

Suite = Literal["thesis", "tracking", "formation", "team"]  # scenarios where none are named


def compare(
    scenarios: Annotated[
        list[str] | None, argument("Names or .toml files, of one kind. Default: a suite.", autocompletion=scenarios)
    ] = None,
    suite: Annotated[
        Suite,
        option("Without names. thesis: the tracking scenarios and all claims of the thesis; or those of one kind."),
    ] = "thesis",
    controllers: Annotated[
        str | None,
        option(
            "Comma-separated: fuzzy,csm:k=0.3,esm. Default: those of the scenarios' kind.",
            autocompletion=controller_list,
        ),
    ] = None,
    law: Laws = None,
    metric: Metric = None,
    seeds: Annotated[int, option("Number of seeds, from --seed on.", min=1)] = 20,
    seed: Annotated[int, option("The first seed.", min=0)] = 0,
    out: Annotated[Path, option("Where tables and report.html go.", "FOLDER")] = Path("out"),
    claims: Annotated[
        bool | None, option("Judge the thesis's claims too. Default: in the suite thesis.", "--claims/--no-claims")
    ] = None,
    thorough: Annotated[
        bool, option("Judge claims by 100 seeds, and rates by 1000 runs, in place of 20 and 200.")
    ] = False,
    save_runs: Annotated[bool, option("Save the runs that claims are judged by, in FOLDER/runs.")] = False,
    arena: Annotated[
        bool | None,
        option(
            "Open the report with laws tuned alike, as `robotics arena demo`. Default: in the suite thesis.",
            "--arena/--no-arena",
        ),
    ] = None,
    report: Annotated[bool, option("Draw figures and write report.html.", "--report/--no-report")] = True,
    fresh: Fresh = False,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Run every controller on every scenario with the same seeds, and write tables, figures and a report.

    Writes results.csv (one row a seed), summary.csv (mean and 95 % interval), configuration.json, figures/ and
    report.html. After a stop the same command goes on. The suite thesis also learns formation networks, drives teams,
    also among obstacles, judges every claim of the thesis and writes claims.csv.

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

    own = bool(scenarios) or controllers is not None or bool(law) or bool(metric)
    thesis = with_seeds(load_study("thesis"), seeds, seed) if not own and suite == "thesis" else None
    if thesis is not None:
        settings, laws = list(thesis.settings), list(thesis.controllers)
    else:
        kind = "tracking" if suite == "thesis" else suite
        settings = [load_scenario(name) for name in scenarios or scenario_names(kind)]
        default = DEFAULT_CONTROLLERS[settings[0].kind]
        laws = [*(split_controllers(controllers) if controllers is not None else default), *(law or [])]
    judged = claims if claims is not None else thesis is not None
    command = ["robotics", "compare", *(scenarios or []), f"--seeds={seeds}", f"--seed={seed}"]
    if suite != "thesis":
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
        chapters = _thesis_chapters(thorough, save_runs) if judged else None
        front = _small_arena if (thesis is not None if arena is None else arena) else None
        told: Any = {"front": front, "begin": begin, "report": report, "command": shlex.join(command), "kept": kept}
        told |= {"fresh": fresh, "resumed": already_there(out, quiet)}
        if judged and thesis is not None:
            study = run_study(thesis, out, chapters=chapters, **told)
        else:
            every = range(seed, seed + seeds)
            study = write_study(out, settings, laws, every, metrics=metric or (), chapters=chapters, **told)
    left = print_outside(note.outside for each in study.comparisons for note in each.notes.values())
    if json:
        print_json(
            {
                "summary": study.summary.to_dict(orient="records"),
                "claims": [claim.row() for claim in study.claims],
                "contacts": contact_rows(study),
                "diverged": study.divergences,
                "outside": left,
                "files": study.files,
                "versions": versions(),
            }
        )
    else:
        print_comparisons(study)
        print_verdicts(study)
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


def _small_arena(begin: "Begin", folder: Path) -> "Front":
    from robotics.show.report.arena import small_arena

    return small_arena(begin, folder)


def _thesis_chapters(thorough: bool, save_runs: bool) -> "MakeChapters":
    from robotics.studies.executors import import_ahead

    import_ahead(["robotics.plugins.thesis.chapters"])  # this takes seconds, in which the same is done here
    from robotics.plugins.thesis.chapters import judging
    from robotics.plugins.thesis.experiment import THOROUGH, USUAL

    return partial(judging, effort=THOROUGH if thorough else USUAL, save_runs=save_runs)
