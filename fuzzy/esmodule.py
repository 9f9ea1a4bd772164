"""Widgets of notebooks: several ES modules as the text of one, which is what a notebook loads, and a picture beside it.

This replaces a build step. The forms of import and export that modules may use are checked; any other raises an error.
"""

import contextlib
import re
from base64 import b64encode
from collections.abc import Callable
from pathlib import Path
from typing import Any

from fuzzy.errors import InputError
from fuzzy.extras import install_command


class ModuleError(InputError):
    """A module that cannot be composed into one text."""


_IMPORT = re.compile(r'^import\s+(?:\{([^}]*)\}|(\w+))\s+from\s+"(\.{1,2}/[^"]+)";[^\S\n]*(?://.*)?$', re.M)
_DEFAULT = re.compile(r"^export\s+default\s+", re.M)
_NAMED = re.compile(r"^export\s+(?=(?:async\s+)?function\*?\s+(\w+)|(?:const|let|class)\s+(\w+))", re.M)
_LIST = re.compile(r"^export\s+\{([^}]*)\};?[^\S\n]*$", re.M)
_LEFT = re.compile(r"^\s*(?:import|export)\b(?!\s*\().*$|\bimport\s*\(.*$", re.M)


def composed(entry: Path, rest: str = "export default entry.default;") -> str:
    """The text of one module that holds the module in the file ``entry`` and all that it imports.

    Each file becomes a function that gives its exports, after those that it imports. ``rest`` ends the text; there
    ``entry`` is the object of the entry's exports. Raises ModuleError for a form of import or export that is not
    known here.
    """
    names: dict[Path, str] = {}
    parts: list[str] = []
    _add(entry.resolve(), names, parts, ())
    return "\n".join([*parts, f"const entry = {names[entry.resolve()]};", rest]) + "\n"


def _add(path: Path, names: dict[Path, str], parts: list[str], above: tuple[Path, ...]) -> None:
    if path in names:
        return
    if path in above:
        raise ModuleError(f"{path.name}: modules that import each other cannot be composed")
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise ModuleError(f"{path.name}: {error.strerror}") from None

    def imported(match: re.Match[str]) -> str:
        wanted = (path.parent / match[3]).resolve()
        _add(wanted, names, parts, (*above, path))
        if match[2]:
            return f"const {match[2]} = {names[wanted]}.default;"
        return f"const {{ {_renamed(match[1], ' as ', ': ')} }} = {names[wanted]};"

    exports: list[str] = []

    def listed(match: re.Match[str]) -> str:
        for item in (part.strip() for part in match[1].split(",")):
            if item:
                inner, _, outer = item.partition(" as ")
                exports.append(f"{outer.strip() or inner.strip()}: {inner.strip()}")
        return ""

    def named(match: re.Match[str]) -> str:
        exports.append(match[1] or match[2])
        return ""

    text = _IMPORT.sub(imported, text)
    text = _LIST.sub(listed, text)
    text = _NAMED.sub(named, text)
    text, defaults = _DEFAULT.subn("const exportedByDefault = ", text)
    if defaults:
        exports.append("default: exportedByDefault")
    left = _LEFT.search(text)
    if left or defaults > 1:
        shown = left[0].strip() if left else "a second default export"
        raise ModuleError(f'{path.name}: {shown[:80]!r} cannot be composed; write `import {{ a }} from "./b.js";`')
    names[path] = f"module{len(names) + 1}"
    body = text.rstrip()
    parts.append(f"const {names[path]} = (() => {{ // {path.name}\n{body}\nreturn {{ {', '.join(exports)} }};\n}})();")


def _renamed(items: str, before: str, after: str) -> str:
    return ", ".join(item.strip().replace(before, after) for item in items.split(",") if item.strip())


def widget_library() -> tuple[Any, Any]:
    """The modules anywidget and traitlets. Raises ModuleError without the extra ``notebook``."""
    try:
        import anywidget
        import traitlets
    except ImportError:
        raise ModuleError(f"a notebook's widgets need anywidget: {install_command('notebook')}") from None
    return anywidget, traitlets


def with_still(bundle: Any, shown: str, draw: Callable[[], bytes]) -> tuple[dict[str, Any], dict[str, Any]] | None:
    """What a notebook keeps of a widget: beside the widget itself a sentence and a picture, for where nothing runs.

    Args:
        bundle: What the widget says of itself, by MIME type; None where it is not to be shown.
        shown: The sentence.
        draw: Gives the picture, as the bytes of a .png file; where it raises an InputError there is none.
    """
    if bundle is None:
        return None
    data, about = bundle if isinstance(bundle, tuple) else (bundle, {})
    data = {**data, "text/plain": shown}
    with contextlib.suppress(InputError):  # there is nothing to draw
        data["image/png"] = b64encode(draw()).decode("ascii")
    return data, about
