"""Named snapshots of a design: FOLDER/.fuzzy-design/NAME.fis.snapshots, a file each, written whole or not at all.

Each stands alone: a file that is damaged costs one snapshot, and two designers do not overwrite each other's.
"""

import json
import os
import re
import secrets
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, NamedTuple

from fuzzy.files.atomic import write_whole
from fuzzy.plugins.designer.autosave import DAMAGED, FOLDER, MOST_UNSAVED, design_content, design_from
from fuzzy.plugins.designer.design import Design
from fuzzy.plugins.designer.folder import check_shown
from fuzzy.plugins.designer.saving import DocumentError
from fuzzy.system import sizes

MOST_SNAPSHOTS = 100  # snapshots of a file
LONGEST_NAME = 80  # characters of a name
PICTURE = 19  # points along each side of a picture
_FORMAT = 1
_KEY = re.compile(r"[0-9a-f]{16}")
_REMOVED = ".removed"  # behind the name of the one that was removed last, which can be brought back


class Snapshot(NamedTuple):
    """What a list shows of a snapshot."""

    key: str  # of its file
    name: str
    when: datetime
    picture: dict[str, Any] | None  # a control surface, see :func:`surface_picture`
    summary: str  # "2 inputs, 1 output, 9 rules"


class Listing(NamedTuple):
    """The snapshots of a file, the newest first, and a sentence on each file that holds none."""

    snapshots: tuple[Snapshot, ...]
    problems: tuple[str, ...]


def place_for(file: Path) -> Path:
    """The folder with the snapshots of ``file``."""
    return file.parent / FOLDER / f"{file.name}.snapshots"


def state_of(file: Path) -> tuple[str, int]:
    """What is another thing once the snapshots of ``file`` have changed."""
    folder = place_for(file)
    try:
        return str(folder), folder.stat().st_mtime_ns
    except OSError:
        return str(folder), 0


def keep(file: Path, design: Design, name: str, picture: dict[str, Any] | None = None) -> str:
    """Write a design as a snapshot of a .fis file, and give its key. Raises DocumentError where it cannot be kept.

    Args:
        file: The .fis file.
        design: The design.
        name: Its name.
        picture: What :func:`surface_picture` gives of it.
    """
    name, folder = _named(name), _folder(file)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        count = len(_files(folder))
    except OSError as error:
        raise DocumentError(f"the snapshot cannot be kept in {folder}: {error.strerror or error}") from None
    if count >= MOST_SNAPSHOTS:
        raise DocumentError(f"{file.name} has {count} snapshots, the most that are kept; remove one first")
    key = secrets.token_hex(8)
    content = {
        "format": _FORMAT,
        "name": name,
        "when": datetime.now(UTC).isoformat(),
        "summary": sizes(design.system),
        "picture": picture,
        **design_content(design),
    }
    _write(folder / f"{key}.json", content)
    return key


def _files(folder: Path) -> list[Path]:
    """The files of snapshots; what begins with a dot was being written when a process died."""
    return sorted(path for path in folder.iterdir() if path.suffix == ".json" and not path.name.startswith("."))


def listed(file: Path) -> Listing:
    """The snapshots of a .fis file, without their designs. Raises DocumentError for a folder that leads elsewhere."""
    folder = _folder(file)
    found: list[Snapshot] = []
    problems = []
    try:
        paths = _files(folder)
    except OSError:
        return Listing((), ())
    for path in paths[: 10 * MOST_SNAPSHOTS]:
        try:
            found.append(_shown(path.stem, _read(path)))
        except DAMAGED:
            problems.append(f"{FOLDER}/{folder.name}/{path.name} is damaged and is no snapshot; nothing else is lost")
    return Listing(tuple(sorted(found, key=lambda one: one.when, reverse=True)), tuple(problems))


def read(file: Path, key: Any) -> tuple[str, Design]:
    """The name and the design of a snapshot.

    Raises DocumentError where there is none or it is damaged, FolderError for a system that a page cannot show.
    """
    path = _place(file, key)
    try:
        content = _read(path)
        name, design = str(content["name"]), design_from(content)
    except FileNotFoundError:
        raise DocumentError("there is no such snapshot; it may have been removed meanwhile") from None
    except DAMAGED:
        raise DocumentError(f"{path} is damaged and is no snapshot") from None
    check_shown(design.system, f"the snapshot {name}")
    return name, design


def rename(file: Path, key: Any, name: Any) -> None:
    """Give a snapshot another name. Raises DocumentError for a name that is none, or where it cannot be written."""
    path, name = _place(file, key), _named(name)
    try:
        content = _read(path)
    except DAMAGED:
        raise DocumentError("there is no such snapshot; it may have been removed meanwhile") from None
    _write(path, {**content, "name": name})


def remove(file: Path, key: Any) -> None:
    """Remove a snapshot; :func:`bring_back` undoes that until the next one is removed. Raises DocumentError."""
    path = _place(file, key)
    with suppress(OSError):
        for old in path.parent.glob(f"*{_REMOVED}"):
            old.unlink()
    _move(path, path.with_name(path.name + _REMOVED))


def bring_back(file: Path, key: Any) -> None:
    """Bring the snapshot back that was removed last. Raises DocumentError where another was removed since."""
    path = _place(file, key)
    _move(path.with_name(path.name + _REMOVED), path)


def surface_picture(surface: dict[str, Any], names: tuple[str, ...], output: str) -> dict[str, Any] | None:
    """The picture of a snapshot: a surface, as :func:`.views.surface_data` gives it, and what it shows.

    ``z`` is rounded to four digits; None where there is no surface.

    Args:
        surface: The surface, :data:`PICTURE` points along each side.
        names: The names of its inputs.
        output: The name of its output.
    """
    rows = surface["z"] if surface["y"] is not None else [surface["z"]]
    z = [[None if value is None else float(f"{value:.4g}") for value in row] for row in rows]
    return {"z": z, "shows": f"{output} over {' and '.join(names)}"}


def _named(name: Any) -> str:
    if not isinstance(name, str) or not name.strip():
        raise DocumentError("a snapshot has a name")
    name = " ".join(name.split())
    if len(name) > LONGEST_NAME or not name.isprintable():
        raise DocumentError(f"a snapshot's name has at most {LONGEST_NAME} printable characters")
    return name


def _folder(file: Path) -> Path:
    folder = place_for(file)
    if Path(os.path.realpath(folder)) != Path(os.path.realpath(file.parent)) / FOLDER / folder.name:
        raise DocumentError(f"{folder} leads elsewhere by a link; snapshots are neither read nor written there")
    return folder


def _place(file: Path, key: Any) -> Path:
    if not isinstance(key, str) or not _KEY.fullmatch(key):
        raise DocumentError("a snapshot is asked for by its key")
    return _folder(file) / f"{key}.json"


def _read(path: Path) -> dict[str, Any]:
    """The content of a snapshot's file. Raises one of DAMAGED."""
    if not _KEY.fullmatch(path.stem) or path.is_symlink() or path.stat().st_size > MOST_UNSAVED:
        raise FileNotFoundError(path)
    content: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    if content["format"] != _FORMAT:
        raise ValueError("another version's")
    return content


def _shown(key: str, content: dict[str, Any]) -> Snapshot:
    when = datetime.fromisoformat(content["when"]).astimezone()
    if not isinstance(content["system"], str) or not isinstance(content["rules"], list):
        raise ValueError("no design")
    return Snapshot(
        key, str(content["name"])[:LONGEST_NAME], when, _picture(content["picture"]), str(content["summary"])
    )


def _picture(picture: Any) -> dict[str, Any] | None:
    """The picture, if it is one: at most PICTURE rows of as many numbers, None where there is none."""
    if picture is None:
        return None
    rows = picture["z"]
    sizes = {len(row) for row in rows}
    numbers = all(value is None or type(value) in (int, float) for row in rows for value in row)
    if not numbers or not 0 < len(rows) <= PICTURE or len(sizes) != 1 or not 1 < max(sizes) <= PICTURE:
        raise ValueError("no picture")
    return {"z": rows, "shows": str(picture["shows"])}


def _write(path: Path, content: dict[str, Any]) -> None:
    try:
        write_whole(path, json.dumps(content, indent=1))
    except OSError as error:
        raise DocumentError(f"the snapshot cannot be kept in {path.parent}: {error.strerror or error}") from None


def _move(path: Path, to: Path) -> None:
    try:
        path.replace(to)
    except OSError:
        raise DocumentError("there is no such snapshot; it may have been removed meanwhile") from None
