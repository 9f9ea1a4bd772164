"""Scenarios: what is simulated, described and read from files."""
