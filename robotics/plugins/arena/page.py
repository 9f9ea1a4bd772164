"""Writing the page of an arena of any kind, and its figures as files."""

from collections.abc import Callable, Sequence
from pathlib import Path

from fuzzy.figures.drawing import save_figure
from fuzzy.files.atomic import write_whole
from robotics.plugins.arena.entered import ArenaOutcome
from robotics.show.report.chapter import Chapter, Picture
from robotics.show.report.plates import Plate, plates_of
from robotics.show.report.template import rendered

_FORMATS = ("png", "svg", "pdf")


def write_page(
    outcome: ArenaOutcome,
    pictures: Sequence[Picture | Plate],
    chapters: Sequence[Chapter],
    answer: Sequence[str],
    file: Path,
    *,
    command: str | None,
    machine: str = "",
    advance: Callable[[], None] = lambda: None,
) -> Path:
    """Write ``file`` and figures/ beside it; return the page's path.

    Args:
        outcome: What came of the arena.
        pictures: All pictures, the one look first.
        chapters: What stands behind the answer.
        answer: Its sentences.
        file: The page.
        command: The command line that the page names.
        machine: On which computing times were measured, if they were.
        advance: Called twice for each picture.
    """
    plates = plates_of(pictures, advance)
    figures = file.parent / "figures"
    figures.mkdir(parents=True, exist_ok=True)
    for picture in pictures:
        assert isinstance(picture, Picture)
        figure = picture.draw()
        for suffix in _FORMATS:
            save_figure(figure, figures / f"{picture.name}.{suffix}")
        advance()
    page = rendered(
        str(Path(__file__).with_name("arena.html.j2")),
        chapters,
        plates,
        (),
        laws=outcome.laws,
        title=outcome.arena.title or f"The arena {outcome.arena.name}",
        head=plates[0],
        answer=answer,
        command=command,
        machine=machine,
    )
    write_whole(file, page)
    return file
