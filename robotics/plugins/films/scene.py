"""The moving picture of a run, frame by frame: the scene from above, and below it a chart with a moving cursor."""

from typing import Any, TypeVar

import numpy as np
from matplotlib import patheffects
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection, PolyCollection

from fuzzy.figures.drawing import DOUBLE, LINES, new_figure
from fuzzy.figures.palette import COLORS
from robotics.laws.modes import MODES, STOPPED
from robotics.measures.contacts import who
from robotics.measures.standing import stands_still
from robotics.show.figures.drawing import (
    CONTACT,
    MODE_COLORS,
    MODE_LINES,
    OBSTACLE,
    TARGET,
    draw_line,
    draw_obstacles,
    draw_patches,
    placed,
    split_outlines,
    strided,
)
from robotics.show.figures.faults import FEW_ROBOTS, HATCHES, WORDS, shade_faults
from robotics.show.playback.replay import Replay
from robotics.simulation.spans import FAULT_KINDS

_MANY_LINKS = 400  # of more links only the stale ones are drawn
_STANDS = 0.005, 0.05  # m/s and rad/s: a robot that is slower is drawn hollow
_LEFT, _RIGHT, _TITLE, _CHART, _GAP, _NOTE = 0.55, 0.15, 0.3, 1.25, 0.5, 0.4  # inches
_STILL = ("figure", "film", "enlarged", "sizes")  # what of a scene does not move
_OUTLINE = [patheffects.withStroke(linewidth=2.5, foreground="white")]


_Collection = TypeVar("_Collection", PolyCollection, LineCollection)


class Scene:
    """A figure of a replay, and the parts of it that move."""

    def __init__(self, film: Replay, speed: float, dpi: float) -> None:
        left, right, bottom, top = film.bounds
        around = max(round(robot.turning_circle, 2) for robot in film.run.about.robots)
        margin = 0.03 * max(right - left, top - bottom) + around
        wide = DOUBLE - _LEFT - _RIGHT
        high = float(np.clip(wide * (top - bottom + 2 * margin) / (right - left + 2 * margin), 1.6, 5.2))
        scale = min(wide / (right - left + 2 * margin), high / (top - bottom + 2 * margin))  # inches a metre
        height = _TITLE + high + _GAP + _NOTE + 0.12 * ((film.modes is not None) + bool(film.contacts)) + _CHART + _GAP
        # A video has an even number of pixels each way.
        figure = new_figure(2 * round(DOUBLE * dpi / 2) / dpi, 2 * round(height * dpi / 2) / dpi, constrained=False)
        ax = figure.add_axes((_LEFT / DOUBLE, 1 - (_TITLE + high) / height, wide / DOUBLE, high / height))
        x, y = (left + right) / 2, (bottom + top) / 2
        ax.set(xlim=(x - wide / scale / 2, x + wide / scale / 2), ylim=(y - high / scale / 2, y + high / scale / 2))
        ax.set(xlabel="x [m]", ylabel="y [m]")
        chart = figure.add_axes((_LEFT / DOUBLE, _GAP / height, wide / DOUBLE, _CHART / height))
        robots, few = len(film.x), len(film.x) <= FEW_ROBOTS
        sizes = np.array([(robot.length, robot.width) for robot in film.run.about.robots])
        least = 0.16 if few else 0.09 if robots <= 60 else 0.07  # inches
        # Among obstacles a robot that is drawn too large would seem to touch them.
        enlarged = 1.0 if film.obstacles is not None else max(1.0, least / (sizes[:, 0].min() * scale))
        colors = [COLORS[i % len(COLORS)] for i in range(robots)]
        for nodes in film.run.paths:
            quiet = TARGET if few else TARGET | {"linewidth": 0.5, "alpha": 0.5}
            ax.plot(*strided(*nodes), **quiet, zorder=1)
        _draw_chart(chart, film, colors)
        figure.text(_LEFT / DOUBLE, 1 - 0.2 / height, film.title, parse_math=False, fontsize=9)
        note = _note(film, enlarged, speed)
        figure.text(_LEFT / DOUBLE, (_GAP + _CHART + 0.13) / height, note, fontsize=6.5, color="0.35")
        thin = 1.2 if few else 0.7
        draw_patches(ax, film.run.about.patches)
        if film.obstacles is not None and len(film.obstacles.counts) == 1:
            draw_obstacles(ax, film.obstacles_at(film.time[0]))

        def empty(kind: type[_Collection], **look: Any) -> _Collection:
            made = kind([], **look)
            ax.add_collection(made, autolim=False)
            return made

        aims, clear = np.zeros(robots), {"facecolors": "none", "zorder": 6}
        name: dict[str, Any] = {"fontsize": 7, "fontweight": "bold", "path_effects": _OUTLINE, "zorder": 9}
        self.figure, self.film = figure, film
        self.enlarged = enlarged  # how many times their size the robots are drawn
        self.sizes = sizes * enlarged  # (robots, 2) m: their lengths and widths, as drawn
        self.bodies = empty(PolyCollection, edgecolors=colors, linewidths=thin, zorder=5)
        self.wheels = empty(PolyCollection, facecolors="0.2", linewidths=0, zorder=6.5)  # all right ones, then the left
        self.marks = empty(PolyCollection, linewidths=0, zorder=7)  # which way they head
        self.hatched = {kind: empty(PolyCollection, hatch=HATCHES[kind], **clear) for kind in FAULT_KINDS.values()}
        self.trails = empty(LineCollection, colors=colors, linewidths=thin, zorder=2)
        self.fresh = empty(LineCollection, colors="black", linewidths=0.6, alpha=0.5 if few else 0.25, zorder=3)
        self.old = empty(LineCollection, colors="black", linewidths=0.8, linestyles=[(0, (3, 3))], zorder=3)
        self.rings = empty(LineCollection, linewidths=2.0 if few else 1.2, zorder=4.5)  # what a robot does but track
        self.solids = empty(PolyCollection, **OBSTACLE, zorder=1.5)  # obstacles, if some move
        self.walls = empty(LineCollection, colors="0.3", linewidths=2.0, zorder=1.5)
        self.targets = ax.scatter(aims, aims, marker="+", s=30 if few else 8, c=colors, linewidths=thin, zorder=4)
        self.stops = ax.plot([], [], "x", color="black", markersize=10, markeredgewidth=1.5, zorder=8)[0]
        self.touches = ax.plot([], [], **CONTACT | {"markersize": 12, "zorder": 8.5})[0]  # where contacts have begun
        # Numbers of the robots, if few; else of those at fault
        self.labels = [ax.text(0, 0, "", **name, clip_on=True) for _ in range(robots)]
        corner = 1 - _RIGHT / DOUBLE, 1 - 0.2 / height
        self.clock = figure.text(*corner, "", ha="right", fontsize=9, fontfamily="monospace")
        self.cursor = chart.axvline(film.time[0], color="black", linewidth=1.0)


def set_scene(film: Replay, speed: float, dpi: float) -> Scene:
    """Draw the figure before its first frame; use it within the project's style.

    Robots are drawn to scale, or enlarged where they would be too small to see; the note under the scene says which.
    The parts that do not move are a picture in the background: a frame is then drawn several times faster.

    Args:
        film: The replay.
        speed: Times real time, which the note says.
        dpi: Pixels per inch of the frames.
    """
    scene = Scene(film, speed, dpi)
    figure, moving = scene.figure, _moving(scene)
    drawn = [figure.patch, *figure.texts, *(artist for ax in figure.axes for artist in ax.get_children())]
    still = [artist for artist in drawn if artist.get_visible() and artist not in moving]
    for artist in moving:
        artist.set_visible(False)
    canvas = FigureCanvasAgg(figure)
    before, figure.dpi = figure.dpi, dpi
    canvas.draw()
    background = np.asarray(canvas.buffer_rgba())[::-1].copy()
    figure.dpi = before
    for artist in still:
        artist.set_visible(False)
    for artist in moving:
        artist.set_visible(True)
    figure.add_artist(_Backdrop(background))
    return scene


class _Backdrop(Artist):
    """Pixels behind everything, as they are: figimage would resample them for every frame."""

    def __init__(self, pixels: np.ndarray) -> None:
        super().__init__()
        self.pixels = pixels  # (rows, columns, 4), the lowest row first
        self.set_zorder(-10)

    def draw(self, renderer: Any) -> None:
        """Put the pixels into the lower left corner."""
        renderer.draw_image(renderer.new_gc(), 0, 0, self.pixels)


def _moving(scene: Scene) -> set[Artist]:
    parts = [part for name, part in vars(scene).items() if name not in _STILL]
    several = [p.values() if isinstance(p, dict) else p if isinstance(p, list) else [p] for p in parts]
    return {artist for each in several for artist in each}


def _wheels(scene: Scene, side: int) -> np.ndarray:
    """The outlines (robots, 4, 2) of the right (-1) or left (1) wheels in the robots' frames [m], as drawn."""
    radius = np.array([robot.wheel_radius for robot in scene.film.run.about.robots])[:, None]
    half = np.array([robot.half_axle for robot in scene.film.run.about.robots])[:, None]
    ahead, aside = radius * [-1, 1, 1, -1], side * half + 0.2 * radius * [-1, -1, 1, 1]
    return np.asarray(scene.enlarged * np.stack([ahead, aside], axis=-1))


def show_frame(scene: Scene, time: float) -> None:
    """Move everything in the figure to ``time`` [s]."""
    film, now = scene.film, scene.film.at(time)
    few, x, y, heading = len(film.x) <= FEW_ROBOTS, now.x, now.y, now.heading
    kinds = [film.kind_at(i, time) for i in range(len(x))]
    stopped = film.stops <= time
    still = stands_still(now.v, _STANDS[0]) & stands_still(now.w, _STANDS[1])
    at_fault = np.array([bool(kind) for kind in kinds])
    hollow = still | stopped | at_fault
    colors = np.array([COLORS[i % len(COLORS)] for i in range(len(x))])
    body = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]]) * scene.sizes[:, None]
    arrow = np.array([[0.44, 0.0], [-0.3, 0.24], [-0.3, -0.24]]) * scene.sizes[:, None]
    outlines, arrows = placed(body, x, y, heading), placed(arrow, x, y, heading)
    scene.bodies.set_verts(list(outlines))
    scene.wheels.set_verts([wheel for side in (-1, 1) for wheel in placed(_wheels(scene, side), x, y, heading)])
    scene.bodies.set_facecolor(list(np.where(hollow, "white", colors)))
    scene.marks.set_verts(list(arrows))
    scene.marks.set_facecolor(list(np.where(at_fault, "black", np.where(hollow, colors, "white"))))
    for kind, collection in scene.hatched.items():
        collection.set_verts([outlines[i] for i, name in enumerate(kinds) if name == kind])
    places = np.stack([x, y], axis=-1)
    begin = 0 if len(x) <= 20 else int(np.searchsorted(film.time, time - 10))  # of many robots the last 10 s
    end = int(np.searchsorted(film.time, time, side="right"))
    driven = np.stack([film.x, film.y], axis=-1)[:, begin:end]
    scene.trails.set_segments(list(np.concatenate([driven, places[:, None]], axis=1)))
    scene.targets.set_offsets(np.stack([now.x_target, now.y_target], axis=-1))
    _show_links(scene, time, places)
    if film.obstacles is not None and len(film.obstacles.counts) > 1:
        solids, walls = split_outlines(film.obstacles_at(time))
        scene.solids.set_verts(solids)
        scene.walls.set_segments(walls)
    doing = [film.mode_at(i, time) for i in range(len(x))]
    _show_modes(scene, doing, places)
    scene.stops.set_data(x[stopped], y[stopped])
    begun = [contact for contact in film.contacts if contact.start <= time + 1e-9]
    scene.touches.set_data([contact.x for contact in begun], [contact.y for contact in begun])
    shifts = 0.4 * np.hypot(*scene.sizes.T)
    for i, (label, kind) in enumerate(zip(scene.labels, kinds, strict=True)):
        about = MODES[doing[i]] if 0 < doing[i] < STOPPED and (few or doing[i] > 3) else ""
        trouble = "stopped" if stopped[i] else WORDS.get(kind, about)
        label.set_text(f"{i + 1}: {trouble}" if trouble else f"{i + 1}" if few else "")
        label.set_position((x[i] + shifts[i], y[i] + shifts[i]))
    scene.clock.set_text(f"t = {time:6.2f} s")
    scene.cursor.set_xdata([time, time])


def _show_modes(scene: Scene, doing: list[int], places: np.ndarray) -> None:
    """A ring around every robot that does something else than track; the label says what."""
    busy = [i for i, code in enumerate(doing) if 0 < code < STOPPED]
    angle, radii = np.linspace(0, 2 * np.pi, 33), 0.62 * np.hypot(*scene.sizes.T)
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    scene.rings.set_segments([places[i] + radii[i] * circle for i in busy])
    if busy:
        scene.rings.set_color([MODE_COLORS[doing[i] & 3] for i in busy])
        scene.rings.set_linestyle([MODE_LINES[doing[i] & 3] for i in busy])


def _show_links(scene: Scene, time: float, places: np.ndarray) -> None:
    """The half of each line that is at a robot tells how fresh what it hears of the other is."""
    film = scene.film
    if film.hears is None:
        return
    receivers, senders, ages = film.stale.at(time)
    receivers, senders = receivers.astype(int), senders.astype(int)
    young = film.hears.copy()
    young[receivers, senders] = False
    heard = np.isfinite(ages)
    old = _halves(places, receivers[heard], senders[heard])
    scene.old.set_segments(list(old))
    # They fade with age; and many lines must not hide the robots.
    fading = np.maximum(0.5, np.exp(-(ages[heard] - film.stale_after) / 8))
    colors = np.zeros((len(old), 4))
    colors[:, 3] = (0.3 if len(old) > 100 else 0.8) * fading
    scene.old.set_color(list(colors))
    many = int(film.hears.sum()) > _MANY_LINKS
    scene.fresh.set_segments([] if many else list(_halves(places, *np.nonzero(young))))


def _halves(places: np.ndarray, receivers: np.ndarray, senders: np.ndarray) -> np.ndarray:
    """From every receiver half the way to the sender: (links, 2, 2)."""
    return np.stack([places[receivers], (places[receivers] + places[senders]) / 2], axis=1)


def _draw_chart(ax: Axes, film: Replay, colors: list[str]) -> None:
    """Progress over time, or without such a thing the distance to the target; faults shaded and named."""
    few = len(film.x) <= FEW_ROBOTS
    values = film.progress
    if values is None:
        values = np.hypot(film.x_target - film.x, film.y_target - film.y)
    for i, row in enumerate(values):
        row = np.where(film.time > film.stops[i], np.nan, row)
        line = LINES[i % len(LINES)] if few else "-"
        look = {"linewidth": 1.1, "alpha": 1.0} if few else {"linewidth": 0.5, "alpha": 0.6}
        draw_line(ax, film.time, row, color=colors[i], linestyle=line, label=f"{i + 1}", **look)
    ax.set(xlim=(film.time[0], film.time[-1]), xlabel="time [s]")
    ax.set_ylabel("progress s" if film.progress is not None else "to the target [m]")
    shade_faults(ax, film.faults, film.time[0], film.time[-1])
    if film.modes is not None:
        _draw_modes(ax, film, few)
    if few:
        ax.legend(loc="lower right", bbox_to_anchor=(1.0, 0.98), ncol=FEW_ROBOTS, handlelength=2.2)


def _draw_modes(ax: Axes, film: Replay, few: bool) -> None:
    """Above the time axis a row a robot, coloured while it does something else than track; changes of mode as ticks."""
    assert film.modes is not None
    across = ax.get_xaxis_transform()
    rows = len(film.modes) if few else 0
    for i in range(rows):
        level = 0.03 + 0.05 * (rows - 1 - i)
        for code in (1, 2, 3):
            busy = np.where((film.modes[i] & 3 == code) & (film.modes[i] < STOPPED), level, np.nan)
            look: dict[str, Any] = {"color": MODE_COLORS[code], "linestyle": MODE_LINES[code], "linewidth": 3.0}
            ax.plot(film.time, busy, transform=across, **look)
    ticks = [[(event.time, 0.0), (event.time, 0.03 + 0.05 * rows)] for event in film.handovers]
    ax.add_collection(
        LineCollection(ticks, colors="0.3", linewidths=0.6, linestyles="-", transform=across), autolim=False
    )


def _note(film: Replay, enlarged: float, speed: float) -> str:
    size = f"robots drawn {enlarged:.1f} times their size" if enlarged > 1.05 else "robots to scale"
    parts = [f"{speed:g} times real time", "dashed: path", "+: target", size, "outline only: standing"]
    if film.faults:
        parts.append("hatched: a robot with a fault")
    if film.run.about.patches:
        parts.append("hatched floor: other friction")
    lines = ["; ".join(parts)]
    if film.contacts:
        named = [f"{who(c.robot, c.other, c.obstacle)} at {c.start:.2f} s" for c in film.contacts[:3]]
        more = f", and {len(film.contacts) - 3} more" if len(film.contacts) > 3 else ""
        lines.insert(0, f"⊗ contact: {', '.join(named)}{more}")
    if film.hears is not None:
        links = f"half a line at a robot: what it hears of the other, dashed if older than {film.stale_after:g} s"
        lines.append(links + ("; only the latter drawn" if int(film.hears.sum()) > _MANY_LINKS else ""))
    if film.modes is not None:
        meaning = "orange: avoiding, pink dashed: along the wall, light blue dotted: yielding; ticks: changes of mode"
        lines.insert(0, f"ring, and bars in the chart (robot 1 on top): {meaning}")
    return "\n".join(lines)
