"""The command ``robotics sweep``: scenario fields and controller gains × controllers × seeds, into one table."""

import sys
from contextlib import suppress
from pathlib import Path
from typing import Annotated

from fuzzy.errors import InputError
from fuzzy.files.atomic import check_folder
from fuzzy.shell.interrupts import interrupted
from fuzzy.shell.options import Json, Quiet, argument, option
from fuzzy.shell.progress import progress_bar
from fuzzy.shell.terminal import print_json
from robotics.commands.completion import sweeps
from robotics.commands.shared import Dask, Laws, Metric, print_forewarnings
from robotics.studies.versions import versions


def sweep(
    spec: Annotated[str, argument("A sweep's file; or a name: lyapunov-gains.", "SPEC.toml", autocompletion=sweeps)],
    law: Laws = None,
    metric: Metric = None,
    workers: Annotated[
        int | None, option("Number of processes of this machine. Default: only this one.", min=1)
    ] = None,
    dask: Dask = None,
    out: Annotated[Path | None, option("Folder of the results. Default: out/NAME", "FOLDER")] = None,
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
    from robotics.laws.catalogue import make_controller
    from robotics.studies.executors import workers_at
    from robotics.studies.forewarnings import forewarnings
    from robotics.studies.sweeps.plan import PACKAGES, controller_at, plan_sweep, scenario_at
    from robotics.studies.sweeps.reading import load_sweep, with_own
    from robotics.studies.sweeps.running import landed_chunks, run_sweep

    plan = plan_sweep(with_own(load_sweep(spec), law or (), metric or ()))
    with suppress(InputError):  # what is wrong with a point is said where it is run
        first = scenario_at(plan.sweep, plan.points[0]).setting  # the other points differ in some fields only
        laws = {c: make_controller(controller_at(plan.sweep, c, plan.points[0])) for c in plan.sweep.controllers}
        print_forewarnings(sentence for name, law in laws.items() for sentence in forewarnings(first, law, name))
    folder = out if out is not None else Path("out") / plan.sweep.name
    check_folder(folder)

    def resumed(done: int, chunks: int) -> None:
        if not quiet:
            print(f"{folder}: {done} of {chunks} chunks are there already", file=sys.stderr)

    try:
        preload = ["pyarrow", "robotics.studies.sweeps.running"]
        with workers_at(workers, dask, preload) as crew, progress_bar(quiet) as begin:
            done = run_sweep(plan, folder, crew, fresh=fresh, begin=begin, resumed=resumed)
    except KeyboardInterrupt:
        landed = f"{landed_chunks(plan, folder)} of {plan.chunks} chunks are in {folder}"
        interrupted(f"{landed}; the same command goes on from there")
    if json:
        print_json(
            {
                "results": str(done.results),
                "rows": done.rows,
                "points": len(plan.points),
                "controllers": list(plan.sweep.controllers),
                "seeds": list(range(plan.sweep.first_seed, plan.sweep.first_seed + plan.sweep.seeds)),
                "runs": done.runs,
                "diverged": done.diverged,
                "with_contact": done.contacts,
                "chunks": done.chunks,
                "computed": done.computed,
                "versions": versions(*PACKAGES),
            }
        )
        return
    counts = ((len(plan.points), "point"), (len(plan.sweep.controllers), "controller"), (plan.sweep.seeds, "seed"))
    shown = " × ".join(f"{count} {name}{'s' if count != 1 else ''}" for count, name in counts)
    touched = f"✕ contact in {done.contacts} of {done.runs} runs; " if done.contacts else ""
    print(
        f"{done.results}: {done.rows} rows, {shown}; {done.diverged} rows of robots that diverged; {touched}"
        f"{done.computed} of {done.chunks} chunks computed now"
    )
