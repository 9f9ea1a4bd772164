"""
A fuzzy PID controller on a plant of one's own
==============================================

The rule table of Mac Vicar-Whelan with 5 triangles a variable controls a lag with dead time, beside a PID that
SIMC tunes. After ten seconds a step at the plant's input disturbs both. The rules' scale factors were tried out until
they do as well as the PID: a linear plant asks for no more.
"""

import fuzzy

plant = fuzzy.TransferFunction([1], [1, 1], 0.2)  # 1/(s + 1) after 0.2 s
loop = {"duration": 20, "sample_time": 0.02, "disturbance": (10.0, 0.3)}
scale = fuzzy.Scale(Ke=1, Kde=0.1, Ku=2.5, Kdu=3)
responses = {
    "fuzzy PID": fuzzy.step_response(fuzzy.rule_table("pid", 5), plant, scale=scale, **loop),
    "PID by SIMC": fuzzy.step_response(fuzzy.tuned_pid(plant, 0.02), plant, **loop),
}
figure = fuzzy.plot_step_response(responses)
for name, response in responses.items():
    found = response.figures
    print(
        f"{name:11} overshoot {found.overshoot:4.1f} %, settling time {found.settling_time:.1f} s, "
        f"IAE {found.iae:.2f}, recovered in {found.recovery_time:.1f} s"
    )
