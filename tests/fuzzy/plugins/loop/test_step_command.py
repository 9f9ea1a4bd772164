"""The command ``fuzzy step``."""

import json
from pathlib import Path

import pytest

from fuzzy import write_fis
from fuzzy.commands.application import main
from fuzzy.plugins.designer.starts.control import rule_table
from fuzzy.plugins.loop import commands


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_fis(rule_table("pd", 5), "pd.fis")


def test_it_prints_what_the_function_gives(capsys):
    arguments = ["step", "pd.fis", "--plant", "integrating", "--scale", "Ku=4", "--limits", "-4,4"]
    arguments += ["--disturbance", "6,0.5", "--pid", "4,0,3"]
    assert main(arguments) == 0
    text = capsys.readouterr().out
    assert "Recovery after the disturbance [s]" in text
    assert "PID: Kp 4, Ki 0, Kd 3" in text
    assert main([*arguments, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    own = found["responses"]["fuzzy-pd-5x5"]
    assert len(own["time"]) == len(own["output"]) == 501
    assert max(own["control"]) <= 4
    assert found["responses"]["PID"]["figures"]["steady_state_error"] == pytest.approx(0, abs=0.05)


@pytest.mark.parametrize(
    ("more", "sentence"),
    [
        (["--plant", "1 1"], "a transfer function is written"),
        (["--plant", "lag", "--scale", "kd=1"], "did you mean 'Kdu'"),
        (["--plant", "lag", "--limits", "1,2,3"], "--limits takes 1 or 2 numbers"),
        (["--plant", "lag", "--role", "error=errors"], "did you mean 'error'"),
        (["--plant", "lag", "--plot", "a.xyz"], "a.xyz"),
        (["--plant", "none.toml"], "none.toml: cannot be read"),
    ],
)
def test_what_is_wrong_is_said_in_a_sentence(more, sentence, capsys):
    assert main(["step", "pd.fis", *more]) == 2
    assert sentence in capsys.readouterr().err


@pytest.mark.parametrize(
    ("pause", "said"),
    [("if t == 0 and u > 0: time.sleep(1.6)", 1), ("time.sleep(0.002)", 0)],  # at once, and 1.6 s in all
)
def test_a_plant_that_does_not_answer_is_named_once(pause, said, capsys, monkeypatch):
    monkeypatch.setattr(commands, "_PATIENCE", 0.8)
    Path("slow.py").write_text(f"import time\n\ndef plant(x, u, t):\n    {pause}\n    return [u]\n", encoding="utf-8")
    assert main(["step", "pd.fis", "--plant", "slow.py", "--duration", "1", "--sample-time", "0.02"]) == 0
    sentence = "The plant in slow.py has not answered for 0.8 s; Ctrl-C ends.\n"
    assert capsys.readouterr().err == said * sentence


def test_a_plant_that_ends_the_process_is_an_error_with_its_line(capsys):
    Path("ends.py").write_text("def plant(x, u, t):\n    raise SystemExit(3)\n", encoding="utf-8")
    assert main(["step", "pd.fis", "--plant", "ends.py"]) == 2
    assert "ends.py:2: SystemExit: 3" in capsys.readouterr().err
