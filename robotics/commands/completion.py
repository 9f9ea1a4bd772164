"""Names that a shell completes after Tab: scenarios, robots, controllers and the others that `robotics list` shows.

The controllers' names are read off their files, because importing the laws takes a second and a half.
"""

import tomllib
from collections.abc import Callable, Collection
from importlib import resources

from fuzzy.commands.completion import completed, last_of_list
from fuzzy.entrypoints import entry_points
from robotics.tables.files import names_in


def one_of(names: Collection[str]) -> Callable[[str], list[str]]:
    """The continuations of one of these names."""
    return lambda incomplete: completed(incomplete, names)


def _packaged(folder: str) -> Callable[[str], list[str]]:
    """The continuations of a packaged file's name, or of the path of a .toml file."""
    return lambda incomplete: completed(incomplete, names_in(folder), (".toml",))


scenarios, robots, studies, sweeps = map(_packaged, ("scenarios", "robots", "studies", "sweeps"))
arenas = _packaged("arenas")


def controllers(incomplete: str) -> list[str]:
    """Controllers by name, and a user's own: a rule base or a law in a file."""
    return completed(incomplete, _controller_names(), (".fis", ".py"))


def controller_list(incomplete: str) -> list[str]:
    """A list of controllers by name, with commas."""
    return last_of_list(incomplete, _controller_names())


def metrics(incomplete: str) -> list[str]:
    """Metrics of other packages, and a user's own in a file."""
    return completed(incomplete, sorted(entry_points(group="fuzzyfleet.metrics").names), (".py",))


def suites(incomplete: str) -> list[str]:
    """What `robotics compare` compares without names: studies of plug-ins, and the scenarios of a kind."""
    names = (*sorted(entry_points(group="fuzzyfleet.suites").names), "tracking", "formation", "team")
    return [name for name in names if name.startswith(incomplete)]


def copies(incomplete: str) -> list[str]:
    """What can be copied: rule bases, scenarios and robots."""
    from fuzzy.files.packaged import packaged_fis_files

    return completed(incomplete, [*packaged_fis_files(), *names_in("scenarios"), *names_in("robots")])


def _controller_names() -> list[str]:
    laws = resources.files("robotics") / "laws"
    files = [tomllib.loads((laws / file).read_text(encoding="utf-8")) for file in ("presets.toml", "tuned.toml")]
    return [name for names in (*files, sorted(entry_points(group="fuzzyfleet.laws").names)) for name in names]
