"""Thousands of random scenarios, and what went wrong in which."""
