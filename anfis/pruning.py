"""Pruning: rules that contribute least are taken away, the rest learns again, and other data choose how many stay.

A grid has terms^inputs rules, most of which the samples say little about. What a rule contributes is measured by taking
it away: the squared error of the training data that is left when the consequents of all other rules are solved for
anew, each sample predicted from the others (:func:`leave_out_errors`). How strongly a rule fires says less: of two
rules that say the same either can go, and a rule that seldom fires may be the only one for its part of the input space.
"""

import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple, get_args

import numpy as np

from anfis.accuracy import total_rmse
from anfis.compiled.threads import one_for_linear_algebra
from anfis.data import DataError, DataWarning, SampleArrays, samples
from anfis.methods.method import make_method
from anfis.methods.options import Options, TrainingError
from anfis.state import Epoch
from anfis.training import Training, train
from fuzzy.detached import detached
from fuzzy.fitting.consequents import OutputGroup, output_groups, rule_shares
from fuzzy.inference import forgiving, infer_quietly
from fuzzy.naming import check_known
from fuzzy.system import Sugeno, Variable

Choice = Literal["one-standard-error", "least"]
_CHOICES: tuple[str, ...] = get_args(Choice)

_SHARE = 10  # one of so many rules goes at a time, at least one
_HELD = 0.25  # of the samples, to choose by where there are no checking data
_RIDGES = tuple(10.0**k for k in range(-8, -1))  # tried, for what rules contribute
_FEWEST = 8  # samples of which some can be held back
_FAINT = 1e-9  # weights of all other rules below which they are computed anew, not from the quotients


class PruningStep(NamedTuple):
    """The errors with some number of rules, over samples and outputs, in the outputs' unit.

    Attributes:
        rules: How many there are.
        train: On the data that teach.
        check: On the data that choose; not-a-number without.
        test: On data that neither teach nor choose; not-a-number without.
        silent: Training samples at which no rule fires: there the middle of the output's range stands.
    """

    rules: int
    train: float
    check: float
    test: float
    silent: int


@dataclass(frozen=True, eq=False)
class Pruned:
    """The result of pruning: a system of fewer rules, and the errors on the way.

    Attributes:
        system: With the chosen number of rules, fully trained.
        error: The errors of ``system``.
        path: From all rules, fully trained, to few, each trained for some epochs.
        systems: Those of the path.
        chosen: The place in the path that the choice fell on.
        training: The last training, that of ``system``.
        held: (held,) int: rows of the training data that chose, and taught in the last training only.
        stopped: Why it ended: "finished" or "interrupted".
    """

    system: Sugeno
    error: PruningStep
    path: tuple[PruningStep, ...]
    systems: tuple[Sugeno, ...]
    chosen: int
    training: Training
    held: np.ndarray
    stopped: str

    def table(self) -> Any:
        """The path as a pandas table."""
        import pandas as pd

        return pd.DataFrame(self.path, columns=list(PruningStep._fields))


def prune(
    fis: Sugeno,
    x: Any,
    y: Any,
    options: Options | None = None,
    *,
    check: tuple[Any, Any] | None = None,
    test: tuple[Any, Any] | None = None,
    keep: int | None = None,
    choice: Choice = "one-standard-error",
    retrain: int = 3,
    seed: int = 0,
    callback: Callable[[str, int, Epoch], bool | None] | None = None,
) -> Pruned:
    """Train ``fis``, take away the rules that contribute least, step by step, and train the rest.

    Each step takes away a tenth of the rules, at least one: those without which the error grows least, by
    :func:`leave_out_errors`. Terms that no rule asks for any more go too. Then the rest learns for ``retrain`` epochs.
    The number of rules is chosen by data that are not learnt from, and the system with it learns once more in full.

    An input at which no rule is left to fire has the middle of the output's range, as in inference; such samples count
    with that error, in the choice of the rules as well. Between the rules that are left the nearest ones go on.

    Args:
        fis: The system to start from, such as a grid.
        x: The inputs (samples, inputs).
        y: The outputs (samples,) or (samples, outputs).
        options: How to train, as for :func:`anfis.train`.
        check: The data that choose, in the form of ``x`` and ``y``; they also choose the best epoch of each training.
            Without them a quarter of the samples, drawn by ``seed``, does so, and is learnt from in the last training.
        test: Data whose error is only measured.
        keep: The number of rules to keep, instead of a choice.
        choice: "one-standard-error": the fewest rules whose checking error is above the least one by no more than one
            standard error of the difference (of squared errors, sample by sample); "least": the number of least error.
        retrain: The epochs after each step.
        seed: The seed of the samples held back.
        callback: Sees "all rules", "pruning" or "last training", the number of rules and every epoch, and may return
            False to end that training.

    Returns:
        The pruned system and the way to it. The same data, options and seed give the same result; Ctrl-C keeps the best
        so far.

    Raises:
        TrainingError: As :func:`anfis.train` does.
        DataError: As :func:`anfis.train` does.
    """
    options = options or Options()
    fis = detached(fis)
    _check_settings(fis, keep, choice, retrain)
    whole = samples(fis, x, y, "training")
    checking = samples(fis, *check, "checking") if check is not None else None
    testing = samples(fis, *test, "test") if test is not None else None
    held = _held(whole.count, seed) if check is None and keep is None else np.arange(0)
    learnt = whole
    if len(held):
        rest = np.delete(np.arange(whole.count), held)
        learnt, checking = SampleArrays(whole.x[rest], whole.y[rest]), SampleArrays(whole.x[held], whole.y[held])
    job = _Job(options, learnt, checking, testing, callback)
    trainings, steps, stopped = [], [], "finished"
    try:
        for training in _shrinking(job, fis, keep or 1, min(retrain, options.epochs)):
            trainings.append(training)
            steps.append(job.measured(training.system))
            stopped = "interrupted" if training.stopped == "interrupted" else stopped
    except KeyboardInterrupt:
        if not trainings:
            raise
        stopped = "interrupted"
    chosen = len(steps) - 1
    if keep is None and checking is not None:
        chosen = _chosen(choice, steps, [t.system for t in trainings], checking)
    last = trainings[chosen]
    if stopped == "finished":
        job = job if not len(held) else _Job(options, whole, None, testing, callback)
        last = job.train(last.system, "last training", options.epochs)
        stopped = "interrupted" if last.stopped == "interrupted" else stopped
    systems = tuple(training.system for training in trainings)
    return Pruned(last.system, job.measured(last.system), tuple(steps), systems, chosen, last, held, stopped)


def schedule(rules: int, least: int = 1) -> list[int]:
    """The numbers of rules that pruning comes to, from ``rules`` down to ``least``."""
    found = [rules]
    while found[-1] > least:
        found.append(max(found[-1] - max(1, found[-1] // _SHARE), least))
    return found


def leave_out_errors(fis: Sugeno, x: np.ndarray, y: np.ndarray, ridge: float = 0.0) -> np.ndarray:
    """What each rule contributes, (rules,): the mean square error without it, over samples and outputs.

    Without the rule the weights of all others are normalised anew and their consequents solved for anew by least
    squares. The error is that of predicting each sample from all others (PRESS, [Allen 1974]), exact for a linear
    least squares with a fixed ridge: residual / (1 − leverage). Where no other rule fires the middle of the output's
    range stands.

    With as many consequents as samples every rule could go without a trace. So the least squares have a ridge: of
    10⁻⁸ ... 10⁻² the one by which all rules together predict left out samples best, ``ridge`` at least.

    Args:
        fis: The system, its premises as they are.
        x: The inputs (samples, inputs).
        y: The outputs (samples, outputs).
        ridge: As :mod:`fuzzy.fitting.consequents` says.
    """
    if fis.out_of_range == "clip":
        x = np.clip(x, [v.universe[0] for v in fis.inputs], [v.universe[1] for v in fis.inputs])
    middle, half = (x.min(axis=0) + x.max(axis=0)) / 2, (x.max(axis=0) - x.min(axis=0)) / 2
    scaled = np.column_stack([(x - middle) / np.where(half > 0, half, 1.0), np.ones(len(x))])
    normalise, groups = fis.defuzzification == "wtaver", output_groups(fis)
    shares = _weights(fis, x, normalise)
    errors = np.empty(len(fis.rules))

    def error(weights: np.ndarray, ridge: float) -> float:
        return sum(_press(fis, group, weights, scaled, y, ridge) for group in groups) / y.size

    with one_for_linear_algebra():
        ridge = min({max(ridge, each) for each in _RIDGES}, key=lambda each: (error(shares, each), each))
        for rule in range(len(fis.rules)):
            others = shares.copy()
            others[:, rule] = 0.0
            if normalise and (others.sum(axis=1) < _FAINT).any():
                rest = [k for k in range(len(fis.rules)) if k != rule]
                others[:, rest] = _weights(replace(fis, rules=[fis.rules[k] for k in rest]), x, normalise)
            errors[rule] = error(others, ridge)
    return errors


def without_rules(fis: Sugeno, gone: Sequence[int]) -> Sugeno:
    """``fis`` without the rules at these places, and without the terms that no other rule asks for or proposes."""
    out = set(gone)
    rules = [rule for k, rule in enumerate(fis.rules) if k not in out]
    asked = {(clause.variable, clause.term) for rule in rules for clause in rule.when}
    proposed = {pair for rule in rules for pair in rule.then}
    return replace(
        fis,
        inputs=[_with_terms(variable, asked) for variable in fis.inputs],
        outputs=[_with_terms(variable, proposed) for variable in fis.outputs],
        rules=rules,
    )


def _with_terms(variable: Variable, kept: set[tuple[str, str]]) -> Variable:
    return replace(variable, terms={n: term for n, term in variable.terms.items() if (variable.name, n) in kept})


@dataclass(frozen=True, eq=False)
class _Job:
    """What every training of a pruning shares."""

    options: Options
    learnt: SampleArrays
    checking: SampleArrays | None
    testing: SampleArrays | None
    callback: Callable[[str, int, Epoch], bool | None] | None

    def train(self, fis: Sugeno, stage: str, epochs: int) -> Training:
        """The training of ``fis`` for that many epochs."""
        check = None if self.checking is None else (self.checking.x, self.checking.y)
        told = self.callback
        look = None if told is None else lambda row: told(stage, len(fis.rules), row)
        return train(
            fis, self.learnt.x, self.learnt.y, replace(self.options, epochs=epochs), check=check, callback=look
        )

    def measured(self, fis: Sugeno) -> PruningStep:
        """The errors of ``fis``."""
        train, check, test = (
            float("nan") if data is None else total_rmse(fis, data.x, data.y)
            for data in (self.learnt, self.checking, self.testing)
        )
        silent = int((~infer_quietly(forgiving(fis), self.learnt.x).fired.all(axis=1)).sum())
        return PruningStep(len(fis.rules), train, check, test, silent)


def _shrinking(job: _Job, fis: Sugeno, least: int, retrain: int) -> Iterator[Training]:
    """The training of all rules, then of fewer and fewer, down to ``least``; none after one that was interrupted."""
    training = job.train(fis, "all rules", job.options.epochs)
    yield training
    for rules in schedule(len(fis.rules), least)[1:]:
        if training.stopped == "interrupted":
            return
        x, y = job.learnt.x, job.learnt.y
        errors = leave_out_errors(training.system, x, y, job.options.ridge)
        gone = np.argsort(errors, kind="stable")[: len(errors) - rules]
        fis = without_rules(training.system, gone.tolist())
        if not make_method(job.options.method).solves:
            # A method that moves the consequents begins where they suit the rules that are left.
            solving = replace(job.options, method="least-squares")
            fis = train(fis, x, y, solving).system
        with warnings.catch_warnings(action="ignore", category=DataWarning):  # was said of all rules
            training = job.train(fis, "pruning", retrain)
        yield training


def _chosen(choice: Choice, steps: Sequence[PruningStep], systems: Sequence[Sugeno], checking: SampleArrays) -> int:
    """The place of the step that the checking data choose; of equal ones that of the fewest rules."""
    best = min(range(len(steps)), key=lambda k: (steps[k].check, steps[k].rules))
    if choice == "least" or checking.count < 2:
        return best
    least = _squares(systems[best], checking)
    for k in reversed(range(len(steps))):
        more = _squares(systems[k], checking) - least
        if more.mean() <= more.std(ddof=1) / checking.count**0.5:
            return k
    return best


def _squares(fis: Sugeno, data: SampleArrays) -> np.ndarray:
    """(samples,) the squared errors, over all outputs."""
    output = np.asarray(infer_quietly(forgiving(fis, "midrange"), data.x).output)
    return np.asarray(((output - data.y) ** 2).sum(axis=1))


def _weights(fis: Sugeno, x: np.ndarray, normalise: bool) -> np.ndarray:
    """The rules' weights (samples, rules); firing strengths for a weighted sum."""
    layers = infer_quietly(forgiving(fis, "midrange"), x)
    return np.asarray(layers.weights if normalise else layers.firing)


def _press(
    fis: Sugeno, group: OutputGroup, weights: np.ndarray, scaled: np.ndarray, y: np.ndarray, ridge: float
) -> float:
    """The sum of squares of the errors in outputs of ``group`` at samples that were left out of the least squares."""
    normalise = fis.defuzzification == "wtaver"
    shares = rule_shares(fis, group, weights)
    fires = shares.sum(axis=1) > 0
    terms = np.zeros((len(group.place), len(group.linear)))
    terms[np.arange(len(group.place)), group.place] = group.place >= 0
    design = ((shares @ terms)[:, :, None] * scaled[:, None, :]).reshape(len(scaled), -1)[:, group.columns]
    design = design[:, design.any(axis=0)]
    target = y[:, list(group.outputs)]
    mean = target[fires].mean(axis=0) if normalise and fires.any() else np.zeros(len(group.outputs))
    gram = design.T @ design + ridge * int(fires.sum()) * np.eye(design.shape[1])
    inverse = np.linalg.inv(gram) if fires.any() else gram
    half = design @ inverse
    residual = target - mean - half @ (design.T @ (target - mean))
    leverage = (half * design).sum(axis=1)
    residual /= np.maximum(1.0 - leverage, np.finfo(float).eps)[:, None]
    residual[~fires] = (target - [fis.outputs[o].midrange for o in group.outputs])[~fires]
    return float((residual**2).sum())


def _held(count: int, seed: int) -> np.ndarray:
    """The rows to choose by, drawn by ``seed``, ascending."""
    if count < _FEWEST:
        raise DataError(f"{count} samples are too few to hold some back: give checking data, or the number of rules")
    return np.sort(np.random.default_rng(seed).permutation(count)[: round(_HELD * count)])


def _check_settings(fis: Sugeno, keep: int | None, choice: str, retrain: int) -> None:
    check_known(choice, _CHOICES, "choice", TrainingError)
    if isinstance(retrain, bool) or not isinstance(retrain, (int, np.integer)) or retrain < 0:
        raise TrainingError(f"retrain must be a whole number >= 0, got {retrain!r}")
    if keep is None:
        return
    if isinstance(keep, bool) or not isinstance(keep, (int, np.integer)) or not 1 <= keep <= len(fis.rules):
        raise TrainingError(
            f"keep must be a whole number from 1 to the number of rules ({len(fis.rules)}), got {keep!r}"
        )
