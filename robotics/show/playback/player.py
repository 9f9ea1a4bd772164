"""A player of a run for a browser: one HTML file without a library, or a part of a page.

The picture, the controls and the chart are ``player.js`` with the looks of ``player.css``. This module packs the run
for them: at most 20 frames a second and about 100,000 poses, every channel as 16-bit numbers of its own range. The
readings of the sonars are those that the run recorded.
"""

import base64
import html
import json
import zlib
from dataclasses import fields
from importlib import resources
from math import ceil
from pathlib import Path
from typing import Any

import numpy as np

from fuzzy.esmodule import composed
from fuzzy.figures.palette import stylesheet
from fuzzy.files.atomic import write_whole
from robotics.laws.modes import MODES
from robotics.measures.contacts import Contact, who
from robotics.measures.decisions import UNKNOWN, decisions, strongest
from robotics.show.playback.replay import Replay, ReplayFrame, replay
from robotics.simulation.run import Run
from robotics.simulation.spans import span
from robotics.world.environment.world import outlines
from robotics.world.sensing.carried import sensor_names
from robotics.world.sensing.sonar import RangeSensor

RATE = 20.0  # frames a second, at most
_POSES = 100_000  # frames × robots, at most
_NODES = 30_000  # points of all paths, at most
_UNKNOWN = -32768
_STEPS = 65_000  # of a channel's range
_RULES = 3  # rules of each rule base that are kept, the strongest; of more than _ANSWERS answers one, without inputs
_ANSWERS = 100_000  # rule bases × poses
_NO_ANSWER = 65535  # in place of a rule's number
# The keys of what a player shows that hold arrays as base64, and whether those are of 16-bit numbers
_ARRAYS = {"data": True, "numbers": True, "time": False, "hears": False, "stale": False, "codes": False,
           "strengths": False, "shares": False}  # fmt: skip


def player_data(
    run: Run,
    seed: int | None = None,
    *,
    start: float | None = None,
    end: float | None = None,
    stale: float | None = None,
    frames: int | None = None,
) -> dict[str, Any]:
    """What the player shows of one seed of a run, in JSON's types: the value "run" of the model in ``player.js``.

    Args:
        run: The run.
        seed: The seed that is shown, by default the first.
        start: The time [s] at which it begins, by default that of the run.
        end: The time [s] at which it ends, by default that of the run.
        stale: The age [s] from which a message is stale, by default as in :func:`robotics.show.playback.replay.replay`.
        frames: How many frames there are at most; the player shows what is between two of them.

    Raises ReplayError.
    """
    begin, until = span(run, start, end)
    shown = np.flatnonzero((run.time >= begin - 1e-9) & (run.time <= until + 1e-9))
    robots, period = run.samples.shape[3], float(run.time[1] - run.time[0])
    step = max(1, ceil(1 / (RATE * period) - 1e-9), ceil(len(shown) * robots / _POSES))
    if frames is not None:
        step = max(step, ceil(len(shown) / frames))
    # The last sample is kept although it may come sooner after the one before.
    chosen = np.unique(np.append(shown[::step], shown[-1]))
    film = replay(run, run.time[chosen], seed, stale)
    channels = {f.name: _packed(getattr(film, f.name)) for f in fields(ReplayFrame)}
    if film.progress is not None:
        channels["progress"] = _packed(film.progress)
    paths = _thinned(film)
    channels |= {"path_x": _packed(paths[:, 0]), "path_y": _packed(paths[:, 1])}
    return {
        "format": 1,
        "title": film.title,
        "seed": run.seeds[film.place],
        "robots": robots,
        "sizes": [[robot.length, robot.width] for robot in run.about.robots],  # m
        "wheels": [[round(robot.wheel_radius, 5), round(robot.half_axle, 5)] for robot in run.about.robots],  # m
        "time": _coded(film.time.astype("<f4")),
        "channels": channels,
        "bounds": [round(value, 4) for value in film.bounds],
        "faults": [[f.robot, f.kind, round(f.start, 3), round(f.end, 3)] for f in film.faults],
        "stops": [float(t) if np.isfinite(t) else None for t in film.stops],
        "hears": None if film.hears is None else _coded(np.packbits(film.hears.ravel(), bitorder="little")),
        "stale": _coded(np.stack(film.stale, axis=1).astype("<f4")),
        "stale_after": film.stale_after,
        "patches": [[patch.friction, np.round(patch.outline(), 4).tolist()] for patch in run.about.patches],  # 1, m
        "obstacles": _obstacles(film),
        "sonar": _sonar(film),
        "modes": _modes(film),
        "contacts": [_contact(contact) for contact in film.contacts],
        "rules": _rules(run, film.place, chosen),
    }


def player_fragment(run: Run, seed: int | None = None, **options: Any) -> str:
    """A part of an HTML page that plays ``seed`` of ``run``; ``options`` are those of :func:`player_data`.

    The page needs :func:`player_script` once, at its end. The data are packed; in a ``details`` element that is closed
    they stay so until it is opened. Raises ReplayError.
    """
    data = player_data(run, seed, **options)
    script = f'<script type="application/octet-stream">{_compressed({"run": data})}</script>'
    return _fragment(data["title"], "", script)


def player_script() -> str:
    """The script that makes a player of every :func:`player_fragment` before it; a page needs it once."""
    folder = Path(str(resources.files("robotics") / "show" / "playback" / "static"))
    looks = stylesheet() + (folder / "player.css").read_text(encoding="utf-8")
    begin = (folder / "fragments.js.txt").read_text(encoding="utf-8").replace("LOOKS", _script_json(looks))
    return f'<script type="module">\n{composed(folder / "player.js", begin)}</script>'


def write_player(
    run: Run,
    path: str | Path,
    seed: int | None = None,
    *,
    start: float | None = None,
    end: float | None = None,
    speed: float = 1.0,
    stale: float | None = None,
) -> None:
    """Write a page that plays one seed of a run: one file that asks for nothing else, whole or not at all.

    Args:
        run: The run.
        path: The file.
        seed: The seed that is shown, by default the first.
        start: The time [s] at which it begins, by default that of the run.
        end: The time [s] at which it ends, by default that of the run.
        speed: Times real time, until another speed is chosen on the page.
        stale: The age [s] from which a message is stale, see :func:`player_data`.

    Raises ReplayError, OSError.
    """
    from jinja2 import Environment, StrictUndefined
    from markupsafe import Markup

    data = player_data(run, seed, start=start, end=end, stale=stale)
    model = _script_json({"run": data, "page": True, "speed": speed})
    script = f'<script type="application/json">{model}</script>'
    here = resources.files("robotics") / "show" / "playback"
    template = (here / "player.html.j2").read_text(encoding="utf-8")
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    page = environment.from_string(template).render(
        title=data["title"],
        sheet=Markup(stylesheet() + (here / "static" / "page.css").read_text(encoding="utf-8")),
        fragment=Markup(_fragment(data["title"], "page", script)),
        script=Markup(player_script()),
    )
    write_whole(path, page)


def _fragment(title: str, mark: str, script: str) -> str:
    name = html.escape(f"Player: {title}")
    return (
        f'<div class="fleet-player" data-fleet-player="{mark}" role="group" aria-label="{name}">\n'
        f'<p class="fp-waiting">{name}. It needs a browser that runs JavaScript.</p>\n'
        f"{script}\n</div>"
    )


def _compressed(model: dict[str, Any]) -> str:
    """The model as ``packed.js`` reads it: its JSON and, after it, its arrays, deflated together, as base64."""
    arrays: list[bytes] = []

    def without_arrays(key: str, value: Any) -> Any:
        if isinstance(value, dict):
            return {name: without_arrays(name, inner) for name, inner in value.items()}
        if isinstance(value, list):
            return [without_arrays("", inner) for inner in value]
        if key not in _ARRAYS or not isinstance(value, str):
            return value
        raw = base64.b64decode(value)
        place = [sum(map(len, arrays)), len(raw), _ARRAYS[key]]
        arrays.append(_differences(raw) if _ARRAYS[key] else raw)
        return {"packed": place}

    text = json.dumps(without_arrays("", model), ensure_ascii=False, separators=(",", ":")).encode()
    whole = b"".join([len(text).to_bytes(4, "little"), text, *arrays])
    return base64.b64encode(zlib.compress(whole, 9)).decode("ascii")


def _differences(raw: bytes) -> bytes:
    """16-bit numbers as differences, all low bytes before all high ones: what hardly changes then deflates well."""
    steps = np.diff(np.frombuffer(raw, "<u2"), prepend=np.uint16(0))
    return np.ascontiguousarray(steps.astype("<u2").view(np.uint8).reshape(-1, 2).T).tobytes()


def _script_json(value: Any) -> str:
    """JSON that may stand in a script element: nothing in it can end the element."""
    return json.dumps(value, ensure_ascii=False, separators=(",", ":")).replace("<", "\\u003c")


def _coded(array: np.ndarray) -> str:
    return base64.b64encode(np.ascontiguousarray(array).tobytes()).decode("ascii")


def _packed(values: np.ndarray) -> dict[str, Any]:
    """``values`` as little-endian 16-bit numbers n: value = offset + scale n; -32768 stands for not-a-number."""
    known = np.isfinite(values)
    low, high = (float(values[known].min()), float(values[known].max())) if known.any() else (0.0, 0.0)
    scale, offset = (high - low) / _STEPS or 1.0, (low + high) / 2
    whole = np.where(known, np.rint((np.where(known, values, offset) - offset) / scale), _UNKNOWN)
    return {"offset": offset, "scale": scale, "data": _coded(whole.astype("<i2"))}


def _obstacles(film: Replay) -> dict[str, Any] | None:
    """Each body's outline [m] about the center of its circle, and where that is and how it has turned, a frame each.

    Of bodies at rest there is one frame. ``solid`` ones are filled, the others are walls.
    """
    if film.obstacles is None:
        return None
    count, circles, segments = int(film.obstacles.counts[0]), film.obstacles.circles, film.obstacles.segments
    centers = np.moveaxis(circles[:, :count, :2], 0, -1)  # (bodies, 2, frames)
    bodies, turns = [], np.zeros((count, len(circles)))
    for b, line in enumerate(outlines(film.obstacles)):
        first, number, closed, _ = film.obstacles.bodies[0, b]
        shape = {"points": np.round(line - centers[b, :, 0], 4).tolist(), "solid": bool(closed or number == 0)}
        if number == 0:
            shape = {"radius": round(float(circles[0, b, 2]), 4), "solid": True}
        else:
            along = segments[:, first, 2:] - segments[:, first, :2]
            angle = np.unwrap(np.arctan2(along[:, 1], along[:, 0]))
            turns[b] = angle - angle[0]
        bodies.append(shape)
    return {"bodies": bodies, "x": _packed(centers[:, 0]), "y": _packed(centers[:, 1]), "turn": _packed(turns)}


def _sonar(film: Replay) -> dict[str, Any] | None:
    """The readings [m] of the range sensors, and their mounting: x, y [m], axis, half the cone [rad], range [m].

    A robot that does not carry one of them has null for it.
    """
    if film.ranges is None:
        return None
    sensors = film.run.about.sensors
    names = sensor_names(sensors)

    def mounting(sensor: RangeSensor | None) -> list[float] | None:
        if sensor is None:
            return None
        return [round(v, 6) for v in (sensor.x, sensor.y, sensor.axis, sensor.half_cone, sensor.range)]

    mounted = [[mounting(carried.get(name)) for name in names] for carried in sensors]
    return {"sensors": mounted, "readings": _packed(film.ranges)}


def _modes(film: Replay) -> dict[str, Any] | None:
    """The words for the codes, a code a robot and frame, and the changes of mode: time [s], robot, from, to, why."""
    if film.modes is None:
        return None
    events = [[round(e.time, 3), e.robot, e.before, e.after, e.why] for e in film.handovers]
    return {"words": list(MODES), "codes": _coded(film.modes.astype(np.int8)), "events": events}


def _rules(run: Run, place: int, chosen: np.ndarray) -> dict[str, Any] | None:
    """The strongest rules of each rule base, for every rule base, robot and frame, and what the rule bases were asked.

    A rule's number counts from 1; it is 0 where no more rules fire, and _NO_ANSWER where an input was not a number.
    Firing strengths, and their shares in the sum of all strengths, are in 255ths.
    """
    if not run.about.rule_bases or run.inputs is None:
        return None
    asked = decisions(run, place, chosen)
    few = len(asked) * asked[0].inputs.shape[0] * asked[0].inputs.shape[1] <= _ANSWERS
    top = _RULES if few else 1
    fired = [each.firing() for each in asked]
    numbers, strengths = zip(*(strongest(each, top) for each in fired), strict=True)
    sums = np.stack([np.nan_to_num(each).sum(axis=-1, keepdims=True) for each in fired])
    number = np.swapaxes(np.stack(numbers), 1, 2)  # (rule bases, robots, frames, top)
    strength = np.swapaxes(np.stack(strengths), 1, 2)
    share = strength / np.where(sums > 0, sums, 1.0).swapaxes(1, 2)
    return {
        "top": top,
        "bases": [
            {
                "task": each.task,
                "rules": [str(rule) for rule in each.system.rules],
                "inputs": [[variable.name, variable.unit] for variable in each.system.inputs],
            }
            for each in asked
        ],
        "numbers": _coded(np.where(number == UNKNOWN, _NO_ANSWER, number).astype("<u2")),
        "strengths": _coded(np.rint(255 * np.clip(strength, 0.0, 1.0)).astype(np.uint8)),
        "shares": _coded(np.rint(255 * np.clip(share, 0.0, 1.0)).astype(np.uint8)),
        "values": [_packed(value.T) for each in asked for value in np.moveaxis(each.inputs, -1, 0)] if few else None,
    }


def _contact(contact: Contact) -> list[Any]:
    """A contact: start and end [s], x and y [m], depth [m], and between whom, in words."""
    numbers = (contact.start, contact.end, contact.x, contact.y, contact.depth)
    return [*(round(value, 4) for value in numbers), who(contact.robot, contact.other, contact.obstacle)]


def _thinned(film: Replay) -> np.ndarray:
    """The paths (robots, 2, points) with equally many points each."""
    paths = film.run.paths
    most = int(np.clip(_NODES // len(paths), 40, 400))
    count = min(most, max(nodes.shape[1] for nodes in paths))
    return np.stack([nodes[:, np.linspace(0, nodes.shape[1] - 1, count).round().astype(int)] for nodes in paths])
