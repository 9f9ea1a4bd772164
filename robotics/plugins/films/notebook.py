"""The player of a run as a widget for notebooks, with the module of the page (:mod:`robotics.show.playback.player`)."""

from functools import partial
from pathlib import Path
from typing import Any

from fuzzy.esmodule import composed, widget_library, with_still
from fuzzy.figures.palette import stylesheet
from robotics.plugins.films.animation import still
from robotics.show import playback
from robotics.show.playback.player import player_data
from robotics.simulation.run import Run


def player(run: Run, seed: int | None = None, *, speed: float = 1.0, **options: Any) -> Any:
    """Make a widget that plays one seed of a run in Jupyter, marimo and the like.

    Its ``time`` [s] is the time that is shown: it changes as the player plays or is dragged, and may be set.

    Args:
        run: The run.
        seed: The seed that is shown, by default the first.
        speed: Times real time, with which it begins.
        options: ``start``, ``end`` and ``stale``, as in :func:`robotics.show.playback.player.player_data`.

    Returns:
        The widget.

    Raises:
        ReplayError: A seed that was not run.
        ModuleError: The extra ``notebook`` is not installed.
    """
    anywidget, traitlets = widget_library()
    folder = Path(playback.__file__).parent / "static"

    class Player(anywidget.AnyWidget):  # type: ignore[name-defined]
        """The player of one run."""

        _esm = composed(folder / "notebook.js")
        _css = stylesheet() + (folder / "player.css").read_text(encoding="utf-8")
        run = traitlets.Dict().tag(sync=True)
        speed = traitlets.Float(1.0).tag(sync=True)
        time = traitlets.Float(0.0).tag(sync=True)  # s: what is shown; it follows the player, and the player follows it
        page = traitlets.Bool(False).tag(sync=True)

        def _repr_mimebundle_(self, **kwargs: Any) -> tuple[dict[str, Any], dict[str, Any]] | None:
            shown = f"Player of {self.run['title']}"
            return with_still(super()._repr_mimebundle_(**kwargs), shown, partial(still, run, seed, **options))

    data = player_data(run, seed, **options)
    return Player(run=data, speed=float(speed), time=float(options.get("start") or run.time[0]))
