"""All keys of a scenario's file as data, made from the dataclasses that it is read into.

What :mod:`robotics.simulation.scenario.reading` reads by functions of its own and not by the types of fields stands
here: paths and obstacles by their shape, presets, the virtual robot and offsets from it. A test holds both together.
"""

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from math import pi
from typing import Any

from robotics.simulation.scenario.description import Member, Scenario, VirtualRobot
from robotics.simulation.scenario.robots import RobotModel
from robotics.tables.keys import Key, KeyTable, Specials, first_line, keys_of, shapes_table, table_of
from robotics.world.environment.world import OBSTACLES, Obstacle
from robotics.world.paths.offset import Offset
from robotics.world.paths.path import SHAPES, Shape
from robotics.world.paths.trajectory import Timing
from robotics.world.radio.description import RADIO_PRESETS, Radio
from robotics.world.sensing.sonar import SENSOR_PRESETS, RangeSensor
from robotics.world.vehicle.robot import ALTERNATIVES, NEEDED, Robot

_NAME = "the name of a robot or the path of its file in quotes"


@cache
def scenario_table() -> KeyTable:
    """The description of a scenario's file."""
    robot = robot_table()
    robots = KeyTable(
        name="robots",
        doc="One robot: its start, path, timing, parameters and sensors.",
        keys=keys_of(Member, _SPECIALS, also=_member_keys(robot)),
        one_of=(("path", "offset"), ("timing", "offset")),
    )
    virtual = table_of(VirtualRobot, "virtual", _SPECIALS)
    also = (
        Key(
            name="robots", doc="The robots, in the order of their numbers.", holds="tables", table=robots, required=True
        ),
        Key(name="robot", doc="Which robot all are; left out: the EtsRo.", holds="table", table=robot, or_text=_NAME),
        Key(name="virtual", doc="The virtual robot of a formation by offsets.", holds="table", table=virtual),
    )
    by_name = {key.name: key for key in keys_of(Scenario, _SPECIALS, also=also)}
    first = ("title", "source", "kind", "controller", "duration", "period", "latency", "plant", "divergence")
    last = ("sensing", "sensors", "radio", "robot", "robots", "virtual", "obstacles", "faults")
    between = [name for name in by_name if name not in (*first, *last)]
    keys = tuple(by_name[name] for name in (*first, *between, *last))
    return KeyTable(name="scenario", doc="A scenario: its robots, their sensing and radio, and obstacles.", keys=keys)


@cache
def robot_table() -> KeyTable:
    """The description of the table [robot] of a scenario."""
    model = Key(
        name="model",
        doc="The robot of which the other keys change numbers; without it they are those of a whole robot.",
        holds="text",
        example="turtlebot3-burger",
    )
    return table_of(Robot, "robot", _SPECIALS, also=(model,))


@cache
def robot_file_table() -> KeyTable:
    """The description of a robot's file."""
    keys = keys_of(RobotModel, _SPECIALS, without=("robot", "sensors"))
    numbers = [replace(key, required=key.name in NEEDED) for key in keys_of(Robot, _SPECIALS)]
    sensors = Key(name="sensors", doc="The range sensors that it carries.", holds="tables", table=_sensors())
    return KeyTable(
        name="robot",
        doc="A robot: its body, wheels, motors, encoders, limits and range sensors.",
        keys=(*keys, *numbers, sensors),
        one_of=tuple(ALTERNATIVES.items()),
    )


def _member_keys(robot: KeyTable) -> tuple[Key, ...]:
    """The keys of a robot that the fields of Member do not tell."""
    known = {key.name: key for of in (Offset, Member) for key in keys_of(of, _SPECIALS, without=("robot",))}
    doc = "Which robot this one is, instead of the one of all."
    return (
        *(replace(known[name], required=False) for name in ("start", "path", "timing", "offset")),
        Key(name="robot", doc=doc, holds="table", table=robot, or_text=_NAME),
    )


@cache
def _path() -> KeyTable:
    return shapes_table("path", "A path by its shape.", "The shape of the path.", SHAPES)


@cache
def _obstacles() -> KeyTable:
    doc = "An obstacle: its shape and place; with a path and a timing it moves."
    return shapes_table("obstacles", doc, "The shape of the obstacle.", OBSTACLES, keys_of(Obstacle, _SPECIALS))


@cache
def _timing() -> KeyTable:
    return KeyTable(
        name="timing", doc=first_line(Timing), keys=keys_of(Timing), one_of=(("speed", "duration", "x_rate"),)
    )


@cache
def _radio() -> KeyTable:
    preset = Key(
        name="preset",
        doc="A known radio, of which other keys may change a part.",
        holds="word",
        words=tuple(RADIO_PRESETS),
    )
    return table_of(Radio, "radio", also=(preset,))


@cache
def _sensors() -> KeyTable:
    name = Key(name="name", doc="The sensor's name, by which a law asks for it.", holds="text", example="rear")
    preset = Key(
        name="preset",
        doc="Known sensors, of all of which other keys may change a part, instead of a name.",
        holds="word",
        words=tuple(SENSOR_PRESETS),
    )
    prefix = Key(name="prefix", doc="What begins the names of a preset's sensors.", holds="text", example="rear-")
    beams = Key(
        name="beams",
        doc="The number of beams of the preset lidar.",
        holds="whole number",
        least=2,
        most=1e4,
        example=121,
    )
    span = Key(
        name="span",
        doc="The angle from the first to the last beam of the preset lidar.",
        holds="number",
        unit="rad",
        least=-2 * pi,
        most=2 * pi,
        example=4.18879,
    )
    keys = keys_of(RangeSensor, also=(name, preset, prefix, beams, span))
    return KeyTable(name="sensors", doc=first_line(RangeSensor), keys=keys, one_of=(("name", "preset"),))


def _special(table: Any, holds: Any = "table") -> Any:
    return lambda name: Key(name=name, doc="", holds=holds, table=table())


_SPECIALS: Specials = {
    Shape: _special(_path),
    Timing: _special(_timing),
    Radio: _special(_radio),
    tuple[Obstacle, ...]: _special(_obstacles, "tables"),
    Mapping[str, RangeSensor]: _special(_sensors, "tables"),
}
