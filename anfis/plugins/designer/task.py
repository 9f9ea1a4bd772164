"""A training as a task of its own process: what to learn from what, reported while it runs, stopped when asked.

The learning is :func:`anfis.train` in a process that knows nothing of the page, a
:class:`fuzzy.plugins.designer.longtask.TaskProcess`: it tells how each epoch went, and ends with the best so far when
it is told to stop.
"""

import time
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from anfis.methods.catalogue import METHODS
from fuzzy.errors import InputError, quoted
from fuzzy.naming import check_known
from fuzzy.plugins.designer.columns import LoadedTable, matching
from fuzzy.plugins.designer.longtask import Report
from fuzzy.quantity import check_quantities, quantity, whole
from fuzzy.system import Sugeno

if TYPE_CHECKING:
    from anfis.training import Training

STARTS = ("present", "subtractive", "grid")
_RARELY = 0.3  # s between two systems that are told of


class TrainingTaskError(InputError):
    """A task that cannot be learnt. The message names the choice and what is accepted."""


class Ask(NamedTuple):
    """One choice that a generator of data asks for, before it makes them."""

    name: str
    title: str
    options: tuple[tuple[str, str], ...]  # each value with its words; none: a whole number >= 1
    value: str  # what is chosen at first


class Generator(NamedTuple):
    """A source of data other than files. ``make`` can be pickled, and may take seconds.

    One that asks is given the folder that is opened and what was chosen, by name: ``make(folder, chosen)``; ``asks``
    can be pickled too.
    """

    name: str
    title: str
    make: Callable[..., LoadedTable]
    asks: Callable[[Path], tuple[Ask, ...]] | None = None  # of the folder that is opened


@dataclass(frozen=True, kw_only=True)
class TrainingTask:
    """One training as the page chose it: the data, the start and the options.

    Raises TrainingTaskError for choices that cannot be learnt from.
    """

    x: np.ndarray = field(repr=False)  # (samples, inputs)
    y: np.ndarray = field(repr=False)  # (samples, outputs)
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    input_units: tuple[str, ...] | None = None  # of a new system's variables
    output_units: tuple[str, ...] | None = None
    start: Literal["present", "subtractive", "grid"] = "present"
    present: Sugeno | None = None  # the system to start from, for "present"
    radius: float = quantity(0.5, "1", above=0, most=2, doc="Subtractive: of a cluster, as a share of the ranges.")
    mfs: int = whole(3, least=2, most=20, doc="Grid: terms an input.")
    method: str = "hybrid"  # a name in anfis.METHODS
    epochs: int = whole(60, least=0, most=100_000, doc="Epochs.")
    goal: float = quantity(0.0, "1", least=0, doc="RMSE, in the outputs' unit.")
    share: float = quantity(0.2, "1", least=0, most=0.8, doc="Of the samples, for checking; 0: none.")
    seed: int = whole(0, least=0, most=2**32 - 1, doc="Of the choice of checking samples.")
    name: str = "learnt"

    def __post_init__(self) -> None:
        for what, value, known in (("start", self.start, STARTS), ("method", self.method, METHODS)):
            check_known(value, known, what, TrainingTaskError)
        check_quantities(self, TrainingTaskError)
        if self.start == "present" and self.present is None:
            raise TrainingTaskError("to start from the present system there must be one")
        if not self.inputs or not self.outputs:
            raise TrainingTaskError("at least one column must be an input and one an output")
        count = len(self.x)
        if count < 2 or self.checking == count:
            rows = "1 sample" if count == 1 else f"{count} samples"
            raise TrainingTaskError(f"{rows}, {self.checking} of them for checking, leave none to learn from")

    @property
    def checking(self) -> int:
        """How many samples are for checking."""
        return round(self.share * len(self.x))


def task_of(
    data: LoadedTable, columns: dict[str, str], present: Sugeno | None, *, skip_bad: bool = False, **settings: Any
) -> TrainingTask:
    """Make the task of learning from the table ``data``.

    ``columns`` says which column is which: to start from the ``present`` system, the column of every variable; for a
    new system, the role of every column ("input", "output" or "unused"). With ``skip_bad`` samples without a number in
    one of these columns are left out. ``settings`` are the other fields of
    :class:`TrainingTask`. Raises TrainingTaskError.
    """
    names = chosen_columns(data, columns, present, settings.get("start", "present"))
    n = len(names[0])
    flat = [*names[0], *names[1]]
    bad = data.lacking(flat)
    if bad.any() and not skip_bad:
        raise TrainingTaskError(f"{data.name}: {data.lack(flat)}; leave such rows out, or choose other columns")
    values = data.values[~bad][:, [data.names.index(name) for name in flat]]
    if settings.get("start", "present") == "present":
        assert present is not None
        called = [v.name for v in (*present.inputs, *present.outputs)]
    else:
        called = [data.variables[data.names.index(name)] if data.variables else name for name in flat]
        twice = next((name for name in called if called.count(name) > 1), None)
        if twice is not None:
            raise TrainingTaskError(
                f"{data.name}: two chosen columns are called {quoted(twice)}; give each a name of its own in the header"
            )
    units = [data.unit(name) for name in flat]
    given = ("x", "y", "inputs", "outputs", "input_units", "output_units", "present")
    known = {name for name in TrainingTask.__dataclass_fields__ if name not in given}
    for name in settings:
        check_known(name, known, "setting", TrainingTaskError)
    return TrainingTask(
        x=values[:, :n],
        y=values[:, n:],
        inputs=tuple(called[:n]),
        outputs=tuple(called[n:]),
        input_units=tuple(units[:n]),
        output_units=tuple(units[n:]),
        present=present,
        **settings,
    )


def chosen_columns(
    data: LoadedTable, columns: dict[str, str], present: Sugeno | None, start: str
) -> tuple[list[str], list[str]]:
    """The columns that are inputs and outputs by a choice as :func:`task_of` takes it. Raises TrainingTaskError."""
    if start == "present":
        if present is None:
            raise TrainingTaskError("to start from the present system there must be one")
        chosen = [[v.name for v in present.inputs], [v.name for v in present.outputs]]
        lacking = [name for names in chosen for name in names if columns.get(name) not in data.names]
        if lacking:
            raise TrainingTaskError(f"no column of {data.name} is chosen for {', '.join(lacking)}")
        inputs, outputs = ([columns[name] for name in group] for group in chosen)
    else:
        inputs, outputs = ([n for n in data.names if columns.get(n) == role] for role in ("input", "output"))
        if not inputs or not outputs:
            raise TrainingTaskError("at least one column must be an input and one an output")
    flat = [*inputs, *outputs]
    twice = next((n for n in flat if flat.count(n) > 1), None)
    if twice is not None:
        raise TrainingTaskError(f"the column {quoted(twice)} is chosen twice")
    return inputs, outputs


def guessed(data: LoadedTable, present: Sugeno | None) -> dict[str, str]:
    """Guess which column is which, in the form that :func:`task_of` takes.

    For a ``present`` system, a variable's column is the one of its name, or the one in its place if no name fits and
    there are as many columns as variables. For a new system (None), the last column is the output, unless the table
    says how many are inputs; a column without a name or without numbers is not used.
    """
    usable = data.usable
    if present is None:
        first = data.inputs or len(usable) - 1
        roles = {name: "input" if k < first else "output" for k, name in enumerate(usable)}
        return {name: roles.get(name, "unused") for name in data.names}
    return matching(data, [v.name for v in (*present.inputs, *present.outputs)])


def split(count: int, checking: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Split ``count`` samples at random, by ``seed``: the sorted indices to learn from, and ``checking`` others."""
    order = np.random.default_rng(seed).permutation(count)
    return np.sort(order[checking:]), np.sort(order[:checking])


def starting_system(task: TrainingTask) -> Sugeno:
    """Make the system that training starts from, of the samples to learn from only.

    Raises an InputError for data that cannot be clustered, and for a present system without rules.
    """
    rows, _ = split(len(task.x), task.checking, task.seed)
    if task.start == "present":
        assert task.present is not None
        if not task.present.rules:
            raise TrainingTaskError(
                f"{task.present.name} has no rule in force, so there is nothing to learn: start from clusters"
            )
        return task.present
    from fuzzy.fitting.identification import identify

    settings: dict[str, Any] = {"radius": task.radius} if task.start == "subtractive" else {"mfs": task.mfs}
    return identify(
        task.x[rows],
        task.y[rows],
        task.start,
        input_names=task.inputs,
        output_names=task.outputs,
        input_units=task.input_units,
        output_units=task.output_units,
        name=task.name,
        **settings,
    )


def learn(task: TrainingTask, report: Report) -> "Training":
    """Do the task. ``report(what, about)`` is called as it proceeds, and returns False to stop with the best so far.

    It is called with "start" and the starting system, "warning" and a sentence, "epoch" and an
    :class:`anfis.state.Epoch`, and at most every 0.3 s with "best" and the best system so far, where that is another
    one than before. Raises an InputError for data and options that cannot be learnt.
    """

    def tell(message: Warning | str, *_: Any, **__: Any) -> None:
        report("warning", str(message))

    rows, held = split(len(task.x), task.checking, task.seed)
    with warnings.catch_warnings():
        warnings.simplefilter("always")
        warnings.showwarning = tell
        fis = starting_system(task)
        report("start", fis)
        from anfis.methods.options import Options
        from anfis.training import train

        best = _BestSoFar(lambda system: report("best", replace(system, out_of_range=fis.out_of_range)))

        def epoch(row: Any) -> bool:
            best.tell()
            return report("epoch", row)

        # A value outside its universe is no reason to be asked again in every epoch.
        quiet = replace(fis, out_of_range="ignore") if fis.out_of_range == "warn" else fis
        result = train(
            quiet,
            task.x[rows],
            task.y[rows],
            Options(method=task.method, epochs=task.epochs, goal=task.goal),
            check=(task.x[held], task.y[held]) if len(held) else None,
            callback=epoch,
            improved=best.note,
        )
    systems = {
        name: replace(getattr(result, name), out_of_range=fis.out_of_range) for name in ("system", "least_train")
    }
    return replace(result, **systems)


class _BestSoFar:
    """Tells of the best system so far, rarely: to make and send it takes longer than an epoch."""

    def __init__(self, say: Callable[[Sugeno], Any]) -> None:
        self._say, self._made = say, -_RARELY
        self._waiting: Callable[[], Sugeno] | None = None

    def note(self, system: Callable[[], Sugeno]) -> None:
        """Note that there is a better one."""
        self._waiting = system

    def tell(self) -> None:
        """Tell of the best one, if it is new and the last time is long enough ago."""
        if self._waiting is not None and time.monotonic() - self._made >= _RARELY:
            self._say(self._waiting())
            self._waiting, self._made = None, time.monotonic()


class TrainOutcome(NamedTuple):
    """The result of a finished training, without what would need torch to be read."""

    system: Sugeno  # the best
    best: int  # its epoch
    stopped: str  # why: "epochs", "goal", "callback" (asked to), "converged", "diverged"
    parameters: int  # how many numbers were learnt


def train_task(task: TrainingTask, report: Report) -> TrainOutcome:
    """Do a task as :class:`fuzzy.plugins.designer.longtask.TaskProcess` wants it: plain types, which need no torch."""

    def plainly(what: str, about: Any) -> bool:
        return report(what, tuple(about) if what == "epoch" else about)

    try:
        result = learn(task, plainly)
    except MemoryError:
        raise TrainingTaskError("the training needs more memory than there is: fewer rules or samples") from None
    return TrainOutcome(result.system, result.best, result.stopped, result.parameters)


_FEW, _GROWN, _APART = 5.0, 1.2, 2.0  # samples a parameter; checking errors over the least, and over the training error


def in_words(history: Sequence[Sequence[float]], parameters: int, samples: int) -> list[str]:
    """What the numbers of a training say, and what to do.

    Args:
        history: Of each epoch its number, the training error and the checking error, not-a-number where there is none.
        parameters: How many numbers were learnt.
        samples: From how many training samples.
    """
    said = []
    if samples < _FEW * parameters:
        said.append(
            f"{parameters} numbers are learnt from {samples} samples, {samples / parameters:.2g} for each: few. Fewer "
            "terms, clusters of a larger radius, or more rows."
        )
    checked = [row for row in history if isfinite(row[2])]
    if not checked:
        return said
    best, last = min(checked, key=lambda row: row[2]), checked[-1]
    if last[2] > _GROWN * best[2]:
        said.append(
            f"From epoch {best[0]:.0f} on the checking error grows, to {last[2] / best[2]:.2g} times its least: what "
            f"is learnt then is the noise of the samples. *Take the best* takes epoch {best[0]:.0f}."
        )
    if best[1] > 0 and best[2] > _APART * best[1]:
        said.append(
            f"At its best the checking error is {best[2] / best[1]:.2g} times the training error: the system fits its "
            "own samples better than others. Fewer terms, or more rows."
        )
    return said
