"""The rule language: sentences in English become rules. :class:`fuzzy.rule.Rule` writes them back.

    if distance is far and bearing is not very left then v is fast and w is 'zero turn' with 0.5

Keywords may be in upper or lower case. Names are spelled as in the system, and stand in quotes unless they are
plain words. MATLAB's verbose form, "If (service is poor) or (food is rancid) then (tip is cheap) (1)", is read too,
and so is its symbolic form, "service==poor | food~=fresh => tip=cheap (1)".
"""

import math
import re
import unicodedata
from collections.abc import Mapping, Sequence
from typing import Literal

from fuzzy.errors import InputError, quoted
from fuzzy.naming import expected
from fuzzy.rule import HEDGES, KEYWORDS, PLAIN_NAME, Clause, Rule

_SHOWN = 100  # characters of a long sentence that a message shows on either side of the place at fault
_QUOTED = re.compile(r"""'(?:[^']|'')*'|"(?:[^"]|"")*\"""")
_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?", re.IGNORECASE | re.ASCII)
_SPACE = re.compile(r"\s*")
_RULE_NUMBER = re.compile(r"\s*\d+\s*[.:)]\s*")
# "(0.5)" at the end is a weight; what only looks like a number is taken for one, to be refused as a number.
_WEIGHT_IN_PARENTHESES = re.compile(r"\(\s*((?:[+-]|\d|\.\d|nan\b|inf\b)[^()]*?)\s*\)\s*\Z", re.IGNORECASE)
_Names = Mapping[str, Sequence[str]] | Sequence[str]
_IS = {"is": False, "==": False, "=": False, "~=": True, "!=": True}  # does it negate?
_AND_OR: dict[str, Literal["and", "or"]] = {"and": "and", "&&": "and", "&": "and", "or": "or", "||": "or", "|": "or"}
_AFTER_VARIABLE = re.compile(r"\s*(?:==|=(?!>)|[~!]=|is(?![\w-]))", re.IGNORECASE)
_AFTER_TERM = re.compile(r"\s*(?:\Z|[()^,&|]|=>|(?:and|or|then|with)(?![\w-]))", re.IGNORECASE)
_UNKNOWN = re.compile(
    r".+?(?=\s*(?:\Z|[()^,&|]|[=~!]=|=)|\s+(?:is|and|or|then|with)(?![\w-]))", re.IGNORECASE | re.DOTALL
)


class RuleError(InputError):
    """The error for a sentence that is no rule of the system. The message says why and marks the place.

    ``sentence`` is the whole text, ``sentence[start:end]`` is the word at fault (empty where a word is missing), and
    ``reason`` says what is wrong with it.
    """

    def __init__(self, reason: str, sentence: str, start: int, end: int) -> None:
        super().__init__(reason, sentence, start, end)  # all of them, so that the error can be pickled
        self.reason, self.sentence, self.start, self.end = reason, sentence, start, end

    def __str__(self) -> str:
        # Of a long sentence what stands about the place.
        long = len(self.sentence) > 3 * _SHOWN
        first = max(0, self.start - _SHOWN) if long else 0
        last = first + 2 * _SHOWN if long else len(self.sentence)
        shown = self.sentence[first:last]
        before, after = "... " if first else "", " ..." if last < len(self.sentence) else ""
        indent = len(before) + _columns(self.sentence[first : self.start])
        marks = _columns(self.sentence[self.start : min(self.end, last)])
        line = before + re.sub(r"\s", " ", shown) + after
        return f"{self.reason}\n  {line}\n  {' ' * indent}{'^' * max(marks, 1)}"


def _columns(text: str) -> int:
    """Count the columns of a terminal that ``text`` fills."""
    return sum(0 if unicodedata.combining(c) else 1 + (unicodedata.east_asian_width(c) in "WF") for c in text)


def parse_rule(text: str, inputs: Mapping[str, Sequence[str]], outputs: Mapping[str, Sequence[str]]) -> Rule:
    """Read one sentence as a rule.

    The language is:

    - "if <clauses> then <consequents> [with <weight>]", or the weight in parentheses at the end; the clauses are joined
      all by "and" or all by "or", the consequents by "and" or by commas. An input may be left out.
    - A clause is "<input> is [not] [hedges] <term>", with the hedges somewhat, very and extremely, whose powers
      multiply, or "<term>^<power>". A consequent is "<output> is <term>".
    - Parentheses may stand round clauses and consequents. "=" and "==" mean "is", "~=" means "is not".
    - A name in quotes may hold any character; a quote inside is doubled. A name without quotes is recognised by its
      spelling. Where several names fit, a plain word is preferred to a longer name, and a hedge to a term that begins
      with the same word. Upper and lower case count only between names that differ in nothing else.

    Args:
        text: The sentence.
        inputs: The names of the terms by the name of each input.
        outputs: The names of the terms by the name of each output.

    Returns:
        The rule; ``parse_rule(str(rule), ...)`` equals it.

    Raises:
        RuleError: A sentence outside this language.
    """
    return _Sentence(text).rule(inputs, outputs)


class _Sentence:
    """A reader that walks through a sentence from left to right."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.place = 0  # of the next character that is no blank
        self._go(0)

    def _go(self, place: int) -> None:
        blanks = _SPACE.match(self.text, place)
        assert blanks is not None
        self.place = blanks.end()

    def _error(self, reason: str, start: int, end: int) -> RuleError:
        return RuleError(reason, self.text, start, end)

    def _since(self, start: int, reason: str) -> RuleError:
        """The error of what stands between ``start`` and here."""
        return self._error(reason, start, len(self.text[: self.place].rstrip()))

    def _word_at(self, place: int) -> str:
        """The plain word at ``place``, or ""."""
        word = PLAIN_NAME.match(self.text, place)
        return word[0] if word else ""

    def _take(self, *tokens: str) -> str | None:
        """Step over the first of ``tokens`` (words in lower case, symbols) that comes next, if any does."""
        word = self._word_at(self.place)
        for token in tokens:
            if token.isalpha() and word.casefold() == token:
                self._go(self.place + len(word))
                return token
            if not token.isalpha() and self.text.startswith(token, self.place):
                self._go(self.place + len(token))
                return token
        return None

    def _expect(self, what: str, *tokens: str) -> str:
        token = self._take(*tokens)
        if token is None:
            raise self._unexpected(f"expected {what}")
        return token

    def _unexpected(self, reason: str) -> RuleError:
        start = self.place
        if start == len(self.text):
            start = len(self.text.rstrip())
            return self._error(f"{reason}, but the sentence ends", start, start)
        found = self._word_at(start) or self.text[start]
        return self._error(f"{reason}, found {quoted(found)}", start, start + len(found))

    def rule(self, inputs: Mapping[str, Sequence[str]], outputs: Mapping[str, Sequence[str]]) -> Rule:
        if self.place == len(self.text):
            raise self._error("the sentence is empty; expected 'if <input> is <term> then <output> is <term>'", 0, 0)
        number = _RULE_NUMBER.match(self.text)
        if number:
            self._go(number.end())
        # Only MATLAB's symbolic form goes without "if".
        if self._take("if") is None and "=>" not in self.text:
            raise self._unexpected("expected 'if'")
        when, connective = self._antecedent(inputs)
        then = self._consequents(outputs)
        weight = self._weight()
        if self.place < len(self.text):
            raise self._unexpected("expected 'and', 'with <weight>' or the end of the sentence")
        return Rule(when, then, connective, weight)

    def _antecedent(self, inputs: Mapping[str, Sequence[str]]) -> tuple[tuple[Clause, ...], Literal["and", "or"]]:
        clauses: dict[str, Clause] = {}
        connective: Literal["and", "or"] | None = None
        depth = 0  # of parentheses; with one connective for all clauses, they change nothing
        while True:
            depth += self._open(inputs)
            variable = self._variable("input", inputs, clauses, "a rule asks for each input once")
            clauses[variable] = self._clause(variable, inputs[variable])
            while depth and self._take(")"):
                depth -= 1
            start = self.place
            if depth == 0 and self._take("then", "=>"):
                return tuple(clauses.values()), connective or "and"
            wanted = "'and', 'or' or ')'" if depth else "'and', 'or' or 'then'"
            joined = _AND_OR[self._expect(wanted, *_AND_OR)]
            if connective not in (None, joined):
                raise self._since(
                    start, "a rule joins its clauses all by 'and' or all by 'or', not by both; write two rules"
                )
            connective = joined

    def _open(self, names: _Names) -> int:
        """Step over opening parentheses, but not into a name that begins with one; return how many there were."""
        depth = 0
        while not self._spelled(names, _AFTER_VARIABLE) and self._take("("):
            depth += 1
        return depth

    def _variable(self, what: str, known: Mapping[str, Sequence[str]], taken: Mapping[str, object], why: str) -> str:
        """Step over a variable that is not ``taken``; ``why`` it may stand there once."""
        start = self.place
        name = self._name(what, known, _AFTER_VARIABLE)
        if name in taken:
            raise self._since(start, f"{what} {name!r} appears twice; {why}")
        return name

    def _is(self) -> bool:
        """Step over "is" or its symbols; return whether it negates."""
        if self.text.startswith("=>", self.place):
            raise self._unexpected("expected 'is'")
        return _IS[self._expect("'is'", *_IS)]

    def _clause(self, variable: str, terms: Sequence[str]) -> Clause:
        negated = self._is()
        # After each "not" or hedge a name may begin, and the words so far may themselves begin a name.
        readings = [(self.place, negated, 1.0)]
        if not negated and self._take("not"):
            readings.append((self.place, True, 1.0))
        while hedge := self._take(*HEDGES):
            _, negated, power = readings[-1]
            readings.append((self.place, negated, power * HEDGES[hedge]))
        self.place, negated, power = next(
            (reading for reading in reversed(readings) if self._spelled(terms, _AFTER_TERM, reading[0])),
            readings[-1],
        )
        term = self._name("term", terms, _AFTER_TERM, variable)
        start = self.place
        if self._take("^"):
            number = _NUMBER.match(self.text, self.place)
            if number is None:
                raise self._unexpected("expected a power after '^', a number > 0")
            power *= float(number[0])
            self._go(number.end())
        if not (power > 0 and math.isfinite(power)):
            raise self._since(start, "the power of the hedges must be a finite number > 0")
        return Clause(variable, term, negated, power)

    def _consequents(self, outputs: Mapping[str, Sequence[str]]) -> tuple[tuple[str, str], ...]:
        consequents: dict[str, str] = {}
        depth = 0
        while True:
            depth += self._open(outputs)
            output = self._variable("output", outputs, consequents, "a rule sets each output once")
            symbol = self.place
            negated = self._is()
            start = self.place
            terms = outputs[output]
            if negated or (not self._spelled(terms, _AFTER_TERM) and self._take("not", *HEDGES)):
                start = symbol if negated else start
                raise self._since(start, "a consequent is '<output> is <term>', without 'not' or hedges")
            consequents[output] = self._name("term", terms, _AFTER_TERM, output)
            while depth and self._take(")"):
                depth -= 1
            if _WEIGHT_IN_PARENTHESES.match(self.text, self.place):
                more = False
            else:  # MATLAB writes "(v is fast)(w is zero)", with nothing between
                more = self._take("and", "&&", "&", ",") is not None or self.text.startswith("(", self.place)
            if not more:
                if depth:
                    raise self._unexpected("expected ')'")
                return tuple(consequents.items())

    def _weight(self) -> float:
        in_parentheses = _WEIGHT_IN_PARENTHESES.match(self.text, self.place)
        if in_parentheses:
            start, end = in_parentheses.span(1)
        elif self._take("with"):
            self._take("weight")
            start, end = self.place, len(self.text.rstrip())
            if start == len(self.text):
                raise self._unexpected("expected a weight in [0, 1]")
        else:
            return 1.0
        number = _NUMBER.fullmatch(self.text, start, end)
        if number is None or not 0 <= float(number[0]) <= 1:
            raise self._error(f"a rule's weight is a number in [0, 1], got {quoted(self.text[start:end])}", start, end)
        self._go(len(self.text))
        return float(number[0])

    def _name(self, what: str, known: _Names, after: re.Pattern[str], owner: str = "") -> str:
        """Step over a name of ``known``; ``after`` matches what can follow it. ``owner``: a term's variable."""
        found = self._spelled(known, after) or self._spelled(known, None)
        if found:
            name, end = found
            self._go(end)
            return name
        start = self.place
        word = self._word_at(start)
        if start == len(self.text) or word.casefold() in KEYWORDS:
            wanted = f"a term of {owner!r}" if owner else f"an {what}"
            raise self._unexpected(f"expected {wanted} ({', '.join(known) or 'it has none'})")
        literal = _QUOTED.match(self.text, start)
        unknown = literal or _UNKNOWN.match(self.text, start)
        assert unknown is not None
        name = _unquoted(literal[0]) if literal else unknown[0]
        same = [k for k in known if k.casefold() == name.casefold()]
        if len(same) > 1:
            raise self._error(
                f"{quoted(name)} may be {' or '.join(map(repr, same))}: letter case matters here", *unknown.span()
            )
        raise self._error((f"{owner}: " if owner else "") + expected(name, known, what), *unknown.span())

    def _spelled(
        self, known: _Names, after: re.Pattern[str] | None, place: int | None = None
    ) -> tuple[str, int] | None:
        """The name of ``known`` at ``place`` (or here), followed by ``after``, and the place where it ends."""
        text, place = self.text, self.place if place is None else place
        candidates: list[tuple[str, int]] = []  # (spelling, end) in order of preference
        literal = _QUOTED.match(text, place)
        if literal:
            candidates.append((_unquoted(literal[0]), literal.end()))
        word = self._word_at(place)
        if word and word.casefold() not in KEYWORDS:
            candidates.append((word, place + len(word)))
        for length in sorted({len(name) for name in known if name}, reverse=True):
            end = place + length
            inside = re.match(r"[\w-]{2}", text[end - 1 : end + 1])  # it would end in the middle of a word
            if end <= len(text) and not inside:
                candidates.append((text[place:end], end))
        candidates = [c for c in candidates if after is None or after.match(text, c[1])]
        for spelling, end in candidates:
            if spelling in known:
                return spelling, end
        for spelling, end in candidates:
            same = [name for name in known if name.casefold() == spelling.casefold()]
            if len(same) == 1:
                return same[0], end
        return None


def _unquoted(literal: str) -> str:
    quote = literal[0]
    return literal[1:-1].replace(quote * 2, quote)
