"""The page docs/explanation/type2.md tells the numbers of its file; the law of the study is the rule base it says."""

import json
import re
from pathlib import Path

import pytest

from benchmarks.type2noise import check, summary

DOCS = Path(__file__).parents[4] / "docs"
CELLS = json.loads((DOCS / "reference" / "type2noise.json").read_text(encoding="utf-8"))["cells"]


def test_the_law_of_the_study_answers_as_its_systems():
    check()


def test_the_table_of_the_page_is_that_of_the_file():
    text = (DOCS / "explanation" / "type2.md").read_text(encoding="utf-8")
    rows = [
        [word.strip() for word in line.split("|")[1:-1]] for line in text.splitlines() if re.match(r"\| \d+ mm", line)
    ]
    assert len(rows) == len(CELLS) == 18
    for row, cell in zip(rows, CELLS, strict=True):
        found = summary(cell["searches"])
        assert row[:3] == [f"{1000 * cell['noise_m']:g} mm", f"{1000 * cell['latency_s']:g} ms", cell["pose"]]
        assert [float(word) for word in row[3:5]] == pytest.approx([found["type_1"], found["type_2"]], abs=6e-4)
        assert row[5] == f"{found['ratio']:.2f} ({found['low']:.2f} to {found['high']:.2f})"
        assert row[6] == f"{found['failed_1']:g}, {found['failed_2']:g}"
