"""Recompute the numbers behind the claims from saved runs, with numpy and shapely alone.

    robotics compare --save-runs --out out && python tests/recompute_claims.py out

reads out/evidence.csv and out/runs, and computes again, by code that shares nothing with the package, every number
whose runs are there: values, intervals and outcomes. It prints the largest difference, and exits with 1 if one is
larger than 1e-6 of the number (or of 1, for numbers below 1).
"""

import csv
import json
import math
import re
import sys
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import scipy.ndimage
import scipy.optimize
import scipy.stats
import shapely
from shapely.geometry import LineString, Point, Polygon

TOLERANCE = 1e-6
CHANNELS = ["x", "y", "heading", "v", "w", "x_measured", "y_measured", "heading_measured", "command_1", "command_2",
            "v_demand", "w_demand", "effort", "torque_variation"]  # fmt: skip
LEFT_BEHIND, STOPPED = 4, 8  # of the modes' codes
Array = np.ndarray


class SavedRun:
    """A saved run: arrays are (runs, robots, samples)."""

    def __init__(self, path: Path, past_contacts: bool = False) -> None:
        with np.load(path) as file:
            self.about = json.loads(str(file["about"]))
            self.time: Array = file["time"]
            self.seeds: Array = file["seeds"]
            samples = np.moveaxis(file["samples"], 0, -1)  # (channels, runs, robots, samples)
            self.channels = dict(zip(CHANNELS, samples, strict=True))
            self.reference = np.moveaxis(file["reference"], 1, -1)[:3]  # x, y, heading: (3, robots, samples)
            self.paths = [file[f"path_{i}"].T for i in range(samples.shape[2])]
            self.modes = np.moveaxis(file["modes"], 0, -1) if "modes" in file else None
            self.geometry = (
                {n: file[f"obstacles_{n}"] for n in ("circles", "bodies", "segments", "counts")}
                if "obstacles_circles" in file
                else None
            )
        kinds = self.about["robots"]
        sizes = [(k["robot"]["length"], k["robot"]["width"]) for k in kinds]
        self.sizes = [sizes[i] for i in self.about["robot"]]
        self.step = float(self.time[1] - self.time[0])
        self.touches = np.full(samples.shape[1], np.inf) if past_contacts else self._first_contacts()
        self.counted = self._up_to_contact()

    def __getitem__(self, name: str) -> Array:
        """A channel, up to the first contact of each run."""
        return np.where(self.counted[:, None], self.channels[name], np.nan)

    def _first_contacts(self) -> Array:
        """The time of the first contact of every run, infinite where there is none."""
        return np.array([first_contact(self, run) for run in range(self.channels["x"].shape[0])])

    def _up_to_contact(self) -> Array:
        return self.time[None] <= self.touches[:, None]


# Geometry ---------------------------------------------------------------------------------------------------------


def footprint(x: float, y: float, heading: float, size: tuple[float, float]) -> Polygon:
    """A robot's rectangle."""
    c, s, u, v = math.cos(heading), math.sin(heading), size[0] / 2, size[1] / 2
    corners = ((-u, -v), (u, -v), (u, v), (-u, v))
    return Polygon([(x + c * a - s * b, y + s * a + c * b) for a, b in corners])


def bodies(geometry: dict[str, Array], sample: int) -> list[Any]:
    """The obstacles at a sample."""
    k = min(sample, len(geometry["counts"]) - 1)
    found: list[Any] = []
    for (x, y, radius), (first, number, closed, _) in zip(
        geometry["circles"][k][: geometry["counts"][k]], geometry["bodies"][k], strict=False
    ):
        ends = geometry["segments"][k][first : first + number].reshape(-1, 2)
        found.append((Point(x, y), radius) if number == 0 else Polygon(ends[::2]) if closed else LineString(ends[:2]))
    return found


def gap(robot: Polygon, body: Any) -> float:
    """The distance from a robot's surface to a body; 0 or less in contact."""
    if isinstance(body, tuple):
        center, radius = body
        return float(robot.distance(center)) - float(radius)
    return float(robot.distance(body))


def pose(run: SavedRun, place: int, robot: int, time: float) -> tuple[float, float, float]:
    """A robot's pose between samples: the cubic through both with the recorded velocities.

    Where these are off the chord by more than half of the larger, the robot goes straight and turns evenly.
    """
    k = min(int(time / run.step + 1e-9), len(run.time) - 2)
    u = (time - run.time[k]) / run.step
    x, y, heading, v, w = (run.channels[n][place, robot, k : k + 2] for n in ("x", "y", "heading", "v", "w"))
    chord = np.array([x[1] - x[0], y[1] - y[0]])
    ends = run.step * v * np.array([np.cos(heading), np.sin(heading)])  # (2, both ends)
    larger = max(run.step * np.abs(v).max(), np.hypot(*chord))
    if not np.hypot(*(ends.mean(axis=1) - chord)) <= 0.5 * larger:
        ends = np.repeat(chord[:, None], 2, axis=1)
    turned, turns = heading[1] - heading[0], run.step * w
    if not abs(turns.mean() - turned) <= 0.5 * max(abs(turned), np.abs(turns).max()):
        turns = np.array([turned, turned])
    h10, h01, h11 = u * (1 - u) ** 2, u * u * (3 - 2 * u), u * u * (u - 1)
    place_x, place_y = (s[0] + h01 * c + h10 * e[0] + h11 * e[1] for s, c, e in zip((x, y), chord, ends, strict=True))
    return float(place_x), float(place_y), float(heading[0] + h01 * turned + h10 * turns[0] + h11 * turns[1])


def outlines(run: SavedRun, place: int, robot: int) -> Array:
    """The rectangles of a robot at all samples, as shapely's polygons; empty where it is nowhere."""
    length, width = run.sizes[robot]
    x, y, heading = (run.channels[n][place, robot] for n in ("x", "y", "heading"))
    c, s = np.cos(heading), np.sin(heading)
    corners = [(u * length / 2, v * width / 2) for u, v in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    points = np.stack([np.stack([x + c * u - s * v, y + s * u + c * v], axis=-1) for u, v in corners], axis=1)
    known = np.isfinite(points).all(axis=(1, 2))
    found = np.full(len(x), Polygon(), dtype=object)
    found[known] = shapely.polygons(points[known])
    return found


def meetings(run: SavedRun, place: int) -> Iterator[tuple[tuple[int, ...], Array, Callable[[float], float], Array]]:
    """Every pair that may meet: its robots, its distance at the samples, that at any time, and how fast it changes."""
    robots = range(len(run.sizes))
    shapes = [outlines(run, place, robot) for robot in robots]
    v, w = (np.abs(run.channels[name][place]) for name in ("v", "w"))
    fast = [scipy.ndimage.maximum_filter1d(np.nan_to_num(v[i] + 0.2 * w[i]), 5) * 1.3 + 0.002 for i in robots]
    for i in robots:
        for j in range(i + 1, len(run.sizes)):

            def between(t: float, i: int = i, j: int = j) -> float:
                a, b = (footprint(*pose(run, place, r, t), run.sizes[r]) for r in (i, j))
                return float(a.distance(b))

            yield (i, j), shapely.distance(shapes[i], shapes[j]), between, fast[i] + fast[j]
        if run.geometry is None:
            continue
        assert len(run.geometry["counts"]) == 1, "moving obstacles are not read here"
        for body in bodies(run.geometry, 0):

            def beside(t: float, i: int = i, body: Any = body) -> float:
                return gap(footprint(*pose(run, place, i, t), run.sizes[i]), body)

            solid, radius = body if isinstance(body, tuple) else (body, 0.0)
            yield (i,), shapely.distance(shapes[i], solid) - radius, beside, fast[i]


def around(run: SavedRun, k: int, number: int) -> Array:
    """So many times around a sample, up to its neighbours."""
    return np.clip(run.time[k] + np.linspace(-run.step, run.step, number), run.time[0], run.time[-1])


def first_contact(run: SavedRun, place: int) -> float:
    """The time of the first contact of a run, infinite where there is none."""
    found = math.inf
    if len(run.paths) == 1 and run.geometry is None:
        return found
    for _, sampled, at, fast in meetings(run, place):
        for k in np.flatnonzero(sampled < fast * run.step).tolist():
            if run.time[k] - run.step > found:
                break
            touched = next((float(t) for t in around(run, k, 101) if at(t) <= 0), None)
            if touched is not None:
                found = min(found, touched)
                break
    return found


def clearance(run: SavedRun, place: int) -> Array:
    """The least clearance of every robot of a run; not-a-number where it touches something."""
    least = np.full(len(run.sizes), np.inf)
    for pair, sampled, at, fast in meetings(run, place):
        low = float(np.nanmin(sampled))
        for k in np.argsort(sampled - fast * run.step).tolist():
            if not sampled[k] - fast[k] * run.step < low or low <= 0:
                break
            first, last = around(run, k, 2)
            near = scipy.optimize.minimize_scalar(at, bounds=(first, last), method="bounded", options={"xatol": 1e-9})
            low = min(low, float(near.fun), at(first), at(last))
        for i in pair:
            least[i] = np.minimum(least[i], low if low > 0 else math.nan)  # which keeps a not-a-number
    return least


@cache
def crossing(run: SavedRun) -> Array:
    """The distance of every sample from its robot's path (runs, robots, samples)."""
    found = np.full(run["x"].shape, np.nan)
    for i, nodes in enumerate(run.paths):
        path = LineString(nodes)
        shapely.prepare(path)
        x, y = run["x"][:, i], run["y"][:, i]
        known = np.isfinite(x)
        points = shapely.points(x[known], y[known])
        apart = shapely.distance(points, path)
        if np.hypot(*(nodes[0] - nodes[-1])) > 1e-6:  # past the end the part across the last chord counts
            chord = (nodes[-1] - nodes[-2]) / np.hypot(*(nodes[-1] - nodes[-2]))
            dx, dy = x[known] - nodes[-1, 0], y[known] - nodes[-1, 1]
            past = (shapely.line_locate_point(path, points) >= path.length) & (dx * chord[0] + dy * chord[1] > 0)
            apart = np.where(past, np.abs(chord[0] * dy - chord[1] * dx), apart)
        found[:, i][known] = apart
    return found


@cache
def progress(run: SavedRun) -> Array:
    """The share of its path that each robot has behind it, searched for within half a metre of the one before."""
    found: Array = np.full(run["x"].shape, np.nan)
    for i, nodes in enumerate(run.paths):
        a, b = nodes[:-1], nodes[1:]
        lengths = np.hypot(*(b - a).T)
        chords, total = len(lengths), lengths.sum()
        window = max(2, int(0.5 / (total / chords)))
        for r in range(len(found)):
            low, high = 0, max(2, int(0.25 * len(nodes)))
            for k, p in enumerate(np.stack([run["x"][r, i], run["y"][r, i]], axis=1)):
                if not np.isfinite(p[0]):
                    continue
                near = low + int(np.argmin(((nodes[low : high + 1] - p) ** 2).sum(1)))
                best, place = math.inf, 0.0
                for n in (near - 1, near):
                    if 0 <= n < chords:
                        t = float(np.clip((p - a[n]) @ (b[n] - a[n]) / lengths[n] ** 2, 0, 1))
                        d = float(np.hypot(*(a[n] + t * (b[n] - a[n]) - p)))
                        if d < best:
                            best, place = d, n + t
                found[r, i, k] = place / chords
                low, high = max(near - window, 0), min(near + window, chords)
    return found


# Quantities -------------------------------------------------------------------------------------------------------


def errors(run: SavedRun) -> tuple[Array, Array, Array]:
    """The posture error in the robot's frame."""
    x, y, heading = (run[n] for n in ("x", "y", "heading"))
    dx, dy, turn = run.reference[0] - x, run.reference[1] - y, run.reference[2] - heading
    turn = (turn + math.pi) % (2 * math.pi) - math.pi
    return np.cos(heading) * dx + np.sin(heading) * dy, np.cos(heading) * dy - np.sin(heading) * dx, turn


def norm(run: SavedRun) -> Array:
    """The error norm, 1 rad counted as 1 m."""
    ex, ey, turn = errors(run)
    return np.sqrt(ex**2 + ey**2 + turn**2)


def distance(run: SavedRun) -> Array:
    """The distance from the reference."""
    ex, ey, _ = errors(run)
    return np.hypot(ex, ey)


def settled(run: SavedRun, values: Array) -> Array:
    """The time from which values stay below 5 cm."""
    found = np.full(values.shape[:2], np.inf)
    for r, i in np.ndindex(*found.shape):
        outside = np.flatnonzero(~(np.abs(values[r, i]) < 0.05))
        k = outside[-1] + 1 if len(outside) else 0
        if k < len(run.time):
            found[r, i] = run.time[k]
    return found


def arrivals(run: SavedRun) -> Array:
    """The time at which 99.5 % of the path are driven, by its end's tangent, at most 10 cm beside it and beyond."""
    there = np.zeros(run["x"].shape, dtype=bool)
    for i, nodes in enumerate(run.paths):
        there[:, i] = at_end(run["x"][:, i], run["y"][:, i], nodes) & (progress(run)[:, i] > 0.5)
    return np.where(there.any(-1), run.time[np.argmax(there, -1)], np.inf)


def at_end(x: Array, y: Array, nodes: Array) -> Array:
    """Whether a place is at the end of a path: in a box about it."""
    along = (nodes[-1] - nodes[-2]) / np.hypot(*(nodes[-1] - nodes[-2]))
    place = np.stack([x, y], axis=-1) - nodes[-1]
    beyond, beside = place @ along, place @ [-along[1], along[0]]
    return (beyond >= -0.005 * length(nodes)) & (beyond <= 0.1) & (np.abs(beside) < 0.1)


def spread(times: Array) -> Array:
    """Last minus first, the same for every robot."""
    with np.errstate(invalid="ignore"):
        apart = np.where(np.isfinite(times).all(1), times.max(1) - times.min(1), np.inf)
    return np.repeat(apart[:, None], 1, axis=1)


def longest(run: SavedRun, flags: Array) -> Array:
    """The longest stretch of time in which flags hold."""
    found = np.zeros(flags.shape[:2])
    for r, i in np.ndindex(*found.shape):
        text = "".join("1" if f else "0" for f in flags[r, i])
        found[r, i] = max((len(part) for part in re.findall("1+", text)), default=0) * run.step
    return found


def standing(run: SavedRun) -> Array:
    """The longest stop on the way."""
    ends = arrivals(run)
    ends = np.where(np.isfinite(ends), ends, run.time[-1])[..., None] - 0.5
    return longest(run, (np.abs(run["v"]) < 0.01) & (run.time > 2.0) & (run.time < ends))


def left(run: SavedRun) -> Array:
    """The longest time in which the group went on without the robot."""
    if run.modes is None:
        return np.zeros(run["x"].shape[:2])
    return longest(run, (run.modes & LEFT_BEHIND > 0) & (run.modes < STOPPED))


def lead(run: SavedRun) -> tuple[Array, Array]:
    """Of a formation: the leader's x minus the followers' mean, and the sample at which the leader ends."""
    x = run["x"]
    there = x[:, 0] >= run.paths[0][-1, 0] - 0.01
    return x[:, 0] - x[:, 1:].mean(axis=1), np.where(there.any(-1), np.argmax(there, -1), -1)


def length(nodes: Array) -> float:
    """The length of a path."""
    return float(np.hypot(*np.diff(nodes, axis=0).T).sum())


def alignment(run: SavedRun) -> Array:
    """The time from which the leader is level with its followers, until its end."""
    gaps, last = lead(run)
    found = np.full((len(last), 1), np.inf)
    for r, end in enumerate(last):
        if end >= 0:
            apart = np.flatnonzero(~(np.abs(gaps[r, : end + 1]) < 0.1))
            k = apart[-1] + 1 if len(apart) else 0
            if k <= end:
                found[r, 0] = run.time[k]
    return found


def lateral(run: SavedRun) -> Array:
    """The largest distance from the own path until the leader's end."""
    _, last = lead(run)
    cross = crossing(run)
    return np.array(
        [np.nanmax(c[:, : (end + 1) if end >= 0 else None], axis=-1) for c, end in zip(cross, last, strict=True)]
    )


def rms(values: Array) -> Array:
    """The root mean square over time."""
    return np.sqrt(np.mean(values**2, axis=-1))


def least_clearance(run: SavedRun) -> Array:
    """The least clearance of each robot."""
    return np.array([clearance(run, place) for place in range(run.channels["x"].shape[0])])


def separated(run: SavedRun) -> Array:
    """∫ Σ |z_i − z_j| dt from 10 s on."""
    z = progress(run)[..., run.time >= 10.0]
    apart = sum(np.abs(z[:, i] - z[:, j]) for i in range(z.shape[1]) for j in range(i))
    return np.nansum(apart, axis=-1)[:, None] * run.step


QUANTITIES: dict[str, Callable[[SavedRun], Array]] = {
    "mean_error_norm": lambda r: np.nanmean(norm(r), axis=-1),
    "timetable_error_norm": lambda r: np.nanmean(norm(r), axis=-1),
    "late_error_norm": lambda r: np.mean(norm(r)[..., r.time > 6.0], axis=-1),
    "mean_speed_error_mps": lambda r: np.nanmean(np.abs(r["v_demand"] - r["v"]), axis=-1),
    "settling_time_s": lambda r: settled(r, distance(r)),
    "path_settling_time_s": lambda r: settled(r, crossing(r)),
    "last_distance_m": lambda r: rms(distance(r)[..., r.time > r.time[-1] - 5.0]),
    "largest_distance_m": lambda r: np.nanmax(distance(r), axis=-1),
    "late_cross_track_m": lambda r: rms(crossing(r)[..., (r.time > 15.0) & (r.time < 20.0)]),
    "rms_cross_track_m": lambda r: np.sqrt(np.nanmean(crossing(r) ** 2, axis=-1)),
    "max_cross_track_m": lambda r: np.nanmax(crossing(r), axis=-1),
    "settles": lambda r: np.isfinite(settled(r, distance(r))),
    "arrival_spread_s": lambda r: spread(arrivals(r)),
    "others_spread_s": lambda r: spread(arrivals(r)[:, 1:]),
    "max_progress_gap": lambda r: np.nanmax(np.ptp(progress(r), axis=1), axis=-1)[:, None],
    "short_of_goal_m": lambda r: (
        (1 - np.nanmax(progress(r), axis=-1)) * [np.hypot(*np.diff(p, axis=0).T).sum() for p in r.paths]
    ),
    "stood_s": standing,
    "off_path_s": lambda r: longest(r, crossing(r) > 0.1),
    "left_behind_s": left,
    "alignment_time_s": alignment,
    "max_lateral_error_m": lateral,
    "untouched": lambda r: ~np.isfinite(r.touches)[:, None],
    "min_clearance_m": least_clearance,
    "separation_s": separated,
}
SMALLEST = {"untouched", "min_clearance_m", "settles"}  # the worst robot is the one with the least


def of_runs(run: SavedRun, quantity: str, robot: str) -> Array:
    """One number a run."""
    values = QUANTITIES[quantity](run)
    if robot == "mean":
        return values.mean(axis=1)
    if robot != "worst":
        return values[:, int(robot) - 1]
    return values.min(axis=1) if quantity in SMALLEST else values.max(axis=1)


# Of several files ------------------------------------------------------------------------------------------------


def of_sweep(folder: Path, row: dict[str, str]) -> Array | None:
    """Whether an order of Table 2.1 holds in each run of the sweep around it."""
    values: dict[str, list[Array]] = {}
    for mode in ("csm", "assm", "qssm", "esm"):
        files = sorted(folder.glob(f"conditions_of_Table_2.1_*--{row['of']}-{mode}.npz"), key=number)
        runs = [SavedRun(file) for file in files]
        both = [[QUANTITIES[n](run)[:, 0] for run in runs] for n in ("mean_error_norm", "mean_speed_error_mps")]
        if not runs:
            return None
        values[mode] = [np.concatenate(each) for each in both]

    def least(mode: str, place: int, sign: int = 1) -> Array:
        others = [sign * found[place] for name, found in values.items() if name != mode]
        return np.asarray(sign * values[mode][place] < np.min(others, axis=0))

    precise, quiet = least("esm", 0), least("esm", 1)
    return {
        "all_four_orders": precise & quiet & least("csm", 0, -1) & least("csm", 1, -1),
        "esm_most_precise": precise,
        "esm_chatters_least": quiet,
        "esm_chatters_less_than_csm": values["esm"][1] < values["csm"][1],
    }[row["quantity"]]


def number(file: Path) -> int:
    """The number before a law in the name of a file."""
    return int(re.findall(r"_(\d+)--", file.name)[-1])


def of_outage(folder: Path, row: dict[str, str]) -> Array | None:
    """Whether a team is together again after an outage: within 5 % and 10 cm for good, before 97 % of the way."""
    file = folder / file_of(row, row["of"])
    if not file.exists():
        return None
    run = SavedRun(file, past_contacts=True)
    # Both faults begin between 5 and 35 s, drawn from the stream 4 of each seed
    drawn = [np.random.default_rng([seed, 4]).random(2) for seed in run.seeds.tolist()]
    ends = 5.0 + 30.0 * np.max(drawn, axis=1) + float(row["on"].split()[2])
    z, off = progress(run), crossing(run).max(axis=1)
    good = (np.ptp(z, axis=1) < 0.05) & (off < 0.1)
    found = []
    for n, end in enumerate(ends):
        after = np.flatnonzero(run.time >= end)
        bad = after[~good[n, after]]
        back = bad[-1] + 1 if len(bad) else after[0]
        found.append(back < len(run.time) and z[n, :, back].max() < 0.97)
    return np.array(found)


def of_crossings(folder: Path, row: dict[str, str]) -> Array | None:
    """Whether all robots of a random crossing come to their ends, and none touches another before."""
    found = []
    for file in sorted(folder.glob(f"random_crossings_*--{row['of']}.npz"), key=number):
        run = SavedRun(file)
        x, y = run.channels["x"][0], run.channels["y"][0]
        there = [at_end(*place) for place in zip(x, y, run.paths, strict=True)]
        last = max(run.time[np.argmax(row)] if row.any() else np.inf for row in there)
        found.append(np.isfinite(last) and not run.touches[0] <= last)
    return np.array(found) if found else None


SEVERAL: dict[str, Callable[[Path, dict[str, str]], Array | None]] = {
    "all_four_orders": of_sweep,
    "esm_most_precise": of_sweep,
    "esm_chatters_least": of_sweep,
    "esm_chatters_less_than_csm": of_sweep,
    "recovers": of_outage,
    "arrive_untouched": of_crossings,
}


# Intervals --------------------------------------------------------------------------------------------------------


def estimate(values: Array) -> tuple[float, float, float]:
    """The mean of what is finite, with Student's interval, or of booleans the share with Wilson's."""
    if values.dtype == bool:
        n, mean = len(values), float(np.mean(values))
        if n == 1:
            return mean, mean, mean
        z = 1.959963984540054
        middle, half = mean + z * z / (2 * n), z * math.sqrt(mean * (1 - mean) / n + z * z / (4 * n * n))
        low, high = ((middle + sign * half) / (1 + z * z / n) for sign in (-1, 1))
        return mean, 0.0 if mean == 0 else low, 1.0 if mean == 1 else high
    if np.isinf(values).all():
        return values[0], values[0], values[0]
    known = values[~np.isinf(values)]
    n, mean = len(known), float(np.mean(known))
    if len(values) == 1:
        return mean, mean, mean
    half = float(scipy.stats.t.ppf(0.975, n - 1)) * float(np.std(known, ddof=1)) / math.sqrt(n) if n > 1 else math.inf
    return mean, mean - half, mean + half


def compared(ours: Array, others: list[Array], more: bool) -> tuple[float, float, float]:
    """Ours minus the best other; or how often ours is not better, where a value is infinite."""
    rival = np.max(others, axis=0) if more else np.min(others, axis=0)
    if np.isfinite(ours).all() and np.isfinite(rival).all():
        return estimate(ours - rival)
    return estimate(~(ours > rival if more else ours < rival))


def outcome(low: float, high: float, row: dict[str, str]) -> str:
    """Which side of the bound the interval lies on, if that is sure among all parts."""
    bound = float(row["bound"])
    if row["adjusted"] and float(row["adjusted"]) >= 0.05:
        return "open"
    if row["sense"] == "above":
        low, high, bound = -high, -low, -bound
    return "holds" if high < bound else "fails" if low >= bound else "open"


def adjusted(rows: list[dict[str, str]]) -> list[float]:
    """The p-values of all rows that depend on chance, by their numbers, by Holm's step-down; not-a-number of others."""
    p_values = np.full(len(rows), np.nan)
    for k, row in enumerate(rows):
        value, low, high, bound, runs = (float(row[n]) for n in ("value", "low", "high", "bound", "runs"))
        if row["kind"] == "rate":
            p_values[k] = 2 * scipy.stats.norm.sf(abs(value - bound) / math.sqrt(bound * (1 - bound) / runs))
        elif row["kind"] == "mean":
            half, t = (high - low) / 2, scipy.stats.t(runs - int(row["lost"]) - 1)
            p_values[k] = float(value == bound) if half == 0 else 1.0
            if 0 < half < math.inf:
                p_values[k] = 2 * t.sf(abs(value - bound) / half * t.ppf(0.975))
    order = [k for k in np.argsort(p_values) if not np.isnan(p_values[k])]
    least = 0.0
    for place, k in enumerate(order):
        least = p_values[k] = max(least, min(1.0, (len(order) - place) * p_values[k]))
    return list(p_values)


def file_of(row: dict[str, str], law: str) -> str:
    """The file of a law's runs."""
    plain = re.sub(r"[^A-Za-z0-9.=-]+", "_", f"{row['on']}--{law}")
    return f"{plain}{'--ideal' if row['form'] == 'ideal' else ''}.npz"


def recompute(folder: Path) -> tuple[float, int, list[str]]:
    """The largest relative difference, how many rows of evidence.csv were computed again, and what differs."""
    runs: dict[str, SavedRun] = {}
    worst, done, wrong = 0.0, 0, []
    with (folder / "evidence.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    for row, p in zip(rows, adjusted(rows), strict=True):
        if row["adjusted"] and not abs(float(row["adjusted"]) - p) <= TOLERANCE:
            wrong.append(f"{row['claim']}, {row['form']}, {row['says']}: p {row['adjusted']}, recomputed {p}")
        laws = [row["of"], *filter(None, row["against"].split("; "))]
        files = [file_of(row, law) for law in laws]
        others: list[Array] = []
        if row["quantity"] in SEVERAL:
            several = SEVERAL[row["quantity"]](folder / "runs", row)
            if several is None:
                continue
            ours = several
        elif row["quantity"] in QUANTITIES and all((folder / "runs" / name).exists() for name in files):
            for name in files:
                if name not in runs:  # robots at random starts are each in a world of their own
                    runs[name] = SavedRun(folder / "runs" / name, past_contacts=row["on"] == "random starts")
            ours, *others = (of_runs(runs[name], row["quantity"], row["robot"]) for name in files)
            if row["on"] == "random starts":  # a robot for each start
                ours = QUANTITIES[row["quantity"]](runs[files[0]])[0]
        else:
            continue
        more = bool(others) and row["sense"] == "above"
        if row["limit"]:
            ours = ours > float(row["limit"]) if row["limit_sense"] == "above" else ours < float(row["limit"])
        again = compared(ours, others, more) if others else estimate(ours)
        for name, found in zip(("value", "low", "high"), again, strict=True):
            told = float(row[name])
            if math.isnan(found):  # of overlaps, whose depth is not computed here
                continue
            apart = 0.0 if told == found else abs(told - found) / max(1.0, abs(told))
            worst = max(worst, apart)
            if not apart <= TOLERANCE:
                wrong.append(f"{row['claim']}, {row['form']}, {row['says']}: {name} {told!r}, recomputed {found!r}")
        if not math.isnan(again[0]) and outcome(*again[1:], row) != row["outcome"]:
            wrong.append(f"{row['claim']}, {row['form']}, {row['says']}: the outcome is another")
        done += 1
    return worst, done, wrong


if __name__ == "__main__":
    largest, count, differing = recompute(Path(sys.argv[1]))
    print(f"{count} numbers recomputed, the largest difference is {largest:.2g}", *differing, sep="\n")
    sys.exit(bool(differing) or count == 0)
