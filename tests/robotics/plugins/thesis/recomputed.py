"""Claims against the script that recomputes them from saved runs."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from robotics.plugins.thesis.chapters import save_results
from robotics.plugins.thesis.experiment import Experiment
from robotics.show.report.chapter import Claim, judged_together
from tests.recompute_claims import recompute


def check_recomputed(
    results: dict[Any, Any], experiments: Sequence[Experiment], claims: Sequence[Claim], folder: Path, least: int
) -> None:
    """Save the runs behind the claims, and compute at ``least`` so many of their numbers again, to 1e-6."""
    save_results(results, experiments, folder / "runs")
    pd.DataFrame([row for claim in judged_together(claims, [])[0] for row in claim.evidence()]).to_csv(
        folder / "evidence.csv", index=False
    )
    worst, count, wrong = recompute(folder)
    assert wrong == [], wrong
    assert count >= least
    assert worst < 1e-6
