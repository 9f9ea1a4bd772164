"""From formation data to networks that drive the robots: cluster, train, write; thesis 5.2.2.

For each of the four outputs: subtractive clusters with the setting that an enumerative search finds best for the
wanted number of rules (Table 5.1), consequents by least squares, then learning (hybrid, 60 epochs, as in 5.2.2).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

import anfis
from fuzzy.errors import InputError
from fuzzy.files.fisfile import write_fis
from fuzzy.fitting.identification import identify
from fuzzy.fitting.search import SearchResult, Trial, search_clusters
from fuzzy.system import Sugeno
from robotics.laws.formation.leader_follower import INPUTS, OUTPUTS

_SPEEDS = {"v_l": "m/s", "w_l": "rad/s", "v_f": "m/s", "w_f": "rad/s"}
UNITS = {"x_l": "m", "y_l": "m", "theta_l": "rad", "dx": "m"} | _SPEEDS
SETTINGS = 108  # that the search tries
_AROUND = 2  # rules more or fewer than wanted, where no setting gives just so many


class FormationLearningError(InputError):
    """Data or options from which no formation networks can be learnt."""


@dataclass(frozen=True, eq=False)
class Learnt:
    """One network: how it was found, before and after learning."""

    output: str
    search: SearchResult
    trial: Trial  # the setting that was taken
    before: Sugeno  # clusters with consequents by least squares
    training: anfis.Training

    @property
    def after(self) -> Sugeno:
        """The trained network: the one of least checking error."""
        # Robots drive beyond the data at times; a network says less nonsense at its universe's edge than far outside.
        return replace(self.training.system, out_of_range="clip")


def learn_networks(
    names: Sequence[str],
    values: np.ndarray,
    check: np.ndarray | None = None,
    *,
    rules: int = 8,
    options: anfis.Options | None = None,
    advance: Callable[[], None] | None = None,
) -> list[Learnt]:
    """Learn v_l, w_l, v_f and w_f from a table ``values`` (samples, columns) with the columns ``names``.

    Inputs are those of x_l, y_l, theta_l and dx that the table has. ``check`` is a table with the same columns;
    ``advance`` is called after every setting of the search and every epoch: :func:`steps` times in all, unless
    training stops early. Raises FormationLearningError for a table without the columns.
    """
    return [
        learn_network(output, names, values, check, rules=rules, options=options, advance=advance) for output in OUTPUTS
    ]


def learn_network(
    output: str,
    names: Sequence[str],
    values: np.ndarray,
    check: np.ndarray | None = None,
    *,
    rules: int = 8,
    options: anfis.Options | None = None,
    advance: Callable[[], None] | None = None,
) -> Learnt:
    """Learn the network of one ``output``; otherwise as :func:`learn_networks`."""
    options = options or anfis.Options(epochs=60)
    columns = {name: k for k, name in enumerate(names)}
    inputs = [name for name in INPUTS if name in columns]
    if not inputs or not set(OUTPUTS) <= set(columns):
        raise FormationLearningError(
            f"formation data have inputs among {', '.join(INPUTS)} and the outputs {', '.join(OUTPUTS)}; "
            f"got the columns {', '.join(names)}"
        )
    step = advance or (lambda: None)
    x, y = values[:, [columns[name] for name in inputs]], values[:, columns[output]]
    search = search_clusters(x, y, rules, input_names=inputs, output_names=[output], progress=lambda *_: step())
    trial = nearest_trial(search, rules)
    before = identify(
        x,
        y,
        "subtractive",
        radius=trial.radius,
        options=trial.options,
        input_names=inputs,
        output_names=[output],
        input_units=[UNITS[name] for name in inputs],
        output_units=[UNITS[output]],
        name=output,
    )
    held = None if check is None else (check[:, [columns[n] for n in inputs]], check[:, columns[output]])
    training = anfis.train(before, x, y, options, check=held, callback=lambda _: step())
    return Learnt(output, search, trial, before, training)


def steps(epochs: int) -> int:
    """How many times :func:`learn_networks` calls ``advance`` if no training stops early."""
    return len(OUTPUTS) * (SETTINGS + epochs + 1)


def nearest_trial(search: SearchResult, rules: int) -> Trial:
    """The best setting that gives ``rules`` rules, or as near as any setting comes. Raises FormationLearningError."""
    best = search.by_rules
    near = [n for n in best if abs(n - rules) <= _AROUND]
    if not near:
        raise FormationLearningError(
            f"no setting gives {rules} rules or {_AROUND} more or fewer; they give {', '.join(map(str, best))}"
        )
    return best[min(near, key=lambda n: (abs(n - rules), best[n].error))]


def write_networks(networks: Sequence[Learnt], folder: str | Path) -> Path:
    """Write each trained network to ``folder``/<output>.fis; the folder comes back. Raises OSError."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    for network in networks:
        write_fis(network.after, folder / f"{network.output}.fis")
    return folder
