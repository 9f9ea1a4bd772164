"""Moving pictures of a run as files: .gif by Pillow, .mp4 by ffmpeg; a .html is the player's."""

import shutil
import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from io import BytesIO
from math import ceil
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from fuzzy.errors import InputError
from fuzzy.extras import install_command
from fuzzy.figures.drawing import COLORS, style
from fuzzy.files.atomic import check_target, replacing
from robotics.plugins.films.scene import set_scene, show_frame
from robotics.show.playback.replay import replay
from robotics.simulation.run import Run
from robotics.simulation.spans import span

_FORMATS = ("mp4", "gif", "html")
FPS = {"mp4": 20.0, "gif": 10.0}  # frames a second, if nothing else is asked for
ANIMATION_DPI = 120
SLOWEST = 1e-3  # times real time, and frames a second
_SPEEDS = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000)
_LASTS = 25.0  # s: with the default speed a picture lasts no longer
_MOST_SAMPLES = 4000  # samples of the trails and the chart, at most
_MOST_PIXELS = 1.5e9  # pixels of all frames of a .gif, which are in memory at the same time


class AnimationError(InputError):
    """A moving picture that cannot be made. The message says which option is wrong and what is accepted."""


class FrameTiming(NamedTuple):
    """The times of the frames of a moving picture."""

    times: np.ndarray  # (frames,) s of the run
    fps: float  # frames a second of the picture
    speed: float  # times real time


class Written(NamedTuple):
    """What :func:`write_animation` wrote."""

    frames: int
    fps: float
    speed: float  # times real time
    seconds: float  # how long it lasts
    enlarged: float  # how many times their size the robots are drawn


def check_animation(path: str | Path) -> str:
    """The format that ``path`` ends in, one of FORMATS.

    Raises AnimationError for any other, or without ffmpeg, TargetError for a place where no file can be written.
    """
    suffix = Path(path).suffix[1:].lower()
    if suffix not in _FORMATS:
        raise AnimationError(f"a moving picture needs a name that ends in .mp4, .gif or .html, got {str(path)!r}")
    if suffix == "mp4" and ffmpeg() is None:
        raise AnimationError(
            f"{path}: a .mp4 needs ffmpeg, which is not on this machine ({install_command('video')} brings one); "
            ".gif and .html need no ffmpeg"
        )
    check_target(path)
    return suffix


def ffmpeg() -> str | None:
    """The path of ffmpeg, the machine's own or that of the optional package imageio-ffmpeg; None if there is none."""
    own = shutil.which("ffmpeg")
    if own is not None:
        return own
    try:
        from imageio_ffmpeg import get_ffmpeg_exe  # type: ignore[import-not-found,unused-ignore]

        return str(get_ffmpeg_exe())
    except (ImportError, RuntimeError):
        return None


def frame_times(
    run: Run,
    suffix: str,
    *,
    start: float | None = None,
    end: float | None = None,
    fps: float | None = None,
    speed: float | None = None,
) -> FrameTiming:
    """The times of the frames of a .mp4 or .gif, the last of them at ``end``.

    Args:
        run: The run.
        suffix: "mp4" or "gif".
        start: The time [s] at which the picture begins, by default that of the run.
        end: The time [s] at which it ends, by default that of the run.
        fps: Frames a second, by default 20 (.gif: 10). A .gif counts hundredths of a second: its ``fps`` becomes the
            nearest that it can keep.
        speed: Times real time, by default the least of 1, 2, 5, 10, ... with which it lasts at most 25 s.

    Raises AnimationError, ReplayError.
    """
    begin, until = span(run, start, end)
    for name, value, most in (("fps", fps, 100 if suffix == "mp4" else 50), ("speed", speed, 1e4)):
        if value is not None and not SLOWEST <= value <= most:
            raise AnimationError(f"{name} must be >= {SLOWEST:g} and <= {most:g} for a .{suffix}, got {value:g}")
    rate = FPS[suffix] if fps is None else fps
    if suffix == "gif":
        rate = 100 / max(2, round(100 / rate))
    if speed is None:
        speed = next((s for s in _SPEEDS if (until - begin) / s <= _LASTS), _SPEEDS[-1])
    count = ceil((until - begin) * rate / speed - 1e-9) + 1
    return FrameTiming(np.minimum(begin + np.arange(count) * speed / rate, until), rate, float(speed))


def write_animation(
    run: Run,
    path: str | Path,
    seed: int | None = None,
    *,
    start: float | None = None,
    end: float | None = None,
    fps: float | None = None,
    speed: float | None = None,
    dpi: float = ANIMATION_DPI,
    stale: float | None = None,
    progress: Callable[[int], Callable[[], None]] | None = None,
) -> Written:
    """Write one seed of a run as a .mp4 or .gif, whole or not at all.

    Args:
        run: The run.
        path: The file, whose name ends in .mp4 or .gif.
        seed: The seed that is shown, by default the first.
        start: The time [s] at which the picture begins, by default that of the run.
        end: The time [s] at which it ends, by default that of the run.
        fps: Frames a second, see :func:`frame_times`.
        speed: Times real time, see :func:`frame_times`.
        dpi: Pixels per inch, 20 to 600.
        stale: The age [s] from which a message is stale, see :func:`robotics.show.playback.replay.replay`.
        progress: Called with the number of frames; what it returns is called after each frame.

    Raises AnimationError, ReplayError, OSError.
    """
    suffix = check_animation(path)
    if suffix == "html":
        raise AnimationError(
            f"{path}: this writes .mp4 and .gif; robotics.show.playback.player.write_player writes .html"
        )
    if not 20 <= dpi <= 600:
        raise AnimationError(f"dpi must be >= 20 and <= 600, got {dpi:g}")
    timing = frame_times(run, suffix, start=start, end=end, fps=fps, speed=speed)
    frames = len(timing.times)
    with style():
        scene = set_scene(replay(run, _samples(run, timing), seed, stale), timing.speed, dpi)
        width, height = scene.figure.get_size_inches() * dpi
        if suffix == "gif" and frames * width * height > _MOST_PIXELS:
            raise AnimationError(
                f"{frames} frames of {width:.0f} × {height:.0f} pixels are too many for a .gif: raise speed, lower fps "
                "or dpi, shorten the span, or write a .mp4"
            )
        advance = progress(frames) if progress is not None else None
        with (
            film_writer(path, suffix, timing.fps, scene.film.title, scene.figure, dpi) as writer,
        ):
            for time in timing.times:
                show_frame(scene, float(time))
                writer.grab_frame()
                if advance is not None:
                    advance()
    return Written(frames, timing.fps, timing.speed, frames / timing.fps, scene.enlarged)


def still(
    run: Run,
    seed: int | None = None,
    *,
    start: float | None = None,
    end: float | None = None,
    stale: float | None = None,
    dpi: float = 80.0,
) -> bytes:
    """The last frame of such a picture as the bytes of a .png file; the arguments are :func:`write_animation`'s.

    Raises AnimationError, ReplayError.
    """
    timing = frame_times(run, "gif", start=start, end=end, speed=1.0)
    picture = BytesIO()
    with style():
        scene = set_scene(replay(run, _samples(run, timing), seed, stale), timing.speed, dpi)
        show_frame(scene, float(timing.times[-1]))
        scene.figure.savefig(picture, format="png", dpi=dpi)
    return picture.getvalue()


def _samples(run: Run, timing: FrameTiming) -> np.ndarray:
    """The times of the run's own samples from the first to the last frame, at most some thousands."""
    begin, until = timing.times[0], timing.times[-1]
    inside = run.time[(run.time > begin) & (run.time < until)]
    return np.concatenate([[begin], inside[:: max(1, len(inside) // _MOST_SAMPLES)], [until]])


@contextmanager
def film_writer(path: str | Path, suffix: str, fps: float, title: str, figure: Any, dpi: float) -> Iterator[Any]:
    """What writes frames of ``figure`` as a film to ``path``, whole or not at all. Raises AnimationError, OSError."""
    with (
        replacing(path) as temporary,
        _writer(suffix, fps, title) as writer,
        writer.saving(figure, str(temporary), dpi),
    ):
        yield writer


@contextmanager
def _writer(suffix: str, fps: Any, title: str) -> Iterator[Any]:
    """Matplotlib's writer for that format; what ffmpeg says when it fails becomes one message."""
    import matplotlib as mpl
    from matplotlib.animation import FFMpegWriter, PillowWriter
    from PIL import Image

    palette = Image.new("P", (1, 1))
    palette.putpalette(_palette().tobytes())

    class SmallGif(PillowWriter):
        """A writer of frames with one palette and a byte a pixel, which saves memory and keeps still parts equal."""

        def grab_frame(self, **options: Any) -> None:
            super().grab_frame(**options)
            frames: list[Image.Image] = self._frames  # type: ignore[attr-defined]
            frames[-1] = frames[-1].quantize(palette=palette, dither=Image.Dither.NONE)

    if suffix == "gif":
        yield SmallGif(fps=fps - 1e-6)  # it rounds a frame's milliseconds down
        return
    with mpl.rc_context({"animation.ffmpeg_path": ffmpeg()}):
        try:
            # bitexact: no version and no date in the file
            yield FFMpegWriter(fps=fps, codec="h264", metadata={"title": title}, extra_args=["-fflags", "+bitexact"])
        except subprocess.CalledProcessError as error:
            said = [line for line in str(error.stderr).splitlines() if line.strip()]
            raise AnimationError(f"ffmpeg could not write the .mp4: {said[-1] if said else error}") from None


def _palette() -> np.ndarray:
    """What the project's colours make with white and black at soft edges, and greys: (colours, 3) bytes."""
    from matplotlib.colors import to_rgb

    colors = np.array([to_rgb(color) for color in COLORS if to_rgb(color) != (0, 0, 0)])
    tints = 1 - np.linspace(0.06, 1, 18)[:, None, None] * (1 - colors)
    shades = np.linspace(0.1, 0.9, 7)[:, None, None] * colors
    # Pillow compares colours in cells: with closer greys white would become grey.
    greys = np.linspace(0, 1, 33)[:, None].repeat(3, axis=1)
    return np.rint(255 * np.concatenate([greys, tints.reshape(-1, 3), shades.reshape(-1, 3)])).astype(np.uint8)
