"""The files of a run: the run itself, its samples, its changes of mode, a picture, a page; and those of plug-ins."""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Protocol

from fuzzy.commands.shared import check_plot
from fuzzy.files.atomic import check_folder, check_target
from fuzzy.shell.options import option

if TYPE_CHECKING:
    from fuzzy.shell.progress import Begin
    from robotics.simulation.run import Run

MOST_AGES = 100_000_000  # of messages that a run holds: 400 MB


class FilesOfPlugin(Protocol):
    """Further files of a run: a dataclass whose fields are options, and that raises an InputError for wrong ones."""

    @property
    def logged(self) -> bool:
        """Whether the run shall keep all that a log shows."""

    def check(self, seeds: Sequence[int]) -> None:
        """See, before the run, that the files of these seeds can be written. Raises an InputError."""

    def write(self, run: "Run", begin: "Begin | None" = None) -> None:
        """Write ``run`` to the files. Raises OSError."""


@dataclass(frozen=True, kw_only=True)
class RunFiles:
    """The files into which a run goes; None: not written. Raises an InputError for a name with a wrong
    ending and a place where no file can be written."""

    plot: Annotated[Path | None, option("Draw the first seed: .png, .pdf, .svg.", "PICTURE")] = None
    save: Annotated[Path | None, option("Save the run without loss.", "FILE.npz")] = None
    table: Annotated[Path | None, option("Save every sample as CSV.", "FILE.csv")] = None
    events: Annotated[Path | None, option("Save who avoided, yielded or timed out, and when.", "FILE.csv")] = None
    player: Annotated[bool, option("Write a page that plays the first seed: SCENARIO-seed-N.html.", "--animate")] = (
        False
    )
    added: tuple[FilesOfPlugin, ...] = ()  # of those that the entry points of the group fuzzyfleet.runfiles name

    def __post_init__(self) -> None:
        check_plot(self.plot)
        for path, suffix in ((self.save, ".npz"), (self.table, ".csv"), (self.events, ".csv")):
            check_target(path, suffix)
        if self.player:
            check_folder(Path())

    @property
    def logged(self) -> bool:
        """Whether the run shall keep all that a log shows."""
        return any(each.logged for each in self.added)

    def check_logs(self, seeds: Sequence[int]) -> None:
        """See, before the run, that the logs of these seeds can be written. Raises an InputError."""
        for each in self.added:
            each.check(seeds)

    def need_ages(self, runs: int, robots: int, ticks: int) -> bool:
        """Whether such a run shall keep the age of each message, as a saved run and a page show it.

        Warns where the ages are left out because they are too many numbers.

        Args:
            runs: Number of seeds.
            robots: Number of robots.
            ticks: Number of periods.
        """
        wanted = self.save is not None or self.player or self.logged
        if wanted and runs * robots**2 * ticks > MOST_AGES:
            warnings.warn("too many robots and seeds to keep the age of every message; the rest is saved", stacklevel=2)
            return False
        return wanted

    def write(self, run: "Run", begin: "Begin | None" = None) -> Path | None:
        """Write ``run`` to all of the files; return the page that plays it, if there is one. Raises OSError.

        ``begin`` starts a bar of a progress display, by its text and total.
        """
        if self.save is not None:
            run.save(self.save)
        if self.table is not None or self.events is not None:
            from fuzzy.files.table import write_frame
            from robotics.simulation.mode_changes import mode_change_table

            if self.table is not None:
                write_frame(run.frame(), self.table)
            if self.events is not None:
                write_frame(mode_change_table(run), self.events)
        if self.plot is not None:
            from fuzzy.figures.drawing import save_figure
            from robotics.show.figures.run import plot_run

            save_figure(plot_run(run), self.plot)
        for each in self.added:
            each.write(run, begin)
        if not self.player:
            return None
        from robotics.show.playback.player import write_player

        page = Path(f"{run.scenario}-seed-{run.seeds[0]}.html")
        write_player(run, page)
        return page
