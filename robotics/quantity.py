"""Quantities of fields, as :mod:`fuzzy.quantity` describes them: the name by which laws of one's own import them."""

from fuzzy.quantity import (  # noqa: F401
    LARGEST_NUMBER,
    SMALLEST,
    accepted,
    check_quantities,
    described,
    got,
    is_number,
    quantity,
    whole,
)
