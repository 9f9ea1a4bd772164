"""The file of a certificate: all that its checker needs, as JSON, in decimals that read back the same."""

from pathlib import Path
from typing import Any

import numpy as np

from fuzzy.files.atomic import write_json
from fuzzy.membershipfunction import as_number
from fuzzy.system import Linear, Sugeno
from robotics.plugins.certificates.certificate import CertificateError
from robotics.plugins.certificates.checker import FORMAT
from robotics.plugins.certificates.loopcolumns import ASKED, LevelColumns, LoopColumns
from robotics.plugins.certificates.loopmodel import ClosedLoop
from robotics.plugins.certificates.regions import LoopCertificate
from robotics.plugins.certificates.statechecker import STATES_FORMAT
from robotics.plugins.certificates.wheels import WINDOW

_ROWS = ("formula", "count", "places", "given")


def contents(certificate: Any) -> dict[str, Any]:
    """What a file holds of a certificate, as values of JSON."""
    about = {"law": certificate.loop.title, **numbers_of(certificate.loop)}
    if isinstance(certificate, LoopCertificate):
        form = LevelColumns(certificate.form)
        return {"format": FORMAT, **about, "V": {n: float(getattr(form, n)) for n in LevelColumns.columns}}
    return {"format": STATES_FORMAT, **about, "V": list(certificate.cells)}


def numbers_of(loop: ClosedLoop) -> dict[str, Any]:
    """What it holds of a loop; raises CertificateError for a weighted sum, which the checker does not know."""
    numbers = LoopColumns(loop.numbers)
    if loop.rules is not None and loop.rules.defuzzification != "wtaver":
        raise CertificateError(f"{loop.title}: a certificate's file is of rules with the weighted average only")
    told = {name: getattr(numbers, name) for name in LoopColumns.columns if name not in _ROWS}
    return {
        "loop": {n: v.tolist() if np.ndim(v) else float(v) for n, v in told.items()} | {"window": float(WINDOW)},
        "rules": None if loop.rules is None else _rules(loop.rules, [ASKED[int(i)] for i in numbers.places]),
    }


def write_certificate(certificate: Any, path: str | Path) -> None:
    """Write a certificate's file."""
    write_json(path, contents(certificate))


def _rules(fis: Sugeno, quantities: list[str]) -> dict[str, Any]:
    """A rule base in numbers."""
    s = fis.structure
    outputs = [list(v.terms.values()) for v in fis.outputs]

    def says(o: int, r: int) -> list[float] | None:
        place = int(s.consequent[o, r])
        if place < 0:
            return None
        found = outputs[o][place]
        slopes = [as_number(p) for p in found.parameters[:-1]] if isinstance(found, Linear) else [0.0] * len(fis.inputs)
        return [as_number(found.parameters[-1]), *slopes]

    return {
        "clip": fis.out_of_range == "clip",
        "and": fis.and_method,
        "or": fis.or_method,
        "inputs": [
            {
                "quantity": quantities[i],
                "low": v.universe[0],
                "high": v.universe[1],
                "terms": [[t.matlab, list(t.numbers)] for t in v.terms.values()],
            }
            for i, v in enumerate(fis.inputs)
        ],
        "outputs": [v.name for v in fis.outputs],
        "rules": [
            {
                "or": bool(s.is_or[r]),
                "weight": float(s.weight[r]),
                "clauses": [
                    [i, int(s.term[i, r]), float(s.power[i, r]), bool(s.negated[i, r])]
                    for i in range(len(fis.inputs))
                    if s.term[i, r] >= 0
                ],
                "then": [says(o, r) for o in range(len(fis.outputs))],
            }
            for r in range(len(fis.rules))
        ],
    }
