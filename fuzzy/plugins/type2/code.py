"""An interval type-2 system in C: the type-1 writer's tables and degrees, with lower degrees and type reduction."""

from dataclasses import replace
from pathlib import Path
from typing import Any

from fuzzy.compiled.tables import LEAST_STRENGTH
from fuzzy.files.atomic import write_together
from fuzzy.membershipfunction import as_number
from fuzzy.plugins.ccode.numbertype import FIXED_POINT, FLOATING, ExportError, Floating, checked_number
from fuzzy.plugins.ccode.plan import CodePlan, planned
from fuzzy.plugins.ccode.source import CSources, FloatWriter, header
from fuzzy.plugins.ccode.writing import CFiles
from fuzzy.plugins.type2.system import Type2Sugeno


def write_c_type2(fis: Type2Sugeno, folder: str | Path, number: str = "double", *, name: str = "") -> CFiles:
    """Write an interval type-2 system as one header and one source of C99, that allocate nothing and need only math.h.

    Args:
        fis: The system.
        folder: Where to write, made if it is not there.
        number: "double" or "float".
        name: The files' name and the functions' prefix; by default the system's.

    Returns:
        The files that were written.

    Raises:
        ExportError: What C, or the type of numbers, does not have.
        OSError: Nothing can be written.
    """
    if checked_number(number) == FIXED_POINT:
        raise ExportError(f"{fis.name}: a type-2 system is written in double or float, not in {number}")
    plan, kind = replace(planned(fis.upper, name), logs=False), FLOATING[number]
    about = f"an interval type-2 Takagi-Sugeno system of {plan.rules} rules"
    sources = CSources(plan.name, header(plan, kind.name, about), _Type2Writer(plan, kind, fis).source())
    top, source = write_together(folder, sources.texts)
    return CFiles(top, source, plan.name, number, None)


class _Type2Writer(FloatWriter):
    """The source of the system whose upper one is laid out."""

    template = "type2_infer.c.j2"

    def __init__(self, plan: CodePlan, number: Floating, fis: Type2Sugeno) -> None:
        super().__init__(plan, number)
        self.fis = fis

    def tables(self) -> list[str]:
        """Tables, however few rules there are."""
        return [*self._rule_tables(), *self._consequent_tables()] if self.plan.rules else []

    def more(self) -> dict[str, Any]:
        """The lower degrees, and how strengths are reduced."""
        return {"lower": self._lower, "nietan": self.fis.reduction == "nietan", "least_strength": LEAST_STRENGTH}

    def _lower(self, k: int) -> str:
        """The lower degree of the term ``k``, from the upper one."""
        term = self.plan.terms[k]
        own = list(self.fis.lower[self.fis.inputs[term.input].name].values())[term.place]
        scale, peak = as_number(own.scale), self.number.constant(self.fis.peaks[term.input][term.place])
        sides = [
            f"lowered(degree[{k}], {self.number.constant(lag)}, {self.number.constant(scale / (1 - lag))})"
            for lag in map(as_number, own.lag)
        ]
        return sides[0] if sides[0] == sides[1] else f"{term.variable} < {peak} ? {sides[0]} : {sides[1]}"
