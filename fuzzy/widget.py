"""What the widgets for notebooks share: the library that makes them, and what is kept of one where nothing runs."""

import contextlib
from base64 import b64encode
from collections.abc import Callable
from typing import Any

from fuzzy.errors import InputError
from fuzzy.esmodule import ModuleError
from fuzzy.extras import install_command


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


def widget_library() -> tuple[Any, Any]:
    """The modules anywidget and traitlets. Raises ModuleError without the extra ``notebook``."""
    try:
        import anywidget
        import traitlets
    except ImportError:
        raise ModuleError(f"a notebook's widgets need anywidget: {install_command('notebook')}") from None
    return anywidget, traitlets
