"""The page docs/howto/own-plant.md: its snippets run as written, one after the other."""

import re
from pathlib import Path

from fuzzy.plugins.loop.plant import TransferFunction
from fuzzy.plugins.loop.plantfile import read_plant
from fuzzy.plugins.loop.scheduledplant import ScheduledTransferFunction
from tests.snippets import run_commands, run_python, snippets

DOCS = Path(__file__).parents[4] / "docs"


def test_every_snippet_of_the_page_runs_in_order(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    kinds, said = [], ""
    for kind, text in snippets(DOCS / "howto" / "own-plant.md"):
        kinds.append(kind)
        if kind == "sh":
            run_commands(text)
        elif kind == "python":
            run_python(text, "own-plant.md")
        elif kind == "toml":
            path = tmp_path / ("points.toml" if "point" in text else "lag.toml")
            path.write_text(text, encoding="utf-8")
            if path.stem == "lag":
                assert read_plant(path) == TransferFunction([1], [1, 1], 0.2)
            else:
                assert read_plant(path) == ScheduledTransferFunction(
                    [0.5], [TransferFunction([1], [4, 1], 2)], [(0.97, 0.24, 0)]
                )
        else:
            (tmp_path / "plant.py").write_text(text, encoding="utf-8")
        said += capsys.readouterr().out
    assert kinds == ["python", "toml", "sh", "python", "python", "sh", "sh", "toml", "python", "py", "sh", "python"]
    assert (tmp_path / "step.png").stat().st_size > 10_000
    assert said.count("Overshoot [%]") == 20
    assert "SIMC (Skogestad 2003)" in said
    assert re.search(r"0\.0 s late, Ku = 4: overshoot 0 %, settled: [1-5]", said)
    assert re.search(r"0\.6 s late, Ku = 1: overshoot 6 %, settled: [45]", said)
    assert re.search(r"0\.6 s late, Ku = 4: overshoot \d\d %, settled: None", said)
    overshoot, settling, recovery = map(float, said.splitlines()[-1].split())
    assert overshoot < 20
    assert settling < 20
    assert recovery < 20
