"""Learning from formation data the networks that drive the robots: cluster, train, write; thesis 5.2.2.

Each output has its network: subtractive clusters with the setting that an enumerative search finds best for the wanted
number of rules (Table 5.1), consequents by least squares, then learning (hybrid, 60 epochs).

Tables come in two forms. The thesis's have the outputs v_l, w_l, v_f and w_f. Those of a scenario
(:mod:`robotics.plugins.learning.scenariodata`) have v_N and w_N of each robot N, which learn from the columns of
their own robot, those that end in _N. An input without which the output scatters no more (Gamma test) is left out: in
clusters an input that says nothing costs rules.
"""

import re
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import inf
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import anfis
from fuzzy.errors import InputError
from fuzzy.files.fisfile import write_fis
from fuzzy.files.table import Table, open_table
from fuzzy.fitting.clustering import DataWarning
from fuzzy.fitting.identification import identify
from fuzzy.fitting.search import SearchResult, Trial, search_clusters
from fuzzy.naming import check_known
from fuzzy.system import Sugeno
from robotics.laws.formation.leader_follower import FORMATION_INPUTS, FORMATION_OUTPUTS
from robotics.laws.rules.quantities import quantity_of
from robotics.plugins.learning.datatable import DataTable, Samples
from robotics.plugins.learning.formationdata import FormationRecipe, formation_data
from robotics.plugins.learning.scatter import NEIGHBOURS, scatter
from robotics.studies.executors import processes
from robotics.studies.pieces import run_pieces

_INPUT_UNITS = ("m", "m", "rad", "m", "rad", "1/m")
UNITS = dict(zip(FORMATION_INPUTS + FORMATION_OUTPUTS, (*_INPUT_UNITS, "m/s", "rad/s", "m/s", "rad/s"), strict=True))
# What does not concern a robot: where the path goes where the others are
_IGNORED = {"v_l": {"kappa_f"}, "w_l": {"kappa_f"}, "v_f": {"alpha_l"}, "w_f": {"alpha_l"}}
FRESH = 20  # sets
_SETTINGS = 108  # number of settings that the search tries
_OWN_OUTPUT = re.compile(r"([vw])_([1-9]\d*)")
_OF_ROBOT = re.compile(r"_([1-9]\d{0,8})$")
_WORSE, _LEAST = 1.05, 0.01  # times the scatter, plus that share of the output's spread: what matters adds more
_AROUND = 2  # the most rules more or fewer than wanted that a setting may give


class FormationLearningError(InputError):
    """Data or options from which no formation networks can be learnt."""


AS_WELL = 1.02  # times an error: no more is as good


@dataclass(frozen=True, eq=False)
class Learnt:
    """One network: the search for its clusters, and the system before and after learning.

    Attributes:
        output: What it says: v_l, w_l, v_f, w_f, or v_N and w_N of robot N.
        search: All settings that were tried.
        trial: The setting that was taken.
        before: The clusters, with consequents by least squares.
        training: The learning.
    """

    output: str
    search: SearchResult
    trial: Trial  # the setting that was taken
    before: Sugeno  # the clusters, with consequents by least squares
    training: anfis.Training

    @property
    def fewer(self) -> Trial | None:
        """The setting of the fewest rules that do as well after clustering, where they are fewer than those taken."""
        best = next(t for t in self.search.by_rules.values() if t.error <= AS_WELL * self.trial.error)
        return best if best.rules < self.trial.rules else None

    @property
    def remarks(self) -> list[str]:
        """What is to be said of the learning, and of the number of rules, in sentences."""
        less = self.fewer
        if less is None:
            return self.training.remarks
        said = f"{less.rules} rules do as well after clustering: RMSE {less.error:.3g}, and {self.trial.error:.3g} with"
        return [*self.training.remarks, f"{said} {self.trial.rules}"]

    @property
    def after(self) -> Sugeno:
        """The trained network, the one with the least checking error."""
        # Robots drive beyond the data at times, where a network is more sensible at its universe's edge than outside.
        return replace(self.training.system, out_of_range="clip")


@dataclass(frozen=True)
class Errors:
    """Errors of one network, RMSE in its output's unit; not-a-number where they are not known."""

    network: Learnt
    clustering: float  # over the training samples, before learning
    training: float
    checking: float
    range: float  # of the output over the training samples
    scatter: tuple[float, float, float]  # of the output at equal inputs, Gamma test: mean, least, greatest
    outside: float  # share of the checking samples with an input outside those of the training samples

    @property
    def last(self) -> float:
        """The error that counts: over the checking samples if there are any."""
        return self.checking if np.isfinite(self.checking) else self.training


def outputs_of(names: Sequence[str]) -> tuple[str, ...]:
    """The outputs of a table with the columns ``names``: the thesis's four, or v and w of each robot.

    Raises FormationLearningError where there are neither.
    """
    if set(FORMATION_OUTPUTS) <= set(names):
        return FORMATION_OUTPUTS
    own = {(int(found[2]), found[1]) for name in names if (found := _OWN_OUTPUT.fullmatch(name))}
    wanted = [(robot, output) for robot in range(1, 1 + max((r for r, _ in own), default=0)) for output in ("v", "w")]
    if not own or own != set(wanted):
        raise FormationLearningError(
            f"formation data have inputs among {', '.join(FORMATION_INPUTS)} and the outputs "
            f"{', '.join(FORMATION_OUTPUTS)}, or the outputs v_1, w_1, v_2, w_2 ... and each robot's inputs, "
            f"named with its number; got the columns {', '.join(names)}"
        )
    return tuple(f"{output}_{robot}" for robot, output in wanted)


def formation_table(path: str | Path, columns: Sequence[str] | None = None, *, skip_bad: bool = False) -> Table:
    """Read the columns of a file of formation data that networks are learnt from; what others hold does not matter.

    Args:
        path: The file, with a header of names, with or without units: "v_l" or "v_l [m/s]".
        columns: The columns, for checking data those of the data; by default the inputs and outputs that it has.
        skip_bad: Leave out rows that have no number in one of them.

    Raises DataError for a file that cannot be read, FormationLearningError for one without these columns.
    """
    text = open_table(path)
    if not text.headed:
        raise FormationLearningError(f"{path}: a header line with the columns' names is needed")
    if columns is None:
        names = [column.name for column in text.columns]
        robots = {robot_of(output) for output in outputs_of(names)}
        numbers = {name: _OF_ROBOT.search(name) for name in names}
        own = {name for name, found in numbers.items() if found is not None and int(found[1]) in robots}
        columns = [name for name in names if name in own or name in FORMATION_INPUTS or name in FORMATION_OUTPUTS]
    return text.numbers(columns, skip_bad)


def robot_of(output: str) -> int:
    """The number of the robot that ``output`` belongs to, from 1; 0: it is one of the thesis's four."""
    found = _OWN_OUTPUT.fullmatch(output)
    return int(found[2]) if found else 0


def input_columns(fis: Sugeno) -> list[str]:
    """The columns of a table that hold the inputs of ``fis``, a network of one output: robot N's end in _N."""
    robot = robot_of(fis.outputs[0].name)
    return [f"{v.name}_{robot}" if robot else v.name for v in fis.inputs]


def learn_networks(
    names: Sequence[str],
    values: np.ndarray,
    check: np.ndarray | None = None,
    *,
    rules: int = 8,
    options: anfis.Options | None = None,
    advance: Callable[[], None] | None = None,
    jobs: int = 1,
) -> list[Learnt]:
    """Learn all networks of a table: v_l, w_l, v_f and w_f, or v_N and w_N of each robot N.

    Args:
        names: The table's columns. For the thesis's four those of x_l, y_l, theta_l and dx that it has are the inputs,
            for the leader's networks also alpha_l, for the followers' kappa_f; for robot N all that end in _N.
        values: The table (samples, columns), in m, rad, m/s and rad/s.
        check: A checking table (samples, columns) with the same columns.
        rules: The wanted number of rules; the nearest that a setting gives is taken.
        options: How to learn, by default 60 epochs of hybrid learning.
        advance: Called after every setting of the search and every epoch: :func:`steps` times in all, unless training
            stops early; with several jobs for a whole network at once.
        jobs: The number of processes.

    Returns:
        The networks, in the order of the outputs.

    Raises:
        FormationLearningError: A table without these columns, or where no setting gives about that many rules.
        WorkerError: A process fails.
    """
    outputs, options, step = outputs_of(names), options or anfis.Options(epochs=60), advance or (lambda: None)
    one = partial(learn_network, names=names, values=values, check=check, rules=rules, options=options)
    if jobs == 1:
        return [one(output, advance=advance) for output in outputs]
    found = {}
    with processes(min(jobs, len(outputs)), [__name__]) as workers:
        for output, network in run_pieces(one, outputs, workers, called=lambda output: f"the network of {output}"):
            found[output] = network
            for _ in range(steps(options.epochs, 1)):
                step()
    return [found[output] for output in outputs]


def learn_network(
    output: str,
    names: Sequence[str],
    values: np.ndarray,
    check: np.ndarray | None = None,
    *,
    rules: int = 8,
    options: anfis.Options,
    advance: Callable[[], None] | None = None,
) -> Learnt:
    """Learn the network of one ``output``; the other arguments and errors are those of :func:`learn_networks`."""
    columns = {name: k for k, name in enumerate(names)}
    check_known(output, outputs_of(names), "output", FormationLearningError)
    robot = robot_of(output)
    if robot:
        inputs = _own_inputs(output, names, values)
        called = [name.removesuffix(f"_{robot}") for name in inputs]  # as the robot's quantities are
        input_units = [quantity_of(name, "the table").unit for name in called]
        output_unit = UNITS[f"{output[0]}_l"]
    else:
        inputs = called = [name for name in FORMATION_INPUTS if name in columns and name not in _IGNORED[output]]
        input_units, output_unit = [UNITS[name] for name in inputs], UNITS[output]
    if not inputs:
        raise FormationLearningError(
            f"{output} has no inputs; formation data have some among {', '.join(FORMATION_INPUTS)}, or those of robot "
            f"N end in _N; got the columns {', '.join(names)}"
        )
    step = advance or (lambda: None)
    x, y = values[:, [columns[name] for name in inputs]], values[:, columns[output]]
    how: dict[str, Any] = {"input_names": called, "output_names": [output], "output_units": [output_unit]}
    how["ridge"] = options.ridge  # the same throughout, so that the history begins where the clusters end
    search = search_clusters(x, y, rules, progress=lambda *_: step(), **how)
    # Of one or two inputs wide clusters are few and narrow ones many: there may be nothing about the wanted number
    trial = nearest_trial(search, rules, around=inf if robot else _AROUND)
    with warnings.catch_warnings():
        if robot:  # where wide clusters overlap, the solution of least norm is where training begins
            warnings.simplefilter("ignore", DataWarning)
        how |= {"radius": trial.radius, "options": trial.options, "input_units": input_units, "name": output}
        before = identify(x, y, "subtractive", **how)
    held = None if check is None else (check[:, [columns[n] for n in inputs]], check[:, columns[output]])
    training = anfis.train(before, x, y, options, check=held, callback=lambda _: step())
    return Learnt(output, search, trial, before, training)


def _own_inputs(output: str, names: Sequence[str], values: np.ndarray) -> list[str]:
    """The columns of the robot of ``output`` without which this would scatter more.

    Columns are left out one by one, that which adds least to the scatter first; a constant one says nothing anyway.
    """
    columns = {name: k for k, name in enumerate(names)}
    ending = f"_{robot_of(output)}"
    own = [n for n in names if n.endswith(ending) and not _OWN_OUTPUT.fullmatch(n)]
    kept = [n for n in own if np.ptp(values[:, columns[n]]) > 0]
    if len(values) <= NEIGHBOURS:  # too few rows to tell
        return kept
    y = values[:, columns[output]]

    def spread(inputs: Sequence[str]) -> float:
        return float(scatter(values[:, [columns[n] for n in inputs]], y, draws=1, share=1.0).rms[0])

    enough = _WORSE * spread(kept) + _LEAST * float(np.std(y)) if kept else 0.0
    while len(kept) > 1:
        least, without = min((spread([k for k in kept if k != n]), n) for n in kept)
        if least > enough:
            break
        kept.remove(without)
    return kept


def steps(epochs: int, outputs: int = len(FORMATION_OUTPUTS)) -> int:
    """The number of times that :func:`learn_networks` calls ``advance`` if no training stops early."""
    return outputs * (_SETTINGS + epochs + 1)


def nearest_trial(search: SearchResult, rules: int, around: float = _AROUND) -> Trial:
    """The best setting that gives ``rules`` rules, or else the nearest number.

    Raises FormationLearningError where that is more than ``around`` off.
    """
    best = search.by_rules
    near = [n for n in best if abs(n - rules) <= around]
    if not near:
        raise FormationLearningError(
            f"no setting gives {rules} rules or {around:g} more or fewer; they give {', '.join(map(str, best))}"
        )
    return best[min(near, key=lambda n: (abs(n - rules), best[n].error))]


def write_networks(networks: Sequence[Learnt], folder: str | Path, data: str = "") -> Path:
    """Write each trained network to ``folder``/<output>.fis. Raises OSError.

    Args:
        networks: What :func:`learn_networks` gives.
        folder: The folder; it is made where there is none.
        data: The name of the file that was learnt from, for the comment at the head of each file.

    Returns:
        The folder.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    for network in networks:
        output, whose = network.output, {"l": "the leader's ", "f": "the followers' "}.get(network.output[2:], "")
        title = f"{whose or 'the '}{'speed' if output[0] == 'v' else 'turn rate'} {output}"
        title += "" if whose else f" of robot {robot_of(output)}"
        comment = f"Formation: {title}, learnt{f' from {data}' if data else ''}."
        write_fis(network.after, folder / f"{output}.fis", comment)
    return folder


# Errors over sets of formation data drawn afresh: evidence on learning that does not rest on one draw. The literal set
# has nothing random in it: its errors are exact numbers, and there is nothing to draw. ------------------------------


class FreshErrors(NamedTuple):
    """RMSE of one output, in its unit, over the sets; every field is (sets,)."""

    clustering: np.ndarray  # training error of each set's own clusters, with consequents by least squares
    learnt: np.ndarray  # of the network learnt, on each set
    rules: np.ndarray  # how many rules the setting gives on each set


def fresh_errors(networks: Sequence[Learnt], recipe: FormationRecipe, sets: int = FRESH) -> dict[str, FreshErrors]:
    """Measure networks, and the setting of their clusters, on sets of ``recipe`` that are drawn afresh; by output.

    The first set is that of ``recipe``'s own seed, the next those of the seeds that follow. On each one the clusters
    are found again with the setting that the search took for the network; the search and the epochs are not repeated.

    Args:
        networks: The networks, as :func:`learn_networks` returns them.
        recipe: What the networks were learnt from, of the kind "well-posed".
        sets: The number of sets.
    """
    errors: dict[str, list[tuple[float, float, int]]] = {network.output: [] for network in networks}
    for k in range(sets):
        table = formation_data(replace(recipe, seed=recipe.seed + k))
        for network in networks:
            x, y = columns_of(network.after, table)
            trial = network.trial
            again = identify(x, y, "subtractive", radius=trial.radius, options=trial.options)
            errors[network.output].append((_rmse(again, x, y), _rmse(network.after, x, y), len(again.rules)))
    return {output: FreshErrors(*np.transpose(rows)) for output, rows in errors.items()}


def columns_of(fis: Sugeno, table: DataTable | Samples) -> tuple[np.ndarray, np.ndarray]:
    """The inputs (samples, inputs) and the output (samples,) of ``fis``, of one output, in ``table``, by name."""
    inputs = [table.names.index(name) for name in input_columns(fis)]
    return table.values[:, inputs], table.values[:, table.names.index(fis.outputs[0].name)]


def _rmse(fis: Sugeno, x: np.ndarray, y: np.ndarray) -> float:
    return float(np.sqrt(np.mean((fis(x)[:, 0] - y) ** 2)))
