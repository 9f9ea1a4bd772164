"""The command ``robotics explain``: which rules decided what a robot did in a saved run."""

from typing import Annotated

import typer

from fuzzy.errors import InputError
from fuzzy.shell.options import Json
from fuzzy.shell.terminal import print_json
from robotics.commands.shared import OneSeed, SavedRun


def explain(
    run: SavedRun,
    robot: Annotated[int, typer.Option(help="The robot, from 1.")] = 1,
    time: Annotated[float | None, typer.Option(metavar="S", help="The time to explain, s.")] = None,
    start: Annotated[
        float | None, typer.Option("--from", metavar="S", help="In place of --time: list the rules from here on, s.")
    ] = None,
    end: Annotated[float | None, typer.Option("--to", metavar="S", help="Up to this time, s.")] = None,
    seed: OneSeed = None,
    json: Json = False,
) -> None:
    """Explain what a robot did at one time, and which rules of its law decided; or list the strongest rules of a span.

    \b
    Example:
      robotics run table-2-1 -c fuzzy --save run.npz
      robotics explain run.npz --robot 1 --time 14
    """
    from robotics.measures.explained import explain_decision, explain_spans
    from robotics.simulation.run import load_run

    spans = start is not None or end is not None
    if spans == (time is not None):
        raise InputError("give either --time, or --from and --to")
    loaded = load_run(run)
    if time is not None:
        explained = explain_decision(loaded, robot, time, seed)
        print_json(explained.as_dict()) if json else print(explained)
        return
    found = explain_spans(loaded, robot, start, end, seed)
    if json:
        print_json([span._asdict() | {"sentence": sentence} for span, sentence in found])
    else:
        print("\n".join(sentence for _, sentence in found))
