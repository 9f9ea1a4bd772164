"""The command line ``anfis``."""
