"""Training: data in, history and the best systems out. The one place that loops over epochs.

What the step of an epoch does is the method's, see :mod:`anfis.methods.catalogue`; all of them go through the one
inference of :mod:`fuzzy.inference`.
"""

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from anfis.accuracy import total_rmse
from anfis.checkpoint import dump, fingerprint_of, restore, save
from anfis.data import DataError, DataWarning, SampleArrays, samples
from anfis.methods.method import LearningProblem, Method, make_method
from anfis.methods.options import Options, TrainingError
from anfis.point import Point
from anfis.state import Epoch, TrainingState
from fuzzy.detached import detached
from fuzzy.errors import quoted
from fuzzy.extras import needed
from fuzzy.shown import shown
from fuzzy.system import Sugeno

if TYPE_CHECKING:
    from anfis.compiled.network import CompiledNetwork
    from anfis.network import Network
    from fuzzy import Type2Sugeno

_BLOCK = 65_536  # samples held at a time
_NEGLIGIBLE = 1e-6  # of the outputs' spread: a difference of errors below it is none

UNLIKE = 1.5  # checking error over training error, beyond which it is remarked


@dataclass(frozen=True, eq=False)
class Training:
    """The result of a training: the best systems, the errors on the way, why it stopped, and a state to go on from.

    Attributes:
        system: The system of least checking error if there are checking data (as MATLAB's chkFIS), else of least
            training error.
        least_train: The system of least training error. Both are of type 2 if the one to start from is.
        history: An entry an epoch, from the system as it was.
        best: The epoch of ``system``.
        stopped: Why it ended: "epochs", "goal", "patience", "interrupted", "callback", "converged" or "diverged".
        options: How it was trained.
        parameters: How many numbers were learnt.
        rmse: Of ``system`` as its file holds it, on the training data, over samples and outputs, in the outputs' unit.
        check_rmse: Likewise on the checking data; not-a-number without.
        state: To resume from, with :func:`train`'s ``resume``.
    """

    system: Any
    least_train: Any
    history: tuple[Epoch, ...]
    best: int
    stopped: str
    options: Options
    parameters: int
    rmse: float
    check_rmse: float
    state: dict[str, Any] = field(repr=False)

    @property
    def added_nothing(self) -> bool:
        """Whether the start, or what the first epoch made of it, is the best although there were more epochs."""
        return self.best <= 1 < len(self.history) - 1

    @property
    def remarks(self) -> list[str]:
        """What is to be said of the learning, in sentences: that it added nothing, that it learnt its data by heart."""
        found = []
        if self.added_nothing:
            last = len(self.history) - 1
            found.append(f"learning added nothing over the start: epoch {self.best} of {last} is the best")
        if self.check_rmse > UNLIKE * self.rmse > 0:
            times = self.check_rmse / self.rmse
            found.append(f"the checking error is {times:.1f} times the training error: fewer rules, or more data")
        return found

    def table(self) -> Any:
        """The history as a pandas table."""
        import pandas as pd

        return pd.DataFrame(self.history, columns=list(Epoch._fields))


def train(
    fis: "Sugeno | Type2Sugeno",
    x: Any,
    y: Any,
    options: Options | None = None,
    *,
    check: tuple[Any, Any] | None = None,
    callback: Callable[[Epoch], bool | None] | None = None,
    improved: Callable[[Callable[[], Any]], None] | None = None,
    checkpoint: str | Path | None = None,
    resume: str | Path | dict[str, Any] | None = None,
) -> Training:
    """Learn the parameters of a system from data (MATLAB's ``anfis``).

    Where no rule fires the middle of the output's range stands, as in inference, and its error counts. Warns
    (DataWarning) of such samples, of constant inputs, of no more samples than parameters of the consequents, and where
    the system's own numbers are too coarse for what was learnt, because an input lies far from 0 for its spread. Ctrl-C
    ends training with the best so far, and so does an error that is no longer finite.

    Args:
        fis: The system to start from, such as :func:`fuzzy.identify` makes; of an interval type-2 system the method
            "backprop" learns the footprint of uncertainty, too.
        x: The inputs (samples, inputs).
        y: The outputs (samples,) or (samples, outputs).
        options: Method, epochs and the rest; by default those of :class:`anfis.Options`.
        check: Data in the form of ``x`` and ``y`` that are not learnt from; they choose the best epoch.
        callback: Sees every epoch, and may return False to stop.
        improved: Called before it, after every epoch that is the best so far, with a function that makes the system of
            that epoch.
        checkpoint: A file that is rewritten after every epoch.
        resume: A checkpoint, or a ``Training.state``, from which training goes on with the same result as if it had not
            stopped, to the last bit on the same machine.

    Returns:
        The best systems, the errors on the way, and a state to go on from. The same data, options and seed give the
        same result.

    Raises:
        DataError: Data that cannot be learnt from.
        TrainingError: Options or checkpoints that cannot be used, or a system without rules.
    """
    options = options or Options()
    fis = detached(fis)
    if not fis.rules:
        raise TrainingError(f"{fis.name} has no rules, so there is nothing to learn")
    data = samples(fis.upper, x, y, "training")
    checking = samples(fis.upper, *check, "checking") if check is not None else None
    method = make_method(options.method)
    network = _network(method, fis, options)
    problem = LearningProblem(network, network.samples(data), options)
    run = _Run(method, problem, network.samples(checking) if checking is not None else None)
    _say_too_few(network, data.count)
    if resume is None:
        state = run.begin()
        _say_silent(run, state.point)
    else:
        state = run.resumed(resume)
    with network.threads(data.count):
        state, stopped = _learn(run, state, callback, improved, checkpoint)
    system = network.system(state.best_check if checking is not None else state.best_train)
    best = _argmin(state.history, "check" if checking is not None else "train")
    rmse = total_rmse(system, data.x, data.y)
    _say_differing(rmse, next(row.train for row in state.history if row.epoch == best), data, fis)
    return Training(
        system,
        network.system(state.best_train),
        state.history,
        best,
        stopped,
        options,
        network.count,
        rmse,
        float("nan") if checking is None else total_rmse(system, checking.x, checking.y),
        dump(state, options, run.fingerprint),
    )


def _learn(
    run: "_Run",
    state: TrainingState,
    callback: Callable[[Epoch], bool | None] | None,
    improved: Callable[[Callable[[], Any]], None] | None,
    checkpoint: str | Path | None,
) -> tuple[TrainingState, str]:
    """Measure and step until there is a reason to stop: the last state, and the reason."""
    options, told = run.problem.options, False
    try:
        while True:
            measured = run.measure(state)
            if measured is None:
                return state, "diverged"
            state, row = measured
            if checkpoint is not None:
                told = _saved(dump(state, options, run.fingerprint), checkpoint, told)
            if improved is not None and state.since == 0:
                best = state.best_train if run.checking is None else state.best_check
                improved(partial(run.problem.network.system, best))
            if callback is not None and callback(row) is False:
                return state, "callback"
            if row.train <= options.goal:
                return state, "goal"
            if options.patience and state.since >= options.patience:
                return state, "patience"
            if row.epoch >= options.epochs or run.method.once:
                return state, "epochs"
            advanced = run.method.advance(run.problem, state)
            if advanced is None:
                return state, "converged"
            state = advanced
    except KeyboardInterrupt:
        if not state.history:
            raise
        return state, "interrupted"


def _saved(state: dict[str, Any], checkpoint: str | Path, told: bool) -> bool:
    """Write a checkpoint, and return whether it was ``told`` that this fails: what is learnt is worth more."""
    try:
        save(state, checkpoint)
    except OSError as error:
        if not told:
            reason = error.strerror or error
            warnings.warn(f"{checkpoint}: {reason}; learning goes on without this checkpoint", stacklevel=5)
        return True
    return told


def _network(method: Method, fis: "Sugeno | Type2Sugeno", options: Options) -> "Network | CompiledNetwork":
    """The network in compiled code where the method, the numbers and the functions allow it, else in torch."""
    # Imported when it is known which: torch takes seconds to load, and compiled learning does without.
    chosen = options.keep_order, options.ridge, options.batch or _BLOCK
    if not isinstance(fis, Sugeno):
        if method.solves:
            raise TrainingError(
                f"{fis.name}: a type-2 system learns by the method 'backprop', not by {options.method!r}, whose least "
                "squares need outputs that are linear in the consequents"
            )
        needed("torch", "learning of a type-2 system")
        return import_module("anfis.type2network").make_network(fis, options.dtype, options.device, *chosen)
    if method.compiled and options.dtype == "float64" and options.device == "cpu":
        compiled = import_module("anfis.compiled.network")
        if compiled.has_kernel(fis):
            return compiled.make_network(fis, *chosen)
    needed("torch", "learning by back-propagation, in float32, on another device or of functions of one's own")
    return import_module("anfis.network").make_network(fis, options.dtype, options.device, *chosen)


def _argmin(history: Sequence[Epoch], column: str) -> int:
    values = [getattr(row, column) for row in history]
    return history[int(np.nanargmin(values))].epoch if np.isfinite(values).any() else history[0].epoch


@dataclass(frozen=True, eq=False)
class _Run:
    """One training: the method, what it learns from, and the checking data, which only this loop sees."""

    method: Method
    problem: LearningProblem
    checking: SampleArrays | None

    @cached_property
    def fingerprint(self) -> str:
        """The digest of the problem, which a checkpoint must have to be resumed."""
        return fingerprint_of(self.problem.network, self.problem.data, self.checking)

    def begin(self) -> TrainingState:
        """The state before the first epoch."""
        point = self.method.start(self.problem.network)
        return TrainingState(point, 0, self.method.first_step(self.problem.options), (), point, point, 0, {})

    def resumed(self, source: str | Path | dict[str, Any]) -> TrainingState:
        """The state that a checkpoint holds. Raises TrainingError for one of another problem, and a damaged one."""
        problem = self.problem
        state = restore(source, problem.options, self.fingerprint, problem.network.start(), problem.network.array)
        try:
            known = self.method.remembers(problem, state.point, state.memory)
        except (KeyError, TypeError, AttributeError):
            known = False
        if state.history and not known:
            where = "" if isinstance(source, dict) else f"{source}: "
            raise TrainingError(f"{where}this checkpoint is damaged: the method's memory does not fit the network")
        return state

    def measure(self, state: TrainingState) -> tuple[TrainingState, Epoch] | None:
        """Measure the errors at the present point, recorded once; the consequents are solved if the method wants that.

        None where the error is no longer finite; DataError where it never was.
        """
        if state.history and state.history[-1].epoch == state.epoch:
            return state, state.history[-1]  # resumed just after it was recorded
        point, rank, memory = state.point, 0, state.memory
        network, data = self.problem.network, self.problem.data
        if not self.method.solves:
            train_error = network.rmse(point, data)
        else:
            fit = network.fit(point.free, data, gradient=self.method.gradient)
            train_error, rank = fit.rmse, min(solution.rank for solution in fit.solutions if len(solution.values))
            point = point._replace(values=[solution.values for solution in fit.solutions])
            if fit.gradient is not None:
                memory = {**memory, "gradient": fit.gradient}
        check_error = network.rmse(point, self.checking) if self.checking is not None else float("nan")
        if not np.isfinite(train_error):
            if state.history:
                return None
            raise DataError("the training error is not finite: check the data's and the parameters' magnitudes")
        row = Epoch(state.epoch, train_error, check_error, state.step, rank)
        better_train, better_check = train_error < state.least_train, check_error < state.least_check
        better = better_train if self.checking is None else better_check
        state = state._replace(
            point=point,
            memory=memory,
            history=(*state.history, row),
            best_train=point if better_train else state.best_train,
            best_check=point if better_check or not state.history else state.best_check,
            least_train=train_error if better_train else state.least_train,
            least_check=check_error if better_check else state.least_check,
            since=0 if better or not state.history else state.since + 1,
        )
        return state, row


def _say_differing(rmse: float, learnt: float, data: SampleArrays, fis: "Sugeno | Type2Sugeno") -> None:
    """Warn where the system errs by more than what was learnt.

    A consequent is slopes · x + constant. Where x lies far from 0 for its spread both parts are large and all but
    cancel, and the digits of a number do not suffice.
    """
    spread = max(float(np.ptp(data.y[:, k])) for k in range(data.y.shape[1]))
    if rmse <= 1.05 * learnt or rmse - learnt <= _NEGLIGIBLE * spread:
        return
    lowest, highest = data.x.min(axis=0), data.x.max(axis=0)
    offset = np.maximum(abs(lowest), abs(highest)) / np.where(highest > lowest, highest - lowest, np.inf)
    k = int(np.argmax(offset))
    warnings.warn(
        f"the system errs by {shown(rmse)} (RMSE), though {shown(learnt)} was learnt: its numbers have too few digits "
        f"for the input {quoted(fis.inputs[k].name)}, which lies at {shown(lowest[k])} and spreads over only "
        f"{shown(highest[k] - lowest[k])}; subtract a constant from it in the data",
        DataWarning,
        stacklevel=3,
    )


def _say_too_few(network: "Network | CompiledNetwork", count: int) -> None:
    most = network.columns
    if most >= count and not network.ridge:
        why = "the solution of least norm is taken" if most > count else "they are learnt by heart, noise and all"
        warnings.warn(
            f"{count} samples for {most} parameters of the consequents: {why}. Fewer rules, constant consequents, more "
            "samples or ridge > 0 helps",
            DataWarning,
            stacklevel=3,
        )


def _say_silent(run: "_Run", point: Point) -> None:
    network, data = run.problem.network, run.problem.data
    count = network.silent(point.free, data)
    if count:
        warnings.warn(
            f"no rule fires at {count} of {data.count} training samples: nothing is learnt from them",
            DataWarning,
            stacklevel=3,
        )
