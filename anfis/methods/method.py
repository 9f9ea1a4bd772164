"""What a method of learning is. A new one is a module beside this one and a line in METHODS (``catalogue.py``)."""

from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

from anfis.data import SampleArrays
from anfis.methods.catalogue import METHODS
from anfis.methods.options import Options
from anfis.point import Point
from anfis.state import TrainingState

if TYPE_CHECKING:
    from anfis.compiled.network import CompiledNetwork
    from anfis.network import Network


@dataclass(frozen=True, eq=False)
class LearningProblem:
    """What a method learns from, the same in every epoch."""

    network: "Network | CompiledNetwork"
    data: SampleArrays  # to learn from; a method never sees the checking data
    options: Options


class Method(Protocol):
    """One way of learning: what the step of an epoch does. Subclass it, so that the defaults below hold.

    Every epoch training first measures the errors at ``state.point``, solving for the consequents if the method wants
    that, and then asks the method for the next point. A method has no memory of its own: what it must remember goes
    into ``TrainingState.memory``, as plain values and arrays, and so into checkpoints.
    """

    reads: ClassVar[tuple[str, ...]] = ()  # the names of the Options that are this method's own
    solves: ClassVar[bool] = True  # are the consequents solved by least squares at every point? Else it moves them
    gradient: ClassVar[bool] = False  # with ``solves``: does it want the gradient there, as memory["gradient"]?
    compiled: ClassVar[bool] = False  # can its arrays be numpy's? Then it learns in compiled code where there is one
    once: ClassVar[bool] = False  # is everything learnt when the consequents are solved, without a step?

    def start(self, network: "Network | CompiledNetwork") -> Point:
        """The point of the first epoch: the system as it is, its premises made legal."""
        return network.start()

    def first_step(self, options: Options) -> float:
        """The step size of the first epoch, which the history shows: a length, a damping or a learning rate."""
        return options.rate

    def remembers(self, problem: LearningProblem, point: Point, memory: dict[str, Any]) -> bool:
        """Whether ``memory``, which comes from a checkpoint, is what this method can go on with from ``point``."""
        return True

    def advance(self, problem: LearningProblem, state: TrainingState) -> TrainingState | None:
        """The state of the next epoch: ``point``, ``epoch + 1`` and what else changed; None where no step helps."""
        ...


def make_method(name: str) -> Method:
    """The method called ``name``, one of METHODS (KeyError otherwise)."""
    module, _, kind = METHODS[name].home.partition(":")
    method: Method = getattr(import_module(module), kind)()
    return method
