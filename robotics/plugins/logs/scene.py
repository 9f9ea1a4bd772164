"""What stands around in the log of a run: the frames that do not move, robots and obstacles to be drawn."""

from collections.abc import Iterator, Sequence
from typing import Any

from fuzzy.figures.palette import COLORS, ROLES
from robotics.plugins.logs.messages import Composer
from robotics.plugins.logs.names import MAP, Names, token
from robotics.simulation.run import Run

HEIGHT, LINE = 0.12, 0.02  # m: of bodies, of lines
# Types of visualization_msgs/Marker
_CUBE = 1
_CYLINDER = 3
_LINES = 5


def mount(names: Names, sensor: str) -> str:
    """The frame of a range sensor."""
    return names.frame(f"range_{token(sensor)}")


def mounts(run: Run, robots: Sequence[Names], make: Composer) -> Iterator[Any]:
    """Where the frames stand that do not move: all robots count from the same place, and carry their sensors."""
    for names, carried in zip(robots, run.about.sensors, strict=True):
        yield make.transform(make.header(0.0, MAP), names.frame("odom"), 0.0, 0.0, 0.0)
        for name, sensor in carried.items():
            header = make.header(0.0, names.frame("base_link"))
            yield make.transform(header, mount(names, name), sensor.x, sensor.y, sensor.axis)


def bodies(run: Run, robots: Sequence[Names], make: Composer, k: int, time: float) -> Any:
    """The bodies of robots, which go with their frames, and of obstacles as they stand at sample ``k``."""
    markers = []
    for i, (names, robot) in enumerate(zip(robots, run.about.robots, strict=True)):
        header = make.header(time, names.frame("base_link_true"))
        place, size = (0.0, 0.0, HEIGHT / 2, 0.0), (robot.length, robot.width, HEIGHT)
        markers.append(make.marker(header, "robots", i, _CUBE, place, size, COLORS[i % len(COLORS)], carried=True))
    world = run.obstacles
    if world is None:
        return make.make("visualization_msgs/MarkerArray", markers=markers)
    at, header, grey = min(k, len(world.circles) - 1), make.header(time, MAP), ROLES["quiet"].light
    for body in range(int(world.counts[min(at, len(world.counts) - 1)])):
        x, y, radius = world.circles[at, body].tolist()
        first, count = world.bodies[min(at, len(world.bodies) - 1), body, :2].tolist()
        if count == 0:
            place, size = (x, y, HEIGHT / 2, 0.0), (2 * radius, 2 * radius, HEIGHT)
            markers.append(make.marker(header, "obstacles", body, _CYLINDER, place, size, grey))
            continue
        edges = world.segments[at, first : first + count].reshape(-1, 2).tolist()
        place, size = (0.0, 0.0, HEIGHT / 2, 0.0), (LINE, LINE, LINE)
        markers.append(make.marker(header, "obstacles", body, _LINES, place, size, grey, edges))
    return make.make("visualization_msgs/MarkerArray", markers=markers)
