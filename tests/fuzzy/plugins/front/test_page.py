"""The page docs/howto/rules-from-nothing.md: its commands run, and its table is that of the file of measurements."""

import json
import re
from pathlib import Path

import pytest

from tests.snippets import run_commands, snippets

DOCS = Path(__file__).parents[4] / "docs"
PAGE = DOCS / "howto" / "rules-from-nothing.md"
ROWS = json.loads((DOCS / "reference" / "rulefronts.json").read_text())["rows"]


@pytest.mark.long  # seconds; test_front.py has a small version of the command
def test_the_commands_of_the_page_run(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    ((kind, text),) = snippets(PAGE)[:1]
    assert kind == "sh"
    run_commands("\n".join(line for line in text.splitlines() if not line.startswith("pip ")))
    assert "<- fewest" in capsys.readouterr().out
    assert (tmp_path / "front" / "4.fis").exists()
    assert (tmp_path / "front.png").exists()


def test_the_table_of_the_page_is_that_of_the_file():
    table = re.findall(r"^\| (diabetes|wine|iris) \| (.+) \|$", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    assert [name for name, _ in table] == ["diabetes", "wine", "iris"]
    for name, cells in table:
        here = [row for row in ROWS if row["table"] == name and "error" in row]
        best = {
            row["package"]: row for row in sorted(here, key=lambda row: -row["error"]) if row["package"] != "fuzzyfleet"
        }
        own = {row["setting"]: row for row in here if row["package"] == "fuzzyfleet"}
        said = [
            own["marked"],
            own["least error"],
            *(best[p] for p in ("pyFUME", "ex-fuzzy", "anfis-toolbox", "a plane")),
        ]
        assert cells.split(" | ") == [
            f"{row['error']:.3f} ± {row['deviation']:.3f}; {row['rules']:.1f}, {row['conditions']:.1f}" for row in said
        ]
