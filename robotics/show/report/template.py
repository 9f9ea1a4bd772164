"""The templates of pages, and what every page has: its looks, the player's script, the versions."""

import base64
from collections.abc import Iterable
from importlib import resources
from typing import Any

from jinja2 import Environment, FunctionLoader, StrictUndefined
from markupsafe import Markup

from fuzzy.figures.palette import stylesheet
from fuzzy.shown import typeset
from robotics.laws.catalogue import law_title
from robotics.show.playback.player import player_script
from robotics.show.report.chapter import Chapter, Plate
from robotics.show.report.glossary import SIDES, Linker, law_term, terms, terms_in, words_of
from robotics.show.report.plates import SCREEN
from robotics.studies.versions import versions

_HERE = resources.files("robotics") / "show" / "report"
_SPELLED = {"numpy": "NumPy", "python": "Python"}
_GLOSSARY = "<!-- glossary -->"  # stands in the page until it is known which words it has


def rendered(
    name: str,
    chapters: Iterable[Chapter],
    plates: Iterable[Plate],
    entries: Iterable[tuple[str, str]],
    laws: Iterable[str] = (),
    **values: Any,
) -> str:
    """The page that the template of that ``name`` makes.

    Args:
        name: A file of robotics/show/report, or the whole path of another.
        chapters: The chapters; their films are made.
        plates: Every picture of the page, drawn.
        entries: Anchors and titles of the sections before the chapters, for the list of contents.
        laws: The controllers that the glossary explains.
        values: What else the template names.
    """
    chapters, environment = list(chapters), _environment()
    environment.filters["typeset"] = typeset
    linked = Linker()
    page = environment.get_template(name).render(
        sheet=stylesheet() + (_HERE / "static" / "report.css").read_text(encoding="utf-8"),
        behaviour=(_HERE / "static" / "report.js").read_text(encoding="utf-8"),
        chapters=chapters,
        images={each.name: _image(each) for each in plates},
        films={film.caption: film.make() for chapter in chapters for film in chapter.films},
        entries=[
            *entries,
            *((f"chapter-{chapter.name}", chapter.title) for chapter in chapters),
            ("reproduce", "How to reproduce this"),
        ],
        linked=linked,
        glossary=Markup(_GLOSSARY),
        script=player_script(),
        versions=[(_SPELLED.get(name, name), version) for name, version in versions().items()],
        **values,
    )
    words = words_of(part for part in page.split('"') if not part.startswith("data:image"))
    parts = environment.get_template("parts.html.j2").module
    explained = [(law_title(law), SIDES[known.side], known.says) for law in laws if (known := law_term(law))]
    there = terms_in(words)
    found = [term for term in terms() if term in there or term.name in linked.used]
    shown = parts.glossary(found, explained) if found or explained else ""  # type: ignore[attr-defined]
    return page.replace(_GLOSSARY, shown, 1)


def program(name: str, **values: Any) -> str:
    """The Python program that the template of that ``name`` makes of the values; of another folder by its path."""
    return _environment().get_template(f"{name}.py.j2").render(**values) + "\n"


def _environment() -> Environment:
    return Environment(
        autoescape=lambda name: name is not None and name.endswith(".html.j2"),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        loader=FunctionLoader(lambda file: (_HERE / file).read_text(encoding="utf-8")),
    )


def _image(plate: Plate) -> dict[str, Any]:
    data = base64.b64encode(plate.webp).decode("ascii")
    narrow = plate.narrow and _image(plate.narrow)
    size = {"width": plate.width, "height": plate.height, "inches": round(plate.width / SCREEN, 2)}
    return {"data": data, "narrow": narrow, **size}
