"""
A fuzzy PID controller on a plant of one's own
==============================================

The rule table of Mac Vicar-Whelan with 5 triangles a variable controls a lag with dead time, beside a PID that
SIMC tunes.
"""

import fuzzy

plant = fuzzy.TransferFunction([1], [1, 1], 0.2)
rules = fuzzy.step_response(
    fuzzy.rule_table("pid", 5), plant, scale=fuzzy.Scale(Ku=1, Kdu=2.5), disturbance=(12.0, 0.3)
)
rival = fuzzy.step_response(fuzzy.tuned_pid(plant, 0.01), plant, disturbance=(12.0, 0.3))
figure = fuzzy.plot_step_response({"fuzzy PID": rules, "PID by SIMC": rival})
