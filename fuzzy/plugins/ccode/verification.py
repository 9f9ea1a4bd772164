"""The proof of a system in C: compiled, run on many points, compared with the inference here, and watched."""

import tempfile
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fuzzy.inference import Inference, InferenceWarning, infer
from fuzzy.plugins.ccode.compiler import SANITIZERS, Compiler, CompilerError, find_compiler, run_program
from fuzzy.plugins.ccode.numbertype import FIXED_POINT, ONE, c_type, given_in, read_from
from fuzzy.plugins.ccode.phrases import filled
from fuzzy.plugins.ccode.proofpoints import answers_of, proof_points
from fuzzy.plugins.ccode.writing import CFiles
from fuzzy.system import Sugeno

# Greatest differences, shares of an output's span
LIMITS = {"double": 4e-15, "float": 1e-6, FIXED_POINT: 0.01}
_POINTS = 1_000_000
_FAINTEST = {"double": 1e-300, "float": 1e-17}  # strengths, below which a type has few digits or none
_SANITIZED = 20_000  # points that are also run under the sanitizers
_WEIGHED = 4096  # points at which the proposals of the rules are looked at


@dataclass(frozen=True)
class OutputDifference:
    """How far one output of the C is from the inference here."""

    output: str
    greatest: float  # in the output's unit
    mean: float
    span: float  # its range, or the spread of its answers where that is wider
    scale: float  # the span, or what the rules propose, weighted, where that is more and cancels
    at: tuple[float, ...]  # where it is greatest

    @property
    def share(self) -> float:
        """The greatest difference as a share of the span."""
        return self.greatest / self.span if self.span > 0 else self.greatest


@dataclass(frozen=True)
class Verified:
    """What a proof has found.

    Attributes:
        number: The type of numbers that was compared.
        points: At how many points.
        differences: Between C and system, an output each.
        compiler: Which compiler made the program.
        sanitized: Whether it ran under sanitizers; False: the compiler has none.
        holds: Whether the differences are within what the type allows; None: a table has no limit.
    """

    number: str
    points: int
    differences: tuple[OutputDifference, ...]
    compiler: str
    sanitized: bool
    holds: bool | None


def verify_c(
    fis: Sugeno,
    files: CFiles,
    points: int = _POINTS,
    seed: int = 0,
    advance: Callable[[str], None] = lambda step: None,
    answers: Callable[[np.ndarray], np.ndarray] | None = None,
) -> Verified:
    """Compile the C of a system with all warnings as errors, run it, and compare it with the system.

    The points lie in the universes of discourse and 20 % beyond, a quarter of them at and around the parameters of the
    membership functions. A lookup table is compared in the universes only, and has no limit. In fixed point the C may
    answer what the system answers one last digit of an input beside the point, as it does at edges and feet, and
    anything where the system answers not-a-number, which fixed point lacks.

    Args:
        fis: The system.
        files: What :func:`fuzzy.plugins.ccode.writing.write_c` has written of it.
        points: How many.
        seed: Of their choice.
        advance: Told what is done next.
        answers: What the C should answer (points, outputs) at points (points, inputs); by default what ``fis`` does. Of
            a type-2 system ``fis`` is the upper one, and this the type-2 system itself, compiled.

    Returns:
        The greatest difference of each output, and whether it is within what the type of numbers allows.

    Raises:
        CompilerError: There is no compiler, it refuses the C, or the C fails under a sanitizer.
    """
    compiler = find_compiler()
    x = proof_points(fis, points, seed, files.lookup is not None)
    if files.number == FIXED_POINT:
        x = np.nan_to_num(x, posinf=0.0)  # it has neither
    given, x = given_in(x, files.number)
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        program = _program(compiler, files, folder)
        advance("comparing")
        y = _ran(program, given, len(fis.outputs), files.number, folder)
        advance("under the sanitizers")
        sanitized = compiler.sanitizes(folder)
        if sanitized:
            watched = _program(compiler, files, folder, "-O1", "-g", *SANITIZERS)
            again = _ran(watched, given[:_SANITIZED], len(fis.outputs), files.number, folder)
            if not np.array_equal(again, y[: len(again)], equal_nan=True):
                raise CompilerError(f"{files.source.name}: other answers under the sanitizers than without them")
    wanted = answers_of(fis, x, answers)
    if files.number == FIXED_POINT:
        wanted = np.clip(wanted, -32768.0, 32768.0)  # where the C stays
    error = _error(y, wanted)
    if files.number == FIXED_POINT and files.lookup is None:
        error = _less_a_digit(fis, x, y, np.where(np.isnan(wanted), 0.0, error))
    differences = _differences(fis, x, wanted, error)
    holds = _within(fis, x, error, differences, files.number) if files.lookup is None else None
    return Verified(files.number, len(x), differences, compiler.version, sanitized, holds)


def _program(compiler: Compiler, files: CFiles, folder: Path, *flags: str) -> Path:
    driver = folder / "driver.c"
    words = {"NAME": files.name, "UPPER": files.name.upper(), "REAL": c_type(files.number)}
    driver.write_text(filled(Path(__file__).with_name("driver.c"), **words), encoding="utf-8")
    include = f"-I{files.header.parent}"
    return compiler.compile([driver, files.source], folder / "driver", include, *(flags or ("-O2",)))


def _ran(program: Path, given: np.ndarray, outputs: int, number: str, folder: Path) -> np.ndarray:
    (folder / "points").write_bytes(given.tobytes())
    run_program(program, str(folder / "points"), str(folder / "answers"))
    return read_from((folder / "answers").read_bytes(), number).reshape(-1, outputs)


def _differences(fis: Sugeno, x: np.ndarray, wanted: np.ndarray, error: np.ndarray) -> tuple[OutputDifference, ...]:
    known = np.isfinite(x).all(axis=1)
    scales = _scales(fis, x[known])
    found = []
    for o, variable in enumerate(fis.outputs):
        finite = wanted[known, o][np.isfinite(wanted[known, o])]
        spread = float(np.ptp(finite)) if len(finite) else 0.0
        span = max(variable.span, spread)
        worst = int(np.argmax(error[:, o]))
        found.append(
            OutputDifference(
                variable.name,
                float(error[worst, o]),
                float(error[:, o].mean()),
                span,
                max(span, float(scales[o])),
                tuple(map(float, x[worst])),
            )
        )
    return tuple(found)


def _error(y: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """The differences; 0 where both are not-a-number or the same infinity, infinite where only one is."""
    with np.errstate(invalid="ignore"):
        error = np.abs(y - wanted)
    error = np.where((np.isnan(wanted) & np.isnan(y)) | (y == wanted), 0.0, error)
    return np.where(np.isnan(error), np.inf, error)


def _less_a_digit(fis: Sugeno, x: np.ndarray, y: np.ndarray, error: np.ndarray) -> np.ndarray:
    """The differences in fixed point, where they are large those from the answers one last digit of an input beside."""
    spans = np.array([v.span for v in fis.outputs])
    rows = np.flatnonzero((error > LIMITS[FIXED_POINT] * spans).any(axis=1))
    least = error[rows]
    for step in np.vstack([np.eye(x.shape[1]), -np.eye(x.shape[1])]) / ONE:
        least = np.fmin(least, np.abs(y[rows] - answers_of(fis, x[rows] + step)))
    error[rows] = least
    return error


def _layers(fis: Sugeno, x: np.ndarray) -> Inference:
    with warnings.catch_warnings(action="ignore", category=InferenceWarning), np.errstate(all="ignore"):
        return infer(fis, x)


def _scales(fis: Sugeno, x: np.ndarray) -> np.ndarray:
    """What the rules propose (outputs,), weighted, at most: rounding in their sum is a share of it."""
    layers = _layers(fis, x[:_WEIGHED])
    share = layers.firing if fis.defuzzification == "wtsum" else layers.weights
    return np.asarray(np.nan_to_num((share[..., None] * np.abs(layers.rule_outputs)).sum(axis=-2)).max(axis=0))


def _within(
    fis: Sugeno, x: np.ndarray, error: np.ndarray, differences: tuple[OutputDifference, ...], number: str
) -> bool:
    """Whether all differences are within the limit.

    Where all rules that fire do so by a difference 1 − μ of little size, the same rounding is a larger share of it,
    here as there: at such points the limit is a share of the sum of their strengths. What fires more faintly than the
    least number of the type does not fire. Fixed point has so few digits that this would excuse wrong answers.
    """
    allowed = np.array([LIMITS[number] * d.scale for d in differences])
    if all(d.greatest <= a for d, a in zip(differences, allowed, strict=True)):
        return True
    if number == FIXED_POINT:
        return False
    rows = np.flatnonzero((error > allowed).any(axis=1))
    total = _layers(fis, x[rows]).firing @ (fis.structure.consequent >= 0).T.astype(float)
    within = error[rows] <= allowed / (np.clip(total, 1e-30, 1.0) if fis.structure.negated.any() else 1.0)
    return bool((within | ((total > 0) & (total < _FAINTEST[number]))).all())
