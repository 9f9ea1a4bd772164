"""The words of a report: every law is explained, terms are found and linked once, and own studies stay their own."""

import re

import pytest

from robotics.laws.catalogue import CATALOGUE, law_title
from robotics.show.report.glossary import SIDES, Linker, law_terms, side_of, terms, terms_in, words_of


def test_every_law_of_the_catalogue_is_explained_and_stands_on_a_side() -> None:
    assert set(law_terms()) == set(CATALOGUE)
    assert {law.side for law in law_terms().values()} == set(SIDES)
    assert all(law.says.endswith(".") and law.says[0].isupper() for law in law_terms().values())
    assert [side_of(law) for law in ("fuzzy:look_ahead=0.1", "mine.fis", "esm:k=0.3", "mine.py:Mine")] == [
        "fuzzy",
        "fuzzy",
        "nonlinear",
        "",
    ]


def test_short_names_of_laws_and_of_the_reports_words_are_terms() -> None:
    asked = ["CSM", "ASSM", "QSSM", "ESM", "SM", "α", "λ", "η", "Θ", "S", "K", "K/Q(S)"]
    asked += ["stood", "hand-over", "ideal", "corrected", "literal"]
    asked += ["left behind", "as printed", "Virtual structure", "Crash avoidance", "Right of way", "drives blind"]
    known = {word for term in terms() for word in (term.name, *term.others)}
    assert set(asked) <= known
    titles = {law_title(law) for law in CATALOGUE}
    short = {word for title in titles for word in re.findall(r"\b[A-Z]{2,}\b", title)}
    assert short <= known  # capitals of a law's title, such as SM
    assert all(f"Virtual structure, {kind}" in known for kind in ("virtual", "measured", "waiting"))


def test_terms_have_anchors_of_their_own_and_sentences() -> None:
    anchors = [term.anchor for term in terms()]
    assert len(anchors) == len(set(anchors))
    assert all(re.fullmatch(r"term-[\w-]+", anchor) for anchor in anchors)
    assert all(term.says[0].isupper() and term.says.endswith(".") for term in terms())
    every = " ".join([*(term.says for term in terms()), *(law.says for law in law_terms().values())]).lower()
    for word in ("thesis", "mehrjerdi", "chapter", "(5.9)"):  # own studies read it too
        assert word not in every


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("The ESM follows S = 0 with K/Q(S).", ["ESM", "S", "K/Q(S)"]),
        ("S' and s_ij, CSMs, kK, Q(S)", ["K/Q(S)"]),
        ("It was left behind, as printed.", ["as printed", "left behind"]),
        ("nothing of all that", []),
    ],
)
def test_terms_are_whole_words(text: str, names: list[str]) -> None:
    assert sorted(term.name for term in terms_in(text)) == sorted(names)


def test_a_term_is_linked_where_it_is_used_first_and_text_stays_text() -> None:
    linked = Linker()
    first, second = linked("<b>ESM</b> & CSM"), linked("ESM again, then ASSM")
    assert first == (
        '&lt;b&gt;<a class="term" href="#term-esm">ESM</a>&lt;/b&gt; &amp; <a class="term" href="#term-csm">CSM</a>'
    )
    assert second == 'ESM again, then <a class="term" href="#term-assm">ASSM</a>'


def test_words_of_a_page_are_those_that_are_read() -> None:
    page = ['<p title="x">CSM</p><script>const ESM = 1;</script>', "<style>.S {}</style>λ"]
    assert words_of(page).split() == ["CSM", "λ"]
