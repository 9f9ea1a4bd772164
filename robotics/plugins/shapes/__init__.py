"""Further shapes of paths: by formulas of a parameter, and tracks from tables."""
