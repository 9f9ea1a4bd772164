"""Files of plans, whatever their kind: told apart by their keys, and drawn in text before anything runs."""

import copy
from collections.abc import Callable, Iterator, Sequence
from itertools import chain
from pathlib import Path
from typing import Any, NamedTuple

from fuzzy.entrypoints import entry_points
from fuzzy.errors import InputError
from fuzzy.words import counted
from robotics.show.report.plan import StudyPlan, load_study, study_from_table, study_names
from robotics.studies.axes import SWEEP_KEYS
from robotics.studies.design import Axis
from robotics.studies.tuning.file import load_tuning, tuning_from_table
from robotics.tables.build import Keys
from robotics.tables.faults import FileFault, Remains
from robotics.tables.files import TomlFile
from robotics.tables.text import parse_table, read_text

PLAN_GROUP = "fuzzyfleet.plans"  # entry points: kinds of files of plug-ins, each a PlanKind

_NAMED_ELSEWHERE = ("scenarios", "controllers", "laws", "names", "axes", "conditions")  # keys whose entries are
Row = tuple[int, str, str]  # how many, of what, which: what a plan multiplies


class PlanKind(NamedTuple):
    """A kind of files that plan runs.

    Attributes:
        name: What it is called.
        keys: The keys that only such a file has.
        draw: Gives its title, its rows and further lines, from the file.
        read: Reads the table of a file of the kind; its InputErrors are about the keys of what is wrong.
        new_form: What it is as a study's file; "": it is one.
        run: Runs the file, with the options workers, out, fresh, json and quiet; None: there is nothing to run.
    """

    name: str
    keys: frozenset[str]
    draw: Callable[[str], tuple[str, list[Row], list[str]]]
    read: Callable[[dict[str, Any], TomlFile], Any]
    new_form: str = ""
    run: Callable[..., None] | None = None


def plan_kind(name: str) -> PlanKind | None:
    """The kind of plan of which a file has the most keys; None for no plan, as a scenario. Plug-ins are asked last."""
    if name in study_names():
        return _STUDY
    path = Path(name)
    if path.suffix != ".toml" or not path.is_file():
        return None
    keys = {*parse_table(read_text(path, InputError), name, InputError)}
    others = (point.load() for point in entry_points(group=PLAN_GROUP))
    best = max(chain((_STUDY, _SWEEP, _TUNING), others), key=lambda kind: len(keys & kind.keys))
    return best if keys & best.keys else None


class _PlanRemains(Remains):
    """A plan's table, from which more and more is left out."""

    def explains(self, at: Keys) -> bool:
        """Likewise; also a scenario or a controller that is missing where others are named."""
        named = at[:1] in (("claims",), ("names",), ("tune",), ("axes",), ("conditions",), ("search",))
        return super().explains(at) or (named and any(gone[0] in _NAMED_ELSEWHERE for gone in self.dropped))


def plan_faults(kind: PlanKind, name: str) -> tuple[TomlFile, list[FileFault]]:
    """The user's own file of a plan, and all that is wrong with it. Raises an InputError for what is no TOML."""
    path = Path(name)
    about = TomlFile(read_text(path, InputError), path.stem, name, path.parent, path)
    left = _PlanRemains(parse_table(about.text, name, InputError))
    return about, left.faults(lambda table: kind.read(copy.deepcopy(table), about))


def note_on(kind: PlanKind, name: str) -> str:
    """What is said of a file that is no study's, but readable as what it is."""
    article = "an" if kind.name[0] in "aeiou" else "a"
    what = f"{name} is {article} {kind.name}'s file, and is read as one"
    return f"{what}; its new form: {kind.new_form} (robotics new study)"


def drawn_plan(kind: PlanKind, name: str) -> str:
    """The plan in a file, in text: what is multiplied with what, how many runs and pieces that makes, what is asked.

    Raises an InputError for a file that makes no plan.
    """
    title, rows, tail = kind.draw(name)
    heads = [f"{'× ' if place else '':2}{counted(count, word)}" for place, (count, word, _) in enumerate(rows)]
    width = max(map(len, heads), default=0)
    drawn = [f"{head:{width}}  {text}" for head, (_, _, text) in zip(heads, rows, strict=True)]
    return "\n".join([f"{name}: {title}" if title else name, *drawn, *tail])


def _study(name: str) -> tuple[str, list[Row], list[str]]:
    plan = load_study(name)
    points, design = (len(plan.points), _design(plan.axis_list, plan.method)) if plan.axes else (1, "")
    rows = [
        (len(plan.settings), "scenario", ", ".join(s.name for s in plan.settings)),
        *([(len(plan.conditions), "condition", ", ".join(plan.conditions))] if plan.conditions else []),
        *([(points, "point", design)] if design else []),
        (len(plan.laws), "controller", ", ".join(plan.laws)),
        (plan.seeds, "seed", _seeds(plan.row)),
    ]
    return plan.title, rows, [*_amount(plan), *_asked(plan)]


def _amount(plan: StudyPlan) -> Iterator[str]:
    pieces = sum(case.chunks(plan.row) for case in chain(*plan.cases))
    yield f" = {counted(plan.runs, 'run')} in {counted(pieces, 'piece')}, {counted(plan.rows, 'row')}"
    for group in plan.groups:
        yield from (f"   without {on}: {line}" for on, lines in group.skipped.items() for line in lines)


def _asked(plan: StudyPlan) -> Iterator[str]:
    if plan.tune is not None:
        tuned, on = plan.tune, sorted({s.name for name in plan.tuned for s in plan.tuned_on(name)})
        yield (
            f"   tuned first: {', '.join(plan.tuned)}, {counted(tuned.evaluations, 'evaluation')} each on "
            f"{', '.join(on)} × {counted(tuned.runs, 'seed')}"
        )
    for word, names in (("claim", [claim.name for claim in plan.claims]), ("question", plan.questions)):
        if names:
            yield f"   {counted(len(names), word)}: {', '.join(names)}"


def _tuning(name: str) -> tuple[str, list[Row], list[str]]:
    found = load_tuning(name)
    terms = " + ".join(f"{term.metric} / {term.scale:g}" for term in found.cost)
    return found.title, [], [f"   moves {', '.join(found.move)}", f"   cost {terms}"]


def _seeds(row: Sequence[int]) -> str:
    return f"{row[0]} to {row[-1]}" if len(row) > 1 else str(row[0])


def _design(axes: Sequence[Axis], method: str) -> str:
    spans = [
        f"{axis.name} {', '.join(map(str, axis.levels))}"
        if axis.levels
        else f"{axis.name} {axis.low:g} to {axis.high:g}"
        for axis in axes
    ]
    return f"{method}: {' × '.join(spans)}"


_STUDY = PlanKind("study", frozenset({"scenarios"}), _study, study_from_table)
_SWEEP = PlanKind(
    "sweep",
    SWEEP_KEYS,
    _study,
    study_from_table,
    "scenarios, controllers and seeds of a study, with [[axes]] key = ... or gain = ..., values = ...",
)
_TUNING = PlanKind(
    "tuning",
    frozenset({"move", "cost", "bounds", "rule_bases", "fixed", "symmetric"}),
    _tuning,
    lambda table, about: tuning_from_table(table, about.folder),
    "the key space of a study's [tune]",
)
