"""The scenario or robot file that is edited in the panel "Try it": its text, what is wrong with it, and saving it."""

from dataclasses import dataclass, replace
from typing import Any

from fuzzy.plugins.designer.folder import Folder
from fuzzy.plugins.designer.saving import OverwriteError
from robotics.plugins.designer.folderfiles import FolderText, checked_text, write_text_file
from robotics.plugins.designer.uses import TryoutError

TEXT_KINDS = ("scenario", "robot")


@dataclass(frozen=True)
class TextDesk:
    """One text under edit; a desk never changes, each step gives the next one."""

    what: str  # "scenario" or "robot"
    file: FolderText  # as it was read or saved last; without a digest it comes with the package or from elsewhere
    text: str  # as it is edited
    copy: int  # counts the texts that came from here, which the page then shows anew
    problem: tuple[int | None, str] | None = None  # the line, if it is known, and what is wrong there
    asks: str = ""  # why saving needs a word more: it would overwrite something

    @property
    def saved(self) -> bool:
        """Whether the file in the folder holds the text."""
        return self.file.digest is not None and self.text == self.file.text

    @property
    def edited(self) -> bool:
        """Whether the text is another than the one that was opened."""
        return self.text != self.file.text

    def written(self, text: Any) -> "TextDesk":
        """With another text. Raises TryoutError for one that is too long, or none."""
        if not isinstance(text, str):
            raise TryoutError("a file is edited as text")
        return replace(self, text=checked_text(self.file.name, text.encode("utf-8", "replace")), asks="")

    def judged(self, fault: dict[str, Any]) -> "TextDesk":
        """With what :func:`robotics.plugins.designer.tryout.checked` says of the text."""
        return replace(self, problem=(fault["line"], fault["message"]) if fault else None)

    def reverted(self) -> "TextDesk":
        """With the text as it was opened or saved."""
        return replace(self, text=self.file.text, copy=self.copy + 1, asks="")

    def reread(self, file: FolderText) -> "TextDesk":
        """After the file has changed on disk: an edited text stays, and saving will ask."""
        if self.edited:
            asks = f"{file.name} was changed on disk by another program; saving overwrites that"
            return replace(self, asks=asks)
        return replace(self, file=file, text=file.text, copy=self.copy + 1)

    def saved_as(self, folder: Folder, name: str, overwrite: bool) -> "TextDesk":
        """After writing the text to the file ``name``; where it would overwrite what was not read, it asks instead.

        Raises FolderError or DocumentError where it cannot be written.
        """
        try:
            file = write_text_file(folder, self.file._replace(text=self.text), name, overwrite)
        except OverwriteError as error:
            return replace(self, asks=str(error))
        return replace(self, file=file, asks="")

    def shown(self) -> dict[str, Any]:
        """What the page shows; the text is the one that was opened, which the page itself edits."""
        line, message = self.problem or (None, "")
        return {
            "what": self.what,
            "name": self.file.name,
            "own": self.file.digest is not None,
            "text": self.file.text,
            "copy": self.copy,
            "saved": self.saved,
            "edited": self.edited,
            "line": line,
            "message": message,
            "asks": self.asks,
        }
