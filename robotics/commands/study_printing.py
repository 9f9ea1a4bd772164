"""How the outcome of a comparison or of a study is printed."""

import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fuzzy.shell.interrupts import interrupted
from fuzzy.shell.terminal import print_json
from robotics.commands.shared import UNTIL_CONTACT, print_outside
from robotics.studies.executors import WorkerError
from robotics.studies.versions import versions

if TYPE_CHECKING:
    from robotics.show.report.chapter import Claim
    from robotics.show.report.study import Study
    from robotics.studies.comparison import Comparison

_FORMS = """
What the source claims, judged by these runs: that a claim does not hold is a result, and no error of this program. Its
laws drive as printed; corrected, without what is wrong in the text; ideal, corrected and without noise; and tuned, with
gains that a search found. The report and evidence.csv say what decides each claim.
"""


def print_study(study: "Study", wanted: Sequence[str] = (), title: str = "") -> None:
    """Print the outcome of a comparison or of a study: tables and verdicts, or as JSON what of it is ``wanted``."""
    outside = print_outside(note.outside for each in study.comparisons for note in each.notes.values())
    if not wanted:
        print_comparisons(study)
        print_claims(study.claims)
        for name, answer in study.answers.items():
            print(f"\n{answer.title or name}\n  {answer.sentence}")
        print(f"\n{study.shown}")
        return
    about = {
        "title": title,
        "summary": study.summary.to_dict(orient="records"),
        "claims": [claim.row() for claim in study.claims],
        "evidence": [row for claim in study.claims for row in claim.evidence()],
        "contacts": _contact_rows(study),
        "diverged": study.divergences,
        "outside": outside,
        "skipped": list(study.skipped),
        "files": study.files,
        "versions": versions(),
    }
    answers = {"answers": {name: answer.row() for name, answer in study.answers.items()}} if study.answers else {}
    print_json({name: about[name] for name in wanted} | answers)


def print_comparisons(study: "Study") -> None:
    """Print a short table for every scenario."""
    for comparison in study.comparisons:
        _print_tables(comparison, study)
    count = len(study.comparison.seeds)
    over = study.comparison.counted_runs
    print("one seed" if count == 1 else f"mean over {over} ± half the 95 % confidence interval")
    if any(row["with_contact"] for row in _contact_rows(study)):
        print(UNTIL_CONTACT)


@contextmanager
def rows_kept(wanted: int, file: Path) -> Iterator[Callable[[int], None]]:
    """Give what is told how many rows are written, and say on Ctrl-C, and where processes die, how many of
    those that were ``wanted`` are kept.

    Args:
        wanted: The number of rows of the whole.
        file: The file that holds them.
    """
    done = 0

    def kept(rows: int) -> None:
        nonlocal done
        done = rows

    try:
        yield kept
    except KeyboardInterrupt:
        interrupted(f"{done} of {wanted} rows are in {file}; the same command goes on from there")
    except WorkerError as error:
        raise WorkerError(
            f"{error}; {done} of {wanted} rows are in {file}; the same command goes on from there"
        ) from None


def already_there(folder: Path, quiet: bool, what: str = "pieces") -> Callable[[int, int], None]:
    """Give what is told how many pieces of the work, called ``what``, the folder has already, and says it on stderr."""

    def resumed(done: int, pieces: int) -> None:
        if not quiet:
            print(f"{folder}: {done} of {pieces} {what} are there already", file=sys.stderr)

    return resumed


def print_claims(claims: "Sequence[Claim]") -> None:
    """Print every claim with its verdict.

    A line tells each claim of a publication, on the forms of its laws; below other claims stands what decides them.
    """
    from robotics.show.report.wording import sentence

    if any("" not in claim.forms for claim in claims):
        print(_FORMS)
    for claim in claims:
        source = f" ({claim.source})" if claim.source else ""
        if "" not in claim.forms:
            told = "; ".join(f"{form} {verdict}" for form, verdict in claim.forms.items())
            print(f"  {claim.name}{source}: {told}")
            continue
        print(f"\n{claim.name}{source}: {claim.verdict.upper()} ({claim.counts('')})".replace(" ()", ""))
        for part in claim.parts:
            print(f"  {sentence(part)}")


def _contact_rows(study: "Study") -> list[dict[str, Any]]:
    """How many runs of each controller on each scenario had a contact, where there is something to touch."""
    from robotics.studies.comparison import contact_runs

    rows = []
    for comparison in study.comparisons:
        for scenario in comparison.scenarios:
            for law in comparison.controllers:
                count, runs = contact_runs(comparison.table, scenario.name, law)
                row = {"scenario": scenario.name, "controller": law, "with_contact": count, "runs": runs}
                rows += [row] if scenario.setting.has_others else []
    return rows


def _print_tables(comparison: "Comparison", study: "Study") -> None:
    """Print the table of every scenario; where it is wider than the terminal, a line for each number."""
    from rich.console import Console
    from rich.table import Table

    from robotics.show.report.summarytable import printed_metrics, summary_table

    # A pipe has no width of its own.
    console = Console(width=None if sys.stdout.isatty() else 160, highlight=False, markup=False)
    for scenario in comparison.scenarios:
        shown = printed_metrics(comparison, scenario, study.first)
        found = summary_table(comparison, scenario.name, study.first, only=shown)
        contacts = found.contacts or [(0, 0)] * len(found.controllers)
        laws = [name + " ✕" * (count > 0) for name, (count, _) in zip(found.controllers, contacts, strict=True)]
        heads = [f"{m.short or m.title}\n[{row.unit}]" for m, row in zip(shown.values(), found.rows, strict=True)]
        columns = {"controller": laws} | {
            head: [f"{cell.mean} ± {cell.half}" if cell.half not in ("", "0") else cell.mean for cell in row.cells]
            for head, row in zip(heads, found.rows, strict=True)
        }
        title = f"{scenario.name}: {scenario.title}"
        widths = [_widths(columns, in_words) for in_words in (False, True)]
        fitting = [each for each in widths if sum(each.values()) + 3 * len(each) + 1 <= console.width]
        if fitting:
            table = Table(title=title, title_justify="left")
            for head, width in fitting[0].items():
                table.add_column(head, width=width, justify="left" if columns[head] is laws else "right")
            for row in zip(*columns.values(), strict=True):
                table.add_row(*row)
            console.print(table)
        else:
            print(title)
            wide = max(map(len, laws))
            for head in heads:
                print("  " + head.replace("\n", " "))
                for law, number in zip(laws, columns[head], strict=True):
                    print(f"    {law:{wide}}  {number}")
        for name, (count, runs) in zip(found.controllers, contacts, strict=True):
            if count:
                print(f"✕ {name}: contact in {count} of {runs} runs")


def _widths(columns: dict[str, list[str]], in_words: bool) -> dict[str, int]:
    """How wide each column is if no number and no unit is broken, and the headings at most between words."""
    heads = {head: head.partition("\n") for head in columns}
    parts = {head: [unit, *(title.split() if in_words else [title])] for head, (title, _, unit) in heads.items()}
    return {head: max(map(len, [*cells, *parts[head]])) for head, cells in columns.items()}
