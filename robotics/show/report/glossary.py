"""The words of a report, explained: terms and laws, as ``glossary.toml`` has them, and links to them from the text."""

import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cache
from html import unescape
from typing import NamedTuple

from markupsafe import Markup, escape

from fuzzy.shown import typeset
from robotics.laws.catalogue import CATALOGUE
from robotics.laws.presets import tuned_from
from robotics.laws.specification import Specification
from robotics.tables.texts import TextFile

_GLOSSARY = TextFile("robotics.show.report", "glossary.toml")
SIDES = {"fuzzy": "fuzzy", "nonlinear": "nonlinear", "planning": "a plan"}  # of a comparison, and their words


class GlossaryTerm(NamedTuple):
    """A word of the report."""

    name: str
    says: str  # what it means, in a sentence
    others: tuple[str, ...] = ()  # how else it is written

    @property
    def anchor(self) -> str:
        """Its name as an anchor."""
        return "term-" + "-".join(re.findall(r"\w+", self.name)).lower().replace("_", "-")

    @property
    def pattern(self) -> str:
        """Matches it as a whole word; a letter is no word where an apostrophe or an index follows."""
        words = sorted((self.name, *self.others), key=len, reverse=True)
        before = r"\w/(" if len(self.name) == 1 else r"\w/"  # the S of Q(S) is none
        return rf"(?<![{before}])(?:{'|'.join(map(re.escape, words))})(?![\w'(/_])"


class LawTerm(NamedTuple):
    """A law of the catalogue in a sentence."""

    side: str  # one of SIDES
    says: str


@cache
def terms() -> tuple[GlossaryTerm, ...]:
    """All terms, in the order of the file."""
    return tuple(GlossaryTerm(t["name"], t["says"], tuple(t.get("others", ()))) for t in _GLOSSARY.table("terms"))


@cache
def law_terms() -> dict[str, LawTerm]:
    """All laws by their names in the catalogue; one with tuned gains is told of by the law that it is."""
    told = {name: LawTerm(**row) for name, row in _GLOSSARY.table("laws").items() if name in CATALOGUE}
    tuned = {name: told[of] for name, of in tuned_from().items() if name in CATALOGUE}
    return told | {
        name: law._replace(says=f"{law.says} Its numbers were found by a search.") for name, law in tuned.items()
    }


def terms_in(words: str) -> list[GlossaryTerm]:
    """The terms that occur in a text."""
    return [term for term in terms() if re.search(term.pattern, words)]


def law_term(specification: str) -> LawTerm | None:
    """What the glossary says of a law; None for one that it does not know."""
    return law_terms().get(_name(specification))


def side_of(specification: str) -> str:
    """The one of SIDES on which a law stands; "" if the glossary does not know it."""
    found = law_term(specification)
    return found.side if found else ""


def _name(specification: str) -> str:
    about = Specification.of(specification)
    if about.file:
        return "fuzzy" if about.file.endswith(".fis") else ""
    return about.name


@dataclass
class Linker:
    """Links each term from its first use in the texts of one page, in the order in which they are given."""

    used: set[str] = field(default_factory=set)

    def __call__(self, text: str) -> Markup:
        """The text as markup, with true minus signs."""
        text, parts, end = typeset(text), [], 0
        for match in _any_term().finditer(text):
            term = terms()[int((match.lastgroup or "t0")[1:])]
            if term.name in self.used:
                continue
            self.used.add(term.name)
            link = Markup('<a class="term" href="#{}">{}</a>').format(term.anchor, match[0])
            parts += [escape(text[end : match.start()]), link]
            end = match.end()
        return Markup("").join([*parts, escape(text[end:])])


@cache
def _any_term() -> re.Pattern[str]:
    order = sorted(range(len(terms())), key=lambda k: -max(map(len, (terms()[k].name, *terms()[k].others))))
    return re.compile("|".join(f"(?P<t{k}>{terms()[k].pattern})" for k in order))


def words_of(html: Iterable[str]) -> str:
    """The words of markup: what stands between its tags, without scripts and styles."""
    text = re.sub(r"<(script|style)\b.*?</\1>", " ", " ".join(html), flags=re.S)
    return unescape(re.sub(r"<[^>]*>", " ", text))
