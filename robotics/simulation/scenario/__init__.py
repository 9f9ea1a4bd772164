"""Scenarios: their description, and how they are read from files."""
