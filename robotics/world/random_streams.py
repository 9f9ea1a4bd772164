"""The random streams of a seed: each purpose draws from a generator of its own, so that none shifts another.

The start and the posture noise draw from the seed alone, the others from [seed, stream].
"""

RADIO_STREAM = 1  # losses and delays of messages
RELATIVE_STREAM = 2  # posture noise in proportion to the coordinates
WHEEL_STREAM = 3  # errors of the wheels' and the axle's sizes
FAULT_STREAM = 4  # when faults begin
SONAR_STREAM = 5  # noise, losses and crosstalk of range sensors
START_STREAM = 6  # where a robot starts
