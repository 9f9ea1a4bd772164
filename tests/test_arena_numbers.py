"""What pages say of the arena is what its last run wrote: docs/reference/arena.csv."""

import re
from pathlib import Path

import pandas as pd
import pytest

ROOT = Path(__file__).parent.parent
TABLE = pd.read_csv(ROOT / "docs" / "reference" / "arena.csv")
NAMES = {
    "MPPI": "mppi",
    "predictive control": "nmpc",
    "exponential sliding mode": "esm",
    "conventional sliding mode": "csm",
    "quasi-continuous": "qssm",
    "arbitrary second order": "assm",
    "parallel compensation (T-S fuzzy)": "pdc",
    "LQR": "lqr",
    "Lyapunov": "lyapunov",
    "PID": "pid",
    "fuzzy rule base": "fuzzy",
    "regulated pure pursuit": "pursuit",
}
PAGES = {"README.md": 12, "docs/tutorials/fair-comparison.md": 4}


def said(number):
    return f"{number:.2f}" if number < 10 else f"{number:.1f}"


@pytest.mark.parametrize("page", PAGES)
def test_a_table_of_the_arena_holds_the_numbers_of_its_last_run(page):
    rows = TABLE.set_index(TABLE["law"].str.partition(":")[0])
    found = re.findall(
        r"\| ([^|]+) \| ([\d.]+) \| ([\d.]+)(?: \(([\d.]+) to ([\d.]+)\))?(?= \|)", (ROOT / page).read_text("utf-8")
    )
    cells = [cell for cell in found if cell[0] in NAMES]
    assert len(cells) == PAGES[page]
    for name, published, tuned, low, high in cells:
        row = rows.loc[NAMES[name]]
        assert published == said(row["published_ratio"])
        assert tuned == (said(row["tuned_ratio"]) if row["tuned_ratio"] != 1 else "1")
        if low:
            assert (low, high) == (said(row["tuned_ratio_low"]), said(row["tuned_ratio_high"]))


def test_what_the_readme_says_beside_its_table_is_of_the_same_run():
    text = " ".join((ROOT / "README.md").read_text(encoding="utf-8").split())
    rows = TABLE.set_index("law")
    distance, effort = 1000 * rows["rms_distance_late_m"], rows["w_variation_late_radps2"]
    assert f"keeps {distance['fuzzy']:.1f} mm from its reference" in text
    assert f"({effort['fuzzy']:.2f} rad/s²), the exponential sliding mode {distance['esm']:.1f} mm" in text
    assert f"{distance['esm']:.1f} mm and {effort['esm']:.2f}" in text
    assert f"that is {rows['cost']['fuzzy'] / rows['cost']['esm']:.1f} times the cost" in text


def test_the_arena_of_the_file_is_the_packaged_one():
    import robotics

    assert set(TABLE["law"]) == set(robotics.load_arena("default").laws)
