"""The command ``robotics explain``: which rules decided what a robot did in a saved run."""

from typing import Annotated

from fuzzy.errors import InputError
from fuzzy.shell.options import Json, option
from robotics.commands.shared import OneSeed, SavedRun, print_result


def explain(
    run: SavedRun,
    robot: Annotated[int, option("The robot, from 1.")] = 1,
    time: Annotated[float | None, option("The time to explain, s.", "S")] = None,
    start: Annotated[float | None, option("In place of --time: list the rules from here on, s.", "--from", "S")] = None,
    end: Annotated[float | None, option("Up to this time, s.", "--to", "S")] = None,
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
        print_result(json, explained.as_dict(), str(explained))
        return
    found = explain_spans(loaded, robot, start, end, seed)
    rows = [span._asdict() | {"sentence": sentence} for span, sentence in found]
    print_result(json, rows, "\n".join(sentence for _, sentence in found))
