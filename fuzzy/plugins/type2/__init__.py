"""Interval type-2 Sugeno systems: how they answer, their files, and how they are drawn."""
