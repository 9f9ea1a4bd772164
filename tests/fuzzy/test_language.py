"""The rule language: sentences read by hand, sentences refused, and every rule read back."""

import pickle
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzy.language import RuleError, parse_rule
from fuzzy.rule import KEYWORDS, Clause, Rule
from tests.randomcases import cases

INPUTS = {
    "distance": ["near", "far", "very far"],
    "bearing": ["left", "zero turn"],
    "f_0(f27s1)": ["y=2x1+2x2;", "Y", "y"],
    "İrtifa": ["Sıfıra-Yakın", "it's"],
}
OUTPUTS = {"v": ["fast", "slow"], "w": ["zero turn", "left"]}
FAR = Clause("distance", "far")
LEFT = Clause("bearing", "left")
FAST = (("v", "fast"),)


def read(sentence):
    return parse_rule(sentence, INPUTS, OUTPUTS)


@pytest.mark.parametrize(
    ("sentence", "rule"),
    [
        ("if distance is far then v is fast", Rule((FAR,), FAST)),
        ("IF Distance IS Far THEN V IS Fast", Rule((FAR,), FAST)),
        ("if distance is far and bearing is left then v is fast with 0.25", Rule((FAR, LEFT), FAST, "and", 0.25)),
        ("if distance is far or bearing is left then v is fast with weight 1e-1", Rule((FAR, LEFT), FAST, "or", 0.1)),
        ("if distance is not far then v is fast", Rule((Clause("distance", "far", True),), FAST)),
        (
            "if bearing is not very somewhat extremely left then v is fast",
            Rule((Clause("bearing", "left", True, 3.0),), FAST),
        ),
        ("if distance is far^1.3 then v is fast", Rule((Clause("distance", "far", power=1.3),), FAST)),
        ("if distance is very near ^ 1.5 then v is fast", Rule((Clause("distance", "near", power=3.0),), FAST)),
        # A hedge comes before a term that begins with its word; where there is no such term, the term is meant.
        ("if distance is very far then v is fast", Rule((Clause("distance", "far", power=2.0),), FAST)),
        ("if distance is 'very far' then v is fast", Rule((Clause("distance", "very far"),), FAST)),
        ("if distance is not 'very far' then v is fast", Rule((Clause("distance", "very far", True),), FAST)),
        (
            "if (distance is far and bearing is left) then (v is fast) (w is zero turn)",
            Rule((FAR, LEFT), (("v", "fast"), ("w", "zero turn"))),
        ),
        (
            "if ((distance is far)) and (bearing is left) then v is fast, w is left",
            Rule((FAR, LEFT), (("v", "fast"), ("w", "left"))),
        ),
        ("3. If (distance is far) or (bearing is left) then (v is fast) (0.5)", Rule((FAR, LEFT), FAST, "or", 0.5)),
        (
            "distance==far & bearing~=left => v=fast, w=left (0.5)",
            Rule((FAR, Clause("bearing", "left", True)), (("v", "fast"), ("w", "left")), "and", 0.5),
        ),
        (
            "if distance = far | bearing != left then v is fast (1)",
            Rule((FAR, Clause("bearing", "left", True)), FAST, "or"),
        ),
        # Names as real files have them, without quotes.
        ("if f_0(f27s1) is y=2x1+2x2; then v is fast", Rule((Clause("f_0(f27s1)", "y=2x1+2x2;"),), FAST)),
        ("if (f_0(f27s1) is not Y) then (v is fast)", Rule((Clause("f_0(f27s1)", "Y", True),), FAST)),
        ("if İrtifa is Sıfıra-Yakın then v is fast", Rule((Clause("İrtifa", "Sıfıra-Yakın"),), FAST)),
        ("if İrtifa is 'it''s' then v is fast", Rule((Clause("İrtifa", "it's"),), FAST)),
        ("if İrtifa is it's then v is fast", Rule((Clause("İrtifa", "it's"),), FAST)),
        ('if bearing is "zero turn" then v is fast', Rule((Clause("bearing", "zero turn"),), FAST)),
        ("if bearing is zero turn then w is Zero Turn", Rule((Clause("bearing", "zero turn"),), (("w", "zero turn"),))),
        ("  if distance\tis far\n  then v is fast  ", Rule((FAR,), FAST)),
    ],
)
def test_a_sentence_becomes_the_rule_it_says(sentence, rule):
    assert read(sentence) == rule


def test_a_hedge_word_is_part_of_the_name_where_only_that_is_a_term():
    terms = {"x": ["very far", "not known"]}
    assert parse_rule("if x is very far then v is fast", terms, OUTPUTS).when == (Clause("x", "very far"),)
    assert parse_rule("if x is not very far then v is fast", terms, OUTPUTS).when == (Clause("x", "very far", True),)
    assert parse_rule("if x is not known then v is fast", terms, OUTPUTS).when == (Clause("x", "not known"),)


def test_a_plain_word_comes_before_a_longer_name_but_not_in_its_way():
    inputs = {"x": ["far", "far and y is near", "far away"], "y": ["near"]}
    both = Rule((Clause("x", "far"), Clause("y", "near")), FAST)
    assert parse_rule("if x is far and y is near then v is fast", inputs, OUTPUTS) == both
    longer = Rule((Clause("x", "far and y is near"),), FAST)
    assert parse_rule(str(longer), inputs, OUTPUTS) == longer
    assert parse_rule("if x is far away then v is fast", inputs, OUTPUTS).when == (Clause("x", "far away"),)


@pytest.mark.parametrize(
    ("sentence", "word", "reason"),
    [
        ("", "", "the sentence is empty"),
        (" \n", "", "the sentence is empty"),
        ("distance is far then v is fast", "distance", "expected 'if'"),
        ("if distance is fra then v is fast", "fra", "distance: unknown term 'fra'; did you mean 'far'?"),
        ("if distanse is far then v is fast", "distanse", "unknown input 'distanse'; did you mean 'distance'?"),
        ("if 'the distance' is far then v is fast", "'the distance'", "unknown input 'the distance'"),
        ("if bearing is zero trun then v is fast", "zero trun", "did you mean 'zero turn'?"),
        ("if distance is far then u is fast", "u", "unknown output 'u'. Known: v, w"),
        ("if distance is far then v is 'fats'", "'fats'", "v: unknown term 'fats'; did you mean 'fast'?"),
        ("if f_0(f27s1) is 'X' then v is fast", "'X'", "f_0(f27s1): unknown term 'X'"),
        ("if distance is then v is fast", "then", "expected a term of 'distance' (near, far, very far)"),
        ("if distance is far then v is", "", "expected a term of 'v' (fast, slow), but the sentence ends"),
        ("if distance far then v is fast", "far", "expected 'is'"),
        ("if distance => far then v is fast", "=", "expected 'is'"),
        ("if distance is far v is fast", "v", "expected 'and', 'or' or 'then'"),
        ("if distance is far", "", "expected 'and', 'or' or 'then', but the sentence ends"),
        ("if distance is far and then v is fast", "then", "expected an input"),
        ("if distance is far) then v is fast", ")", "expected 'and', 'or' or 'then'"),
        ("if (distance is far then v is fast", "then", "expected 'and', 'or' or ')'"),
        ("if distance is far then (v is fast", "", "expected ')'"),
        ("if distance is far and distance is near then v is fast", "distance", "appears twice"),
        ("if distance is far then v is fast and v is slow", "v", "output 'v' appears twice"),
        (
            "if distance is far or bearing is left and İrtifa is it's then v is fast",
            "and",
            "all by 'and' or all by 'or'",
        ),
        ("if distance is far then v is not fast", "not", "without 'not' or hedges"),
        ("if distance is far then v ~= fast", "~=", "without 'not' or hedges"),
        ("if distance is far then v is very fast", "very", "without 'not' or hedges"),
        ("if distance is far then v is fast with 1.5", "1.5", "a number in [0, 1]"),
        ("if distance is far then v is fast with -0.5", "-0.5", "a number in [0, 1]"),
        ("if distance is far then v is fast (2)", "2", "a number in [0, 1]"),
        ("if distance is far then v is fast (nan)", "nan", "a number in [0, 1]"),
        ("if distance is far then v is fast with nan", "nan", "a number in [0, 1]"),
        ("if distance is far then v is fast with", "", "expected a weight in [0, 1]"),
        ("if distance is far then v is fast indeed", "indeed", "expected 'and', 'with <weight>' or the end"),
        ("if distance is far^x then v is fast", "x", "expected a power after '^'"),
        ("if distance is far^0 then v is fast", "^0", "a finite number > 0"),
        ("if distance is far^-2 then v is fast", "^-2", "a finite number > 0"),
        ("if distance is far^1e999 then v is fast", "^1e999", "a finite number > 0"),
    ],
)
def test_a_refused_sentence_is_marked_where_it_goes_wrong(sentence, word, reason):
    with pytest.raises(RuleError) as caught:
        read(sentence)
    error = caught.value
    assert reason in error.reason
    assert error.sentence == sentence
    assert sentence[error.start : error.end] == word
    first, quoted, marks = str(error).split("\n")
    assert first == error.reason
    assert quoted == "  " + sentence.replace("\n", " ")
    assert marks.count("^") == max(len(word), 1)
    assert marks.index("^") == 2 + error.start


def test_the_second_of_two_is_the_one_marked():
    sentence = "if distance is far and distance is near then v is fast"
    with pytest.raises(RuleError) as caught:
        read(sentence)
    assert caught.value.start == sentence.rindex("distance")


def test_marks_stand_under_wide_and_combining_letters():
    inputs = {"距離": ["é"]}  # two columns a letter, and an accent that fills none
    with pytest.raises(RuleError) as caught:
        parse_rule("if 距離 is é and x is é then v is fast", inputs, OUTPUTS)
    assert str(caught.value).split("\n")[2] == "  " + " " * len("if dddd is e and ") + "^"


def test_letter_case_matters_only_where_it_must():
    inputs = {"x": ["far", "FAR"]}
    assert parse_rule("if X is FAR then v is fast", inputs, OUTPUTS).when == (Clause("x", "FAR"),)
    with pytest.raises(RuleError, match=r"'Far' may be 'far' or 'FAR'"):
        parse_rule("if x is Far then v is fast", inputs, OUTPUTS)


def test_an_error_survives_pickling():
    with pytest.raises(RuleError) as caught:
        read("if distance is fra then v is fast")
    copy = pickle.loads(pickle.dumps(caught.value))
    assert str(copy) == str(caught.value)
    assert (copy.start, copy.end) == (caught.value.start, caught.value.end)


NAMES = st.one_of(
    st.text(max_size=8),
    st.sampled_from(
        [*sorted(KEYWORDS), "very far", "not x", "a is b", "x^2", "it's", "'", '"', "(x)", "x,y", "İ", "iſ"]
    ),
    st.sampled_from(["far", "Far", "far and y is near", "far then", "a", "a b", "a-b", "=>", "=", "0.5", "(0.5)"]),
)
TERMS = st.lists(NAMES, min_size=1, max_size=3, unique=True)
VARIABLES = st.dictionaries(NAMES, TERMS, min_size=1, max_size=3)
HEDGES = st.one_of(
    st.sampled_from([1.0, 0.5, 2.0, 3.0, 4.0, 6.0, 0.25, 1.5, 1.3]), st.floats(0, 1e300, exclude_min=True)
)
WEIGHTS = st.floats(0, 1)


@st.composite
def systems_with_a_rule(draw):
    inputs, outputs = draw(VARIABLES), draw(VARIABLES)
    asked = draw(st.lists(st.sampled_from(list(inputs)), min_size=1, unique=True))
    told = draw(st.lists(st.sampled_from(list(outputs)), min_size=1, unique=True))
    when = tuple(Clause(v, draw(st.sampled_from(inputs[v])), draw(st.booleans()), draw(HEDGES)) for v in asked)
    then = tuple((v, draw(st.sampled_from(outputs[v]))) for v in told)
    connective: Any = draw(st.sampled_from(["and", "or"]))
    return inputs, outputs, Rule(when, then, connective, draw(WEIGHTS))


@settings(max_examples=cases(300))
@given(systems_with_a_rule())
def test_every_rule_reads_back(system):
    inputs, outputs, rule = system
    assert parse_rule(str(rule), inputs, outputs) == rule


def test_a_single_clause_is_joined_by_nothing():
    one = Rule((Clause("a", "b"),), (("c", "d"),), "or", 0.5)
    assert one == Rule((Clause("a", "b"),), (("c", "d"),), "and", 0.5)
    assert replace(Rule((Clause("a", "b"), Clause("e", "f")), (("c", "d"),), "or"), when=one.when) == replace(
        one, weight=1.0
    )


def test_of_a_long_sentence_the_place_of_the_mistake_is_shown():
    with pytest.raises(RuleError) as caught:
        parse_rule("if " + "(" * 50_000 + "x is y", {"a": ["b"]}, {"c": ["d"]})
    reason, line, marks = str(caught.value).splitlines()
    assert len(reason) < 200
    assert len(line) < 250
    assert line[marks.index("^") :].startswith("x")
    with pytest.raises(RuleError) as caught:
        parse_rule("if a is " + "z" * 50_000, {"a": ["b"]}, {"c": ["d"]})
    assert max(map(len, str(caught.value).splitlines())) < 400


WORDS = st.sampled_from(
    [
        *sorted(KEYWORDS),
        *"(),^=&'|\"",
        "==",
        "~=",
        "=>",
        "0.5",
        "nan",
        "distance",
        "far",
        "bearing",
        "left",
        "v",
        "fast",
    ]
)


@settings(max_examples=cases(300))
@given(st.one_of(st.lists(WORDS, max_size=14).map(" ".join), st.text(max_size=30)))
def test_any_text_is_a_rule_or_a_rule_error_that_marks_a_place_in_it(text):
    try:
        rule = read(text)
    except RuleError as error:
        place = error.start, error.end, len(text)
        assert place == tuple(sorted(place))
    else:
        assert read(str(rule)) == rule
