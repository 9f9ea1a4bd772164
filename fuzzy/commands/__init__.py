"""The command line ``fuzzy``."""
