"""A film of a run in MuJoCo by MuJoCo's own renderer, without a screen: by OSMesa, or by EGL."""

import os
from collections.abc import Callable
from ctypes.util import find_library
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from fuzzy.extras import install_command
from fuzzy.figures.drawing import new_figure, style
from robotics.laws.setting import Setting
from robotics.plugins.films.animation import AnimationError, check_animation, film_writer, frame_times
from robotics.plugins.mujoco.mjcf import FILM_PIXELS
from robotics.simulation.lanes import PlantLanes
from robotics.simulation.physics import Mover, PhysicsError
from robotics.simulation.run import Run

_DPI = 100
_DOWN = -50.0  # degrees: the camera looks so far down, along y
_ROOM = 1.25  # of what the robots drive, in the picture
_PATH_POINTS, _PATH_WIDTH = 200, 0.006  # m


class MujocoFilm:
    """MuJoCo as the plant, which keeps how the world of the first run stands after every period."""

    def __init__(self, worlds: Callable[[Setting, PlantLanes], Any], name: str, target: Path) -> None:
        """``worlds`` opens worlds, ``name`` is the plant's. Raises AnimationError, PhysicsError, TargetError."""
        self.suffix = check_animation(target)
        if self.suffix == "html":
            raise AnimationError(f"{target}: MuJoCo's renderer makes .mp4 and .gif; robotics animate makes .html")
        self.make, self.name, self.target = worlds, name, target
        self.context = _context()
        self.places: list[np.ndarray] = []

    def __str__(self) -> str:
        """The plant's name."""
        return self.name

    def opened(self, setting: Setting, body: PlantLanes) -> Mover:
        """As of the plant."""
        self.worlds = self.make(setting, body)
        self.places.append(self.worlds.worlds[0].qpos.copy())
        return self.move

    def move(self, *moment: Any) -> None:
        """As of the plant."""
        self.worlds.move(*moment)
        self.places.append(self.worlds.worlds[0].qpos.copy())

    def write(self, run: Run, progress: Callable[[int], Callable[[], None]]) -> None:
        """Draw and write the film. Raises AnimationError and OSError."""
        timing, period = frame_times(run, self.suffix), float(run.time[1] - run.time[0])
        advance, (width, height) = progress(len(timing.times)), FILM_PIXELS
        with style():
            figure = new_figure(width / _DPI, height / _DPI, constrained=False)
            ax = figure.add_axes((0.0, 0.0, 1.0, 1.0))
            ax.set_axis_off()
            picture = ax.imshow(np.zeros((height, width, 3), dtype=np.uint8), aspect="auto", interpolation="none")
            look: dict[str, Any] = {"fontsize": 9, "va": "top", "parse_math": False, "transform": ax.transAxes}
            ax.text(0.02, 0.97, f"{run.controller} on {run.scenario}, {timing.speed:g} times real time", **look)
            clock = ax.text(0.98, 0.97, "", **look | {"ha": "right", "fontfamily": "monospace"})
            with film_writer(self.target, self.suffix, timing.fps, run.scenario, figure, _DPI) as writer:
                shot = _camera_of(self.worlds, self.context, run.paths)
                for time in timing.times:
                    k = min(round(float(time) / period), len(self.places) - 1)
                    picture.set_data(shot(self.places[k]))
                    clock.set_text(f"t = {time:6.2f} s")
                    writer.grab_frame()
                    advance()


def _context() -> Any:
    """An OpenGL context without a screen, of the size of the picture. Raises PhysicsError."""
    libraries = {"osmesa": "OSMesa", "egl": "EGL"}
    named = os.environ.get("MUJOCO_GL", "").lower()
    found = [named] if named in libraries else [name for name, library in libraries.items() if find_library(library)]
    why = "neither OSMesa nor EGL is on this machine"
    if found:
        try:
            context = import_module(f"mujoco.{found[0]}").GLContext(*FILM_PIXELS)
            context.make_current()
            return context
        except (ImportError, AttributeError, RuntimeError, OSError, TypeError) as error:
            why = f"{found[0]}: {error}"
    raise PhysicsError(
        f"a film by MuJoCo's renderer is drawn by OpenGL without a screen, and there is none ({why}): on Debian and "
        f"Ubuntu `apt install libosmesa6`, and {install_command('mujoco')} for PyOpenGL; robotics animate needs neither"
    )


def _camera_of(worlds: Any, context: Any, paths: tuple[np.ndarray, ...]) -> Callable[[np.ndarray], np.ndarray]:
    """What draws a world that stands at given coordinates, with the paths: pixels (height, width, 3)."""
    mj, model, (width, height) = worlds.module, worlds.model, FILM_PIXELS
    data, scene, camera, option = mj.MjData(model), mj.MjvScene(model, 10_000), mj.MjvCamera(), mj.MjvOption()
    context.make_current()
    drawing, rectangle = mj.MjrContext(model, mj.mjtFontScale.mjFONTSCALE_100.value), mj.MjrRect(0, 0, width, height)
    mj.mjr_setBuffer(mj.mjtFramebuffer.mjFB_OFFSCREEN.value, drawing)
    low, high = (getattr(np.concatenate(paths, axis=1), name)(axis=1) for name in ("min", "max"))
    across, along = _ROOM * np.maximum(high - low, 0.6)
    camera.lookat[:] = [*(low + high) / 2, 0.0]
    seen = 2 * np.tan(np.radians(model.vis.global_.fovy) / 2)  # of the height, at a distance of 1
    camera.distance, camera.elevation, camera.azimuth = max(across * height / width, along) / seen, _DOWN, 90.0

    def shot(place: np.ndarray) -> np.ndarray:
        data.qpos[:] = place
        mj.mj_forward(model, data)
        mj.mjv_updateScene(model, data, option, None, camera, mj.mjtCatBit.mjCAT_ALL.value, scene)
        for nodes in paths:
            points = nodes[:, :: max(1, nodes.shape[1] // _PATH_POINTS)]
            for begin, end in zip(points.T[:-1], points.T[1:], strict=True):
                line, scene.ngeom = scene.geoms[scene.ngeom], scene.ngeom + 1
                none = np.zeros(3), np.zeros(3), np.zeros(9)
                mj.mjv_initGeom(line, mj.mjtGeom.mjGEOM_CAPSULE, *none, np.array([0.2, 0.2, 0.2, 1.0], np.float32))
                ends = np.array([*begin, _PATH_WIDTH]), np.array([*end, _PATH_WIDTH])
                mj.mjv_connector(line, mj.mjtGeom.mjGEOM_CAPSULE, _PATH_WIDTH, *ends)
        mj.mjr_render(rectangle, scene, drawing)
        pixels = np.empty((height, width, 3), dtype=np.uint8)
        mj.mjr_readPixels(pixels, None, rectangle, drawing)
        return pixels[::-1]

    return shot
