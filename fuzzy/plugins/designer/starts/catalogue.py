"""The starts of all installed packages.

A package offers starts by entry points of the group ``fuzzyfleet.starts``, in ``pyproject.toml``:

    [project.entry-points."fuzzyfleet.starts"]
    mine = "mypackage.starts:starts"

The value is a function without arguments that gives a sequence of :class:`fuzzy.plugins.designer.starts.start.Start`.
"""

from typing import NamedTuple

from fuzzy.entrypoints import entry_points
from fuzzy.naming import check_known
from fuzzy.plugins.designer.starts.packaged import packaged_starts
from fuzzy.plugins.designer.starts.start import Start, StartError

START_GROUP = "fuzzyfleet.starts"


class Catalogue(NamedTuple):
    """What was found."""

    starts: tuple[Start, ...]  # those of one group one after the other
    unusable: tuple[str, ...]  # a sentence for each entry point that cannot be used, and for each name that is taken

    def start(self, name: str) -> Start:
        """The start of that name. Raises StartError."""
        found = {start.name: start for start in self.starts}
        check_known(name, found, "start", StartError)
        return found[name]


def find_starts() -> Catalogue:
    """The starts of all installed packages, and at the end the shipped rule bases that none of them has."""
    starts: dict[str, Start] = {}
    sentences = []
    # fuzzy's own stand first
    for point in sorted(
        entry_points(group=START_GROUP), key=lambda point: (point.name != "fuzzy", point.name, point.value)
    ):
        try:
            found = tuple(point.load()())
            if not all(isinstance(start, Start) for start in found):
                raise TypeError(f"{point.value}() must give a sequence of fuzzy.plugins.designer.starts.start.Start")
        except Exception as error:  # a stranger's code: whatever it raises, the others are there
            sentences.append(f"the starts {point.name!r} cannot be used: {error or type(error).__name__}")
            continue
        for start in found:
            if starts.setdefault(start.name, start) is not start:
                sentences.append(f"the starts {point.name!r}: there is another start {start.name!r}")
    for start in packaged_starts():
        starts.setdefault(start.name, start)
    groups = list(dict.fromkeys(start.group for start in starts.values()))  # in the order of their first ones
    grouped = sorted(starts.values(), key=lambda start: groups.index(start.group))
    return Catalogue(tuple(grouped), tuple(sentences))
