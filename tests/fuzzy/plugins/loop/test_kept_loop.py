"""The loop that goes with a system: saved, undone, restored after a crash, and the same to ``fuzzy step``."""

import asyncio
import json
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzy import read_fis, write_fis
from fuzzy.commands.application import main
from fuzzy.files.fisfile import format_fis, parse_fis
from fuzzy.plugins.designer.document import Document
from fuzzy.plugins.designer.starts.control import rule_table
from fuzzy.plugins.loop.controller import PID, LoopError
from fuzzy.plugins.loop.keptloop import (
    example_settings,
    kept_settings,
    kept_text,
    loop_of,
    pid_of,
    step_arguments,
    transfer_of,
)
from fuzzy.plugins.loop.panel import StepSession
from fuzzy.plugins.loop.plant import TransferFunction
from fuzzy.plugins.loop.response import step_response
from fuzzy.plugins.loop.steptask import simulated

CHANGES = {"numerator": "2", "denominator": "3 1", "dead_time": 0.8, "Kde": 3.0, "Kdu": 0.3067, "high": None}


def edit(**changes):
    chosen = {**kept_settings("{}"), **changes}
    return {"edit": "loop", "text": kept_text(chosen), "what": "dead time"}


def test_a_loop_is_saved_undone_and_taken_up_after_a_crash(tmp_path):
    file = tmp_path / "pi.fis"
    write_fis(rule_table("pi", 5), file)
    document = Document(file)
    document.apply(edit(**CHANGES))
    assert document.can_undo == "loop: dead time"
    assert not document.saved
    document.autosave()
    after = Document(file)  # as another run finds it, which did not save
    found = kept_settings(after.design.system.loop)
    assert {name: found[name] for name in CHANGES} == CHANGES
    assert after.restored is not None
    after.save()
    assert kept_settings(read_fis(file).loop) == found
    after.undo()
    assert after.design.system.loop == ""
    after.redo()
    after.replace(rule_table("pd", 3), "learn")  # what is learnt or uploaded without a loop stays in this one
    assert kept_settings(after.design.system.loop) == found


def test_the_file_says_only_what_differs_and_rules_are_as_before(tmp_path):
    fis = replace(rule_table("pi", 5), loop=edit(**CHANGES)["text"])
    (line,) = [line for line in format_fis(fis).splitlines() if "Loop" in line]
    assert json.loads(line.partition("=")[2].strip("'")) == {"example": "lag", **CHANGES}
    assert parse_fis(format_fis(fis)) == fis
    assert format_fis(replace(fis, loop="")) == format_fis(rule_table("pi", 5))


@given(st.dictionaries(st.text(max_size=8), st.sampled_from(["error", "u", "du", ""]), max_size=3))
@settings(max_examples=50)
def test_names_of_any_kind_are_kept_in_one_line(roles):
    text = kept_text({**kept_settings("{}"), "roles": roles})
    fis = replace(rule_table("pd", 3), loop=text)
    assert text.isprintable()
    assert kept_settings(parse_fis(format_fis(fis)).loop)["roles"] == roles


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("no", "it is no JSON"),
        ("[1]", "it is no table of settings"),
        ('{"kde": 1}', "unknown setting 'kde'; did you mean 'Kde'"),
        ('{"Kde": "1"}', "Kde must be a number"),
        ('{"Kde": NaN}', "Kde must be a number"),
        ('{"numerator": 3}', "numerator must be numbers"),
        ('{"roles": {"e": "errors"}}', "roles are error"),
        ('{"example": "lagg"}', "did you mean 'lag'"),
        ("[" * 100_000, "it is no JSON"),
    ],
)
def test_what_is_no_loop_is_told_in_a_sentence(text, sentence):
    with pytest.raises(LoopError, match="the loop that is kept with the system cannot be read: .*" + sentence):
        kept_settings(text)


def test_it_makes_what_the_panel_simulates():
    chosen = kept_settings(edit(**CHANGES, Kp=2.0)["text"])
    plant = transfer_of(chosen)
    assert isinstance(plant, TransferFunction)
    assert plant.denominator == (3.0, 1.0)
    assert loop_of(chosen).scale.Kdu == 0.3067
    assert loop_of(chosen).high == float("inf")
    assert pid_of(chosen) == PID(2.0, 0.0, 0.0)
    assert pid_of(kept_settings("{}")) is None
    assert kept_settings('{"example": "motor"}')["duration"] == example_settings("motor")["duration"]


def test_the_command_takes_it_and_options_go_before(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    write_fis(rule_table("pi", 5), "plain.fis")
    assert main(["step", "plain.fis"]) == 2
    assert "--plant is missing, such as --plant '1; 1 1 0', and plain.fis keeps no loop" in capsys.readouterr().err
    write_fis(replace(rule_table("pi", 5), loop=edit(**CHANGES)["text"]), "pi.fis")
    scales = [f"{name}={example_settings('lag')[name]:g}" for name in ("Ke", "Kie", "Ku")] + ["Kde=3", "Kdu=0.3067"]
    usual = example_settings("lag")
    said = ["step", "plain.fis", "--plant", "2; 3 1; 0.8", "--duration", str(usual["duration"]), "--json"]
    said += ["--disturbance", f"{usual['disturbance_time']},{usual['disturbance']}", "--limits", f"{usual['low']}"]
    for scale in scales:
        said += ["--scale", scale]
    found = []
    for arguments in (["step", "pi.fis", "--json"], said, ["step", "pi.fis", "--json", "--scale", "Kdu=1"]):
        assert main(arguments) == 0
        found.append(json.loads(capsys.readouterr().out)["responses"]["fuzzy-pi-5x5"]["figures"])
    assert found[0] == found[1]
    assert found[2]["overshoot"] > found[0]["overshoot"]
    write_fis(replace(rule_table("pi", 5), loop=edit(source="plant.py")["text"]), "strange.fis")
    assert main(["step", "strange.fis"]) == 2
    assert "--plant plant.py runs it" in capsys.readouterr().err


class _Bench:
    """What a panel's session knows of a page; it notes what the widget is given."""

    def __init__(self, document):
        self.document, self.closed, self.sent = document, False, []
        self.on_message = self.on_change = self.on_close = lambda callback: None

    def widget(self, module, **traits):
        return self

    def update(self, **traits):
        self.sent.append(traits)

    def forget(self, name):
        self.sent.append({"forgotten": name})

    async def background(self, function, *given):
        await asyncio.sleep(60)


def test_an_undo_right_behind_an_edit_finds_it_done_and_the_field_is_told(tmp_path):
    """Both are asked for before the server comes to answer, as by a quick hand on a busy machine."""
    write_fis(rule_table("pi", 3), tmp_path / "pi.fis")

    async def edited_and_undone():
        bench = _Bench(Document(tmp_path / "pi.fis"))
        session = StepSession(bench)
        await session.opening
        for name, value in (("numerator", "3"), ("denominator", "3 1 0"), ("Kp", 2.0)):
            session.heard({"do": "choose", "name": name, "value": value})
        kept = kept_settings(bench.document.design.system.loop)
        assert (kept["numerator"], kept["denominator"], kept["Kp"]) == ("3", "3 1 0", 2.0)  # no edit loses another
        session.changed()
        session.heard({"do": "choose", "name": "dead_time", "value": 0.7})
        bench.document.undo()
        assert kept_settings(bench.document.design.system.loop)["numerator"] == "3"
        bench.sent.clear()
        session.heard({"do": "choose", "name": "dead_time", "value": 0.8})
        bench.document.undo()
        session.changed()  # once for both: the loop is what was sent before, the field is not
        assert bench.sent[0] == {"forgotten": "choice"}
        assert bench.sent[-1]["choice"]["dead_time"] == session.choice["dead_time"] == 0.2
        session.close()

    asyncio.run(edited_and_undone())


class _AtOnce(_Bench):
    """What is asked of another process is done here."""

    async def background(self, function, *given):
        return function(*given)

    async def read(self, name, function, *given):
        return function(*given)


def test_beside_the_design_stands_the_one_before_by_its_own_scale_factors(tmp_path):
    """That of the file, or what a new one began with; not where nothing but the plant is another."""
    old = replace(rule_table("pi", 3), loop=edit(Kde=0.7)["text"])
    write_fis(old, tmp_path / "pi.fis")

    async def beside(document):
        bench = _AtOnce(document)
        session = StepSession(bench)
        await session.opening
        rows = []
        for name, value in (("dead_time", 0.8), ("Kde", 0.3)):
            session.heard({"do": "choose", "name": name, "value": value})
            task = session._task()
            rows.append(task.before)
        answer = simulated(task)
        session.close()
        return rows, answer["rows"]

    for document in (Document(tmp_path / "pi.fis"), Document("new.fis", tmp_path, old)):
        (same, before), answer = asyncio.run(beside(document))
        assert same is None
        assert (before[0].name, before[2].Kde) == (old.name, 0.7)
        plant = TransferFunction([1], [1, 1], 0.8)
        arguments = step_arguments({**kept_settings(old.loop), "dead_time": 0.8})
        figures = step_response(old, plant, **arguments).figures
        assert [row["name"] for row in answer] == ["design", "file", "pid"]
        assert answer[1]["figures"]["ise"] == pytest.approx(figures.ise)
        assert answer[0]["figures"]["ise"] != pytest.approx(figures.ise)
