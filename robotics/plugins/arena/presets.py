"""The tuned laws of an arena as presets: the form of ``robotics/laws/tuned.toml``, with their rule bases beside it."""

import re
from collections.abc import Sequence
from pathlib import Path

from fuzzy.files.atomic import write_whole
from fuzzy.words import counted
from robotics.laws.catalogue import presets
from robotics.laws.equation import KNOWLEDGE_FIELDS
from robotics.laws.specification import Specification
from robotics.plugins.arena.outcome import Outcome


def preset_name(law: str) -> str:
    """The name of the preset of an arena's law: that in the catalogue, and what of knowledge it takes part with."""
    entered = Specification.of(law)
    known = [part for part in KNOWLEDGE_FIELDS if f"{part}=" in entered.gains]
    return "-".join([entered.name, *known, "tuned"])


def write_presets(outcome: Outcome, specifications: Sequence[str], folder: Path) -> None:
    """Write presets.toml, and for every rule base that it names NAME.fis; laws in files of the user's own are left out.

    Args:
        outcome: What came of the arena.
        specifications: Those of the chosen laws, as :func:`robotics.plugins.arena.report.write_laws` gives them.
        folder: Where they are written; it is made.
    """
    folder.mkdir(parents=True, exist_ok=True)
    arena, tables = outcome.arena, []
    note = (
        f"tuned by `robotics arena`: {len(arena.scenarios('tune'))} random scenarios, {counted(arena.runs, 'seed')}, "
        f"{{}} evaluations a search, {counted(len(arena.engines), 'engine')}, {counted(arena.repeats, 'repeat')}; "
        f"chosen on {len(arena.scenarios('choose'))} others"
    )
    for entry, text in zip(outcome.entries, specifications, strict=True):
        entered, chosen = Specification.of(entry.law), Specification.of(text)
        if entered.name not in presets():
            continue
        name = preset_name(entry.law)
        said = note.format(arena.budget(entry.law))
        said += "" if entry.by else ": no search found better gains than the published ones"
        gains = []
        for gain, _, value in (part.partition("=") for part in chosen.gains.split(",") if part):
            if value.endswith(".fis"):
                rules = Path(value).read_text(encoding="utf-8")
                write_whole(folder / f"{name}.fis", re.sub(r"(?m)^Name='.*'$", f"Name='{name}'", rules, count=1))
                value = name
            try:
                shown = f"{float(value):.6g}"
            except ValueError:
                shown = f'"{value}"'
            gains.append(f'"{gain}" = {shown}' if "." in gain else f"{gain} = {shown}")
        tables.append(f'[{name}]\nof = "{entered.name}"\nnote = "{said}"\ngains = {{ {", ".join(gains)} }}\n')
    write_whole(folder / "presets.toml", "\n".join(tables))
