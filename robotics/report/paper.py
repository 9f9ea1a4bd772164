"""A page that consists of chapters: one HTML file that needs nothing else."""

from collections.abc import Callable, Sequence
from pathlib import Path

from fuzzy.files.atomic import write_whole
from robotics.report.chapter import Chapter
from robotics.report.plates import plate
from robotics.report.template import rendered


def write_paper(
    path: str | Path,
    title: str,
    lead: Sequence[str],
    chapters: Sequence[Chapter],
    *,
    command: str | None = None,
    program: str | None = None,
    advance: Callable[[], None] = lambda: None,
) -> Path:
    """Draw the chapters' pictures and write the page, whole or not at all; return its path.

    The folder of the page is made if it is missing. Chapters that are ``closed`` are folded under their title.

    Args:
        path: The file.
        title: The page's title.
        lead: Paragraphs before the chapters.
        chapters: The chapters, whose names and whose pictures' names differ.
        command: The command line that made the page.
        program: Python that makes the same.
        advance: Called after every picture that is drawn: :func:`picture_count` times.

    Raises OSError, and what drawing a picture or making a film raises.
    """
    path = Path(path)
    plates = []
    for chapter in chapters:
        for picture in chapter.pictures:
            plates.append(plate(picture))
            advance()
    page = rendered("paper.html.j2", chapters, plates, (), title=title, lead=lead, command=command, program=program)
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, page)
    return path


def picture_count(chapters: Sequence[Chapter]) -> int:
    """The number of pictures that :func:`write_paper` draws."""
    return sum(len(chapter.pictures) for chapter in chapters)
