"""The parts of the command line ``robotics``, thin over the public functions."""
