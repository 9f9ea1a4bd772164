"""The arena of tasks as a kind: what the command does with it."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from robotics.plugins.arena.kinds import ArenaKind
from robotics.plugins.tasks.description import TASKS_PAGE, tasks_from_table

if TYPE_CHECKING:
    from robotics.plugins.tasks.outcome import TaskOutcome


def _run(plan: Any, folder: Path, command: str, **options: Any) -> "TaskOutcome":
    from robotics.plugins.tasks.report import write_tasks
    from robotics.plugins.tasks.running import drive_tasks

    outcome = drive_tasks(plan, folder, **options)
    write_tasks(outcome, folder, command=command, begin=options["begin"])
    return outcome


def _answer(outcome: "TaskOutcome") -> list[str]:
    from robotics.plugins.tasks.answer import answer

    return answer(outcome)


def _show(outcome: "TaskOutcome") -> str:
    """The ranking of each class, with exact bounds."""
    caused, locked, time = outcome.share("caused"), outcome.share("deadlock"), outcome.mean("time")
    lines = [f"{'':30}{'caused':>8}  {'95 %':>14}{'deadlocks':>11}{'time':>7}   (per 1,000 runs; time over nominal)"]
    for knowledge in outcome.filled:
        lines.append(knowledge)
        for rank, k in enumerate(outcome.among(knowledge), start=1):
            ends = f"{1000 * caused.low[k]:.3g} to {1000 * caused.high[k]:.3g}"
            numbers = f"{1000 * caused.value[k]:8.3g}  {ends:>14}{1000 * locked.value[k]:11.3g}{time.value[k]:7.3g}"
            lines.append(f"  {rank} {outcome.titles[k]:26}{numbers}")
    return "\n".join(lines)


def _tell(outcome: "TaskOutcome") -> dict[str, Any]:
    from robotics.plugins.tasks.report import laws_table, ranking_table

    tables = {"ranking": ranking_table(outcome), "laws": laws_table(outcome)}
    return {name: table.replace({float("nan"): None}).to_dict(orient="records") for name, table in tables.items()}


TASK_KIND = ArenaKind(tasks_from_table, _run, _answer, _show, _tell, TASKS_PAGE, ("robotics.plugins.tasks.running",))
