"""What robots know and the laws of rule bases, on arrays (runs, robots): the oracle of their equations."""
