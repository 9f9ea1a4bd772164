"""The option --folds of ``anfis train``: the cross-validation, its progress and what is said of it."""

from typing import TYPE_CHECKING, Any

from anfis.commands.shared import TrainingData
from fuzzy.shell.progress import Mover, progress_bar
from fuzzy.shown import shown

if TYPE_CHECKING:
    from anfis import CrossValidation, Epoch, Options


def crossed(
    start: Any,
    samples: TrainingData,
    options: "Options",
    folds: int,
    order: str,
    quiet: bool,
) -> "CrossValidation":
    """The cross-validation, with a progress bar on stderr."""
    import anfis

    with progress_bar(quiet, width=44) as begin:
        each = options.epochs + 1
        move = Mover(begin("folds", folds * each))

        def show(fold: int, row: "Epoch") -> None:
            move(fold * each + row.epoch + 1, f"fold {fold + 1} of {folds}: training {shown(row.train)}")

        found = anfis.cross_validate(
            start,
            samples.x,
            samples.y,
            options,
            folds=folds,
            order=order,  # type: ignore[arg-type]
            seed=options.seed,
            check=samples.check,
            callback=show,
        )
        move(folds * each, "folds")
        return found


def folds_object(found: "CrossValidation", order: str, seed: int) -> dict[str, Any]:
    """What --json says of the folds."""
    return {
        "count": len(found.folds),
        "order": order,
        "seed": seed,
        "mean": found.mean,
        "std": found.std,
        "each": found.table().to_dict("records"),
    }


def say_folds(found: "CrossValidation", order: str, unit: str) -> None:
    """Print a line for each fold, and the mean."""
    of = f" [{unit}]" if unit else ""
    print(f"RMSE{of} of {len(found.folds)} folds ({order}), at the samples that a fold did not learn from:")
    print("  fold  held back  training  held back's  rules  epochs")
    for row in found.table().itertuples():
        errors = f"{shown(row.train):>8}  {shown(row.rmse):>11}"
        print(f"  {row.fold:4d}  {row.held:9d}  {errors}  {row.rules:5d}  {row.epochs:6d}")
    print(f"  mean {shown(found.mean)}, standard deviation {shown(found.std)}")
