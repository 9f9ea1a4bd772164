"""A system in C on a Cortex-M4 that QEMU plays: what it needs of flash and RAM, and how many instructions a call takes.

QEMU is not exact to the cycle: it counts instructions (``-icount shift=0``), of which a Cortex-M4 takes about one a
cycle without wait states, and several cycles for a division or a load.
"""

import re
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fuzzy.plugins.ccode.compiler import STRICT, CompilerError
from fuzzy.plugins.ccode.numbertype import FIXED_POINT, c_type, given_in, read_from
from fuzzy.plugins.ccode.phrases import signature
from fuzzy.plugins.ccode.proofpoints import answers_of, proof_points
from fuzzy.plugins.ccode.writing import CFiles
from fuzzy.system import Sugeno

TOOLS = ("arm-none-eabi-gcc", "arm-none-eabi-size", "qemu-system-arm")
_POINTS = 200
_REPEATS = 40  # of each point between two looks at the clock
_PER_TICK = 40  # instructions: the board's 25 MHz against QEMU's one instruction a nanosecond
_MACHINE = ("-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16", "-O2", "-ffunction-sections")
_LINK = ("-nostartfiles", "--specs=nano.specs", "-Wl,--gc-sections", "-T")
_TIME = 120  # s
_HERE = Path(__file__).parent / "board"


@dataclass(frozen=True)
class OnBoard:
    """What a Cortex-M4 needs for a system."""

    flash: int  # bytes: code and tables, with what they take of the mathematical library
    ram: int  # bytes: static data, and the function's own stack
    instructions: int  # of the slowest of the points
    median: int  # of all points
    equal: bool  # whether its answers are those of the same C on this machine, within rounding of the libraries
    compiler: str


def missing_tools() -> list[str]:
    """The tools that are not there."""
    return [tool for tool in TOOLS if shutil.which(tool) is None]


def run_on_board(fis: Sugeno, files: CFiles, seed: int = 0) -> OnBoard:
    """Compile the C of a system for a Cortex-M4 and run it in QEMU.

    Args:
        fis: The system.
        files: What :func:`fuzzy.plugins.ccode.writing.write_c` has written of it.
        seed: Of the choice of the points.

    Raises:
        CompilerError: A tool is missing, or what a tool says.
    """
    if missing := missing_tools():
        raise CompilerError(
            f"there is no {', '.join(missing)} "
            "(Debian: apt install gcc-arm-none-eabi libnewlib-arm-none-eabi qemu-system-arm)"
        )
    x = proof_points(fis, _POINTS, seed, inside=True)
    if files.number != FIXED_POINT:
        x = x.astype(np.float32).astype(float)  # few digits, which the board's source holds
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        (folder / "points.h").write_text(_points(x, files), encoding="utf-8")
        whole = _linked(files, folder, files.source, "whole.elf")
        stub = folder / "stub.c"
        stub.write_text(_stub(files), encoding="utf-8")
        empty = _linked(files, folder, stub, "empty.elf")
        flash, static = (a - b for a, b in zip(_size(whole), _size(empty), strict=True))
        ticks, sums = _ran(whole)
        stack = _stack(folder / f"{files.name}.su", f"{files.name}_infer")
        counts = np.array(ticks) * _PER_TICK // _REPEATS
        version = _said("arm-none-eabi-gcc", "--version").partition("\n")[0]
    return OnBoard(
        flash, static + stack, int(counts.max()), int(np.median(counts)), _equal(fis, files, x, sums), version
    )


def _points(x: np.ndarray, files: CFiles) -> str:
    kept, _ = given_in(x, files.number)
    suffix = "f" if files.number == "float" else ""
    rows = ",\n".join("{" + ", ".join(f"{value!r}{suffix}" for value in row) + "}" for row in kept.tolist())
    name, upper, real = files.name, files.name.upper(), c_type(files.number)
    return (
        f'#include "{name}.h"\n#define POINTS {len(x)}\n#define REPEATS {_REPEATS}\ntypedef {real} real;\n'
        f"#define INPUTS {upper}_INPUTS\n#define OUTPUTS {upper}_OUTPUTS\n#define infer {name}_infer\n"
        f"static const real points[POINTS][INPUTS] = {{\n{rows}\n}};\n"
    )


def _stub(files: CFiles) -> str:
    head = signature(files.name, c_type(files.number))
    return f'#include "{files.name}.h"\n{head} {{\n    y[0] = x[0];\n    return 0;\n}}\n'


def _linked(files: CFiles, folder: Path, source: Path, target: str) -> Path:
    include = (f"-I{files.header.parent}", f"-I{folder}")
    made = folder / f"{source.stem}.o"
    _said("arm-none-eabi-gcc", *STRICT, *_MACHINE, *include, "-fstack-usage", "-c", str(source), "-o", str(made))
    line = (*_MACHINE, *include, str(_HERE / "board.c"), str(made), *_LINK, str(_HERE / "board.ld"), "-lm")
    _said("arm-none-eabi-gcc", *line, "-o", str(folder / target))
    return folder / target


def _size(program: Path) -> tuple[int, int]:
    """Bytes of flash and of static RAM."""
    text, data, bss = map(int, _said("arm-none-eabi-size", str(program)).splitlines()[1].split()[:3])
    return text + data, data + bss


def _stack(usage: Path, function: str) -> int:
    """The stack of a function of the system, with those of ours that it calls, as the compiler says."""
    found = [int(m[1]) for m in re.finditer(r":\w+\t(\d+)\t", usage.read_text(encoding="utf-8"))]
    own = re.search(rf":{function}\t(\d+)\t", usage.read_text(encoding="utf-8"))
    own_size = int(own[1]) if own else 0
    return own_size + max([size for size in found if size != own_size], default=0)


def _ran(program: Path) -> tuple[list[int], list[list[int]]]:
    """The ticks of each point, and its outputs' bits, as the board prints them."""
    said = _said(
        "qemu-system-arm",
        *("-machine", "mps2-an386", "-display", "none", "-monitor", "none", "-serial", "none"),
        *("-icount", "shift=0", "-semihosting-config", "enable=on,target=native", "-kernel", str(program)),
    )
    rows = [line.split() for line in said.splitlines() if line.startswith("point ")]
    if len(rows) != _POINTS:
        raise CompilerError(f"the board printed {len(rows)} points of {_POINTS}: {said[-200:]!r}")
    return [int(row[1], 16) for row in rows], [[int(word, 16) for word in row[2:]] for row in rows]


def _equal(fis: Sugeno, files: CFiles, x: np.ndarray, words: list[list[int]]) -> bool:
    """Whether the board's answers are those of the system, as far as the number type goes."""
    y = read_from(np.array(words, dtype=np.uint32).tobytes(), files.number).reshape(len(x), -1)
    _, given = given_in(x, files.number)
    wanted = answers_of(fis, given) if files.lookup is None else files.lookup.answers(fis, given)
    span = np.array([max(v.span, 1e-9) for v in fis.outputs])
    spread = np.maximum(span, np.nanmax(np.abs(wanted), axis=0))
    rounding = {"double": 1e-12, "float": 1e-4, FIXED_POINT: 1e-3}[files.number]
    return bool((np.abs(y - wanted) <= rounding * spread).all())


def _said(*line: str) -> str:
    done = subprocess.run(line, capture_output=True, text=True, check=False, timeout=_TIME)
    if done.returncode != 0:
        raise CompilerError(f"{line[0]} ended with {done.returncode}: {done.stderr.strip()[:800]}")
    return done.stdout + done.stderr
