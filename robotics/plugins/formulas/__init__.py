"""Paths by formulas of a parameter."""
