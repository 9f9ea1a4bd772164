"""The report of a comparison: figures, tables and verdicts in one HTML file that needs nothing else.

One page is in front, with the answer; behind it are chapters, of which one is open at a time, and all on paper.

The file is the same, byte for byte, whenever the same comparison is reported by the same versions.
"""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import fields
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

from matplotlib.figure import Figure

from fuzzy.figures.drawing import PAGE_WIDTH
from fuzzy.files.atomic import write_whole
from fuzzy.words import counted, listed
from robotics.laws.catalogue import law_title
from robotics.laws.specification import Specification
from robotics.measures.evidence import FEWEST_RUNS, FORMS
from robotics.measures.leading import Lead
from robotics.show.figures.comparison import plot_comparison
from robotics.show.figures.controllers import plot_errors, plot_paths, plot_velocities
from robotics.show.figures.drawing import looks, seeds_as_text
from robotics.show.figures.leads import plot_leads
from robotics.show.report.answer import answer
from robotics.show.report.chapter import Chapter, Claim, Front, Picture, Plate
from robotics.show.report.plates import plates_of
from robotics.show.report.summarytable import SummaryTable, comparison_leads, shown_metrics, summary_table
from robotics.show.report.template import program, rendered
from robotics.show.report.texts import ReportTexts
from robotics.show.report.wording import reading
from robotics.simulation.scenario.description import Member, Scenario
from robotics.studies.comparison import Comparison, terms

_TEXTS = ReportTexts("robotics.show.report")
_SHORT = 8  # claims that stand on the front page, at most; more are a chapter
_PER_ROBOT = 4  # robots of a scenario that get their own pictures of errors and speeds, at most


class ScenarioSection(NamedTuple):
    """The part of the report on one scenario."""

    scenario: Scenario
    place: str  # its name as an anchor and in file names
    facts: list[tuple[str, str]]
    table: SummaryTable
    divergences: list[str]
    pictures: list[Plate]


class Heading(NamedTuple):
    """What stands at the head of a report, and at its end."""

    title: str = "Controllers compared on the same terms"
    author: str = ""
    text: tuple[str, ...] = ()  # paragraphs
    program: str = ""  # Python that does the same; "": made of the comparison
    written: Mapping[str, str] = MappingProxyType({})  # controllers, as they were named, by what they are called
    folder: str = ""  # with its last slash: what is left out of the paths of files
    skipped: Mapping[str, Sequence[str]] = MappingProxyType({})  # by scenario, who does not drive there and why


def write_report(
    comparisons: Sequence[Comparison],
    claims: Sequence[Claim],
    folder: str | Path,
    *,
    chapters: Sequence[Chapter] = (),
    command: str | None = None,
    sections: Sequence[ScenarioSection] | None = None,
    heading: Heading | None = None,
    first: Sequence[str] = (),
    front: Front | None = None,
) -> Path:
    """Write ``folder``/report.html and ``folder``/figures/*.png, each whole or not at all; return the page's path.

    Args:
        comparisons: The comparison, or several with the same seeds, such as those of scenarios of several kinds.
        claims: Claims that are listed with their verdicts, as those of ``chapters`` are.
        folder: The folder of the report.
        chapters: Chapters that follow the comparison.
        command: The command line that made the comparison.
        sections: The sections of :func:`draw_sections`, if they are drawn already.
        heading: The title and what else stands at the head; with a text the claims come before the first picture.
        first: Metrics that come before the others; the first of them says who leads.
        front: What stands before all others.

    Raises OSError.
    """
    folder, heading = Path(folder), heading or Heading()
    (folder / "figures").mkdir(parents=True, exist_ok=True)
    sections = draw_sections(comparisons, first=first) if sections is None else sections
    claims = [*claims, *(claim for chapter in chapters for claim in chapter.claims)]
    leads = [lead for each in comparisons for lead in comparison_leads(each, first)]
    leads += [lead for chapter in chapters for lead in chapter.leads]
    head = _leads(leads)
    first_pictures = [head] if front is None else [front.picture, head]
    drawn = [picture for section in sections for picture in section.pictures]
    pictures = [*first_pictures, *drawn, *(picture for chapter in chapters for picture in chapter.pictures)]
    plates = plates_of(pictures)
    for picture in plates:
        write_whole(folder / "figures" / f"{picture.name}.png", picture.png)
    laws = list(dict.fromkeys(name for each in comparisons for name in each.controllers))
    apart = len(claims) > _SHORT
    entries = [
        ("front", "The answer"),
        *([("verdict", "Verdict in brief")] if apart else []),
        *([("head", "Who leads where")] if front is not None else []),
        ("terms", "What was compared, on what terms"),
        *((f"scenario-{s.place}", s.scenario.name) for s in sections),
    ]
    hints = {
        "verdict": f"{len(claims)} claims, each with its parts and numbers",
        "head": f"all {counted(len(leads), 'scenario')} at a glance",
        "terms": "the laws, their gains, how to read the tables",
        "reproduce": "command, seeds, versions",
    }
    hints |= {f"scenario-{s.place}": _leading(s.scenario.name, leads) for s in sections}
    hints |= {f"chapter-{chapter.name}": _content(chapter) for chapter in chapters}
    page = rendered(
        "report.html.j2",
        chapters,
        plates,
        entries,
        laws=list(dict.fromkeys([*laws, *(s.law for lead in leads for s in lead.standings)])),
        controllers=laws,
        answer=answer(comparisons, {s.scenario.name: s.table for s in sections}, leads, claims, first),
        heading=heading,
        front=front,
        count=len(comparisons[0].seeds),
        claims=claims,
        apart=apart,
        hints=hints,
        homes={claim.name: chapter for chapter in chapters for claim in chapter.claims},
        head=head,
        forms=FORMS if any(form for claim in claims for form in claim.forms) else (),
        fewest=FEWEST_RUNS,
        reading=reading,
        terms=list({row["controller"]: row for each in comparisons for row in _terms(each, heading)}.values()),
        seeds=seeds_as_text(comparisons[0].seeds),
        first_seed=comparisons[0].seeds[0],
        sections=sections,
        better=_better(row.title for section in sections for row in section.table.rows if row.larger),
        several=any(len(section.scenario.robots) > 1 for section in sections),
        touchable=any(section.scenario.setting.has_others for section in sections),
        command=command,
        program=heading.program or _program(comparisons[0]),
    )
    write_whole(folder / "report.html", page)
    return folder / "report.html"


def draw_sections(
    comparisons: Sequence[Comparison],
    advance: Callable[[], None] = lambda: None,
    first: Sequence[str] = (),
) -> list[ScenarioSection]:
    """Draw the sections on the scenarios of one or several comparisons.

    ``advance`` is called after every figure; the metrics ``first`` come before the others.
    """
    shown = [(each, scenario) for each in comparisons for scenario in each.scenarios]
    places = _places([scenario.name for _, scenario in shown])
    sections = []
    for each, scenario in shown:
        place = places[scenario.name]
        plates = plates_of(_pictures(each, scenario, place, first), advance)
        table = summary_table(each, scenario.name, first)
        stops = [line for name in each.controllers for line in each.notes[scenario.name, name].divergences]
        sections.append(ScenarioSection(scenario, place, _facts(scenario), table, stops, plates))
    return sections


def figure_count(comparisons: Sequence[Comparison]) -> int:
    """The number of figures that :func:`draw_sections` draws."""
    return sum(len(_pictures(each, scenario, "")) for each in comparisons for scenario in each.scenarios)


def _better(larger: Iterable[str]) -> str:
    """A sentence on which values are better; of the metrics ``larger``, by their titles, larger ones."""
    titles = list(dict.fromkeys(larger))
    return f"Smaller is better, except for {listed(titles)}." if titles else "Smaller is better."


def _leads(found: Sequence[Lead]) -> Picture:
    """The picture at the head of the report."""
    said = "; ".join(f"{lead.scenario}: {', '.join(_leaders(lead))}" for lead in found)
    better = _better(lead.title for lead in found if lead.larger)
    wide, narrow = partial(plot_leads, found), partial(plot_leads, found, PAGE_WIDTH, 1)
    return _TEXTS.picture("verdicts", wide, narrow, better=better, leading=said)


def _leaders(lead: Lead) -> list[str]:
    return [law_title(s.law) for s in lead.standings if s.leads] or ["nobody"]


def _leading(scenario: str, leads: Sequence[Lead]) -> str:
    """Who leads in a scenario, and by what."""
    found = [(_leaders(lead), lead.title) for lead in leads if lead.scenario == scenario]
    return "; ".join(f"{listed(who)} {'lead' if len(who) > 1 else 'leads'} in {title}" for who, title in found)


def _content(chapter: Chapter) -> str:
    """How much of what a chapter has."""
    many = {"claim": chapter.claims, "picture": chapter.pictures, "run": chapter.films}
    found = [counted(len(things), name) + " to play" * (name == "run") for name, things in many.items() if things]
    return listed(found) if found else "tables"


# What is drawn -------------------------------------------------------------------------------------------------


def _places(names: Sequence[str]) -> dict[str, str]:
    """The scenarios' names with nothing in them that a file name or an anchor cannot have; no two are the same."""
    slugs = [re.sub(r"[^A-Za-z0-9_-]+", "-", name).strip("-").lower() for name in names]
    return {
        name: slug if slug and slugs.count(slug) == 1 else f"{slug}-{place}".strip("-")
        for place, (name, slug) in enumerate(zip(names, slugs, strict=True), start=1)
    }


def _pictures(comparison: Comparison, scenario: Scenario, slug: str, first: Sequence[str] = ()) -> list[Picture]:
    name, seed = scenario.name, comparison.seeds[0]
    looked = looks(comparison.controllers)
    most = comparison.drawn_seeds
    seeds = "all seeds" if most == len(comparison.seeds) // comparison.points else f"the first {most} seeds"

    def drawn(plot: Callable[..., Figure], **options: Any) -> Callable[[], Figure]:
        runs = [(name, law) for law in comparison.controllers]  # looked up when the picture's turn comes
        return lambda: plot([comparison.runs[key] for key in runs], looks=looked, width=PAGE_WIDTH, **options)

    shown = shown_metrics(comparison, scenario, first, scenario.setting.has_others)
    about: dict[str, Any] = {"name": name, "seed": seed, "seeds": seeds, "count": len(shown)}
    about |= {"who": ", ".join(map(law_title, comparison.controllers)), "runs": comparison.counted_runs}
    about["better"] = _better(metric.title for metric in shown.values() if metric.larger)

    def picture(kind: str, draw: Callable[[], Figure], suffix: str = "", of: str = "") -> Picture:
        return _TEXTS.picture(f"{slug}-{kind}{suffix}", draw, key=kind, of=of, **about)

    metrics = partial(plot_comparison, comparison, name, list(shown), looks=looked, width=PAGE_WIDTH)
    pictures = [picture("metrics", metrics), picture("paths", drawn(plot_paths))]
    for i, member in enumerate(scenario.robots[:_PER_ROBOT]):
        called = (f"-robot-{i + 1}", f", robot {i + 1}") if len(scenario.robots) > 1 else ("", "")
        speeds = drawn(plot_velocities, robot=i, machine=member.robot)
        pictures += [picture("errors", drawn(plot_errors, robot=i), *called), picture("speeds", speeds, *called)]
    return pictures


# What is said --------------------------------------------------------------------------------------------------


def _facts(scenario: Scenario) -> list[tuple[str, str]]:
    """A scenario's conditions, in words."""
    sensing = scenario.sensing
    noise = _spread(sensing.position_noise, sensing.heading_noise)
    start = _spread(sensing.start_position, sensing.start_heading)
    measured = "the true one" if sensing.posture == "pose" else "from the wheel encoders alone"
    facts = [("posture", measured + (f" with white noise, standard deviations {noise}" if noise else ""))]
    if start:
        facts.append(("true start", f"off by standard deviations {start} over the seeds"))
    if not noise and not start:
        facts.append(("noise", "none: every seed gives the same run"))
    facts += [
        ("time", f"{scenario.duration:g} s; a command every {1000 * scenario.period:g} ms"),
        ("latency", f"{1000 * scenario.latency:g} ms from decision to effect"),
        ("plant", scenario.plant),
        ("stopped at", f"more than {scenario.divergence:g} m from the reference"),
    ]
    for i, member in enumerate(scenario.robots, start=1):
        facts.append((f"robot {i}" if len(scenario.robots) > 1 else "robot", _member(member)))
    return facts


def _spread(position: float, heading: float) -> str:
    """Standard deviations [m], [rad] in words; "" if both are 0."""
    return f"{1000 * position:g} mm in x and y, {1000 * heading:g} mrad" if position or heading else ""


def _member(member: Member) -> str:
    start = ", ".join(f"{v:g}" for v in member.start)
    timing = ", ".join(f"{name} {value}" for name, value in _set(member.timing))
    shape = ", ".join(f"{name} {value}" for name, value in _set(member.path))
    text = f"starts at [{start}] (m, m, rad); {type(member.path).__name__.lower()}: {shape}; timing: {timing}"
    return f"{text}; {_robot(member)}"


def _robot(member: Member) -> str:
    """The robot's model, and the numbers in which it differs from it; all of them where it has no model."""
    if member.model is None:
        return "robot: " + ", ".join(f"{name} {value}" for name, value in _set(member.robot))
    usual = dict(_set(member.model.robot))
    other = ", ".join(f"{name} {value}" for name, value in _set(member.robot) if usual.get(name) != value)
    return f"robot {member.model.title or member.model.name}" + (f", but {other}" if other else "")


def _set(instance: Any) -> list[tuple[str, str]]:
    """The fields of a dataclass with their units, without those that are not set."""
    result = []
    for f in fields(instance):
        value = getattr(instance, f.name)
        if not f.init or value is None or (value == f.default and value == 0):
            continue
        if isinstance(value, float):
            unit = f.metadata.get("unit", "")
            result.append((f.name, f"{value:.5g}" + (f" {unit}" if unit not in ("", "1") else "")))
        elif isinstance(value, tuple):
            pair = len(value) == 2 and not isinstance(value[0], tuple)
            result.append((f.name, f"({value[0]:g}, {value[1]:g}) m" if pair else f"({len(value)} points)"))
        else:
            result.append((f.name, str(value)))
    return result


def _terms(comparison: Comparison, heading: Heading) -> list[dict[str, Any]]:
    """The terms of each controller, with the gains that were changed."""
    rows = [{str(key): value for key, value in row.items()} for row in terms(comparison).to_dict(orient="records")]
    for row in rows:
        row["gains"] = row["gains"].replace(heading.folder, "") if heading.folder else row["gains"]
        row["name"] = heading.written.get(row["controller"], row["controller"])
        row["changed"] = Specification.of(row["name"]).gains
    return rows


def _program(comparison: Comparison) -> str:
    """Python that makes the same comparison."""
    seeds = comparison.seeds
    row = tuple(range(seeds[0], seeds[0] + len(seeds)))
    if seeds == row:
        chosen = f"range({len(seeds)})" if seeds[0] == 0 else f"range({seeds[0]}, {seeds[-1] + 1})"
    else:
        chosen = repr(list(seeds))
    scenarios = [f'"{s.name}"' for s in comparison.scenarios]
    return program("comparison", scenarios=scenarios, laws=[f'"{c}"' for c in comparison.controllers], seeds=chosen)
