"""A run: all samples of every seed and robot; its table, its file, and back."""

import io
import json
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, get_args

import numpy as np

from fuzzy.errors import InputError, quoted
from fuzzy.files.arrays import MOST_BYTES, ArchiveError, headers, read_archive, sized, unpacked
from fuzzy.files.atomic import replacing
from fuzzy.files.fisfile import FisFileError, format_fis, parse_fis
from fuzzy.files.sealed import intact, is_sealed, sealed_archive
from fuzzy.naming import expected
from fuzzy.quantity import is_number
from fuzzy.shown import shown
from fuzzy.sketch import lines, table, titled
from fuzzy.system import Sugeno
from fuzzy.words import counted
from robotics.laws.modes import MODES
from robotics.laws.setting import Kind
from robotics.simulation.channels import CHANNELS, RECORDS, TEAM_CHANNELS, Axes
from robotics.simulation.layout import LayoutError, check_headers, check_values
from robotics.world.environment.world import Geometry
from robotics.world.paths.goal import Reach
from robotics.world.sensing.carried import sensor_names
from robotics.world.sensing.sonar import RangeSensor
from robotics.world.vehicle.floor import Patch
from robotics.world.vehicle.plant import Level
from robotics.world.vehicle.robot import Robot

if TYPE_CHECKING:
    import pandas as pd

REFERENCE: dict[str, str] = {"x": "m", "y": "m", "heading": "rad", "v": "m/s", "w": "rad/s", "s": "m"}

_FORMAT = 3  # of the files of runs
_ROBOTS_DRAWN = 12  # in a notebook
_POINTS_DRAWN = 200


class RunError(InputError):
    """A file that holds no run, or a place where none can be written."""


class ChannelError(InputError, KeyError):
    """A name that no channel of a run has. The message says which there are."""

    __str__ = Exception.__str__  # a KeyError's would put the sentence in quotation marks


@dataclass(frozen=True)
class About:
    """The scenario, the controller and the robots of a run."""

    scenario: str
    kind: str  # of the scenario: "tracking", "formation", "team" or "goal"
    controller: str
    level: str  # "velocity" or "torque": the meaning of the command
    robots: tuple[Robot, ...] = field(repr=False)
    sensors: tuple[Mapping[str, RangeSensor], ...] = field(repr=False)  # the sensors that each robot carries, by name
    rule_bases: Mapping[str, Sugeno] | None = field(default=None, repr=False)  # by task; None: an older file, not said
    message: tuple[str, ...] = field(default=(), repr=False)  # the names of the values that robots broadcast, if kept
    goals: tuple[Reach, ...] = field(default=(), repr=False)  # of the kind "goal": what each robot shall do
    patches: tuple[Patch, ...] = field(default=(), repr=False)  # of the floor


class Recorded(NamedTuple):
    """A recorded array with the names of its axes."""

    values: np.ndarray
    axes: Axes

    def only(self, axis: str, which: slice) -> "Recorded":
        """The part ``which`` along ``axis``."""
        return self._replace(values=self.values[(slice(None),) * self.axes.index(axis) + (which,)])


def _thinned(x: np.ndarray, y: np.ndarray) -> list[tuple[float, float]]:
    """A few of the points of a track."""
    places = np.unique(np.linspace(0, len(x) - 1, _POINTS_DRAWN).astype(int))
    return list(zip(x[places].tolist(), y[places].tolist(), strict=True))


@dataclass(frozen=True, eq=False)
class Run:
    """All samples of all seeds and robots. ``run["x"]`` is (runs, robots, samples).

    Attributes:
        about: The scenario's name and kind, the controller, the robots, their sensors and rule bases.
        seeds: The seed of each run.
        time: (samples,) [s], both ends included.
        recorded: The arrays of robotics.simulation.channels.RECORDS, by name.
        reference: (6, samples, robots): x [m], y [m], heading [rad], v [m/s], w [rad/s], s [m].
        paths: Per robot (2, nodes): x and y of the path's nodes [m].
        stopped: (runs, robots) int: the sample at which it diverged, or -1.
        obstacles: Where obstacles were; its first axis is the samples, or 1 if all rest. None: there were none.
    """

    about: About
    seeds: tuple[int, ...]
    time: np.ndarray
    recorded: dict[str, Recorded] = field(repr=False)
    reference: np.ndarray = field(repr=False)
    paths: tuple[np.ndarray, ...] = field(repr=False)
    stopped: np.ndarray = field(repr=False)
    obstacles: Geometry | None = field(default=None, repr=False)

    def __repr__(self) -> str:
        return f"Run({self.scenario!r} under {self.controller!r}: {self._counted()})"

    def _repr_html_(self) -> str:
        """What a notebook shows: what ran, and the first seed's tracks from above, over the paths."""
        robots = range(min(len(self.about.robots), _ROBOTS_DRAWN))
        x, y = (self[channel][0] for channel in ("x", "y"))  # (robots, samples) m
        drawn = lines(
            [_thinned(x[i], y[i]) for i in robots],
            [_thinned(*self.paths[i]) for i in robots],
            size=(320.0, 200.0),
            equal=True,
        )
        stopped = [["stopped", sentence] for sentence in self.divergences()[:3]]
        rows = [["scenario", self.scenario], ["controller", self.controller], *stopped]
        facts = table((), [*rows, [f"seed {self.seeds[0]}", drawn]])
        return titled("Run", self._counted(), facts)

    def _counted(self) -> str:
        robots, first, last = counted(len(self.about.robots), "robot"), self.seeds[0], self.seeds[-1]
        seeds = f"seed {first}" if len(self.seeds) == 1 else f"{len(self.seeds)} seeds, {first} to {last}"
        return f"{robots}, {seeds}, {shown(self.time[-1])} s in {len(self.time)} samples"

    @property
    def scenario(self) -> str:
        """The name of its scenario."""
        return self.about.scenario

    @property
    def controller(self) -> str:
        """The name of the controller that drove the robots."""
        return self.about.controller

    @property
    def level(self) -> str:
        """The meaning of ``command_1`` and ``command_2``: "velocity" or "torque"."""
        return self.about.level

    @property
    def samples(self) -> np.ndarray:
        """The samples of CHANNELS (samples, channels, runs, robots); not-a-number after a robot was stopped."""
        return self.recorded["samples"].values

    @property
    def team(self) -> np.ndarray | None:
        """The samples of TEAM_CHANNELS (samples, channels, runs, robots) in a team's run; otherwise None."""
        return self._values("team")

    @property
    def message_ages(self) -> np.ndarray | None:
        """The ages of messages [s] (samples, runs, receivers, senders), or None if the run does not keep them."""
        return self._values("message_ages")

    @property
    def modes(self) -> np.ndarray | None:
        """The codes of robotics.laws.modes.MODES (samples, runs, robots) int8, or None if the law has no modes."""
        return self._values("modes")

    @property
    def guarded(self) -> np.ndarray | None:
        """Whether the emergency rule acted (samples, runs, robots) bool, or None if the law has no such rule."""
        return self._values("guarded")

    @property
    def ranges(self) -> np.ndarray | None:
        """The readings of the range sensors [m] (samples, runs, robots, sensors), or None if the law needs none."""
        return self._values("ranges")

    @property
    def torques(self) -> np.ndarray | None:
        """The motors' torques [N m] (samples, right and left wheel, runs, robots), or None if a run keeps none.

        Each is that at the start of the last 10 ms of its period; those of the kinematic plant are 0.
        """
        return self._values("torques")

    @property
    def encoders(self) -> np.ndarray | None:
        """What the encoders tell (samples, ENCODER_CHANNELS, runs, robots), or None if the run does not keep it."""
        return self._values("encoders")

    @property
    def messages(self) -> np.ndarray | None:
        """What robots broadcast (samples, values, runs, robots), named by ``about.message``, or None if that is not
        kept.

        It is not-a-number in periods in which no message is due.
        """
        return self._values("messages")

    @property
    def inputs(self) -> np.ndarray | None:
        """The inputs of the rule bases (samples, inputs, runs, robots) float32, or None if the law has none.

        They stand in the order of ``about.rule_bases`` and, in each, of its inputs, whose units they have.
        """
        return self._values("inputs")

    @property
    def channels(self) -> tuple[str, ...]:
        """The names of its channels: those of CHANNELS, in a team's run also those of TEAM_CHANNELS."""
        return (*CHANNELS, *(TEAM_CHANNELS if self.team is not None else ()))

    def _values(self, name: str) -> np.ndarray | None:
        return self.recorded[name].values if name in self.recorded else None

    def __getitem__(self, channel: str) -> np.ndarray:
        """One channel (runs, robots, samples), one of :attr:`channels`. Raises ChannelError for another."""
        if channel not in self.channels:
            what = "channel of a run" if self.team is not None else "channel of a run without a team"
            raise ChannelError(expected(channel, self.channels, what))
        if channel in TEAM_CHANNELS and self.team is not None:
            return np.moveaxis(self.team[:, list(TEAM_CHANNELS).index(channel)], 0, -1)
        return np.moveaxis(self.samples[:, list(CHANNELS).index(channel)], 0, -1)

    def with_recorded(self, **arrays: np.ndarray | None) -> "Run":
        """The same run with other values of some recorded ``arrays``, by name, in the shapes of these (samples, ...);
        None
        leaves one out.
        """
        kept = {name: record for name, record in self.recorded.items() if name not in arrays}
        changed = {n: Recorded(values, RECORDS[n].axes) for n, values in arrays.items() if values is not None}
        return replace(self, recorded=kept | changed)

    def only(self, seed: int) -> "Run":
        """The part of one ``seed``. Raises ValueError for a seed that was not run."""
        place = self.seeds.index(seed)
        if len(self.seeds) == 1:
            return self  # and what was measured of it is known
        which = slice(place, place + 1)
        recorded = {name: record.only("run", which) for name, record in self.recorded.items()}
        return replace(self, seeds=(seed,), recorded=recorded, stopped=self.stopped[which])

    def time_innermost(self) -> "Run":
        """The same run with time last in memory, so that sums over time do not depend on the number of runs."""
        arrays = {
            name: np.moveaxis(np.ascontiguousarray(np.moveaxis(record.values, 0, -1)), -1, 0)
            for name, record in self.recorded.items()
            if "channel" in record.axes
        }
        return self.with_recorded(**arrays)

    def target(self, name: str) -> np.ndarray:
        """A field of the reference (robots, samples), by its ``name``: x, y, heading, v, w or s."""
        return self.reference[list(REFERENCE).index(name)].T

    @property
    def diverged(self) -> np.ndarray:
        """Whether each robot was stopped (runs, robots) bool."""
        return self.stopped >= 0

    def divergences(self) -> list[str]:
        """A sentence for every robot that was stopped."""
        return [
            f"controller {self.controller!r} diverged on {self.scenario!r}: robot {robot + 1}, seed {self.seeds[run]}, "
            f"stopped at t = {self.time[self.stopped[run, robot]]:.2f} s"
            for run, robot in np.argwhere(self.diverged)
        ]

    def frame(self) -> "pd.DataFrame":
        """A pandas table with one row for each seed, robot and sample; it has the reference beside the channels."""
        import pandas as pd

        runs, robots, n = len(self.seeds), self.samples.shape[3], len(self.time)
        columns: dict[str, Any] = {
            "seed": np.repeat(self.seeds, robots * n),
            "robot": np.tile(np.repeat(np.arange(1, robots + 1), n), runs),
            "time": np.tile(self.time, runs * robots),
        }
        columns |= {name: self[name].ravel() for name in self.channels}
        if self.modes is not None:
            columns["mode"] = np.array(MODES)[np.moveaxis(self.modes, 0, -1).ravel()]
        if self.guarded is not None:
            columns["guarded"] = np.moveaxis(self.guarded, 0, -1).ravel()
        columns |= {f"{name}_reference": np.tile(self.target(name).ravel(), runs) for name in REFERENCE}
        return pd.DataFrame(columns)

    def save(self, path: str | Path) -> None:
        """Write the run to ``path`` (.npz), whole or not at all; :func:`load_run` reads it back without loss.

        Raises:
            RunError: The file cannot be written, or a .fis file cannot hold a rule base.
        """
        about = json.dumps(_as_json(self.about, str(path)))
        arrays: dict[str, Any] = {
            "about": np.array(about),
            "seeds": np.array(self.seeds),
            "time": self.time,
            "reference": self.reference,
            "stopped": self.stopped,
        }
        arrays |= {f"path_{i}": nodes for i, nodes in enumerate(self.paths)}
        arrays |= {name: record.values for name, record in self.recorded.items()}
        if self.obstacles is not None:
            arrays |= {f"obstacles_{name}": part for name, part in self.obstacles._asdict().items()}
        total = sum(values.nbytes for values in arrays.values())
        if total > MOST_BYTES:
            raise RunError(f"{path}: the run takes {sized(total)}, and a file holds at most {sized(MOST_BYTES)}")
        content = io.BytesIO()
        np.savez_compressed(content, **arrays)
        try:
            with replacing(path) as temporary:
                temporary.write_bytes(sealed_archive(content.getvalue()))
        except OSError as error:
            raise RunError(f"{path}: cannot be written: {error.strerror}") from None


def load_run(path: str | Path) -> Run:
    """Read the run from a file that :meth:`Run.save` wrote.

    Nothing is unpacked before the sizes and shapes of all arrays fit together, and nothing is believed whose checksum
    is not that of the contents.

    Args:
        path: The file (.npz).

    Returns:
        The run, as it was saved.

    Raises:
        RunError: A file that holds no run; the message names it.
    """
    try:
        content = read_archive(path)
    except ArchiveError as error:
        raise RunError(f"{path}: {error}") from None
    except OSError as error:
        raise RunError(f"{path}: cannot be read: {error.strerror or error}") from None
    if is_sealed(content) and not intact(content):
        raise _damaged(path, "its checksum is not that of its contents")
    try:
        found = headers(content)
    except ArchiveError as error:
        raise _damaged(path, error) from None
    except Exception:  # what zipfile, zlib and numpy raise for bytes that are none of theirs has no end
        found = {}
    if "about" not in found:
        if content.startswith(b"PK"):
            raise _damaged(path, "it cannot be unpacked, or it is another archive")
        raise RunError(f"{path}: this is not a run saved by `robotics run --save`")
    try:
        check_headers(_renamed(found))
        arrays = _renamed(unpacked(content))
        check_values(arrays)
        table = json.loads(str(arrays["about"]))
        if table["format"] != _FORMAT:
            raise RunError(
                f"{path}: a saved run of format {quoted(table['format'])}; this version reads format {_FORMAT}"
            )
        if not is_sealed(content):
            raise _damaged(path, "its checksum is missing")
        return _run(table, arrays)
    except RunError:
        raise
    except InputError as error:
        raise _damaged(path, error) from None
    except MemoryError:
        total = sum(header.bytes for header in found.values())
        raise RunError(f"{path}: the run takes {sized(total)}, more than there is memory") from None
    except Exception:
        raise _damaged(path, "what it says of its robots and sensors cannot be read") from None


def _renamed(arrays: Mapping[str, Any]) -> dict[str, Any]:
    """The arrays of a file by their names of today: 0.2.0 called the ages of messages links."""
    return {"message_ages" if name == "links" else name: array for name, array in arrays.items()}


def _damaged(path: str | Path, reason: object) -> RunError:
    return RunError(f"{path}: this saved run is damaged: {reason}")


def _run(table: dict[str, Any], arrays: Mapping[str, np.ndarray]) -> Run:
    """The run of what a file says in JSON and of its arrays, whose shapes fit together."""
    recorded = {name: Recorded(arrays[name], record.axes) for name, record in RECORDS.items() if name in arrays}
    robots = arrays["stopped"].shape[1]
    about = _from_json(table)
    _check_about(about, robots, recorded)
    obstacles = None
    if "obstacles_circles" in arrays:
        obstacles = Geometry(*(arrays[f"obstacles_{name}"] for name in Geometry._fields))
    return Run(
        about,
        tuple(arrays["seeds"].tolist()),
        arrays["time"],
        recorded,
        arrays["reference"],
        tuple(arrays[f"path_{i}"] for i in range(robots)),
        arrays["stopped"],
        obstacles,
    )


def _check_about(about: About, robots: int, recorded: Mapping[str, Recorded]) -> None:
    """Raise LayoutError unless ``about`` is of a run with these robots and recorded arrays."""
    named = isinstance(about.scenario, str) and isinstance(about.controller, str)
    if about.kind not in get_args(Kind) or about.level not in get_args(Level) or not named:
        raise LayoutError(f"it is of a kind {quoted(about.kind)} and a level {quoted(about.level)} that no run has")
    if len(about.goals) != (robots if about.kind == "goal" else 0):
        raise LayoutError(f"it describes {len(about.goals)} goals of {robots} robots")
    if len(about.robots) != robots:
        raise LayoutError(f"it describes {len(about.robots)} robots, and {robots} were recorded")
    wanted = {"input": sum(len(system.inputs) for system in (about.rule_bases or {}).values())}
    wanted |= {"value": len(about.message), "sensor": len(sensor_names(about.sensors))}
    for name, record in recorded.items():
        for axis, length in zip(record.axes, record.values.shape, strict=True):
            if wanted.get(axis, length) != length:
                raise LayoutError(f"{quoted(name)} has {length} {axis}s, and the robots have {wanted[axis]}")


def _as_json(about: About, path: str) -> dict[str, Any]:
    """``about`` in JSON's types; robots that are alike are written once. ``path`` is for messages."""
    kinds = [{"robot": asdict(r), "sensors": {n: asdict(s) for n, s in c.items()}} for r, c in _pairs(about)]
    distinct = [kind for i, kind in enumerate(kinds) if kind not in kinds[:i]]
    plain: dict[str, Any] = {name: getattr(about, name) for name in ("scenario", "kind", "controller", "level")}
    if about.message:
        plain["message"] = list(about.message)
    if about.goals:
        plain["goals"] = [asdict(goal) for goal in about.goals]
    if about.patches:
        plain["patches"] = [asdict(patch) for patch in about.patches]
    if about.rule_bases is not None:
        try:
            plain["rule_bases"] = {task: format_fis(system) for task, system in about.rule_bases.items()}
        except FisFileError as error:
            raise RunError(f"{path}: a rule base cannot be written: {error}") from None
    return plain | {"format": _FORMAT, "robots": distinct, "robot": [distinct.index(kind) for kind in kinds]}


def _pairs(about: About) -> Iterator[tuple[Robot, Mapping[str, RangeSensor]]]:
    return zip(about.robots, about.sensors, strict=True)


def _from_json(table: dict[str, Any]) -> About:
    """Read what :func:`_as_json` wrote."""
    kinds = [
        (Robot(**k["robot"]), {name: RangeSensor(**row) for name, row in k["sensors"].items()}) for k in table["robots"]
    ]
    texts = table.get("rule_bases")
    rule_bases = None if texts is None else {task: parse_fis(text, f"{task}.fis") for task, text in texts.items()}
    return About(
        table["scenario"],
        table["kind"],
        table["controller"],
        table["level"],
        tuple(kinds[i][0] for i in table["robot"]),
        tuple(kinds[i][1] for i in table["robot"]),
        rule_bases,
        tuple(map(str, table.get("message", ()))),
        tuple(map(_goal_from_json, table.get("goals", ()))),
        tuple(map(_patch_from_json, table.get("patches", ()))),
    )


def _patch_from_json(table: dict[str, Any]) -> Patch:
    """Read a patch of the floor. Raises FloorError for one that cannot be."""
    center, corners = table["center"], table["corners"]
    points = {"center": center and tuple(center), "corners": corners and tuple(map(tuple, corners))}
    return Patch(**table | points)


def _goal_from_json(table: dict[str, Any]) -> Reach:
    """Read a goal. Raises LayoutError for one that no robot can have."""
    region = table["region"] and tuple(map(tuple, table["region"]))
    goal = Reach(**table | {"region": region})
    numbers = [goal.within, goal.hold, 0.0 if goal.heading_within is None else goal.heading_within]
    corners = [number for corner in region or () for number in corner]
    paired = region is None or (len(region) > 2 and {len(corner) for corner in region} == {2})
    if not (all(map(is_number, [*numbers, *corners])) and min(numbers) >= 0 and paired):
        raise LayoutError("it describes a goal by what are no finite numbers, or too few")
    return goal
