"""
A certificate of stability
==========================

From everywhere inside these ellipses the Lyapunov law converges at least this fast, for all references within
the stated speeds and turn rates: one quadratic function proves it, and simulated errors must stay below its
bound.
"""

import robotics

model = robotics.SectorModel(speed_low=0.2, speed_high=0.4, turn=3.5)
certificate = robotics.certify(model)
print(f"decay rate {certificate.decay:.3f} 1/s")
figure = robotics.plot_certificate(certificate, robotics.load_robot("etsro").robot)
