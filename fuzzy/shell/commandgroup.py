"""The commands of a program below headings: its own, and those that installed packages add.

A package adds a command by an entry point of the group ``fuzzyfleet.commands``, named program, heading and command:

    [project.entry-points."fuzzyfleet.commands"]
    "robotics.deploy.flash" = "mypackage.commands:flash"

A command of a group is named likewise, as "robotics-dataset.commands.from-bag" of ``robotics dataset``. The value is a
function, as those in ``fuzzy/commands``, or an :func:`fuzzy.shell.terminal.application`, a group of commands. A module
is imported when its command is listed or called. What cannot be imported is a sentence in its place.
"""

from collections.abc import Mapping
from functools import cached_property
from importlib import import_module
from typing import Any, ClassVar

import typer
from typer.core import TyperGroup

from fuzzy.entrypoints import entry_points
from fuzzy.errors import InputError
from fuzzy.shell.options import Application

COMMAND_GROUP = "fuzzyfleet.commands"
MORE = "more"  # the heading below which commands are only named
_OWN = "fuzzyfleet"  # the distribution whose commands come before those of others


class CommandGroup(TyperGroup):
    """A group of commands that are imported when they are asked for; each has a class of its own."""

    program: ClassVar[str]  # its name in entry points; "": none are read
    modules: ClassVar[str]  # how the names of its own commands' modules begin, such as "robotics.commands."
    own: ClassVar[Mapping[str, str]]  # the headings of its own commands, by the names of their modules
    headings: ClassVar[tuple[str, ...]]  # in the order of the help; those that only others know come after them
    taken: tuple[Any, ...] = ()  # entry points of commands whose names others have

    @cached_property
    def _places(self) -> dict[str, tuple[str, Any]]:
        """The heading of every command, by its name, and the entry point of a plug-in's."""
        places: dict[str, Any] = {module.replace("_", "-"): (heading, None) for module, heading in self.own.items()}
        points = entry_points(group=COMMAND_GROUP) if self.program else ()
        for point in sorted(points, key=lambda each: (_package(each) != _OWN, each.name, each.value)):
            program, _, rest = point.name.partition(".")
            heading, _, name = rest.rpartition(".")
            if program == self.program and places.setdefault(name, (heading or MORE, point))[1] is not point:
                self.taken = (*self.taken, point)
        return places

    @property
    def commands(self) -> Any:
        """All commands, by name."""
        return {name: self.get_command(None, name) for name in self._places}

    @commands.setter
    def commands(self, _: Any) -> None:
        pass

    def list_commands(self, ctx: Any) -> list[str]:
        """The names of the commands."""
        return list(self._places)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """The command of that name, None where there is none."""
        module = cmd_name.replace("-", "_")
        if module in self.own:
            found = vars(import_module(self.modules + module))
            return _as_command(cmd_name, found.get(module) or found[f"{module}_"])
        if cmd_name not in self._places:
            return None
        point = self._places[cmd_name][1]
        try:
            return _as_command(cmd_name, point.load())
        except Exception as error:  # a stranger's code: whatever it raises, the others are there
            reason = " ".join(f"{type(error).__name__}: {error}".split())
            return _unusable(cmd_name, f"{point.value} of the package {_package(point)} cannot be used: {reason}")

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the commands below their headings, and those below "more" by their names alone."""
        names: dict[str, list[str]] = {heading: [] for heading in self.headings}
        for name, (heading, _) in self._places.items():
            names.setdefault(heading, []).append(name)
        for point in self.taken:
            typer.echo(f"the command {point.name} of the package {_package(point)} has the name of another", err=True)
        more = names.pop(MORE, [])
        wide = max((len(name) for group in names.values() for name in group), default=0)
        left = formatter.width - 6 - wide  # characters for a sentence
        for heading, group in ((heading, group) for heading, group in names.items() if group):
            with formatter.section(heading.capitalize()):
                formatter.write_dl([(n.ljust(wide), self.get_command(ctx, n).get_short_help_str(left)) for n in group])
        if more:
            with formatter.section(f"More ({ctx.command_path} COMMAND --help)"):
                formatter.write_text(", ".join(more))


def _package(point: Any) -> str:
    return str(point.dist.name if point.dist is not None else point.value)


def _as_command(name: str, found: Any, **settings: Any) -> Any:
    """The command that a function or a group of commands is, as typer makes it."""
    if not callable(found):
        raise TypeError(f"a command must be a function or an application, not {type(found).__name__}")
    above = Application(rich_markup_mode=None, pretty_exceptions_enable=False)
    if isinstance(found, Application):
        above.add_typer(found, name=name)
    else:
        above.command(name, **settings)(found)
    return typer.main.get_group(above).commands[name]


def _unusable(name: str, sentence: str) -> Any:
    """A command that says why it cannot be used, however it is called."""

    def say() -> None:
        raise InputError(f"{name}: {sentence}")

    open_to_all = {"ignore_unknown_options": True, "allow_extra_args": True}
    return _as_command(name, say, short_help=sentence, add_help_option=False, context_settings=open_to_all)
