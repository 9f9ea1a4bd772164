"""An arena's file among the plans that `robotics study` and `robotics check` take."""

from fuzzy.words import counted
from robotics.plugins.arena.commands import arena
from robotics.plugins.arena.kinds import load_plan, plan_from_table
from robotics.plugins.arena.plan import BLOCKS
from robotics.show.report.planfile import PlanKind, Row


def drawn(name: str) -> tuple[str, list[Row], list[str]]:
    """Draw the plan of an arena: its laws, how each is tuned, on what it is tested."""
    plan = load_plan(name)
    rows = [
        (len(plan.laws), "law", ", ".join(plan.laws)),
        (len(plan.engines) * plan.repeats, "search", f"{', '.join(plan.engines)}, {plan.evaluations} evaluations each"),
    ]
    blocks = ", ".join(f"{counted(plan.count(block), 'scenario')} to {block}" for block in BLOCKS)
    return plan.title, rows, [f"   {blocks}{plan.tested}"]


ARENA = PlanKind(
    "arena",
    frozenset({"laws", "like", "engines", "choose", "test", "testing_runs", "choosing_runs"}),
    drawn,
    lambda table, about: plan_from_table(table, about.name, about.folder),
    "a study with [tune], in which every law is tuned with the same budget",
    arena,
)
