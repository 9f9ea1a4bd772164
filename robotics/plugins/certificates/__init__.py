"""Stability certificates of tracking laws by linear matrix inequalities."""
