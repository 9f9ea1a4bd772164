"""Other distributions install packages called fuzzy, anfis and robotics: whoever has one beside ours is told so."""

import os
import subprocess
import sys
import zipfile
from importlib.machinery import EXTENSION_SUFFIXES

import pytest

import _fuzzyfleet
from tests.test_wheel import borrowing, built, pip

FUZZY = f"fuzzy{EXTENSION_SUFFIXES[0]}"
# As those on the index: their names, their versions and where their files lie.
STRANGERS = {
    "anfis-0.3.1": {
        "anfis/__init__.py": "import membership\n",
        "anfis/anfis.py": "",
        "anfis/membership/__init__.py": "",
    },
    "robotics-1.2": {"robotics/__init__.py": "name = 'robotics'\n"},
    "Fuzzy-1.2.2": {FUZZY: "not for this machine"},
}
AGAIN = "pip install --force-reinstall fuzzyfleet --no-deps"
HIDDEN = f"Fuzzy 1.2.2 installs {FUZZY}, which the package fuzzy of fuzzyfleet hides: pip uninstall Fuzzy"
OVERWRITTEN, SHARED = [
    sorted(
        f"the distribution {sentence}"
        for sentence in (
            HIDDEN,
            f"anfis 0.3.1 {before} anfis/__init__.py of fuzzyfleet{after}: pip uninstall anfis; {AGAIN}",
            f"robotics 1.2 {before} robotics/__init__.py of fuzzyfleet{after}: pip uninstall robotics; {AGAIN}",
        )
    )
    for before, after in (("has overwritten", ""), ("counts", " among its files and would delete it"))
]
GONE = [f"{{}}/{name}/__init__.py of fuzzyfleet is missing: {AGAIN}" for name in ("anfis", "robotics")]


@pytest.fixture(scope="module")
def ours(tmp_path_factory):
    return built(tmp_path_factory.mktemp("ours"), "py3-none-any")


@pytest.fixture(scope="module")
def strangers(tmp_path_factory):
    """Wheels of the strangers."""
    folder = tmp_path_factory.mktemp("strangers")
    return [wheel_of(folder, title, files) for title, files in STRANGERS.items()]


def wheel_of(folder, title, files):
    name, _, version = title.partition("-")
    about = f"{title}.dist-info"
    inside = files | {
        f"{about}/METADATA": f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n",
        f"{about}/WHEEL": "Wheel-Version: 1.0\nGenerator: test\nRoot-Is-Purelib: true\nTag: py3-none-any\n",
    }
    record = "".join(f"{file},,\n" for file in (*inside, f"{about}/RECORD"))
    wheel = folder / f"{title}-py3-none-any.whl"
    with zipfile.ZipFile(wheel, "w") as into:
        for file, text in {**inside, f"{about}/RECORD": record}.items():
            into.writestr(file, text)
    return wheel


def said(python, *command, code=0):
    """The sentences that a process ends with; ``command`` is one of ours, or what Python is to run."""
    clean = {k: v for k, v in os.environ.items() if not k.startswith("PYTHON")}
    words = [python, "-c", *command[1:]] if command[0] == "-c" else [python.parent / command[0], *command[1:]]
    done = subprocess.run(words, env=clean, cwd=python.parent, capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == code, done.stderr
    assert "Traceback" not in done.stderr
    lines = [line for line in done.stderr.splitlines() if "fuzzyfleet" in line and "warnings.warn" not in line]
    return sorted(line.rpartition("UserWarning: ")[2].removeprefix(f"{command[0]}: ") for line in lines)


def test_strangers_that_come_after_ours_are_named_wherever_our_code_still_runs(ours, strangers, tmp_path):
    python = borrowing(tmp_path)
    pip(python, ours)
    site = python.parent.parent / "lib" / f"python{sys.version_info[0]}.{sys.version_info[1]}" / "site-packages"
    assert said(python, "-c", "import fuzzy, anfis, robotics") == []
    pip(python, *strangers)
    assert said(python, "-c", "import fuzzy") == OVERWRITTEN
    assert said(python, "fuzzy", "--version") == OVERWRITTEN
    for program in ("anfis", "robotics"):
        assert said(python, program, "--version", code=2) == OVERWRITTEN
    # What the sentences say mends it; half of it does not.
    subprocess.run(
        [sys.executable, "-m", "pip", "--python", python, "uninstall", "-qy", "anfis", "robotics", "Fuzzy"], check=True
    )
    assert said(python, "robotics", "--version", code=2) == [sentence.format(site) for sentence in GONE]
    assert said(python, "fuzzy", "--version") == [sentence.format(site) for sentence in GONE]
    pip(python, ours, "--force-reinstall")
    assert said(python, "-c", "import fuzzy, anfis, robotics") == []
    assert said(python, "robotics", "--version") == []


def test_strangers_that_were_there_before_ours_are_named_by_all(ours, strangers, tmp_path):
    python = borrowing(tmp_path)
    pip(python, *strangers)
    pip(python, ours)
    for package in ("fuzzy", "anfis", "robotics"):
        assert said(python, "-c", f"import {package}") == SHARED
        assert said(python, package, "--version") == SHARED
    clean = {k: v for k, v in os.environ.items() if not k.startswith("PYTHON")}
    done = subprocess.run([python.parent / "fuzzy", "doctor"], env=clean, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert sorted(line for line in done.stdout.splitlines() if "distribution" in line) == SHARED


def test_where_nothing_is_wrong_nothing_is_read():
    code = "import sys, _fuzzyfleet; _fuzzyfleet.check(); print('importlib.metadata' in sys.modules)"
    done = subprocess.run([sys.executable, "-S", "-c", code], capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout == "False\n"


def test_each_package_bears_the_mark_by_which_it_is_known():
    assert _fuzzyfleet.PACKAGES == ("fuzzy", "anfis", "robotics")
    for name in _fuzzyfleet.PACKAGES:
        file, ours = _fuzzyfleet._place(name)
        assert ours
        assert file.endswith(f"{name}/__init__.py")
