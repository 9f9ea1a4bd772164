"""Sweeps: the design, the plan, what a point becomes, and a folder that another sweep finds."""

import json
import math
import re
from concurrent.futures import Executor, Future
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzy.files.claim import alone
from fuzzy.shell.progress import unwatched
from robotics.laws.catalogue import make_controller
from robotics.measures.formations import FORMATION_METRICS
from robotics.measures.teams import TEAM_METRICS
from robotics.measures.tracking import METRICS
from robotics.show.report.plan import StudyError, load_sweep, parse_study
from robotics.show.report.study import run_table
from robotics.simulation.loop import simulate
from robotics.simulation.scenario.reading import parse_scenario
from robotics.studies import chunks, pieces
from robotics.studies.design import Axis, ScenarioDesign, SweepError, design_points, unit_design
from robotics.studies.executors import InProcess, Workers
from robotics.studies.keptcomparison import PACKAGES, Case, KeptComparisons
from robotics.studies.versions import versions
from tests.robotics.commands.test_sweep_command import SCENARIO as ALONE

SCENARIO = f"""{ALONE}
[[robots]]
start = [0.0, 0.9, 0.0]
path = {{ shape = "line", start = [0.0, 1.0], end = [2.0, 1.0] }}
timing = {{ speed = 0.2 }}
"""
SWEEPS = Path(__file__).parents[3] / "robotics" / "data" / "sweeps"
SPEC = """
scenario = "two.toml"
controllers = ["lyapunov", "lyapunov:kx=2"]
seeds = 3
first_seed = 5
chunk = 4

[scenario_fields]
"robots.0.timing.speed" = [0.1, 0.3]
latency = { low = 0.0, high = 0.1, step = 0.05 }

[controller_parameters]
ky = { low = 1, high = 16, count = 3, scale = "log" }
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "two.toml").write_text(SCENARIO, encoding="utf-8")
    return tmp_path


@pytest.fixture
def plan(folder):
    return parse_study(SPEC, "spec", "spec.toml", folder)


def rows(path):
    return pq.ParquetFile(path).read().to_pylist()


def points_of(*axes, method="grid", samples=0, seed=0):
    return design_points(axes, method, samples, seed)


def design(plan):
    """What a point of a study with one scenario changes."""
    return plan.cases[0][0].design


# The design -------------------------------------------------------------------------------------------------------


@settings(max_examples=40)
@given(samples=st.integers(1, 60), axes=st.integers(1, 6), seed=st.integers(0, 2**32))
def test_a_latin_hypercube_has_one_point_in_every_stratum_of_every_axis(samples, axes, seed):
    u = unit_design("latin-hypercube", samples, axes, seed)
    assert u.shape == (samples, axes)
    strata = np.sort(np.floor(u * samples).astype(int), axis=0)
    np.testing.assert_array_equal(strata, np.tile(np.arange(samples)[:, None], axes))
    np.testing.assert_array_equal(u, unit_design("latin-hypercube", samples, axes, seed))


def test_strata_hold_on_a_logarithmic_axis_and_levels_get_equal_shares():
    axes = (Axis("gain", "controller", low=0.01, high=100.0, log=True), Axis("level", "scenario", levels=(3, 5, 8)))
    points = points_of(*axes, method="latin-hypercube", samples=12, seed=4)
    decades = sorted(math.log10(gain) for gain, _ in points)  # 12 strata of 4/12 each
    assert [math.floor((d + 2) * 3) for d in decades] == list(range(12))
    assert sorted(level for _, level in points) == [3] * 4 + [5] * 4 + [8] * 4


def test_random_points_are_the_same_for_the_same_seed_only_and_stay_in_range():
    axis = Axis("x", "scenario", low=-2.0, high=5.0)
    first, again, other = ([p[0] for p in points_of(axis, method="random", samples=400, seed=s)] for s in (1, 1, 2))
    assert first == again != other
    assert -2 <= min(first) < -1.9
    assert 4.9 < max(first) <= 5
    # Uniform: the mean of 400 is normal with σ = 7/√12/20
    assert np.mean(first) == pytest.approx(1.5, abs=4 * 7 / 12**0.5 / 20)


def test_a_grid_is_the_product_with_its_last_axis_fastest(plan):
    expected = [(s, latency, ky) for s, latency, ky in product([0.1, 0.3], [0.0, 0.05, 0.1], [1.0, 4.0, 16.0])]
    assert list(plan.points) == expected
    assert plan.rows == 18 * 2 * 3 * 2
    assert plan.cases[0][0].chunks(plan.row) == 36  # one point and controller each: two would be 6 runs, of 4 at most


def test_values_of_a_range_are_round_and_end_where_they_should(folder):
    text = SPEC.replace("high = 0.1, step = 0.05", "high = 0.3, step = 0.1")
    latency = parse_study(text, folder=folder).axis_list[1]
    assert latency.levels == (0.0, 0.1, 0.2, 0.3)  # not 0.30000000000000004
    text = SPEC.replace("low = 1, high = 16", f"low = {1 / 3!r}, high = {math.pi!r}")
    ky = parse_study(text, folder=folder).axis_list[2]
    assert (ky.levels[0], ky.levels[-1]) == (1 / 3, math.pi)
    assert ky.levels[1] == pytest.approx((math.pi / 3) ** 0.5, rel=1e-14)


@settings(max_examples=60)
@given(points=st.integers(1, 7), controllers=st.integers(1, 3), seeds=st.integers(1, 9), chunk=st.integers(1, 50))
def test_chunks_are_all_runs_in_order_and_no_larger_than_wanted(points, controllers, seeds, chunk):
    laws = [f"c{i}" for i in range(controllers)]
    design = ScenarioDesign(scenario="s", table={}, axes=(Axis("x", "scenario", levels=tuple(range(points))),))
    case = Case(
        parse_scenario(SCENARIO, "two"),
        dict.fromkeys(laws, ""),
        design=design,
        points=points_of(*design.axes),
        chunk=chunk,
    )
    row = range(3, 3 + seeds)
    work = KeptComparisons(Path(), {}, lasting=True, groups=[[case]], seeds=row)
    chunks = [work.chunk(number) for number in range(1, work.ends[-1] + 1)]
    runs = [[(p.point, p.values, p.controller, s) for p in c.passes for s in p.seeds] for c in chunks]
    assert all(0 < len(part) <= chunk for part in runs)
    flat = [run for part in runs for run in part]
    assert flat == [(p + 1, (p,), law, s) for p, law, s in product(range(points), laws, row)]


# A point ----------------------------------------------------------------------------------------------------------


def test_fields_reach_the_scenario_and_leave_the_table_alone(folder):
    text = """
scenario = "two.toml"
controllers = ["lyapunov"]
[scenario_fields]
robots.1.start = [[1.0, 2.0, 0.5]]
"robots.*.timing.speed" = [0.15]
sensing.heading_noise = [0.25]
"robot.v_max" = [0.9]
"robots.0.start.1" = [0.2]
"""
    plan = parse_study(text, folder=folder)
    before = json.dumps(design(plan).table)
    scenario = design(plan).scenario_at(plan.points[0])
    assert [m.timing.speed for m in scenario.robots] == [0.15, 0.15]
    assert [m.start for m in scenario.robots] == [(0.0, 0.2, 0.0), (1.0, 2.0, 0.5)]
    assert scenario.sensing.heading_noise == 0.25
    assert scenario.robots[1].robot.v_max == 0.9
    assert scenario.name == "two"
    assert json.dumps(design(plan).table) == before


def test_gains_reach_the_controller(folder):
    text = SPEC.replace("[controller_parameters]", '[controller_parameters]\nform = ["2.31"]')
    plan = parse_study(text, folder=folder)
    values = (0.1, 0.0, "2.31", 0.1 + 0.2)
    law: Any = make_controller(design(plan).law_at("lyapunov:kx=2,ky=7", values))
    assert (law.kx, law.ky, law.form) == (2.0, 0.1 + 0.2, "2.31")


def test_the_table_is_what_a_simulation_by_hand_gives(folder, plan):
    """Point 10 is 0.3 m/s, no latency, ky = 1: seeds and robots each have their row, to the last bit."""
    done = run_table(plan, folder / "out")
    assert (done.counts.rows, done.computed) == (216, 36)
    table = pq.ParquetFile(done.results).read()
    assert table.column_names == [
        *("scenario", "point", "robots.0.timing.speed", "latency", "ky", "controller", "seed", "robot"),
        *METRICS,
        *("contacts", "min_clearance_m", "diverged", "contact"),
    ]
    mine = [r for r in table.to_pylist() if r["point"] == 10 and r["controller"] == "lyapunov:kx=2"]
    assert [(r["seed"], r["robot"]) for r in mine] == list(product([5, 6, 7], [1, 2]))
    assert {(r["scenario"], r["robots.0.timing.speed"], r["latency"], r["ky"]) for r in mine} == {("two", 0.3, 0, 1)}
    for i, seed in enumerate((5, 6, 7)):
        run = simulate(parse_scenario(SCENARIO, "two"), make_controller("lyapunov:kx=2,ky=1"), [seed])
        for name, metric in METRICS.items():
            np.testing.assert_allclose([r[name] for r in mine[2 * i : 2 * i + 2]], metric.measure(run)[0], rtol=1e-12)


@pytest.mark.parametrize("controller", ["lyapunov", "fuzzy", "csm"])
def test_the_numbers_do_not_depend_on_the_size_of_the_chunks(folder, controller):
    text = SPEC.replace('["lyapunov", "lyapunov:kx=2"]', f'["{controller}"]').split("[scenario_fields]")[0]
    one_robot = SCENARIO.rpartition("[[robots]]")[0]
    (folder / "two.toml").write_text(one_robot.replace("kinematic", "dynamic"), encoding="utf-8")
    tables = []
    for chunk in (1, 2, 3):
        plan = parse_study(text.replace("chunk = 4", f"chunk = {chunk}"), folder=folder)
        tables.append(rows(run_table(plan, folder / f"out{chunk}").results))
    assert tables[0] == tables[1] == tables[2]


def test_a_formation_has_its_own_figures_of_merit(tmp_path):
    text = """
scenario = "formation-ahead"
controllers = ["formation-teacher"]
[scenario_fields]
duration = [1.0]
"""
    (row, *others) = rows(run_table(parse_study(text), tmp_path).results)
    assert len(others) == 2
    assert set(FORMATION_METRICS) | set(METRICS) < set(row)


def test_a_team_brings_its_controller_and_has_its_own_figures_of_merit(folder):
    team = SCENARIO.replace('plant = "kinematic"', 'kind = "team"\ncontroller = "cooperation"\nradio.period = 0.05')
    team = team.replace("speed = 0.3", "duration = 10.0").replace("speed = 0.2", "duration = 10.0")
    (folder / "two.toml").write_text(team, encoding="utf-8")
    text = 'scenario = "two.toml"\nseeds = 2\nscenario_fields."radio.loss" = [0.0, 0.5]'
    table = rows(run_table(parse_study(text, folder=folder), folder / "out").results)
    assert [(r["controller"], r["radio.loss"]) for r in table] == [("cooperation", x) for x in [0] * 4 + [0.5] * 4]
    assert set(TEAM_METRICS) | set(METRICS) < set(table[0])


def test_a_value_that_is_a_list_is_a_column_of_text(folder):
    text = (
        'scenario = "two.toml"\ncontrollers = ["lyapunov"]\nscenario_fields."robots.0.start" = [[0, 0, 0], [0, 1, 0.5]]'
    )
    done = run_table(parse_study(text, folder=folder), folder / "out")
    assert [r["robots.0.start"] for r in rows(done.results)] == ["[0, 0, 0]"] * 2 + ["[0, 1, 0.5]"] * 2


def test_diverged_robots_are_rows_like_others(folder):
    (folder / "two.toml").write_text(SCENARIO + "\n", encoding="utf-8")
    text = 'scenario = "two.toml"\ncontrollers = ["lyapunov"]\nscenario_fields.divergence = [0.05, 10.0]'
    done = run_table(parse_study(text, folder=folder), folder / "out")
    assert [r["diverged"] for r in rows(done.results)] == [True, True, False, False]
    assert done.counts.diverged == 2


# The folder -------------------------------------------------------------------------------------------------------


class Counting(Executor):
    """Does nothing until it is full, then all it has, last first; fails on the chunks it is told to."""

    def __init__(self, full, failing=()):
        self.full, self.failing = full, set(failing)
        self.waiting, self.submitted, self.most = [], [], 0

    def submit(self, fn, /, chunk):  # type: ignore[override]
        future: Future[Any] = Future()
        self.waiting.append((future, fn, chunk))
        self.submitted.append(chunk.number)
        self.most = max(self.most, len(self.waiting))
        if len(self.waiting) == self.full or chunk.number == self.last:
            for waiting, f, other in reversed(self.waiting):
                if other.number in self.failing:
                    waiting.set_exception(RuntimeError("out of luck"))
                else:
                    waiting.set_result(f(other))
            self.waiting.clear()
        return future

    last = 36


@pytest.mark.long
def test_no_more_chunks_are_in_flight_than_allowed_and_the_order_does_not_matter(folder, plan):
    crew = Counting(4)
    done = run_table(plan, folder / "out", Workers(crew, 4))
    assert crew.most == 4
    assert crew.submitted == list(range(1, 37))
    assert done.results.read_bytes() == run_table(plan, folder / "alone").results.read_bytes()


def test_what_failed_is_named_and_only_what_is_missing_is_done_again(folder, plan):
    with pytest.raises(SweepError) as caught:
        run_table(plan, folder / "out", Workers(Counting(3, failing=[8]), 3))
    # Chunk 8 of two controllers at each point
    assert "point 4 (robots.0.timing.speed = 0.1, latency = 0.05, ky = 1), controller 'lyapunov:kx=2'" in str(
        caught.value
    )
    assert "seeds 5 to 7" in str(caught.value)
    assert "RuntimeError: out of luck" in str(caught.value)
    there = {f.name: f.stat().st_mtime_ns for f in (folder / "out" / "pieces").glob("chunk*")}
    assert 6 <= len(there) <= 8
    told = []
    crew = Counting(1)
    done = run_table(plan, folder / "out", Workers(crew), resumed=lambda *counts: told.append(counts))
    assert told == [(len(there), 36)]
    assert done.computed == 36 - len(there) == len(crew.submitted)
    assert {n: (folder / "out" / "pieces" / n).stat().st_mtime_ns for n in there} == there
    assert done.results.read_bytes() == run_table(plan, folder / "alone").results.read_bytes()


def test_a_run_that_fails_names_its_point_and_seeds(folder, plan, monkeypatch):
    def fail(scenario, law, seeds, **named):
        if law.kx == 2 and scenario.latency == 0.05:
            raise np.linalg.LinAlgError("singular matrix")
        return simulate(scenario, law, seeds, **named)

    monkeypatch.setattr("robotics.studies.keptcomparison.simulate", fail)
    with pytest.raises(SweepError, match=r"point 4 \(.*latency = 0.05, ky = 1\), controller 'lyapunov:kx=2', seed"):
        run_table(plan, folder / "out")


def test_a_damaged_or_foreign_chunk_is_done_again(folder, plan):
    first = run_table(plan, folder / "out")
    expected = first.results.read_bytes()
    there = folder / "out" / "pieces"
    (there / "chunk-000003.parquet").write_bytes((there / "chunk-000003.parquet").read_bytes()[:-100])
    (there / "chunk-000004.parquet").write_bytes(b"")
    table = pq.ParquetFile(there / "chunk-000005.parquet").read()
    pq.write_table(table.replace_schema_metadata({"sweep": "another"}), there / "chunk-000005.parquet")
    seventh = bytearray((there / "chunk-000007.parquet").read_bytes())
    seventh[len(seventh) // 3] ^= 1
    (there / "chunk-000007.parquet").write_bytes(seventh)
    (there / "chunk-000008.parquet").write_bytes((there / "chunk-000009.parquet").read_bytes())  # whole, but another
    (there / ".chunk-000009-0123abcd.parquet").write_bytes(b"half")  # as a killed process leaves it
    with pytest.warns(UserWarning, match="is not of this sweep; it is computed again") as told:
        again = run_table(plan, folder / "out")
    assert [re.search(r"chunk-00000(\d)", str(each.message))[1] for each in told] == ["3", "4", "5", "7", "8"]
    assert again.computed == 5
    assert again.results.read_bytes() == expected
    assert len(list(there.glob("*chunk*"))) == 36


def test_a_chunk_that_is_spoilt_before_it_is_joined_is_done_again(folder, plan, monkeypatch):
    plan = replace(plan, axes=(), chunk=1)
    expected = run_table(plan, folder / "first").results.read_bytes()
    write, left = chunks._write, [2]

    def spoil(table, path, kind, key, number):
        write(table, path, kind, key, number)
        if number in left:
            left.remove(number)
            path.write_bytes(path.read_bytes()[:-9])

    monkeypatch.setattr(chunks, "_write", spoil)
    with pytest.warns(UserWarning, match=r"chunk-000002\.parquet is damaged"):
        again = run_table(plan, folder / "out")
    assert again.results.read_bytes() == expected
    assert not left


@pytest.mark.long
def test_a_cluster_without_workers_is_said_once(folder, plan, monkeypatch):
    plan = replace(plan, axes=(), chunk=2)
    monkeypatch.setattr(pieces, "_PATIENCE", 0.0)
    late: list[tuple[Future, tuple]] = []
    asked: list[int] = []

    class Nobody(InProcess):
        def submit(self, fn, /, *args, **kwargs):
            if len(asked) > 2:
                return super().submit(fn, *args, **kwargs)
            late.append((Future(), (fn, args)))
            return late[-1][0]

    def idle():
        asked.append(1)
        if len(asked) == 3:  # somebody comes, and does all
            for future, (fn, args) in late:
                future.set_result(fn(*args))
        return "" if len(asked) > 2 else "nobody is there"

    with pytest.warns(UserWarning, match="nobody is there") as told:
        done = run_table(plan, folder / "out", Workers(Nobody(), 2, idle=idle))
    assert len(told) == 1
    assert done.computed == done.chunks


@pytest.mark.long
def test_another_sweep_in_the_folder_is_refused_but_for_fresh(folder, plan):
    out = folder / "out"
    before = run_table(plan, out).results.read_bytes()
    for old, new, sentence in (
        ("seeds = 3", "seeds = 4", "seeds changed"),
        ("step = 0.05", "step = 0.1", "axes changed"),
        ("kx=2", "kx=3", "controllers changed"),
        ("chunk = 4", "chunk = 50", "chunk changed"),
    ):
        other = parse_study(SPEC.replace(old, new), folder=folder)
        with pytest.raises(SweepError, match=sentence) as caught:
            run_table(other, out)
        assert "--fresh" in str(caught.value)
        assert (out / "results.parquet").read_bytes() == before
    done = run_table(other, out, fresh=True)
    assert done.computed == done.chunks == 4
    assert len(list((out / "pieces").glob("chunk*"))) == 4
    table, expected = rows(done.results), rows(run_table(plan, folder / "alone").results)
    assert table == expected  # chunks of another size, the same numbers


def test_a_comment_in_the_file_changes_nothing_but_scenario_versions_and_files_do(folder, plan, monkeypatch):
    out = folder / "out"
    run_table(plan, out)
    same = parse_study(SPEC + "\n# so far\n", "renamed", "other.toml", folder)
    assert run_table(same, out).computed == 0
    (folder / "two.toml").write_text(SCENARIO.replace("0.002", "0.003"), encoding="utf-8")
    with pytest.raises(SweepError, match="holds another sweep: scenarios, files changed"):
        run_table(parse_study(SPEC, folder=folder), out)
    (folder / "two.toml").write_text(SCENARIO, encoding="utf-8")
    true = versions(*PACKAGES)
    monkeypatch.setattr("robotics.show.report.study.versions", lambda *names: true | {"numpy": "1.0"})
    with pytest.raises(SweepError, match=rf"numpy {true['numpy']} became 1.0"):
        run_table(plan, out)
    (out / "pieces" / "plan.json").write_text("[", encoding="utf-8")
    with pytest.raises(SweepError, match=r"plan\.json: this is no sweep"):
        run_table(plan, out)


def test_a_rule_base_that_a_controller_reads_belongs_to_the_sweep(folder):
    from fuzzy.files.fisfile import write_fis
    from robotics.laws.tracking.fuzzy_tracking import load_rule_base

    rules = folder / "my.fis"
    write_fis(load_rule_base("tracking"), rules)
    text = SPEC.split("[scenario_fields]")[0].replace('["lyapunov", "lyapunov:kx=2"]', f'["fuzzy:rule_base={rules}"]')
    plan = parse_study(text, folder=folder)
    out = folder / "out"
    run_table(plan, out)
    about = json.loads((out / "pieces" / "plan.json").read_text(encoding="utf-8"))
    assert list(about["files_sha256"]) == ["my.fis", "two.toml"]  # as seen from the sweep
    rules.write_text(rules.read_text(encoding="utf-8") + "\n", encoding="utf-8")
    with pytest.raises(SweepError, match="holds another sweep: files changed"):
        run_table(plan, out)


def test_a_worker_with_other_versions_is_refused(folder, plan):
    with pytest.raises(SweepError, match=r"a worker has numpy .* where this was planned with 1\.0"):
        chunks.run_chunk(pd.DataFrame, str, versions(*PACKAGES) | {"numpy": "1.0"}, SweepError, chunks.Chunk(1, ()))


def test_a_folder_belongs_to_one_sweep_at_a_time(folder, plan):
    (folder / "pieces").mkdir()
    with alone(folder / "pieces", SweepError("held")), pytest.raises(SweepError, match="another sweep is at work here"):
        run_table(plan, folder)


# What is refused --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("old", "new", "fragments"),
    [
        ("chunk = 4", "chunks = 4", ["spec.toml:6: ", "unknown key 'chunks'; did you mean 'chunk'"]),
        ("chunk = 4", "chunk = 0", ["spec.toml:6: ", "chunk must be a whole number >= 1; got 0"]),
        ("seeds = 3", "seeds = 2.5", ["spec.toml:4: ", "seeds must be a whole number >= 1 and <= 100000; got 2.5"]),
        ("first_seed = 5", "first_seed = -1", ["spec.toml:5: ", "whole number >= 0 and <= 1000000000000000; got -1"]),
        ("seeds = 3", 'seeds = 3\nmethod = "gird"', ["spec.toml:5: ", "'grid', 'random', 'latin-hypercube'", "'gird'"]),
        ("seeds = 3", "seeds = 3\nsamples = 5", ["spec.toml:5: ", "samples belongs to method = 'random'"]),
        ("seeds = 3", 'seeds = 3\nmethod = "random"', ["spec.toml:5: ", "needs samples = N"]),
        ('"two.toml"', '"three.toml"', ["spec.toml:2: ", "three.toml: cannot be read"]),
        ('"two.toml"', '"referense"', ["spec.toml:2: ", "unknown scenario 'referense'; did you mean 'reference'"]),
        ('"lyapunov",', '"lyapnov",', ["spec.toml:3: ", "unknown controller 'lyapnov'; did you mean 'lyapunov'"]),
        ('"lyapunov",', '"lyapunov:kx=2",', ["spec.toml:3: ", "'lyapunov:kx=2' is given twice"]),
        ("[0.1, 0.3]", "[0.1, 0.1]", ["spec.toml:9: ", "robots.0.timing.speed: 0.1 is given twice"]),
        ("[0.1, 0.3]", "[]", ["spec.toml:9: ", "at least one value"]),
        ("[0.1, 0.3]", "0.1", ["spec.toml:9: ", "a list of values or a range { low, high, ... }; got 0.1"]),
        ("[0.1, 0.3]", "[0.1, nan]", ["spec.toml:9: ", "numbers must be finite", "got nan"]),
        ("[0.1, 0.3]", '[0.1, "x"]', ["spec.toml:9: ", "of one kind"]),
        ("latency", "kind", ["spec.toml:10: ", "make one sweep for each"]),
        ("latency", "seed", ["spec.toml:10: ", "two columns 'seed'"]),
        ("high = 0.1", "high = 0.0", ["spec.toml:10: ", "low must be below high; got 0 and 0"]),
        ("high = 0.1, step", "high = 0.1, stepp", ["spec.toml:10: ", "unknown key 'stepp'; did you mean 'step'"]),
        ("step = 0.05", "step = 0.5", ["spec.toml:10: ", "step must be > 0 and at most high - low = 0.1; got 0.5"]),
        (", step = 0.05", "", ["spec.toml:10: ", "a grid needs count = N"]),
        ("count = 3", "count = 1", ["spec.toml:13: ", "controller_parameters: ky: ", "whole number >= 2", "got 1"]),
        ("low = 1,", "low = 0,", ["spec.toml:13: ", "low must be > 0 where scale is 'log'; got 0"]),
        ('"log"', '"cubic"', ["spec.toml:13: ", "'linear' or 'log'; got 'cubic'"]),
        ("ky = {", 'form = ["2.31,kx=3"]\nky = {', ["spec.toml:13: ", "no comma"]),
        ("ky = {", "kx = [true]\nky = {", ["spec.toml:13: ", "a gain is a number or text in quotes; got True"]),
        # What only a point shows
        ("0.3]", "3.0]", ["spec.toml:9: point 10 (robots.0.timing.speed = 3, latency = 0, ky = 1)", "infeasible"]),
        ("step = 0.05", "step = 0.025", ["spec.toml:10: point 4 (", "latency must be a multiple of 0.01 s, got 0.025"]),
        ("latency =", "latencyy =", ["spec.toml:10: point 1", "unknown key 'latencyy'; did you mean 'latency'"]),
        ("robots.0", "robots.2", ["spec.toml:9: point 1", "'2' is no entry of a list of 2: 0 to 1, or *"]),
        ("robots.0.timing.speed", "duration.x", ["spec.toml:9: point 1", "'x' stands below 1.0"]),
        ("ky =", "kyy =", ["spec.toml:13: point 1", "controller 'lyapunov': unknown gain 'kyy'; did you mean 'ky'"]),
        ('[0.1, 0.3]', '[0.1, 0.3]\n"sensing.posture" = ["pose", "odometry"]', ["spec.toml:", "point ", "posture"]),
        ("scenario =", "scenario ==", ["spec.toml:2: this is not TOML"]),
    ],
)  # fmt: skip
def test_what_is_refused_names_file_line_and_field(folder, old, new, fragments):
    assert SPEC.count(old) >= 1
    with pytest.raises((StudyError, SweepError)) as caught:
        parse_study(SPEC.replace(old, new, 1), "spec", "spec.toml", folder).check_points(unwatched)
    for fragment in fragments:
        assert fragment in str(caught.value)


def test_a_design_beyond_all_measure_is_refused():
    axes = [Axis(f"a{i}", "scenario", levels=tuple(range(100))) for i in range(4)]
    with pytest.raises(SweepError, match="100000000 points; at most 1000000"):
        points_of(*axes)


@pytest.mark.parametrize("name", sorted(file.stem for file in SWEEPS.glob("*.toml")))
def test_the_sweeps_of_the_package_are_sound(name):
    plan = load_sweep(name)
    design(plan).check(plan.points[:: max(1, len(plan.points) // 5)], plan.laws.values())


def test_an_unknown_sweep_is_named(tmp_path):
    with pytest.raises(StudyError, match=r"unknown sweep 'lyapunov-gain'; did you mean 'lyapunov-gains'"):
        load_sweep("lyapunov-gain")
    with pytest.raises(StudyError, match=r"none\.toml: cannot be read: No such file"):
        load_sweep(tmp_path / "none.toml")
