"""Fuzzy inference: Sugeno systems, membership functions, rules in English, MATLAB's files, pictures."""
