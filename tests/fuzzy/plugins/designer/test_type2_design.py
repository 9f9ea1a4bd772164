"""A type-2 file in the designer: its footprint follows edits, undo, files and unsaved work, and the views tell it."""

import json
import warnings
from itertools import product

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import fuzzy
from fuzzy.plugins.designer.autosave import design_content, design_from
from fuzzy.plugins.designer.design import design_of, file_text
from fuzzy.plugins.designer.document import Document
from fuzzy.plugins.designer.edits import apply
from fuzzy.plugins.designer.figures import figure_bytes
from fuzzy.plugins.designer.notebook import NotebookSession
from fuzzy.plugins.designer.open_documents import _kept
from fuzzy.plugins.designer.saving import digest_of
from fuzzy.plugins.designer.views import design_data, several_data, surface_data, viewer_data
from tests.fuzzy.plugins.designer.design_messages import messages, system
from tests.fuzzy.plugins.designer.served import tipper
from tests.randomcases import cases

TWO = fuzzy.to_type2(tipper(), lag={"service": {"good": (0.1, 0.3), "poor": 0.2}}, scale=0.8)


@pytest.fixture
def document(tmp_path):
    fuzzy.write_fis(TWO, tmp_path / "two.fis")
    return Document(tmp_path / "two.fis")


def set_poor(document, *lower):
    document.apply({"edit": "footprint", "variable": "service", "term": "poor", "lower": list(lower)})


def test_it_stays_type_2_through_edits_undo_and_saving(document):
    before = document.path.read_bytes()
    assert document.saved
    set_poor(document, 0.5, 0.3, 0.3)
    document.apply({"edit": "rename_variable", "variable": "service", "name": "staff"})
    document.apply({"edit": "rename_term", "variable": "staff", "term": "good", "name": "fine"})
    document.apply({"edit": "remove_term", "variable": "staff", "term": "superb"})
    document.apply({"edit": "add_term", "variable": "staff", "name": "new"})
    document.apply({"edit": "term", "variable": "staff", "term": "fine", "parameters": [1, 5, 9]})
    document.apply({"edit": "choice", "name": "type_reduction", "value": "nietan"})
    document.save()
    read = fuzzy.read_type2(document.path)
    assert (read.reduction, read.inputs[0].terms["fine"]) == ("nietan", fuzzy.Triangle(1, 5, 9))
    lower = {"poor": fuzzy.Lower(0.5, 0.3), "fine": fuzzy.Lower(0.8, (0.1, 0.3)), "new": fuzzy.Lower(1, 0)}
    assert read.lower == {"staff": lower, "food": TWO.lower["food"]}
    while document.can_undo:
        document.undo()
    document.save()
    assert document.path.read_bytes() == before


def test_unsaved_work_and_snapshots_keep_the_footprint(document):
    set_poor(document, 0.5, 0.3, 0.25)
    assert design_from(json.loads(json.dumps(design_content(document.design)))).shown == document.design.shown
    document.autosave()
    again = Document(document.path)
    assert again.restored is not None
    assert again.text() == document.text()
    again.undo()
    assert again.saved
    document.path.write_text("[System]", encoding="utf-8")  # nor does a file that cannot be read any more lose it
    document._digest = digest_of(document.path)
    document.autosave()
    kept = _kept(document.path, fuzzy.FisFileError(str(document.path), 1, "damaged"))
    assert kept is not None
    assert Document(document.path, content=kept).text() == document.text()


def test_what_makes_no_type_2_system_is_refused_and_changes_nothing(document):
    before, poor = document.design, {"edit": "footprint", "variable": "service", "term": "poor"}
    for message, match in (
        (poor | {"lower": [1.5, 0, 0]}, r"scale .* \(0, 1\], got 1.5"),
        (poor | {"lower": [1, 1, 0]}, r"lag .* \[0, 1\)"),
        (poor | {"lower": [1, 0]}, "three numbers"),
        (poor | {"variable": "tip", "term": "low", "lower": [1, 0, 0]}, "an input's"),
        ({"edit": "choice", "name": "defuzzification", "value": "wtsum"}, "takes the weighted average"),
        ({"edit": "choice", "name": "type_reduction", "value": "none"}, "karnikmendel"),
    ):
        with pytest.raises(fuzzy.InputError, match=match):
            document.apply(message)
    assert document.design is before
    with pytest.raises(fuzzy.InputError, match="`fuzzy type2`"):
        apply(design_of(system()), {"edit": "footprint", "variable": "d", "term": "near", "lower": [1, 0, 0]})


@given(st.lists(messages(), max_size=12))
@settings(max_examples=cases(60), deadline=None, suppress_health_check=list(HealthCheck))
def test_no_edits_make_a_file_that_cannot_be_read(sequence):
    design = design_of(fuzzy.to_type2(system(), 0.2, 0.9))
    for message in sequence:
        try:
            design = apply(design, message)
        except fuzzy.InputError:
            continue
    with warnings.catch_warnings(action="ignore"):
        back = design_from(json.loads(json.dumps(design_content(design))))
    assert back.footprint is not None
    assert file_text(back) == file_text(design)
    json.dumps([design_data(design), viewer_data(design)], allow_nan=False)


def test_a_notebook_keeps_the_footprint():
    session = NotebookSession(TWO)
    session.hear({"edit": "footprint", "variable": "service", "term": "poor", "lower": [0.5, 0, 0]})
    again = NotebookSession(TWO, session)
    assert isinstance(again.design.shown, fuzzy.Type2Sugeno)
    assert again.design.shown.lower["service"]["poor"] == fuzzy.Lower(0.5, 0)
    assert again.traits()["design"]["inputs"][0]["terms"][0]["lower"] == [0.5, 0, 0]


def test_surfaces_are_those_of_the_type_2_system():
    design = design_of(TWO)
    shown = surface_data(design, points=9)
    grid = np.stack(np.meshgrid(shown["x"], shown["y"]), axis=-1)
    with warnings.catch_warnings(action="ignore"):
        found = fuzzy.compile_type2(TWO)(grid.reshape(-1, 2)).reshape(9, 9)
    fired = np.array(shown["fired"])
    assert not fired.all()
    assert np.array(shown["z"], float)[fired] == pytest.approx(found[fired], abs=1e-9)
    assert np.abs(np.array(surface_data(design_of(TWO.upper), points=9)["z"]) - found)[fired].max() > 0.1
    (small,) = several_data(design, "outputs", points=9)["pictures"]
    assert np.array(small["z"])[fired] == pytest.approx(found[fired], abs=0.05)


def test_the_viewer_tells_firing_intervals_and_shares_that_make_the_output():
    rng = np.random.default_rng(1)
    fis = fuzzy.to_type2(
        fuzzy.Sugeno(TWO.inputs, TWO.outputs, [*TWO.rules, "if food is not bad then tip is middle with 0.5"]), 0.1, 0.7
    )
    for _ in range(20):
        x = rng.uniform(0, 10, 2)
        told = viewer_data(design_of(fis), x.tolist())
        least, most = ([row[name] for row in told["rules"]] for name in ("least", "firing"))
        proposed = [row["proposed"][0] for row in told["rules"]]
        ends = [
            np.dot(chosen, proposed) / sum(chosen)
            for chosen in product(*zip(least, most, strict=True))
            if sum(chosen) > 1e-12
        ]
        assert told["interval"] == [pytest.approx([min(ends), max(ends)], abs=1e-9)]
        assert told["output"] == pytest.approx([(min(ends) + max(ends)) / 2], abs=1e-9)
        assert sum(row["contribution"][0] for row in told["rules"]) == pytest.approx(told["output"][0], abs=1e-9)
        assert sum(row["share"][0] for row in told["rules"]) == pytest.approx(1)
        low, high = fis.degrees("food", "bad", x[1])
        assert (least[3], most[3]) == pytest.approx(((1 - high) / 2, (1 - low) / 2))
        assert told["rules"][3]["degrees"] == pytest.approx([1 - low])
    words = viewer_data(design_of(TWO), [2.0, 2.0])["words"]
    assert "fires 0.23 to 0.43" in words  # 0.8 (0.6 − 0.2) / 0.8 · 0.8 · 5/7, and 0.6 · 5/7
    assert "the middle of the type-reduced set" in words


def test_pictures_show_the_footprint_and_others_are_refused():
    for kind in ("memberships", "surface"):
        two, one = (figure_bytes(fis, kind, "svg", (5, 5), (0, 1), 0) for fis in (TWO, TWO.upper))
        assert two != one
    with pytest.raises(fuzzy.InputError, match="not the rules"):
        figure_bytes(TWO, "rules", "svg", (5, 5), (0, 1), 0)
