"""Controllers by file: a law in a Python file, or a rule base, wherever a controller is named."""

import json
import pickle
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest

from fuzzy.errors import InputError
from robotics.commands.application import main
from robotics.commands.compare import split_controllers
from robotics.laws.catalogue import files_of, gains_of, label, law_title, located, make_controller, safety_distance
from robotics.laws.law import ControllerError
from robotics.laws.specification import Specification
from robotics.laws.tracking.fuzzy_tracking import RULE_BASES
from robotics.measures.registry import measure_all
from robotics.plugins.stress.crossings import stress_crossing
from robotics.show.report.plan import load_sweep
from robotics.show.report.study import run_table
from robotics.simulation.loop import simulate
from robotics.simulation.scenario.reading import load_scenario
from robotics.studies.executors import processes

CARROT = '''
from dataclasses import dataclass
import numpy as np
from robotics import Command, Law
from robotics.world.paths.posture import posture_error

@dataclass(frozen=True, kw_only=True)
class Carrot(Law[None]):
    """Turn to a point 0.3 m ahead of the reference."""

    gain: float = 2.0
    brisk: bool = False

    def init(self, setting, runs):
        return None

    def control(self, seen, memory, dt):
        e = posture_error(seen.x, seen.y, seen.heading, seen.reference)
        v = np.clip(seen.reference.v + e.x, 0.0, 0.6)
        w = self.gain * np.arctan2(e.y, e.x + 0.3)
        return Command(v, w, v, w), None
'''
SCENARIO = """
duration = 0.5
[[robots]]
start = [0.0, 0.0, 0.0]
timing = { speed = 0.2 }
path = { shape = "line", start = [0.0, 0.0], end = [2.0, 0.0] }
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """The current folder: a law in laws/mylaw.py, a rule base, and a scenario."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "laws").mkdir()
    (tmp_path / "laws" / "mylaw.py").write_text(CARROT, encoding="utf-8")
    (tmp_path / "mine.fis").write_bytes((RULE_BASES / "tracking.fis").read_bytes())
    (tmp_path / "short.toml").write_text(SCENARIO, encoding="utf-8")
    return tmp_path


@pytest.mark.parametrize(
    ("text", "parts", "short"),
    [
        ("csm", ("", "csm", ""), "csm"),
        ("fuzzy:rule_base=a/mine.fis,look_ahead=1", ("", "fuzzy", "rule_base=a/mine.fis,look_ahead=1"), "fuzzy"),
        ("a/mylaw.py", ("a/mylaw.py", "", ""), "mylaw.py"),
        ("a/mylaw.py:MyLaw", ("a/mylaw.py", "MyLaw", ""), "MyLaw"),
        ("a/mylaw.py:gain=2", ("a/mylaw.py", "", "gain=2"), "mylaw.py"),
        ("mylaw.py:MyLaw:gain=2,k=3", ("mylaw.py", "MyLaw", "gain=2,k=3"), "MyLaw"),
        (r"C:\laws\mylaw.py:MyLaw:gain=2", (r"C:\laws\mylaw.py", "MyLaw", "gain=2"), "MyLaw"),
        ("D:/my.rules/mine.fis:look_ahead=1", ("D:/my.rules/mine.fis", "", "look_ahead=1"), "mine.fis"),
        ("../a.py.d/mine.fis", ("../a.py.d/mine.fis", "", ""), "mine.fis"),
    ],
)
def test_a_specification_has_three_parts(text, parts, short):
    found = Specification.of(text)
    assert (found, found.short, str(found)) == (parts, short, text)


def test_a_list_of_specifications_is_split_at_the_laws():
    text = "a/mylaw.py:MyLaw:gain=2,k=3,mine.fis,C:/b.py:B,fuzzy:rule_base=C:/x.fis,look_ahead=1"
    wanted = ["a/mylaw.py:MyLaw:gain=2,k=3", "mine.fis", "C:/b.py:B", "fuzzy:rule_base=C:/x.fis,look_ahead=1"]
    assert split_controllers(text) == wanted


def test_a_law_in_a_file_is_made_with_its_gains_and_called_by_its_name(folder):
    law: Any = make_controller("laws/mylaw.py:Carrot:gain=3,brisk=true")
    assert (type(law).__name__, law.gain, law.brisk) == ("Carrot", 3.0, True)
    assert type(make_controller("laws/mylaw.py")) is type(law)
    assert label("laws/mylaw.py:Carrot:gain=3") == "Carrot (gain=3)"
    assert pickle.loads(pickle.dumps(law)) == law
    assert [*files_of("laws/mylaw.py:Carrot")] == ["laws/mylaw.py"]


def test_a_rule_base_in_a_file_is_the_law_fuzzy_with_it(folder):
    assert gains_of(make_controller("mine.fis:look_ahead=0.5")) == gains_of(
        make_controller("fuzzy:rule_base=mine.fis,look_ahead=0.5")
    )
    assert label("mine.fis:look_ahead=0.5") == "mine.fis (look_ahead=0.5)"
    runs = [simulate(load_scenario("short.toml"), make_controller(name)) for name in ("mine.fis", "fuzzy")]
    np.testing.assert_array_equal(runs[0]["x"], runs[1]["x"])


def test_an_edited_file_is_another_law_and_what_was_made_stays(folder):
    before: Any = make_controller("laws/mylaw.py")
    file = folder / "laws" / "mylaw.py"
    file.write_text(CARROT.replace("gain: float = 2.0", "gain: float = 7.0"), encoding="utf-8")
    after: Any = make_controller("laws/mylaw.py")
    assert (before.gain, after.gain) == (2.0, 7.0)
    assert pickle.loads(pickle.dumps(before)) == before


def test_nothing_runs_for_the_title_of_a_saved_run(folder):
    (folder / "trap.py").write_text("raise SystemExit('it ran')", encoding="utf-8")
    assert law_title("trap.py:Trap:gain=2") == "Trap (gain=2)"
    assert safety_distance("trap.py:Trap", ()) is None


@pytest.mark.parametrize(
    ("text", "name", "message"),
    [
        ("def f(:\n", "", "mylaw.py:1: SyntaxError: "),
        ("x = 1\n\nimport nowhere_at_all\n", "", "mylaw.py:3: ModuleNotFoundError: No module named 'nowhere_at_all'"),
        ("def f():\n    return 1 / 0\nf()\n", "", "mylaw.py:2: ZeroDivisionError: division by zero"),
        ("raise SystemExit(3)", "", "mylaw.py:1: SystemExit: 3"),
        ("x = 1", "", "mylaw.py: one law is needed, a frozen dataclass derived from robotics.Law; it has none"),
        (CARROT + "class Other(Carrot):\n    pass\n", "", "it has Carrot, Other: say which, as in mylaw.py:Carrot"),
        (CARROT, ":Carot", "mylaw.py: unknown law 'Carot'; did you mean 'Carrot'? Known: Carrot"),
        (
            CARROT.replace("(frozen=True, kw_only=True)", "(kw_only=True)"),
            ":Carrot",
            "mylaw.py: Carrot must be a frozen dataclass derived from robotics.Law: write @dataclass(frozen=True, kw",
        ),
        (CARROT, ":np", "must be a frozen dataclass derived from robotics.Law: it is <module 'numpy'"),
        (CARROT, ":dataclass", "it is <function dataclass"),
        (CARROT + "class Plain:\n    pass\n", ":Plain", "it does not derive from robotics.Law; it has: Carrot"),
        (CARROT.replace("control(", "steer("), ":Carrot", "it does not define control"),
        (CARROT, ":Carrot:gian=2", "mylaw.py:Carrot': unknown gain 'gian'; did you mean 'gain'?"),
        (CARROT, ":Carrot:gain=two", "mylaw.py:Carrot': gain must be a number; got 'two'"),
        (CARROT, ":Carrot:brisk=2", "mylaw.py:Carrot': brisk must be true or false; got '2'"),
        (CARROT.replace("gain: float = 2.0", "gain: float"), ":Carrot", "missing 1 required keyword-only argument"),
    ],
)
def test_what_is_wrong_with_a_file_is_one_sentence(folder, text, name, message):
    (folder / "mylaw.py").write_text(text, encoding="utf-8")
    with pytest.raises(ControllerError) as raised:
        make_controller(f"mylaw.py{name}")
    assert message in str(raised.value)
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("return seen.nothing", "mylaw.py:21: AttributeError: 'Observation' object has no attribute 'nothing'"),
        ("return 1", "control of the law Carrot must return a Command and its memory; got int"),
        (
            "return Command(1.0, np.zeros((3, 2)), 1.0, 1.0), None",
            "(runs, robots) = (1, 1) as second; got shape (3, 2)",
        ),
        ("return Command('fast', 0.0, 1.0, 1.0), None", "as first; got 'fast'"),
    ],
)
def test_a_law_that_fails_while_it_drives_is_one_sentence(folder, line, message, capsys):
    text = CARROT.replace("return Command(v, w, v, w), None", line)
    (folder / "mylaw.py").write_text(text, encoding="utf-8")
    assert main(["run", "short.toml", "-c", "mylaw.py", "-q"]) == 2
    assert message in capsys.readouterr().err
    with pytest.raises(ControllerError) as raised:
        simulate(load_scenario("short.toml"), make_controller("mylaw.py"))
    assert (raised.value.__cause__ is not None) == ("nothing" in line)


def test_files_are_found_from_where_they_are_named(folder, monkeypatch, capsys):
    (folder / "laws" / "own.toml").write_text('controller = "mylaw.py:Carrot:gain=3"\n' + SCENARIO, encoding="utf-8")
    assert load_scenario("laws/own.toml").controller == str(Path("laws/mylaw.py:Carrot:gain=3"))
    assert located("fuzzy:rule_base=mine.fis", folder) == f"fuzzy:rule_base={folder / 'mine.fis'}"
    assert located("nowhere.py:X", folder) == "nowhere.py:X"
    (folder / "laws" / "wrong.toml").write_text('controller = "mylow.py"\n' + SCENARIO, encoding="utf-8")
    with pytest.raises(InputError, match=r"wrong.toml:1: mylow.py: cannot be read"):
        load_scenario("laws/wrong.toml")
    monkeypatch.chdir(folder / "laws")
    assert load_scenario("own.toml").controller == "mylaw.py:Carrot:gain=3"


def test_worker_processes_are_told_no_class_of_a_file(folder):
    sweep = 'scenario = "../short.toml"\ncontrollers = ["mylaw.py:Carrot"]\n'
    (folder / "laws" / "one.toml").write_text(sweep, encoding="utf-8")
    plan = load_sweep("laws/one.toml")
    passes = plan.cases[0][0].passes(0, plan.row, {})
    told = pickle.dumps((passes, plan.metrics_located, partial(stress_crossing, "laws/mylaw.py:Carrot", 2)))
    module = type(make_controller("laws/mylaw.py")).__module__
    assert module.encode() not in told
    assert module.encode() in pickle.dumps(make_controller("laws/mylaw.py"))


@pytest.mark.long
def test_worker_processes_do_the_same(folder):
    sweep = 'scenario = "../short.toml"\ncontrollers = ["mylaw.py:Carrot", "../mine.fis"]\nseeds = 2\nchunk = 2\n'
    (folder / "laws" / "two.toml").write_text(sweep, encoding="utf-8")
    plan = load_sweep("laws/two.toml")
    stress = partial(stress_crossing, "laws/mylaw.py:Carrot", 2, (0, 1))
    with processes(1) as crew:
        work = crew.executor.submit(stress)
        run_table(plan, folder / "swept", crew)
        assert work.result().summary() == stress().summary()
    table = pq.read_table("swept/results.parquet").to_pylist()
    assert [row["controller"] for row in table] == ["mylaw.py:Carrot"] * 2 + ["../mine.fis"] * 2
    own = measure_all(simulate(load_scenario("short.toml"), make_controller("laws/mylaw.py"), (0, 1)))
    assert [row["mean_error_norm"] for row in table[:2]] == [*own["mean_error_norm"][:, 0]]
    files = json.loads(Path("swept/pieces/plan.json").read_text(encoding="utf-8"))["files_sha256"]
    assert {*files} == {"mylaw.py", "../mine.fis", "../short.toml"}


@pytest.mark.long
def test_the_number_of_processes_changes_nothing(folder, capsys):
    told = []
    for jobs in ("1", "2"):
        line = ["stress", "crossing", "--controller", "laws/mylaw.py:Carrot", "--runs", "60", "--json", "-q"]
        assert main([*line, "--workers", jobs]) == 0
        told.append(json.loads(capsys.readouterr().out))
    assert told[0] == told[1]


def test_a_comparison_names_files_shortly_and_keeps_their_digests(folder, capsys):
    names = "laws/mylaw.py:Carrot:gain=3,mine.fis"
    assert main(["compare", "short.toml", "--controllers", names, "--seeds", "2", "--no-report", "-q"]) == 0
    assert "Carrot (gain=3)" in capsys.readouterr().out
    about = json.loads(Path("out/configuration.json").read_text(encoding="utf-8"))
    assert [*about["controllers"]] == names.split(",")
    assert {*about["files_sha256"]} == {"laws/mylaw.py", "mine.fis"}
