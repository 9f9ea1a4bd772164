"""The command ``robotics sweep``: scenario fields and controller gains × controllers × seeds, into one table."""

from contextlib import suppress
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import Annotated

from fuzzy.errors import InputError
from fuzzy.files.atomic import check_folder
from fuzzy.shell.interrupts import interrupted
from fuzzy.shell.options import Json, Quiet, argument, option
from fuzzy.shell.progress import progress_bar
from fuzzy.shell.terminal import print_json
from fuzzy.words import counted
from robotics.commands.completion import sweeps
from robotics.commands.shared import Dask, Laws, Metric, print_forewarnings
from robotics.commands.study_printing import already_there
from robotics.studies.versions import versions


def sweep(
    spec: Annotated[str, argument("A sweep's file; or a name: lyapunov-gains.", "SPEC.toml", autocompletion=sweeps)],
    law: Laws = None,
    metric: Metric = None,
    workers: Annotated[
        int | None, option("Number of processes of this machine. Default: only this one.", min=1)
    ] = None,
    dask: Dask = None,
    out: Annotated[Path | None, option("Folder of the results. Default: out/NAME", "--out", "-o", "FOLDER")] = None,
    fresh: Annotated[bool, option("Discard what FOLDER holds of a sweep.")] = False,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Sweep parameters: fields of a scenario and gains of controllers, as a grid or at random, times seeds.

    Writes results.parquet, one row for each run and robot, chunk by chunk. After a stop the same command goes on from
    there.

    \b
    Example:
      robotics new sweep -o mine.toml
      robotics sweep mine.toml --out out/mine

    \b
    A sweep's file:
      scenario = "lyapunov-sine"         # a name, or a path relative to the file
      controllers = ["lyapunov", "fuzzy:look_ahead=0.5", "mylaw.py:MyLaw"]
      metrics = ["mymetric.py:comfort"]  # of your own, besides
      seeds = 20                         # first_seed = 0
      method = "latin-hypercube"         # samples = 50, seed = 0; "random"; "grid"
      chunk = 100                        # runs that are written at a time
      [scenario_fields]                  # keys of the scenario's file
      "robots.*.timing.x_rate" = { low = 0.1, high = 0.3 }
      latency = [0.0, 0.1]               # or { low = 0, high = 0.2, step = 0.05 }
      [controller_parameters]            # gains; for a grid also count = 5
      ky = { low = 1, high = 40, scale = "log" }
    """
    from robotics.laws.catalogue import as_law
    from robotics.show.report.plan import load_sweep
    from robotics.show.report.study import run_table
    from robotics.studies.executors import workers_at
    from robotics.studies.forewarnings import forewarnings
    from robotics.studies.keptcomparison import PACKAGES

    plan = load_sweep(spec)
    plan = replace(plan, controllers=(*plan.controllers, *(law or ())), metrics=(*plan.metrics, *(metric or ())))
    for case in chain(*plan.cases):
        with suppress(InputError):  # what is wrong with a point is said where it is run
            first = case.passes(0, plan.row, {})[0].driven()[0].setting  # the others differ in some fields only
            print_forewarnings(s for name, c in case.laws.items() for s in forewarnings(first, as_law(c), name))
    print_forewarnings(f"{on}: {line}" for group in plan.groups for on, said in group.skipped.items() for line in said)
    folder = out if out is not None else Path("out") / plan.name
    check_folder(folder)

    def stopped(done: int, chunks: int) -> None:
        interrupted(f"{done} of {chunks} chunks are in {folder}; the same command goes on from there")

    preload = ["pyarrow", "robotics.studies.keptcomparison"]
    resumed = already_there(folder, quiet, "chunks")
    with workers_at(workers, dask, preload) as crew, progress_bar(quiet) as begin:
        done = run_table(plan, folder, crew, fresh=fresh, begin=begin, resumed=resumed, stopped=stopped)
    if json:
        print_json(
            {
                "results": str(done.results),
                "rows": done.counts.rows,
                "points": len(plan.points),
                "controllers": list(plan.laws),
                "seeds": list(plan.row),
                "runs": plan.runs,
                "diverged": done.counts.diverged,
                "with_contact": done.counts.contacts,
                "chunks": done.chunks,
                "computed": done.computed,
                "versions": versions(*PACKAGES),
            }
        )
        return
    counts = ((len(plan.points), "point"), (len(plan.laws), "controller"), (plan.seeds, "seed"))
    shown = " × ".join(counted(*each) for each in counts)
    touched = f"✕ contact in {done.counts.contacts} of {plan.runs} runs; " if done.counts.contacts else ""
    print(
        f"{done.results}: {done.counts.rows} rows, {shown}; {done.counts.diverged} rows of robots that diverged; "
        f"{touched}{done.computed} of {done.chunks} chunks computed now"
    )
