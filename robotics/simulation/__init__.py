"""The simulation, and the runs that it makes."""
