"""A wheel built from the tree, in a bare virtual environment, runs a comparison from any folder."""

import json
import os
import platform
import re
import subprocess
import sys
import sysconfig
import tomllib
import venv
from pathlib import Path

import pytest

from fuzzy.files.examples import EXAMPLES

ROOT = Path(__file__).parent.parent


@pytest.fixture(scope="module")
def python(tmp_path_factory):
    """The interpreter of an environment with the pure wheel."""
    return installed(tmp_path_factory.mktemp("wheel"), "py3-none-any")


def installed(folder, tag, **environment):
    """The interpreter of a virtual environment that holds the wheel, and this environment's third-party packages."""
    build = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", str(folder), str(ROOT)]
    subprocess.run(build, check=True, capture_output=True, timeout=120, env=os.environ | environment)
    (wheel,) = folder.glob("fuzzyfleet-*.whl")
    assert wheel.name.endswith(f"-{tag}.whl")
    venv.create(folder / "venv", with_pip=False)
    python = folder / "venv" / "bin" / "python"
    subprocess.run(
        [sys.executable, "-m", "pip", "--python", str(python), "install", "-q", "--no-deps", "--no-index", str(wheel)],
        check=True,
        capture_output=True,
        timeout=120,
    )
    # A path in a .pth file is searched, but its own .pth files (our editable install) are not read.
    site = subprocess.run(
        [python, "-c", "import sysconfig; print(sysconfig.get_paths()['purelib'])"],
        check=True,
        capture_output=True,
        text=True,
    ).stdout.strip()
    (Path(site) / "borrowed.pth").write_text(sysconfig.get_paths()["purelib"] + "\n", encoding="utf-8")
    return python


@pytest.mark.long
def test_the_installed_package_compares_from_any_folder(python, tmp_path):
    script = python.parent / "robotics"
    whole = (ROOT / "robotics" / "data" / "scenarios" / "fuzzy-on-path.toml").read_text(encoding="utf-8")
    short, changed = re.subn(r"(?m)^duration = .*$", "duration = 0.2", whole)
    assert changed == 1
    (tmp_path / "short.toml").write_text(short, encoding="utf-8")
    command = [script, "compare", "short.toml", "--controllers", "fuzzy,esm", "--seeds", "1", "--out", "here", "-q"]
    # Interpreted: to compile everything once more, in a folder that is thrown away, takes longer than the comparison.
    clean = {k: v for k, v in os.environ.items() if not k.startswith("PYTHON")} | {"NUMBA_DISABLE_JIT": "1"}
    done = subprocess.run(command, cwd=tmp_path, env=clean, capture_output=True, text=True, timeout=240, check=False)
    assert done.returncode == 0, done.stderr
    lines = (tmp_path / "here" / "results.csv").read_text(encoding="utf-8").splitlines()
    assert len(lines) == 1 + 2
    assert "<html" in (tmp_path / "here" / "report.html").read_text(encoding="utf-8")
    where = subprocess.run(
        [python, "-c", "import robotics, fuzzy; print(robotics.__file__, fuzzy.__file__)"],
        cwd=tmp_path,
        env=clean,
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    assert where.count(str(python.parent.parent)) == 2, where


def test_the_installed_commands_find_rule_bases_by_name(python, tmp_path):
    clean = {k: v for k, v in os.environ.items() if not k.startswith("PYTHON")}
    for name, count in (("tracking", 16), ("formation/v_l", 8)):
        command = [python.parent / "fuzzy", "rules", name]
        done = subprocess.run(command, cwd=tmp_path, env=clean, capture_output=True, text=True, timeout=60, check=False)
        assert (done.returncode, done.stderr) == (0, "")
        assert len(done.stdout.splitlines()) == count


def test_the_installed_package_brings_its_examples_and_names_what_an_extra_needs(python, tmp_path):
    declared = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]
    wanted = {extra: ["pip", "install", *packages] for extra, packages in declared.items()}
    code = (
        "import json, shlex, sys; from fuzzy.commands.application import main\n"
        "from fuzzy.extras import install_command\n"
        "code = main(['example', '--all'])\n"
        "print(json.dumps({extra: shlex.split(install_command(extra)) for extra in sys.argv[1:]})); sys.exit(code)"
    )
    clean = {k: v for k, v in os.environ.items() if not k.startswith("PYTHON")}
    command = [python, "-c", code, *wanted]
    done = subprocess.run(command, cwd=tmp_path, env=clean, capture_output=True, text=True, timeout=60, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    *files, commands = done.stdout.splitlines()
    assert files == sorted(files, key=list(EXAMPLES).index) == list(EXAMPLES)
    for file in EXAMPLES:
        assert (tmp_path / file).read_bytes() == (ROOT / "fuzzy" / "examples" / file).read_bytes()
    assert {extra: sorted(words) for extra, words in json.loads(commands).items()} == {
        extra: sorted(words) for extra, words in wanted.items()
    }


@pytest.mark.long
@pytest.mark.skipif(platform.machine() != "x86_64", reason="kernels are shipped for x86-64 only")
def test_a_wheel_with_kernels_compiles_nothing(tmp_path):
    """What was compiled for it, that is: another command still compiles what it lacks."""
    make = [sys.executable, "-m", "kernels", "--only", "^first steps$", "--baseline", "x86-64-v2"]
    subprocess.run([*make, "--out", str(tmp_path)], cwd=ROOT, check=True, capture_output=True, timeout=600)
    tag = f"cp{sys.version_info[0]}{sys.version_info[1]}"
    kernels = {"FUZZYFLEET_KERNELS": str(tmp_path / "wheel")}
    python = installed(tmp_path, f"{tag}-{tag}-manylinux_2_17_x86_64", **kernels)
    code = (
        "import sys; from numba.core.event import install_recorder; from robotics.commands.application import main\n"
        "with install_recorder('numba:compile') as recorder: assert main(sys.argv[1:]) == 0\n"
        "print(len(recorder.buffer))"
    )
    clean = {k: v for k, v in os.environ.items() if not k.startswith(("PYTHON", "NUMBA"))}

    def compiled(*words):
        command = [python, "-c", code, *words]
        done = subprocess.run(command, cwd=tmp_path, env=clean, capture_output=True, text=True, timeout=300, check=True)
        return int(done.stdout.split()[-1])

    assert compiled("run", "lyapunov-sine", "--plot", "sine.png") == 0
    assert compiled("run", "lyapunov-sine", "-c", "lyapunov") > 0


def test_the_wheel_carries_data_and_types(python):
    code = (
        "from importlib.resources import files;"
        "print(*(p.is_file() for p in (files('fuzzy') / 'py.typed', files('robotics') / 'py.typed',"
        "*(files(package) / '__init__.pyi' for package in ('fuzzy', 'anfis', 'robotics')),"
        "files('robotics') / 'data' / 'rulebases' / 'tracking.fis',"
        "files('robotics') / 'data' / 'scenarios' / 'reference.toml',"
        "*(files('robotics') / 'show' / 'playback' / 'static' / f'player.{end}' for end in ('js', 'css')),"
        "files('robotics') / 'show' / 'playback' / 'player.html.j2',"
        "files('fuzzy') / 'plugins' / 'designer' / 'static' / 'bridge.js',"
        "files('robotics') / 'show' / 'report' / 'report.html.j2',"
        "files('robotics') / 'data' / 'rulebases' / 'formation' / 'v_l.fis',"
        "files('robotics') / 'data' / 'robots' / 'etsro.toml')))"
    )
    done = subprocess.run([python, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["True"] * 14
