"""
Tuning in the closed loop
=========================

CMA-ES tries sixty sets of gains on two scenarios, four seeds each. Dots are their costs, the line is the best so far.
Whether the best is better is another question: it is asked on a path and on seeds that the search has not seen.
"""

import numpy as np

import fuzzy
import robotics

tuned = robotics.tune("lyapunov", ["lyapunov-sine", "fuzzy-off-path"], runs=4, evaluations=60)
print(f"cost {tuned.before:.2f} before, {tuned.after:.2f} after {tuned.evaluations} evaluations")
figure = fuzzy.plot_search(tuned.evaluated)

# %%
# On a circle, seeds 100 to 119:

unseen = robotics.load_scenario("lyapunov-circle")
for name, law in (("as published", "lyapunov"), ("tuned", tuned.law)):
    found = robotics.measure_all(robotics.simulate(unseen, law, seeds=range(100, 120)))
    print(f"{name:12} RMS cross-track error {1e3 * np.mean(found['rms_cross_track_m']):.1f} mm")
