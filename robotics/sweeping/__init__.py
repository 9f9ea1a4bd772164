"""Sweeps: many scenarios on many workers, that survive being killed."""
