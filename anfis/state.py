"""What an epoch of learning changes."""

from typing import Any, NamedTuple

from anfis.point import Point


class Epoch(NamedTuple):
    """One row of the history: the network before the epoch's own step.

    Attributes:
        epoch: Its number, from 0.
        train: RMSE over samples and outputs, in the outputs' unit.
        check: RMSE on the checking data; not-a-number without.
        step: Hybrid: the length of the step; second-order: the damping; others: the learning rate.
        rank: Of the least squares (the smallest of the outputs' problems); 0 for a method that does not solve them.
    """

    epoch: int
    train: float
    check: float
    step: float
    rank: int


class TrainingState(NamedTuple):
    """Everything that an epoch changes."""

    point: Point  # where the premises and the consequents are
    epoch: int
    step: float
    history: tuple[Epoch, ...]
    best_train: Point
    best_check: Point
    since: int  # epochs since the last minimum of the checking error (training error without checking data)
    memory: dict[str, Any]  # the method's own, in plain values and arrays: a gradient, an optimiser's state
    least_train: float = float("inf")  # the least errors in the history
    least_check: float = float("inf")
