"""Fuzzyfleet on ROS 2: a node that drives a robot by any law, and the simulator as a loopback with wheel dynamics.

Without rclpy: frames (postures and quaternions), alongpath (a setting from way-points), onboard (one robot driven by a
law), loopback (the simulator, driven from outside). With it: messages, parameters, running, controller and simulator.
"""
