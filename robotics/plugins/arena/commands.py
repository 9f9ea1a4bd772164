"""The command ``robotics arena``: every law tuned with the same budget, and compared on runs that none has seen."""

import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from fuzzy.errors import InputError
from fuzzy.files.atomic import check_folder
from fuzzy.shell.interrupts import interrupted
from fuzzy.shell.options import Json, Quiet, argument, option, renamed_options
from fuzzy.shell.progress import progress_bar
from fuzzy.shell.terminal import print_json
from robotics.commands.completion import arenas, controller_list
from robotics.commands.shared import Dask
from robotics.studies.versions import versions

if TYPE_CHECKING:
    from robotics.plugins.arena.outcome import Outcome

FULL = "full"


@renamed_options(jobs="--workers")
def arena(
    file: Annotated[
        str, argument("An arena's file; or a name.", "[FILE.toml]", show_default=True, autocompletion=arenas)
    ] = "default",
    full: Annotated[bool, option("The whole protocol: 1000 evaluations, 20 seeds, 5 repeats. Takes days.")] = False,
    laws: Annotated[
        str | None,
        option(
            "Other laws: comma-separated names, mine.fis, mylaw.py:MyLaw:gain=2.", "A,B", autocompletion=controller_list
        ),
    ] = None,
    out: Annotated[Path | None, option("Folder of the results. Default: out/arena", "--out", "-o", "FOLDER")] = None,
    workers: Annotated[int | None, option("Number of processes. Default: one for each core.", min=1, max=1000)] = None,
    dask: Dask = None,
    fresh: Annotated[bool, option("Discard what FOLDER holds of an arena.")] = False,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Fuzzy or nonlinear: which, when, by how much? Tune every law alike, then compare them on unseen runs.

    Says first how long it will take. Writes arena.html with the answer in one figure and ten sentences, results.csv,
    summary.csv, figures and the tuned laws. After a stop the same command goes on from there.

    \b
    Example:
      robotics arena demo --out out/arena
      robotics new law -o mylaw.py
      robotics arena demo --laws fuzzy,lyapunov,mylaw.py:MyLaw --out out/mine
    """
    if full and file != "default":
        raise InputError(f"give --full or {file}, not both")
    from fuzzy.compiled.threads import processors
    from robotics.commands.compare import split_controllers
    from robotics.plugins.arena.answer import answer
    from robotics.plugins.arena.description import load_arena, with_laws
    from robotics.plugins.arena.report import PAGE_FILE, pairs_table, run_arena, summary_table
    from robotics.studies.executors import workers_at

    plan = load_arena(FULL if full else file)
    if laws is not None:
        plan = with_laws(plan, split_controllers(laws))
    folder = out if out is not None else Path("out") / "arena"
    check_folder(folder)
    command = ["robotics", "arena", *(["--full"] if full else [file] if file != "default" else [])]
    command += [f"--laws={laws}"] if laws is not None else []

    def announce(sentence: str) -> None:
        if not quiet:
            print(f"{folder}: {sentence}", file=sys.stderr)

    try:
        count = workers or (processors() if dask is None else None)
        with workers_at(count, dask, ["robotics.plugins.arena.work"]) as crew, progress_bar(quiet) as begin:
            outcome = run_arena(
                plan, folder, workers=crew, fresh=fresh, begin=begin, announce=announce, command=shlex.join(command)
            )
    except KeyboardInterrupt:
        interrupted(f"what is done is in {folder}; the same command goes on from there")
    page, sentences = folder / PAGE_FILE, answer(outcome)
    if json:
        print_json(
            {
                "answer": sentences,
                "laws": summary_table(outcome).to_dict(orient="records"),
                "pairs": pairs_table(outcome).to_dict(orient="records"),
                "computing_us": dict(outcome.computing),
                "machine": outcome.machine,
                "page": str(page),
                "versions": versions(),
            }
        )
    else:
        _print(outcome)
        print("", *sentences, page, sep="\n")


def _print(outcome: "Outcome") -> None:
    """Print the costs of every law, as published and tuned, with their intervals."""
    unit = outcome.titles[outcome.reference]
    print(f"{'':28} {'published':>10} {'tuned':>10}  {'95 %':>17}  failed   (cost over that of {unit}, tuned)")
    for k in outcome.order:
        before, after, rate = outcome.published_ratio, outcome.tuned_ratio, outcome.failures.value[k]
        ends = f"{after.low[k]:.3g} to {after.high[k]:.3g}"
        print(f"{outcome.titles[k]:28} {before.value[k]:10.3g} {after.value[k]:10.3g}  {ends:>17}  {100 * rate:5.2g} %")
