"""The option --prune of ``anfis train``: the pruning, its progress and what is said of it."""

from typing import TYPE_CHECKING, Any

from anfis.commands.shared import TrainingData
from fuzzy.shell.progress import Mover, progress_bar
from fuzzy.shown import shown

if TYPE_CHECKING:
    from anfis import Epoch, Options, Pruned
    from fuzzy.system import Sugeno

_RETRAIN = 3  # epochs after each step
_POINTS = 20_000  # places of the input space at which is asked whether a rule fires


def pruned(
    fis: "Sugeno", samples: TrainingData, options: "Options", keep: int | None, choice: str, quiet: bool
) -> "Pruned":
    """The pruning, with a progress bar on stderr."""
    import anfis
    from anfis.pruning import schedule

    full, short = options.epochs + 1, min(_RETRAIN, options.epochs) + 1
    numbers = schedule(len(fis.rules), keep or 1) if keep is None or keep <= len(fis.rules) else [len(fis.rules)]
    starts = {rules: full + k * short for k, rules in enumerate(numbers[1:])}
    with progress_bar(quiet, width=44) as begin:
        total = 2 * full + len(starts) * short
        move = Mover(begin("pruning", total))

        def show(stage: str, rules: int, row: "Epoch") -> None:
            place = {"all rules": 0, "last training": total - full}.get(stage, starts.get(rules, 0))
            checked = f", checking {shown(row.check)}" if row.check == row.check else ""
            move(place + row.epoch + 1, f"{rules} rules: training {shown(row.train)}{checked}")

        found = anfis.prune(
            fis,
            samples.x,
            samples.y,
            options,
            check=samples.check,
            test=samples.test,
            keep=keep,
            choice=choice,  # type: ignore[arg-type]
            retrain=_RETRAIN,
            seed=options.seed,
            callback=show,
        )
        move(total, "pruning")
        return found


def pruning_object(found: "Pruned") -> dict[str, Any]:
    """What --json says of a pruning."""
    return {
        "unpruned": found.path[0]._asdict(),
        "pruned": found.error._asdict(),
        "chosen": found.path[found.chosen].rules,
        "held": len(found.held),
        "uncovered_percent": _uncovered(found.system),
        "path": [step._asdict() for step in found.path],
    }


def say_pruning(found: "Pruned", unit: str) -> None:
    """Print the errors for every number of rules, and where no rule fires any more."""
    columns = [c for c in ("train", "check", "test") if getattr(found.path[0], c) == getattr(found.path[0], c)]
    titles = {"train": "training", "check": "checking", "test": "test"}
    print(f"RMSE{f' [{unit}]' if unit else ''} by the number of rules, before the last training:")
    print("  rules" + "".join(f"  {titles[c]:>9}" for c in columns))
    for k, step in enumerate(found.path):
        mark = "  <- chosen" if k == found.chosen else ""
        print(f"  {step.rules:5d}" + "".join(f"  {shown(getattr(step, c)):>9}" for c in columns) + mark)
    if len(found.held):
        print(f"{len(found.held)} samples were held back for the choice, and were learnt from in the last training")
    share = _uncovered(found.system)
    if share:
        print(f"no rule fires in {share:.2g} % of the input space: there the middle of the output's range stands")


def _uncovered(fis: "Sugeno") -> float:
    """The largest share of the input space, in percent, in which no rule fires for an output."""
    from fuzzy.insight.coverage import uncovered

    return max((share for _, share, _ in uncovered(fis, _POINTS)), default=0.0)
