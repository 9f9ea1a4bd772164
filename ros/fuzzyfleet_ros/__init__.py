"""Fuzzyfleet on ROS 2: a node that drives a robot by any law, and the simulator as a loopback with wheel dynamics.

Without rclpy: frames, alongpath, onboard (one robot driven by a law), loopback (the simulator, driven from outside),
standing (the watchdog) and names. With it: messages, parameters, transforms, controllersettings, controllernode,
simulatornode and running. Commands: controller, simulator, fleet.
"""
