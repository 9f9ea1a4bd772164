"""A robot identified from a drive: its lag, latency, limits, friction, wheels and noise, and what to drive for it."""
