"""Plants in files and in a text: what a command line and the designer are given.

A .toml file has the keys of :class:`fuzzy.plugins.loop.plant.TransferFunction`, or a table [[point]] with these for
each operating point, its value ``at`` and, where known, ``gains`` = [Kp, Ki, Kd]; a .py file has a function
``plant(x, u, t)``, and may have ``states``, ``output(x)``, ``initial``, ``dead_time``, ``substeps`` and ``linear``, see
TEMPLATE; with ``operating`` = [points] and ``gains`` = [[Kp, Ki, Kd], ...] the function ``plant(x, u, t, v)``.
"""

import re
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from fuzzy.errors import quoted
from fuzzy.files.pythonfile import load_python_file, told
from fuzzy.naming import check_known
from fuzzy.plugins.loop.plant import FunctionPlant, PlantError, TransferFunction
from fuzzy.plugins.loop.scheduledplant import ScheduledTransferFunction
from fuzzy.quantity import UNPRINTABLE, unprintable

TEMPLATE = Path(__file__).with_name("template.txt").read_text(encoding="utf-8")
_OPTIONAL = ("states", "initial", "dead_time", "substeps", "linear", "operating", "gains")
_KEYS = ("numerator", "denominator", "dead_time")

Plant = TransferFunction | ScheduledTransferFunction | FunctionPlant


class Example(NamedTuple):
    """A plant to begin with, and settings of a normalised rule base that control it."""

    title: str
    plant: TransferFunction
    duration: float  # s
    scale: tuple[float, float, float, float, float]  # Ke, Kde, Kie, Ku, Kdu
    limits: tuple[float, float]
    disturbance: tuple[float, float]  # s, size
    points: str = ""  # transfer functions at operating points, of which ``plant`` is one

    @property
    def whole(self) -> TransferFunction | ScheduledTransferFunction:
        """The plant with all of its operating points."""
        return plant_of_text(self.points) if self.points else self.plant


def _examples() -> dict[str, Example]:
    tables = tomllib.loads(Path(__file__).with_name("examples.toml").read_text(encoding="utf-8"))
    return {name: Example(**table | {"plant": TransferFunction(**table["plant"])}) for name, table in tables.items()}


PLANT_EXAMPLES = _examples()


def plant_of_text(text: str) -> TransferFunction | ScheduledTransferFunction:
    """The transfer function in "numerator; denominator; dead time", coefficients with blanks or commas between.

    Those of operating points stand one after the other, "value: numerator; denominator; dead time; Kp Ki Kd | ...",
    dead time and gains may be left out.

    >>> plant_of_text("1; 1 0.4 1; 0.2").dead_time
    0.2
    >>> plant_of_text("1: 2; 3 1; 0.8 | 2: 4; 3 1; 0.8").at(1.5).numerator
    (1.0,)

    Raises PlantError.
    """
    if ":" in text:
        return _of_points([_point_of_text(part) for part in text.replace("\n", "|").split("|") if part.strip()])
    return _transfer_of_text(text)


def _point_of_text(text: str) -> dict[str, Any]:
    value, _, rest = text.partition(":")
    gains = rest.split(";")[3:]
    return {
        "at": numbers_of(value, "operating")[0],
        "plant": _transfer_of_text(";".join(rest.split(";")[:3])),
        "gains": numbers_of(" ".join(gains), "gains") if gains else [],
    }


def _of_points(points: list[dict[str, Any]]) -> ScheduledTransferFunction:
    columns = ([point[name] for point in points] for name in ("at", "plant", "gains"))
    return ScheduledTransferFunction(*columns)


def _transfer_of_text(text: str) -> TransferFunction:
    parts = text.split(";")
    if len(parts) not in (2, 3):
        raise PlantError(
            "a transfer function is written 'numerator; denominator; dead time', coefficients with the highest power "
            f"first and the dead time optional, such as '1; 1 0.4 1; 0.2'; got {quoted(text)}"
        )
    rows = [numbers_of(part, name) for part, name in zip(parts, _KEYS, strict=False)]
    if len(rows) == 3 and len(rows[2]) != 1:
        raise PlantError(f"the dead time must be one number of seconds, got {quoted(parts[2])}").about("dead_time")
    return TransferFunction(rows[0], rows[1], rows[2][0] if len(rows) == 3 else 0.0)


def numbers_of(text: str, name: str) -> list[float]:
    """The numbers in a text, with blanks or commas between, brackets around or not. Raises PlantError."""
    words = re.split(r"[\s,]+", text.strip().strip("[]").strip())
    try:
        return [float(word) for word in words]
    except ValueError:
        raise PlantError(
            f"{name} must be numbers with blanks between, such as '1 0.4 1', got {quoted(text.strip())}"
        ).about(name) from None


def read_plant(path: Path, name: str = "", answered: Callable[[], None] = lambda: None) -> Plant:
    """The plant in a .toml or .py file; a Python file is run.

    Args:
        path: The file.
        name: What messages call it; by default its path.
        answered: Called after each answer of a Python file.

    Raises PlantError with the file, and the line of a Python file.
    """
    name = name or str(path)
    if path.suffix.casefold() == ".py":
        return _of_module(load_python_file(path, PlantError), path, name, answered)
    if path.suffix.casefold() != ".toml":
        raise PlantError(f"{name}: a plant is a .toml or a .py file")
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:  # or a number or a nesting that does not end
        raise PlantError(f"{name}: cannot be read: {getattr(error, 'strerror', None) or error}") from None
    for keys in unprintable(table):
        raise PlantError(f"{name}: cannot be read: {keys[0]}: {UNPRINTABLE}")
    try:
        if "point" not in table:
            return _of_table(table, _KEYS[:2])
        check_known(next((key for key in table if key != "point"), "point"), ("point",), "key", PlantError)
        if not isinstance(table["point"], list) or not all(isinstance(each, dict) for each in table["point"]):
            raise PlantError("operating points are tables [[point]]")
        points = [
            {"at": each.pop("at", None), "gains": each.pop("gains", []), "plant": _of_table(each, _KEYS[:2])}
            for each in table["point"]
        ]
        return _of_points(points)
    except PlantError as error:
        raise PlantError(f"{name}: {error}") from None


def _of_table(table: dict[str, Any], needed: tuple[str, ...]) -> TransferFunction:
    for key in table:
        check_known(key, _KEYS, "key", PlantError)
    missing = [key for key in needed if key not in table]
    if missing:
        raise PlantError(f"the {missing[0]} is missing")
    return TransferFunction(**table)


def _of_module(module: Any, path: Path, name: str, answered: Callable[[], None]) -> FunctionPlant:
    function, output = getattr(module, "plant", None), getattr(module, "output", None)
    if not callable(function):
        raise PlantError(f"{name}: there is no function plant(x, u, t), which gives the derivatives of the states")
    if output is not None and not callable(output):
        raise PlantError(f"{name}: output must be a function of the states")
    about = {key: getattr(module, key) for key in _OPTIONAL if hasattr(module, key)}
    place = path.resolve()

    def guarded(run: Any) -> Any:
        def ran(*args: Any) -> Any:
            try:
                return run(*args)
            except (Exception, SystemExit) as error:  # a file of the user's may raise anything
                raise PlantError(told(error, place, name)) from error
            finally:
                answered()

        return ran

    return FunctionPlant(guarded(function), output=output and guarded(output), name=name, **about)
