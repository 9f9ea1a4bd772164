"""The command ``robotics check``: whether a scenario can go well, before anything runs."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fuzzy.commands.shared import check_plot
from fuzzy.shell.options import Json, option
from fuzzy.shell.terminal import FAILED, print_json
from fuzzy.shown import shown
from robotics.commands.shared import ScenarioName, controller_option

if TYPE_CHECKING:
    from robotics.simulation.scenario.survey import Survey
    from robotics.studies.inspection import Inspection
    from robotics.tables.faults import FileFault
    from robotics.tables.files import TomlFile


def check(
    scenario: ScenarioName,
    controller: Annotated[
        str | None, controller_option("Who is to drive. Default: the scenario's own, or fuzzy.")
    ] = None,
    out: Annotated[Path | None, option("Draw it to scale: .png, .pdf or .svg.", "--out", "-o", "PICTURE")] = None,
    json: Json = False,
) -> None:
    """Judge a scenario before anything runs: speeds, starts, goals, paths among obstacles, radio, sensors, rules.

    It also reads the file of a study, a sweep, an arena or a tuning, and draws its plan in text.

    It tells all errors of the file at once, with line, key, value and what is accepted. The exit code is 1 if
    there are errors or warnings; notes do not count.

    \b
    Example:
      robotics new scenario -o mine.toml
      robotics check mine.toml -o mine.png
    """
    from fuzzy.figures.drawing import save_figure
    from robotics.show.report.planfile import drawn_plan, note_on, plan_faults, plan_kind
    from robotics.simulation.scenario.survey import survey
    from robotics.studies.inspection import inspect_survey

    if kind := plan_kind(scenario):
        if Path(scenario).is_file() and (faults := plan_faults(kind, scenario))[1]:
            _print_faults(kind.name, *faults, json)
            raise typer.Exit(FAILED)
        plan_text = drawn_plan(kind, scenario)
        if json:
            print_json({"file": scenario, "kind": kind.name, "ok": True, "plan": plan_text})
            return
        print(plan_text)
        if kind.new_form:
            print(f"robotics: note: {note_on(kind, scenario)}", file=sys.stderr)
        return
    check_plot(out)
    read = survey(scenario)
    found = inspect_survey(read, controller or "")
    if out is not None and found.scenario is not None:
        from robotics.show.figures.scenario import plot_scenario

        save_figure(plot_scenario(found.scenario, found.findings), out)
    drawn = out if found.scenario is not None else None
    if json:
        print_json(_as_json(read, found, drawn))
    else:
        _print(read, found, drawn)
    if found.failed:
        raise typer.Exit(FAILED)


def _print_faults(kind: str, about: "TomlFile", faults: "list[FileFault]", json: bool) -> None:
    """Print all that is wrong with the file of a plan."""
    from robotics.tables.text import line_of

    rows = [
        {"sentence": f.sentence, "key": ".".join(map(str, f.at)) or None, "line": line_of(about.text, f.at)}
        for f in faults
    ]
    if json:
        found = [{"severity": "error", "kind": "not accepted", **row} for row in rows]
        print_json({"file": about.file, "kind": kind, "ok": False, "findings": found})
        return
    for number, row in enumerate(rows, start=1):
        print(f"{number:2} error: {about.file}:{row['line']}: {row['sentence']}")


def _as_json(read: "Survey", found: "Inspection", picture: Path | None) -> dict[str, object]:
    rows = [
        {
            "severity": f.severity,
            "kind": f.kind,
            "sentence": f.sentence,
            "key": ".".join(map(str, f.at)) or None,
            "line": read.line(f.at) if f.at else None,
            "x_m": f.x,
            "y_m": f.y,
        }
        for f in found.findings
    ]
    needed = [d._asdict() | {"robot": d.robot + 1, "reserve": d.reserve} for d in found.demands]
    made: dict[str, object] = {"file": read.file, "controller": found.controller, "ok": not found.failed}
    made |= {"findings": rows, "demands": needed, "metrics": [*found.metrics]}
    made["asked"] = [
        {"rule_base": d.rule_base, "output": d.output, "unit": d.unit, "span": d.span} for d in found.asked
    ]
    return made | ({"picture": str(picture)} if picture is not None else {})


def _print(read: "Survey", found: "Inspection", picture: Path | None) -> None:
    """Print the findings with their lines, numbered as in the picture, and the greatest demands on each robot."""
    for number, f in enumerate(found.findings, start=1):
        where = f"{read.file}:{read.line(f.at)}: " if f.at else f"{read.file}: "
        print(f"{number:2} {f.severity}: {where}{f.sentence}")
    if not found.findings:
        print("nothing found")
    if found.scenario is None:
        print("too little of the file can be read to judge or to draw the rest")
        return
    print("\nthe most that each reference demands, and what is left of it:")
    print("robot  of         needs    limit    left     at t      x        y")
    for d in found.demands:
        unit = "rad/s" if d.limit == "turn rate" else "m/s  "
        place = f"{d.time:6.2f} s {d.x:6.2f} m {d.y:6.2f} m"
        print(f"{d.robot + 1:5}  {d.limit:9}  {d.need:6.3f}  {d.most:6.3f} {unit} {100 * d.reserve:5.1f} % {place}")
    for asked in found.asked:
        low, high = (shown(value, span=asked.span[1] - asked.span[0]) for value in asked.span)
        print(f"the rule base {asked.rule_base} asks for {asked.output} from {low} to {high} {asked.unit}")
    if found.metrics:
        print(f"\nmetrics of the task, which come first: {', '.join(found.metrics)}")
    if picture is not None:
        print(picture)
