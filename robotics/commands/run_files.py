"""The files of a run: the run itself, its samples, its changes of mode, a picture, a page that plays it, its logs."""

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fuzzy.files.atomic import check_folder, check_target
from fuzzy.files.table import write_frame
from robotics.logs.layout import write_layout
from robotics.logs.typestore import check_distribution
from robotics.logs.writing import check_mcap, check_rosbag, check_storage, seed_files, write_mcap, write_rosbag
from robotics.playback.player import write_player
from robotics.simulation.mode_changes import mode_change_table
from robotics.simulation.run import Run

MOST_AGES = 100_000_000  # of messages that a run holds: 400 MB


@dataclass(frozen=True, kw_only=True)
class RunFiles:
    """The files into which a run goes; None: not written. Raises an InputError for a name with a wrong
    ending and a place where no file can be written."""

    save: Path | None = None  # .npz, without loss
    table: Path | None = None  # .csv, every sample
    events: Path | None = None  # .csv, who avoided, yielded or timed out, and when
    plot: Path | None = None  # .png, .pdf or .svg, of the first seed
    player: bool = False  # <scenario>-seed-<first seed>.html in the folder in which one is
    mcap: Path | None = None  # .mcap, of each seed
    rosbag: Path | None = None  # a new folder, of each seed
    layout: Path | None = None  # .json, for Foxglove
    storage: str = "mcap"  # of the rosbag
    distribution: str = "jazzy"  # of ROS 2, for both logs

    def __post_init__(self) -> None:
        if self.plot is not None:
            from fuzzy.figures.drawing import check_picture

            check_picture(self.plot)
        for path, suffix in ((self.save, ".npz"), (self.table, ".csv"), (self.events, ".csv")):
            if path is not None:
                check_target(path, suffix)
        if self.player:
            check_folder(Path())
        if self.layout is not None:
            check_target(self.layout, ".json")
        if self.logged:
            check_distribution(self.distribution)
            check_storage(self.storage)

    @property
    def logged(self) -> bool:
        """Whether the run shall keep all that a log shows."""
        return self.mcap is not None or self.rosbag is not None

    def check_logs(self, seeds: Sequence[int]) -> None:
        """See, before the run, that the logs of these seeds can be written. Raises LogError or TargetError."""
        for path in self._logs(self.mcap, seeds).values():
            check_mcap(path)
        for path in self._logs(self.rosbag, seeds).values():
            check_rosbag(path)

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

    def write(self, run: Run, begin: Callable[[str, int], Callable[[], None]] | None = None) -> Path | None:
        """Write ``run`` to all of the files; return the page that plays it, if there is one. Raises OSError.

        ``begin`` starts a bar of a progress display, by its text and total.
        """
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
        self._write_logs(run, begin)
        if not self.player:
            return None
        page = Path(f"{run.scenario}-seed-{run.seeds[0]}.html")
        write_player(run, page)
        return page

    @staticmethod
    def _logs(path: Path | None, seeds: Sequence[int]) -> dict[int, Path]:
        return {} if path is None else seed_files(path, seeds)

    def _write_logs(self, run: Run, begin: Callable[[str, int], Callable[[], None]] | None) -> None:
        """Write the logs of all seeds, and the layout."""
        logs: list[tuple[Any, Path | None, dict[str, Any]]] = [
            (write_mcap, self.mcap, {}),
            (write_rosbag, self.rosbag, {"storage": self.storage}),
        ]
        for write, wanted, options in logs:
            for seed, path in self._logs(wanted, run.seeds).items():
                advance = None if begin is None else begin(str(path), len(run.time))
                write(run, path, seed=seed, distribution=self.distribution, progress=advance, **options)
        if self.layout is not None:
            write_layout(run, self.layout)
