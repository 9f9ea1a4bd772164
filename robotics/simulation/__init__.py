"""The one simulation, and the runs that it makes."""
