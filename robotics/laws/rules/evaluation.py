"""A rule base among the quantities that robots know: its inputs by name, and its outputs over all other robots."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from fuzzy.compiled.sugeno import CompiledSugeno, compile_sugeno
from fuzzy.naming import check_known
from fuzzy.system import Sugeno
from robotics.laws.law import ControllerError
from robotics.laws.rules.quantities import QUANTITY_GROUPS, Quantity, quantity_of
from robotics.laws.rules.situation import Situation
from robotics.laws.setting import Setting
from robotics.laws.tracking.fuzzy_tracking import called, load_rule_base

ADDED = frozenset({"turn", "w"})  # outputs that add up over the other robots; of all others the least holds


@dataclass(frozen=True, eq=False)
class RuleBase:
    """A rule base whose inputs are quantities of :mod:`robotics.laws.rules.quantities`, and its outputs by name."""

    fis: Sugeno
    compiled: CompiledSugeno = field(repr=False)
    inputs: tuple[Quantity, ...] = field(repr=False)
    outputs: Mapping[str, int]

    @classmethod
    def of(cls, name: str | Sugeno, outputs: Mapping[str, str], task: str) -> "RuleBase":
        """Read the rule base of that name or file. Raises ControllerError or FisFileError.

        Args:
            name: A name of robotics/data/rulebases, the path of a ``.fis`` file, or the system itself.
            outputs: The outputs that it may have, each with what it means.
            task: What messages call it.
        """
        fis = load_rule_base(name)
        if fis.out_of_range == "warn":  # what a sensor reads, or that it reads nothing, is often out of range
            fis = replace(fis, out_of_range="clip")
        for variable in fis.outputs:
            check_known(variable.name, outputs, f"output of {task}", ControllerError, where=called(name))
        inputs = tuple(quantity_of(variable.name, called(name)) for variable in fis.inputs)
        places = {variable.name: k for k, variable in enumerate(fis.outputs)}
        return cls(fis, compile_sugeno(fis, sample=True), inputs, places)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the system alone: its quantities are functions, which other processes find by their names."""
        return _restored, (self.fis, dict(self.outputs))

    @property
    def of_pairs(self) -> bool:
        """Whether it is evaluated once for each other robot."""
        return any(quantity.pair for quantity in self.inputs)

    @property
    def radio(self) -> bool:
        """Whether robots must tell each other where they are."""
        return any(quantity.radio for quantity in self.inputs)

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

    def asked(self, situation: Situation, neutral: Mapping[str, float]) -> tuple[dict[str, np.ndarray], np.ndarray]:
        """What it says in ``situation``, by output, (runs, robots) each; and its inputs (inputs, runs, robots).

        Where it is of pairs, turns of all other robots add up and of all else the least holds; the inputs are those of
        the robot for which the least was said. ``neutral`` is what it says of a robot that is not heard. A rule base
        without rules says nothing.
        """
        known = self.known(situation)
        said = self(known) if self.fis.rules else {}
        if not self.of_pairs:
            return said, np.moveaxis(known, -1, 0)
        ignored = ~situation.seen.heard.hears | np.isnan(situation.others.gap)
        out = {}
        for name, values in said.items():
            values = np.where(ignored, neutral[name], values)
            out[name] = values.sum(axis=-1) if name in ADDED else values.min(axis=-1)
        worst = self._most_urgent(said, ignored)
        inputs = np.take_along_axis(known, worst[..., None, None], axis=-2)[..., 0, :]
        alone = ignored.all(axis=-1)  # nobody is heard: there are no inputs to show
        return out, np.moveaxis(np.where(alone[..., None], np.nan, inputs), -1, 0)

    @staticmethod
    def _most_urgent(said: Mapping[str, np.ndarray], ignored: np.ndarray) -> np.ndarray:
        """The place of the other robot of which the first output that does not add up is least, or the turn largest."""
        least = [name for name in said if name not in ADDED]
        if least:
            return np.asarray(np.where(ignored, np.inf, said[least[0]]).argmin(axis=-1))
        turn = np.abs(next(iter(said.values()))) if said else 0.0
        return np.asarray(np.where(ignored, -1.0, turn).argmax(axis=-1))

    def known(self, situation: Situation) -> np.ndarray:
        """Its inputs (runs, robots, inputs), or where it is of pairs (runs, robots, others, inputs)."""
        rows = [np.asarray(quantity.of(situation), dtype=float) for quantity in self.inputs]
        if self.of_pairs:
            shape = (*situation.place.shape, situation.place.shape[1])
            rows = [
                np.broadcast_to(row if quantity.pair else row[..., None], shape)
                for row, quantity in zip(rows, self.inputs, strict=True)
            ]
        out = np.empty((*rows[0].shape, len(rows)))
        for k, (row, variable) in enumerate(zip(rows, self.fis.inputs, strict=True)):
            out[..., k] = np.nan_to_num(row, nan=variable.universe[1], posinf=variable.universe[1])
        return out

    def __call__(self, known: np.ndarray) -> dict[str, np.ndarray]:
        """Its outputs by name, with the axes of ``known`` but the last."""
        out = self.compiled(known)
        return {name: out[..., k] for name, k in self.outputs.items()}


def _restored(fis: Sugeno, outputs: dict[str, int]) -> RuleBase:
    """Make the rule base again that was pickled."""
    return RuleBase(
        fis, compile_sugeno(fis, sample=True), tuple(quantity_of(v.name, fis.name) for v in fis.inputs), outputs
    )
