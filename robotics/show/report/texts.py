"""The texts of a report's part: titles, captions and sentences, from a TOML file beside the code that fills them in."""

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any

from matplotlib.figure import Figure

from robotics.show.report.chapter import Chapter, Grid, Picture
from robotics.tables.texts import TextFile


class ReportTexts(TextFile):
    """The texts of a report's part, and the chapters, tables and pictures that are called by them."""

    def chapter(self, name: str, values: Mapping[str, Any] = MappingProxyType({}), /, **parts: Any) -> Chapter:
        """The chapter of that name with those parts; what its table has, such as title and text, stands there.

        The ``values`` fill its text.
        """
        about = self.table(name)
        own = {key: about[key] for key in ("title", "folded") if key in about}
        text = self.texts(f"{name}.text", **values) if "text" in about else ()
        return Chapter(name=name, text=text, **own, **parts)

    def grid(self, key: str, rows: Sequence[tuple[str, ...]], /, **values: Any) -> Grid:
        """The table of a chapter, its caption and its head from the table that is called so."""
        return Grid(self.text(f"{key}.caption", **values), self.texts(f"{key}.head"), rows)

    def picture(
        self,
        name: str,
        draw: Callable[[], Figure],
        narrow: Callable[[], Figure] | None = None,
        /,
        *,
        key: str = "",
        **values: Any,
    ) -> Picture:
        """The picture of that name, its caption and its alt from the table that is called so, or ``key``."""
        caption, alt = (self.text(f"{key or name}.{part}", **values) for part in ("caption", "alt"))
        return Picture(name, caption, alt, draw, narrow)
