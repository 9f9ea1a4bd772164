"""The command ``robotics tune``: a law's gains and rule bases, tuned through the closed loop."""

import re
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from fuzzy.files.atomic import check_folder
from fuzzy.shell.interrupts import interrupted
from fuzzy.shell.options import Json, Quiet, argument, option, renamed_options
from fuzzy.shell.progress import Mover, progress_bar
from fuzzy.shell.terminal import print_json
from fuzzy.shown import shown
from fuzzy.words import split_list
from robotics.commands.completion import controllers, scenarios
from robotics.commands.shared import Dask, print_forewarnings
from robotics.studies.versions import versions

if TYPE_CHECKING:
    from fuzzy.tuning.search import Evaluations
    from robotics.plugins.tuning.unseen import Unseen
    from robotics.simulation.scenario.description import Scenario
    from robotics.studies.tuning.tune import Tuned


@renamed_options(jobs="--workers", runs="--seeds", check_runs="--check-seeds", scenarios="")
def tune(
    law: Annotated[
        str, argument("The law: a name, name:gain=value, mine.fis, mylaw.py:MyLaw.", "LAW", autocompletion=controllers)
    ],
    on: Annotated[list[str], argument("Names or .toml files to tune on.", "SCENARIO", autocompletion=scenarios)],
    unseen: Annotated[
        str | None,
        option("Scenarios not tuned on, to compare before and after. Default: other packaged tracking ones.", "C,D"),
    ] = None,
    noise: Annotated[bool, option("Measure postures with 3 mm and 3 mrad of noise where nothing is random.")] = False,
    seeds: Annotated[int, option("Seeds of each candidate on each scenario.", min=1)] = 20,
    evaluations: Annotated[int, option("Number of candidates, including the law as it is.", min=1)] = 1000,
    seed: Annotated[int, option("The seed of the search.", min=0)] = 1,
    engine: Annotated[str, option("What searches: cmaes, or random.")] = "cmaes",
    space: Annotated[str | None, option("What may move, and the cost: see `robotics new tuning`.", "FILE.toml")] = None,
    pareto: Annotated[bool, option("Look for the front between the cost's two objectives.")] = False,
    check_seeds: Annotated[int, option("Unseen seeds to compare before and after; 0: none.", min=0)] = 200,
    out: Annotated[Path | None, option("Folder of the results. Default: out/tune-LAW", "--out", "-o", "FOLDER")] = None,
    fresh: Annotated[bool, option("Discard what FOLDER holds of a search.")] = False,
    workers: Annotated[int | None, option("Number of threads. Default: one for each core.", min=1, max=1000)] = None,
    dask: Dask = None,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Tune a law through the closed loop: its gains, the memberships and the consequents of its rule bases.

    All candidates drive with the same seeds. It writes history.csv, one row an evaluation, the tuned rule bases as
    .fis, result.json and evaluations.png. After a stop the same command goes on from there; Ctrl-C keeps the best.

    \b
    Example:
      robotics tune lyapunov lyapunov-sine noisy-position --evaluations 100 --seeds 5 -o tuned
      robotics tune fuzzy lyapunov-sine --unseen lyapunov-circle --evaluations 50 --seeds 5 -o rules
      robotics run lyapunov-sine -c fuzzy:rule_base=rules/tracking.fis
    """
    from robotics.laws.catalogue import make_controller
    from robotics.plugins.tuning.unseen import compared
    from robotics.simulation.scenario.reading import load_scenario
    from robotics.studies.executors import workers_at
    from robotics.studies.forewarnings import forewarnings
    from robotics.studies.tuning.file import TuningFile, load_tuning
    from robotics.studies.tuning.results import write_tuned
    from robotics.studies.tuning.tune import TuningInterrupt, with_noise
    from robotics.studies.tuning.tune import tune as tuned_by

    tuning = load_tuning(space) if space is not None else TuningFile()
    settings = [load_scenario(name) for name in on]
    others = [load_scenario(name) for name in _unseen(unseen, settings)] if check_seeds else []
    if noise:
        settings, others = ([with_noise(s) for s in group] for group in (settings, others))
    moving, cost = tuning.space(make_controller(law)), tuning.made_cost()
    folder = out if out is not None else Path("out") / f"tune-{_plain(law)}"
    check_folder(folder)
    print_forewarnings(sentence for s in settings for sentence in forewarnings(s.setting, moving.law, law))
    began = time.monotonic()
    try:
        with workers_at(address=dask) as crew, progress_bar(quiet, width=46) as begin:
            moved = Mover(begin(f"{law}: {len(moving.parameters)} parameters", evaluations))

            def told(found: "Evaluations") -> None:
                before, best = shown(float(found.costs[0])), shown(float(found.costs.min()))
                moved(len(found), f"{law}: {before} before, best {best}")

            found = tuned_by(
                moving,
                settings,
                specification=law,
                runs=seeds,
                evaluations=evaluations,
                seed=seed,
                engine=engine,
                cost=cost,
                pareto=pareto,
                folder=folder,
                fresh=fresh,
                threads=workers,
                workers=crew,
                progress=told,
            )
    except TuningInterrupt as stop:
        kept = stop.tuned
        name = write_tuned(kept, law, folder)
        interrupted(
            f"the best of {kept.evaluations} evaluations costs {shown(kept.after)}, before {shown(kept.before)}: "
            f"{name}; the same command goes on from there"
        )
    result = write_tuned(found, law, folder)
    checked = compared(found, settings, others, check_seeds, workers) if check_seeds else []
    seconds = time.monotonic() - began
    if json:
        print_json(_as_json(found, result, folder, checked, seconds))
    else:
        _print(found, result, folder, checked, seconds)


def _unseen(text: str | None, settings: "list[Scenario]") -> list[str]:
    """The names of the scenarios that are not tuned on: those that are asked for, or all other packaged ones."""
    from robotics.simulation.scenario.reading import scenario_names

    if text is not None:
        return split_list(text)
    if {s.kind for s in settings} != {"tracking"}:
        return []
    return [name for name in scenario_names("tracking") if name not in {s.name for s in settings}]


def _plain(law: str) -> str:
    """A specification as the name of a folder."""
    return re.sub(r"[^\w.-]+", "-", Path(law.partition(":")[0]).stem)


def _as_json(found: "Tuned", result: str, folder: Path, checked: "list[Unseen]", seconds: float) -> dict[str, Any]:
    from robotics.studies.tuning.results import front_table

    rows = {"front": front_table(found).to_dict(orient="records")} if found.about["engine"] == "pareto" else {}
    return {
        "law": found.about["law"],
        "before": found.before,
        "after": found.after,
        "evaluations": found.evaluations,
        "parameters": len(found.space.parameters),
        "held": list(found.space.held),
        "result": result,
        "unseen": [one.row() for one in checked],
        "folder": str(folder),
        "seconds": seconds,
        "versions": versions(),
        **rows,
    }


def _print(found: "Tuned", result: str, folder: Path, checked: "list[Unseen]", seconds: float) -> None:
    print(
        f"{result}\n  mean cost on the tuning runs: {shown(found.before)} before, {shown(found.after)} after "
        f"{found.evaluations} evaluations of {len(found.space.parameters)} parameters, {seconds:.0f} s"
    )
    if found.space.held:
        names = ", ".join(found.space.held)
        print(f'  held, since the tuning runs say nothing of it (unreached = "move" in FILE.toml moves it): {names}')
    for one in checked:
        print(f"  {one.sentence()}")
    if found.about["engine"] == "pareto":
        print(f"  {len(found.evaluated.front)} laws on the front: {folder / 'front.csv'}")
    print(f"  {folder}: history.csv, result.json, pictures")
