"""
A comparison with intervals
===========================

Four laws on two scenarios, ten seeds each: every seed is a mark, the cross is the mean with its 95 % interval. Which
law is best depends on what is asked for. First an S-curve, from off its beginning:
"""

import robotics

scenarios = [robotics.load_scenario(name) for name in ("fuzzy-off-path", "lyapunov-circle")]
comparison = robotics.compare(scenarios, ["fuzzy", "lyapunov", "csm", "esm"], seeds=range(10))
figure = robotics.plot_comparison(comparison, "fuzzy-off-path")

# %%
# And a circle of radius 1 m, from half a metre outside it:

circle = robotics.plot_comparison(comparison, "lyapunov-circle")

# %%
# The numbers behind one panel:

summary = robotics.summarise(comparison.table)
print(summary[summary["metric"] == "rms_cross_track_under_way_m"].to_string(index=False))
