"""The files of a control law in C, written whole or not at all."""

from pathlib import Path
from typing import Any, NamedTuple

from fuzzy.files.atomic import write_together
from fuzzy.plugins.ccode.identifier import identifier
from robotics.laws.catalogue import as_law
from robotics.laws.law import Law
from robotics.plugins.ccode.guard import HandedOrder
from robotics.plugins.ccode.source import SECTIONS, LawSources, law_sources
from robotics.simulation.scenario.description import Scenario


class CLawFiles(NamedTuple):
    """What was written of a law, and for which it was.

    Attributes:
        law: The law.
        sources: The texts of the files.
        number: "double" or "float".
        folder: Where they lie.
    """

    law: Law[Any]
    sources: LawSources
    number: str
    folder: Path

    @property
    def files(self) -> list[Path]:
        """The paths of headers and sources, those of the law first."""
        names = [self.sources.name, *(base.name for base in self.sources.bases)]
        return [self.folder / f"{name}.{ending}" for name in names for ending in ("h", "c")]


def write_c_law(
    controller: Law[Any] | str, scenario: Scenario, folder: str | Path, number: str = "double", *, name: str = ""
) -> CLawFiles:
    """Write a law's control step as C99 that allocates nothing and needs only math.h.

    Args:
        controller: The law, or its specification, such as "fuzzy:rule_base=mine.fis". Of one that cannot be written but
            says safe=yes, the monitor of passive safety is: the order is handed to it.
        scenario: Whose first robot and control period count.
        folder: Where to write, made if it is not there.
        number: "double" or "float".
        name: The files' name and the functions' prefix; by default the law's.

    Returns:
        The files that were written.

    Raises:
        ExportError: A law that cannot be written; the message lists those that can.
        OSError: Nothing can be written.
    """
    law = as_law(controller)
    plain = controller.partition(":")[0] if isinstance(controller, str) else type(law).__name__
    if law.safe == "yes" and type(law) not in SECTIONS:
        law, plain = HandedOrder(safe="yes"), f"{plain}_monitor"
    sources = law_sources(law, scenario.setting, name or identifier(plain), number)
    written = CLawFiles(law, sources, number, Path(folder))
    texts = [sources.header, sources.source]
    texts += [text for base in sources.bases for text in (base.header, base.source)]
    write_together(folder, {file.name: text for file, text in zip(written.files, texts, strict=True)})
    return written
