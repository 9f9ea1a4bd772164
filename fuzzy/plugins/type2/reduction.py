"""What of type reductions needs no NumPy, which commands do without until they run: names, the least strength."""

from typing import Literal

LEAST_STRENGTH = 1e-300  # of a firing strength: a weaker one is 0, for a product with it has too few digits

Reduction = Literal["karnikmendel", "ekm", "iasc", "eiasc", "nietan"]
