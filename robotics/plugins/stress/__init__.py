"""Random scenarios in thousands, and what became of them."""
