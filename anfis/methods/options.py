"""Options of training, checked when they are chosen."""

from dataclasses import dataclass
from math import inf
from typing import Literal

from anfis.methods.catalogue import METHODS
from fuzzy.errors import InputError
from fuzzy.extras import needed
from fuzzy.fitting.consequents import LARGEST_RIDGE
from fuzzy.naming import check_known
from fuzzy.quantity import check_quantities, described, quantity, whole


class TrainingError(InputError):
    """Options or a checkpoint that training cannot use. The message names the option and what is accepted."""


@dataclass(frozen=True, kw_only=True)
class Options:
    """How to train. Defaults are MATLAB's where it has the option.

    A method reads its own options besides those of every method, see :attr:`anfis.methods.method.Method.reads`.
    Raises:
        TrainingError: An option that training cannot use.
    """

    method: str = described(f"How to learn: {', '.join(METHODS)}.", "hybrid")
    epochs: int = whole(10, least=0, doc="The most epochs to learn for.")
    step: float = quantity(
        0.01, "1", least=0, doc="Length of the first premise step (hybrid), in units of the universes."
    )
    increase: float = quantity(
        1.1, "1", least=1, doc="Factor of the step after four decreases of the error in a row (hybrid) [Jang 1993]."
    )
    decrease: float = quantity(
        0.9, "1", least=0, most=1, doc="Factor of the step after up, down, up, down of the error (hybrid)."
    )
    goal: float = quantity(0.0, "1", least=0, doc="Stop at this training RMSE, over all outputs and in their unit.")
    patience: int = whole(
        0, least=0, doc="Stop that many epochs after the least error, of checking if there is any; 0: never."
    )
    ridge: float = quantity(
        0.0,
        "1",
        least=0,
        most=LARGEST_RIDGE,
        doc="Times the square of the consequents, added to the mean square error; no unit.",
    )
    optimiser: str = described("A class of torch.optim (backprop).", "Adam")
    rate: float = described("Learning rate (backprop), >= 0.", 0.01)
    batch: int = whole(
        0, least=0, doc="Samples a step (backprop), else samples held at a time; 0: all (backprop), else 65,536."
    )
    keep_order: bool = described("Keep an input's memberships in order and overlapping.", False)
    seed: int = whole(0, least=0, doc="Seed of the order of mini-batches (backprop).")
    dtype: Literal["float64", "float32"] = described("Type of all numbers that are learnt.", "float64")
    device: str = described("Device of torch.", "cpu")

    def __post_init__(self) -> None:
        check_known(self.method, METHODS, "method", TrainingError)
        check_quantities(self, TrainingError)
        if isinstance(self.rate, bool) or not isinstance(self.rate, (int, float)) or not 0 <= self.rate < inf:
            raise TrainingError(f"rate must be a finite number >= 0, got {self.rate!r}")
        check_known(self.dtype, ("float64", "float32"), "dtype", TrainingError)
        # torch is loaded only to ask for what is not known without it.
        if self.optimiser != "Adam":
            _check_optimiser(self.optimiser)
        if self.device != "cpu":
            _check_device(self.device)


def _check_optimiser(name: object) -> None:
    optim = needed("torch.optim", f"the optimiser {name!r}")
    # These want more than a gradient: a closure, or sparse gradients.
    unusable = (optim.Optimizer, optim.LBFGS, optim.SparseAdam)
    kind = getattr(optim, name, None) if isinstance(name, str) else None
    if not (isinstance(kind, type) and issubclass(kind, optim.Optimizer)) or kind in unusable:
        raise TrainingError(f"optimiser must be a class of torch.optim, such as 'Adam'; got {name!r}")


def _check_device(device: str) -> None:
    torch = needed("torch", f"the device {device!r}")
    try:
        torch.empty(0, device=device)
    except (RuntimeError, AssertionError) as error:
        raise TrainingError(f"device {device!r} cannot be used: {str(error).splitlines()[0]}") from None
