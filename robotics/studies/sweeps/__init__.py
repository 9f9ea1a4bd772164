"""Sweeps: many variations of a scenario, in parallel, resumable."""
