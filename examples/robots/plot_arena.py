"""
Fuzzy or nonlinear? A small arena
=================================

Three laws, tuned with the same small budget on some random scenarios and tested on others. The default arena
does this with more laws, more runs and two engines; what this one says is only about its few runs.

Hollow marks are costs of laws as published, filled ones those of tuned laws, both as multiples of the tuned
Lyapunov law's, with 95 % intervals. Beside it stands what the cost does not count.
"""

from dataclasses import replace
from tempfile import TemporaryDirectory

import robotics

small = replace(
    robotics.load_arena("demo"),
    laws=("fuzzy", "lyapunov", "esm"),
    reference="lyapunov",
    evaluations=20,
    choosing_runs=2,
    testing_runs=6,
    robustness_runs=2,
)
with TemporaryDirectory() as folder:
    outcome = robotics.run_arena(small, folder)
figure = robotics.plot_arena(outcome)
