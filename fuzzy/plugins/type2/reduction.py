"""The names of type reductions, for commands that import no NumPy."""

from typing import Literal

Reduction = Literal["karnikmendel", "ekm", "iasc", "eiasc", "nietan"]
