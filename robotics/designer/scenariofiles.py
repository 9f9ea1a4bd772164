"""The scenario files of the folder that the designer serves; nothing outside it is read."""

import re
import tomllib
from pathlib import Path

from fuzzy.designer.folder import LARGEST_FILE, Folder, FolderError
from robotics.scenario.description import ScenarioError
from robotics.scenario.robots import robot_files

_ROBOTS = re.compile(rb"^\s*(\[\[\s*robots\s*\]\]|robots\s*=)", re.MULTILINE)  # what every scenario has


def scenario_files(folder: Folder) -> list[str]:
    """The names of the .toml files of the folder that describe robots, faulty ones too."""
    return [name for name in folder.files(".toml") if _is_scenario(folder.path / name)]


def _is_scenario(path: Path) -> bool:
    try:
        return path.stat().st_size <= LARGEST_FILE and _ROBOTS.search(path.read_bytes()) is not None
    except OSError:
        return False


def read_scenario_file(folder: Folder, name: str) -> str:
    """The text of a scenario file of the folder. Raises FolderError or ScenarioError.

    The files of robots that it names are in the folder, too.
    """
    path = folder.inside(name, ".toml")
    if not path.is_file():
        raise ScenarioError(f"there is no file {name!r} in the opened folder")
    try:
        text = checked_text(name, path.read_bytes())
    except OSError as error:
        raise ScenarioError(f"{name}: cannot be read: {error.strerror or error}") from None
    _check_robots(folder, name, text)
    return text


def _check_robots(folder: Folder, name: str, text: str) -> None:
    """Raise FolderError where a scenario names a robot's file outside the folder."""
    try:
        files = robot_files(tomllib.loads(text), (folder.path / name).parent)
    except ValueError:  # the reader of scenarios says it better
        return
    for said, path in files.items():
        if not path.resolve().is_relative_to(folder.path):
            raise FolderError(f"{name}: the file of a robot, {said!r}, leads out of the opened folder")


def checked_text(name: str, data: bytes) -> str:
    """The text in the bytes of a scenario file. Raises ScenarioError."""
    if len(data) > LARGEST_FILE:
        raise ScenarioError(f"{name} is larger than {LARGEST_FILE / 1e6:g} MB")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise ScenarioError(f"{name}: cannot be read: it is not UTF-8 text") from None


def changed_at(folder: Folder, name: str) -> tuple[int, int] | None:
    """When the file was changed last [ns], and its size [bytes]; None where there is none."""
    try:
        state = (folder.path / name).stat()
    except OSError:
        return None
    return state.st_mtime_ns, state.st_size
