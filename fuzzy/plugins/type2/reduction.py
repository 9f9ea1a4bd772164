"""The names of type reductions, apart from what needs NumPy, which commands do without until they run."""

from typing import Literal

Reduction = Literal["karnikmendel", "ekm", "iasc", "eiasc", "nietan"]
