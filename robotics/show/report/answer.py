"""The answer of a report in a few sentences, from its numbers: who leads where, in what, and which claims hold."""

from collections import Counter
from collections.abc import Mapping, Sequence

from fuzzy.words import counted, listed
from robotics.laws.catalogue import law_title
from robotics.measures.evidence import FORMS, Verdict
from robotics.measures.leading import Lead
from robotics.show.report.chapter import Claim
from robotics.show.report.glossary import side_of
from robotics.show.report.summarytable import SummaryTable, shown_metrics
from robotics.studies.comparison import Comparison

_LEADERS = {"fuzzy": "a fuzzy law", "nonlinear": "a nonlinear law", "planning": "a plan"}
_GROUPS = {"fuzzy": "fuzzy laws", "nonlinear": "nonlinear laws", "planning": "plans"}
_MOST = 3  # laws that are named, where sides are not known
_COUNTED: dict[Verdict, tuple[str, str]] = {
    "holds": ("holds", "hold"),
    "holds in part": ("holds in part", "hold in part"),
    "does not hold": ("does not hold", "do not hold"),
    "cannot be told": ("cannot be told", "cannot be told"),
}


def answer(
    comparisons: Sequence[Comparison],
    tables: Mapping[str, SummaryTable],
    leads: Sequence[Lead],
    claims: Sequence[Claim],
    first: Sequence[str] = (),
) -> list[str]:
    """The sentences with which a report begins.

    Args:
        comparisons: The comparisons.
        tables: The tables of their scenarios, by name.
        leads: Who leads where, as the picture at the head shows it.
        claims: The claims.
        first: The metrics that come first, as of :func:`robotics.show.report.page.write_report`.
    """
    return [*_judged(claims), *leading_sentences(leads), *_lowest(comparisons, tables, first)]


def leading_sentences(leads: Sequence[Lead]) -> list[str]:
    """Who leads in how many scenarios: by sides where all laws have one and there are two, otherwise by laws."""
    laws = list(dict.fromkeys(s.law for lead in leads for s in lead.standings))
    if len(laws) < 2:
        return []
    sides = {law: side_of(law) for law in laws}
    where = ""
    if all(sides.values()) and len(set(sides.values())) > 1:
        # Where all laws are of one kind, its lead says nothing
        leads = [lead for lead in leads if len({sides[s.law] for s in lead.standings}) > 1]
        where = "Where laws of different kinds compete, "
        found = Counter(_side(lead, sides) for lead in leads)
        said = [f"{words} in {found[side]}" for side, words in _LEADERS.items() if found[side]]
        said += [f"laws of two kinds that the seeds cannot tell apart in {found['both']}"] * bool(found["both"])
        said += [f"nobody in {found['nobody']}"] * bool(found["nobody"])
    else:
        leaders = Counter(s.law for lead in leads for s in lead.standings if s.leads)
        said = [f"{law_title(law)} in {n}" for law, n in leaders.most_common(_MOST)] or ["nobody in 0"]
    if not leads:
        return []
    who, count = said[0].rsplit(" in ", 1)
    text = listed([f"{who} leads in {count} of {counted(len(leads), 'scenario')}", *said[1:]])
    return [f"{where}{text}." if where else f"{text[0].upper()}{text[1:]}."]


def _side(lead: Lead, sides: Mapping[str, str]) -> str:
    found = {sides[s.law] for s in lead.standings if s.leads}
    return found.pop() if len(found) == 1 else "both" if found else "nobody"


def _lowest(comparisons: Sequence[Comparison], tables: Mapping[str, SummaryTable], first: Sequence[str]) -> list[str]:
    """In what each side has the lowest mean, of the metrics that the report shows."""
    wins: dict[str, Counter[str]] = {}
    for comparison in comparisons:
        laws = [side_of(law) for law in comparison.controllers]
        if not all(laws) or len(set(laws)) < 2:
            return []
        for scenario in comparison.scenarios:
            wanted = shown_metrics(comparison, scenario, first, scenario.setting.has_others).values()
            names = {about.title: about.short or about.title for about in wanted if not about.larger}
            for row in tables[scenario.name].rows:
                won = {side for side, cell in zip(laws, row.cells, strict=True) if cell.mark == "lowest"}
                if row.title in names and len(won) == 1:
                    wins.setdefault(names[row.title], Counter())[won.pop()] += 1
    better: dict[str, list[str]] = {}
    for metric, sides in wins.items():
        (side, most), *others = [*sides.most_common(), ("", 0)]
        if most > others[0][1]:
            better.setdefault(side, []).append(f"{metric} ({most} of {sides.total()})")
    said = [f"{_GROUPS[side]} have the lowest {listed(metrics)}" for side, metrics in sorted(better.items())]
    return [f"Number by number, scenario by scenario, {'; '.join(said)}."] if said else []


def _judged(claims: Sequence[Claim]) -> list[str]:
    """How many claims hold: of a publication as it prints them, then corrected, and at their best."""
    said = []
    for form in ("", *FORMS):
        verdicts = Counter(claim.forms[form] for claim in claims if form in claim.forms)
        told = [f"{n} {_COUNTED[verdict][n != 1]}" for verdict in _COUNTED if (n := verdicts[verdict])]
        if told:
            count, how = counted(verdicts.total(), "claim"), f" {form}" if form else " that were tested"
            said.append(f"Of {count}{how}, {listed(told)}.")
    return said
