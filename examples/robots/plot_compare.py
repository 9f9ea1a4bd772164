"""
A comparison with intervals
===========================

Four laws on two scenarios, ten seeds each: means and 95 % intervals.
"""

import robotics

scenarios = [robotics.load_scenario(name) for name in ("fuzzy-off-path", "lyapunov-circle")]
comparison = robotics.compare(scenarios, ["fuzzy", "lyapunov", "csm", "esm"], seeds=range(10))
figure = robotics.plot_comparison(comparison)
