"""A method of learning as CONTRIBUTING.md says it: one file, and a line in METHODS for who wants it."""

from anfis.methods.method import LearningProblem, Method
from anfis.state import TrainingState


class Halving(Method):
    """Moves the premises down the gradient by the first option ``step``, half as far every epoch."""

    reads = ("step", "ridge", "batch")
    gradient = True

    def first_step(self, options):
        return options.step

    def advance(self, problem: LearningProblem, state: TrainingState) -> TrainingState | None:
        pull = state.memory["gradient"]
        largest = max(float(g.abs().max()) for g in pull)
        if not largest > 0:
            return None
        free = [p - state.step * g / largest for p, g in zip(state.point.free, pull, strict=True)]
        point = state.point._replace(free=problem.network.premises.valid(free))
        memory = {**state.memory, "steps": state.memory.get("steps", 0) + 1}
        return state._replace(point=point, epoch=state.epoch + 1, step=state.step / 2, memory=memory)
