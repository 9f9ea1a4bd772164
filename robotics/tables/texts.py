"""Texts from a TOML file beside the code that fills them in: sentences, captions, titles of columns."""

import tomllib
from functools import cached_property
from importlib import resources
from typing import Any


class TextFile:
    """The texts of a file of a package, by dotted keys; read when the first is asked for.

    A text has places for values in braces, as :meth:`str.format` fills them. An unknown key is a KeyError.
    """

    def __init__(self, package: str, file: str = "texts.toml") -> None:
        self.package, self.file = package, file

    def text(self, key: str, /, **values: Any) -> str:
        """The text of that key, with the values in their places."""
        return str(self.table(key)).format(**values)

    def texts(self, key: str, /, **values: Any) -> tuple[str, ...]:
        """The texts of a list, such as the paragraphs of a chapter or the head of a table."""
        return tuple(each.format(**values) for each in self.table(key))

    def filled(self, key: str, /, **values: Any) -> dict[str, str]:
        """The texts of a table by their keys, such as facts by a word each."""
        return {name: each.format(**values) for name, each in self.table(key).items()}

    def table(self, key: str) -> Any:
        """What stands under that key, as it is: a table, such as one of the titles of columns."""
        found: Any = self._all
        for part in key.split("."):
            if part not in found:
                raise KeyError(f"{self.package}/{self.file} has no text {key!r}")
            found = found[part]
        return found

    @cached_property
    def _all(self) -> dict[str, Any]:
        return tomllib.loads((resources.files(self.package) / self.file).read_text(encoding="utf-8"))
