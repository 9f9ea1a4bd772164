"""The file of an identified robot: every number with where it is from, and what a scenario must say besides."""

from fuzzy.shown import shown
from robotics.plugins.identify.identified import Identified, Number
from robotics.plugins.identify.model import LIMIT_NAMES, fields_of
from robotics.plugins.identify.signals import IdentifyError
from robotics.simulation.scenario.robots import parse_robot, robot_file
from robotics.world.vehicle.robot import Robot, RobotError

_OPEN_LIMITS = ("v_rate_max", "w_rate_max")  # those that a file may leave out: there is none
_DIGITS = 5


def identified_text(found: Identified, name: str) -> str:
    """The TOML text of the robot; ``name`` is that of the data sheet's file. Raises IdentifyError."""
    base, numbers = found.model.robot, {each.name: each for each in found.numbers}
    sized = base.changed(**_sizes(base, numbers))
    fields = fields_of(sized, found.motion.values)
    of_field = {each.field: each for each in found.numbers if each.field}
    lines: list[str] = [
        f'title = "{found.model.title or found.model.name}, identified"',
        f'source = "robotics identify {found.signals.log}; mass and size: {found.model.name}"',
        "",
        "# Intervals are of 95 %. What was not identified is from the data sheet, and says so.",
        *_scenario_lines(found),
        "",
    ]
    given = {key: value for key, value in base.given.items() if key not in fields}
    for key, value in given.items():
        if key in ("wheel_radius", "half_axle", "counts_per_turn"):
            lines.append(_sized_line(key, value, sized, numbers))
        else:
            lines.append(f"{key} = {value!r}    # {found.model.name}, not identified")
    for key, value in fields.items():
        by = of_field["wheel_speed_max" if key == "back_emf" else key]
        lines.append(_field_line(key, value, by, base, found.model.name))
    text = "\n".join(lines)
    text += "\n" + _sensors(name)
    try:
        parse_robot(text, "identified")
    except RobotError as error:
        raise IdentifyError(f"{found.signals.log}: the numbers that were found make no robot: {error}") from None
    return text


def _sizes(base: Robot, numbers: dict[str, Number]) -> dict[str, float]:
    found = {}
    if "scale" in numbers:
        found["wheel_radius"] = base.wheel_radius * numbers["scale"].value
    if "axle_ratio" in numbers:
        found["half_axle"] = base.half_axle * numbers["axle_ratio"].value
    if "counts_per_turn" in numbers:
        found["counts_per_turn"] = numbers["counts_per_turn"].value
    return found


def _sized_line(key: str, value: float, sized: Robot, numbers: dict[str, Number]) -> str:
    by = numbers.get({"wheel_radius": "scale", "half_axle": "axle_ratio"}.get(key, key))
    now = getattr(sized, key)
    if by is None:
        return f"{key} = {value!r}    # from the data sheet, not identified"
    times = now / by.value
    low, high = (shown(each * times, digits=_DIGITS) for each in by.ends)
    return (
        f"{key} = {_digits(now)}    # identified: {low} to {high}; the data sheet says {shown(value, digits=_DIGITS)}"
    )


def _field_line(key: str, value: float, by: Number, base: Robot, name: str) -> str:
    sheet = getattr(base, key)
    if by.known == "above" and by.name in LIMIT_NAMES:
        seen = f"not reached: {by.title} is above {shown(by.ends.low, digits=3)} {by.unit}"
        if key in _OPEN_LIMITS:
            return f"# {key}: {seen}"
        if key in ("v_max", "w_max"):
            value = max(sheet, by.ends.low)
        return f"{key} = {_digits(value)}    # {seen}"
    if by.known == "no":
        return f"{key} = {_digits(value)}    # hardly identified: {by.title} {by.interval} {by.unit}"
    return f"{key} = {_digits(value)}    # identified: {by.title} {shown(by.value, digits=3)} {by.unit} ({by.interval})"


def _scenario_lines(found: Identified) -> list[str]:
    """What is no part of a robot, as comments: latency, wheels' gains, noise."""
    numbers = {each.name: each for each in found.numbers}
    late = numbers["latency"]
    said = [
        "# A scenario says the latency and the noise:",
        f"#   latency = {round(late.value / 0.01) * 0.01:.2f}    # s; identified: {late.interval} s",
    ]
    if "position_noise" in numbers:
        said += [
            '#   [sensing]\n#   posture = "pose"',
            *(
                f"#   {n} = {_digits(numbers[n].value)}    # {numbers[n].interval}"
                for n in ("position_noise", "heading_noise")
            ),
        ]
    for name in (
        "right_gain",
        "left_gain",
        "turn_gain",
        "wheel_ratio",
        "turn_scale",
        "v_noise",
        "w_noise",
    ):
        if name in numbers:
            one = numbers[name]
            said.append(
                f"# {one.title}: {shown(one.value, digits=_DIGITS)} {one.unit} ({one.interval}); no part of this file"
            )
    return said


def _digits(value: float) -> str:
    return repr(float(f"{value:.{_DIGITS}g}"))


def _sensors(name: str) -> str:
    """The sensors in the data sheet's file, as they stand there."""
    lines = robot_file(name).text.splitlines()
    first = next((k for k, line in enumerate(lines) if line.lstrip().startswith("[[")), len(lines))
    return "\n".join(["", *lines[first:], ""]) if first < len(lines) else ""
