"""The command ``fuzzy doctor``: what it finds agrees with pip's own list and with pyproject.toml."""

import json
import re
import tomllib
from importlib.metadata import version
from pathlib import Path

import pytest

from fuzzy.commands import doctor
from fuzzy.commands.application import main
from fuzzy.compiled import jit
from kernels.__main__ import pack

ROOT = Path(__file__).parents[3]
DEVELOPMENT = {"bench", "docs", "jupyter", "mpc", "release", "test"}


def project():
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


@pytest.fixture
def declared(monkeypatch):
    """The requirements of this tree, whatever is installed."""
    lines = [*project()["dependencies"]]
    for extra, asked in project()["optional-dependencies"].items():
        lines += [f"{line}; extra == '{extra}'" for line in asked]
    monkeypatch.setattr("importlib.metadata.requires", lambda name: lines)
    monkeypatch.setattr("fuzzy.extras.requires", lambda name: lines)
    return lines


def examined(capsys, code=0):
    assert main(["doctor", "--json"]) == code
    return json.loads(capsys.readouterr().out)


def test_every_extra_that_is_not_for_development_has_a_purpose():
    assert {*doctor.EXTRAS} == {*project()["optional-dependencies"]} - DEVELOPMENT


def test_versions_and_threads_are_those_that_are_there(declared, capsys):
    found = examined(capsys)
    assert found["ok"]
    assert found["faults"] == []
    assert {each["name"]: each["version"] for each in found["packages"]} == {
        name: version(name) for name in (re.split("[>=<]", line)[0] for line in project()["dependencies"])
    }
    assert found["threads"]["processors"] >= 1
    assert main(["doctor"]) == 0
    assert capsys.readouterr().out.endswith("nothing is wrong\n")


def test_what_an_extra_lacks_is_named_with_the_command_that_brings_it(declared, capsys, monkeypatch):
    declared.append("no-such-package>=2; extra == 'design'")
    (design,) = [each for each in examined(capsys)["extras"] if each["name"] == "design"]
    assert not design["installed"]
    assert "'no-such-package>=2'" in design["install"]


@pytest.mark.parametrize(
    ("line", "sentence"),
    [
        ("no-such-package>=2", "no-such-package is not installed: pip install 'no-such-package>=2'"),
        ("numpy>=99", f"numpy {version('numpy')} is too old: pip install 'numpy>=99'"),
    ],
)
def test_a_package_that_is_missing_or_too_old_is_a_fault(line, sentence, declared, capsys):
    declared.append(line)
    assert examined(capsys, 1)["faults"] == [sentence]


def test_kernels_are_counted(tmp_path, capsys, monkeypatch, declared):
    files = [tmp_path / f"{name}.{jit._PYTHON}.nbc" for name in "abc"]
    for file in (*files, tmp_path / "numbas-own.py311.1.nbc"):
        file.write_bytes(b"x")
    pack(files[:2], tmp_path / "x86-64-v2.kernels")
    capsys.readouterr()
    monkeypatch.setattr(jit, "_PACKAGED", tmp_path)
    monkeypatch.setattr(jit.config, "CACHE_DIR", str(tmp_path))
    kernels = examined(capsys)["kernels"]
    assert kernels == {"shipped": {"x86-64-v4": 0, "x86-64-v3": 0, "x86-64-v2": 2}, "kept": {str(tmp_path): 3}}


def test_a_file_that_was_changed_after_installation_is_named(tmp_path, monkeypatch, capsys, declared):
    about = tmp_path / "fuzzyfleet-9.dist-info"
    about.mkdir()
    (tmp_path / "fuzzy").mkdir()
    (tmp_path / "fuzzy" / "whole.txt").write_bytes(b"")
    (tmp_path / "fuzzy" / "other.txt").write_bytes(b"other")
    empty = "sha256=47DEQpj8HBSa-_TImW-5JCeuQeRkm5NMpJWZG3hSuFU,0"  # of no bytes, as any sha256 says
    files = [f"fuzzy/{name}.txt,{empty}" for name in ("whole", "other", "gone")]
    (about / "RECORD").write_text("\n".join(files) + "\n")
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: fuzzyfleet\nVersion: 9\n")
    monkeypatch.syspath_prepend(tmp_path)
    assert examined(capsys, 1)["faults"] == [
        "files are not as they were installed, fuzzy/other.txt, fuzzy/gone.txt: "
        "pip install --force-reinstall fuzzyfleet --no-deps"
    ]
