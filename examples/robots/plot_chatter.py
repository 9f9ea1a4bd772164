"""
What chatter costs
==================

Four sliding modes, from the conventional to the exponential one, on the thesis's reference with 3 mm and 3 mrad of
noise. All keep within two millimetres of the path; what differs is what they ask of the motors.
"""

import robotics

scenario = robotics.load_scenario("table-2-1")
laws = ["csm", "assm", "qssm", "esm"]
runs = [robotics.simulate(scenario, law, seeds=range(5), name=law) for law in laws]
figure = robotics.plot_velocities(runs, seed=0)

# %%
# In numbers, means over five seeds:

for law, run in zip(laws, runs, strict=True):
    found = robotics.measure_all(run)
    print(
        f"{law:5} RMS cross-track error {1e3 * found['rms_cross_track_m'].mean():5.1f} mm, "
        f"torque variation {found['torque_variation_nmps'].mean():6.2f} N m/s"
    )
