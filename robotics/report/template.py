"""The templates of pages, and what every page has: its looks, the player's script, the versions."""

import base64
from collections.abc import Iterable
from importlib import resources
from typing import Any

from jinja2 import Environment, FunctionLoader, StrictUndefined

from fuzzy.figures.palette import stylesheet
from robotics.experiments.versions import versions
from robotics.playback.player import player_script
from robotics.report.chapter import Chapter, Plate


def rendered(name: str, chapters: Iterable[Chapter], plates: Iterable[Plate], **values: Any) -> str:
    """The page that the template of that ``name`` makes.

    Args:
        name: A file of robotics/report.
        chapters: The chapters; their films are made.
        plates: Every picture of the page, drawn.
        values: What else the template names.
    """
    here = resources.files("robotics") / "report"
    chapters = list(chapters)
    environment = Environment(
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        loader=FunctionLoader(lambda file: (here / file).read_text(encoding="utf-8")),
    )
    return environment.get_template(name).render(
        sheet=stylesheet() + (here / "static" / "report.css").read_text(encoding="utf-8"),
        chapters=chapters,
        images={each.name: base64.b64encode(each.png).decode("ascii") for each in plates},
        films={film.caption: film.make() for chapter in chapters for film in chapter.films},
        script=player_script(),
        versions=_versions(),
        **values,
    )


def _versions() -> list[tuple[str, str]]:
    spelled = {"numpy": "NumPy", "python": "Python"}
    return [(spelled.get(name, name), version) for name, version in versions().items()]
