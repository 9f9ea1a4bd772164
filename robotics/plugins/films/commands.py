"""The command ``robotics animate``: a saved run as a moving picture, or as a page that plays it."""

from pathlib import Path
from typing import Annotated, Any

from fuzzy.errors import InputError
from fuzzy.shell.options import Json, Quiet, option
from fuzzy.shell.progress import progress_bar
from robotics.commands.shared import OneSeed, SavedRun, print_result


def animate(
    run: SavedRun,
    out: Annotated[Path, option("The file to write: .mp4, .gif or .html (a player).", "--out", "-o", "FILE")],
    seed: OneSeed = None,
    start: Annotated[float | None, option("Time at which to begin, s.", "--from", "S")] = None,
    end: Annotated[float | None, option("Time at which to end, s.", "--to", "S")] = None,
    speed: Annotated[
        float | None, option("Speed, times real time. Default: so that it lasts 25 s at most; .html: 1")
    ] = None,
    fps: Annotated[float | None, option("Frames per second. Default: 20; .gif: 10")] = None,
    dpi: Annotated[float | None, option("Pixels per inch; the picture is 7.16 inches wide. Default: 120")] = None,
    stale: Annotated[
        float | None, option("Age from which a message counts as stale, s. Default: from the run's usual ages", "S")
    ] = None,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Show a saved run in motion: robots, paths, trails, targets, messages, faults and stops, with a time axis.

    A .mp4 needs ffmpeg, the machine's own or that of the package imageio-ffmpeg; a .gif or .html does not.

    \b
    Example:
      robotics run outage-10s --save team.npz
      robotics animate team.npz -o team.html
      robotics animate team.npz -o team.gif --speed 20
    """
    from robotics.plugins.films.animation import SLOWEST, AnimationError, check_animation, write_animation
    from robotics.simulation.run import load_run

    suffix = check_animation(out)
    for name, value in (("fps", fps), ("dpi", dpi)):
        if suffix == "html" and value is not None:
            raise InputError(f"--{name} belongs to .mp4 and .gif; a player draws as often and as finely as its screen")
    span: dict[str, Any] = {"start": start, "end": end, "stale": stale}
    result = load_run(run)
    about: dict[str, Any] = {"file": str(out), "format": suffix}
    if suffix == "html":
        from robotics.show.playback.player import write_player

        if speed is not None and not SLOWEST <= speed <= 1e4:
            raise AnimationError(f"speed must be >= {SLOWEST:g} and <= 10000, got {speed:g}")
        write_player(result, out, seed, speed=1.0 if speed is None else speed, **span)
        about["bytes"] = out.stat().st_size
        said = f"{out}: a page of {about['bytes'] / 1e6:.2f} MB; any browser opens it"
    else:
        span |= {name: value for name, value in (("fps", fps), ("speed", speed), ("dpi", dpi)) if value is not None}
        with progress_bar(quiet) as begin:
            done = write_animation(result, out, seed, **span, progress=lambda n: begin(f"drawing {out.name}", n))
        about |= done._asdict()
        size = f"robots drawn {done.enlarged:.1f} times their size" if done.enlarged > 1.05 else "robots to scale"
        said = f"{out}: {done.frames} frames, {done.seconds:.1f} s, {done.speed:g} times real time, {size}"
    print_result(json, about, said)
