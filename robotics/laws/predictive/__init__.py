"""Predictive laws of one robot: they optimise over a horizon."""
