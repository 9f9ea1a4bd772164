"""The world that is simulated: robots, paths, obstacles, sensors and the radio between robots."""
