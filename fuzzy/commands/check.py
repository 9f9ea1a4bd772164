"""The command ``fuzzy check``: defects of a rule base."""

from typing import Annotated

import typer

from fuzzy.commands.shared import FisFile, read_system
from fuzzy.shell.options import Json, option
from fuzzy.shell.terminal import FAILED, print_json


def check(
    file: FisFile,
    points: Annotated[int, option("Points at which to look for places without a rule.", min=1)] = 4096,
    seed: Annotated[int, option("Shifts the points.", min=0)] = 0,
    json: Json = False,
) -> None:
    """Look for defects: places where no rule fires, unused terms, contradictory rules and so on.

    The exit code is 1 if there are errors or warnings; notes do not count.

    \b
    Example:
      fuzzy example tipper
      fuzzy check tipper.fis
      fuzzy check lateral
    """
    from fuzzy.insight.diagnosis import check as check_system

    findings = check_system(read_system(file), points, seed)
    failed = any(finding.severity != "note" for finding in findings)
    if json:
        fields = ("severity", "kind", "sentence", "where")
        listed = [{name: getattr(finding, name) for name in fields} for finding in findings]
        print_json({"ok": not failed, "findings": listed})
    else:
        for finding in findings:
            print(finding)
        if not findings:
            print("nothing found")
    if failed:
        raise typer.Exit(FAILED)
