"""What the commands of ``anfis`` share: arguments and the error of options."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

from fuzzy.commands.completion import rule_bases
from fuzzy.errors import InputError
from fuzzy.shell.options import argument

if TYPE_CHECKING:
    import numpy as np

Data = Annotated[
    Path, argument('Samples, a row each, below a header of names "speed [m/s]" or "speed (m/s)".', "DATA.csv")
]
Fis = Annotated[
    Path, argument("A Sugeno system: a .fis file, or a packaged one's name.", "NET", autocompletion=rule_bases)
]


class TrainingData(NamedTuple):
    """The chosen columns of the tables that a training reads."""

    names: dict[str, list[str]]  # and units, as identify and search_clusters take them
    x: "np.ndarray"  # (samples, inputs)
    y: "np.ndarray"  # (samples, outputs)
    check: "tuple[np.ndarray, np.ndarray] | None"
    test: "tuple[np.ndarray, np.ndarray] | None"
    skipped: int  # rows that were left out, checking and test data included


class CommandError(InputError):
    """Options of the command line that do not go together."""
