"""The start that anfis offers for a new rule base: a network learnt from a table."""

from pathlib import Path

from fuzzy.plugins.designer.starts.samples import TABLE_OPTIONS, clusters_example, read_samples
from fuzzy.plugins.designer.starts.start import NumberOption, Report, Start
from fuzzy.system import Sugeno

EPOCHS = 60  # as `anfis train` learns


def learnt(
    file: Path, inputs: str, outputs: str, bad: str, radius: float, epochs: int, report: Report = lambda *_: None
) -> Sugeno:
    """Learn as `anfis train --radius` does by default: from clusters of all samples, by hybrid learning."""
    from anfis.methods.options import Options
    from anfis.training import train
    from fuzzy.fitting.identification import identify
    from fuzzy.fitting.termnames import with_telling_names

    x, y, names = read_samples(file, inputs, outputs, bad)
    report(0.0, "clusters are looked for")
    fis = identify(x, y, "subtractive", radius=radius, name="anfis", **names)

    def tell(epoch: object) -> None:
        number, error = epoch.epoch, epoch.train  # type: ignore[attr-defined]
        report(number / max(1, epochs), f"epoch {number} of {epochs}: RMSE {error:.4g}")

    return with_telling_names(train(fis, x, y, Options(epochs=epochs), callback=tell).system)


def starts() -> list[Start]:
    """ANFIS from a table."""
    return [
        Start(
            "anfis",
            "From data",
            "ANFIS from a table",
            "Learns memberships and consequents from a .csv file, starting from its clusters, as anfis train does.",
            learnt,
            (
                *TABLE_OPTIONS,
                NumberOption("radius", "Radius of the first clusters", 0.05, 2, 0.5, whole=False),
                NumberOption("epochs", "Epochs", 1, 2000, EPOCHS),
            ),
            clusters_example,
            reports=True,
        )
    ]
