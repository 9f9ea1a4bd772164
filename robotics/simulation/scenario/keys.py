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
from robotics.world.paths.path import Shape, shapes
from robotics.world.paths.trajectory import Timing
from robotics.world.radio.description import RADIO_PRESETS, Radio
from robotics.world.sensing.sonar import SENSOR_PRESETS, RangeSensor
from robotics.world.vehicle.floor import Patch
from robotics.world.vehicle.robot import ALTERNATIVES, NEEDED, Robot

_NAME = "the name of a robot or the path of its file in quotes"


@cache
def scenario_table() -> KeyTable:
    """The description of a scenario's file."""
    robot = robot_table()
    doc, members = "One robot: its start, path, timing, parameters and sensors.", _member_keys(robot)
    robots = KeyTable("robots", doc, members, one_of=(("path", "offset", "goal"), ("timing", "offset", "goal")))
    virtual = table_of(VirtualRobot, "virtual", _SPECIALS)
    also = (
        Key("robots", "The robots, in the order of their numbers.", "tables", table=robots, required=True),
        Key("robot", "The robot that all are; left out: the EtsRo.", "table", table=robot, or_text=_NAME),
        Key("virtual", "The virtual robot of a formation by offsets.", "table", table=virtual),
    )
    by_name = {key.name: key for key in keys_of(Scenario, _SPECIALS, also=also)}
    first = ("title", "source", "kind", "controller", "metrics", "duration", "period", "latency", "plant", "divergence")
    last = ("sensing", "sensors", "radio", "robot", "robots", "virtual", "obstacles", "patches", "faults")
    between = [name for name in by_name if name not in (*first, *last)]
    keys = tuple(by_name[name] for name in (*first, *between, *last))
    return KeyTable("scenario", "A scenario: its robots, their sensing and radio, and obstacles.", keys)


@cache
def robot_table() -> KeyTable:
    """The description of the table [robot] of a scenario."""
    doc = "The robot of which the other keys change numbers; without it they are those of a whole robot."
    return table_of(Robot, "robot", _SPECIALS, also=(Key("model", doc, "text", example="turtlebot3-burger"),))


@cache
def robot_file_table() -> KeyTable:
    """The description of a robot's file."""
    keys = keys_of(RobotModel, _SPECIALS, without=("robot", "sensors"))
    numbers = [replace(key, required=key.name in NEEDED) for key in keys_of(Robot, _SPECIALS)]
    sensors = Key("sensors", "The range sensors that it carries.", "tables", table=_sensors())
    doc = "A robot: its body, wheels, motors, encoders, limits and range sensors."
    return KeyTable("robot", doc, (*keys, *numbers, sensors), one_of=tuple(ALTERNATIVES.items()))


def _member_keys(robot: KeyTable) -> tuple[Key, ...]:
    """The keys of a robot of a scenario; where its path and its timing stand follows from ``one_of``."""
    known = {key.name: key for of in (Offset, Member) for key in keys_of(of, _SPECIALS, without=("robot",))}
    doc = "Which robot this one is, instead of the one of all."
    also = (
        *(replace(known[name], required=False) for name in ("start", "path", "timing", "offset", "goal")),
        Key("robot", doc, "table", table=robot, or_text=_NAME),
    )
    return keys_of(Member, _SPECIALS, also=also)


@cache
def _path() -> KeyTable:
    return shapes_table("path", "A path by its shape.", "The shape of the path.", shapes())


@cache
def _obstacles() -> KeyTable:
    doc = "An obstacle: its shape and place; with a path and a timing it moves."
    return shapes_table("obstacles", doc, "The shape of the obstacle.", OBSTACLES, keys_of(Obstacle, _SPECIALS))


@cache
def _patches() -> KeyTable:
    form = ("center", "corners"), ("radius", "corners")
    return KeyTable("patches", first_line(Patch), keys_of(Patch), one_of=form)


@cache
def _timing() -> KeyTable:
    return KeyTable("timing", first_line(Timing), keys_of(Timing), one_of=(("speed", "duration", "x_rate", "rest"),))


@cache
def _radio() -> KeyTable:
    doc = "A known radio, of which other keys may change a part."
    return table_of(Radio, "radio", also=(Key("preset", doc, "word", words=tuple(RADIO_PRESETS)),))


@cache
def _sensors() -> KeyTable:
    known = "Known sensors, of all of which other keys may change a part, instead of a name."
    angle = "The angle from the first to the last beam of the preset lidar."
    turn: dict[str, Any] = {"unit": "rad", "least": -2 * pi, "most": 2 * pi}
    also = (
        Key("name", "The sensor's name, by which a law asks for it.", "text", example="rear"),
        Key("preset", known, "word", words=tuple(SENSOR_PRESETS)),
        Key("prefix", "What begins the names of a preset's sensors.", "text", example="rear-"),
        Key("beams", "The number of beams of the preset lidar.", "whole number", least=2, most=1e4, example=121),
        Key("span", angle, "number", **turn, example=4.18879),
    )
    keys = keys_of(RangeSensor, also=also)
    return KeyTable("sensors", first_line(RangeSensor), keys, one_of=(("name", "preset"),))


def _special(table: Any, holds: Any = "table") -> Any:
    return lambda name: Key(name, "", holds, table=table())


_SPECIALS: Specials = {
    Shape: _special(_path),
    Timing: _special(_timing),
    Radio: _special(_radio),
    tuple[Obstacle, ...]: _special(_obstacles, "tables"),
    tuple[Patch, ...]: _special(_patches, "tables"),
    Mapping[str, RangeSensor]: _special(_sensors, "tables"),
}
