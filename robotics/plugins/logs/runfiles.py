"""The logs of a run, as options of the commands that simulate one: an MCAP file, a rosbag2 folder, a layout."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from fuzzy.files.atomic import check_target
from fuzzy.shell.options import option
from robotics.commands.completion import one_of
from robotics.plugins.logs.typestore import DISTRIBUTIONS, check_distribution

if TYPE_CHECKING:
    from fuzzy.shell.progress import Begin
    from robotics.simulation.run import Run


storages = one_of(("mcap", "sqlite3"))  # of a rosbag2 folder
Distribution = Annotated[
    str,
    option(
        "ROS 2 distribution whose messages a log has: humble, iron, jazzy or kilted.",
        "--ros",
        autocompletion=one_of(DISTRIBUTIONS),
    ),
]


@dataclass(frozen=True, kw_only=True)
class LogFiles:
    """The logs into which a run goes; None: not written. Raises an InputError for what cannot be written."""

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
        check_target(self.layout, ".json")
        if self.logged:
            from robotics.plugins.logs.writing import check_storage

            check_distribution(self.distribution)
            check_storage(self.storage)

    @property
    def logged(self) -> bool:
        """Whether the run shall keep all that a log shows."""
        return self.mcap is not None or self.rosbag is not None

    def check(self, seeds: Sequence[int]) -> None:
        """See, before the run, that the logs of these seeds can be written. Raises LogError or TargetError."""
        from robotics.plugins.logs.writing import check_mcap, check_rosbag

        for path in self._logs(self.mcap, seeds).values():
            check_mcap(path)
        for path in self._logs(self.rosbag, seeds).values():
            check_rosbag(path)

    def write(self, run: "Run", begin: "Begin | None" = None) -> None:
        """Write the logs of all seeds, and the layout; ``begin`` starts a bar by its text and total. Raises OSError."""
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

    @staticmethod
    def _logs(path: Path | None, seeds: Sequence[int]) -> dict[int, Path]:
        """The file or folder of each seed's log: ``path`` itself, or run-seed-3.mcap and so on of several."""
        if path is None or len(seeds) == 1:
            return {} if path is None else {seeds[0]: path}
        return {seed: path.with_name(f"{path.stem}-seed-{seed}{path.suffix}") for seed in seeds}
