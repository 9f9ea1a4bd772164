"""The texts of a report's part: titles, captions and sentences, from a TOML file beside the code that fills them in."""

import tomllib
from collections.abc import Callable, Sequence
from functools import cached_property
from importlib import resources
from typing import Any

from matplotlib.figure import Figure

from robotics.show.report.chapter import Chapter, Grid, Picture


class ReportTexts:
    """The texts of a file of a package, by dotted keys; read when the first is asked for.

    A text has places for values in braces, as :meth:`str.format` fills them. An unknown key is a KeyError.
    """

    def __init__(self, package: str, file: str = "texts.toml") -> None:
        self.package, self.file = package, file

    def text(self, key: str, /, **values: Any) -> str:
        """The text of that key, with the values in their places."""
        return str(self._found(key)).format(**values)

    def texts(self, key: str, /, **values: Any) -> tuple[str, ...]:
        """The texts of a list, such as the paragraphs of a chapter or the head of a table."""
        return tuple(each.format(**values) for each in self._found(key))

    def table(self, key: str) -> dict[str, str]:
        """The texts of a table by their keys, such as the titles of columns."""
        return dict(self._found(key))

    def chapter(self, name: str, /, **parts: Any) -> Chapter:
        """The chapter of that name with those parts; what its table has, such as title and text, stands there."""
        about = self._found(name)
        own = {key: about[key] for key in ("title", "folded") if key in about}
        return Chapter(name=name, text=tuple(about.get("text", ())), **own, **parts)

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
        key: str | None = None,
        **values: Any,
    ) -> Picture:
        """The picture of that name, its caption and its alt from the table that is called so, or ``key``."""
        at = key or name
        return Picture(name, self.text(f"{at}.caption", **values), self.text(f"{at}.alt", **values), draw, narrow)

    def _found(self, key: str) -> Any:
        found: Any = self._table
        for part in key.split("."):
            if part not in found:
                raise KeyError(f"{self.package}/{self.file} has no text {key!r}")
            found = found[part]
        return found

    @cached_property
    def _table(self) -> dict[str, Any]:
        return tomllib.loads((resources.files(self.package) / self.file).read_text(encoding="utf-8"))
