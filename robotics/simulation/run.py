"""A run: what happened, sample by sample, for every seed and robot; a table, a file, and back."""

import json
import zlib
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any
from zipfile import BadZipFile

import numpy as np

from fuzzy.errors import InputError
from fuzzy.files.atomic import replacing
from robotics.environment.world import Geometry
from robotics.laws.modes import MODES

if TYPE_CHECKING:
    import pandas as pd

# The channels of a run, in the order of ``Run.samples``, with their units
CHANNELS: dict[str, str] = {
    "x": "m",  # true pose
    "y": "m",
    "heading": "rad",
    "v": "m/s",  # true velocity
    "w": "rad/s",
    "x_measured": "m",  # what the controller saw
    "y_measured": "m",
    "heading_measured": "rad",
    "command_1": "m/s or N m",  # v, or the right wheel's torque
    "command_2": "rad/s or N m",  # ω, or the left wheel's torque
    "v_demand": "m/s",  # the speed that the law tries to reach, within the robot's limits
    "w_demand": "rad/s",
    "effort": "N² m² s",  # ∫ τr² + τl² dt so far
    "torque_variation": "N m",  # Σ |Δτr| + |Δτl| so far, at the wheel loops' 100 Hz
}
# Further channels of a team's run, in the order of ``Run.team``
TEAM_CHANNELS: dict[str, str] = {
    "progress": "1",  # the law's own path parameter; not-a-number if it has none
    "x_target": "m",  # where the law wants the robot to be
    "y_target": "m",
    "heading_target": "rad",
    "fault": "1",  # 0 none, 1 failure, 2 delay, 3 silence, 4 stall
}
REFERENCE: dict[str, str] = {"x": "m", "y": "m", "heading": "rad", "v": "m/s", "w": "rad/s", "s": "m"}


class RunError(InputError):
    """A file that holds no run, or a place where none can be written."""


@dataclass(frozen=True, eq=False)
class Run:
    """All samples of all seeds and robots. ``run["x"]`` is (runs, robots, samples)."""

    scenario: str
    controller: str
    level: str  # "velocity" or "torque": what the command is
    seeds: tuple[int, ...]
    time: np.ndarray  # (samples,) s
    samples: np.ndarray = field(repr=False)  # (samples, channels, runs, robots); NaN after a robot was stopped
    reference: np.ndarray = field(repr=False)  # (6, samples, robots): REFERENCE
    paths: tuple[np.ndarray, ...] = field(repr=False)  # per robot (2, nodes) m: the path's nodes
    stopped: np.ndarray = field(repr=False)  # (runs, robots) int: the sample at which it diverged, or -1
    team: np.ndarray | None = field(default=None, repr=False)  # (samples, team channels, runs, robots)
    links: np.ndarray | None = field(default=None, repr=False)  # (samples, runs, receivers, senders) s: age of messages
    modes: np.ndarray | None = field(
        default=None, repr=False
    )  # (samples, runs, robots) int8: robotics.laws.modes.MODES
    ranges: np.ndarray | None = field(default=None, repr=False)  # (samples, runs, robots, sensors) m: as sensed
    obstacles: Geometry | None = field(default=None, repr=False)  # its first axis: the samples, or 1 if all rest

    def __getitem__(self, channel: str) -> np.ndarray:
        """One channel (runs, robots, samples); those of TEAM_CHANNELS only in a team's run."""
        if channel in TEAM_CHANNELS and self.team is not None:
            return np.moveaxis(self.team[:, list(TEAM_CHANNELS).index(channel)], 0, -1)
        return np.moveaxis(self.samples[:, list(CHANNELS).index(channel)], 0, -1)

    def target(self, name: str) -> np.ndarray:
        """One field of the reference (robots, samples): x, y, heading, v, w or s."""
        return self.reference[list(REFERENCE).index(name)].T

    @property
    def diverged(self) -> np.ndarray:
        """(runs, robots) bool: was the robot stopped?"""
        return self.stopped >= 0

    def divergences(self) -> list[str]:
        """A sentence for every robot that was stopped."""
        return [
            f"controller {self.controller!r} diverged on {self.scenario!r}: robot {robot + 1}, seed {self.seeds[run]}, "
            f"stopped at t = {self.time[self.stopped[run, robot]]:.2f} s"
            for run, robot in np.argwhere(self.diverged)
        ]

    def frame(self) -> "pd.DataFrame":
        """A pandas table: one row a seed, robot and sample; the reference beside the channels."""
        import pandas as pd

        runs, robots, n = len(self.seeds), self.samples.shape[3], len(self.time)
        columns: dict[str, Any] = {
            "seed": np.repeat(self.seeds, robots * n),
            "robot": np.tile(np.repeat(np.arange(1, robots + 1), n), runs),
            "time": np.tile(self.time, runs * robots),
        }
        columns |= {name: self[name].ravel() for name in (*CHANNELS, *(TEAM_CHANNELS if self.team is not None else ()))}
        if self.modes is not None:
            columns["mode"] = np.array(MODES)[np.moveaxis(self.modes, 0, -1).ravel()]
        columns |= {f"{name}_reference": np.tile(self.target(name).ravel(), runs) for name in REFERENCE}
        return pd.DataFrame(columns)

    def save(self, path: str | Path) -> None:
        """Write the run to ``path`` (.npz), whole or not at all; :func:`load_run` reads it back without loss."""
        about = {k: getattr(self, k) for k in ("scenario", "controller", "level")} | {"format": 1}
        arrays: dict[str, Any] = {f"path_{i}": nodes for i, nodes in enumerate(self.paths)}
        arrays |= {k: v for k in ("team", "links", "modes", "ranges") if (v := getattr(self, k)) is not None}
        if self.obstacles is not None:
            arrays |= {f"obstacles_{name}": part for name, part in self.obstacles._asdict().items()}
        try:
            with replacing(path) as temporary, temporary.open("wb") as file:
                np.savez_compressed(
                    file,
                    about=np.array(json.dumps(about)),
                    seeds=np.array(self.seeds),
                    time=self.time,
                    samples=self.samples,
                    reference=self.reference,
                    stopped=self.stopped,
                    **arrays,
                )
        except OSError as error:
            raise RunError(f"{path}: cannot be written: {error.strerror}") from None


def load_run(path: str | Path) -> Run:
    """The run in a file that :meth:`Run.save` wrote. Raises RunError."""
    try:
        with Path(path).open("rb") as raw, np.load(raw, allow_pickle=False) as file:
            about = json.loads(str(file["about"]))
            obstacles = None
            if "obstacles_circles" in file:
                obstacles = Geometry(*(file[f"obstacles_{name}"] for name in Geometry._fields))
            return Run(
                about["scenario"],
                about["controller"],
                about["level"],
                tuple(int(s) for s in file["seeds"]),
                file["time"],
                file["samples"],
                file["reference"],
                tuple(file[f"path_{i}"] for i in range(file["reference"].shape[2])),
                file["stopped"],
                file.get("team"),
                file.get("links"),
                file.get("modes"),
                file.get("ranges"),
                obstacles,
            )
    except OSError as error:
        raise RunError(f"{path}: cannot be read: {error.strerror or error}") from None
    except (KeyError, ValueError, EOFError, IndexError, TypeError, BadZipFile, zlib.error) as error:
        raise RunError(f"{path}: this file holds no run: {error}") from None
