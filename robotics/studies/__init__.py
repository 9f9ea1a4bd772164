"""Runs made for a question: comparisons, sweeps, stress, recovery, learning, certificates."""
