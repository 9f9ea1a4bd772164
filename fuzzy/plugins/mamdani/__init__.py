"""Mamdani systems: how they answer, and the Sugeno systems that come near them."""
