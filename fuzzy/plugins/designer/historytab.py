"""The drawer History: named snapshots of the design, and the edits that can be undone or made again."""

import re
from collections.abc import Callable, Mapping
from datetime import datetime
from pathlib import Path
from typing import Any

from nicegui import background_tasks

from fuzzy.errors import InputError
from fuzzy.plugins.designer import snapshots
from fuzzy.plugins.designer.bridge import Bridge
from fuzzy.plugins.designer.design import Design, file_text
from fuzzy.plugins.designer.document import Document
from fuzzy.plugins.designer.panel import Workbench
from fuzzy.plugins.designer.session import act_of
from fuzzy.plugins.designer.snapshots import Listing
from fuzzy.plugins.designer.views import or_none, surface_data
from fuzzy.plugins.designer.workers import WorkError
from fuzzy.plugins.type2.system import Type2Sugeno
from fuzzy.system import Sugeno

_MODULE = Path(__file__).parent / "static" / "history.js"
_UNSAFE = re.compile(r"[^\w.-]+")


def history_data(document: Document) -> dict[str, Any]:
    """The trait ``history``: the edits, the oldest first, ``when`` in ms since 1970; are older ones gone?"""
    edits = [edit._asdict() | {"when": _milliseconds(edit.when)} for edit in document.history]
    return {"edits": edits, "forgotten": document.forgotten}


def listing_data(listing: Listing) -> dict[str, Any]:
    """The trait ``snapshots``: those that are kept, the newest first, sentences on damaged files, and the limits."""
    kept = [snapshot._asdict() | {"when": _milliseconds(snapshot.when)} for snapshot in listing.snapshots]
    return {
        "kept": kept,
        "problems": list(listing.problems),
        "most": snapshots.MOST_SNAPSHOTS,
        "longest": snapshots.LONGEST_NAME,
    }


class HistoryTab:
    """The tab on one page.

    Args:
        bench: The page's workbench.
        compare: Shows a system of this name beside the design, or None.
        download: Gives the browser a text as a file of this name.
    """

    def __init__(
        self,
        bench: Workbench,
        compare: Callable[[str | None, Sugeno | Type2Sugeno | None], None],
        download: Callable[[str, str], None],
    ) -> None:
        self._bench, self._document = bench, bench.document
        self._compare, self._download = compare, download
        self._bridge: Bridge | None = None
        self._listing: dict[str, Any] | None = None
        self._listed: Any = None  # the state of the folder that the listing shows
        # The snapshot that was compared with here last, by its key
        self._compared: tuple[str, Sugeno | Type2Sugeno] | None = None
        self._removed: dict[str, Any] | None = None  # the snapshot that can be brought back

    def build(self) -> None:
        """Put the tab on the page."""
        self._bridge = self._bench.widget(_MODULE, **self._traits())
        self._bridge.on_message(self._heard)
        self._bench.on_change(self._show)
        background_tasks.create(self._show())

    def take(self, name: Any = None) -> str:
        """Keep the design as a snapshot; its name, by default the time and the last edit. Raises InputError."""
        document = self._document
        if not isinstance(name, str) or not name.strip():
            words = f"{datetime.now():%H:%M:%S}, {document.can_undo or 'as opened'}"
            name = "".join(c for c in words if c.isprintable())[: snapshots.LONGEST_NAME]
        snapshots.keep(document.path, document.design, name, _picture(document.design))
        document.announce()
        return " ".join(name.split())

    def _traits(self) -> dict[str, Any]:
        chosen = self._compared
        return {
            "history": history_data(self._document),
            "snapshots": self._listing,
            "compared": chosen[0] if chosen is not None and self._document.compared is chosen[1] else None,
            "removed": self._removed,
        }

    async def _show(self) -> None:
        state = snapshots.state_of(self._document.path)
        if state != self._listed:
            await self._list(state)
        if self._bridge is not None and not self._bench.closed:
            self._bridge.update(**self._traits())

    async def _list(self, state: Any) -> None:
        try:
            listing = await self._bench.read("the list of snapshots", snapshots.listed, self._document.path)
        except (InputError, WorkError) as error:
            listing = Listing((), (str(error),))
        self._listed, self._listing = state, listing_data(listing)
        if self._removed is not None and any(s.key == self._removed["key"] for s in listing.snapshots):
            self._removed = None

    # What the module asks for ---------------------------------------------------------------------------------

    async def _heard(self, content: Any) -> None:
        if not isinstance(content, Mapping) or "snapshot" not in content:
            self._document.apply(content)
            return
        what = content["snapshot"]
        act = act_of(self, what)
        if act is None:
            raise InputError(f"the page asked for {str(what)[:40]!r} of a snapshot")
        try:
            result = act(content)
            if result is not None:
                await result
        except WorkError as error:
            raise InputError(f"snapshot: {error}") from None

    def _do_take(self, content: Mapping[str, Any]) -> None:
        self._bench.notify(f"the snapshot “{self.take(content.get('name'))}” is kept")

    async def _read(self, content: Mapping[str, Any]) -> tuple[str, Design]:
        return await self._bench.read("the snapshot", snapshots.read, self._document.path, content.get("key"))

    async def _do_open(self, content: Mapping[str, Any]) -> None:
        name, design = await self._read(content)
        if [line.text for line in design.lines] == [line.text for line in self._document.design.lines] and (
            file_text(design) == self._document.text()
        ):
            self._bench.notify(f"the design is what the snapshot “{name}” holds")
            return
        self._document.take(design, f"open the snapshot {name}")

    async def _do_compare(self, content: Mapping[str, Any]) -> None:
        if content.get("key") is None:
            self._compare(None, None)
            return
        name, design = await self._read(content)
        if not self._bench.closed:
            self._compared = content["key"], design.shown
            self._compare(name, design.shown)

    async def _do_download(self, content: Mapping[str, Any]) -> None:
        name, design = await self._read(content)
        if not self._bench.closed:
            words = _UNSAFE.sub("-", name).strip("-.")
            self._download(file_text(design), f"{self._document.path.stem}-{words or 'snapshot'}.fis")

    def _do_rename(self, content: Mapping[str, Any]) -> None:
        snapshots.rename(self._document.path, content.get("key"), content.get("name"))
        self._document.announce()

    def _do_remove(self, content: Mapping[str, Any]) -> None:
        key = content.get("key")
        snapshots.remove(self._document.path, key)
        kept = [] if self._listing is None else self._listing["kept"]
        self._removed = {"key": key, "name": next((s["name"] for s in kept if s["key"] == key), "")}
        self._document.announce()

    def _do_back(self, content: Mapping[str, Any]) -> None:
        self._removed = None
        try:
            snapshots.bring_back(self._document.path, content.get("key"))
        finally:
            self._document.announce()


def _picture(design: Design) -> dict[str, Any] | None:
    system = design.system
    surface = or_none(surface_data, design, points=snapshots.PICTURE)
    if surface is None:
        return None
    names = tuple(system.inputs[i].name for i in surface["inputs"])
    return snapshots.surface_picture(surface, names, system.outputs[0].name)


def _milliseconds(when: datetime) -> float:
    return round(when.timestamp() * 1000)
