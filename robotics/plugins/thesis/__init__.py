"""The thesis's own experiments, claims and chapters of the report."""
