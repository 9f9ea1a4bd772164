"""Studies from files: what is refused, how claims are judged, what is written."""

import json
import re
from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from scipy import stats

import robotics
from robotics.measures.evidence import FEWEST_RUNS, judge
from robotics.measures.own import MetricError
from robotics.measures.quantities import measured
from robotics.show.report.claims import ClaimError, Condition, Measure, decided
from robotics.show.report.plan import StudyError, load_study, parse_study, study_names
from robotics.show.report.study import run_study, with_seeds
from robotics.show.report.wording import reading
from robotics.simulation.scenario.reading import load_scenario, scenario_names
from robotics.studies.comparison import DEFAULT_CONTROLLERS

EXAMPLE = Path(__file__).parents[4] / "docs" / "examples" / "own-study"
SHORT = """
title = "A short line"
duration = 2.0
[sensing]
posture = "pose"
position_noise = 0.003
[[robots]]
start = [0.0, 0.1, 0.0]
path = { shape = "line", start = [0.0, 0.0], end = [3.0, 0.0] }
timing = { speed = 0.3 }
"""
TEAM = """
kind = "team"
duration = 2.0
[[robots]]
start = [0.0, 0.0, 0.0]
path = { shape = "line", start = [0.0, 0.0], end = [1.0, 0.0] }
timing = { duration = 8.0 }
[[robots]]
start = [0.0, 1.0, 0.0]
path = { shape = "line", start = [0.0, 1.0], end = [1.2, 1.0] }
timing = { duration = 8.0 }
"""
STUDY = """
title = "Mine"
scenarios = ["short.toml", "lanes.toml"]
controllers = ["lyapunov", "csm:k=0.3", "virtual-structure"]
names = ["rival", "gentle", "team"]
seeds = 3
metrics = ["extra.py:spread_m"]

[[claims]]
name = "One"
metric = "rms_cross_track_m"
on = "short"
of = "gentle"
against = "rival"
less = true
margin = 0.001

[[claims]]
name = "Two"
[[claims.parts]]
metric = "extra.py:spread_m"
of = "rival"
on = ["short"]
below = 0.5
[[claims.parts]]
metric = "arrival_time_s"
on = "lanes"
of = "csm:k=0.3"
against = ["team"]
robot = 2
no_worse_by_percent = 5
"""
EXTRA = """
import numpy as np
from robotics import Run

def spread_m(run):
    "How far it gets from where it begins."
    return np.nanmax(np.hypot(run["x"] - run["x"][..., :1], run["y"] - run["y"][..., :1]), axis=-1)

spread_m.unit = "m"

def flat(run):
    return np.zeros(3)
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, text in (("short.toml", SHORT), ("lanes.toml", TEAM), ("extra.py", EXTRA), ("study.toml", STUDY)):
        (tmp_path / name).write_text(text, encoding="utf-8")
    (tmp_path / "more.py").write_text(EXTRA, encoding="utf-8")
    return tmp_path


def line_of(text: str, wanted: str) -> int:
    return next(n for n, line in enumerate(text.splitlines(), start=1) if wanted in line)


BAD = {  # what is replaced, by what, what the line has, and what the message says
    "unknown key": ('title = "Mine"', 'tilte = "Mine"', "tilte", "unknown key 'tilte'; did you mean 'title'?"),
    "title no text": ('"Mine"', "3", "title", "title must be text in quotes; got 3"),
    "scenario": ('"short.toml", ', '"referenc", ', "scenarios", "scenario 'referenc'; did you mean 'reference'?"),
    "scenario file": ('"short.toml", ', '"no.toml", ', "scenarios", "no.toml: cannot be read"),
    "scenario twice": ('"lanes.toml"', '"short.toml"', "scenarios", "'short' is given twice"),
    "no scenario": ('["short.toml", "lanes.toml"]', "[]", "scenarios", "got []"),
    "controller": ('"lyapunov"', '"lyapunof"', "controllers", "did you mean 'lyapunov'?"),
    "gain": ("k=0.3", "q=0.3", "controllers", "unknown gain 'q'"),
    "law's file": ('"lyapunov"', '"no.py:Law"', "controllers", "no.py: cannot be read"),
    "names": (', "team"]', "]", "names = ", "names must be as many as controllers, 3"),
    "name of another": ('"rival", "gentle"', '"fuzzy", "gentle"', "names = ", "'fuzzy', for lyapunov, is the name of"),
    "seeds": ("seeds = 3", "seeds = 0", "seeds", "seeds must be a whole number >= 1 and <= 100000; got 0"),
    "seeds no number": ("seeds = 3", 'seeds = "3"', "seeds", "got '3'"),
    "metric": ('"rms_cross_track_m"', '"rms_cross_trak_m"', "rms_cross_trak_m", "did you mean 'rms_cross_track_m'?"),
    "metric's function": ("extra.py:spread_m\"\nof", "extra.py:spred_m\"\nof", "spred_m", "did you mean 'spread_m'?"),
    "two of a name": ('"extra.py:spread_m"\nof', '"more.py:spread_m"\nof', "more.py", "would both be called spread_m"),
    "metric of the kind": ('"arrival_time_s"\non = "lanes"', '"arrival_time_s"\non = "short"', "arrival_time_s",
                           "arrival_time_s is not measured on short, which is of kind 'tracking'"),
    "on": ('on = "short"', 'on = "shrt"', 'on = "shrt"', "unknown scenario of the study 'shrt'; did you mean 'short'?"),
    "of": ('of = "gentle"', 'of = "gentel"', "gentel", "controller of the study 'gentel'; did you mean 'gentle'"),
    "against": ('against = "rival"', 'against = "fuzzy"', "against", "unknown controller of the study 'fuzzy'"),
    "itself": ('against = "rival"', 'against = "gentle"', "against", "gentle is compared to itself"),
    "no rival": ('against = "rival"\n', "", "less", "less compares to other controllers: it needs against"),
    "no relation": ("less = true\nmargin = 0.001", "", "[[claims]]", "one relation: below, above, less, more"),
    "two relations": ("less = true", "less = true\nmore = true", "more", "got less and more"),
    "a number against": ("less = true\nmargin = 0.001", "below = 1", "against", "below compares to a number"),
    "less = 3": ("less = true", "less = 3", "less", "less must be true or false; got 3"),
    "margin's sign": ("margin = 0.001", "margin = -0.001", "margin", "write no_worse_by = 0.001"),
    "margin's type": ("margin = 0.001", 'margin = "1 mm"', "margin", "margin must be a finite number; got '1 mm'"),
    "margin's relation": ("below = 0.5", "below = 0.5\nmargin = 0.1", "margin = 0.1", "the relation is below"),
    "margins": ("margin = 0.001", "margin = 0.001\nmargin_percent = 1", "margin_percent", "not both"),
    "too much": ("margin = 0.001", "margin_percent = 100", "margin_percent", "must be < 100"),
    "worse by less than nothing": ("no_worse_by_percent = 5", "no_worse_by_percent = -5", "percent", "must be > 0"),
    "robot": ("robot = 2", "robot = 3", "robot = 3", "robot must be one of lanes, 1 to 2; got 3"),
    "drives not": ('of = "gentle"', 'of = "team"', "of = ", 'does not drive short: short: this law needs'),
    "drives nowhere": (', "lanes.toml"]', "]", "controllers", "team drives no scenario of the study"),
    "claim without name": ('name = "One"\n', "", "[[claims]]", "a claim needs a name"),
    "claim twice": ('name = "Two"', 'name = "One"', "", "'One' is given twice"),
    "parts": ('[[claims.parts]]\nmetric = "arr', '[[claims.prts]]\nmetric = "arr', "", "unknown key 'prts'"),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD)
def test_what_is_wrong_is_told_with_line_key_value_and_what_is_accepted(case: str, folder: Path) -> None:
    before, after, at, says = BAD[case]
    assert before in STUDY
    text = STUDY.replace(before, after, 1)
    (folder / "study.toml").write_text(text, encoding="utf-8")
    if case == "drives nowhere":
        (folder / "study.toml").write_text(text := text[: text.index("[[claims]]")], encoding="utf-8")
    with pytest.raises(StudyError, match=re.escape(says)) as caught:
        load_study(folder / "study.toml")
    told = str(caught.value)
    assert told.startswith(f"{folder / 'study.toml'}:")
    if at:
        assert int(told.removeprefix(f"{folder / 'study.toml'}:").partition(":")[0]) == line_of(text, at)


def test_a_study_is_grouped_by_kind_and_by_who_drives(folder: Path) -> None:
    plan = load_study(folder / "study.toml")
    assert [(g.kind, [s.name for s in g.scenarios], list(g.laws)) for g in plan.groups] == [
        ("tracking", ["short"], ["rival", "gentle"]),
        ("team", ["lanes"], ["rival", "gentle", "team"]),
    ]
    (said,) = plan.groups[0].skipped["short"]
    assert said.startswith("team does not drive here: short: this law needs")
    assert plan.groups[1].skipped == {"lanes": ()}
    assert plan.paragraphs == ()


# How claims are judged ---------------------------------------------------------------------------------------------

ERROR = Measure("error", "m")
ROOM = Measure("clearance", "m", larger=True)


def numbers(seed: int, mean: float, spread: float = 0.1, count: int = 25) -> np.ndarray:
    return mean + spread * np.random.default_rng(seed).standard_normal(count)


def part(measure: Measure, ours: np.ndarray, rivals: dict[str, np.ndarray], **keys: Any) -> Any:
    values = {"mine": ours, **rivals}
    condition = Condition(metric="q", of="mine", against=tuple(rivals), **keys)
    against = list(rivals)
    return decided(condition, measure, values.__getitem__, on="s", of="mine", against=against, fewest=FEWEST_RUNS)


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("relation", ["less", "more", "margin", "percent", "more_percent", "worse", "worse_room"])
def test_verdicts_are_those_of_students_interval(relation: str, seed: int) -> None:
    """The oracle: SciPy's interval of the mean of hand-made differences, wholly on one side of 0 or not."""
    mean = 1.0 + 0.04 * (seed - 6)  # so that some hold, some fail and some are open
    ours, rival = numbers(seed, mean), numbers(seed + 100, 1.0)
    cases: dict[str, tuple[dict[str, Any], Measure, np.ndarray]] = {
        "less": ({"less": True}, ERROR, ours - rival),
        "more": ({"more": True}, ERROR, rival - ours),
        "margin": ({"less": True, "margin": 0.05}, ERROR, ours - rival + 0.05),
        "percent": ({"less": True, "margin_percent": 10}, ERROR, ours - 0.9 * rival),
        "more_percent": ({"more": True, "margin_percent": 10}, ERROR, 1.1 * rival - ours),
        "worse": ({"no_worse_by": 0.05}, ERROR, ours - rival - 0.05),
        "worse_room": ({"no_worse_by": 0.05}, ROOM, rival - 0.05 - ours),
    }
    keys, measure, excess = cases[relation]
    found = part(measure, ours, {"theirs": rival}, **keys)
    low, high = stats.t.interval(0.95, len(excess) - 1, np.mean(excess), stats.sem(excess))
    assert found.outcome == ("holds" if high < 0 else "fails" if low >= 0 else "open")
    assert judge([found]) == {"holds": "holds", "fails": "does not hold", "open": "cannot be told"}[found.outcome]


@pytest.mark.parametrize("kept", range(0, 51, 5))
@pytest.mark.parametrize("asked", [None, 0.8])
def test_a_bound_is_judged_by_the_share_of_runs_that_keep_it(kept: int, asked: float | None) -> None:
    """One infinite number does not make never; the oracle is SciPy's Wilson interval."""
    values = np.r_[np.full(kept, 0.04), np.full(50 - kept, np.inf)]
    found = part(Measure("spread", "s"), values, {}, below=0.05, share=asked, origin="a data sheet")
    interval = stats.binomtest(kept, 50).proportion_ci(0.95, method="wilson")
    least = asked or 0.5
    told = "holds" if interval.low > least else "fails" if interval.high <= least else "open"
    assert (found.outcome, found.kept, found.estimate.kind) == (told, kept, "rate")
    words = reading(found)
    assert f"; {kept} of 50 < 0.05 s (" in words
    assert words.endswith("the bound: a data sheet")
    assert ("never in" in words) == (0 < kept < 50)
    assert not found.close
    assert part(Measure("spread", "s"), values + 0.006, {}, below=0.05).close == (kept > 0)


def test_all_three_outcomes_come_of_the_numbers() -> None:
    seen = {part(ERROR, numbers(1, m), {"r": numbers(2, 1.0)}, less=True, margin=0.1).outcome for m in (0.5, 0.9, 1.5)}
    assert seen == {"holds", "open", "fails"}


def test_a_margin_must_be_kept_by_the_whole_interval() -> None:
    """A mean beyond the margin is not enough, and a margin never helps."""
    ours, rival = numbers(1, 0.87, 0.2), numbers(2, 1.0, 0.2)
    margin = 0.9 * float(np.mean(rival - ours))
    assert margin > 0
    plain, with_margin = (part(ERROR, ours, {"r": rival}, less=True, margin=m) for m in (None, margin))
    assert (plain.outcome, with_margin.outcome) == ("holds", "open")
    below_nothing = numbers(3, -1.0, 0.001), numbers(4, -1.0, 0.001)  # 10 % of a negative number is no gift either
    for direction in ("less", "more"):
        assert (
            part(ERROR, below_nothing[0], {"r": below_nothing[1]}, **{direction: True, "margin_percent": 10}).outcome
            == "fails"
        )


def test_of_several_rivals_the_best_in_each_seed_counts() -> None:
    ours, a, b = numbers(1, 0.9), numbers(2, 1.0), numbers(3, 1.0)
    found = part(ERROR, ours, {"a": a, "b": b}, less=True)
    assert found.estimate.value == pytest.approx(np.mean(ours - np.minimum(a, b)), rel=1e-12)


def test_what_never_happens_is_judged_by_the_share_of_seeds() -> None:
    ours, rival = np.full(25, 3.0), np.r_[np.full(24, np.inf), 2.0]
    found = part(Measure("arrival", "s"), ours, {"r": rival}, less=True)
    assert (found.estimate.kind, found.estimate.value, found.outcome) == ("rate", 1 / 25, "holds")
    both = np.full(25, np.inf)
    assert part(Measure("arrival", "s"), both, {"r": both}, less=True).outcome == "fails"
    assert part(Measure("arrival", "s"), both, {"r": both}, no_worse_by=1.0).outcome == "holds"


@pytest.mark.parametrize("count", [1, 2, 19, 20])
def test_too_few_seeds_tell_nothing(count: int) -> None:
    found = part(ERROR, numbers(1, 0.1, 0.01, count), {"r": numbers(2, 1.0, 0.01, count)}, less=True)
    assert found.outcome == ("holds" if count == 20 else "open")


def test_a_condition_says_what_it_lacks() -> None:
    with pytest.raises(ClaimError, match="got none"):
        Condition(metric="q", of="a")
    with pytest.raises(ClaimError, match="robot must be a whole number >= 1"):
        Condition(metric="q", of="a", below=1.0, robot=0)
    assert Condition(metric="q", of="a", below=0.0).relation == "below"  # 0 is a number, and not nothing


# A run ------------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def own(tmp_path_factory: pytest.TempPathFactory) -> tuple[Any, Path]:
    """The example of docs/howto/own-study.md with few seeds, without pictures."""
    out = tmp_path_factory.mktemp("own")
    return run_study(with_seeds(robotics.load_study(EXAMPLE / "study.toml"), 2), out, report=False), out


def test_the_example_has_what_a_study_is(own: tuple[Any, Path]) -> None:
    study, out = own
    plan = load_study(EXAMPLE / "study.toml")
    assert len(plan.settings) == 4
    assert {Path(c.partition(":")[0]).suffix for c in plan.controllers} >= {".py", ".fis"}
    assert len(plan.claims) == 2
    assert [claim.verdict for claim in study.claims] == ["cannot be told"] * 2  # of two seeds
    assert {"results.csv", "summary.csv", "claims.csv", "evidence.csv", "configuration.json"} <= set(study.files)
    rows = pd.read_csv(out / "results.csv")
    assert len(rows) == 4 * 3 * 2
    assert set(rows["controller"]) == {"formula", "rules", "lyapunov"}


def test_evidence_is_recomputed_from_the_table_of_results(own: tuple[Any, Path]) -> None:
    _, out = own
    rows, evidence = pd.read_csv(out / "results.csv"), pd.read_csv(out / "evidence.csv", keep_default_na=False)
    assert len(evidence) == 4
    for found in evidence.to_dict("records"):
        column = found["quantity"].rpartition(":")[2]
        here = rows[rows["scenario"] == found["on"]].pivot_table(index="seed", columns="controller", values=column)
        apart = here[found["of"]] - found["scale"] * here[found["against"]]
        low, high = stats.t.interval(0.95, len(apart) - 1, np.mean(apart), stats.sem(apart))
        assert [found[k] for k in ("value", "low", "high")] == pytest.approx([np.mean(apart), low, high], rel=1e-9)
        assert (found["runs"], found["fewest"], found["outcome"]) == (2, 20, "open")


def test_the_record_names_every_file_with_its_digest(own: tuple[Any, Path]) -> None:
    _, out = own
    record = json.loads((out / "configuration.json").read_text(encoding="utf-8"))
    names = {"slalom.toml", "yard.toml", "ring.toml", "lane.toml", "mylaw.py", "mine.fis"}
    assert record["files_sha256"] == {n: sha256((EXAMPLE / n).read_bytes()).hexdigest() for n in names}
    assert record["file"] == (EXAMPLE / "study.toml").read_text(encoding="utf-8")
    assert record["seeds"] == [0, 1]
    assert str(EXAMPLE) not in json.dumps(record)


@pytest.mark.long
def test_several_kinds_in_one_study_and_one_report(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("robotics.show.report.plates.DPI", 30)
    plan = replace(load_study(folder / "study.toml"), save_runs=True, text="What I ask.\n\nAnd more.")
    study = run_study(plan, folder / "out")
    assert [c.scenarios[0].kind for c in study.comparisons] == ["tracking", "team"]
    assert study.skipped == ("short: " + plan.groups[0].skipped["short"][0],)
    page = (folder / "out" / "report.html").read_text(encoding="utf-8")
    words = re.sub(r"<[^>]+>", "", page)
    for said in ("Mine", "What I ask.", "And more.", "team does not drive here", "only 3 runs, a verdict needs 20"):
        assert said in words
    assert page.index('id="head"') < page.index('id="verdict"') < page.index('id="scenario-short"')
    assert "As printed" not in words
    rows = pd.read_csv(folder / "out" / "results.csv")
    assert len(rows) == 3 * (2 + 2 * 3)
    assert rows["spread_m"].notna().all()  # one's own metric, in both kinds
    assert len(list((folder / "out" / "runs").glob("*.npz"))) == 5
    (rate,) = (p for claim in study.claims for p in claim.parts if p.quantity == "arrival_time_s")
    assert (rate.of, rate.robots, rate.estimate.kind) == ("gentle", "2", "rate")  # 2 s are too short to arrive
    run = robotics.load_run(folder / "out" / "runs" / "short--rival.npz")
    np.testing.assert_array_equal(measured(run, "rms_cross_track_m"), rows["rms_cross_track_m"][:3])


def test_processes_change_no_digit(folder: Path) -> None:
    plan = load_study(folder / "study.toml")
    for jobs in (1, 2):
        run_study(plan, folder / str(jobs), jobs=jobs, report=False)
    for name in ("results.csv", "summary.csv", "claims.csv", "evidence.csv"):
        assert (folder / "1" / name).read_bytes() == (folder / "2" / name).read_bytes()


def test_a_metric_of_ones_own_that_does_not_measure_is_told(folder: Path) -> None:
    text = STUDY.replace("spread_m", "flat")
    with pytest.raises(MetricError, match=r"one number for each run and robot, \(3, 1\); got the shape \(3,\)"):
        run_study(parse_study(text, folder=folder), folder / "out", report=False)


# The thesis -------------------------------------------------------------------------------------------------------


def test_the_thesis_is_a_study_that_comes_with_the_package() -> None:
    assert "thesis" in study_names()
    plan = load_study("thesis")
    assert list(plan.scenarios) == [n for n in scenario_names() if load_scenario(n).kind == "tracking"]
    assert plan.controllers == DEFAULT_CONTROLLERS["tracking"]
    assert plan.row == range(20)
