"""Ablation: what is taken away, what it is worth by an oracle, and the command."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from fuzzy.files.fisfile import read_fis, write_fis
from robotics.commands.application import main
from robotics.laws.catalogue import gains_of, make_controller
from robotics.laws.rules.fuzzy_team import FuzzyTeam
from robotics.laws.tracking.fuzzy_tracking import load_rule_base
from robotics.measures.quantities import measured
from robotics.plugins.ablation.ablation import AblationPlan, _compared, ablate
from robotics.plugins.ablation.figures import plot_ablation
from robotics.plugins.ablation.variants import AblationError, variants
from robotics.simulation.loop import simulate
from robotics.simulation.scenario.reading import load_scenario

OFF_PATH = "fuzzy-off-path"


def test_a_law_is_taken_apart_by_its_rule_bases() -> None:
    law = make_controller("fuzzy-team")
    assert isinstance(law, FuzzyTeam)
    found = {v.name: v for v in variants(law, ["supervisor"], shuffles=1, seed=3)}
    tasks = ("tracking", "cooperation", "crash", "obstacles", "supervisor")
    rules = len(law.fuzzy_systems["supervisor"].rules)
    assert len(found) == 1 + 2 * len(tasks) + rules + 1 + len(tasks)
    for task in tasks:
        bare = found[f"{task} without rules"].law
        assert bare.fuzzy_systems[task].rules == ()
        assert {t: f for t, f in bare.fuzzy_systems.items() if t != task} == {
            t: f for t, f in law.fuzzy_systems.items() if t != task
        }
        dealt, whole = found[f"{task} shuffled, 1"].law.fuzzy_systems[task], law.fuzzy_systems[task]
        assert [r.when for r in dealt.rules] == [r.when for r in whole.rules]
        assert sorted(map(str, (r.then for r in dealt.rules))) == sorted(map(str, (r.then for r in whole.rules)))
        assert dealt != whole
        assert gains_of(found[f"{task} without rules, no emergency rule"].law)["guard.on"] == 0
    third = found["supervisor without rule 3"]
    kept = tuple(law.fuzzy_systems["supervisor"].rules)
    assert (third.base, third.rule) == ("supervisor", 3)
    assert third.law.fuzzy_systems["supervisor"].rules == kept[:2] + kept[3:]
    assert gains_of(found["no emergency rule"].law)["guard.on"] == 0


def test_what_cannot_be_taken_apart_is_said() -> None:
    with pytest.raises(AblationError, match="Lyapunov has no rule base"):
        variants(make_controller("lyapunov"))
    with pytest.raises(AblationError, match="did you mean 'tracking'"):
        variants(make_controller("fuzzy"), ["trackin"])
    with pytest.raises(AblationError, match="nothing is driven"):
        ablate(AblationPlan(law="fuzzy", seeds=0))


def test_differences_are_of_runs_that_both_end() -> None:
    rng = np.random.default_rng(5)
    ours, theirs = rng.normal(3.0, 0.2, 30), rng.normal(3.3, 0.2, 30)
    theirs[:4], ours[7] = np.inf, np.nan
    (row,) = _compared({"time": ours}, {"time": theirs})
    apart = np.delete(theirs - ours, [0, 1, 2, 3, 7])
    low, high = stats.t.interval(0.95, 24, apart.mean(), stats.sem(apart))
    assert [row[k] for k in ("difference", "low", "high")] == pytest.approx([apart.mean(), low, high], rel=1e-9)
    assert (row["runs"], row["worse"]) == (25, "yes")
    assert list(_compared({"time": np.full(3, np.inf)}, {"time": ours[:3]})) == []


@pytest.fixture(scope="module")
def padded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The tracking rule base with a seventeenth rule that says nothing: its weight is 0."""
    fis = load_rule_base("tracking")
    path = tmp_path_factory.mktemp("rules") / "padded.fis"
    write_fis(replace(fis, rules=[*fis.rules, replace(fis.rules[0], weight=0.0)]), path)
    return path


@pytest.fixture(scope="module")
def found(padded: Path) -> Any:
    plan = AblationPlan(law=f"fuzzy:rule_base={padded}", each_rule=("tracking",), shuffles=1, seeds=4, on=(OFF_PATH,))
    return ablate(plan)


def test_a_rule_that_says_nothing_is_worth_nothing_and_a_base_is_needed(found: Any, padded: Path) -> None:
    rows = found.table[found.table["variant"] == f"tracking without rule {len(read_fis(padded).rules)}"]
    assert (rows["difference"] == 0).all()
    assert (rows["worse"] == "no").all()
    assert found.needed["tracking without rules"]
    assert found.needed["tracking shuffled, 1"]
    assert any(not needed for needed in found.needed.values())
    assert (
        f"tracking without rule {len(read_fis(padded).rules)}: nothing is worse beyond the interval." in found.sentences
    )


def test_numbers_are_those_of_runs_made_by_hand(found: Any) -> None:
    fis = load_rule_base("tracking")
    bare = make_controller("fuzzy").with_fuzzy_system("tracking", replace(fis, rules=(*fis.rules[:1], *fis.rules[2:])))
    scenario = load_scenario(OFF_PATH)
    with_all, without = (measured(simulate(scenario, law, range(4)), "rms_distance_late_m") for law in ("fuzzy", bare))
    rows = found.table.set_index(["variant", "measured"])
    row = rows.loc["tracking without rule 2", "distance"]
    assert row["whole"] == pytest.approx(with_all.mean(), rel=1e-12)
    assert row["difference"] == pytest.approx((without - with_all).mean(), rel=1e-12)


def test_the_picture_has_a_row_a_variant_and_units(found: Any) -> None:
    figure = plot_ablation(found)
    labels = [tick.get_text() for tick in figure.axes[0].get_yticklabels()]
    assert labels == list(dict.fromkeys(found.table["variant"]))
    assert all("[" in ax.get_xlabel() for ax in figure.axes if ax.get_visible() and ax.get_xlabel())


def test_the_command_writes_what_it_says(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = ["ablate", "fuzzy", "--on", OFF_PATH, "--seeds", "2", "--shuffles", "0", "--workers", "1", "-q"]
    assert main([*command, "-o", str(tmp_path / "out"), "--plot", str(tmp_path / "worth.png")]) == 0
    said = capsys.readouterr().out
    assert said.startswith("tracking without rules: ")
    assert (tmp_path / "worth.png").stat().st_size > 10_000
    rows = pd.read_csv(tmp_path / "out" / "ablation.csv")
    assert set(rows["variant"]) == {"tracking without rules"}
    assert main([*command, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["needed"] == {"tracking without rules": True}
    assert main(["ablate", "lyapunov", "-q"]) == 2
    assert capsys.readouterr().err.strip().endswith("Lyapunov has no rule base")
    assert main(["ablate", "fuzzy", "--on", "fuzy-off-path", "-q"]) == 2
    assert "did you mean 'fuzzy-off-path'" in capsys.readouterr().err


@pytest.mark.long
def test_every_base_of_the_fuzzy_team_is_needed() -> None:
    """Without it something touches, never arrives or falls behind: on other seeds than the bases were made with."""
    plan = AblationPlan(law="fuzzy-team", shuffles=0, crossings=24, courses=12, seeds=4, seed=7000)
    table = ablate(plan).table
    hard = table[table["measured"].isin(["contacts", "deadlocks", "gap", "time"]) & (table["worse"] == "yes")]
    for task in ("tracking", "cooperation", "obstacles", "supervisor"):
        assert f"{task} without rules" in set(hard["variant"])
    alone = hard[hard["measured"] == "contacts"]["variant"]
    assert "crash without rules, no emergency rule" in set(alone)
    assert "no emergency rule" not in set(alone)
