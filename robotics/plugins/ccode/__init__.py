"""Control laws as C: the control step of one robot, for its microcontroller."""
