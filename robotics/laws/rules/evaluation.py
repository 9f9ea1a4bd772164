"""A rule base among the quantities that robots know: its inputs and outputs by name."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

import fuzzy
from fuzzy.compiled.sugeno import CompiledSugeno, compile_sugeno
from fuzzy.files.fisfile import Type2Error
from fuzzy.naming import check_known
from fuzzy.system import Sugeno
from robotics.laws.law import ControllerError
from robotics.laws.rules.quantities import QUANTITY_GROUPS, Quantity, quantity_of
from robotics.laws.setting import Setting
from robotics.laws.tracking.fuzzy_tracking import called, load_rule_base

ADDED = frozenset({"turn", "w"})  # outputs that add up over the other robots; of all others the least holds
MOST_INPUTS = 64  # of a rule base


@dataclass(frozen=True, eq=False)
class RuleBase:
    """A rule base whose inputs are quantities of :mod:`robotics.laws.rules.quantities`, and its outputs by name."""

    fis: Sugeno
    compiled: CompiledSugeno = field(repr=False)
    inputs: tuple[Quantity, ...] = field(repr=False)
    outputs: Mapping[str, int]
    composite: np.ndarray | None = field(default=None, repr=False)  # (n,): the row that is evaluated in its place

    @classmethod
    def of(cls, name: str | Sugeno, outputs: Mapping[str, str], task: str) -> "RuleBase":
        """Read the rule base of that name or file. Raises ControllerError or FisFileError.

        Args:
            name: A name of robotics/data/rulebases, the path of a ``.fis`` file, or the system itself.
            outputs: The outputs that it may have, each with what it means.
            task: What messages call it.
        """
        return cls._of(load_rule_base(name), name, outputs, task)

    @classmethod
    def of_composite(
        cls, whole: "fuzzy.Tree | fuzzy.Type2Sugeno", name: Any, outputs: Mapping[str, str], task: str
    ) -> "RuleBase":
        """That of a tree or of a type-2 system: of its inputs and outputs, without rules, and with its row.

        Raises ControllerError, and FuzzySystemError of a membership function that compiled code does not know.
        """
        made: Any = whole.mapped(_clipped)
        row = (fuzzy.compile_tree if isinstance(whole, fuzzy.Tree) else fuzzy.compile_type2)(made).row
        shell = Sugeno(whole.inputs, [replace(v, terms={}) for v in whole.outputs], (), whole.name)
        return replace(cls._of(shell, name, outputs, task), composite=row)

    @classmethod
    def _of(cls, fis: Sugeno, name: Any, outputs: Mapping[str, str], task: str) -> "RuleBase":
        fis = _clipped(fis)
        for variable in fis.outputs:
            check_known(variable.name, outputs, f"output of {task}", ControllerError, where=called(name))
        inputs = tuple(quantity_of(variable.name, called(name)) for variable in fis.inputs)
        if len(inputs) > MOST_INPUTS:
            raise ControllerError(
                f"{called(name)}: a rule base that drives has at most {MOST_INPUTS} inputs, not {len(inputs)}"
            )
        places = {variable.name: k for k, variable in enumerate(fis.outputs)}
        return cls(fis, compile_sugeno(fis, sample=True), inputs, places)

    @property
    def of_pairs(self) -> bool:
        """Whether it is evaluated once for each other robot."""
        return any(quantity.pair for quantity in self.inputs)

    @property
    def sensors(self) -> tuple[str, ...]:
        """The range sensors that it names."""
        return tuple(quantity.sensor for quantity in self.inputs if quantity.sensor)

    @property
    def looks(self) -> bool:
        """Whether it asks for the room around the robot."""
        return any(
            v.name in QUANTITY_GROUPS["The room around it"] or q.sensor
            for v, q in zip(self.fis.inputs, self.inputs, strict=True)
        )

    def check(self, setting: Setting, name: str | Sugeno) -> None:
        """Raise ControllerError where it names a robot that does not exist in ``setting``; ``name`` is its own."""
        for variable, known in zip(self.fis.inputs, self.inputs, strict=True):
            if known.robot > len(setting.robots):
                raise ControllerError(
                    f"{called(name)}: {variable.name} is of robot {known.robot}, and {setting.name} has "
                    f"{len(setting.robots)}"
                )


def _clipped(fis: Sugeno) -> Sugeno:
    """The system without warnings: what a sensor reads, or that it reads nothing, is often out of range."""
    return replace(fis, out_of_range="clip") if fis.out_of_range == "warn" else fis


def composite_of(rule_base: Any) -> "fuzzy.Tree | fuzzy.Type2Sugeno | None":
    """The tree or the type-2 system that a rule base is, itself, a tree's folder or a file; None of any other.

    Raises ControllerError, FisFileError or TreeError for a file that cannot be read.
    """
    if not isinstance(rule_base, str):
        return None if isinstance(rule_base, Sugeno) else rule_base
    if (Path(rule_base) / "tree.toml").is_file():
        return fuzzy.read_tree(rule_base)
    try:
        load_rule_base(rule_base)
    except Type2Error:
        return fuzzy.read_type2(rule_base)
    return None
