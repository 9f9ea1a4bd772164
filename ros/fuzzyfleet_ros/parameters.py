"""The parameters of a node: each declared with its type, its bounds and its sentence; wrong ones are one sentence."""

from collections.abc import Sequence
from math import inf, isfinite
from typing import Any, NamedTuple

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.node import Node

from fuzzy.errors import InputError, quoted
from fuzzy.naming import expected

_LARGEST = 1e9
_OWN = ("use_sim_time", "start_type_description_service")  # that every node of ROS has


class ParameterError(InputError):
    """A parameter that a node does not have or cannot take. The message names it and what is accepted."""


class Parameter(NamedTuple):
    """A parameter: its type is that of its default."""

    name: str
    default: bool | int | float | str
    doc: str
    least: float = -inf
    most: float = inf
    one_of: tuple[str, ...] = ()


def declared(node: Node, parameters: Sequence[Parameter]) -> dict[str, Any]:
    """Declare ``parameters`` on a node that has none yet, and return their values by name, each of its default's type.

    Raises ParameterError for one that is given and not known, or of the wrong type or size.
    """
    given = getattr(node, "_parameter_overrides", {})
    known = [parameter.name for parameter in parameters]
    for name in given:
        if name not in known and name not in _OWN and not name.startswith("qos_overrides."):
            raise ParameterError(expected(name, known, "parameter of this node"))
    values: dict[str, Any] = {}
    for parameter in parameters:
        value = given[parameter.name].value if parameter.name in given else parameter.default
        values[parameter.name] = checked = _checked(parameter, value)
        node.declare_parameter(parameter.name, checked, _descriptor(parameter), ignore_override=True)
    return values


def _checked(parameter: Parameter, value: Any) -> bool | int | float | str:
    name, default = parameter.name, parameter.default
    if isinstance(default, bool):
        if not isinstance(value, bool):
            raise ParameterError(f"{name} must be true or false, got {value!r}")
        return value
    if isinstance(default, str):
        if not isinstance(value, str):
            raise ParameterError(f"{name} must be a text, got {value!r}")
        if parameter.one_of and value not in parameter.one_of:
            raise ParameterError(f"{name} must be {' or '.join(parameter.one_of)}, got {quoted(value)}")
        return value
    whole = isinstance(default, int)
    if isinstance(value, bool) or not isinstance(value, int if whole else (int, float)):
        raise ParameterError(f"{name} must be a {'whole ' * whole}number, got {value!r}")
    least, most = max(parameter.least, -_LARGEST), min(parameter.most, _LARGEST)
    if not (isfinite(value) and least <= value <= most):
        raise ParameterError(f"{name} must be >= {least:g} and <= {most:g}, got {value!r}")
    return value if whole else float(value)


def _descriptor(parameter: Parameter) -> ParameterDescriptor:
    described = ParameterDescriptor(description=parameter.doc, read_only=True)
    if parameter.one_of:
        described.additional_constraints = f"one of: {', '.join(parameter.one_of)}"
    least, most = max(parameter.least, -_LARGEST), min(parameter.most, _LARGEST)
    if isinstance(parameter.default, float):
        described.floating_point_range = [FloatingPointRange(from_value=least, to_value=most)]
    elif isinstance(parameter.default, int) and not isinstance(parameter.default, bool):
        described.integer_range = [IntegerRange(from_value=int(least), to_value=int(most), step=1)]
    return described
