"""The command ``robotics ablate``: what each rule base, each rule and the emergency rule of a law is worth."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from fuzzy.commands.shared import check_plot
from fuzzy.files.atomic import check_folder
from fuzzy.shell.options import FieldOptions, Json, Quiet, argument, option
from fuzzy.shell.progress import progress_bar
from fuzzy.shell.terminal import print_json
from robotics.commands.completion import controllers, scenarios
from robotics.studies.versions import versions

if TYPE_CHECKING:
    from robotics.plugins.ablation.ablation import AblationPlan

WORTH_FILE = "ablation.csv"
_NUMBERS = ("crossings", "courses", "seeds", "shuffles", "seed")


def ablate(
    law: Annotated[
        str, argument("The law: a name, name:gain=value, mine.fis, mylaw.py:MyLaw.", "LAW", autocompletion=controllers)
    ],
    *,
    each_rule: Annotated[
        list[str], option("Leave out every rule of this rule base too, one at a time; may be repeated.", "--rules")
    ] = [],  # noqa: B006
    on: Annotated[
        list[str],
        option("A scenario to drive; may be repeated. Default: those of its kind.", "--on", autocompletion=scenarios),
    ] = [],  # noqa: B006
    made: Annotated[
        "Callable[..., AblationPlan]",
        FieldOptions("robotics.plugins.ablation.ablation:AblationPlan", *_NUMBERS, later=True),
    ],
    workers: Annotated[int | None, option("Number of processes. Default: one for each core.", min=1, max=1000)] = None,
    out: Annotated[
        Path | None, option(f"Folder for {WORTH_FILE}. Default: nothing is written.", "-o", "--out", "FOLDER")
    ] = None,
    plot: Annotated[Path | None, option("Draw what each part is worth: .png, .pdf, .svg.", "PICTURE")] = None,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Drive a law without each of its rule bases, with their consequents shuffled, without rules, without emergency.

    Everything drives on the same runs as the whole law; the differences have 95 % intervals. A part that is worth
    nothing in these runs may go, or be worth something elsewhere: --on drives other scenarios.

    \b
    Example:
      robotics ablate fuzzy --on fuzzy-off-path --seeds 5 --rules tracking --plot worth.png
    """
    from fuzzy.compiled.threads import processors
    from fuzzy.figures.drawing import save_figure
    from fuzzy.files.table import write_frame
    from robotics.plugins.ablation.ablation import ablate
    from robotics.plugins.ablation.figures import plot_ablation
    from robotics.studies.executors import workers_at

    check_plot(plot)
    if out is not None:
        check_folder(out)
    plan = made(law=law, each_rule=tuple(each_rule), on=tuple(on))
    count = workers or processors()
    with workers_at(count, None, ["robotics.plugins.ablation.tasks"]) as crew, progress_bar(quiet) as begin:
        found = ablate(plan, crew, begin)
    files = []
    if out is not None:
        out.mkdir(parents=True, exist_ok=True)
        write_frame(found.table, out / WORTH_FILE)
        files.append(out / WORTH_FILE)
    if plot is not None:
        save_figure(plot_ablation(found), plot)
        files.append(plot)
    if json:
        rows = found.table.to_dict(orient="records")
        print_json({"law": law, "needed": found.needed, "rows": rows, "versions": versions()})
        return
    print(*found.sentences, *files, sep="\n")
