"""Quantities of fields, as :mod:`fuzzy.quantity` describes them: the name by which laws of one's own import them."""

from fuzzy.quantity import LARGEST, SMALLEST, accepted, check_quantities, described, got, is_number, quantity, whole  # noqa: F401
