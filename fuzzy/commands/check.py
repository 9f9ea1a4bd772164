"""The command ``fuzzy check``: defects of a rule base."""

from dataclasses import asdict
from typing import Annotated

import typer

from fuzzy.commands.shared import FisFile, read_system
from fuzzy.shell.options import Json, option
from fuzzy.shell.terminal import FAILED, print_json


def check(
    file: FisFile,
    points: Annotated[int, option("Points at which to look for places without a rule.", min=1)] = 4096,
    seed: Annotated[int, option("Shifts the points.", min=0)] = 0,
    measures: Annotated[bool, option("Also give measures of how readable it is.", "--measures")] = False,
    json: Json = False,
) -> None:
    """Look for defects: places where no rule fires, unused terms, contradictory rules and so on.

    The exit code is 1 if there are errors or warnings; notes do not count.

    \b
    Example:
      fuzzy example tipper
      fuzzy check tipper.fis
      fuzzy check tipper.fis --measures
      fuzzy check lateral
    """
    from fuzzy.insight.diagnosis import check as check_system
    from fuzzy.insight.interpretability import interpretability

    system = read_system(file)
    findings = check_system(system, points, seed)
    measured = interpretability(system) if measures else None
    failed = any(finding.severity != "note" for finding in findings)
    if json:
        fields = ("severity", "kind", "sentence", "where")
        listed = [{name: getattr(finding, name) for name in fields} for finding in findings]
        about = {} if measured is None else {"measures": asdict(measured)}
        print_json({"ok": not failed, "findings": listed} | about)
    else:
        for finding in findings:
            print(finding)
        if not findings:
            print("nothing found")
        if measured is not None:
            print(measured)
    if failed:
        raise typer.Exit(FAILED)
