"""Tracking laws of one robot: fuzzy, Lyapunov, sliding modes."""
