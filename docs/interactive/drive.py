"""The simulator's loop as WebAssembly: the page on which a rule base steers a robot, without Python behind it.

The equations of laws, wheels, motors, body, encoders and pose sensor are those of the simulator, from Python to C by
the translator of ``robotics export c``; ``drive.c`` is the loop around them. ``python docs/interactive/drive.py`` makes
``drive.wasm`` anew where clang and wasm-ld are (Debian: apt install clang lld): a change of these equations needs it,
and tests compare it with the simulator. The site itself needs no compiler.
"""

import subprocess
import tempfile
from base64 import b64encode
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

import robotics
from fuzzy.compiled import packed
from fuzzy.compiled.tables import KIND, NUMBERS
from fuzzy.membership import Trapezoid, Triangle
from fuzzy.plugins.ccode.numbertype import FLOATING
from fuzzy.plugins.designer.design import design_of
from fuzzy.plugins.designer.views import design_data, functions_data
from robotics.laws.catalogue import as_law
from robotics.laws.setting import Setting
from robotics.laws.tracking.fuzzy_tracking import load_rule_base, rule_base_files
from robotics.plugins.ccode.source import AIM_SYMBOLS, law_sources
from robotics.plugins.ccode.terms import PIECES, Arithmetic, CArray, CRecord, CTable, CTerm, KnownValue, Lane, piece
from robotics.plugins.ccode.translation import Translator
from robotics.world.paths.road import rows_at
from robotics.world.sensing import posture
from robotics.world.vehicle import plant

HERE = Path(__file__).parent
WASM = HERE / "drive.wasm"
DURATION = 20.0  # s
MOST_LATE = 15  # steps of 10 ms: the latency that the page goes up to
MOST_NUMBERS = 512  # of a packed rule base
SEEDS = (1, 2, 3)
PATHS = {"sine": "lyapunov-sine", "circle": "lyapunov-circle"}
BASES = {"tracking": "tracking, 16 rules", "correcting": "correcting, 9 rules"}
SLIDERS = {
    "noise": {"words": "Noise of the pose", "unit": "mm, mrad", "max": 20, "step": 1},
    "latency": {"words": "Latency", "unit": "ms", "max": 10 * MOST_LATE, "step": 10},
}
# Laws by their number in the module; those of rules drive by the rule base of that name
LAWS = {"tracking": "fuzzy", "correcting": "fuzzy-correcting", "lyapunov": "lyapunov:lead=auto,smooth=0.2"}
_DOUBLE = FLOATING["double"]
_FLAGS = (
    "--target=wasm32", "-std=c99", "-O2", "-nostdlib", "-fno-builtin", "-ffp-contract=off", "-mbulk-memory",
    "-Wl,--no-entry", "-Wl,--allow-undefined", "-Wl,--strip-all", "-Wl,--stack-first", "-Wl,-z,stack-size=16384",
)  # fmt: skip
_EXPORTS = ("drive", "aims", "ahead", "early", "trace", "rules", "parameters", "draws", "noise")
_MATH = """#define NAN __builtin_nan("")
#define HUGE_VAL __builtin_huge_val()
#define isnan(x) __builtin_isnan(x)
#define isfinite(x) __builtin_isfinite(x)
#define sqrt __builtin_sqrt
#define fabs __builtin_fabs
#define floor __builtin_floor
double sin(double), cos(double), atan2(double, double), hypot(double, double), fmod(double, double);
"""


def scenario(path: str, **changes: Any) -> robotics.Scenario:
    """The scenario of a path of the page, with changes such as its latency."""
    return replace(robotics.load_scenario(PATHS[path]), duration=DURATION, **changes)


# C ------------------------------------------------------------------------------------------------------------------


def _read(table: CTable | Lane, row: Any) -> Any:
    """An entry of an array, or a column of one lane of it."""
    if isinstance(table, CTable):
        return CTerm(f"{table.name}[{row}]", "real")
    column = table.of.columns[row]
    if column.of is not None:
        return Lane(table.name, column.of, table.first + column.row)
    return CTerm(f"{table.name}[{table.first + column.row}]", "real")


class _Real(Arithmetic):
    """Encoders may count beyond the whole numbers of C."""

    def called(self, name: str, arguments: Any) -> Any:
        if name != "floor":
            return super().called(name, arguments)
        return CTerm(f"floor({self.real(arguments[0])})", "real")


def _constant(text: str, value: float) -> CTerm:
    return CTerm(_DOUBLE.constant(value), "real")


def plant_text(setting: Setting) -> str:
    """The plant, the encoders, the pose sensor and the degree of a term, translated."""
    arithmetic = _Real(_DOUBLE)
    translator = Translator("drive", arithmetic, _read, lambda *_: NotImplemented, _constant)
    z, one, zero, first = CTable("z"), KnownValue(1), KnownValue(0), plant.BlockColumns.parameter.row
    period, step = KnownValue(setting.period), KnownValue(plant.STEP)
    lanes = [CTable("z", first), z]
    senses = SimpleNamespace(posed=(True,), since=(0.0,), until=(np.inf,), gain=(1.0,), relative_draws=())
    senses.draws = CArray("draws", "real", (1, setting.ticks + 1, 3, 1))
    senses.noise = CArray("noise", "real", (3, 0))
    k, (x, a, b, c, d) = CTerm("k", "int"), (CTerm(name, "real") for name in "xabcd")
    measured = [CTable("posture"), CTable("velocity"), k, k, period]
    for function, arguments in (
        (plant._begin, [z, one]),
        (plant._loops, [z, one, step, zero]),
        (plant._move, [z, one, KnownValue(plant.STEP / plant.SUBSTEPS), KnownValue(1.0)]),
        (plant._odometry, [z, one, step]),
        (posture.encoders_of, [zero, *lanes, CTable("counts"), period, CTable("velocity")]),
        (posture.measure_of, [zero, zero, zero, CRecord("senses", senses), *lanes, *measured]),
        (packed._at_trapezoid, [x, a, b, c, d]),
    ):
        translator.function(function, arguments)
    columns = plant.BlockColumns
    names = {"X": 0, "Y": 1, "HEADING": 2, "ODO_X": columns.state.row + plant.TruthColumns.odo_x.row}
    names |= {"ODO_Y": names["ODO_X"] + 1, "ODO_HEADING": names["ODO_X"] + 2}
    names |= {"VOLT_R": columns.volt_r.row, "VOLT_L": columns.volt_l.row, "Z": columns.size}
    names |= {"FIRST_PARAMETER": first, "PARAMETERS": plant.ParameterColumns.size, "SAMPLES": setting.ticks + 1}
    names |= {"STEPS": round(setting.period / plant.STEP), "SUBSTEPS": plant.SUBSTEPS, "MOST_LATE": MOST_LATE}
    names |= {"MOST_NUMBERS": MOST_NUMBERS, "TRIANGLE": KIND.Triangle}
    names |= {f"AT_{name}": column.row for name, column in packed.PackedColumns.columns.items()}
    return "\n".join(
        [
            '#include "math.h"',
            f"enum {{{', '.join(f'{name} = {number}' for name, number in names.items())}}};",
            f"#define DIVERGENCE {_DOUBLE.constant(setting.divergence)}",
            "static double z[Z], counts[2], velocity[2], posture[3];",
            "double draws[1][SAMPLES][3][1], noise[3];",
            *(piece(name, _DOUBLE) for name in PIECES if name in arithmetic.needed),
            *(function.text for function in translator.done.values()),
        ]
    )


def law_texts(setting: Setting) -> dict[str, str]:
    """The files of all laws, and ``laws.h``, which calls each of them."""
    names = ("x", "y", "heading", "v", "w")
    seen = dict(zip(names, [*(f"posture[{n}]" for n in range(3)), "velocity[0]", "velocity[1]"], strict=True))
    files, head, starts, steps = dict[str, str](), [], [], []
    for number, (name, specification) in enumerate(LAWS.items()):
        law: Any = as_law(specification)
        sources = law_sources(law, setting, name)
        files |= {f"{name}.c": sources.source, f"{name}.h": sources.header}
        for base in sources.bases:
            files[f"{base.name}.h"] = base.header
            head.append(f"int {base.name}_infer(const double *x, double *y) {{\n    infer(x, y);\n    return 0;\n}}")
        given = dict(seen)
        leads = float(np.ravel(law.knowledge_rows(setting)[0])[0]) > 0
        for n, at in enumerate(names):
            given[f"at_{at}"] = f"early[k * STEPS + late][{n - 3}]" if leads and n > 2 else f"aims[k][{n}]"
            given[AIM_SYMBOLS[n]] = f"ahead[k][{n}]"
        inputs = ", ".join(f".{field} = {given[field]}" for field in sources.inputs)
        head += [f'#include "{name}.h"', f"static {name}_state {name}_now;"]
        starts.append(f"    {name}_init(&{name}_now);")
        steps += [
            f"    if (law == {number}) {{",
            f"        const {name}_input input = {{{inputs}}};",
            f"        {name}_output output;",
            f"        {name}_step(&{name}_now, &input, &output);",
            "        order[0] = output.v;\n        order[1] = output.w;\n    }",
        ]
    step = "static void step(int law, int k, double *order) {"
    lines = [*head, "static void start(void) {", *starts, "}", step, *steps, "}", ""]
    return files | {"laws.h": "\n".join(lines)}


def written(folder: Path) -> list[str]:
    """Write the whole program in C into a folder; return the names of the files to compile, for any machine."""
    setting = scenario("sine").setting
    files = {"plant.h": plant_text(setting), **law_texts(setting)}
    files["drive.c"] = (HERE / "drive.c").read_text(encoding="utf-8")
    for file, text in files.items():
        (folder / file).write_text(text, encoding="utf-8")
    return sorted(file for file in files if file.endswith(".c"))


def build(target: Path) -> Path:
    """Compile the module into ``target``; the same compiler makes the same bytes of it."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        sources = written(folder)
        (folder / "math.h").write_text(_MATH, encoding="utf-8")
        exported = [f"-Wl,--export={name}" for name in _EXPORTS]
        subprocess.run(["clang", *_FLAGS, *exported, "-I.", *sources, "-o", target.resolve()], cwd=folder, check=True)
    target.chmod(0o644)  # it is no program
    return target


# The page's data ----------------------------------------------------------------------------------------------------


def _kept(values: Any) -> str:
    """Numbers as text, to the last bit."""
    return b64encode(np.ascontiguousarray(values, dtype="<f8").tobytes()).decode()


def rule_base(name: str) -> dict[str, Any]:
    """A packaged rule base: its numbers for the module, where its terms have theirs, the design and the file."""
    fis = load_rule_base(name)
    numbers, second = packed.packed(fis), fis.inputs[1]
    header = packed.PackedColumns(numbers)
    kinds = {type(f) for variable in fis.inputs for f in variable.terms.values()}
    assert kinds <= {Triangle, Trapezoid}, kinds  # what drive.c knows
    assert header.clip
    assert header.weighted_sum == header.and_min == header.logs == fis.structure.is_or.max() == 0
    assert ((fis.structure.power == 1) | (fis.structure.term < 0)).all()
    terms = [(i, NUMBERS[type(f)], t) for i, v in enumerate(fis.inputs) for t, f in enumerate(v.terms.values())]
    return {
        "title": BASES[name],
        "numbers": _kept(numbers),
        "at": {name: column.row for name, column in packed.PackedColumns.columns.items()},
        "terms": [(i, t) for i, _, t in sorted(terms)],
        "consequents": fis.structure.consequent.tolist(),
        "design": design_data(design_of(fis)),
        "text": rule_base_files()[name].read_text(encoding="utf-8"),
        "point": [sum(v.universe) / 2 for v in fis.inputs],
        "selected": {"kind": "input", "variable": second.name, "term": [*second.terms][len(second.terms) // 2]},
    }


def road(path: str) -> dict[str, Any]:
    """The reference of a path as the laws read it: in each period, ahead of it, and early as the latency asks."""
    setting = scenario(path).setting
    laws: list[Any] = [as_law(specification) for specification in LAWS.values()]
    each = round(setting.period / plant.STEP)
    late = [scenario(path, latency=n * plant.STEP).setting for n in range(each)]
    leads = np.array([np.ravel(laws[1].knowledge_rows(told)[0])[0] for told in late])
    steps = np.arange(setting.ticks * each + MOST_LATE + 1)

    def at(times: np.ndarray) -> np.ndarray:
        return rows_at(setting.references.road, times[:, None])[:5, :, 0].T

    return {
        "title": path,
        "start": setting.starts[0].tolist(),
        "aims": _kept(at(setting.times)),
        "ahead": _kept(at(setting.times + laws[0].look_ahead)),
        "early": _kept(at(steps // each * setting.period + leads[steps % each])[:, 3:]),
    }


def drawn(seed: int) -> str:
    """The pose sensor's noise of a seed, in standard deviations: what the simulator draws after the start's."""
    generator = np.random.default_rng(seed)
    generator.standard_normal((1, 3))
    return _kept(generator.standard_normal((scenario("sine").setting.ticks + 1, 3)))


def data() -> dict[str, Any]:
    """All that the page holds."""
    setting = scenario("sine").setting
    return {
        "module": b64encode(WASM.read_bytes()).decode(),
        "laws": [*LAWS],
        "robot": plant.parameters(setting.robots[0]).tolist(),
        "samples": setting.ticks + 1,
        "period": setting.period,
        "step": plant.STEP,
        "sliders": SLIDERS,
        "paths": {path: road(path) for path in PATHS},
        "draws": {seed: drawn(seed) for seed in SEEDS},
        "bases": {name: rule_base(name) for name in BASES},
        "functions": functions_data(),
    }


if __name__ == "__main__":
    print(build(WASM), WASM.stat().st_size, "bytes")
