"""Tracking laws: fuzzy, Lyapunov, sliding modes, and leader and followers."""
