"""New designs: what they can begin with, as the page's dialog "New from" shows and makes it.

Files are read, and systems made, in other processes: see :class:`Starting`.
"""

import asyncio
import warnings
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple, cast

import numpy as np

from fuzzy.errors import InputError
from fuzzy.files.table import open_table
from fuzzy.plugins.designer.folder import FolderError, check_size
from fuzzy.plugins.designer.longtask import EVERY, Report, TaskProcess
from fuzzy.plugins.designer.open_documents import OpenDocuments
from fuzzy.plugins.designer.starts.catalogue import Catalogue, find_starts
from fuzzy.plugins.designer.starts.samples import TABLE_OPTIONS, read_samples
from fuzzy.plugins.designer.starts.start import File, Start, StartError
from fuzzy.plugins.designer.views import numbers, rounded_for, surface_data
from fuzzy.plugins.designer.workers import WorkError
from fuzzy.shown import shown, typeset
from fuzzy.system import Sugeno

_POINTS = 21  # of a small picture, along each axis
_LONGEST = 600.0  # s that a start which reports may work


class MadeSystem(NamedTuple):
    """A system that a start made."""

    fis: Sugeno
    warnings: tuple[str, ...]  # sentences


class Starting:
    """The dialog of one browser tab. ``send`` takes messages to its page; each has one key that says what it is."""

    def __init__(self, opened: OpenDocuments, send: Callable[[dict[str, Any]], None]) -> None:
        self._opened, self._send = opened, send
        self._found: Catalogue | None = None
        self._making: asyncio.Task[MadeSystem] | None = None

    async def _do_starts(self, _: Mapping[str, Any]) -> None:
        """Tell the starts and the folder's tables, and then their pictures."""
        found = self._catalogue()
        about = {
            "list": [start.described() for start in found.starts],
            "unusable": list(found.unusable),
            "tables": self._opened.folder.files(".csv"),
        }
        self._send({"starts": about})
        names = [start.name for start in found.starts]
        # A few at a time, so that the first are there soon.
        for k in range(0, len(names), 6):
            with suppress(InputError, WorkError):
                self._send({"start_pictures": await self._opened.workers.run(pictures, names[k : k + 6])})

    async def _do_start_columns(self, content: Mapping[str, Any]) -> None:
        """Tell the columns of a table of the folder: ``file``."""
        name = content.get("file")
        try:
            path = self._table(name)
            self._send(
                {"start_columns": {"file": name, "columns": await self._opened.reading(str(name), columns, path)}}
            )
        except (InputError, WorkError) as error:
            self._send(
                {
                    "start_columns": {
                        "file": name,
                        "columns": [],
                        "problem": self._said(error),
                    }
                }
            )

    async def _do_start_make(self, content: Mapping[str, Any]) -> None:
        """Make a new design: ``start``, ``options`` by name, ``name`` of the new file. It opens as unsaved work."""
        if self._making is not None:
            raise InputError("a new design is being made already")
        try:
            name = self._opened.folder.name(self._opened.folder.inside(str(content.get("name") or "")))
            start = self._catalogue().start(str(content.get("start")))
            given = self._given(start, content.get("options"))
            self._making = asyncio.ensure_future(self._made(start, given, name))
            made = await self._making
            document = self._opened.begun(name, made.fis)
            document.notes += tuple(f"{warning}" for warning in made.warnings)
            document.table = next((Path(given[o.name]).name for o in start.options if isinstance(o, File)), "")
            self._send({"begun": name})
        except asyncio.CancelledError:
            self._send({"start_refused": "It was stopped; nothing was made."})
        except (InputError, WorkError, OSError) as error:
            self._send({"start_refused": self._said(error)})
        finally:
            self._making = None

    def _do_start_stop(self, _: Mapping[str, Any]) -> None:
        self.stop()

    def stop(self) -> None:
        """End what is being made."""
        if self._making is not None:
            self._making.cancel()

    def _said(self, error: Exception) -> str:
        return typeset(self._opened.folder.without_place(str(error)))

    def _catalogue(self) -> Catalogue:
        if self._found is None:
            self._found = find_starts()
        return self._found

    def _table(self, name: Any) -> Path:
        path = self._opened.folder.inside(name if isinstance(name, str) else "", ".csv")
        if not path.is_file():
            raise FolderError(f"there is no file {name!r} in the opened folder")
        check_size(path, str(name))
        return path

    def _given(self, start: Start, options: Any) -> dict[str, Any]:
        """The options, with paths inside the folder for files."""
        if not isinstance(options, Mapping):
            raise StartError("the options of a start are a mapping")
        files = {option.name for option in start.options if isinstance(option, File)}
        return {str(key): str(self._table(value)) if key in files else value for key, value in options.items()}

    async def _made(self, start: Start, given: dict[str, Any], name: str) -> MadeSystem:
        stem = Path(name).stem
        if not start.reports:
            return await self._opened.reading(name, make, start.name, given, stem)
        process = TaskProcess((start.name, given, stem), report_making, "making of the design")
        try:
            async with asyncio.timeout(_LONGEST):
                while True:
                    for what, about in process.news():
                        if what == "done":
                            return cast(MadeSystem, about)
                        if what == "problem":
                            raise InputError(about["message"])
                        self._send({"start_progress": {"share": about[0], "said": about[1]}})
                    await asyncio.sleep(EVERY)
        except TimeoutError:
            raise InputError(f"{start.title} took longer than {_LONGEST:g} s and was given up") from None
        finally:
            process.close()


def pictures(names: list[str]) -> dict[str, dict[str, Any] | None]:
    """A small picture of what each of these starts makes, see :func:`picture`; None where there is none."""
    found: dict[str, dict[str, Any] | None] = {}
    known = {start.name: start for start in find_starts().starts}
    for name in names:
        start = known[name]
        try:
            with warnings.catch_warnings(), np.errstate(all="ignore"):
                warnings.simplefilter("ignore")
                found[name] = picture(start.example() if start.example is not None else start.made({}, name))
        except Exception:  # a stranger's code; without a picture it can be chosen all the same
            found[name] = None
    return found


def picture(fis: Sugeno) -> dict[str, Any]:
    """What shows a system best in a small picture: ``surface`` of the output that changes most over its range.

    Where none changes: ``curves``, the degrees (terms, points) of the first input's terms over its range.
    """
    surfaces = [surface_data(fis, output=j, points=_POINTS) for j in range(len(fis.outputs))]
    changes = [(s["high"] - s["low"]) / (v.span or 1.0) for s, v in zip(surfaces, fis.outputs, strict=True)]
    most = int(np.argmax(changes))
    if changes[most] > 1e-6 and np.any(surfaces[most]["fired"]):
        return {"surface": small(surfaces[most])}
    first = fis.inputs[0]
    x = np.linspace(*first.universe, 4 * _POINTS)
    return {"curves": [np.round(term(x), 3).tolist() for term in first.terms.values()]}


def small(surface: dict[str, Any]) -> dict[str, Any]:
    """A surface with fewer digits, which no small picture shows."""
    z = rounded_for(np.array(surface["z"], dtype=float), surface["high"] - surface["low"])
    return surface | {"z": numbers(z)}


def columns(path: Path) -> list[dict[str, Any]]:
    """The columns of a table: their ``title`` and whether they hold numbers (``usable``). Raises DataError."""
    text = open_table(path)
    numbers = np.isfinite(text.all_columns().values).any(axis=0).tolist()
    return [
        {"title": column.title or column.name, "usable": bool(some and column.title)}
        for column, some in zip(text.columns, numbers, strict=True)
    ]


def make(start: str, given: Mapping[str, Any], stem: str, report: Any = lambda share, said: None) -> MadeSystem:
    """Make the system of the start of that name, with the sentences that were warned of. Raises InputError."""
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        chosen = find_starts().start(start)
        fis = chosen.made(given, stem, report)
        fit = _fit(fis, given) if TABLE_OPTIONS[0] in chosen.options else ""
    said = dict.fromkeys(str(w.message) for w in warned if issubclass(w.category, UserWarning))
    return MadeSystem(fis, (*said, fit) if fit else tuple(said))


def _fit(fis: Sugeno, given: Mapping[str, Any]) -> str:
    """How far the system is off on the rows that it was made from."""
    x, y, _ = read_samples(*(given.get(o.name, getattr(o, "value", "")) for o in TABLE_OPTIONS))
    off = np.sqrt(np.mean((fis(x) - y) ** 2, axis=0))
    errors = ", ".join(
        f"{shown(float(error))}{f' {v.unit}' if v.unit else ''} in {v.name}"
        for error, v in zip(off, fis.outputs, strict=True)
    )
    return f"RMSE {errors}, on the {len(x):,} rows of {Path(given['file']).name} that it was made from"


def report_making(given: tuple[str, dict[str, Any], str], report: Report) -> MadeSystem:
    """Make a system as :func:`make` does, and tell ("progress", (share, said)): a stranger's code, which may fail."""
    try:
        return make(*given, lambda share, said: report("progress", (share, said)))
    except (InputError, ConnectionError):
        raise
    except Exception as error:
        raise InputError(f"{type(error).__name__}: {error}") from None
