"""Tables to learn from: numbers, and what is in their columns."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from fuzzy.files.atomic import write_whole

COMMAND_OUTPUTS = MappingProxyType({"v": ("m/s", "commanded speed"), "w": ("rad/s", "commanded turn rate")})
TIMED_COLUMNS = ("x_err", "y_err", "heading_err", "target_v", "target_w")  # what a law that follows a timing goes by


class DataColumn(NamedTuple):
    """One column of a table."""

    name: str
    unit: str
    meaning: str
    output: bool = False
    group: int = 0  # outputs are a function of the inputs of their group, which is a robot's number


@dataclass(frozen=True, eq=False)
class DataTable:
    """A table to learn from."""

    columns: tuple[DataColumn, ...]
    values: np.ndarray  # (rows, columns), each in the unit of its column

    @property
    def names(self) -> tuple[str, ...]:
        """The names of its columns."""
        return tuple(column.name for column in self.columns)

    @property
    def inputs(self) -> tuple[str, ...]:
        """The names of its columns that are no outputs."""
        return tuple(column.name for column in self.columns if not column.output)


class Samples(NamedTuple):
    """A table of samples as it was read from a file."""

    file: str  # its name
    names: tuple[str, ...]  # of the columns
    values: np.ndarray  # (rows, columns)
    skipped: int = 0  # rows of the file that were left out, as they lack a number


def write_data(path: str | Path, names: Sequence[str], values: np.ndarray) -> None:
    """Write a table as CSV with a header, whole or not at all, each number as short as is exact.

    Args:
        path: The file.
        names: The columns' names.
        values: The numbers (rows, columns).
    """
    lines = [",".join(names)]
    lines += [",".join(repr(value).removesuffix(".0") for value in row) for row in values.tolist()]
    write_whole(path, "\n".join(lines) + "\n")
