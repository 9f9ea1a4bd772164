"""
A certificate of stability
==========================

The Lyapunov law, for references that drive at 0.2 to 0.4 m/s and turn at up to 1 rad/s: from everywhere inside an
ellipsoid, whose shadows are drawn in black, it converges at least as fast as the black line falls. One quadratic
function proves it. Thin lines are simulated errors under references that jump about in these ranges; they fall faster.
"""

import robotics

model = robotics.SectorModel(speed_low=0.2, speed_high=0.4, turn=3.5)
certificate = robotics.certify(model)
print(f"decay rate, proven: {certificate.decay:.3f} 1/s")
figure = robotics.plot_certificate(certificate, robotics.load_robot("etsro").robot)
