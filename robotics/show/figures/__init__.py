"""Figures of runs, teams and comparisons."""
