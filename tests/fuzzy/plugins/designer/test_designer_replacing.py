"""A system that takes the place of the one under design, a file that is not ours to overwrite, what is compared."""

from dataclasses import replace
from pathlib import Path

import pytest

import fuzzy
from fuzzy.files.fisfile import write_quietly
from fuzzy.plugins.designer.design import design_of
from fuzzy.plugins.designer.document import Document
from fuzzy.plugins.designer.saving import DocumentError, OverwriteError
from fuzzy.plugins.designer.views import compared_data, design_data
from tests.fuzzy.plugins.designer.design_messages import system


@pytest.fixture
def document(tmp_path: Path) -> Document:
    """The small system, its second rule switched off."""
    write_quietly(system(), tmp_path / "small.fis")
    opened = Document(tmp_path / "small.fis")
    opened.apply({"edit": "rule_enabled", "key": opened.design.lines[1].key, "enabled": False})
    return opened


def texts(document: Document) -> list[tuple[str, bool]]:
    return [(line.text, line.enabled) for line in document.design.lines]


def test_what_was_learnt_from_the_rules_in_force_keeps_the_others(document: Document) -> None:
    before = texts(document)
    learnt = document.design.in_force
    learnt = replace(learnt, rules=tuple(replace(rule, weight=0.25) for rule in learnt.rules))
    document.replace(learnt, "train", keep_disabled=True)
    assert [line.rule.weight for line in document.design.lines if line.enabled] == [0.25] * len(learnt.rules)
    assert texts(document)[1] == before[1]
    assert not document.design.lines[1].enabled
    assert document.design.in_force == learnt
    assert len({line.key for line in document.design.lines}) == len(before)
    document.undo()
    assert texts(document) == before


def test_rules_that_do_not_fit_any_more_go(document: Document) -> None:
    other = fuzzy.Sugeno(
        [fuzzy.Variable("x", (0, 1), {"low": fuzzy.Triangle(-1, 0, 1)})],
        [fuzzy.Variable("y", (0, 1), {"one": 1.0})],
        ["if x is low then y is one"],
    )
    document.replace(other, "train", keep_disabled=True)
    assert texts(document) == [("if x is low then y is one", True)]


def test_other_rules_than_before_stand_first(document: Document) -> None:
    off = texts(document)[1]
    fewer = replace(document.design.in_force, rules=document.design.in_force.rules[:1])
    document.replace(fewer, "train", keep_disabled=True)
    assert texts(document) == [(str(fewer.rules[0]), True), off]
    document.replace(fewer, "upload")
    assert texts(document) == [(str(fewer.rules[0]), True)]


def test_overwriting_is_an_error_of_its_own(document: Document) -> None:
    document.path.write_text(document.path.read_text() + "\n% changed\n")
    with pytest.raises(OverwriteError, match="was changed on disk"):
        document.save()
    write_quietly(system(), document.folder / "other.fis")
    with pytest.raises(OverwriteError, match="exists already"):
        document.save("other.fis")
    with pytest.raises(DocumentError, match="outside the opened folder") as outside:
        document.save("../other.fis")
    assert not isinstance(outside.value, OverwriteError)
    document.save(overwrite=True)
    assert document.saved


def test_outputs_are_compared_too() -> None:
    fis = system()
    other = compared_data(fis, "before")
    shown = design_data(design_of(fis))
    assert (other["inputs"], other["outputs"]) == (shown["inputs"], shown["outputs"])
