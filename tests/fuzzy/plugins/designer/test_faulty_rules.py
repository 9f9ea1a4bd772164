"""A file with rules that cannot be read: they stand in the design as they are, until they are mended or removed."""

import json

import pytest

import fuzzy
from fuzzy.errors import InputError
from fuzzy.plugins.designer.design import file_text
from fuzzy.plugins.designer.document import Document
from fuzzy.plugins.designer.saving import DocumentError
from fuzzy.plugins.designer.views import document_data, findings_data
from tests.fuzzy.plugins.designer.design_messages import near, unsaved

WRONG = "2 0, 3 (1) : 1"  # one output too few


@pytest.fixture
def faulty(file):
    """The file of the design with a line that is no rule as its second one."""
    text = file.read_text(encoding="utf-8").replace("NumRules=3", "NumRules=4")
    head, rules = text.split("[Rules]\n")
    first, *others = rules.splitlines()
    file.write_text(f"{head}[Rules]\n{first}\n{WRONG}\n" + "\n".join(others) + "\n", encoding="utf-8")
    return file


def edit(document, op, **content):
    document.apply({"edit": op, **content})


def key(document):
    return document.design.lines[1].key


def test_a_wrong_rule_is_marked_where_it_stands_and_nothing_of_it_counts(faulty):
    with pytest.raises(fuzzy.FisFileError, match="expected 2 output terms"):
        fuzzy.read_fis(faulty)  # for everybody else
    before, document = faulty.read_bytes(), Document(faulty)
    rule = document_data(document)["rules"][1]
    assert (rule["text"], rule["enabled"], rule["unread"]) == (WRONG, False, True)
    assert rule["problem"]["message"].startswith("expected 2 output terms, one for each output, got 1; a sentence")
    assert "line 49 is no rule" in document.notes[0]
    assert before.decode().splitlines()[48] == WRONG
    assert len(document.design.in_force.rules) == 3
    assert document.saved
    assert file_text(document.design) == before.decode()
    assert any("rule 2 is no rule" in finding["sentence"] for finding in findings_data(document.design))


def test_saving_is_refused_until_it_is_mended_and_no_crash_loses_it(faulty):
    before, document = faulty.read_bytes(), Document(faulty)
    document.autosave()
    assert not unsaved(faulty).exists()  # nothing was edited
    document.apply(near(0.5))
    with pytest.raises(DocumentError, match="rule 2 is not readable yet; mend or remove it"):
        document.save()
    assert faulty.read_bytes() == before
    document.autosave()
    again = Document(faulty)
    assert again.design.lines == document.design.lines
    edit(again, "rule_text", key=key(again), text="2 0, 3 1 (1) : 1")  # still wrong, elsewhere
    assert again.design.lines[1].problem.message.startswith("'v' has no term number 3")
    edit(again, "rule_text", key=key(again), text="if distance is far then v is fas")
    assert "fas" in again.design.lines[1].problem.message
    again.autosave()
    again = Document(faulty)
    assert again.design.lines[1].source == WRONG
    edit(again, "rule_text", key=key(again), text="if distance is far then v is fast")
    assert len(again.design.in_force.rules) == 4
    again.save()
    assert len(fuzzy.read_fis(faulty).rules) == 4
    again.undo()
    assert again.design.lines[1].source == WRONG
    assert not again.saved


def test_it_is_mended_as_a_line_of_the_file_or_removed(faulty):
    document = Document(faulty)
    edit(document, "rule_text", key=key(document), text="2 0, 2 0 (0.5) : 1")
    assert document.design.lines[1].text == "if distance is far then v is fast with 0.5"
    document.undo()
    edit(document, "remove_rule", key=key(document))
    document.save()
    assert len(fuzzy.read_fis(faulty).rules) == 3


@pytest.mark.parametrize(
    ("op", "content"),
    [
        ("rule_enabled", {"enabled": True}),
        ("rule_weight", {"weight": 0.5}),
        ("rule_then", {"variable": "v", "term": "fast"}),
        ("rule_clause", {"variable": "bearing", "term": "left"}),
        ("rule_connective", {"connective": "or"}),
    ],
)
def test_what_does_not_mend_it_is_refused(faulty, op, content):
    document = Document(faulty)
    with pytest.raises(InputError, match="is no rule yet: mend its sentence, or remove it"):
        edit(document, op, key=key(document), **content)
    assert document.can_undo is None


def test_it_outlives_other_variables_and_terms_and_a_training(faulty):
    document = Document(faulty)
    edit(document, "rename_variable", kind="input", variable="distance", name="gap")
    edit(document, "remove_term", kind="input", variable="gap", term="near")
    edit(document, "remove_variable", kind="output", variable="w")  # now the numbers fit: nobody said that they do
    (line,) = [line for line in document.design.lines if line.source is not None]
    assert (line.text, line.enabled) == (WRONG, False)
    document.replace(document.design.in_force, "train", keep_disabled=True)
    assert WRONG in [line.source for line in document.design.lines]
    assert WRONG in document.text()


def test_a_file_without_terms_for_a_stand_in_is_refused(tmp_path):
    path = tmp_path / "empty.fis"
    path.write_text(
        "[System]\nName='a'\nType='sugeno'\nNumInputs=1\nNumOutputs=1\nNumRules=1\nAndMethod='prod'\nOrMethod='max'\n"
        "DefuzzMethod='wtaver'\n[Input1]\nName='x'\nRange=[0 1]\nNumMFs=0\n"
        "[Output1]\nName='y'\nRange=[0 1]\nNumMFs=0\n[Rules]\n1, 1 (1) : 1\n"
    )
    with pytest.raises(fuzzy.FisFileError, match="no term number 1"):
        Document(path)


def test_unsaved_work_of_an_earlier_version_is_read(faulty):
    document = Document(faulty)
    document.apply(near(0.5))
    edit(document, "remove_rule", key=key(document))
    document.autosave()
    content = json.loads(unsaved(faulty).read_text())
    for rule in content["rules"]:
        del rule["source"]
    unsaved(faulty).write_text(json.dumps(content))
    assert Document(faulty).restored is not None
