"""The page on type-2 under noise tells the numbers of its file; the law of the study is the rule base it says."""

import json
import re
from pathlib import Path

import pytest

from benchmarks.type2noise import check, summary

DOCS = Path(__file__).parents[4] / "docs"
FILES = [json.loads((DOCS / "reference" / name).read_text()) for name in ("type2noise.json", "type2noise-few.json")]
CELLS, FEW = ({(c["noise_m"], c["latency_s"], c["pose"]): c for c in each["cells"]} for each in FILES)


def test_the_law_of_the_study_answers_as_its_systems():
    check()


def test_the_table_of_the_page_is_that_of_the_file():
    text = (DOCS / "explanation" / "type2-under-noise.md").read_text(encoding="utf-8")
    rows = [
        [word.strip() for word in line.split("|")[1:-1]] for line in text.splitlines() if re.match(r"\| \d+ mm", line)
    ]
    assert len(rows) == len(CELLS) >= 10
    for row, (cell, measured) in zip(rows, CELLS.items(), strict=True):
        found = summary(measured["searches"])
        assert row[:3] == [f"{1000 * cell[0]:g} mm", f"{1000 * cell[1]:g} ms", cell[2]]
        assert [float(word) for word in row[3:5]] == pytest.approx([found["type_1"], found["type_2"]], abs=6e-4)
        assert row[5] == f"{found['ratio']:.2f} ({found['low']:.2f} to {found['high']:.2f})"
        assert found["failed_1"] == found["failed_2"] == 0
        few = summary(FEW[cell]["searches"]) if cell in FEW else None
        assert row[6] == (f"{few['ratio']:.2f} ({few['low']:.2f} to {few['high']:.2f})" if few else "-")
