"""The command ``robotics study``: scenarios × controllers × seeds with claims of one's own, from a file to a report."""

import shlex
import sys
from pathlib import Path
from typing import Annotated, Any

from fuzzy.errors import InputError
from fuzzy.files.atomic import check_folder
from fuzzy.shell.options import Json, Quiet, argument, option, renamed_options
from fuzzy.shell.progress import progress_bar
from robotics.commands.completion import studies
from robotics.commands.shared import Dask, Fresh, Report, print_forewarnings
from robotics.commands.study_printing import already_there, print_study, rows_kept
from robotics.commands.sweep import sweep


@renamed_options(jobs="--workers")
def study(
    name: Annotated[
        str, argument("A study's file; or the name of a packaged one.", "STUDY.toml", autocompletion=studies)
    ],
    out: Annotated[
        Path | None, option("Folder of the results. Default: the file's key out, or out/NAME", "--out", "-o", "FOLDER")
    ] = None,
    seeds: Annotated[int | None, option("Number of seeds. Default: the file's; a verdict needs 20.", min=1)] = None,
    workers: Annotated[
        int, option("Number of processes that simulate; the numbers do not depend on it.", min=1, max=1000)
    ] = 1,
    dask: Dask = None,
    report: Report = True,
    fresh: Fresh = False,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Run a study: scenarios × controllers × seeds, claims judged, a report with your title. The file says which.

    Writes results.csv, columns.csv, summary.csv, claims.csv, evidence.csv, configuration.json, figures/ and
    report.html. The exit code is 0 for all verdicts, and 2 for a file that cannot be used. After a stop the
    same command goes on.

    \b
    Example:
      robotics new study -o study.toml
      robotics study study.toml --no-report

    \b
    A study's file; paths in it are relative to it:
      title = "Two laws on my paths"      # author, text
      scenarios = ["sine.toml", "lyapunov-circle"]
      controllers = ["mylaw.py:MyLaw", "mine.fis", "lyapunov"]
      names = ["mine", "rules", "rival"]  # optional
      seeds = 20                          # first_seed = 0
      metrics = ["mylaw.py:swerve"]       # optional: your own, or packaged ones to put in front
      questions = ["leads", "mine.py:clearance"]  # optional: a function from the table of all runs to an Answer
      [conditions]                        # optional: every scenario under each
      calm = {}
      noisy = { sensing.position_noise = 0.01 }
      [[axes]]                            # optional: every scenario at every point
      key = "latency"                     # or gain = "ky"
      values = [0.0, 0.1]                 # or { low = 0, high = 0.2, step = 0.05 }
      [tune]                              # optional: tuned first, "mine (tuned)" takes part beside "mine"
      evaluations = 300                   # space = "my-tuning.toml"
      [[claims]]
      name = "Mine is more precise"
      metric = "rms_cross_track_m"        # on = "sine", robot = 1, mean = true
      of = "mine"
      against = "rival"
      less = true                         # more, no_worse_by = 0.01, below = 0.05, above
      margin_percent = 10                 # or margin = 0.002
    """
    from robotics.laws.catalogue import as_law
    from robotics.measures.evidence import FEWEST_RUNS
    from robotics.show.report.plan import load_study
    from robotics.show.report.planfile import note_on, plan_kind
    from robotics.show.report.study import default_folder, run_study, with_seeds
    from robotics.studies.forewarnings import forewarnings

    if (kind := plan_kind(name)) is not None and kind.new_form:
        note, run = note_on(kind, name), sweep if kind.name == "sweep" else kind.run
        if run is None:
            raise InputError(f"{note}; or robotics tune LAW SCENARIO --space {name}")
        print(f"robotics: note: {note}", file=sys.stderr)
        common: Any = {"dask": dask, "out": out, "fresh": fresh, "json": json, "quiet": quiet}
        count = workers if workers > 1 else None
        run(name, workers=count, **common)
        return
    plan = with_seeds(load_study(name), seeds)
    folder = out if out is not None else default_folder(plan)
    check_folder(folder)
    for group in plan.groups:
        laws = {called: as_law(law) for called, law in group.laws.items()}
        for scenario in group.scenarios:
            print_forewarnings(s for n, law in laws.items() for s in forewarnings(scenario.setting, law, n))
        print_forewarnings(f"{on}: {line}" for on, lines in group.skipped.items() for line in lines)
    if plan.claims and plan.seeds < FEWEST_RUNS:
        print_forewarnings([f"a verdict needs {FEWEST_RUNS} seeds; with {plan.seeds} the claims cannot be told"])
    command = ["robotics", "study", name, f"--seeds={plan.seeds}"]

    with rows_kept(plan.rows, folder / "results.csv") as kept, progress_bar(quiet) as begin:
        made = run_study(
            plan,
            folder,
            jobs=workers,
            dask=dask,
            report=report,
            begin=begin,
            command=shlex.join(command),
            kept=kept,
            fresh=fresh,
            resumed=already_there(folder, quiet),
        )
    told_as_json = ("title", "claims", "evidence", "summary", "contacts", "diverged", "outside", "skipped", "files")
    print_study(made, (*told_as_json, "versions") if json else (), plan.title or plan.name)
    if not json:
        print_forewarnings(made.divergences[:5])
