"""What pages say of the arena is what its last run wrote: docs/reference/arena.csv."""

from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from robotics.laws.catalogue import make_controller
from robotics.laws.equation import KNOWLEDGE_FIELDS
from robotics.laws.presets import tuned_from
from robotics.measures.statistics.aggregates import IQM
from robotics.plugins.arena.description import load_arena
from robotics.plugins.arena.presets import preset_name
from robotics.studies.tuning.cost import costs_of

ROOT = Path(__file__).parent.parent
TABLE = pd.read_csv(ROOT / "docs" / "reference" / "arena.csv")
CONDITIONS = pd.read_csv(ROOT / "docs" / "reference" / "arena-conditions.csv")
NAMES = {
    "MPPI": "mppi:samples=500,steps=28,step=0.1",
    "predictive control": "nmpc",
    "exponential sliding mode": "esm",
    "conventional sliding mode": "csm",
    "quasi-continuous": "qssm",
    "arbitrary second order": "assm",
    "parallel compensation (T-S fuzzy)": "pdc",
    "LQR": "lqr",
    "Lyapunov": "lyapunov",
    "PID": "pid",
    "fuzzy-correcting, nine rules": "fuzzy-correcting",
    "fuzzy rule base (Table 5.6)": "fuzzy",
    "regulated pure pursuit": "pursuit",
}
GIVEN = ":lead=auto,smooth=0.2"
EVERYTHING = "docs/start/everything.md"
PAGES = {EVERYTHING: 13, "docs/tutorials/fair-comparison.md": 5}
ROWS: Any = TABLE.set_index("law")


def said(number):
    return f"{number:.2f}" if number < 10 else f"{number:.1f}"


def cell(law, part):
    """The ratio of a law with its interval, as the tables write it."""
    value, low, high = (said(ROWS.loc[law, f"{part}_ratio{end}"]) for end in ("", "_low", "_high"))
    return f"{value} ({low} to {high})"


@pytest.mark.parametrize("page", PAGES)
def test_a_table_of_the_arena_holds_the_numbers_of_its_last_run(page):
    lines = (ROOT / page).read_text("utf-8").splitlines()
    found = [[part.strip() for part in line.strip().strip("|").split("|")] for line in lines if line.startswith("| ")]
    rows = [row for row in found if row[0] in NAMES]
    assert len(rows) == PAGES[page]
    for name, bare, untuned, tuned, *filtered in rows:
        law = NAMES[name]
        if bare:
            ratio = ROWS.loc[law, "tuned_ratio"]
            assert bare == (said(ratio) if ratio != 1 else "1")
        given = law + GIVEN if law + GIVEN in ROWS.index else law
        if untuned:
            assert (untuned, tuned) == (cell(given, "published"), cell(given, "tuned"))
        else:
            assert given == law != "fuzzy-correcting"
        for kalman in filtered:
            more = [f"{given}{mark}estimator=kalman" for mark in ",:"]
            assert kalman == next((cell(one, "tuned") for one in more if one in ROWS.index), "")


def test_what_the_readme_answers_is_of_the_same_run():
    text = " ".join((ROOT / "README.md").read_text(encoding="utf-8").split())
    given = ("lqr" + GIVEN, "lyapunov" + GIVEN, "fuzzy-correcting")
    told = [said(ROWS.loc[law, "tuned_ratio"]) for law in given]
    assert f"({told[0]}, {told[1]} and {told[2]})" in text
    assert len({*NAMES.values()}) == 13
    assert "tunes thirteen laws" in text
    ranking: Any = pd.read_csv(ROOT / "docs" / "reference" / "arena-tasks.csv").set_index("law")
    ends = [f"{ranking.loc['fuzzy-team', f'caused_per_1000{end}']:.3g}" for end in ("", "_low", "_high")]
    assert f"{ends[0]} of 1,000 runs ({float(ends[1]):.1g} to {ends[2]})" in text
    assert ranking["caused_per_1000"].idxmin() == "fuzzy-team"


def test_what_the_page_says_beside_its_table_is_of_the_same_run():
    text = " ".join((ROOT / EVERYTHING).read_text(encoding="utf-8").split())
    distance, ratio = 1000 * ROWS["rms_distance_late_m"], ROWS["tuned_ratio"]
    assert f"keeps {distance['fuzzy']:.1f} mm from its reference" in text
    assert f"the exponential sliding mode keeps {distance['esm']:.1f} mm" in text
    assert f"(Lyapunov: {said(ratio['lyapunov'])}, with it alone {said(ratio['lyapunov:lead=auto'])})" in text
    given = [f"{law}{GIVEN}" for law in ("lqr", "pdc", "lyapunov")]
    assert ROWS.loc[[*given], "tuned_ratio_high"].max() < 0.85
    filtered = [*(f"{law}:estimator=kalman" for law in ("nmpc", "fuzzy-correcting")), f"lqr{GIVEN},estimator=kalman"]
    filtered.append("mppi:samples=500,steps=28,step=0.1,estimator=kalman")
    assert 1.03 < ratio[filtered].max() / ratio[filtered].min() < 1.07
    assert 0.45 < ratio[filtered].min() < ratio[filtered].max() < 0.55
    assert list(ratio.index).index("fuzzy") == len(ratio) - 2
    assert ratio[["lyapunov", "lqr", "pid", "pdc"]].min() > 2
    assert not ROWS["failed"].any()


def test_the_arenas_of_the_files_are_the_packaged_ones():
    assert set(TABLE["law"]) == set(load_arena("default").laws)
    plan = load_arena("knowledge")
    conditions = [each.title for each in (plan.conditions, *plan.under)]
    assert {*zip(CONDITIONS["condition"], CONDITIONS["law"], strict=True)} == {*product(conditions, plan.laws)}


def test_what_the_page_says_of_conditions_is_what_was_found():
    page = (ROOT / "docs" / "explanation" / "arena.md").read_text(encoding="utf-8")
    parts = [{"lead"}, {"lead", "smooth"}, {"lead", "estimator"}, {"lead", "smooth", "estimator"}]
    for condition, rows in CONDITIONS.groupby("condition"):
        cost = rows.set_index("law")["cost"]
        made = {law: make_controller(law) for law in cost.index if not law.startswith(("nmpc", "mppi"))}
        known = {law: {p for p in KNOWLEDGE_FIELDS if getattr(each, p)} for law, each in made.items()}
        (row,) = (line for line in page.splitlines() if line.startswith(f"| {condition} |"))
        cells = [cell.strip() for cell in row.strip("|").split("|")][1:]
        bare = np.log([cost[law] for law, own in known.items() if not own]).mean()
        for own, cell in zip(parts, cells[:4], strict=True):
            with_parts = [cost[law] for law, has in known.items() if has == own]
            assert len(with_parts) == 4
            assert cell.startswith(f"{np.exp(np.log(with_parts).mean() - bare):.2f} (")
        filtered = [law for law in cost.index if "kalman" in law and law not in known]
        equal = [cost[law] for law in (*filtered, *(law for law, own in known.items() if own == parts[3]))]
        assert len(equal) == 6
        assert cells[4] == f"{min(equal):.2f} to {max(equal):.2f}"
        assert 1.06 < max(equal) / min(equal) < 1.2


SORTS = 8  # of scenarios, four draws each
PRESETS = [name for name, about in tuned_from().items() if about not in ("cooperation", "virtual-structure-virtual")]


@pytest.mark.parametrize("preset", [pytest.param(p, marks=pytest.mark.long if "mp" in p else ()) for p in PRESETS])
def test_a_preset_costs_what_the_arena_has_found(preset):
    """The first scenarios of two sorts; gains have six digits in the preset, and a switching law shows it."""
    costs = pd.read_csv(ROOT / "docs" / "reference" / "arena-scenarios.csv", index_col="law")
    arena = load_arena("default")
    (law,) = (law for law in costs.index if preset_name(law) == preset)
    for place in (4, 24):
        scenario = arena.scenarios("test")[place]
        found = costs_of(arena.made_cost, [scenario], [preset], arena.seeds("test", arena.testing_runs)).sum(axis=-1)
        assert IQM(found[:, :, None, :])[0, 0] == pytest.approx(costs.loc[law, scenario.name], rel=0.02)
