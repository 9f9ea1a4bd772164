"""What Tab completes: the names that commands accept, as bash asks for them, without what takes long to import."""

import subprocess
import sys
from importlib import import_module

import pytest

from fuzzy.files.packaged import packaged_fis_files
from robotics.laws.catalogue import presets
from robotics.simulation.scenario.reading import scenario_names
from robotics.simulation.scenario.robots import robot_names


def completions(monkeypatch, capsys, line):
    """What the program offers for the last word of ``line``."""
    program, place = line.split()[0], len(line.split(" ")) - 1
    monkeypatch.setenv("COMP_WORDS", line)
    monkeypatch.setenv("COMP_CWORD", str(place))
    monkeypatch.setenv(f"_{program.upper()}_COMPLETE", "complete_bash")
    import_module(f"{program}.commands.application").main([])
    monkeypatch.delenv(f"_{program.upper()}_COMPLETE")
    return capsys.readouterr().out.split()


@pytest.mark.parametrize(
    ("line", "names"),
    [
        ("robotics run ", scenario_names()),
        ("robotics compare lyapunov-sine ", scenario_names()),
        ("robotics run lyapunov-sine -c ", list(presets())),
        ("robotics compare lyapunov-sine --controllers fuzzy,", [f"fuzzy,{name}" for name in presets()]),
        ("robotics robot ", robot_names()),
        ("robotics list sce", ["scenarios"]),
        ("robotics plot run.npz -k dis", ["distances"]),
        ("robotics new rule", ["rule-base"]),
        ("robotics copy etsr", ["etsro"]),
        ("fuzzy show ", list(packaged_fis_files())),
        ("fuzzy example sam", ["samples"]),
        ("anfis train data.csv --method sec", ["second-order"]),
        ("anfis predict formation/v_", ["formation/v_f", "formation/v_l"]),
    ],
)
def test_names_are_completed(line, names, monkeypatch, capsys, tmp_path):
    monkeypatch.chdir(tmp_path)
    assert sorted(completions(monkeypatch, capsys, line)) == sorted(names)


def test_files_are_completed_beside_names(monkeypatch, capsys, tmp_path):
    monkeypatch.chdir(tmp_path)
    for name in ("mine.toml", "mine.txt", "folder/mice.toml"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()
    assert completions(monkeypatch, capsys, "robotics run mi") == ["mine.toml"]
    assert completions(monkeypatch, capsys, "robotics run fol") == ["folder/"]
    assert completions(monkeypatch, capsys, "robotics run folder/m") == ["folder/mice.toml"]
    assert completions(monkeypatch, capsys, "robotics run nowhere/m") == []


def test_a_key_press_imports_little():
    code = (
        "import sys; from robotics.commands.completion import controllers, scenarios; controllers(''); scenarios('');"
        "print(*{'numpy', 'numba', 'scipy', 'torch', 'pandas', 'robotics.laws'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout.strip() == ""
