"""The files of a run: the run itself, its samples, its changes of mode, a picture, a page that plays it, its logs."""

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from fuzzy.commands.shared import check_plot
from fuzzy.files.atomic import check_folder, check_target
from fuzzy.shell.options import option
from robotics.commands.completion import distributions, storages

if TYPE_CHECKING:
    from robotics.simulation.run import Run

MOST_AGES = 100_000_000  # of messages that a run holds: 400 MB

Distribution = Annotated[
    str,
    option(
        "ROS 2 distribution whose messages a log has: humble, iron, jazzy or kilted.",
        "--ros",
        autocompletion=distributions,
    ),
]


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
    mcap: Annotated[
        Path | None,
        option("Log the run for Foxglove and ROS 2; of several seeds one file each, FILE-seed-N.mcap.", "FILE.mcap"),
    ] = None
    rosbag: Annotated[Path | None, option("Log the run as a rosbag2 folder; of several seeds one each.", "FOLDER")] = (
        None
    )
    layout: Annotated[Path | None, option("Write a Foxglove layout for the log.", "FILE.json")] = None
    storage: Annotated[
        str, option("Storage of --rosbag: mcap, or sqlite3 for ROS 2 before Iron.", autocompletion=storages)
    ] = "mcap"
    distribution: Distribution = "jazzy"

    def __post_init__(self) -> None:
        check_plot(self.plot)
        for path, suffix in ((self.save, ".npz"), (self.table, ".csv"), (self.events, ".csv")):
            check_target(path, suffix)
        if self.player:
            check_folder(Path())
        check_target(self.layout, ".json")
        if self.logged:
            from robotics.plugins.logs.typestore import check_distribution
            from robotics.plugins.logs.writing import check_storage

            check_distribution(self.distribution)
            check_storage(self.storage)

    @property
    def logged(self) -> bool:
        """Whether the run shall keep all that a log shows."""
        return self.mcap is not None or self.rosbag is not None

    def check_logs(self, seeds: Sequence[int]) -> None:
        """See, before the run, that the logs of these seeds can be written. Raises LogError or TargetError."""
        from robotics.plugins.logs.writing import check_mcap, check_rosbag

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

    def write(self, run: "Run", begin: Callable[[str, int], Callable[[], None]] | None = None) -> Path | None:
        """Write ``run`` to all of the files; return the page that plays it, if there is one. Raises OSError.

        ``begin`` starts a bar of a progress display, by its text and total.
        """
        from fuzzy.files.table import write_frame
        from robotics.show.playback.player import write_player
        from robotics.simulation.mode_changes import mode_change_table

        if self.save is not None:
            run.save(self.save)
        if self.table is not None:
            write_frame(run.frame(), self.table)
        if self.events is not None:
            write_frame(mode_change_table(run), self.events)
        if self.plot is not None:
            from fuzzy.figures.drawing import save_figure
            from robotics.show.figures.run import plot_run

            save_figure(plot_run(run), self.plot)
        self._write_logs(run, begin)
        if not self.player:
            return None
        page = Path(f"{run.scenario}-seed-{run.seeds[0]}.html")
        write_player(run, page)
        return page

    @staticmethod
    def _logs(path: Path | None, seeds: Sequence[int]) -> dict[int, Path]:
        from robotics.plugins.logs.writing import seed_files

        return {} if path is None else seed_files(path, seeds)

    def _write_logs(self, run: "Run", begin: Callable[[str, int], Callable[[], None]] | None) -> None:
        """Write the logs of all seeds, and the layout."""
        from robotics.plugins.logs.layout import write_layout
        from robotics.plugins.logs.writing import write_mcap, write_rosbag

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
