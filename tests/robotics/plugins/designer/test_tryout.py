"""The panel "Try it": its runs are the simulator's own, its session runs the latest wish, its module shows them."""

import asyncio
import json
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from fuzzy.compiled.kernel import evaluate_batch
from fuzzy.errors import InputError
from fuzzy.files.fisfile import write_fis
from fuzzy.membership import Gaussian
from fuzzy.plugins.designer.design import design_of
from fuzzy.system import Constant, Linear, Sugeno, Variable
from robotics.laws.catalogue import make_controller, presets
from robotics.laws.tracking.fuzzy_tracking import load_rule_base
from robotics.measures.registry import measure_all, panel_metrics
from robotics.plugins.designer import session as session_module
from robotics.plugins.designer.folderfiles import read_text_file
from robotics.plugins.designer.moments import rounded_list
from robotics.plugins.designer.panel import formation_data, panel
from robotics.plugins.designer.session import TryoutSession
from robotics.plugins.designer.tryout import (
    Attempt,
    TryoutTrial,
    choices,
    course_data,
    design_data,
    driven_law,
    place_data,
    reduced_metrics,
    rival_data,
    run_design,
    settled,
    shown,
)
from robotics.plugins.designer.uses import TryoutError, law_of
from robotics.plugins.learning.formationdata import FILES, FormationRecipe
from robotics.plugins.learning.formationdata import formation_data as formation_table
from robotics.simulation.loop import simulate
from robotics.simulation.scenario.reading import load_scenario, scenario_names
from robotics.studies.forewarnings import forewarnings
from robotics.studies.tuning.cost import COST_TERMS, Cost
from tests.browsers import run_apart
from tests.robotics.plugins.designer.tried import beside, on_page

TEAM = "crossing-in-turn"
NEW = Path("no-such-folder/new.fis")  # a system that has not been saved yet


@pytest.fixture(scope="module")
def tracking() -> Sugeno:
    return load_rule_base("tracking")


@pytest.fixture(scope="module")
def slower(tracking: Sugeno) -> Sugeno:
    """The rule base with a gentler turn: another system, with another path."""
    v, w = tracking.outputs
    return replace(tracking, name="slower", outputs=(v, replace(w, terms={**w.terms, "Positive": Constant(1.5)})))


# The runs -------------------------------------------------------------------------------------------------------


def test_the_package_s_rule_base_drives_as_the_package_s_law(tracking: Sugeno) -> None:
    trial = TryoutTrial(scenario="table-2-1", seed=3)
    direct = simulate(load_scenario("table-2-1"), make_controller("fuzzy"), (3,))
    run = run_design(tracking, trial).run
    assert np.array_equal(run.samples, direct.samples)
    measured = measure_all(direct)
    data = design_data(tracking, trial)
    names = [*panel_metrics("tracking"), *(term.metric for term in COST_TERMS)]
    assert {n: x for n, x in data["metrics"].items() if n != "cost"} == {n: float(measured[n][0, 0]) for n in names}
    parts = [measured[term.metric][0, 0] / term.scale for term in COST_TERMS]
    assert data["metrics"]["cost"] == pytest.approx(sum(parts), rel=1e-12)
    assert list(data["shares"].values()) == pytest.approx(np.array(parts) / sum(parts))
    assert [m["name"] for m in course_data(trial)["metrics"]][:4] == ["cost", *(term.metric for term in COST_TERMS)]
    np.testing.assert_allclose(data["x"][0], direct["x"][0, 0], atol=5.1e-5)
    assert len(data["cross_track"][0]) == len(data["time"]) == len(direct.time)


def test_a_changed_system_drives_as_its_file_would(slower: Sugeno, tracking: Sugeno, tmp_path: Path) -> None:
    file = tmp_path / "slower.fis"
    write_fis(slower, file)
    direct = simulate(load_scenario("fuzzy-off-path"), make_controller(f"fuzzy:rule_base={file},look_ahead=0.7"))
    run = run_design(slower, TryoutTrial(look_ahead=0.7)).run
    assert np.array_equal(run.samples, direct.samples)
    assert not np.array_equal(run.samples, run_design(tracking, TryoutTrial(look_ahead=0.7)).run.samples)


@pytest.fixture(scope="module")
def team(slower: Sugeno) -> Attempt:
    return run_design(slower, TryoutTrial(scenario=TEAM))


def test_a_team_s_law_takes_the_system_where_it_holds_one(team: Attempt, slower: Sugeno, tmp_path: Path) -> None:
    file = tmp_path / "slower.fis"
    write_fis(slower, file)
    direct = simulate(load_scenario(TEAM), make_controller(f"cooperation:rule_base={file}"), message_ages=True)
    assert settled(slower, TryoutTrial(scenario=TEAM)).law == "cooperation"
    assert np.array_equal(team.run.samples, direct.samples)
    measured = measure_all(direct)
    told = shown(team, "slower")
    metrics = told["metrics"]
    assert metrics["min_distance_m"] == measured["min_distance_m"].min()
    assert metrics["arrival_time_s"] == measured["arrival_time_s"].mean()
    assert team.run.about.rule_bases == {"tracking": slower}
    (base,) = told["player"]["rules"]["bases"]  # the player shows which rules of the design fire
    assert (base["task"], len(base["rules"])) == ("tracking", len(slower.rules))


def test_the_shared_law_stays_as_it_is(slower: Sugeno) -> None:
    trial = settled(slower, TryoutTrial(scenario="trap-u"))
    driven: Any = driven_law(slower, trial)
    assert driven.cooperation.tracker.tracking.fis is slower
    law: Any = law_of("obstacles")
    assert law.cooperation.tracker.tracking.fis.name != slower.name


def test_a_rival_is_the_catalogue_s_law() -> None:
    direct = simulate(load_scenario("lyapunov-sine"), make_controller("esm"), (2,))
    found = rival_data("esm", TryoutTrial(scenario="lyapunov-sine", seed=2))
    for name in ("x", "y"):
        assert found[name] == [rounded_list(row) for row in direct[name][0]]
    cost = found["metrics"].pop("cost")
    assert found["metrics"] == reduced_metrics("tracking", measure_all(direct), 0, Cost())
    one = TryoutTrial(scenario="lyapunov-sine", seed=2, terms=(("rms_cross_track_m", 0.1, 3.0),))
    other = rival_data("esm", one)
    assert other["metrics"]["cost"] == pytest.approx(30 * found["metrics"]["rms_cross_track_m"]) != cost
    assert other["shares"] == {"rms_cross_track_m": 1.0}


def test_inputs_may_be_fewer_and_in_another_order() -> None:
    fis = Sugeno(
        [
            Variable("alpha", (-3.2, 3.2), {"any": Gaussian(2.0, 0.0)}),
            Variable("distance", (0, 20), {"any": Gaussian(9.0, 0.0)}),
        ],
        [
            Variable("v", (0, 1), {"go": Linear((0.0, 2.0), 0.0)}),
            Variable("w", (-9, 9), {"turn": Linear((4.0, 0.0), 0.0)}),
        ],
        ["if alpha is any and distance is any then v is go and w is turn"],
    )
    metrics = design_data(fis, TryoutTrial(scenario="lyapunov-circle"))["metrics"]
    assert 0 < metrics["rms_cross_track_m"] < 0.3  # proportional pursuit: it finds the circle


def test_edits_are_never_compiled_again(tracking: Sugeno) -> None:
    if not hasattr(evaluate_batch, "signatures"):
        pytest.skip("Numba compiles nothing here (NUMBA_DISABLE_JIT)")
    x = np.zeros((1, 1, 4))
    law: Any = make_controller("fuzzy")
    law.with_fuzzy_system("tracking", tracking).tracking(x)
    before = len(evaluate_batch.signatures)
    first = tracking.inputs[0]
    curved = replace(first, terms={**first.terms, "Close": Gaussian(0.05, 0.05)})
    sloped = replace(tracking.outputs[0], terms={**tracking.outputs[0].terms, "Slow": Linear((1, 0, 0, 0), 0.5)})
    for fis in (
        replace(tracking, inputs=(curved, *tracking.inputs[1:])),
        replace(tracking, rules=tracking.rules[:5]),
        replace(tracking, outputs=(sloped, tracking.outputs[1])),
        replace(tracking, and_method="min", defuzzification="wtsum", out_of_range="clip", no_rule_fires="nan"),
    ):
        law.with_fuzzy_system("tracking", fis).tracking(x)
    assert len(evaluate_batch.signatures) == before


# What is said ---------------------------------------------------------------------------------------------------


def test_a_system_without_rules_waits_for_one(tracking: Sugeno) -> None:
    with pytest.raises(TryoutError, match="cannot drive a robot yet: it has no rule in force"):
        run_design(replace(tracking, rules=()), TryoutTrial())


@pytest.mark.parametrize(
    ("choice", "says"),
    [
        ({"scenario": "fuzzy-of-path"}, "did you mean 'fuzzy-off-path'"),
        (
            {"scenario": "formation-ahead"},
            'is of kind "formation", and the laws that tracking fits drive .* tracking or',
        ),
        ({"scenario": None}, "scenario must be a name"),
        ({"law": "lyapunow"}, "unknown law"),
        ({"look_ahead": -1.0}, "look_ahead must be a finite number in s, >= 0 and <= 10"),
        ({"look_ahead": "1"}, "look_ahead must be"),
        ({"seed": 1.5}, "seed must be a whole number"),
        ({"seed": True}, "seed must be a whole number"),
        ({"scenario": "a.toml", "text": "robots = 1"}, "a.toml:1: at least one"),
        ({"scenario": "a.toml", "text": "x ="}, "a.toml:1: this is not TOML"),
    ],
)
def test_choices_that_there_are_not(choice: dict[str, Any], says: str, tracking: Sugeno) -> None:
    with pytest.raises(InputError, match=says):
        settled(tracking, TryoutTrial(**choice))


def test_what_happens_on_the_way_is_noted(tracking: Sugeno) -> None:
    narrow = replace(tracking.inputs[0], universe=(0.0, 0.1))
    leaving = replace(tracking, inputs=(narrow, *tracking.inputs[1:]), out_of_range="warn")
    notes = run_design(leaving, TryoutTrial()).notes
    assert len(notes) == 1
    assert "distance" in notes[0]
    # Where no rule fires the command is no number: the robot is stopped, and the curves end.
    few = replace(tracking, rules=tracking.rules[:1], no_rule_fires="nan")
    data = on_page(few, TryoutTrial())
    assert [(kind, text.partition(" at ")[0]) for kind, text in data["outcomes"]] == [
        ("stopped", "robot 1 was stopped")
    ]
    assert data["x"][0][-1] is None
    assert data["metrics"]["settling_time_s"] == "never"
    json.dumps(data, allow_nan=False)
    with pytest.raises(InputError, match="distance"):
        run_design(replace(leaving, out_of_range="error"), TryoutTrial())


def test_every_scenario_and_law_is_offered(tracking: Sugeno) -> None:
    known = choices()
    assert [s["name"] for s in known["scenarios"]] == scenario_names()
    assert {name for pairs in known["rivals"].values() for name, _ in pairs} == {*presets()}
    place = place_data(tracking, TryoutTrial(scenario=TEAM))
    offered = {law for law, *_ in place["course"]["laws"]}
    assert offered >= {"fuzzy", "cooperation", "obstacles", "crash-yielding", "fuzzy-team"}
    json.dumps([known, place], allow_nan=False)


def test_the_law_suits_the_scenario(tracking: Sugeno) -> None:
    turns = "turn-towards-each-other"  # whose own law is "obstacles"
    for wish, law in (
        (TryoutTrial(), "fuzzy"),
        (TryoutTrial(scenario=turns), "obstacles"),
        (TryoutTrial(scenario=turns, law="cooperation"), "cooperation"),
        (TryoutTrial(scenario=turns, law="fuzzy"), "obstacles"),  # which drives no team
        (TryoutTrial(scenario="lyapunov-sine", law="cooperation"), "fuzzy"),
        (TryoutTrial(law="fuzzy-team"), "fuzzy-team"),
    ):
        assert settled(tracking, wish).law == law
    assert settled(load_rule_base("crash"), TryoutTrial()).scenario == "three-cross"


@pytest.mark.parametrize("scenario", ["fuzzy-off-path", "crossing-in-turn", "three-cross", "trap-u"])
def test_laws_that_do_not_suit_the_scenario_are_marked_with_what_is_warned_of(tracking: Sugeno, scenario: str) -> None:
    setting = load_scenario(scenario).setting
    marks = place_data(tracking, TryoutTrial(scenario=scenario))["course"]["marks"]
    for name in ("cooperation", "crash-yielding", "virtual-structure", "obstacles", "right-of-way", "fuzzy-team"):
        warned = " ".join(forewarnings(setting, law_of(name), name))
        words = {"does not avoid obstacles": "senses no obstacles", "ignores the others": "takes no care of other"}
        assert marks.get(name, "") == ", ".join(mark for mark, said in words.items() if said in warned), name
    assert ("virtual-structure" in marks) == (scenario in ("three-cross", "trap-u"))


ALONE = """
duration = 6.0
[[robots]]
start = [0.0, 0.0, 0.0]
path = { shape = "line", start = [0.0, 0.0], end = [2.0, 0.0] }
timing = { duration = 8.0 }
[[obstacles]]
shape = "disc"
position = [1.0, 0.17]
radius = 0.1
"""


def test_a_scenario_of_ones_own_with_ones_own_robot() -> None:
    """A small robot passes 4 cm beside the obstacle that the usual one, 10 cm wide on each side, touches."""
    text, fis = ALONE, load_rule_base("tracking")
    data = design_data(fis, TryoutTrial(scenario="mine.toml", text=text))
    assert data["verdict"].startswith("robot 1 and obstacle 1 touch at ")
    assert data["metrics"]["contacts"] == 1
    assert data["moment"] == pytest.approx(data["contacts"][0][0])
    assert data["player"]["obstacles"]
    small = text.replace("[[robots]]", '[robot]\nmodel = "etsro"\nlength = 0.06\nwidth = 0.06\n[[robots]]', 1)
    data = design_data(fis, TryoutTrial(scenario="mine.toml", text=small))
    assert data["verdict"].startswith("no contact; least clearance ")
    assert data["metrics"]["min_clearance_m"] == pytest.approx(0.04, abs=0.01)
    course = course_data(TryoutTrial(scenario="mine.toml", text=small))
    assert course["played"]
    assert [m["name"] for m in course["metrics"]][:2] == ["contacts", "min_clearance_m"]


def test_formation_data_for_training(monkeypatch: pytest.MonkeyPatch) -> None:
    short = FormationRecipe(starts=(4.0,), samples=20)
    monkeypatch.setitem(FILES, "formation-literal.csv", short)
    generators = {g.name: g for g in formation_data()}
    made, direct = generators["formation-literal"].make(), formation_table(short)
    assert made.names == direct.names
    assert made.inputs == 3
    assert np.array_equal(made.values, direct.values)
    assert set(generators) == {"formation-literal", "formation-well-posed", "formation-scenario"}


# The session ----------------------------------------------------------------------------------------------------


class Bench:
    """What the designer's page offers to a panel, without a page."""

    say: Any  # what the panel listens with

    done: asyncio.Event  # of what is slow

    def __init__(self, fis: Sugeno, path: Path) -> None:
        folder = path.parent if path.parent.is_dir() else Path()
        design = SimpleNamespace(in_force=fis, lines=design_of(fis).lines, system=fis)
        self.document: Any = SimpleNamespace(design=design, path=path, folder=folder, judged=())
        self.traits: dict[str, Any] = {}
        self.calls: list[tuple[str, tuple[Any, ...]]] = []
        self.pictured: dict[str, Any] = {}
        self.gate = asyncio.Event()
        self.gate.set()

    def widget(self, module: Path, **traits: Any) -> Any:
        assert module.is_file()
        self.traits.update(traits)
        return SimpleNamespace(update=self.traits.update, on_message=lambda f: setattr(self, "say", f))

    def on_change(self, callback: Any) -> None:
        self.changed = callback

    def on_close(self, callback: Any) -> None:
        self.close = callback

    def edit(self, fis: Sugeno) -> None:
        self.document.design.in_force = fis
        self.changed()

    async def background(self, function: Any, *args: Any) -> Any:
        self.calls.append((function.__name__, args))
        await self.gate.wait()
        return function(*args)

    async def read(self, name: str, function: Any, *args: Any) -> Any:
        return function(*args)


async def opened(fis: Sugeno, path: Path = NEW) -> tuple[Bench, TryoutSession]:
    bench = Bench(fis, path)
    session = TryoutSession(bench)
    bench.say({"do": "see", "on": True})
    await settle(session)
    return bench, session


async def settle(session: TryoutSession) -> None:
    """Wait for all that is being read and run."""
    while session.reading and not all(task.done() for task in session.reading.values()):
        await asyncio.wait(session.reading.values())
    assert session.task is not None
    await session.task


def test_what_is_run_is_said_once_it_takes_a_while(tracking: Sugeno, slower: Sugeno, monkeypatch: Any) -> None:
    async def scene(wait: float) -> Any:
        monkeypatch.setattr(session_module, "_SAID", wait)
        bench, session = await opened(tracking)
        bench.gate.clear()
        bench.edit(slower)
        await asyncio.sleep(0.05)
        said = bench.traits["busy"]
        bench.gate.set()
        await settle(session)
        assert bench.traits["busy"] is None
        return said

    assert asyncio.run(scene(60.0)) is None
    said = asyncio.run(scene(0.0))
    assert said["what"] == "course"  # another name may have another place
    assert said["took"] > 0


def test_the_latest_design_wins_and_the_rival_is_run_once(tracking: Sugeno, slower: Sugeno) -> None:
    async def scene() -> None:
        bench, session = await opened(tracking)
        assert bench.traits["tried"] == on_page(tracking, TryoutTrial()) | {"number": 1}
        assert bench.traits["rival"] == rival_data("lyapunov", TryoutTrial(scenario="fuzzy-off-path"))
        assert [name for name, _ in bench.calls].count("design_data") == 1  # of two equal designs one is run
        assert bench.traits["before"] == beside(tracking, TryoutTrial()) | {"label": "as opened"}
        bench.calls.clear()
        bench.gate.clear()
        others = [replace(tracking, rules=tracking.rules[: 15 - k]) for k in range(12)]
        for fis in others:
            bench.edit(fis)
            await asyncio.sleep(0)
        bench.edit(slower)
        bench.gate.set()
        await settle(session)
        assert [args[0] for name, args in bench.calls if name == "design_data"] == [others[0], slower]
        assert [name for name, _ in bench.calls if name == "rival_data"] == []
        assert bench.traits["tried"] == on_page(slower, TryoutTrial()) | {"number": 3}
        assert bench.traits["busy"] is None
        bench.document.judged = (("rms_cross_track_m", 0.1, 1.0),)  # tuned by another cost than before
        session.changed()
        await settle(session)
        assert [m["name"] for m in bench.traits["course"]["metrics"]][:2] == ["cost", "rms_cross_track_m"]
        for name in ("tried", "before", "rival"):
            assert bench.traits[name]["shares"] == {"rms_cross_track_m": 1.0}
        bench.document.judged = ()
        session.changed()
        await settle(session)
        bench.calls.clear()
        bench.say({"do": "pin"})
        await settle(session)
        assert bench.traits["before"] == beside(slower, TryoutTrial()) | {"label": "pinned"}
        bench.say({"do": "choose", "name": "rival", "value": "esm"})
        await settle(session)
        bench.say({"do": "choose", "name": "rival", "value": "lyapunov"})
        await settle(session)
        assert [name for name, _ in bench.calls].count("rival_data") == 1
        assert bench.traits["rival"] == rival_data("lyapunov", TryoutTrial(scenario="fuzzy-off-path"))

    run_apart(scene())


def test_the_design_before_is_that_of_the_file(tracking: Sugeno, slower: Sugeno, tmp_path: Path) -> None:
    write_fis(slower, tmp_path / "slower.fis")
    bench, _ = run_apart(opened(tracking, tmp_path / "slower.fis"))
    assert bench.traits["before"] == beside(slower, TryoutTrial()) | {"label": "in the file"}
    assert bench.traits["tried"]["label"] == "tracking"


def test_nothing_is_run_for_a_panel_that_nobody_sees(tracking: Sugeno, slower: Sugeno) -> None:
    async def scene() -> None:
        bench = Bench(tracking, NEW)
        panel.build(bench)
        bench.edit(slower)
        await asyncio.sleep(0)
        assert bench.calls == []

    run_apart(scene())


def test_a_run_that_another_choice_overtook_is_not_shown(tracking: Sugeno) -> None:
    async def scene() -> None:
        bench, session = await opened(tracking)
        bench.gate.clear()
        bench.edit(replace(tracking, name="late"))
        await asyncio.sleep(0)
        bench.say({"do": "choose", "name": "scenario", "value": "lyapunov-circle"})
        bench.gate.set()
        await settle(session)
        assert bench.traits["course"]["scenario"] == "lyapunov-circle"
        assert bench.traits["tried"]["time"][-1] == 25.0
        assert bench.traits["before"]["time"][-1] == 25.0

    run_apart(scene())


def test_wrong_wishes_and_designs_get_sentences(tracking: Sugeno) -> None:
    async def scene() -> None:
        bench, session = await opened(tracking)
        wrong: tuple[Any, ...] = (
            None,
            [],
            {"do": "run"},
            {"do": ["see"]},
            {"do": "choose"},
            {"do": "choose", "name": "scenario", "value": "../up.toml"},
            {"do": "choose", "name": "law", "value": "lyapunov"},
            {"do": "choose", "name": "rival", "value": "fuzz"},
            {"do": "choose", "name": "look_ahead", "value": None},
            {"do": "choose", "name": "seed", "value": -1},
            {"do": "file", "name": "a.fis", "text": ""},
            {"do": "file", "name": "a.toml", "text": None},
            {"do": "file", "name": "a.toml", "text": "x" * 2_000_001},
        )
        for message in wrong:
            bench.traits["problem"] = None
            bench.say(message)
            assert bench.traits["problem"]["message"], message
        assert session.wish == TryoutTrial(folder=str(Path().resolve()))
        # What only reading shows is said once it is read; nothing is shown of another scenario meanwhile.
        bench.say({"do": "choose", "name": "scenario", "value": "nowhere.toml"})
        await settle(session)
        assert "there is no file 'nowhere.toml'" in bench.traits["problem"]["message"]
        for message, says in (
            ({"do": "choose", "name": "scenario", "value": "fuzzy-of-path"}, "did you mean 'fuzzy-off-path'"),
            ({"do": "choose", "name": "scenario", "value": "formation-ahead"}, 'of kind "formation"'),
            ({"do": "file", "name": "mine.toml", "text": "[[robots]]"}, "mine.toml:1: "),
        ):
            bench.say(message)
            await settle(session)
            assert says in bench.traits["problem"]["message"]
            assert bench.traits["tried"] is bench.traits["course"] is None
        bench.say({"do": "choose", "name": "scenario", "value": "fuzzy-off-path"})
        await settle(session)
        bench.edit(replace(tracking, outputs=(replace(tracking.outputs[0], name="sped"),), rules=()))
        await settle(session)
        assert "no law takes the output 'sped' (did you mean 'speed'" in bench.traits["problem"]["message"]
        assert bench.traits["tried"] is None
        bench.edit(tracking)
        await settle(session)
        assert bench.traits["problem"] is None
        assert bench.traits.get("tried")["label"] == "tracking"

    run_apart(scene())


def test_a_scenario_file_of_the_folder_is_read_again_when_it_changes(tracking: Sugeno, tmp_path: Path) -> None:
    write_fis(tracking, tmp_path / "mine.fis")
    (tmp_path / "pyproject.toml").write_text("[project]\n", encoding="utf-8")
    mine = tmp_path / "mine.toml"
    mine.write_text(ALONE, encoding="utf-8")

    async def scene() -> None:
        bench, session = await opened(tracking, tmp_path / "mine.fis")
        assert bench.traits["files"]["scenarios"] == ["mine.toml"]
        bench.say({"do": "choose", "name": "scenario", "value": "mine.toml"})
        await settle(session)
        assert bench.traits["trial"]["scenario"] == "mine.toml"
        assert bench.traits["course"]["duration"] == 6.0
        assert "touch" in bench.traits["tried"]["verdict"]
        mine.write_text(ALONE.replace("6.0", "4.0"), encoding="utf-8")
        session._look()
        await settle(session)
        assert bench.traits["course"]["duration"] == 4.0
        calls = len(bench.calls)
        session._look()
        mine.write_text(ALONE.replace("radius", "radios"), encoding="utf-8")
        session._look()
        await settle(session)
        assert len(bench.calls) == calls + 1  # it is run once a change, and not at all while it is faulty
        assert "mine.toml:10: " in bench.traits["problem"]["message"]
        assert "radius" in bench.traits["problem"]["message"]
        mine.unlink()
        session._look()
        await settle(session)
        assert "there is no file 'mine.toml'" in bench.traits["problem"]["message"]
        bench.close()

    run_apart(scene())


def test_a_file_that_is_read_slowly_keeps_nobody_waiting(tracking: Sugeno, tmp_path: Path) -> None:
    """Neither another tab nor this one: what is chosen later wins."""
    write_fis(tracking, tmp_path / "mine.fis")
    (tmp_path / "slow.toml").write_text(ALONE, encoding="utf-8")

    class Slow(Bench):
        async def read(self, name: str, function: Any, *args: Any) -> Any:
            if name == "slow.toml" and function is read_text_file:
                await self.done.wait()
            return await super().read(name, function, *args)

    async def scene() -> None:
        bench, other = Slow(tracking, tmp_path / "mine.fis"), Bench(tracking, tmp_path / "mine.fis")
        bench.done = asyncio.Event()
        session, another = TryoutSession(bench), TryoutSession(other)
        for each in (bench, other):
            each.say({"do": "see", "on": True})
        await settle(session)
        bench.say({"do": "choose", "name": "scenario", "value": "slow.toml"})
        bench.say({"do": "edit", "what": "scenario"})  # that file, once it is there
        await asyncio.sleep(0)
        assert bench.traits["busy"] == {"what": "file", "took": None}
        await settle(another)
        assert other.traits["tried"]["label"] == "tracking"
        bench.say({"do": "choose", "name": "look_ahead", "value": 0.5})
        assert session.task is not None
        await session.task
        assert bench.traits["trial"]["look_ahead"] == 0.5
        assert bench.traits["trial"]["scenario"] == "fuzzy-off-path"
        assert bench.pictured["trial"] == session.trial  # for a set of pictures
        bench.done.set()
        await settle(session)
        assert bench.traits["trial"]["scenario"] == bench.traits["editor"]["name"] == "slow.toml"
        bench.done.clear()
        bench.say({"do": "choose", "name": "scenario", "value": "slow.toml"})
        bench.say({"do": "choose", "name": "scenario", "value": "lyapunov-circle"})
        bench.done.set()
        await settle(session)
        assert bench.traits["trial"]["scenario"] == "lyapunov-circle"
        for each in (bench, other):
            each.close()

    run_apart(scene())


def test_laws_chosen_for_one_group_of_scenarios_are_not_kept_for_another(tracking: Sugeno) -> None:
    """A law that is blind to obstacles is not what one chose among them; within a group the choice stays."""

    async def scene() -> None:
        bench = Bench(tracking, NEW)
        session = TryoutSession(bench)

        async def background(function: Any, *args: Any) -> Any:
            return {} if function.__name__ in ("design_data", "rival_data") else function(*args)

        async def chosen(**choices: str) -> tuple[str, str]:
            for name, value in choices.items():
                bench.say({"do": "choose", "name": name, "value": value})
                await settle(session)
            return bench.traits["trial"]["law"], bench.traits["trial"]["rival"]

        bench.background = background  # type: ignore[method-assign]
        bench.say({"do": "see", "on": True})
        await settle(session)
        picked = ("crash-literal", "virtual-structure-virtual")
        assert await chosen(scenario="three-cross") == ("crash-yielding", "right-of-way")
        assert await chosen(law=f"{picked[0]}/tracking", rival=picked[1]) == picked
        assert await chosen(scenario="two-meetings") == picked
        assert await chosen(scenario="trap-u") == ("obstacles", "fuzzy-team")
        assert await chosen(law="cooperation/tracking", rival=picked[1]) == ("cooperation", picked[1])
        assert await chosen(scenario="wait-for-one") == ("cooperation", picked[1])
        assert await chosen(scenario="concentric-circles") == ("cooperation", "virtual-structure")

    run_apart(scene())


def test_a_crash_rule_base_finds_the_crossing_and_another_law(tracking: Sugeno) -> None:
    """The law "fuzzy" lets it steer alone; a law that drives no such scenario brings its own."""

    async def scene() -> None:
        bench = Bench(load_rule_base("crash"), NEW)
        session = TryoutSession(bench)
        ran: list[Any] = []

        async def background(function: Any, *args: Any) -> Any:
            ran.append((function.__name__, args))
            return {} if function.__name__ in ("design_data", "rival_data") else function(*args)

        bench.background = background  # type: ignore[method-assign]
        bench.say({"do": "see", "on": True})
        await settle(session)
        trial = bench.traits["trial"]
        assert (trial["law"], trial["task"], trial["scenario"]) == ("fuzzy-team", "crash", "three-cross")
        assert trial["rival"] == "right-of-way"
        bench.say({"do": "choose", "name": "law", "value": "fuzzy/own"})
        await settle(session)
        assert bench.traits["trial"]["law"] == "fuzzy"
        assert ran[-1][1][1].law == "fuzzy"
        bench.edit(tracking)  # an upload: another system altogether
        await settle(session)
        assert bench.traits["trial"]["scenario"] == "fuzzy-off-path"
        bench.say({"do": "choose", "name": "law", "value": "cooperation/tracking"})
        await settle(session)
        assert bench.traits["trial"]["scenario"] == "crossing-in-turn"
        bench.say({"do": "choose", "name": "scenario", "value": "lyapunov-sine"})
        await settle(session)
        assert bench.traits["trial"]["law"] == "fuzzy"

    run_apart(scene())


def test_a_scenario_is_edited_in_place(tracking: Sugeno, tmp_path: Path) -> None:
    """What is valid is tried, what is not leaves the last pictures; saving asks before it overwrites."""
    write_fis(tracking, tmp_path / "mine.fis")
    mine = tmp_path / "mine.toml"
    mine.write_text(ALONE, encoding="utf-8")

    async def scene() -> None:
        bench, session = await opened(tracking, tmp_path / "mine.fis")

        async def say(**message: Any) -> Any:
            bench.say(message)
            await settle(session)
            return bench.traits["editor"]

        await say(do="choose", name="scenario", value="mine.toml")
        editor = await say(do="edit", what="scenario")
        assert (editor["name"], editor["text"], editor["saved"]) == ("mine.toml", ALONE, True)
        editor = await say(do="text", what="scenario", text=ALONE.replace("6.0", "4.0"))
        assert bench.traits["course"]["duration"] == 4.0
        assert (editor["edited"], editor["saved"], editor["message"]) == (True, False, "")
        editor = await say(do="text", what="scenario", text=ALONE.replace("radius", "radios"))
        assert editor["line"] == 1 + ALONE.splitlines().index("radius = 0.1")
        assert "did you mean 'radius'" in editor["message"]
        assert bench.traits["course"]["duration"] == 4.0  # the last one that was valid
        assert bench.traits["tried"]["verdict"]
        assert mine.read_text(encoding="utf-8") == ALONE
        mine.write_text(ALONE + "# theirs", encoding="utf-8")
        session._look()
        short = ALONE.replace("6.0", "3.0")
        await say(do="text", what="scenario", text=short)
        editor = await say(do="save", what="scenario")
        assert "mine.toml was changed on disk by another program" in editor["asks"]
        assert mine.read_text(encoding="utf-8") == ALONE + "# theirs"
        editor = await say(do="save", what="scenario", overwrite=True)
        assert (editor["saved"], editor["asks"], mine.read_text(encoding="utf-8")) == (True, "", short)
        await say(do="choose", name="scenario", value="lyapunov-sine")
        assert bench.traits["editor"] is None
        editor = await say(do="edit", what="scenario")
        assert not editor["own"]
        for wrong in ("../up.toml", "mine.txt", ".hidden.toml"):
            await say(do="save", what="scenario", name=wrong)
            assert bench.traits["problem"]["message"], wrong
        editor = await say(do="save", what="scenario", name="sine.toml")
        assert (editor["name"], editor["own"], bench.traits["trial"]["scenario"]) == ("sine.toml", True, "sine.toml")
        assert bench.traits["files"]["scenarios"] == ["mine.toml", "sine.toml"]
        assert load_scenario(tmp_path / "sine.toml").duration == load_scenario("lyapunov-sine").duration
        bench.close()
        assert sorted(path.name for path in tmp_path.iterdir()) == ["mine.fis", "mine.toml", "sine.toml"]

    run_apart(scene())


def test_several_seeds_are_run_when_the_design_rests(
    tracking: Sugeno, slower: Sugeno, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The newest design wins; the worst seed is drawn until another is picked."""
    monkeypatch.setattr("robotics.plugins.designer.severalseeds._PAUSE", 0.0)
    write_fis(tracking, tmp_path / "mine.fis")
    noisy = ALONE[: ALONE.index("[[obstacles]]")].replace(
        "duration = 6.0", "duration = 2.0\nsensing = { start_position = 0.05 }", 1
    )
    (tmp_path / "mine.toml").write_text(noisy, encoding="utf-8")

    async def scene() -> None:
        bench, session = await opened(tracking, tmp_path / "mine.fis")

        async def rest() -> None:
            while (
                session.wanted or session.rounds.done is not None or not (session.task is None or session.task.done())
            ):
                await asyncio.sleep(0)

        bench.say({"do": "choose", "name": "scenario", "value": "mine.toml"})
        bench.say({"do": "choose", "name": "count", "value": 5})
        await rest()
        seeds = bench.traits["seeds"]
        errors = {row["seed"]: row["metrics"]["rms_cross_track_m"] for row in seeds["rows"]}
        assert len(errors) == 5
        assert seeds["worst"] == seeds["shown"] == max(errors, key=lambda seed: errors[seed])
        assert bench.traits["tried"]["seed"] == bench.traits["rival"]["seed"] == seeds["worst"]
        assert set(seeds["runs"]) == {"tried", "before", "rival"}
        other = next(seed for seed in errors if seed != seeds["worst"])
        bench.say({"do": "choose", "name": "shown", "value": other})
        await rest()
        assert bench.traits["tried"]["seed"] == bench.traits["before"]["seed"] == other
        assert bench.traits["tried"]["metrics"]["rms_cross_track_m"] == errors[other]
        bench.calls.clear()
        bench.edit(replace(tracking, rules=tracking.rules[:12]))
        assert bench.traits.get("seeds") is None  # of another design
        bench.edit(slower)
        await rest()
        ran = [args[0] for name, args in bench.calls if name == "design_seeds"]
        assert ran == [slower]
        run = [args[0] for name, args in bench.calls if name == "rival_seeds"]
        assert run == [session.before]  # the rival's are known
        assert bench.traits["seeds"]["rows"][other]["metrics"] == bench.traits["tried"]["metrics"]
        bench.say({"do": "weigh"})
        await rest()
        worth = bench.traits["seeds"]["worth"]
        assert {row["rule"] for row in worth} == set(range(1, len(slower.rules) + 1))
        assert all(row["text"] == str(slower.rules[row["rule"] - 1]) for row in worth)
        assert [row["worse"] for row in worth] == sorted((row["worse"] for row in worth), reverse=True)
        for wrong in (2, True, "5", None):
            bench.traits["problem"] = None
            bench.say({"do": "choose", "name": "count", "value": wrong})
            assert "the number of seeds is one of 1, 5, 20" in bench.traits["problem"]["message"]
        bench.close()

    run_apart(scene())


def test_a_file_of_the_folder_is_the_rival(tracking: Sugeno, slower: Sugeno, tmp_path: Path) -> None:
    write_fis(tracking, tmp_path / "mine.fis")
    write_fis(slower, tmp_path / "slower.fis")
    (tmp_path / "own.py").write_text("from robotics import Law\nclass Own(Law): pass\n", encoding="utf-8")

    async def scene() -> None:
        bench, session = await opened(tracking, tmp_path / "mine.fis")
        assert bench.traits["files"]["laws"] == ["slower.fis", "own.py:Own"]
        bench.say({"do": "choose", "name": "rival", "value": "slower.fis"})
        await settle(session)
        assert bench.traits["rival"]["metrics"] == design_data(slower, TryoutTrial())["metrics"]
        bench.say({"do": "choose", "name": "rival", "value": "own.py:Own"})
        await settle(session)
        assert "own.py: Own must be a frozen dataclass derived from robotics.Law" in bench.traits["rival"]["why"]
        assert bench.traits["tried"]["metrics"] == design_data(tracking, TryoutTrial())["metrics"]
        for wrong in ("own.py:Other", "../own.py:Own", "none.fis"):
            bench.traits["problem"] = None
            bench.say({"do": "choose", "name": "rival", "value": wrong})
            await settle(session)
            assert bench.traits["problem"]["message"], wrong
        assert bench.traits["trial"]["rival"] == "own.py:Own"
        (tmp_path / "own.py").write_text("", encoding="utf-8")
        session._look()
        await settle(session)
        assert "there is no law 'Own' in own.py" in bench.traits["rival"]["why"]
        bench.close()

    run_apart(scene())
