"""The command ``robotics learn rules``: a rule base that does what another law does."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from fuzzy.errors import InputError
from fuzzy.files.atomic import check_target
from fuzzy.shell.options import FieldOptions, Json, Quiet, Shown, option
from fuzzy.shell.progress import progress_bar
from fuzzy.shell.terminal import print_json
from robotics.commands.completion import controllers, scenarios
from robotics.commands.shared import number_cell
from robotics.plugins.stress.commands_repeat import Stress

if TYPE_CHECKING:
    from robotics.plugins.learning.demonstrations import ImitationTask
    from robotics.plugins.learning.lesson import ImitationPlan


def rules_(
    *,
    teacher: Annotated[
        str, option("The law to learn from: name or name:gain=value,...", "--from", "LAW", autocompletion=controllers)
    ],
    out: Annotated[Path, option("File into which the rule base goes.", "--out", "-o", "FILE.fis")],
    scenario: Annotated[
        list[str] | None,
        option("A scenario's name, or a .toml file, to drive; may be given again.", autocompletion=scenarios),
    ] = None,
    stress: Annotated[
        list[Stress] | None, option("Random scenarios to drive, one for each seed; may be given again.")
    ] = None,
    robots: Annotated[
        int | None, option("Robots of random scenarios. Default: crossing: 3, obstacles: 1.", min=1, max=200)
    ] = None,
    lesson: Annotated[
        "Callable[..., ImitationPlan]",
        FieldOptions(
            "robotics.plugins.learning.lesson:ImitationPlan",
            *("inputs", "outputs", "into", "rules", "rounds", "disturbance"),
            later=True,
            inputs=Shown(default=("x_err", "y_err", "heading_err", "target_v", "target_w"), metavar="NAME,..."),
            outputs=Shown(metavar="NAME,..."),
            into=Shown(metavar="LAW:GAIN"),
        ),
    ],
    epochs: Annotated[int, option("Epochs of hybrid learning in each round.", min=0)] = 30,
    seeds: Annotated[int, option("Runs of each scenario; every fourth is kept for checking.", min=2)] = 12,
    seed: Annotated[int, option("The first seed.", min=0)] = 0,
    unseen: Annotated[int, option("Seeds after these, on which both laws drive at the end.", min=1)] = 10,
    front: Annotated[
        str, option("Also learn with these numbers of rules, to tell what each loses: 2,4,8,16,30.", "N,...")
    ] = "",
    plot: Annotated[Path | None, option("Draw the error over the number of rules.", "--plot", "FILE")] = None,
    data: Annotated[Path | None, option("Save the samples, with names and units in the header.", "FILE.csv")] = None,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Learn a rule base that does what another law does, and drive both on seeds that were not learnt from.

    The teacher drives, half of its runs disturbed; then the learner drives and the teacher says what it would do there.
    Clusters give the rules, hybrid learning moves them. The same command gives the same file.

    \b
    Example:
      robotics learn rules --from lyapunov --scenario lyapunov-sine --rules 8 --rounds 1 --seeds 4 -o learnt.fis
      robotics run lyapunov-sine --controller fuzzy:rule_base=learnt.fis
    """
    from anfis import Options
    from fuzzy.files.table import write_table
    from robotics.plugins.learning.imitation import drives, imitate, most_lost, steps, write_rule_base
    from robotics.plugins.learning.lesson import RIDGE

    check_target(out)
    check_target(data)
    check_target(plot)
    plan = lesson(
        teacher=teacher,
        courses=_courses(scenario or [], stress or [], robots),
        seeds=tuple(range(seed, seed + seeds)),
        options=Options(epochs=epochs, ridge=RIDGE),
    )
    plan.check_file(out)
    with progress_bar(quiet) as begin:
        found = imitate(plan, begin("learning", steps(plan)))
        plans = [replace(plan, rules=count) for count in _counts(front) if count != plan.rules]
        others = [imitate(each, begin(f"with {each.rules} rules", steps(each))) for each in plans]
    fronted = sorted([found, *others], key=lambda each: each.lesson.rules)
    write_rule_base(found, out)
    if plot is not None:
        from fuzzy.figures.drawing import save_figure
        from robotics.plugins.learning.figures import plot_front_of_rules

        save_figure(plot_front_of_rules([(len(e.system.rules), e.taken.of_the_range) for e in fronted]), plot)
    if data is not None:
        write_table(data, *found.table())
    with progress_bar(quiet) as begin:
        after = range(seed + seeds, seed + seeds + unseen)
        driven = drives(plan, out, after, begin("driving unseen seeds", 2 * len(plan.courses)))
    if json:
        about = {"file": str(out), "rules": plan.rules, "rounds": [row.told() for row in found.rounds]}
        lost = [part and part._asdict() for part in map(most_lost, fronted)]
        numbers = [
            {"rules": len(e.system.rules), **e.taken.told(), "most_lost": part}
            for e, part in zip(fronted, lost, strict=True)
        ]
        print_json(about | {"front": numbers, "taken": found.best, "seeds": list(after), "driven": driven})
        return
    for number, row in enumerate(found.rounds):
        print(f"round {number}: {row}{' <- taken' if number == found.best else ''}")
    if others:
        print(f"\n{'rules':>5} {'of range':>9} {'contacts':>9} {'missing':>8}  most of the squared error")
    for each in fronted if others else ():
        row = each.taken
        drove = f"{100 * row.of_the_range:7.3g} % {row.touched:9} {row.missing:8}"
        print(f"{len(each.system.rules):5} {drove}  {most_lost(each) or ''}")
    print(f"{out}: {len(found.system.rules)} rules. Flown on the unseen seeds {after[0]} to {after[-1]}:")
    for course, laws in driven.items():
        print(f"\n{course:48} {'teacher':>12} {'learnt':>12}")
        for name, value in laws["teacher"].items():
            print(f"{name:48} {number_cell(value):>12} {number_cell(laws['learnt'][name]):>12}")
    print(f"\nIt drives as --controller {plan.controller(out)}")


def _counts(front: str) -> list[int]:
    """Numbers of rules, between commas. Raises InputError."""
    try:
        return [int(count) for count in front.split(",") if front]
    except ValueError:
        raise InputError(f"--front must be whole numbers between commas, such as 2,4,8; got {front!r}") from None


def _courses(scenarios: Sequence[str], stress: Sequence[Stress], robots: int | None) -> tuple["ImitationTask", ...]:
    from robotics.plugins.learning.demonstrations import crossing_course, obstacle_course, scenario_course
    from robotics.simulation.scenario.reading import load_scenario

    courses = [scenario_course(load_scenario(name)) for name in scenarios]
    for each in stress:
        courses.append(crossing_course(robots or 3) if each is Stress.crossing else obstacle_course(robots or 1))
    return tuple(courses)
