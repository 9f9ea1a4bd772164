"""The command robotics arena."""

import json

import pytest

from robotics.commands.application import main
from tests.robotics.plugins.arena.test_running import TEXT


@pytest.mark.long
def test_an_arena_from_a_file_to_a_page(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.toml").write_text(TEXT)
    assert main(["arena", "mine.toml", "--out", "out", "--workers", "1", "--json", "-q"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert [row["law"] for row in found["laws"]] in (["lyapunov", "pid"], ["pid", "lyapunov"])
    assert 2 < len(found["answer"]) <= 10
    assert (tmp_path / found["page"]).read_text(encoding="utf-8").count("<figure") >= 5
    before = (tmp_path / "out" / "results.csv").read_bytes(), (tmp_path / "out" / "arena.html").read_bytes()
    assert main(["arena", "mine.toml", "--out", "out", "--workers", "2", "--json", "-q"]) == 0
    assert ((tmp_path / "out" / "results.csv").read_bytes(), (tmp_path / "out" / "arena.html").read_bytes()) == before


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["arena", "defalt"], "unknown arena 'defalt'"),
        (["arena", "--laws", "fuzy"], "unknown controller 'fuzy'; did you mean 'fuzzy'"),
        (["arena", "--full", "demo"], "give --full or demo, not both"),
        (["arena", "--workers", "2", "--dask", "tcp://x:1"], "give --workers or --dask, not both"),
    ],
)
def test_what_is_wrong_is_said_in_a_sentence(arguments, words, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 2
    assert words in capsys.readouterr().err


def test_all_that_is_wrong_with_a_plan_is_told_at_once(tmp_path, capsys):
    file = tmp_path / "plan.toml"
    file.write_text('like = "default"\nlawz = 3\nrepeats = "a"\ntesting_runs = -1\n', encoding="utf-8")
    assert main(["check", str(file), "--json"]) == 1
    found = {f["line"]: f["sentence"] for f in json.loads(capsys.readouterr().out)["findings"]}
    assert [*sorted(found)] == [2, 3, 4]
    assert all(word in found[line] for line, word in {2: "'laws'", 3: "repeats must", 4: "testing_runs must"}.items())
