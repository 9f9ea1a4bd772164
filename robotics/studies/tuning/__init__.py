"""Tuning laws through the closed loop: what may move, what it costs, and the search."""
