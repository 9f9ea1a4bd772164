"""The page docs/howto/logs.md: its snippets run one after the other, and its table names what is in a log."""

import re
from pathlib import Path

import pytest
from mcap.reader import make_reader

from tests.snippets import run_commands, run_python, snippets

DOCS = Path(__file__).parent.parent / "docs"


@pytest.mark.long
def test_every_snippet_of_the_page_runs_in_order(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    kinds, said = [], ""
    for kind, text in snippets(DOCS / "howto" / "logs.md", changed=False):
        kinds.append(kind)
        if kind == "sh":
            run_commands(text)
        else:
            run_python(text, "logs.md")
        said += capsys.readouterr().out
    assert kinds == ["sh", "python", "sh"]
    assert "441 postures, 441 commands" in said
    settled = [float(v) for v in re.findall(r"rms_distance_late_m +([\d.]+)", said)]
    assert settled[-1] < 0.02  # m: what was learnt drives
    with (tmp_path / "run.mcap").open("rb") as file:
        found = make_reader(file).get_summary()
    topics = {found.schemas[c.schema_id].name.replace("/msg/", "/") for c in found.channels.values()}
    table = (DOCS / "howto" / "logs.md").read_text("utf-8")
    assert topics <= set(re.findall(r"\| (\w+/\w+) \|", table))
