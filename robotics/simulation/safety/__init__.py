"""Passive safety: a monitor below any law, by which a robot never drives into what its sensors could see."""
