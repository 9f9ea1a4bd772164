"""Systems in C, many in one library, called from here: independent of the proof that the package makes itself."""

import ctypes
import shutil
import warnings
from pathlib import Path

import numpy as np
import pytest

from fuzzy.inference import infer
from fuzzy.plugins.ccode.compiler import find_compiler
from fuzzy.plugins.ccode.source import CSources, c_sources
from fuzzy.system import Sugeno

KINDS = {"double": np.float64, "float": np.float32, "q16.16": np.int32}
ROOT = Path(__file__).parents[4]
CORPUS = sorted((ROOT / "tests" / "data" / "fis-corpus").glob("*.fis"))
PACKAGED = sorted((ROOT / "robotics" / "data" / "rulebases").rglob("*.fis"))

needs_compiler = pytest.mark.skipif(
    not any(map(shutil.which, ("cc", "gcc", "clang"))), reason="there is no C compiler here"
)


class Library:
    """Systems compiled into one shared library, without optimisation, with the undefined-behaviour sanitizer."""

    def __init__(self, systems: list[Sugeno], number: str, folder: Path) -> None:
        self.number, self.systems = number, systems
        self.sources: list[CSources] = [c_sources(fis, f"s{k}", number) for k, fis in enumerate(systems)]
        for sources in self.sources:
            (folder / f"{sources.name}.h").write_text(sources.header)
            (folder / f"{sources.name}.c").write_text(sources.source)
        flags = ("-shared", "-fPIC", "-O0", "-fsanitize=undefined", "-fno-sanitize-recover=all")
        target = folder / f"systems-{number}.so"
        find_compiler().compile([folder / f"{s.name}.c" for s in self.sources], target, *flags)
        self.library = ctypes.CDLL(str(target))

    def answers(self, k: int, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The points as the C has them, its answers, and what it tells of each point."""
        kind, fis = KINDS[self.number], self.systems[k]
        infer_ = getattr(self.library, f"s{k}_infer")
        fixed = self.number == "q16.16"
        whole = np.clip(np.round(np.nan_to_num(x, posinf=0, neginf=0) * 65536), -(2**31), 2**31 - 1)
        given = np.ascontiguousarray(whole if fixed else x).astype(kind)
        y, told = np.empty((len(x), len(fis.outputs)), kind), np.empty(len(x), int)
        for row in range(len(x)):
            told[row] = infer_(ctypes.c_void_p(given[row].ctypes.data), ctypes.c_void_p(y[row].ctypes.data))
        scale = 65536.0 if fixed else 1.0
        return given.astype(float) / scale, y.astype(float) / scale, told


def wanted(fis: Sugeno, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The answers of the inference (n, outputs), what its rules propose weighted, and the strengths for each output."""
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        layers = infer(fis, x)
        share = layers.firing if fis.defuzzification == "wtsum" else layers.weights
        proposed = (share[..., None] * np.abs(layers.rule_outputs)).sum(axis=-2)
        strengths = layers.firing @ (fis.structure.consequent >= 0).T.astype(float)
    return layers.output, proposed, strengths
