"""The search for settings of subtractive clustering that give a wanted number of rules   [thesis, 5.2.2, Table 5.1].

Every combination is tried. The densities of the samples depend on the radius alone, so they are computed once for each
radius. Settings that find the same centers are fitted once.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, Literal, NamedTuple

import numpy as np

from fuzzy.fitting.clustering import ClusteringOptions, densities, select_centers
from fuzzy.fitting.consequents import ConsequentFit, IdentificationError, least_squares
from fuzzy.fitting.identification import checked, cluster_partition, system_of

# 108 settings. Those of Table 5.1 are among them (radius .5 .9, squash .1 .5, accept .5 .9, reject .1 .3 .7) and so are
# MATLAB's defaults (.5, 1.25, .5, .15); the rest fills the gaps.
RADII = (0.3, 0.5, 0.7, 0.9)
SQUASHES = (0.1, 0.5, 1.25)
ACCEPTS = (0.5, 0.9)
REJECTS = (0.1, 0.15, 0.3, 0.5, 0.7)


class Trial(NamedTuple):
    """A setting that was tried, with the number of rules and the error that it gives."""

    radius: float  # as a share of every column's range
    options: ClusteringOptions
    rules: int  # with more than the search's limit: one more than the limit, and not fitted
    rmse: tuple[float, ...]  # (outputs,) of the training data, in each output's unit; nan if not fitted
    error: float  # what is compared: the rmse, or with several outputs the root mean square of rmse / range
    rank: int  # of the parameters of the consequents, how many the samples determine; 0 if not fitted
    parameters: int


@dataclass(frozen=True)
class SearchResult:
    """All settings that were tried, in order: the radius varies slowest, the reject ratio fastest.

    Attributes:
        trials: Each setting with what came of it.
        wanted: The wanted number of rules.
        limit: The number of rules beyond which a setting is not fitted.
        fitted: Different sets of centers among the settings, each fitted once.
        outputs: The name and the unit of each output.
    """

    trials: tuple[Trial, ...]
    wanted: int
    limit: int
    fitted: int
    outputs: tuple[tuple[str, str], ...]

    @property
    def by_rules(self) -> dict[int, Trial]:
        """The best trial for each number of rules, in ascending order. Of equally good trials the first is taken."""
        best: dict[int, Trial] = {}
        for trial in self.trials:
            if not math.isnan(trial.error) and (
                trial.rules not in best or trial.error < best[trial.rules].error * (1 - 1e-9)
            ):
                best[trial.rules] = trial
        return dict(sorted(best.items()))

    @property
    def best(self) -> Trial:
        """The best trial with the wanted number of rules.

        Raises:
            IdentificationError: No trial has it; the message lists the numbers that were found.
        """
        found = self.by_rules
        if self.wanted not in found:
            raise IdentificationError(
                f"none of the {len(self.trials)} settings gives {self.wanted} rules; "
                f"found: {', '.join(map(str, found)) or f'none up to {self.limit}'}. Try other radii or squash factors"
            )
        return found[self.wanted]


def search_clusters(
    x: Any,
    y: Any,
    rules: int = 8,
    *,
    radii: Sequence[float] = RADII,
    squashes: Sequence[float] = SQUASHES,
    accepts: Sequence[float] = ACCEPTS,
    rejects: Sequence[float] = REJECTS,
    order: Literal[0, 1] = 1,
    ridge: float = 0.0,
    limit: int | None = None,
    input_names: Sequence[str] | None = None,
    output_names: Sequence[str] | None = None,
    input_units: Sequence[str] | None = None,
    output_units: Sequence[str] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> SearchResult:
    """Try every setting of subtractive clustering on samples.

    Combinations with reject > accept make no sense and are left out; the defaults make 108 settings. The system of a
    trial is ``identify(x, y, "subtractive", radius=trial.radius, options=trial.options, order=...)``.

    Args:
        x: The inputs (samples, inputs), in any units.
        y: The outputs (samples,) or (samples, outputs), in any units.
        rules: The wanted number of rules.
        radii: The radii to try, as shares of every column's range.
        squashes: The squash factors to try (see :class:`fuzzy.fitting.clustering.ClusteringOptions`).
        accepts: The accept ratios to try.
        rejects: The reject ratios to try.
        order: 1 for linear consequents, 0 for constants.
        ridge: See :func:`fuzzy.fitting.consequents.fit_consequents`.
        limit: A setting with more rules is not fitted; by default 30, or ``rules`` if that is more.
        input_names: The names of the inputs.
        output_names: The names of the outputs.
        input_units: The units of the inputs, which are labels.
        output_units: The units of the outputs, which are labels.
        progress: A function that is called with the numbers of settings done and in all, after each one.

    Returns:
        Every setting with the number of its rules and its error.

    Raises:
        ClusteringError: As of :func:`fuzzy.fitting.identification.identify`.
        IdentificationError: Likewise, and settings that make no search.
    """
    if isinstance(rules, bool) or not isinstance(rules, (int, np.integer)) or rules < 1:
        raise IdentificationError(f"rules must be a whole number >= 1, got {rules!r}")
    limit = max(rules, 30) if limit is None else limit
    if limit < rules:
        raise IdentificationError(f"limit ({limit}) must not be less than rules ({rules})")
    data = checked(x, y, input_names, output_names, input_units, output_units)
    choices = [ClusteringOptions(*each) for each in product(squashes, accepts, rejects) if each[2] <= each[1]]
    if not choices or not len(radii):
        raise IdentificationError("no setting to try: every radius, squash, accept and reject needs a value")
    both = np.concatenate([data.x, data.y], axis=1)
    span = (data.high - data.low)[len(data.inputs) :]
    trials: list[Trial] = []
    fits: dict[tuple[int, frozenset[int]], ConsequentFit] = {}
    for place, radius in enumerate(radii):
        first = densities(both, radius, ranges=data.ranges)
        for options in choices:
            found = select_centers(first, options, most=limit + 1)
            count = len(found.rows)
            if count > limit:
                unfitted = (math.nan,) * len(data.outputs)
                trials.append(Trial(radius, options, count, unfitted, math.nan, 0, 0))
            else:
                key = place, frozenset(found.rows.tolist())
                if key not in fits:
                    partition = cluster_partition(found.centers, found.sigma, len(data.inputs))
                    fits[key] = least_squares(system_of(partition, data, order=order), data.x, data.y, ridge)
                fit = fits[key]
                error = fit.rmse[0] if len(span) == 1 else np.sqrt(np.mean((fit.rmse / span) ** 2))
                rmse = tuple(fit.rmse.tolist())
                trials.append(Trial(radius, options, count, rmse, float(error), fit.rank, fit.parameters))
            if progress is not None:
                progress(len(trials), len(radii) * len(choices))
    return SearchResult(tuple(trials), int(rules), limit, len(fits), tuple(data.outputs))


def search_table(results: Mapping[str, SearchResult] | SearchResult) -> str:
    """The best settings as a table, as Table 5.1 of the thesis has them, with one column for each network.

    Args:
        results: A search, or several by name.

    Raises:
        IdentificationError: A search found no system with the wanted number of rules.
    """
    if isinstance(results, SearchResult):
        results = {"Fuzzy Network": results}
    best = {name: result.best for name, result in results.items()}
    lines = {
        "": list(best),
        "Rule Number": [str(trial.rules) for trial in best.values()],
        "Training Data Error": [" ".join(f"{value:.3e}" for value in trial.rmse) for trial in best.values()],
        "Radius": [f"{trial.radius:g}" for trial in best.values()],
        "Squash factor": [f"{trial.options.squash:g}" for trial in best.values()],
        "Accept ratio": [f"{trial.options.accept:g}" for trial in best.values()],
        "Reject ratio": [f"{trial.options.reject:g}" for trial in best.values()],
    }
    first = max(map(len, lines))
    widths = [max(len(cells[i]) for cells in lines.values()) for i in range(len(best))]
    return "\n".join(
        "  ".join([f"{label:<{first}}", *(f"{cell:>{w}}" for cell, w in zip(cells, widths, strict=True))]).rstrip()
        for label, cells in lines.items()
    )
