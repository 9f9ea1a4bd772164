"""A lesson: what rule base is to be learnt, from which law, on what, and how."""

from dataclasses import dataclass, field
from pathlib import Path

import anfis
from fuzzy.errors import InputError
from fuzzy.naming import check_known
from fuzzy.quantity import check_quantities, described, quantity, whole
from robotics.laws.catalogue import make_controller
from robotics.laws.rules.own_rules import OwnRules
from robotics.laws.rules.quantities import quantity_of
from robotics.laws.specification import Specification
from robotics.laws.tracking.fuzzy_tracking import TRACKING_INPUTS
from robotics.plugins.learning.demonstrations import ImitationTask

RIDGE = 1e-5  # of the least squares: without it, rules that few samples determine say anything beside them
COMMAND_UNITS = {"v": "m/s", "w": "rad/s", "speed": "m/s", "dv": "m/s", "dw": "rad/s", "bend": "1/m"}


class ImitationError(InputError):
    """A teacher, inputs or outputs of which no rule base can be learnt."""


@dataclass(frozen=True, kw_only=True)
class ImitationPlan:
    """What is to be learnt, from whom, and how."""

    teacher: str  # a controller's specification
    courses: tuple[ImitationTask, ...]
    inputs: tuple[str, ...] = described("Inputs: quantities of docs/reference/quantities.md.")
    outputs: tuple[str, ...] = described(
        "Outputs: v, w, or speed for at most; dv, dw, bend: what corrects the reference's velocity.", ("v", "w")
    )
    into: str = described("The law that drives by the rule base, and its gain that names it.", "fuzzy:rule_base")
    seeds: tuple[int, ...] = tuple(range(12))
    rules: int = whole(12, least=1, most=30, doc="Number of rules.")
    rounds: int = whole(3, least=0, most=20, doc="Rounds in which the learner drives and the teacher corrects it.")
    disturbance: float = quantity(
        1.0,
        "1",
        least=0,
        most=10,
        doc="Disturbance of every second run; 1: starts 0.2 m and 0.3 rad off, pushes of 0.05 m/s and 0.3 rad/s.",
    )
    options: anfis.Options = field(default_factory=lambda: anfis.Options(epochs=30, ridge=RIDGE))

    def __post_init__(self) -> None:
        check_quantities(self, ImitationError)
        for what, names in (("input", self.inputs), ("output", self.outputs)):
            if not names:
                raise ImitationError(f"a rule base needs an {what}")
            for name in names:
                if names.count(name) > 1:
                    raise ImitationError(f"the {what} {name!r} is given twice")
        for name in self.inputs:
            quantity_of(name, "inputs")
        for name in self.outputs:
            check_known(name, COMMAND_UNITS, "output that a teacher shows", ImitationError)
        if len(self.seeds) < 2:
            raise ImitationError("at least two seeds are needed: one to learn from, and one to check with")
        if not self.courses:
            raise ImitationError("at least one scenario or stress test is needed to drive")
        if "=" in self.into.rpartition(",")[2] or ":" not in self.into:
            raise ImitationError(
                f"into must end in the gain that names the rule base, such as fuzzy:rule_base; got {self.into!r}"
            )
        law = Specification.of(self.into)
        tracking = not law.file and law.name.startswith("fuzzy") and set(self.inputs) <= set(TRACKING_INPUTS)
        if tracking and isinstance(make_controller(law.name), OwnRules):
            raise ImitationError(
                f"a rule base of {', '.join(self.inputs)} alone is that of fuzzy tracking itself, which takes its "
                "inputs from a point ahead of the target; add another input, such as y_err"
            )
        if self.of_pairs and self.outputs != ("speed",):
            raise ImitationError(
                f"inputs that are told of each other robot ({', '.join(self.pairs)}) belong to the output speed alone: "
                "of all other robots the least speed holds, and v and w are not shown for each of them"
            )

    @property
    def name(self) -> str:
        """The name of the rule base."""
        return f"{Specification.of(self.teacher).short}-learnt"

    @property
    def pairs(self) -> tuple[str, ...]:
        """The inputs that are told of each other robot."""
        return tuple(name for name in self.inputs if quantity_of(name, "inputs").pair)

    @property
    def of_pairs(self) -> bool:
        """Whether the rule base is asked about each other robot."""
        return bool(self.pairs)

    def controller(self, file: str | Path) -> str:
        """The specification of the controller that drives by the rule base in ``file``."""
        return f"{self.into}={file}"

    def check_file(self, file: Path) -> None:
        """Raise ImitationError unless a controller's specification can name ``file``."""
        if file.suffix != ".fis" or "," in str(file):
            raise ImitationError(f"{file}: the file's name must end in .fis, and hold no comma")

    @property
    def checking(self) -> tuple[int, ...]:
        """The seeds that are not learnt from."""
        return self.seeds[3::4] or self.seeds[-1:]
