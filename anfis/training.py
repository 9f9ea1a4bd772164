"""Training: data in, history and the best systems out. The one place that loops over epochs.

Four methods, all through the one inference of :mod:`fuzzy.inference`:

- ``hybrid``: least squares for the consequents, a gradient step of Jang's length for the premises   [Jang 1993];
- ``backprop``: any torch optimiser on premises and consequents together;
- ``least-squares``: the consequents only, once;
- ``second-order``: the premises by Levenberg-Marquardt on the reduced cost, consequents eliminated by least squares
  (variable projection, Kaufman's approximation of the Jacobian)   [Golub & Pereyra 2003].
"""

import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from copy import deepcopy
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import torch

from anfis.consequents import groups
from anfis.data import DataError, DataWarning, Samples, samples
from anfis.network import Network, Point
from anfis.options import Options, TrainingError
from anfis.premises import premises
from anfis.state import Epoch, State, dump, fingerprint_of, restore, save
from fuzzy.detached import detached
from fuzzy.system import Sugeno

_SMALL = 250_000  # numbers in a design matrix up to which one thread does


@dataclass(frozen=True, eq=False)
class Training:
    """What training gives back."""

    system: Sugeno  # least checking error if there are checking data (as MATLAB's chkFIS), else least training error
    least_train: Sugeno  # the system of least training error
    history: tuple[Epoch, ...]
    best: int  # the epoch of ``system``
    stopped: str  # why: "epochs", "goal", "patience", "interrupted", "callback", "converged", "diverged"
    options: Options
    parameters: int  # how many numbers were learnt
    state: dict[str, Any] = field(repr=False)  # to resume from, with :func:`train`'s ``resume``

    def table(self) -> Any:
        """The history as a pandas table."""
        import pandas as pd

        return pd.DataFrame(self.history, columns=list(Epoch._fields))


def train(
    fis: Sugeno,
    x: Any,
    y: Any,
    options: Options | None = None,
    *,
    check: tuple[Any, Any] | None = None,
    callback: Callable[[Epoch], bool | None] | None = None,
    checkpoint: str | Path | None = None,
    resume: str | Path | dict[str, Any] | None = None,
) -> Training:
    """Learn the parameters of ``fis`` from ``x`` (samples, inputs) and ``y`` (samples,) or (samples, outputs).

    ``check`` is data of the same form that are not learnt from. ``callback`` sees every epoch and may return False to
    stop. ``checkpoint`` is a file rewritten after every epoch; ``resume`` continues from one (or from
    ``Training.state``) with the same result as if it had not stopped, to the last bit on the same machine. Ctrl-C
    ends training with the best so far, and so does an error that is no longer finite. The same data, options and seed
    give the same result.

    Where no rule fires the middle of the output's range stands, as in inference, and its error counts. Warns
    (DataWarning) of such samples, of constant inputs and of more consequents than samples. Raises DataError for data
    that cannot be learnt from, TrainingError for options, checkpoints or a system without rules.
    """
    options = options or Options()
    dtype = getattr(torch, options.dtype)
    fis = detached(fis)
    if not fis.rules:
        raise TrainingError(f"{fis.name} has no rules, so there is nothing to learn")
    data = samples(fis, x, y, "training")
    checking = samples(fis, *check, "checking") if check is not None else None
    held = premises(fis, dtype=dtype, device=options.device, keep_order=options.keep_order)
    parts = groups(fis, dtype, options.device)
    network = Network(held, parts, options.ridge, options.batch or 65_536)
    run = _Run(
        network, options, data.to(dtype, options.device), checking.to(dtype, options.device) if checking else None
    )
    _say_too_few(network, data.count)
    if resume is None:
        state = run.begin()
        _say_silent(run, state.point)
    else:
        state = restore(resume, options, run.fingerprint)
    history = state.history
    stopped = "epochs"
    with _few_threads(network, data.count):
        try:
            while True:
                measured = run.measure(state)
                if measured is None:
                    stopped = "diverged"
                    break
                state, row = measured
                history = state.history
                if checkpoint is not None:
                    save(dump(state, options, run.fingerprint), checkpoint)
                if callback is not None and callback(row) is False:
                    stopped = "callback"
                    break
                if row.train <= options.goal:
                    stopped = "goal"
                    break
                if options.patience and state.since >= options.patience:
                    stopped = "patience"
                    break
                if row.epoch >= options.epochs or options.method == "least-squares":
                    break
                advanced = run.advance(state)
                if advanced is None:
                    stopped = "converged"
                    break
                state = advanced
        except KeyboardInterrupt:
            stopped = "interrupted"
            if not history:
                raise
    return Training(
        network.system(state.best_check if checking is not None else state.best_train),
        network.system(state.best_train),
        history,
        _argmin(history, "check" if checking is not None else "train"),
        stopped,
        options,
        network.count,
        dump(state, options, run.fingerprint),
    )


@contextmanager
def _few_threads(network: Network, count: int) -> Iterator[None]:
    """One thread for a small problem: more wait for each other longer than they compute, the longer the busier the
    machine. The caller's number comes back.
    """
    columns = max(len(g.columns) for g in network.groups)
    before = torch.get_num_threads()
    small = before > 1 and min(count, network.block) * columns < _SMALL
    if small:
        torch.set_num_threads(1)
    try:
        yield
    finally:
        if small:
            torch.set_num_threads(before)


def _argmin(history: Sequence[Epoch], column: str) -> int:
    values = [getattr(row, column) for row in history]
    return history[int(np.nanargmin(values))].epoch if np.isfinite(values).any() else history[0].epoch


@dataclass(frozen=True, eq=False)
class _Run:
    network: Network
    options: Options
    data: Samples
    checking: Samples | None

    @cached_property
    def fingerprint(self) -> str:
        """What a checkpoint must agree with."""
        return fingerprint_of(self.network, self.data, self.checking)

    def begin(self) -> State:
        point = self.network.start()
        if self.options.method == "least-squares":
            point = point._replace(free=self.network.premises.start())  # they stay exactly as they are
        step = {"hybrid": self.options.step, "second-order": 1e-2}.get(self.options.method, self.options.rate)
        return State(point, 0, step, (), point, point, 0, {})

    def measure(self, state: State) -> tuple[State, Epoch] | None:
        """The errors at the present point, recorded once; consequents are solved unless backprop learns them.

        None where the error is no longer finite; DataError where it never was.
        """
        if state.history and state.history[-1].epoch == state.epoch:
            return state, state.history[-1]  # resumed just after it was recorded
        point, rank, memory = state.point, 0, state.memory
        if self.options.method == "backprop":
            train_error = self.network.rmse(point, self.data)
        else:
            fit = self.network.fit(point.free, self.data, gradient=self.options.method == "hybrid")
            train_error, rank = fit.rmse, min(solution.rank for solution in fit.solutions if len(solution.values))
            point = point._replace(values=[solution.values for solution in fit.solutions])
            memory = {"gradient": fit.gradient} if fit.gradient is not None else {}
        check_error = self.network.rmse(point, self.checking) if self.checking is not None else float("nan")
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

    def advance(self, state: State) -> State | None:
        """One step of the method; None where no step helps any more."""
        epoch = {"hybrid": self._hybrid, "backprop": self._backprop, "second-order": self._second_order}
        return epoch[self.options.method](state)

    def _hybrid(self, state: State) -> State | None:
        gradient: list[torch.Tensor] = state.memory["gradient"]
        norm = torch.sqrt(sum((g.square().sum() for g in gradient), start=gradient[0].new_zeros(())))
        if not float(norm) > 0:
            return None
        recent = state.history[-6:]  # more than these the rules do not look at
        errors, steps = [row.train for row in recent], [row.step for row in recent]
        step = jang_step(errors, steps, self.options.increase, self.options.decrease)
        free = [p - step * g / norm for p, g in zip(state.point.free, gradient, strict=True)]
        point = state.point._replace(free=self.network.premises.valid(free))
        return state._replace(point=point, epoch=state.epoch + 1, step=step)

    def _backprop(self, state: State) -> State:
        options, n = self.options, self.data.count
        leaves = [p.detach().clone().requires_grad_() for p in (*state.point.free, *state.point.values)]
        optimiser = getattr(torch.optim, options.optimiser)(leaves, lr=options.rate)
        if "optimiser" in state.memory:
            # A copy: the optimiser writes into what it is given, and ``state`` must stay what it was.
            optimiser.load_state_dict(deepcopy(state.memory["optimiser"]))
        size = options.batch or n
        random = np.random.default_rng([options.seed, state.epoch])
        order = torch.as_tensor(random.permutation(n)) if size < n else None
        kinds = len(state.point.free)
        for start in range(0, n, size):
            rows = slice(None) if order is None else order[start : start + size]
            optimiser.zero_grad()
            x, y = self.data.rows(rows)
            u = self.network.premises.scale(x)
            loss = (self.network.output(leaves[:kinds], leaves[kinds:], u) - y).square().mean()
            loss.backward()
            optimiser.step()
            with torch.no_grad():
                for leaf, legal in zip(leaves[:kinds], self.network.premises.valid(leaves[:kinds]), strict=True):
                    leaf.copy_(legal)
        point = Point(tuple(p.detach() for p in leaves[:kinds]), [p.detach() for p in leaves[kinds:]])
        return state._replace(point=point, epoch=state.epoch + 1, memory={"optimiser": optimiser.state_dict()})

    def _second_order(self, state: State) -> State | None:
        """One accepted Levenberg-Marquardt step; the damping falls after success and grows until there is one."""
        jtj, jtr = self.network.reduced(state.point, self.data)
        # Marquardt's scaling, but no parameter is let loose just because the error hardly depends on it yet.
        diagonal = jtj.diagonal()
        if not float(diagonal.max()) > 0:
            return None  # the error does not depend on the premises
        scale = torch.diag(diagonal.clamp_min(max(0.1 * float(diagonal.max()), torch.finfo(diagonal.dtype).tiny)))
        damping, present = state.step, state.history[-1].train
        flat = torch.cat([p.flatten() for p in state.point.free])
        for _ in range(16):
            step, failed = torch.linalg.solve_ex(jtj + damping * scale, jtr)
            if int(failed) or not bool(torch.isfinite(step).all()):
                damping *= 4
                continue
            free = self.network.premises.valid(self.network.unflatten(flat + step))
            fit = self.network.fit(free, self.data)
            if fit.rmse < present:
                point = Point(free, [solution.values for solution in fit.solutions])
                return state._replace(point=point, epoch=state.epoch + 1, step=max(damping / 5, 1e-12))
            damping *= 4
        return None


def jang_step(errors: Sequence[float], steps: Sequence[float], increase: float, decrease: float) -> float:
    """Jang's two rules for the length of the next step   [Jang 1993, section III].

    Longer after four reductions of the error in a row; shorter after two combinations of one increase and one
    reduction in a row. ``errors`` and ``steps`` are those of all epochs so far; epochs before the last change of the
    step do not count again.
    """
    step = steps[-1]
    changed = max((k for k in range(1, len(steps)) if steps[k] != steps[k - 1]), default=1)
    counted = errors[changed - 1 :]  # the change was decided at the first of these
    if len(counted) < 5:
        return step
    last = list(pairwise(counted[-5:]))
    if all(b < a for a, b in last):
        return step * increase
    if [b > a for a, b in last] == [True, False, True, False] and all(a != b for a, b in last):
        return step * decrease
    return step


def _say_too_few(network: Network, count: int) -> None:
    most = max(len(g.columns) for g in network.groups)
    if most > count and not network.ridge:
        warnings.warn(
            f"{count} samples for {most} parameters of the consequents: the solution of least norm is taken. Fewer "
            "rules, constant consequents, more samples or ridge > 0 helps",
            DataWarning,
            stacklevel=3,
        )


def _say_silent(run: "_Run", point: Point) -> None:
    count = run.network.silent(point.free, run.data)
    if count:
        warnings.warn(
            f"no rule fires at {count} of {run.data.count} training samples: nothing is learnt from them",
            DataWarning,
            stacklevel=3,
        )
