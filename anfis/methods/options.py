"""Options of training, checked when they are chosen."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from anfis.methods.catalogue import METHODS
from fuzzy.errors import InputError
from fuzzy.fitting.consequents import LARGEST_RIDGE
from fuzzy.naming import expected


class TrainingError(InputError):
    """Options or a checkpoint that training cannot use. The message names the option and what is accepted."""


@dataclass(frozen=True, kw_only=True)
class Options:
    """How to train. Defaults are MATLAB's where it has the option.

    A method reads its own options besides those of every method, see :attr:`anfis.methods.method.Method.reads`.
    Raises TrainingError for an option that training cannot use.

    Attributes:
        method: A name in anfis.METHODS.
        epochs: The most epochs.
        step: Hybrid: the length of the first premise step, in units of the universes.
        increase: Hybrid: factor after four decreases of the error in a row   [Jang 1993].
        decrease: Hybrid: factor after up, down, up, down.
        goal: Stop when the training RMSE (over all outputs, in their unit) is this low.
        patience: Stop after that many epochs without a new least error (checking, if any); 0: never.
        ridge: Of the least squares, without a unit, see fuzzy.fitting.consequents.
        optimiser: Backprop: a class of torch.optim.
        rate: Backprop: its learning rate.
        batch: Backprop: samples a step; others: samples held at a time. 0: all (backprop), 65,536 (others).
        keep_order: Memberships of an input stay ordered and covering.
        seed: Backprop: of the order of mini-batches.
        dtype: Of all numbers that are learnt.
        device: Of torch.

    Raises:
        TrainingError: An option that training cannot use.
    """

    method: str = "hybrid"
    epochs: int = 10
    step: float = 0.01
    increase: float = 1.1
    decrease: float = 0.9
    goal: float = 0.0
    patience: int = 0
    ridge: float = 0.0
    optimiser: str = "Adam"
    rate: float = 0.01
    batch: int = 0
    keep_order: bool = False
    seed: int = 0
    dtype: Literal["float64", "float32"] = "float64"
    device: str = "cpu"

    def __post_init__(self) -> None:
        if self.method not in METHODS:
            raise TrainingError(expected(str(self.method), METHODS, "method"))
        for name, least in (("epochs", 0), ("patience", 0), ("batch", 0), ("seed", 0)):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < least:
                raise TrainingError(f"{name} must be a whole number >= {least}, got {value!r}")
        for name, least in (("step", 0), ("increase", 1), ("decrease", 0), ("goal", 0), ("ridge", 0), ("rate", 0)):
            value = getattr(self, name)
            if (
                isinstance(value, bool)
                or not isinstance(value, (int, float))
                or not np.isfinite(value)
                or value < least
            ):
                raise TrainingError(f"{name} must be a finite number >= {least}, got {value!r}")
        if self.ridge > LARGEST_RIDGE:
            raise TrainingError(f"ridge must be <= {LARGEST_RIDGE:g}, got {self.ridge!r}")
        if self.decrease > 1:
            raise TrainingError(f"decrease must be <= 1, got {self.decrease!r}")
        if self.dtype not in ("float64", "float32"):
            raise TrainingError(expected(str(self.dtype), ("float64", "float32"), "dtype"))
        # torch is loaded only to ask for what is not known without it.
        if self.optimiser != "Adam":
            _check_optimiser(self.optimiser)
        if self.device != "cpu":
            _check_device(self.device)


def _check_optimiser(name: object) -> None:
    from torch import optim

    # These want more than a gradient: a closure, or sparse gradients.
    unusable = (optim.Optimizer, optim.LBFGS, optim.SparseAdam)
    kind = getattr(optim, name, None) if isinstance(name, str) else None
    if not (isinstance(kind, type) and issubclass(kind, optim.Optimizer)) or kind in unusable:
        raise TrainingError(f"optimiser must be a class of torch.optim, such as 'Adam'; got {name!r}")


def _check_device(device: str) -> None:
    import torch

    try:
        torch.empty(0, device=device)
    except (RuntimeError, AssertionError) as error:
        raise TrainingError(f"device {device!r} cannot be used: {str(error).splitlines()[0]}") from None
