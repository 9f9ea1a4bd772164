"""The command line ``robotics learn``, end to end."""

import json

import pytest

from fuzzy.files.table import read_table
from robotics.commands.application import main

TINY = """
title = "a line, from beside it"
duration = 4.0

[sensing]
posture = "pose"
position_noise = 0.002

[[robots]]
start = [0.0, 0.1, 0.0]
path = { shape = "line", start = [0.0, 0.0], end = [2.0, 0.0] }
timing = { speed = 0.3 }
"""


@pytest.fixture
def command(tmp_path):
    (tmp_path / "tiny.toml").write_text(TINY, encoding="utf-8")
    few = ["--rules", "3", "--rounds", "0", "--epochs", "1", "--seeds", "3", "--unseen", "1", "-q"]
    driven = ["--scenario", str(tmp_path / "tiny.toml"), "--inputs", "x_err,y_err,heading_err"]
    return ["learn", "rules", "--from", "lyapunov", *driven, *few, "-o", str(tmp_path / "learnt.fis")]


@pytest.mark.long
def test_rules_are_learnt_saved_and_flown_on_unseen_seeds(command, tmp_path, capsys):
    data = tmp_path / "data.csv"
    assert main([*command, "--data", str(data)]) == 0
    out, _ = capsys.readouterr()
    assert "round 0:" in out
    assert "3 rules. Flown on the unseen seeds 3 to 3" in out
    assert f"--controller fuzzy:rule_base={tmp_path / 'learnt.fis'}" in out
    table = read_table(data)
    names, values = table.names, table.values
    assert names[3:] == ("x_err", "y_err", "heading_err", "v", "w")
    assert table.units[3:] == ("m", "m", "rad", "m/s", "rad/s")
    first = (tmp_path / "learnt.fis").read_bytes(), data.read_bytes()
    assert main([*command, "--data", str(data), "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert first == ((tmp_path / "learnt.fis").read_bytes(), data.read_bytes())
    assert printed["seeds"] == [3]
    assert printed["taken"] == 0
    assert printed["rounds"][0]["samples"] < len(values)  # those of the checking seed are not learnt from
    assert printed["driven"]["tiny"].keys() == {"teacher", "learnt"}
    assert main(["run", str(tmp_path / "tiny.toml"), "-c", f"fuzzy:rule_base={tmp_path / 'learnt.fis'}", "-q"]) == 0


def test_other_numbers_of_rules_say_what_they_lose(command, tmp_path, capsys):
    told = [*command, "--front", "1,3", "--plot", str(tmp_path / "front.svg")]
    assert main(told) == 0
    rows = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert [row[0] for row in rows if row[1:] and row[-1] in ("m", "rad")] == ["1", "3"]
    assert "number of rules" in (tmp_path / "front.svg").read_text(encoding="utf-8")
    assert main([*told, "--json"]) == 0
    one, three = json.loads(capsys.readouterr().out)["front"]
    assert (one["rules"], three["rules"]) == (1, 3)
    assert one["of_the_range"] > three["of_the_range"]  # a law that is no plane is nothing for one rule
    assert one["most_lost"]["share"] > 1 / 3
    assert one["most_lost"]["input"] in ("x_err", "y_err", "heading_err")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--front", "2;4"], "--front must be whole numbers between commas, such as 2,4,8; got '2;4'"),
        (["--inputs", "x_er"], "did you mean 'x_err'"),
        (["--outputs", "rate"], "unknown output that a teacher shows 'rate'"),
        (["--from", "lyapnov"], "unknown controller 'lyapnov'; did you mean 'lyapunov'"),
        (["--scenario", "referense"], "did you mean 'reference'"),
        (["-o", "learnt.txt"], "learnt.txt: the file's name must end in .fis"),
        (["--into", "fuzzy-team"], "must end in the gain that names the rule base"),
    ],
)
def test_what_cannot_be_learnt_is_told_in_a_sentence(command, arguments, said, capsys):
    assert main([*command, *arguments]) == 2
    out, err = capsys.readouterr()
    assert said in err
    assert "Traceback" not in err
    assert out == ""


@pytest.mark.parametrize("command", ["learn rules --from lyapunov --scenario lyapunov-sine", "dataset formation"])
def test_a_place_for_no_file_is_refused_before_the_work(command, tmp_path, capsys, no_runs):
    assert main([*command.split(), "-o", str(tmp_path / "nowhere" / "x.csv")]) == 2
    assert f"there is no folder {str(tmp_path / 'nowhere')!r} to write into" in capsys.readouterr().err
