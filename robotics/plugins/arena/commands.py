"""The command ``robotics arena``: every law tuned with the same budget, and compared on runs that none has seen."""

import shlex
import sys
from pathlib import Path
from typing import Annotated

from fuzzy.errors import InputError
from fuzzy.files.atomic import check_folder
from fuzzy.shell.interrupts import interrupted
from fuzzy.shell.options import Json, Quiet, argument, option, renamed_options
from fuzzy.shell.progress import progress_bar
from fuzzy.shell.terminal import print_json
from robotics.commands.completion import arenas, controller_list
from robotics.commands.shared import Dask
from robotics.studies.versions import versions

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
    """Which law, when, by how much? Tune every law alike, then compare them on unseen runs.

    The arena "default" compares laws that track a path, the arena "tasks" teams that cooperate, meet and go round
    obstacles. Both take minutes; "demo" and "tasks-demo" are small ones of seconds.

    It first says how much there is to do. It writes a page, arena.html or tasks.html, with the answer in one figure and
    ten sentences, results.csv, a table a law, figures and the tuned laws. After a stop the same command goes on.

    \b
    Example:
      robotics arena demo --out out/arena
      robotics arena tasks-demo --out out/tasks
      robotics new law -o mylaw.py
      robotics arena demo --laws fuzzy,lyapunov,mylaw.py:MyLaw --out out/mine
    """
    if full and file != "default":
        raise InputError(f"give --full or {file}, not both")
    from fuzzy.compiled.threads import processors
    from robotics.commands.compare import split_controllers
    from robotics.plugins.arena.kinds import arena_kind, load_plan
    from robotics.studies.executors import workers_at

    plan = load_plan(FULL if full else file)
    kind = arena_kind(plan.kind)
    if laws is not None:
        plan = plan.with_laws(split_controllers(laws))
    folder = out if out is not None else Path("out") / "arena"
    check_folder(folder)
    command = ["robotics", "arena", *(["--full"] if full else [file] if file != "default" else [])]
    command += [f"--laws={laws}"] if laws is not None else []

    def announce(sentence: str) -> None:
        if not quiet:
            print(f"{folder}: {sentence}", file=sys.stderr)

    try:
        count = workers or (processors() if dask is None else None)
        with workers_at(count, dask, kind.preload) as crew, progress_bar(quiet) as begin:
            outcome = kind.run(
                plan, folder, workers=crew, fresh=fresh, begin=begin, announce=announce, command=shlex.join(command)
            )
    except KeyboardInterrupt:
        interrupted(f"what is done is in {folder}; the same command goes on from there")
    page, sentences = folder / kind.page, kind.answer(outcome)
    if json:
        print_json({"answer": sentences, **kind.tell(outcome), "page": str(page), "versions": versions()})
    else:
        print(kind.show(outcome), "", *sentences, page, sep="\n")
