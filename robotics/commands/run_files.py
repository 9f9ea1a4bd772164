"""The files of a run: the run itself, its samples, its changes of mode, a picture, and a page that plays it."""

import warnings
from dataclasses import dataclass
from pathlib import Path

from fuzzy.errors import InputError
from fuzzy.files.table import write_frame
from robotics.playback.player import write_player
from robotics.simulation.mode_changes import mode_change_table
from robotics.simulation.run import Run

MOST_AGES = 100_000_000  # of messages that a run holds: 400 MB


class RunFileError(InputError):
    """A file name from which the kind of file cannot be told. The message says what it must end in."""


@dataclass(frozen=True, kw_only=True)
class RunFiles:
    """The files into which a run goes; None: not written. Raises an InputError for a name with a wrong ending."""

    save: Path | None = None  # .npz, without loss
    table: Path | None = None  # .csv, every sample
    events: Path | None = None  # .csv, who avoided, yielded or timed out, and when
    plot: Path | None = None  # .png, .pdf or .svg, of the first seed
    player: bool = False  # <scenario>-seed-<first seed>.html in the folder in which one is

    def __post_init__(self) -> None:
        if self.plot is not None:
            from fuzzy.figures.drawing import check_picture

            check_picture(self.plot)
        for path, suffix in ((self.save, ".npz"), (self.table, ".csv"), (self.events, ".csv")):
            if path is not None and path.suffix != suffix:
                raise RunFileError(f"{path}: the file's name must end in {suffix}")
        for path in (self.save, self.table, self.events, self.plot):  # before the run, not after it
            if path is not None and not path.parent.is_dir():
                raise RunFileError(f"{path}: there is no folder {str(path.parent)!r} to write into")

    def need_ages(self, runs: int, robots: int, ticks: int) -> bool:
        """Whether such a run shall keep the age of each message, as a saved run and a page show it.

        Warns where the ages are left out because they are too many numbers.

        Args:
            runs: Number of seeds.
            robots: Number of robots.
            ticks: Number of periods.
        """
        wanted = self.save is not None or self.player
        if wanted and runs * robots**2 * ticks > MOST_AGES:
            warnings.warn("too many robots and seeds to save the age of every message; the rest is saved", stacklevel=2)
            return False
        return wanted

    def write(self, run: Run) -> Path | None:
        """Write ``run`` to all of the files; return the page that plays it, if there is one. Raises OSError."""
        if self.save is not None:
            run.save(self.save)
        if self.table is not None:
            write_frame(run.frame(), self.table)
        if self.events is not None:
            write_frame(mode_change_table(run), self.events)
        if self.plot is not None:
            from fuzzy.figures.drawing import save_figure
            from robotics.figures.run import plot_run

            save_figure(plot_run(run), self.plot)
        if not self.player:
            return None
        page = Path(f"{run.scenario}-seed-{run.seeds[0]}.html")
        write_player(run, page)
        return page
