"""The arena of tracking as a kind: what the command does with it."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from robotics.plugins.arena.description import ARENA_PAGE, tracking_from_table
from robotics.plugins.arena.kinds import ArenaKind

if TYPE_CHECKING:
    from robotics.plugins.arena.outcome import Outcome


def _run(plan: Any, folder: Path, **options: Any) -> "Outcome":
    from robotics.plugins.arena.report import run_arena

    return run_arena(plan, folder, **options)


def _answer(outcome: "Outcome") -> list[str]:
    from robotics.plugins.arena.answer import answer

    return answer(outcome)


def _show(outcome: "Outcome") -> str:
    """The costs of every law, as published and tuned, with their intervals."""
    unit = outcome.titles[outcome.reference]
    lines = [f"{'':28} {'published':>10} {'tuned':>10}  {'95 %':>17}  failed   (cost over that of {unit}, tuned)"]
    for k in outcome.order:
        before, after, rate = outcome.published_ratio, outcome.tuned_ratio, outcome.failures.value[k]
        ends = f"{after.low[k]:.3g} to {after.high[k]:.3g}"
        costs = f"{before.value[k]:10.3g} {after.value[k]:10.3g}  {ends:>17}  {100 * rate:5.2g} %"
        lines.append(f"{outcome.titles[k]:28} {costs}")
    return "\n".join(lines)


def _tell(outcome: "Outcome") -> dict[str, Any]:
    from robotics.plugins.arena.report import pairs_table, summary_table

    return {
        "laws": summary_table(outcome).to_dict(orient="records"),
        "pairs": pairs_table(outcome).to_dict(orient="records"),
        "computing_us": dict(outcome.computing),
        "machine": outcome.machine,
    }


TRACKING_KIND = ArenaKind(
    tracking_from_table, _run, _answer, _show, _tell, ARENA_PAGE, ("robotics.plugins.arena.work",)
)
