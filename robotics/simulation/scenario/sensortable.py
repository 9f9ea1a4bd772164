"""Tables [[sensors]] of scenario files and robot files: range sensors by name, or those of a preset."""

from typing import Any

from fuzzy.errors import concerning
from fuzzy.naming import expected
from robotics.tables.build import Builder, Keys
from robotics.world.sensing.sonar import SENSOR_PRESETS, RangeSensor, lidar, sonar
from robotics.world.vehicle.robot import Robot

PRESET_KEYS = ("name", "preset", "prefix", "beams", "span")  # those that are no fields of RangeSensor
SCANNER = ("beams", "span", "axis")  # of the preset "lidar", whose beams have no axis in common


def sensors_from_table(value: Any, keys: Keys, builder: Builder, robot: Robot) -> dict[str, RangeSensor]:
    """Read range sensors by name: one table for each, or one for all of a preset, whose fields it may change.

    The sonars of the preset "sonar" sit on the outline of the robot that carries them. A lidar may have another number
    of ``beams`` and another ``span`` [rad], and be turned by ``axis`` [rad]. A ``prefix`` begins the names of a
    preset's sensors, so that a robot can carry two of them.

    Args:
        value: What stands in the file.
        keys: Its place in the file.
        builder: Makes the dataclasses; its errors are raised.
        robot: The robot that carries them.
    """
    found: dict[str, RangeSensor] = {}
    for i, row in enumerate(builder.tables(value, keys)):
        made = _sensors(row, (*keys, i), builder, robot)
        for name in made:
            if name in found:
                raise builder.fault(f"there are two sensors called {name!r}").about(*keys, i)
        found |= made
    return found


def _sensors(row: dict[str, Any], at: Keys, builder: Builder, robot: Robot) -> dict[str, RangeSensor]:
    own = {key: value for key, value in row.items() if key not in ("name", "preset", "prefix")}
    if "preset" not in row:
        name = row.get("name")
        if not isinstance(name, str) or not name:
            text = f'a sensor needs a name such as "rear", or preset, one of {", ".join(SENSOR_PRESETS)}'
            raise builder.fault(text).about(*at)
        if "prefix" in row:
            raise builder.fault("prefix belongs to a preset, whose sensors' names it begins").about(*at, "prefix")
        return {name: builder.build(RangeSensor, own, at, PRESET_KEYS)}
    preset, prefix = row["preset"], row.get("prefix", "")
    if "name" in row or not isinstance(preset, str) or preset not in SENSOR_PRESETS:
        what = expected(str(preset), SENSOR_PRESETS, "sensor preset")
        raise builder.fault(what if "name" not in row else "give name or preset, not both").about(*at, "preset")
    if not isinstance(prefix, str):
        raise builder.fault(f"prefix must be text in quotes; got {prefix!r}").about(*at, "prefix")
    sensors = SENSOR_PRESETS[preset]
    if preset == "sonar":
        sensors = sonar(robot.length, robot.width)
    elif preset == "lidar":
        with concerning(*at):
            sensors = lidar(**{key: own.pop(key) for key in SCANNER if key in own})
    return {
        prefix + name: builder.build(
            RangeSensor, {k: v for k, v in vars(sensor).items() if v is not None} | own, at, PRESET_KEYS
        )
        for name, sensor in sensors.items()
    }
