"""The random streams of a seed, beside that of the start and the posture noise: one does not shift another."""

# Random streams of a seed beside that of the start and the posture noise, so that one does not shift another
RADIO_STREAM, RELATIVE_STREAM, WHEEL_STREAM, FAULT_STREAM = 1, 2, 3, 4
