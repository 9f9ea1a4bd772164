"""Packaged rule bases, scenarios and robots, copied by name into a folder of one's own to be changed there.

A packaged file refers to no other file, and a copy is the original byte for byte: it runs as the original does.
"""

import shlex
from collections.abc import Iterable, Sequence
from contextlib import ExitStack
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from fuzzy.errors import InputError
from fuzzy.files.atomic import replacing
from fuzzy.naming import expected
from robotics.laws.catalogue import gains_of, make_controller, presets
from robotics.laws.tracking.fuzzy_tracking import rule_base_files
from robotics.simulation.scenario.reading import scenario_file, scenario_names
from robotics.simulation.scenario.robots import robot_file, robot_names


class CopyError(InputError):
    """A name that nothing packaged has, or that two things have, or a file that stands in the way."""


class Original(NamedTuple):
    """A packaged file."""

    name: str
    file: Path
    place: Path  # of its copy, relative to the folder of the copies


class Copied(NamedTuple):
    """A copy, and the command by which it is used."""

    name: str
    file: Path
    use: str


def copy_packaged(names: Iterable[str], folder: Path = Path(), force: bool = False) -> list[Copied]:
    """Copy packaged rule bases, scenarios and robots into ``folder``, which is made if need be: all of them or none.

    Args:
        names: Names of rule bases (``tracking``, also ``tracking.fis``), of folders of them (``formation``), of
            scenarios (``three-cross``, also ``three-cross.toml``) and of robots (``etsro``, also ``etsro.toml``); an
            old name of a scenario copies the present one.
        folder: Where the copies go: ``tracking.fis``, ``formation/v_l.fis``, ``three-cross.toml``.
        force: Whether files that are there already are overwritten, all but the packaged ones themselves.

    Raises CopyError, and OSError where a file cannot be written.
    """
    rule_bases = rule_base_files()
    originals = list(dict.fromkeys(o for name in names for o in _originals(name, rule_bases, _files())))
    targets = {o: folder / o.place for o in originals}
    for original, target in targets.items():
        if target.exists() and target.samefile(original.file):
            raise CopyError(f"{target} is the packaged file itself: copy it into another folder with --to")
    present = [str(target) for target in targets.values() if target.exists()]
    if present and not force:
        verb = "exists" if len(present) == 1 else "exist"
        raise CopyError(f"{', '.join(present)} {verb} already, nothing was copied; --force overwrites")
    with ExitStack() as stack:  # every copy is written before the first one takes its place
        for original, target in targets.items():
            target.parent.mkdir(parents=True, exist_ok=True)
            stack.enter_context(replacing(target)).write_bytes(original.file.read_bytes())
    return [Copied(original.name, target, _use(original, target)) for original, target in targets.items()]


def _files() -> dict[str, Path]:
    """The files of scenarios and robots, which share no name."""
    scenarios = {name: scenario_file(name).path for name in scenario_names()}
    return scenarios | {name: robot_file(name).path for name in robot_names()}


def _originals(name: str, rule_bases: dict[str, Path], tables: dict[str, Path]) -> list[Original]:
    """What ``name`` means: one file, or all rule bases of a folder."""
    name = name.rstrip("/")
    suffix = Path(name).suffix if Path(name).suffix in (".fis", ".toml") else ""
    bare = name.removesuffix(suffix)
    found = []
    if suffix != ".toml":
        inside = [each for each in rule_bases if each == bare or (not suffix and each.startswith(f"{bare}/"))]
        found.append([Original(each, rule_bases[each], Path(f"{each}.fis")) for each in inside])
    if suffix != ".fis" and bare in tables:
        found.append([Original(bare, tables[bare], Path(f"{bare}.toml"))])
    meant = [originals for originals in found if originals]
    if not meant:
        raise CopyError(expected(name, _names(rule_bases, tables), "rule base, scenario or robot"))
    if len(meant) > 1:
        raise CopyError(
            f"{name!r} is a rule base and a {tables[bare].parent.name[:-1]}: write {name}.fis or {name}.toml"
        )
    return meant[0]


def _names(rule_bases: dict[str, Path], tables: dict[str, Path]) -> Sequence[str]:
    folders = {each.rpartition("/")[0] for each in rule_bases if "/" in each}
    return [*rule_bases, *sorted(folders), *tables]


def _use(original: Original, target: Path) -> str:
    """The command that uses a copy; of a rule base: with the first controller that has it, or its folder, as a gain."""
    if original.file.parent.name == "robots":
        return f"robotics robot {shlex.quote(str(target))}"
    if target.suffix == ".toml":
        return f"robotics run {shlex.quote(str(target))}"
    values = {original.name: str(target)}
    if {each.name for each in original.file.parent.iterdir()} <= {each.name for each in target.parent.iterdir()}:
        values[original.name.rpartition("/")[0]] = f"{target.parent.as_posix()}/"  # the folder, with all that it needs
    for controller, gain, value in _gains():
        if value and value in values:
            return f"robotics run my.toml --controller {shlex.quote(f'{controller}:{gain}={values[value]}')}"
    return f"fuzzy show {shlex.quote(str(target))}"


@cache
def _gains() -> list[tuple[str, str, Any]]:
    """Every controller of the catalogue with each of its gains and the gain's value."""
    return [(name, *gain) for name in presets() for gain in gains_of(make_controller(name)).items()]
