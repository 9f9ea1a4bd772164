"""Files of machine code: what is damaged or of something else is compiled anew, what a wheel brings is used."""

import pickle
import platform
import shutil
from pathlib import Path
from random import Random

import numpy as np
import pytest
from numba import types

from fuzzy.compiled import jit, notice
from fuzzy.compiled.jit import kernel
from kernels.__main__ import pack
from tests.conftest import module_in
from tests.fuzzy.compiled.test_jit import compiled, python

V2 = "+cx16,+crc32,+popcnt,+sahf,+sse3,+sse4.1,+sse4.2,+ssse3"
V3 = f"{V2},+avx,+avx2,+bmi,+bmi2,+f16c,+fma,+lzcnt,+movbe,+xsave"
V4 = f"{V3},+avx512f,+avx512bw,+avx512cd,+avx512dq,+avx512vl"
on_x86 = pytest.mark.skipif(platform.machine() != "x86_64", reason="kernels are shipped for x86-64 only")


def doubled(x):
    return x * 2.0 + 1.0


def halved(x):
    return x / 2.0


@compiled
@pytest.mark.parametrize(
    ("where", "name", "value", "same"),
    [
        ("sys", "version", "3.11.99 (of another day) [another compiler]", True),
        ("numpy", "__version__", f"{np.__version__.rpartition('.')[0]}.99", True),
        ("numpy", "__version__", "3.1.0", False),
        ("sys", "version_info", (3, 99, 0), False),
        ("numba", "__version__", "0.999.0", False),
        ("llvmlite", "__version__", "0.999.0", False),
    ],
)
def test_a_fingerprint_has_the_versions_that_machine_code_depends_on(monkeypatch, where, name, value, same):
    function = kernel(doubled)
    with monkeypatch.context() as patch:
        patch.setattr(f"{where}.{name}", value)
        other = module_in(Path(jit.__file__))
    assert (other.fingerprint(function) == jit.fingerprint(function)) == same


@pytest.fixture
def kept(tmp_path, monkeypatch):
    """Two compiled functions whose files lie in a folder of their own, and what looks for one's code there."""
    monkeypatch.setattr("numba.core.config.CACHE_DIR", str(tmp_path))
    functions = [kernel(doubled), kernel(halved)]
    assert [function(4.0) for function in functions] == [9.0, 2.0]
    files = [next(tmp_path.rglob(f"*.{function.__name__}-*.nbc")) for function in functions]

    def found(function):
        return function._cache.load_overload((types.float64,), function.targetctx)

    assert all(found(function) is not None for function in functions)
    return functions, files, found


@compiled
def test_damaged_files_are_never_read(kept):
    (function, other), (file, beside), found = kept
    whole, draw = file.read_bytes(), Random(35)

    def flipped(bits):
        damaged = bytearray(whole)
        for place in draw.sample(range(8 * len(whole)), bits):
            damaged[place // 8] ^= 1 << place % 8
        return bytes(damaged)

    damages = [flipped(1) for _ in range(300)] + [flipped(draw.randrange(2, 40)) for _ in range(60)]
    damages += [whole[: draw.randrange(len(whole))] for _ in range(100)]
    damages += [whole + draw.randbytes(draw.randrange(1, 50)) for _ in range(20)]
    damages += [draw.randbytes(draw.randrange(200)) for _ in range(15)]
    damages += [b"", beside.read_bytes(), whole[32:], whole[:32], pickle.dumps((("stamp", ()), ()))]
    assert len(damages) == 500
    for content in damages:
        file.write_bytes(content)
        assert found(function) is None
    again = kernel(doubled)
    assert again(4.0) == 9.0
    assert sum(again.stats.cache_misses.values()) == 1
    assert found(function) is not None  # the file was written anew
    beside.unlink()
    beside.mkdir()
    assert found(other) is None


@compiled
def test_a_file_under_another_name_is_never_read(kept, monkeypatch):
    """Neither that of another function, nor of other types, another CPU or another fingerprint."""
    (function, other), (file, beside), found = kept
    whole, true = file.read_bytes(), jit.fingerprint
    beside.write_bytes(whole)
    assert found(other) is None

    def asked(sig=(types.float64,)):
        """The names under which its code is looked for."""
        names = []
        with monkeypatch.context() as patch:
            patch.setattr(jit, "_content", lambda file: names.append(file) or b"")
            assert function._cache.load_overload(sig, function.targetctx) is None
        return names

    (usual,) = asked()
    assert usual == file
    for forged in (f"{true(function)[:16]}{'0' * 48}", "0" * 64):
        monkeypatch.setattr(jit, "fingerprint", lambda _, forged=forged: forged)
        for name in asked():
            name.write_bytes(whole)
        assert found(function) is None
    monkeypatch.setattr(jit, "fingerprint", true)
    (name,) = asked((types.float32,))
    name.write_bytes(whole)
    assert function._cache.load_overload((types.float32,), function.targetctx) is None
    monkeypatch.setattr(type(function.targetctx.codegen()), "magic_tuple", lambda _: ("another", "machine", ""))
    (name,) = asked()
    name.write_bytes(whole)
    assert found(function) is None


@compiled
def test_a_damaged_archive_is_as_good_as_none(kept, tmp_path, monkeypatch):
    (function, _), (file, _), found = kept
    monkeypatch.setattr(jit, "_PACKAGED", tmp_path)
    monkeypatch.setattr(jit, "BASELINES", {"baseline": set()})
    triple = function.targetctx.codegen().magic_tuple()[0]
    monkeypatch.setattr(type(function.targetctx.codegen()), "magic_tuple", lambda _: (triple, "baseline", ""))
    file.unlink()
    function = kernel(doubled)
    assert function(4.0) == 9.0
    archive, draw = tmp_path / "baseline.kernels", Random(1)
    made = [*tmp_path.rglob("*.nbc")]
    pack(made, archive)
    whole = archive.read_bytes()
    for file in made:
        file.unlink()
    damages = [b"", whole[:99], whole[:-9], whole[32:], draw.randbytes(99)]
    for place in draw.sample(range(len(whole)), 40):
        flipped = bytearray(whole)
        flipped[place] ^= 4
        damages.append(bytes(flipped))
    for content in damages:
        archive.write_bytes(content)
        jit._unpacked.cache_clear()
        assert found(function) is None
    archive.write_bytes(whole)
    jit._unpacked.cache_clear()
    assert found(function) is not None
    jit._unpacked.cache_clear()


TOY = """
from fuzzy.compiled.jit import kernel

@kernel
def inner(x):
    return x * 3.0

@kernel
def outer(x):
    return inner(x) + 1.0
"""
RUN = """
from pathlib import Path
from fuzzy.compiled import jit
jit._PACKAGED = Path("shipped")
from toy.kernels import inner, outer
print(outer(5.0), inner(2.0))
print(*(sum(k.stats.cache_misses.values()) for k in (outer, inner)))
"""


@on_x86
@compiled
@pytest.mark.parametrize(
    ("features", "used"),
    [(V3, "x86-64-v3"), pytest.param(V2, "x86-64-v2", marks=pytest.mark.long), ("+sse2,+sse3", None)],
)
def test_the_kernels_of_a_wheel_are_used_by_a_cpu_that_can(tmp_path, features, used):
    (tmp_path / "toy").mkdir()
    (tmp_path / "toy" / "__init__.py").touch()
    (tmp_path / "toy" / "kernels.py").write_text(TOY, encoding="utf-8")
    for baseline in jit.BASELINES:
        machine = {"NUMBA_CPU_NAME": baseline, "NUMBA_CPU_FEATURES": "", "NUMBA_CACHE_DIR": str(tmp_path / baseline)}
        python(RUN, tmp_path, **machine)
        made = [*(tmp_path / baseline).rglob("*.nbc")]
        assert len(made) == 2
        if used in (baseline, None):
            pack(made, tmp_path / "shipped" / f"{baseline}.kernels")

    numbers, compilations = python(RUN, tmp_path, NUMBA_CPU_FEATURES=features)
    assert numbers == [16.0, 6.0]
    assert compilations == ([0, 0] if used else [1, 1])
    if used:
        # Where nothing can be written, they are used all the same.
        for folder in (tmp_path / "toy" / "__pycache__", tmp_path / "file"):
            shutil.rmtree(folder, ignore_errors=True)
            folder.touch()
        nowhere = {"HOME": str(tmp_path / "file"), "XDG_CACHE_HOME": str(tmp_path / "file")}
        assert python(RUN, tmp_path, NUMBA_CPU_FEATURES=features, **nowhere) == [[16.0, 6.0], [0, 0]]
        (tmp_path / "toy" / "__pycache__").unlink()
        # What was unpacked is one's own from then on.
        python(RUN, tmp_path, NUMBA_CPU_FEATURES=features)
        shutil.rmtree(tmp_path / "shipped")
        (tmp_path / "shipped").mkdir()
        pack([], tmp_path / "shipped" / f"{used}.kernels")
        assert python(RUN, tmp_path, NUMBA_CPU_FEATURES=features) == [[16.0, 6.0], [0, 0]]


@on_x86
def test_the_best_baseline_comes_first_and_needs_all_that_it_says(tmp_path, monkeypatch):
    monkeypatch.setattr(jit, "_PACKAGED", tmp_path)
    for baseline in jit.BASELINES:
        (tmp_path / f"{baseline}.kernels").touch()

    def found(features):
        return [cpu for _, (_, cpu, _) in jit._packaged("x86_64-unknown-linux-gnu", "any", features)]

    assert found(V4) == ["x86-64-v4", "x86-64-v3", "x86-64-v2"]
    assert found(V3) == ["x86-64-v3", "x86-64-v2"]
    for feature in V3.split(","):
        expected = ["x86-64-v2"] if feature not in V2.split(",") else []
        assert found(V3.replace(feature, f"-{feature[1:]}")) == expected
    assert found("") == []


def test_a_waiting_user_is_told_once_and_the_library_says_nothing(monkeypatch, capsys):
    now = [0.0]
    monkeypatch.setattr("time.monotonic", lambda: now[0])

    def compiling_at(*seconds):
        for now[0] in seconds:
            notice.compiling()
        return capsys.readouterr().err

    assert compiling_at(0, 10) == ""
    notice.watch(True)
    assert compiling_at(20, 21) == ""
    assert compiling_at(23, 24, 60).splitlines() == [
        "compiling functions for this machine, once; it can take a minute..."
    ]
    notice.watch(False)
    assert compiling_at(70, 80) == ""
