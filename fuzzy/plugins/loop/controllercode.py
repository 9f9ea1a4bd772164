"""The whole controller of a loop in C: the rules, and all that stands round them; and the proof that it is the same."""

import re
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from fuzzy.files.atomic import write_together
from fuzzy.plugins.ccode.compiler import SANITIZERS, find_compiler, run_program
from fuzzy.plugins.ccode.numbertype import FLOATING, Floating
from fuzzy.plugins.ccode.source import c_sources
from fuzzy.plugins.loop.controller import LoopError, Roles, RuleController, factor_of, roles_of
from fuzzy.plugins.loop.response import Loop, SampledController
from fuzzy.system import Sugeno

PROVEN = {"double": 1e-12, "float": 1e-3}  # greatest differences of the control, shares of its span
_HERE = Path(__file__).parent
_SAMPLES = 20_000  # of the proof's random reference and measurement
_SEEN = {"error": "error", "error_rate": "rate", "error_sum": "total", "scheduling": "operating"}


class ControllerFiles(NamedTuple):
    """The files of a controller in C, by name, and in which numbers they are."""

    texts: dict[str, str]
    name: str  # the prefix of the functions
    number: str  # "double" or "float"


@dataclass(frozen=True)
class ProvenController:
    """How far the control of the C is from the loop's own, over random references and measurements.

    Attributes:
        samples: How many.
        greatest: The greatest difference, in the control's unit.
        span: The control's, over these samples.
        limited: The share of samples at a limit of the actuator.
        compiler: Which compiler made the program; it ran under sanitizers too where there are any.
        holds: Whether the difference is within what the type of numbers allows.
    """

    samples: int
    greatest: float
    span: float
    limited: float
    compiler: str
    holds: bool


def controller_code(
    fis: Sugeno, loop: Loop, roles: Roles | None = None, name: str = "", number: str = "double"
) -> ControllerFiles:
    """A rule base and the loop round it as C99: NAME.h, NAME.c, NAME_control.h and NAME_control.c.

    Args:
        fis: The rule base.
        loop: Its sample time, scale factors, limits and filter are the controller's.
        roles: What its variables are; by default what their names say.
        name: The prefix of everything public; by default the system's own.
        number: "double" or "float".

    Returns:
        The texts of the files, by name.

    Raises:
        LoopError: Names that say nothing, or another type of numbers.
        ExportError: What C does not have.
    """
    if number not in FLOATING:
        raise LoopError(f"a controller is written in {' or '.join(FLOATING)}, got {number!r}: its integral needs them")
    roles = roles_of(fis) if roles is None else roles
    kind, rules = FLOATING[number], c_sources(fis, name, number)
    words = _words(loop, roles, kind)
    texts = {f"{rules.name}.h": rules.header, f"{rules.name}.c": rules.source}
    for ending in ("h", "c"):
        text = (_HERE / f"controller.{ending}").read_text(encoding="utf-8")
        texts[f"{rules.name}_control.{ending}"] = _filled(text, words, rules.name, kind)
    return ControllerFiles(texts, rules.name, number)


def _words(loop: Loop, roles: Roles, kind: Floating) -> dict[str, str]:
    """What stands for the words of the templates."""
    scale, keep = loop.scale, loop.rate_filter / (loop.rate_filter + loop.period)
    inputs = [
        f"    x[{k}] = {_SEEN[role]} * {kind.constant(factor_of(scale, role))};" for k, role in enumerate(roles.inputs)
    ]

    def output(role: str, factor: float) -> str:
        return f"{kind.constant(factor)} * y[{roles.outputs.index(role)}]" if role in roles.outputs else "0"

    scheduled = "scheduling" in roles.inputs
    return {
        " OPERATING": ", REAL operating" if scheduled else "",
        " SCHEDULED": ", operating" if scheduled else "",
        "INPUTS": "\n".join(inputs),
        "OUTPUT_U": output("u", scale.Ku),
        "OUTPUT_DU": output("du", scale.Kdu),
        "PERIOD": kind.constant(loop.period),
        "KEEP": kind.constant(keep),
        "TAKE": kind.constant(1 - keep),
        "LOW": f"({kind.constant(loop.low)})",
        "HIGH": f"({kind.constant(loop.high)})",
    }


def _filled(text: str, words: dict[str, str], name: str, kind: Floating) -> str:
    text = re.sub(rf"\b({'|'.join(words)})\b", lambda found: words[found[0]], text)
    if kind.infinity in text:  # a loop without limits
        text = text.replace('_control.h"\n', '_control.h"\n\n#include <math.h>\n', 1)
    return text.replace("NAME", name).replace("UPPER", name.upper()).replace("REAL", kind.name)


def write_controller(files: ControllerFiles, folder: str | Path) -> list[Path]:
    """Write the files, each whole or not at all.

    Args:
        files: What :func:`controller_code` has made.
        folder: Where to, made if it is not there.

    Returns:
        The paths of the files.

    Raises:
        OSError: Nothing can be written.
    """
    return write_together(folder, files.texts)


def prove_controller(
    files: ControllerFiles, fis: Sugeno, loop: Loop, roles: Roles | None = None, seed: int = 0
) -> ProvenController:
    """Compile the C with all warnings as errors, and compare its control with the loop's own, sample by sample.

    Reference and measurement are random, small and large by turns, so that inputs leave their universes, the actuator
    reaches its limits and the integrals are clamped.

    Args:
        files: What :func:`controller_code` has made of the others.
        fis: The rule base.
        loop: The loop round it.
        roles: What its variables are; by default what their names say.
        seed: Of the reference and measurement.

    Returns:
        How far the C is from the loop's own control.

    Raises:
        CompilerError: There is no compiler, or it refuses the C.
        LoopError: The rules give no number where the proof begins.
    """
    roles = roles_of(fis) if roles is None else roles
    kind, compiler = FLOATING[files.number], find_compiler()
    given = _signals(loop, _operating(fis, roles), seed).astype(kind.type)
    read = {"GIVEN": ", ".join(f"given[{k}]" for k in range(2 + ("scheduling" in roles.inputs)))}
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        write_controller(files, folder)
        driver = _filled((_HERE / "driver.c").read_text(encoding="utf-8"), read, files.name, kind)
        (folder / "driver.c").write_text(driver, encoding="utf-8")
        (folder / "given").write_bytes(given.tobytes())
        sources = [folder / "driver.c", *(folder / name for name in files.texts if name.endswith(".c"))]
        kinds = [("-O2", "-ffp-contract=off"), *([("-O1", *SANITIZERS)] if compiler.sanitizes(folder) else [])]
        for flags in kinds:
            program = compiler.compile(sources, folder / "driver", *flags)
            run_program(program, str(folder / "given"), str(folder / "answers"))
        found = np.frombuffer((folder / "answers").read_bytes(), kind.type).astype(float)
    asked, wanted = SampledController(RuleController(fis, roles, loop.scale), loop), []
    for reference, measured, operating in given.astype(float).tolist():
        u = asked(reference - measured, operating)
        if u != u:  # the C holds the last one there, the simulation ends
            break
        wanted.append(u)
    if not wanted:
        raise LoopError(f"{fis.name} gives no number where the proof begins: no rule fires there")
    control = np.array(wanted)
    greatest, span = float(np.abs(found[: len(control)] - control).max()), float(np.ptp(control))
    limited = float(np.mean((control <= loop.low) | (control >= loop.high)))
    holds = greatest <= PROVEN[files.number] * max(span, 1e-300)
    return ProvenController(len(control), greatest, span, limited, compiler.version, holds)


def _operating(fis: Sugeno, roles: Roles) -> tuple[float, float]:
    """Between what the operating variable is to wander: its universe, and a quarter beyond each end."""
    if "scheduling" not in roles.inputs:
        return 0.0, 0.0
    low, high = fis.inputs[roles.inputs.index("scheduling")].universe
    return low - (high - low) / 4, high + (high - low) / 4


def _signals(loop: Loop, ends: tuple[float, float], seed: int) -> np.ndarray:
    """Random references, measurements and operating variables (samples, 3): steps of the reference, and walks of
    several sizes about it, and to and fro between the ``ends``."""
    rng = np.random.default_rng(seed)
    size = max(abs(loop.reference), 1e-6)
    hold = np.repeat(rng.uniform(-1.5, 1.5, _SAMPLES // 200) * size, 200)
    reach = np.repeat(rng.choice([1e-3, 0.05, 0.5, 3.0], _SAMPLES // 200) * size, 200)
    walk = np.cumsum(rng.normal(0, 0.05, _SAMPLES))
    measured = hold - reach * np.sin(walk) + rng.normal(0, 1e-3 * size, _SAMPLES)
    wandering = ends[0] + (ends[1] - ends[0]) * (0.5 + 0.5 * np.sin(0.2 * walk))
    return np.stack([hold, measured, wandering], axis=1)
