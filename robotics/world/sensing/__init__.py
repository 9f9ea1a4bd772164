"""The sensors by which a robot knows where it is and what is around it."""
