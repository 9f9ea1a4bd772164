"""Running a command line: one message for an expected error, never a traceback, and the right exit code."""

import contextlib
import errno
import json
import math
import os
import re
import sys
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Annotated, Any

import typer

from fuzzy.compiled import notice
from fuzzy.errors import InputError
from fuzzy.naming import did_you_mean
from fuzzy.shell.commandgroup import CommandGroup
from fuzzy.shell.interrupts import INTERRUPTED, answered, exit_code, interrupted, is_told, of_interrupt
from fuzzy.shell.options import Application

# Exit statuses
OK = 0
FAILED = 1
USAGE = 2  # of input that cannot be used
BROKEN_PIPE = 141  # nobody reads the output: 128 + SIGPIPE
# typer brings its own copy of click or uses the installed one, by version: this finds the class in either.
_ClickError: type[Exception] = next(c for c in typer.BadParameter.__mro__ if c.__name__ == "ClickException")


def application(
    purpose: str,
    *examples: str,
    program: str = "",
    modules: str = "",
    commands: str | Mapping[str, str] | None = None,
    version: Callable[[], str] | None = None,
) -> Application:
    """A command line, as all of ours begin: plain help, -h as well as --help, help if nothing is said.

    It has the options --install-completion and --show-completion, if it is not a group of commands in another one.

    Args:
        purpose: What it is for, a sentence.
        examples: Commands with which its help ends, that run as they stand, one after the other.
        program: The name by which installed packages add commands: :mod:`fuzzy.shell.commandgroup`.
        modules: How the names of its commands' modules begin, "robotics.commands." of the program "robotics".
        commands: The commands in the order of the help, with blanks between; or such lists by their headings, of which
            "more" only names its commands; an empty one keeps the place of a heading for the commands of plug-ins. The
            module of each has a function of the command's name, with an underscore behind it where Python has that name
            already, or a group of commands. Empty for a group whose commands are registered where it is made.
        version: Gives what the option --version prints; without, there is no such option.
    """
    by_heading = {"commands": commands or ""} if commands is None or isinstance(commands, str) else commands
    own = {name: heading for heading, names in by_heading.items() for name in names.split()}
    about = {"program": program, "modules": modules or f"{program}.commands.", "own": own, "headings": (*by_heading,)}
    app = Application(
        cls=type("Commands", (CommandGroup,), about) if own else None,
        help="\n  ".join((f"{purpose}\n\n\b\nExample:", *examples)),
        rich_markup_mode=None,
        pretty_exceptions_enable=False,
        no_args_is_help=True,
        context_settings={"help_option_names": ["-h", "--help"]},
    )
    if commands is not None:  # of a group of one command its name is asked for too
        app.callback()(_version_option(version) if version is not None else lambda: None)
    return app


def _version_option(version: Callable[[], str]) -> Callable[..., None]:
    def say(wanted: bool) -> None:
        if wanted:
            print(version())
            raise typer.Exit

    def options(
        version: Annotated[
            bool, typer.Option("--version", callback=say, is_eager=True, help="Print the versions and stop.")
        ] = False,
    ) -> None:
        pass

    return options


def versions_with(library: str) -> str:
    """The versions of this package, of a library that it computes with, and of Python, in a line."""
    from importlib.metadata import distributions, version

    python = ".".join(map(str, sys.version_info[:3]))
    found = next((each.version for each in distributions(name=library)), "is not installed")
    return f"fuzzyfleet {version('fuzzyfleet')} ({library} {found}, Python {python})"


def run(app: typer.Typer, prog_name: str = "", arguments: Sequence[str] | None = None) -> int:
    """Run a command line and return the exit code.

    The code is 0 for success, 1 for what a command says with ``raise typer.Exit(1)``, 2 for an error of usage, an
    InputError or an OSError (one message on stderr), 130 for Ctrl-C, 143 for SIGTERM, 141 for a reader that left.
    A UserWarning becomes one line on stderr, once. Any other exception is a bug and passes through.

    Args:
        app: The command line.
        prog_name: The name in messages, by default that of the process.
        arguments: The arguments, by default those of the process.
    """
    for stream in (sys.stdout, sys.stderr):
        # A terminal that cannot show a character gets an escape, not an exception.
        with contextlib.suppress(AttributeError, ValueError):
            stream.reconfigure(errors="backslashreplace")  # type: ignore[union-attr]
    words = sys.argv[1:] if arguments is None else arguments
    notice.watch(sys.stderr.isatty() and not {"-q", "--quiet"}.intersection(words))
    with answered(prog_name), _warnings_as_lines():
        try:
            return _ended(app, prog_name, arguments)
        except BrokenPipeError:
            _drop_output()
            return BROKEN_PIPE
        finally:
            notice.watch(False)


def _ended(app: typer.Typer, prog_name: str, arguments: Sequence[str] | None) -> int:
    """How a command line ended: its exit code, and the one message where there is one to say."""
    try:
        result = typer.main.get_command(app).main(
            args=None if arguments is None else list(arguments), prog_name=prog_name, standalone_mode=False
        )
        sys.stdout.flush()
        if result == INTERRUPTED and not is_told():  # typer's own answer to an interrupt
            return _interrupted()
        return result if isinstance(result, int) else OK
    except (typer.Abort, KeyboardInterrupt):
        return _interrupted()
    except SystemExit as stop:
        # Commands leave by typer.Exit: this is typer's own answer to a broken pipe.
        if isinstance(stop.__context__, BrokenPipeError):
            raise stop.__context__ from None
        return stop.code if isinstance(stop.code, int) else USAGE
    except _ClickError as error:
        if type(error).__name__ == "NoArgsIsHelpError":  # a program alone, or a group: its message is the help
            return _say("", error.format_message())  # type: ignore[attr-defined]
        context = getattr(error, "ctx", None)
        path = context.command_path if context is not None else prog_name
        said = _in_our_words(error.format_message())  # type: ignore[attr-defined]
        return _say(path, f"{said}\n(try '{path} --help')")
    except BrokenPipeError:
        raise
    except OSError as error:
        if of_interrupt(error):
            return _interrupted()
        # Files that cannot be written say their names: what is left is what was printed.
        printed = error.filename is None and error.errno in (errno.ENOSPC, errno.EFBIG, errno.EIO)
        place = "standard output: " if printed else f"{error.filename}: " if error.filename is not None else ""
        if printed:
            _drop_output()
        return _say(prog_name, place + (error.strerror or str(error)))
    except InputError as error:
        return _say(prog_name, str(error))
    except Exception as error:
        if of_interrupt(error):
            return _interrupted()
        raise


def _interrupted() -> int:
    with contextlib.suppress(typer.Exit):
        interrupted()
    return exit_code()


def print_json(value: Any) -> None:
    """Print ``value`` as one JSON document on stdout; not-a-number and infinity, which JSON lacks, are null."""
    print(json.dumps(plain(value), ensure_ascii=False))


def plain(value: Any) -> Any:
    """``value`` in JSON's types: arrays become lists, numbers that are not finite None."""
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


# What the libraries of command lines say of a value, and what we say of it
_WORDS = (
    (r"^Invalid value for '([^']*)': ", r"\1: "),
    (r"^Invalid value: ", ""),
    (r"(Value|Assertion) error, ", ""),
    (r"Input should be greater than or equal to ", "must be >= "),
    (r"Input should be less than or equal to ", "must be <= "),
    (r"Input should be greater than ", "must be > "),
    (r"Input should be less than ", "must be < "),
    (r"Input should be a valid integer.*", "must be a whole number"),
    (r"Input should be a valid number.*", "must be a number"),
    (r"Input should be a finite number", "must be a finite number"),
)


def _in_our_words(message: str) -> str:
    for theirs, ours in _WORDS:
        message = re.sub(theirs, ours, message, count=1)
    if chosen := re.search(r"'([^']*)' is not one of ('.*')\.$", message):
        hint = did_you_mean(chosen[1], re.findall("'([^']*)'", chosen[2]))
        message = message[:-1] + hint if hint else message
    return message


def _say(name: str, message: str) -> int:
    print(f"{name}: {message}" if name else message, file=sys.stderr)
    return USAGE


def _drop_output() -> None:
    # What is still buffered goes nowhere, instead of failing once more when Python closes the stream.
    with contextlib.suppress(OSError, ValueError, AttributeError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.__stdout__.fileno())  # type: ignore[union-attr]


@contextlib.contextmanager
def _warnings_as_lines() -> Iterator[None]:
    said: set[str] = set()

    def show(message: Warning | str, *_: Any, **__: Any) -> None:
        line = " ".join(str(message).split())
        if line not in said:
            said.add(line)
            print(f"warning: {line}", file=sys.stderr)

    with warnings.catch_warnings():
        warnings.simplefilter("always", UserWarning)
        warnings.showwarning = show
        yield
