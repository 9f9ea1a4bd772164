"""A metric of one's own: change what the function computes.

robotics run lyapunov-sine --metric mymetric.py:comfort
robotics compare lyapunov-sine --controllers lyapunov,csm --metric mymetric.py:comfort --seeds 5
"""

import numpy as np

import robotics


# What tables and pictures say of it. More: larger=True where more is better, kinds=("team",), of_run="max".
@robotics.metric(unit="m/s²", title="RMS acceleration", short="RMS accel.")
def comfort(run: robotics.Run) -> np.ndarray:
    """How hard the ride is: the root mean square of the true acceleration along the path.

    Returns one number for each run and robot (runs, robots). run["v"] is (runs, robots, samples), like run["x"],
    run["y"], run["heading"], run["w"], run["v_demand"]; samples after a stop or a first contact are not-a-number.
    """
    period = run.time[1] - run.time[0]  # s
    acceleration = np.diff(run["v"], axis=-1) / period
    known = np.isfinite(acceleration)
    total = np.where(known, acceleration, 0.0) ** 2
    mean: np.ndarray = total.sum(axis=-1) / np.maximum(known.sum(axis=-1), 1)
    return np.sqrt(mean)
