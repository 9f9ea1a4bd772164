"""Back-propagation: an optimiser of torch moves premises and consequents together, by mini-batches if asked.

torch is loaded when the method learns, not when it is named in a list.
"""

from copy import deepcopy
from typing import Any

import numpy as np

from anfis.methods.method import LearningProblem, Method
from anfis.point import Point
from anfis.state import TrainingState


class Backprop(Method):
    """An epoch of a torch optimiser on the mean square error; its first step is its learning rate."""

    reads = ("optimiser", "rate", "batch", "seed")
    solves = False

    def remembers(self, problem: LearningProblem, point: Point, memory: dict[str, Any]) -> bool:
        """Whether the optimiser's state is that of such an optimiser, of the shapes of what it moves; or none yet."""
        if "optimiser" not in memory:
            return True
        import torch

        leaves = [*point.free, *point.values]
        options = problem.options
        fresh = getattr(torch.optim, options.optimiser)([p.clone() for p in leaves], lr=options.rate).state_dict()
        saved = memory["optimiser"]
        if saved["param_groups"] != fresh["param_groups"] or not set(saved["state"]) <= set(range(len(leaves))):
            return False
        return all(
            isinstance(value, torch.Tensor) and value.shape in ((), leaves[place].shape)
            for place, row in saved["state"].items()
            for value in row.values()
        )

    def advance(self, problem: LearningProblem, state: TrainingState) -> TrainingState:
        """One pass over all samples, in an order drawn from the seed and the epoch if there are mini-batches."""
        import torch

        data, options = problem.data, problem.options
        network: Any = problem.network  # torch's
        leaves = [p.detach().clone().requires_grad_() for p in (*state.point.free, *state.point.values)]
        optimiser = getattr(torch.optim, options.optimiser)(leaves, lr=options.rate)
        if "optimiser" in state.memory:
            # A copy: the optimiser writes into what it is given, and ``state`` must stay what it was.
            optimiser.load_state_dict(deepcopy(state.memory["optimiser"]))
        size = options.batch or data.count
        random = np.random.default_rng([options.seed, state.epoch])
        order = torch.as_tensor(random.permutation(data.count)) if size < data.count else None
        kinds = len(state.point.free)
        for start in range(0, data.count, size):
            rows = slice(None) if order is None else order[start : start + size]
            optimiser.zero_grad()
            x, y = data.rows(rows)
            u = network.premises.scale(x)
            loss = (network.output(leaves[:kinds], leaves[kinds:], u) - y).square().mean()
            loss.backward()
            optimiser.step()
            with torch.no_grad():
                for leaf, legal in zip(leaves[:kinds], network.premises.valid(leaves[:kinds]), strict=True):
                    leaf.copy_(legal)
        point = Point(tuple(p.detach() for p in leaves[:kinds]), [p.detach() for p in leaves[kinds:]])
        return state._replace(point=point, epoch=state.epoch + 1, memory={"optimiser": optimiser.state_dict()})
