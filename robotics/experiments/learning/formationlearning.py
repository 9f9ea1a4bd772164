"""Learning from formation data the networks that drive the robots: cluster, train, write; thesis 5.2.2.

Each of the four outputs has its network: subtractive clusters with the setting that an enumerative search finds best
for the wanted number of rules (Table 5.1), consequents by least squares, then learning (hybrid, 60 epochs).
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

_INPUT_UNITS = ("m", "m", "rad", "m", "rad", "1/m")
UNITS = dict(zip(INPUTS + OUTPUTS, (*_INPUT_UNITS, "m/s", "rad/s", "m/s", "rad/s"), strict=True))
# What does not concern a robot: where the path goes where the others are
_IGNORED = {"v_l": {"kappa_f"}, "w_l": {"kappa_f"}, "v_f": {"alpha_l"}, "w_f": {"alpha_l"}}
_TITLES = {
    "v_l": "Formation: the leader's speed v_l",
    "w_l": "Formation: the leader's turn rate w_l",
    "v_f": "Formation: the followers' speed v_f",
    "w_f": "Formation: the followers' turn rate w_f",
}
SETTINGS = 108  # number of settings that the search tries
_AROUND = 2  # the most rules more or fewer than wanted that a setting may give


class FormationLearningError(InputError):
    """Data or options from which no formation networks can be learnt."""


@dataclass(frozen=True, eq=False)
class Learnt:
    """One network: the search for its clusters, and the system before and after learning."""

    output: str
    search: SearchResult
    trial: Trial  # the setting that was taken
    before: Sugeno  # the clusters, with consequents by least squares
    training: anfis.Training

    @property
    def after(self) -> Sugeno:
        """The trained network, the one with the least checking error."""
        # Robots drive beyond the data at times, where a network is more sensible at its universe's edge than outside.
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
    """Learn the networks of v_l, w_l, v_f and w_f from a table.

    Args:
        names: The table's columns; those of x_l, y_l, theta_l and dx that it has are the inputs, for the leader's
            networks also alpha_l, for the followers' kappa_f.
        values: The table (samples, columns), in m, rad, m/s and rad/s.
        check: A checking table with the same columns.
        rules: The wanted number of rules; the nearest that a setting gives is taken.
        options: How to learn, by default 60 epochs of hybrid learning.
        advance: Called after every setting of the search and every epoch: :func:`steps` times in all, unless training
            stops early.

    Raises FormationLearningError for a table without these columns, or where no setting gives about that many rules.
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
    """Learn the network of one ``output``; the other arguments and errors are those of :func:`learn_networks`."""
    options = options or anfis.Options(epochs=60)
    columns = {name: k for k, name in enumerate(names)}
    inputs = [name for name in INPUTS if name in columns and name not in _IGNORED[output]]
    if not inputs or not set(OUTPUTS) <= set(columns):
        raise FormationLearningError(
            f"formation data have inputs among {', '.join(INPUTS)} and the outputs {', '.join(OUTPUTS)}; "
            f"got the columns {', '.join(names)}"
        )
    step = advance or (lambda: None)
    x, y = values[:, [columns[name] for name in inputs]], values[:, columns[output]]
    ridge = options.ridge  # the same throughout, so that the history begins where the clusters end
    search = search_clusters(
        x, y, rules, ridge=ridge, input_names=inputs, output_names=[output], progress=lambda *_: step()
    )
    trial = nearest_trial(search, rules)
    before = identify(
        x,
        y,
        "subtractive",
        radius=trial.radius,
        options=trial.options,
        ridge=ridge,
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
    """The number of times that :func:`learn_networks` calls ``advance`` if no training stops early."""
    return len(OUTPUTS) * (SETTINGS + epochs + 1)


def nearest_trial(search: SearchResult, rules: int) -> Trial:
    """The best setting that gives ``rules`` rules, or else the nearest number. Raises FormationLearningError."""
    best = search.by_rules
    near = [n for n in best if abs(n - rules) <= _AROUND]
    if not near:
        raise FormationLearningError(
            f"no setting gives {rules} rules or {_AROUND} more or fewer; they give {', '.join(map(str, best))}"
        )
    return best[min(near, key=lambda n: (abs(n - rules), best[n].error))]


def write_networks(networks: Sequence[Learnt], folder: str | Path, data: str = "") -> Path:
    """Write each trained network to ``folder``/<output>.fis and return the folder. Raises OSError.

    ``data`` is the name of the file that was learnt from, for the comment at the head of each file.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    for network in networks:
        comment = f"{_TITLES[network.output]}, learnt{f' from {data}' if data else ''}."
        write_fis(network.after, folder / f"{network.output}.fis", comment)
    return folder
