"""Options of commands, and those that are the fields of a frozen dataclass: what is known of them is told once.

A parameter of a command,

    wrong: Annotated["Disturbance", FieldOptions("robotics.plugins.stress.disturbance:Disturbance", "loss")]

stands for an option for each of the named fields, and the command gets the finished dataclass. Fields are described as
:mod:`fuzzy.quantity` does, or by a ``typer.Option`` of their own. The dataclass is imported when its command is asked
for help or run, not with the command, so that other commands do not wait for it.
"""

import inspect
import sys
import warnings
from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import MISSING, Field, dataclass, fields
from functools import cached_property, partial, wraps
from importlib import import_module
from math import inf
from typing import Annotated, Any, get_type_hints

import typer
from typer.core import TyperCommand
from typer.models import OptionInfo

from fuzzy.entrypoints import entry_points
from fuzzy.errors import InputError
from fuzzy.words import split_list


def option(sentence: str, *shown: str, **more: Any) -> Any:
    """An option, from what its line in the help says: ``option("Where it goes.", "--out", "-o", "FILE")``.

    Args:
        sentence: What it is for.
        shown: Its names, by default that of the parameter, and what stands for its value.
        more: As of ``typer.Option``.
    """
    names = [word for word in shown if word.startswith("-")]
    return typer.Option(*names, help=sentence, metavar=" ".join(shown[len(names) :]) or None, **more)


def argument(sentence: str, metavar: str | None = None, *, show_default: bool = False, **more: Any) -> Any:
    """An argument, likewise."""
    return typer.Argument(help=sentence, metavar=metavar, show_default=show_default, **more)


Json = Annotated[bool, option("Print one JSON object instead of text.", "--json")]
Quiet = Annotated[bool, option("Show no progress bar.", "--quiet", "-q")]
# Of commands that show none, which scripts need not know
_QUIET = inspect.Parameter(
    "quiet",
    inspect.Parameter.KEYWORD_ONLY,
    default=False,
    annotation=Annotated[bool, option("No effect here.", "--quiet", "-q", hidden=True)],
)

_FAR = 1e9  # the help does not show so large a bound


@dataclass(frozen=True)
class Shown:
    """What an option has of its own, where that of its field does not suit a command line."""

    name: str = ""  # such as "--from"
    default: Any = ...
    doc: str = ""
    metavar: str | None = None
    complete: Callable[[str], list[str]] | None = None  # the continuations of a word that was begun


class FieldOptions:
    """The options that are fields of a dataclass: the annotation of a parameter of a command."""

    def __init__(
        self,
        kind: str,
        *names: str,
        later: bool = False,
        given: bool = False,
        of: str = "",
        added: str = "",
        **shown: Shown,
    ) -> None:
        """Choose the fields.

        Args:
            kind: The dataclass, as "package.module:Class".
            names: The fields, in the order of the help; none: all of them.
            later: Whether the command completes the dataclass, of which it gets a ``functools.partial``.
            given: Whether it gets one that knows only those options that were given.
            of: What the options belong to, with which their sentences begin, such as "scenario".
            added: A group of entry points that name further dataclasses, whose fields are options, too; the dataclass
                gets what is made of them as its field added.
            shown: By the name of a field what its option has of its own.
        """
        self.kind, self.names, self.shown = kind, names, shown
        self.later, self.given, self.of, self.added = later or given, given, of, added

    @cached_property
    def _class(self) -> type:
        module, _, name = self.kind.partition(":")
        return getattr(import_module(module), name)

    @cached_property
    def options(self) -> Mapping[str, "_FieldOption"]:
        """The options, by the names of their fields."""
        hints = get_type_hints(self._class, include_extras=True)
        known = {f.name: f for f in fields(self._class)}
        own = {n: _FieldOption(known[n], hints[n], self.shown.get(n, Shown()), self) for n in self.names or known}
        return own | {name: option for part in self._parts for name, option in part.options.items()}

    @cached_property
    def _parts(self) -> "Sequence[FieldOptions]":
        """Those of the dataclasses that entry points name; of one that cannot be imported a warning says so."""
        found = []
        for point in sorted(entry_points(group=self.added), key=lambda each: each.name) if self.added else ():
            part = FieldOptions(point.value)
            try:
                _ = part.options
            except Exception as error:  # a stranger's code: whatever it raises, the command goes on without
                warnings.warn(f"{point.value} cannot be used: {type(error).__name__}: {error}", stacklevel=2)
            else:
                found.append(part)
        return found

    def made(self, values: Mapping[str, Any]) -> Any:
        """What the command gets for the ``values`` of options."""
        others = {name for part in self._parts for name in part.options}
        own = {name: option.value(values[name]) for name, option in self.options.items() if name not in others}
        own |= {"added": tuple(part.made(values) for part in self._parts)} if self.added else {}
        made = partial(self._made, **{name: v for name, v in own.items() if v is not None or not self.given})
        return made if self.later else made()

    def _made(self, **values: Any) -> Any:
        """The dataclass; raises an InputError that names the option."""
        try:
            return self._class(**values)
        except InputError as error:
            field = str(error.at[-1]) if error.at else str(error).partition(" ")[0]
            if field not in self.options:
                raise
            said = str(error).removeprefix(f"{field} ")
            raise InputError(f"{self.options[field].name}{' ' if said != str(error) else ': '}{said}") from None


@dataclass(frozen=True)
class _FieldOption:
    """The option that a field of a dataclass is."""

    field: Field[Any]
    hint: Any
    shown: Shown
    group: FieldOptions

    @property
    def name(self) -> str:
        """What is typed."""
        return self.shown.name or f"--{self.field.name.replace('_', '-')}"

    def parameter(self) -> inspect.Parameter:
        """The parameter of a command whose option this is."""
        default, hint = self._default, self.hint
        if not any(isinstance(each, OptionInfo) for each in getattr(hint, "__metadata__", ())):
            hint = Annotated[self._type, self._option()]
        default = None if self.group.given else inspect.Parameter.empty if default is MISSING else default
        return inspect.Parameter(self.field.name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=hint)

    def value(self, typed: Any) -> Any:
        """The field's value of what was typed."""
        if typed is None or not self._listed:
            return typed
        return tuple(split_list(typed))

    @property
    def _listed(self) -> bool:
        return bool(self.hint == tuple[str, ...])

    @property
    def _default(self) -> Any:
        found = self.field.default if self.shown.default is ... else self.shown.default
        return ",".join(found) if self._listed and found is not MISSING else found

    @property
    def _type(self) -> Any:
        of = str if self._listed else self.hint
        return of | None if self.group.given else of

    def _option(self) -> Any:
        m, group = self.field.metadata, self.group
        bounds = {"min": m.get("least", -inf), "max": m.get("most", inf)} if not group.given else {}
        words: dict[str, Any] = {end: value for end, value in bounds.items() if abs(value) < _FAR}
        words |= {"metavar": self.shown.metavar, "autocompletion": self.shown.complete}
        named = (self.name,) if self.shown.name or self.hint is bool else ()
        return typer.Option(*named, help=self.shown.doc or self._doc(), **words)

    def _doc(self) -> str:
        """The sentence with the unit, and with what the help would not show."""
        m, default, of = self.field.metadata, self._default, self.group.of
        first, dot, rest = m["doc"].partition(". ")
        unit = f", {m['unit']}" if m.get("unit", "1") != "1" else ""
        above = f", > {m['above']:g}" if m.get("above", -inf) > -inf else ""
        usual = f" Default: {default:g}." if isinstance(default, float) else f" Default: {default}."
        start = f"{of}: {first[:1].lower()}{first[1:]}" if of else first
        told = self.group.given and default not in (MISSING, None, "")
        return f"{start.removesuffix('.')}{unit}{above}.{dot[1:]}{rest}{usual if told else ''}"


# Commands --------------------------------------------------------------------------------------------------------


class Application(typer.Typer):
    """A command line; a parameter of its commands can be :class:`FieldOptions`."""

    def command(  # type: ignore[override]
        self, name: str | None = None, **settings: Any
    ) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
        """Register a function as a command, as typer does."""

        def register(function: Callable[..., Any]) -> Callable[..., Any]:
            @wraps(function, assigned=("__module__", "__name__", "__doc__"))
            def named() -> None:  # its arguments and options are made when they are asked for
                pass

            named.__signature__ = inspect.Signature()  # type: ignore[attr-defined]
            typer.Typer.command(self, name, cls=_Command, **settings)(named)
            return function

        return register


class _Command(TyperCommand):
    """A command whose arguments and options are made when they are asked for; it knows earlier names of options."""

    @cached_property
    def _whole(self) -> Any:
        return _whole_command(inspect.unwrap(self.callback))  # type: ignore[arg-type]

    @property
    def params(self) -> Any:
        """Arguments and options."""
        return self._whole.params

    @params.setter
    def params(self, _: Any) -> None:
        pass

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read the arguments, those with earlier names included; say on stderr what these are called now."""
        before = getattr(inspect.unwrap(self.callback), "before", {})  # type: ignore[arg-type]
        return super().parse_args(ctx, _by_names_of_now(ctx, args, before))

    def invoke(self, ctx: Any) -> Any:
        """Run it."""
        return self._whole.invoke(ctx)


def renamed_options(**before: str) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Let a command go on knowing earlier names of options, for one version.

    Args:
        before: By the earlier name, without dashes, today's, such as "--workers"; "" where the values, with commas
            between them, are now arguments of their own.
    """

    def keep(function: Callable[..., Any]) -> Callable[..., Any]:
        function.before = {f"--{name.replace('_', '-')}": now for name, now in before.items()}  # type: ignore[attr-defined]
        return function

    return keep


def _by_names_of_now(ctx: Any, args: Sequence[str], before: Mapping[str, str]) -> list[str]:
    """The arguments by today's names."""
    found: list[str] = []
    by_place: list[str] = []
    rest = iter(args)
    for word in rest:
        if word == "--":
            return [*found, word, *rest, *by_place]
        name, sign, value = word.partition("=")
        if name not in before:
            found.append(word)
            continue
        now = before[name]
        if not ctx.resilient_parsing:  # which is what a shell's completion does
            called = f"is now called {now}" if now else "is no longer needed, its names stand by themselves"
            print(f"{ctx.command_path}: {name} {called}; the old name goes in the next release", file=sys.stderr)
        if now:
            found.append(now + sign + value)
        else:
            values = value if sign else next(rest, "")
            by_place += split_list(values)
    return [*found, *by_place]


def _whole_command(function: Callable[..., Any]) -> Any:
    """The command that a function is, with an option for each field; every one takes --quiet, be it without effect."""
    parameters: dict[str, inspect.Parameter] = {}
    groups: dict[str, FieldOptions] = {}
    own = list[str]()
    for parameter in inspect.signature(function).parameters.values():
        meant = getattr(parameter.annotation, "__metadata__", ())
        if meant and isinstance(meant[0], FieldOptions):
            groups[parameter.name] = meant[0]
            for name, option in meant[0].options.items():
                parameters.setdefault(name, option.parameter())  # several groups may read one option
        else:
            own.append(parameter.name)
            hint = _as_flag(parameter.name, parameter.annotation)
            parameters[parameter.name] = parameter.replace(kind=inspect.Parameter.KEYWORD_ONLY, annotation=hint)
    parameters.setdefault("quiet", _QUIET)

    def run(**values: Any) -> Any:
        made = {name: group.made(values) for name, group in groups.items()}
        return function(**{name: values[name] for name in own}, **made)

    run.__signature__ = inspect.Signature(list(parameters.values()))  # type: ignore[attr-defined]
    app = typer.Typer(add_completion=False)
    app.command()(run)
    return typer.main.get_command(app)


def _as_flag(name: str, hint: Any) -> Any:
    """The annotation of a parameter: what is on or off has the parameter's name alone, and none with "no" before it."""
    about = getattr(hint, "__metadata__", (None,))[0]
    if not isinstance(about, OptionInfo) or hint.__origin__ is not bool or about.default is not ...:
        return hint
    named = copy(about)
    named.default = f"--{name.replace('_', '-')}"  # where typer keeps the first name
    return Annotated[bool, named]
