"""The article as a page of the site: citations in words, a list of references, figures beside it.

``write(folder)`` makes ``made/`` there of ``paper.md``, ``paper.bib`` and ``figures.py``.
"""

import re
from pathlib import Path

import figures

HERE = Path(__file__).parent
_ENTRY = re.compile(r"@\w+\{(\w+),(.*?)\n\}", re.DOTALL)
_FIELD = re.compile(r"(\w+) = \{((?:[^{}]|\{(?:[^{}]|\{[^{}]*\})*\})*)\}")
_ACCENTS = {r"{\'e}": "é", r"{\'E}": "É"}


def references() -> dict[str, dict[str, str]]:
    """The fields of each entry of the bibliography, in plain text, by its key."""
    text = (HERE / "paper.bib").read_text(encoding="utf-8")
    for written, letter in _ACCENTS.items():
        text = text.replace(written, letter)
    return {
        key: {name: re.sub(r"[{}]", "", value).replace("--", "-") for name, value in _FIELD.findall(body)}
        for key, body in _ENTRY.findall(text)
    }


def _short(entry: dict[str, str]) -> str:
    names = [name.partition(",")[0] for name in entry["author"].split(" and ")]
    who = names[0] if len(names) == 1 else f"{names[0]} & {names[1]}" if len(names) == 2 else f"{names[0]} et al."
    return f"{who} {entry['year']}"


def _long(entry: dict[str, str]) -> str:
    where = entry.get("journal") or entry.get("booktitle") or entry.get("school") or ""
    place = ", ".join(part for part in (where, entry.get("volume"), entry.get("pages")) if part)
    authors = entry["author"].replace(" and ", "; ")
    return f"{authors} ({entry['year']}). {entry['title']}." + (f" *{place}*." if place else "")


def page() -> str:
    """The article in Markdown that the site reads."""
    known = references()
    head, text = (HERE / "paper.md").read_text(encoding="utf-8").split("\n---\n", 1)
    title = re.findall(r'^title: "(.*)"$', head, re.MULTILINE)[0]
    text = re.sub(r"\[@(\w+)\]", lambda match: f"[{_short(known[match[1]])}]", text)
    captions = re.findall(r"!\[(.*?)\\label\{(fig:\w+)\}\]\((\w+\.png)\)", text, re.DOTALL)
    for number, (caption, label, name) in enumerate(captions, 1):
        said = " ".join(caption.split())
        text = text.replace(
            f"![{caption}\\label{{{label}}}]({name})", f"![{said}](made/{name})\n\n*Figure {number}.* {said}"
        ).replace(f"\\autoref{{{label}}}", f"Figure {number}")
    text = re.sub(r"^# ", "## ", text, flags=re.MULTILINE).rstrip()
    listed = sorted(f"* {_long(entry)}" for entry in known.values())
    return "\n".join([f"## {title}", "", text, "", *listed, ""])


def write(folder: Path) -> None:
    """Write the page and its figures into the folder ``made`` below ``folder``."""
    made = folder / "made"
    figures.write(made)
    (made / "paper.md").write_text(page(), encoding="utf-8")
