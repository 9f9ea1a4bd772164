"""Interval type-2 systems in C: compiled and run, the answers are those of the system, of all it can hold."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fuzzy
from fuzzy.commands.application import main
from fuzzy.plugins import ccode
from fuzzy.plugins.ccode.compiler import find_compiler, run_program
from fuzzy.plugins.ccode.numbertype import ExportError
from fuzzy.plugins.ccode.phrases import filled
from tests.fuzzy.plugins.type2.drawn import drawn

silent_places = pytest.mark.filterwarnings("ignore:.*no rule fires:fuzzy.inference.InferenceWarning")


def run(fis: fuzzy.Type2Sugeno, x: np.ndarray, folder: Path, number: str = "double") -> np.ndarray:
    """The answers of the C, in the type of numbers."""
    files = fuzzy.write_c_type2(fis, folder, number)
    words = {"NAME": files.name, "UPPER": files.name.upper(), "REAL": number}
    driver = folder / "driver.c"
    driver.write_text(filled(Path(ccode.__file__).with_name("driver.c"), **words), encoding="utf-8")
    program = find_compiler().compile([driver, files.source], folder / "driver", f"-I{folder}", "-O1")
    kind: Any = np.float64 if number == "double" else np.float32
    (folder / "points").write_bytes(np.ascontiguousarray(x, dtype=kind).tobytes())
    run_program(program, str(folder / "points"), str(folder / "answers"))
    return np.frombuffer((folder / "answers").read_bytes(), kind).reshape(len(x), -1).astype(float)


@silent_places
@pytest.mark.parametrize("systems", [4, pytest.param(40, marks=pytest.mark.long)])
def test_random_systems_answer_as_in_python(systems, tmp_path):
    for seed in range(systems):
        rng = np.random.default_rng(seed)
        fis = drawn(rng)
        x = rng.uniform(-1, 11, (2000, 2))
        np.testing.assert_allclose(run(fis, x, tmp_path), fis(x), rtol=1e-12, atol=1e-12, err_msg=str(seed))


def versatile(**more: Any) -> fuzzy.Type2Sugeno:
    """Hedges, "not", "or", weights, two outputs of which not every rule speaks, lags to both sides."""
    a = fuzzy.Variable(
        "a", (0, 10), {"low": fuzzy.LinearZ(0, 6), "mid": fuzzy.Triangle(2, 5, 8), "w": fuzzy.LinearS(4, 9)}
    )
    b = fuzzy.Variable("b", (0, 1), {"off": fuzzy.Gaussian(0.3, 0), "on": fuzzy.Bell(0.4, 2, 1)})
    u = fuzzy.Variable("u", (-5, 5), {"p": -4, "q": 1, "r": 4.5})
    v = fuzzy.Variable("v", (0, 9), {"s": fuzzy.Linear([0.5, 0], 1), "t": fuzzy.Linear([0, 3], 0)})
    rules = [
        "if a is low and b is not on then u is p, v is s",
        "if a is mid or b is off then u is q with 0.4",
        "if a is very w and b is somewhat on then v is t",
        "if a is not low then u is r",
    ]
    upper = fuzzy.Sugeno([a, b], [u, v], rules, "all of it", **more)
    return fuzzy.to_type2(upper, {"a": {"mid": (0.3, 0.1), "low": 0.2}}, {"a": {"w": 0.6}, "b": 0.8})


@silent_places
@pytest.mark.parametrize(
    "more",
    [{}, {"and_method": "min", "or_method": "max"}, {"out_of_range": "clip", "no_rule_fires": "nan"}],
    ids=["product", "min and max", "clipped"],
)
@pytest.mark.parametrize("reduction", ["karnikmendel", "nietan"])
def test_all_that_rules_can_say_is_the_same_in_c(more, reduction, tmp_path):
    fis = versatile(**{"out_of_range": "ignore", "or_method": "probor", **more})
    fis = fuzzy.Type2Sugeno(fis.upper, fis.lower, reduction)
    x = np.random.default_rng(1).uniform([-1, -0.1], [11, 1.1], (3000, 2))
    x[0, 0] = np.nan
    wanted = fis(x)
    np.testing.assert_allclose(run(fis, x, tmp_path), wanted, rtol=1e-12, atol=1e-12)
    assert np.isnan(wanted[0]).all()
    few = x.astype(np.float32)
    np.testing.assert_allclose(run(fis, few, tmp_path, "float"), fis(few.astype(float)), atol=1e-4)


@silent_places
def test_the_command_writes_and_proves(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    with pytest.warns(fuzzy.FisFileWarning):
        fuzzy.write_fis(versatile(), "wide.fis")
    assert main(["export", "c", "wide.fis", "-o", "out", "--verify", "--points", "20000"]) == 0
    assert "the same within 4e-15" in capsys.readouterr().out
    assert main(["export", "c", "wide.fis", "-o", "out", "--table", "9x9"]) == 2
    with pytest.raises(ExportError, match="double or float"):
        fuzzy.write_c_type2(versatile(), "out", "q16.16")
