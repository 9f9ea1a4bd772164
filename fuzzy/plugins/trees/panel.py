"""The designer's panel "Tree": the tree to which the file belongs, and what it answers with the design in its place.

It is the tree of the tree.toml beside the file; each system is edited as a file of its own.
"""

import io
import warnings
from pathlib import Path
from typing import Any

from fuzzy.files.fisfile import format_fis, parse_fis
from fuzzy.naming import check_known
from fuzzy.plugins.designer.folder import Folder, check_size
from fuzzy.plugins.designer.panel import SessionPanel
from fuzzy.plugins.designer.session import PanelSession
from fuzzy.plugins.designer.views import numbers, variable_data
from fuzzy.plugins.trees.files import TREE_FILE, tree_of
from fuzzy.plugins.trees.tree import TreeError

_MODULE = Path(__file__).parent / "static" / "systems.js"


def shown_tree(folder: Path, name: str, design: str, point: dict[str, float]) -> dict[str, Any]:
    """The traits of the page, in JSON's types.

    Args:
        folder: The opened folder; nothing outside it is read.
        name: The design's file, as the folder names it.
        design: The design, the text of a .fis file, in the place of the file.
        point: Values of the tree's inputs by their names, where they are not the middle of the universe.

    Raises TreeError where the file belongs to no tree, FolderError and FisFileError as the reading does.
    """
    from fuzzy.figures.drawing import style
    from fuzzy.plugins.trees.figures import plot_tree

    opened, files = Folder(folder), list[str]()
    above = Path(name).parent

    def read(at: str) -> Any:
        files.append((above / at).as_posix())
        return parse_fis(design) if files[-1] == name else opened.read(files[-1])

    file = opened.path / above / TREE_FILE
    if not file.is_file() or file.is_symlink():
        raise TreeError(f"{name} belongs to no tree: there is no {TREE_FILE} beside it, as fuzzy.Tree.write makes it")
    check_size(file, TREE_FILE)
    tree = tree_of(file, read)
    if name not in files:
        raise TreeError(f"{name} belongs to no tree: {TREE_FILE} beside it names {', '.join(files)}")
    at = {v.name: point.get(v.name, v.midrange) for v in tree.inputs}
    with warnings.catch_warnings(action="ignore"):
        output = tree([at[v.name] for v in tree.inputs])
    drawn = io.BytesIO()
    with style():
        plot_tree(tree).savefig(drawn, format="svg", metadata={"Date": None})
    return {
        "picture": drawn.getvalue().decode(),
        "systems": [
            {"name": system, "file": of, "rules": len(fis.rules), "here": of == name}
            for (system, fis), of in zip(tree.systems.items(), files, strict=True)
        ],
        "inputs": [variable_data(v) | {"terms": [], "value": at[v.name]} for v in tree.inputs],
        "outputs": [
            variable_data(v) | {"terms": [], "value": value}
            for v, value in zip(tree.outputs, numbers(output), strict=True)
        ],
    }


class TreeSession(PanelSession):
    """The panel on one page."""

    error = TreeError

    def __init__(self, bench: Any) -> None:
        super().__init__(bench)
        self.point: dict[str, float] = {}
        self.known: list[str] = []  # the tree's inputs
        self.asked = 0
        self.put(_MODULE, picture="", systems=[], inputs=[], outputs=[])
        self.heard({"do": "draw"})

    async def changed(self) -> None:
        """Draw it, with the design in its place, unless something else has been asked for meanwhile."""
        self.asked += 1
        asked, name = self.asked, self.folder.name(self.bench.document.path)
        text = format_fis(self.present)
        try:
            found = await self.bench.read(name, shown_tree, self.folder.path, name, text, dict(self.point))
        except self.refusals as error:
            self.refuse(error, {"do": "draw"})
            return
        if asked == self.asked:
            self.known = [v["name"] for v in found["inputs"]]
            self.widget.update(problem=None, **found)

    def _do_draw(self, message: dict[str, Any]) -> Any:
        return self.changed()

    def _do_point(self, message: dict[str, Any]) -> Any:
        """Ask the tree at another value of one of its inputs."""
        value = message.get("value")
        name = check_known(message.get("name"), self.known, "input", TreeError)
        if not isinstance(value, (int, float)) or value != value:
            raise TreeError(f"{name}: a number is needed")
        self.point[name] = float(value)
        return self.changed()


def _is_of_a_tree(file: Path) -> bool:
    return (file.parent / TREE_FILE).is_file()


panel = SessionPanel("Tree", 90, TreeSession, purpose="tree", belongs=_is_of_a_tree)
